//! Small modules of SPIR-V, specialised.

use super::*;

const VOID: u32 = 1;
const BOOL: u32 = 2;
const FLAG: u32 = 3;
const KIND: u32 = 4;
const MAIN: u32 = 5;
const CALLED: u32 = 6;
const UNUSED: u32 = 15;
const RETURN: u32 = 253;

fn instruction(opcode: u32, operands: &[u32]) -> Vec<u32> {
    Instruction::new(opcode, operands).0
}

/// `if (FLAG) { called(); }`, where FLAG is the constant of id 7 and false unless said otherwise. The constant
/// of id 8 has no use.
fn module() -> Vec<u32> {
    let parts = [
        vec![0x0723_0203, 0x0001_0300, 0, 20, 0],
        instruction(op::ENTRY_POINT, &[5, MAIN, 0x006e_6961]),
        instruction(op::NAME, &[CALLED, 0x0066]),
        instruction(op::DECORATE, &[FLAG, SPEC_ID, 7]),
        instruction(op::DECORATE, &[UNUSED, SPEC_ID, 8]),
        instruction(19, &[VOID]),
        instruction(op::TYPE_BOOL, &[BOOL]),
        instruction(op::SPEC_CONSTANT_FALSE, &[BOOL, FLAG]),
        instruction(op::SPEC_CONSTANT_FALSE, &[BOOL, UNUSED]),
        instruction(33, &[KIND, VOID]),
        instruction(op::FUNCTION, &[VOID, MAIN, 0, KIND]),
        instruction(op::LABEL, &[10]),
        instruction(op::SELECTION_MERGE, &[12, 0]),
        instruction(op::BRANCH_CONDITIONAL, &[FLAG, 11, 12]),
        instruction(op::LABEL, &[11]),
        instruction(op::FUNCTION_CALL, &[VOID, 13, CALLED]),
        instruction(op::BRANCH, &[12]),
        instruction(op::LABEL, &[12]),
        instruction(RETURN, &[]),
        instruction(op::FUNCTION_END, &[]),
        instruction(op::FUNCTION, &[VOID, CALLED, 0, KIND]),
        instruction(op::LABEL, &[14]),
        instruction(RETURN, &[]),
        instruction(op::FUNCTION_END, &[]),
    ];
    parts.concat()
}

fn opcodes(words: &[u32]) -> Vec<u32> {
    let mut rest = &words[HEADER..];
    let mut found = Vec::new();
    while let [first, ..] = rest {
        found.push(first & 0xffff);
        rest = &rest[(first >> 16) as usize..];
    }
    found
}

fn count(words: &[u32], opcode: u32) -> usize {
    opcodes(words).into_iter().filter(|found| *found == opcode).count()
}

#[test]
fn what_a_false_constant_guards_is_gone() {
    let words = specialize(&module(), |id| (id == 7).then_some([0; 4]));
    assert_eq!(count(&words, op::FUNCTION), 1);
    for opcode in [op::FUNCTION_CALL, op::BRANCH_CONDITIONAL, op::SELECTION_MERGE, op::NAME, op::DECORATE] {
        assert_eq!(count(&words, opcode), 0, "{opcode}");
    }
    assert_eq!(count(&words, op::LABEL), 2);
}

#[test]
fn what_a_true_constant_guards_stays_without_a_branch() {
    let words = specialize(&module(), |id| (id == 7).then_some([1, 0, 0, 0]));
    assert_eq!((count(&words, op::FUNCTION), count(&words, op::FUNCTION_CALL)), (2, 1));
    assert_eq!((count(&words, op::LABEL), count(&words, op::BRANCH_CONDITIONAL)), (4, 0));
}

#[test]
fn constants_that_nobody_gives_keep_their_values() {
    assert_eq!(count(&specialize(&module(), |_| None), op::FUNCTION_CALL), 0);
}

#[test]
fn a_kernel_names_the_constants_that_it_uses() {
    assert_eq!(constants(&module()), [7]);
    assert!(constants(&specialize(&module(), |_| None)).is_empty());
}
