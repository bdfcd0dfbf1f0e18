//! GLSL with includes to SPIR-V.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use glslang::error::GlslangError;
use glslang::include::{IncludeHandler, IncludeResult, IncludeType};
use glslang::{
    Compiler, CompilerOptions, ShaderInput, ShaderMessage, ShaderSource, ShaderStage, SourceLanguage, SpirvVersion,
    Target, VulkanVersion,
};

/// Finds `#include "name.glsl"` in `shaders/include/`.
struct Includes {
    folder: PathBuf,
}

impl IncludeHandler for Includes {
    fn include(&mut self, _: IncludeType, header: &str, _: &str, _: usize) -> Option<IncludeResult> {
        let data = fs::read_to_string(self.folder.join(header)).ok()?;
        Some(IncludeResult { name: format!("shaders/include/{header}"), data })
    }
}

/// The SPIR-V of one kernel. Errors name the file and line of the GLSL.
pub fn compile(root: &Path, source: &Path, workgroup_size: u32) -> Result<Vec<u32>, Box<dyn Error>> {
    let shown = source.strip_prefix(root)?.display().to_string();
    let text = ShaderSource::from(fs::read_to_string(source)?);
    let options = CompilerOptions {
        source_language: SourceLanguage::GLSL,
        // naga cannot read whole-struct copies as SPIR-V 1.4 and later write them.
        target: Target::Vulkan { version: VulkanVersion::Vulkan1_2, spirv_version: SpirvVersion::SPIRV1_3 },
        version_profile: None,
        messages: ShaderMessage::DEFAULT,
    };
    let size = workgroup_size.to_string();
    let defines = [("WORKGROUP_SIZE", Some(size.as_str()))];
    let mut includes = Includes { folder: root.join("shaders/include") };
    let explain = |error: GlslangError| located(&error.to_string(), &shown);
    let compiler = Compiler::acquire().ok_or("the GLSL compiler does not start")?;
    let input = ShaderInput::new(&text, ShaderStage::Compute, &options, Some(&defines), Some(&mut includes))
        .map_err(explain)?;
    let shader = compiler.create_shader(input).map_err(explain)?;
    let mut program = compiler.create_program();
    program.add_shader(&shader);
    program.link().map_err(explain)?;
    Ok(shader.compile().map_err(explain)?)
}

/// glslang calls the main file `0`; people want its name.
fn located(log: &str, shown: &str) -> String {
    let named = log.replace("ERROR: 0:", &format!("ERROR: {shown}:"));
    format!("{shown}: GLSL error\n{named}")
}
