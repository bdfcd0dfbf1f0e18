//! Turns GLSL kernels into typed Rust.
//!
//! Every `.comp` file of a folder is put together with its includes ([`source`]), compiled to
//! SPIR-V once per kind of arrays and workgroup size ([`compile`]), reflected ([`reflect`]), and described in
//! `$OUT_DIR/kernels.rs` ([`generate`]): one struct per GPU struct, one per kernel whose fields are
//! its bindings, one for the scene's arrays, one per group of features. Each of these is thereby
//! written once, in GLSL; renaming a binding or a field stops Rust from compiling.
//!
//! The GLSL is plain but for the following lines, which the build script expands:
//!
//! | line | declares |
//! |---|---|
//! | `TEXELS(T, name)`, `STORED_TEXELS`, `UPDATED_TEXELS` | an array in an image or a buffer: [`texels`] |
//! | `GROUPED_TEXELS(group, T, name)` and its like | the same, in the buffer of a group |
//! | `BUFFER(T, name)`, `UPDATED_BUFFER` | an array in a storage buffer: `name.data[i]` |
//! | `VALUE(T, name)`, `UPDATED_VALUE` | one value in a storage buffer: `name.value` |
//! | `SCENE_TEXELS(part, T, name)`, `SCENE_BUFFER` | an array of the scene: scene.glsl |
//! | `FEATURES Name {` .. `};` | specialization constants: features.glsl |
//! | `export const uint NAME = 1u;` | a number that Rust knows too |
//!
//! Arrays of texels of the scene are a group. Sets, bindings and ids of constants are numbered in the order of these lines.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::{env, fs};

mod compile;
mod generate;
mod reflect;
mod source;
mod texels;

/// What to build.
pub struct Build<'a> {
    /// The folder that has `shaders/`, relative to the package that is built.
    pub root: &'a str,
    /// The folder of the kernels, relative to the root.
    pub folder: &'a str,
    /// Invocations of a workgroup: each kernel is built for each of these.
    pub workgroup_sizes: &'a [u32],
    /// What the generated Rust declares.
    pub scope: Scope,
}

/// What arrays of texels are in: each kernel is built for both.
#[derive(Clone, Copy, PartialEq, Default)]
pub enum ArrayKind {
    /// Each is in an image.
    #[default]
    Images,
    /// Each is in a storage buffer; those of a group are in one.
    Buffers,
}

/// What the generated Rust declares.
#[derive(Clone, Copy, PartialEq)]
pub enum Scope {
    /// All that the kernels need.
    Library,
    /// What the kernels' own files declare. The structs of `shaders/include/`, the features and the
    /// scene's arrays are those of `goblet::kernels`.
    Tests,
}

/// The whole of a build script.
pub fn main(build: &Build<'_>) -> ExitCode {
    match run(build) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn run(build: &Build<'_>) -> Result<()> {
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?).join(build.root);
    let out = PathBuf::from(env::var("OUT_DIR")?);
    for folder in [build.folder, "shaders/include"] {
        println!("cargo:rerun-if-changed={}", root.join(folder).display());
    }
    let mut kernels = Vec::new();
    for path in kernel_files(&root.join(build.folder))? {
        kernels.push(build_kernel(&root, &path, build, &out)?);
    }
    if build.scope == Scope::Tests {
        check_includes(&root, &root.join("shaders/include"))?;
    }
    fs::write(out.join("kernels.rs"), generate::generate(&kernels, build)?)?;
    Ok(())
}

/// What a kernel defines for `shaders/include/geometry/trace.glsl`.
const HOOK: [&str; 2] = [
    "struct Work { bool any; };\n",
    "bool next_query(inout Work work, inout Query query, Hit hit) { return false; }\n",
];

/// Compiles each include on its own: it includes what it needs.
fn check_includes(root: &Path, folder: &Path) -> Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            check_includes(root, &path)?;
        } else {
            let shown = path.strip_prefix(root)?.display().to_string();
            let mut source = source::read(root, &path, &shown, ArrayKind::Images)?;
            if path.ends_with("geometry/trace.glsl") {
                let begin = source.text.find("\nbool next_query").ok_or("trace.glsl has no next_query")?;
                source.text.insert_str(begin + 1, HOOK[0]);
                source.text += HOOK[1];
            }
            source.text += "void main() {}\n";
            compile::compile(&source, 64)?;
        }
    }
    Ok(())
}

fn kernel_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut paths: Vec<PathBuf> =
        fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path())).collect::<std::result::Result<_, _>>()?;
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "comp"));
    paths.sort();
    Ok(paths)
}

/// Compiles a kernel for each kind of arrays and each workgroup size, and reflects it.
fn build_kernel(root: &Path, path: &Path, build: &Build<'_>, out: &Path) -> Result<generate::Kernel> {
    let shown = format!("{}/{}", build.folder, path.file_name().unwrap_or_default().display());
    let name = path.file_stem().and_then(|stem| stem.to_str()).ok_or("a kernel's file name is not UTF-8")?;
    let build_for = |arrays: ArrayKind, suffix: &str| -> Result<(source::Source, reflect::Reflected)> {
        let source = source::read(root, path, &shown, arrays)?;
        let mut reflected = None;
        for size in build.workgroup_sizes {
            let spirv = compile::compile(&source, *size)?;
            let kernel = reflect::reflect(name, &spirv, &source).map_err(|error| format!("{shown}: {error}"))?;
            if kernel.workgroup_size != [*size, 1, 1] {
                return Err(format!("{shown}: include kernel/invocation.glsl").into());
            }
            fs::write(out.join(format!("{name}.{size}.{suffix}.spv")), spirv)?;
            reflected = Some(kernel);
        }
        Ok((source, reflected.ok_or("no workgroup size to build for")?))
    };
    let (source, reflected) = build_for(ArrayKind::Images, "images")?;
    let (_, in_buffers) = build_for(ArrayKind::Buffers, "buffers")?;
    Ok(generate::Kernel { reflected, bindings_in_buffers: in_buffers.bindings, source })
}
