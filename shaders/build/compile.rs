//! GLSL to SPIR-V.

use glslang::error::GlslangError;
use glslang::{
    Compiler, CompilerOptions, ShaderInput, ShaderMessage, ShaderSource, ShaderStage, SourceLanguage, SpirvVersion,
    Target, VulkanVersion,
};

use crate::Result;
use crate::source::Source;

/// The SPIR-V of a kernel. Errors name the file and line of the GLSL.
pub fn compile(source: &Source, workgroup_size: u32) -> Result<Vec<u8>> {
    let options = CompilerOptions {
        source_language: SourceLanguage::GLSL,
        // naga cannot read whole-struct copies as SPIR-V 1.4 and later write them.
        target: Target::Vulkan { version: VulkanVersion::Vulkan1_2, spirv_version: SpirvVersion::SPIRV1_3 },
        version_profile: None,
        messages: ShaderMessage::DEFAULT,
    };
    let size = workgroup_size.to_string();
    let defines = [("WORKGROUP_SIZE", Some(size.as_str()))];
    let explain = |error: GlslangError| format!("GLSL error\n{}", located(&error.to_string(), source));
    let compiler = Compiler::acquire().ok_or("the GLSL compiler does not start")?;
    let text = ShaderSource::from(source.text.as_str());
    let input = ShaderInput::new(&text, ShaderStage::Compute, &options, Some(&defines), None).map_err(explain)?;
    let shader = compiler.create_shader(input).map_err(explain)?;
    let mut program = compiler.create_program();
    program.add_shader(&shader);
    program.link().map_err(explain)?;
    let words = shader.compile().map_err(explain)?;
    Ok(words.iter().flat_map(|word| word.to_le_bytes()).collect())
}

/// The compiler's log with names of files in place of their numbers.
fn located(log: &str, source: &Source) -> String {
    let line = |line: &str| {
        let (before, rest) = line.split_once("ERROR: ")?;
        let (file, rest) = rest.split_once(':')?;
        let name = source.files.get(file.parse::<usize>().ok()?)?;
        Some(format!("{before}ERROR: {name}:{rest}"))
    };
    log.lines().map(|text| line(text).unwrap_or_else(|| text.to_owned()) + "\n").collect()
}
