//! Turns the GLSL kernels into typed Rust.
//!
//! Every `.comp` file is compiled to SPIR-V (once per workgroup size), reflected,
//! and described in `$OUT_DIR/kernels.rs`: one struct per GPU struct, one per
//! kernel. A GLSL struct is thereby written once; renaming a binding or a field
//! stops Rust from compiling.

#[path = "build/commit.rs"]
mod commit;
#[path = "build/compile.rs"]
mod compile;
#[path = "build/generate.rs"]
mod generate;
#[path = "build/reflect.rs"]
mod reflect;
#[path = "build/texels.rs"]
mod texels;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::{env, fs, process};

/// Results must not depend on the workgroup size; tests render with each of these.
/// Kernels name theirs `WORKGROUP_SIZE`.
const WORKGROUP_SIZES: [u32; 3] = [32, 64, 128];

/// Specialization constants that leave out so much code when they are false that kernels are
/// also compiled without it: what a driver need not see costs it no time. GLSL is told by
/// macros, such as `WITHOUT_HAS_REVOLUTIONS`. The first set that fits a scene is taken.
const SEPARATE: [&[&str]; 5] = [
    &["HAS_REVOLUTIONS", "HAS_TEXTURES", "IS_RICH"],
    &["HAS_TEXTURES", "IS_RICH"],
    &["HAS_REVOLUTIONS", "HAS_TEXTURES"],
    &["HAS_REVOLUTIONS"],
    &[],
];
/// Each of these sets is also built without it: shaders/include/kernel/interruption.glsl.
const RESUMABLE: &str = "IS_RESUMABLE";
/// And without both: kernels that are resumed are too rare to be built for each case.
const CONTACTS: &str = "HAS_CONTACTS";

fn main() {
    if let Err(error) = run() {
        eprintln!("{error}");
        process::exit(1);
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    let out = PathBuf::from(env::var("OUT_DIR")?);
    commit::set(&root);
    let plain = SEPARATE.iter().map(|constants| [&[RESUMABLE], *constants].concat());
    let resumable = SEPARATE.iter().map(|constants| constants.to_vec()).filter(|constants| !constants.is_empty());
    let apart = SEPARATE.iter().map(|constants| [&[RESUMABLE, CONTACTS], *constants].concat());
    let separate: Vec<Vec<&str>> = apart.chain(plain).chain(resumable).collect();
    build_kernels(&root, "shaders/passes", &separate, &out, "kernels.rs")?;
    build_kernels(&root, "tests/kernels", &[], &out, "test_kernels.rs")
}

/// Compiles every kernel of `folder` and writes `module` with their description.
fn build_kernels(
    root: &Path,
    folder: &str,
    separate: &[Vec<&str>],
    out: &Path,
    module: &str,
) -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed={folder}");
    println!("cargo:rerun-if-changed=shaders");
    let mut sources: Vec<PathBuf> =
        fs::read_dir(root.join(folder))?.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>()?;
    sources.retain(|path| path.extension().is_some_and(|extension| extension == "comp"));
    sources.sort();

    let types = fs::read_to_string(root.join("shaders/include/scene/types.glsl"))?;
    let mut kernels = Vec::new();
    for source in &sources {
        let name = source.file_stem().and_then(|stem| stem.to_str()).ok_or("a kernel's file name is not UTF-8")?;
        let shown = source.strip_prefix(root)?.display().to_string();
        let mut reflected = None;
        for size in WORKGROUP_SIZES {
            let whole = compile::compile(root, source, &types, size, &[])?;
            let mut kernel = reflect::reflect(name, &whole.bytes(), &whole.elements, &types)
                .map_err(|error| format!("{shown}: {error}"))?;
            if kernel.workgroup_size != [size, 1, 1] {
                return Err(format!("{shown}: write layout(local_size_x = WORKGROUP_SIZE) in;").into());
            }
            fs::write(out.join(format!("{name}.{size}.spv")), whole.bytes())?;
            for constants in separate {
                if !constants.iter().all(|constant| kernel.has_constant(constant)) {
                    continue;
                }
                let part = compile::compile(root, source, &types, size, constants)?;
                fs::write(out.join(format!("{name}.{size}.{}.spv", constants.join("."))), part.bytes())?;
                kernel.smaller.push(constants.iter().map(|constant| (*constant).to_owned()).collect());
            }
            reflected = Some(kernel);
        }
        kernels.extend(reflected);
    }
    fs::write(out.join(module), generate::generate(&kernels, &WORKGROUP_SIZES, &types)?)?;
    Ok(())
}
