//! GLSL with includes to SPIR-V.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use glslang::error::GlslangError;
use glslang::include::{IncludeHandler, IncludeResult, IncludeType};
use glslang::{
    Compiler, CompilerOptions, ShaderInput, ShaderMessage, ShaderSource, ShaderStage, SourceLanguage, SpirvVersion,
    Target, VulkanVersion,
};

use crate::texels;

/// A compiled kernel.
pub struct Compiled {
    words: Vec<u32>,
    /// The element type of each array in texels.
    pub elements: BTreeMap<String, String>,
}

impl Compiled {
    /// Its SPIR-V.
    pub fn bytes(&self) -> Vec<u8> {
        self.words.iter().flat_map(|word| word.to_le_bytes()).collect()
    }
}

/// Finds `#include "name.glsl"` in `shaders/include/`.
struct Includes<'a> {
    folder: PathBuf,
    types: &'a str,
    elements: &'a RefCell<BTreeMap<String, String>>,
}

impl IncludeHandler for Includes<'_> {
    fn include(&mut self, _: IncludeType, header: &str, _: &str, _: usize) -> Option<IncludeResult> {
        let text = fs::read_to_string(self.folder.join(header)).ok()?;
        // The compiler has no way to hear of an error but in the text.
        let data = texels::expand(&text, self.types, &mut self.elements.borrow_mut())
            .unwrap_or_else(|error| format!("#error {error}\n"));
        Some(IncludeResult { name: format!("shaders/include/{header}"), data })
    }
}

/// Compiles one kernel, without the code for specialization constants that are false. Errors
/// name the file and line of the GLSL.
pub fn compile(
    root: &Path,
    source: &Path,
    types: &str,
    workgroup_size: u32,
    without: &[&str],
) -> Result<Compiled, Box<dyn Error>> {
    let shown = source.strip_prefix(root)?.display().to_string();
    let elements = RefCell::new(BTreeMap::new());
    let text = texels::expand(&fs::read_to_string(source)?, types, &mut elements.borrow_mut())?;
    let text = ShaderSource::from(text);
    let options = CompilerOptions {
        source_language: SourceLanguage::GLSL,
        // naga cannot read whole-struct copies as SPIR-V 1.4 and later write them.
        target: Target::Vulkan { version: VulkanVersion::Vulkan1_2, spirv_version: SpirvVersion::SPIRV1_3 },
        version_profile: None,
        messages: ShaderMessage::DEFAULT,
    };
    let size = workgroup_size.to_string();
    let without: Vec<String> = without.iter().map(|constant| format!("WITHOUT_{constant}")).collect();
    let mut defines = vec![("WORKGROUP_SIZE", Some(size.as_str()))];
    defines.extend(without.iter().map(|name| (name.as_str(), None)));
    let mut includes = Includes { folder: root.join("shaders/include"), types, elements: &elements };
    let explain = |error: GlslangError| located(&error.to_string(), &shown);
    let compiler = Compiler::acquire().ok_or("the GLSL compiler does not start")?;
    let input = ShaderInput::new(&text, ShaderStage::Compute, &options, Some(&defines), Some(&mut includes))
        .map_err(explain)?;
    let shader = compiler.create_shader(input).map_err(explain)?;
    let mut program = compiler.create_program();
    program.add_shader(&shader);
    program.link().map_err(explain)?;
    let words = shader.compile().map_err(explain)?;
    drop(shader);
    Ok(Compiled { words, elements: elements.take() })
}

/// glslang calls the main file `0`; people want its name.
fn located(log: &str, shown: &str) -> String {
    let named = log.replace("ERROR: 0:", &format!("ERROR: {shown}:"));
    format!("{shown}: GLSL error\n{named}")
}
