//! Float controls: kernels calculate with infinities, signed zeros and NaN, which a compiler may ignore unless it is told
//! not to (`SPV_KHR_float_controls`, a part of Vulkan 1.2 that devices may leave out).

use ash::vk;

use crate::specialize::op;

/// The words of SPIR-V before the first instruction.
const HEADER: usize = 5;

const SIGNED_ZERO_INF_NAN_PRESERVE: u32 = 4461;
const SIGNED_ZERO_INF_NAN_PRESERVE_CAPABILITY: u32 = 4466;

/// Returns whether kernels of a device may ask for it, for numbers of 32 bits.
pub(crate) fn can_keep(instance: &ash::Instance, physical: vk::PhysicalDevice) -> bool {
    let mut floats = vk::PhysicalDeviceFloatControlsProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut floats);
    // SAFETY: `physical` belongs to `instance`, whose version 1.2 has this function and this structure.
    unsafe { instance.get_physical_device_properties2(physical, &mut properties) };
    floats.shader_signed_zero_inf_nan_preserve_float32 == vk::TRUE
}

/// Returns SPIR-V that asks for it in each of its entry points.
pub(crate) fn keep(words: &[u32]) -> Vec<u32> {
    let (header, body) = words.split_at(HEADER.min(words.len()));
    let mut out = header.to_vec();
    let instruction =
        |opcode: u32, operands: &[u32]| [&[(operands.len() as u32 + 1) << 16 | opcode], operands].concat();
    let mut entries = Vec::new();
    let (mut is_declared, mut is_kept) = (false, false);
    let mut rest = body;
    while let Some(&first) = rest.first() {
        let (opcode, length) = (first & 0xffff, ((first >> 16) as usize).clamp(1, rest.len()));
        // Capabilities come first, then extensions; execution modes follow the entry points.
        if opcode != op::CAPABILITY && !is_declared {
            out.extend(instruction(op::CAPABILITY, &[SIGNED_ZERO_INF_NAN_PRESERVE_CAPABILITY]));
            out.extend(instruction(op::EXTENSION, &string("SPV_KHR_float_controls")));
            is_declared = true;
        }
        if opcode == op::ENTRY_POINT {
            entries.extend(rest.get(2).copied());
        } else if !entries.is_empty() && !is_kept {
            for entry in &entries {
                out.extend(instruction(op::EXECUTION_MODE, &[*entry, SIGNED_ZERO_INF_NAN_PRESERVE, 32]));
            }
            is_kept = true;
        }
        out.extend(&rest[..length]);
        rest = &rest[length..];
    }
    out
}

/// A string as SPIR-V has it: bytes in little-endian words, with a 0 after the last.
fn string(text: &str) -> Vec<u32> {
    let mut bytes = text.as_bytes().to_vec();
    bytes.resize((bytes.len() + 1).next_multiple_of(4), 0);
    bytes.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn declarations_are_where_the_specification_wants_them() {
        let before = [
            [0x0723_0203, 0x0001_0300, 0, 9, 0].as_slice(),
            &[2 << 16 | op::CAPABILITY, 1],
            &[3 << 16 | 14, 0, 1],                              // OpMemoryModel
            &[5 << 16 | op::ENTRY_POINT, 5, 4, 0x6e69_616d, 0], // GLCompute, %4, "main"
            &[6 << 16 | op::EXECUTION_MODE, 4, 17, 64, 1, 1],   // LocalSize
            &[2 << 16 | 19, 2],                                 // OpTypeVoid
        ];
        let name = string("SPV_KHR_float_controls");
        let extension = [&[(name.len() as u32 + 1) << 16 | op::EXTENSION], name.as_slice()].concat();
        let expected = [
            before[0],
            before[1],
            &[2 << 16 | op::CAPABILITY, SIGNED_ZERO_INF_NAN_PRESERVE_CAPABILITY],
            &extension,
            before[2],
            before[3],
            &[4 << 16 | op::EXECUTION_MODE, 4, SIGNED_ZERO_INF_NAN_PRESERVE, 32],
            before[4],
            before[5],
        ];
        assert_eq!(keep(&before.concat()), expected.concat());
        assert_eq!(string("abc"), [0x0063_6261]);
        assert_eq!(string("abcd"), [0x6463_6261, 0]);
    }
}
