//! Takes out of a kernel what its specialization constants leave no use for.
//!
//! Drivers would do that too, after they have parsed, translated and inlined all of it: code that
//! they never see costs nothing. Specialization constants become constants; branches on them become
//! jumps; blocks that are never reached and functions that are never called are removed. SPIR-V
//! 1.3 as glslang writes it is understood: structured control flow, and phis only for `&&` and `||`.

use std::collections::{HashMap, HashSet};

pub mod op;

/// The decoration that gives a specialization constant its id.
const SPEC_ID: u32 = 1;
/// Words before the first instruction.
const HEADER: usize = 5;
/// The word among them that all ids are below.
const BOUND: usize = 3;

/// SPIR-V for these values of specialization constants, by their ids.
pub fn specialize(words: &[u32], value: impl Fn(u32) -> Option<[u8; 4]>) -> Vec<u32> {
    let Some((header, body)) = words.split_at_checked(HEADER) else {
        return words.to_vec();
    };
    let mut module = Module::parse(body, header[BOUND]);
    module.freeze(value);
    // Most of a kernel goes with the first turn.
    while module.fold() {
        module.remove_functions();
    }
    module.remove_functions();
    module.remove_annotations();
    let mut out = header.to_vec();
    out[BOUND] = module.bound;
    out.extend(module.words());
    out
}

/// Ids of the specialization constants that the code of SPIR-V uses, in ascending order. A kernel is compiled
/// once for all values of those that it only declares.
pub fn constants(words: &[u32]) -> Vec<u32> {
    let mut declared: Vec<Option<u32>> = vec![None; words.get(BOUND).map_or(0, |bound| *bound as usize)];
    let mut used = HashSet::new();
    let mut rest = words.get(HEADER..).unwrap_or_default();
    while let Some(&first) = rest.first() {
        let (length, opcode) = ((first >> 16) as usize, first & 0xffff);
        let operands = rest.get(1..length).unwrap_or_default();
        match (opcode, operands) {
            (op::DECORATE, [constant, SPEC_ID, id]) => declared[*constant as usize] = Some(*id),
            // Names, decorations and values are no code.
            (op::NAME | op::MEMBER_NAME | op::DECORATE | op::CONSTANT, _) => (),
            (op::SPEC_CONSTANT_TRUE | op::SPEC_CONSTANT_FALSE | op::SPEC_CONSTANT, _) => (),
            // A literal may equal the id of a constant. One constant too many is harmless.
            _ => used.extend(operands.iter().filter_map(|word| declared.get(*word as usize).copied().flatten())),
        }
        rest = rest.get(length.max(1)..).unwrap_or_default();
    }
    let mut ids: Vec<u32> = used.into_iter().collect();
    ids.sort_unstable();
    ids
}

/// An instruction.
#[derive(Clone, PartialEq)]
struct Instruction(Vec<u32>);

impl Instruction {
    fn new(opcode: u32, operands: &[u32]) -> Self {
        let length = operands.len() as u32 + 1;
        Self([&[length << 16 | opcode], operands].concat())
    }

    fn opcode(&self) -> u32 {
        self.0[0] & 0xffff
    }

    fn operands(&self) -> &[u32] {
        &self.0[1..]
    }

    /// The id that an instruction of a function makes, if it makes one.
    fn result(&self) -> Option<u32> {
        let operands = self.operands();
        match self.opcode() {
            op::LABEL => operands.first().copied(),
            op::LINE | op::STORE | op::COPY_MEMORY | op::IMAGE_WRITE | op::FUNCTION_END => None,
            op::CONTROL_BARRIER | op::MEMORY_BARRIER | op::ATOMIC_STORE => None,
            op::LOOP_MERGE | op::SELECTION_MERGE | op::BRANCH..=op::UNREACHABLE => None,
            _ => operands.get(1).copied(),
        }
    }
}

/// A run of instructions from a label to a terminator.
#[derive(Clone)]
struct Block {
    label: u32,
    /// The label and all that follows.
    code: Vec<Instruction>,
}

impl Block {
    fn terminator(&self) -> &Instruction {
        &self.code[self.code.len() - 1]
    }

    /// Labels that the block may go on to.
    fn successors(&self) -> Vec<u32> {
        let last = self.terminator();
        let operands = last.operands();
        match last.opcode() {
            op::BRANCH => vec![operands[0]],
            op::BRANCH_CONDITIONAL => operands[1..3].to_vec(),
            // The default, then pairs of a literal and a label.
            op::SWITCH => operands[1..].iter().step_by(2).copied().collect(),
            _ => Vec::new(),
        }
    }

    /// The merge block that it declares, and if it is the header of a loop, the continue target.
    fn declared(&self) -> (Option<u32>, Option<u32>) {
        let merge = self.code.len().checked_sub(2).map(|i| &self.code[i]);
        match merge.map(|merge| (merge.opcode(), merge.operands())) {
            Some((op::SELECTION_MERGE, operands)) => (Some(operands[0]), None),
            Some((op::LOOP_MERGE, operands)) => (Some(operands[0]), Some(operands[1])),
            _ => (None, None),
        }
    }
}

struct Function {
    id: u32,
    /// OpFunction and its parameters.
    head: Vec<Instruction>,
    blocks: Vec<Block>,
}

/// Values of booleans that are known.
struct Known {
    /// By ids.
    values: Vec<Option<bool>>,
    /// Number of those that are known.
    count: usize,
}

impl Known {
    fn get(&self, id: u32) -> Option<bool> {
        self.values.get(id as usize).copied().flatten()
    }

    fn insert(&mut self, id: u32, value: bool) {
        if let Some(known) = self.values.get_mut(id as usize) {
            self.count += usize::from(known.is_none());
            *known = Some(value);
        }
    }
}

struct Module {
    /// All before the first function.
    globals: Vec<Instruction>,
    functions: Vec<Function>,
    known: Known,
    /// Constants for false and true.
    constants: [u32; 2],
    /// All ids are below it.
    bound: u32,
    /// Ids that are gone.
    removed: HashSet<u32>,
}

impl Module {
    fn parse(body: &[u32], bound: u32) -> Self {
        let mut module = Self {
            globals: Vec::new(),
            functions: Vec::new(),
            known: Known { values: vec![None; bound as usize + 2], count: 0 },
            constants: [0; 2],
            bound,
            removed: HashSet::new(),
        };
        let mut rest = body;
        while let Some(&first) = rest.first() {
            let length = ((first >> 16) as usize).clamp(1, rest.len());
            let instruction = Instruction(rest[..length].to_vec());
            rest = &rest[length..];
            module.push(instruction);
        }
        module
    }

    fn push(&mut self, instruction: Instruction) {
        let opcode = instruction.opcode();
        match (opcode, self.functions.last_mut()) {
            (op::FUNCTION, _) => {
                let id = instruction.operands()[1];
                self.functions.push(Function { id, head: vec![instruction], blocks: Vec::new() });
            }
            (op::FUNCTION_END, _) => {}
            (op::LABEL, Some(function)) => {
                function.blocks.push(Block { label: instruction.operands()[0], code: vec![instruction] });
            }
            (_, Some(function)) => match function.blocks.last_mut() {
                Some(block) => block.code.push(instruction),
                None => function.head.push(instruction),
            },
            (_, None) => self.globals.push(instruction),
        }
    }

    /// Makes constants of specialization constants.
    fn freeze(&mut self, value: impl Fn(u32) -> Option<[u8; 4]>) {
        let mut ids = HashMap::new();
        self.globals.retain(|instruction| match (instruction.opcode(), instruction.operands()) {
            (op::DECORATE, [target, SPEC_ID, id]) => {
                ids.insert(*target, *id);
                false
            }
            _ => true,
        });
        for instruction in &mut self.globals {
            let (opcode, operands) = (instruction.opcode(), instruction.operands());
            let given = operands.get(1).and_then(|id| ids.get(id)).and_then(|id| value(*id)).map(u32::from_ne_bytes);
            let boolean = |is_true| if is_true { op::CONSTANT_TRUE } else { op::CONSTANT_FALSE };
            let (opcode, operands) = match opcode {
                op::SPEC_CONSTANT_TRUE => (boolean(given != Some(0)), operands.to_vec()),
                op::SPEC_CONSTANT_FALSE => (boolean(given.is_some_and(|value| value != 0)), operands.to_vec()),
                op::SPEC_CONSTANT => (op::CONSTANT, vec![operands[0], operands[1], given.unwrap_or(operands[2])]),
                _ => continue,
            };
            *instruction = Instruction::new(opcode, &operands);
        }
        self.know_constants();
    }

    /// Notes what booleans there are, and adds false and true.
    fn know_constants(&mut self) {
        let bool_type = self.globals.iter().find(|instruction| instruction.opcode() == op::TYPE_BOOL);
        let Some(bool_type) = bool_type.map(|instruction| instruction.operands()[0]) else {
            return;
        };
        for (value, opcode) in [op::CONSTANT_FALSE, op::CONSTANT_TRUE].into_iter().enumerate() {
            self.constants[value] = self.bound;
            self.globals.push(Instruction::new(opcode, &[bool_type, self.bound]));
            self.bound += 1;
        }
        for instruction in &self.globals {
            match instruction.opcode() {
                op::CONSTANT_TRUE => self.known.insert(instruction.operands()[1], true),
                op::CONSTANT_FALSE => self.known.insert(instruction.operands()[1], false),
                _ => {}
            }
        }
    }

    /// Finds values that are known by now, and removes what is not reached any more; whether
    /// anything was found.
    fn fold(&mut self) -> bool {
        let before = self.known.count;
        let returns: HashMap<u32, bool> =
            self.functions.iter().filter_map(|function| Some((function.id, function.returns(&self.known)?))).collect();
        for function in &mut self.functions {
            let variables = function.constant_variables(&self.known);
            for instruction in function.blocks.iter_mut().flat_map(|block| &mut block.code) {
                if let Some(folded) = folded(instruction, &self.known, &returns, &variables) {
                    if let Folded::Value(value) = folded {
                        self.known.insert(instruction.operands()[1], value);
                    }
                    let source = match folded {
                        Folded::Value(value) => self.constants[usize::from(value)],
                        Folded::Copy(source) => source,
                    };
                    // A call may do more than return a value, and phis come first in a block.
                    if ![op::FUNCTION_CALL, op::PHI, op::COPY_OBJECT].contains(&instruction.opcode()) {
                        let [kind, result] = [instruction.operands()[0], instruction.operands()[1]];
                        *instruction = Instruction::new(op::COPY_OBJECT, &[kind, result, source]);
                    }
                }
            }
            function.jump(&self.known, &mut self.removed);
        }
        self.known.count > before
    }

    /// Removes functions that nothing calls.
    fn remove_functions(&mut self) {
        let entry = self.globals.iter().find(|instruction| instruction.opcode() == op::ENTRY_POINT);
        let mut pending: Vec<u32> = entry.map(|entry| entry.operands()[1]).into_iter().collect();
        let mut called = HashSet::new();
        while let Some(id) = pending.pop() {
            if called.insert(id) {
                let function = self.functions.iter().find(|function| function.id == id);
                pending.extend(function.iter().flat_map(|function| function.calls()));
            }
        }
        for function in self.functions.iter().filter(|function| !called.contains(&function.id)) {
            self.removed.extend(function.head.iter().filter_map(Instruction::result));
            self.removed.extend(function.blocks.iter().flat_map(|block| &block.code).filter_map(Instruction::result));
        }
        self.functions.retain(|function| called.contains(&function.id));
    }

    /// Removes names and decorations of what is gone.
    fn remove_annotations(&mut self) {
        let removed = &self.removed;
        self.globals.retain(|instruction| match instruction.opcode() {
            op::NAME | op::MEMBER_NAME | op::DECORATE => !removed.contains(&instruction.operands()[0]),
            _ => true,
        });
    }

    fn words(&self) -> Vec<u32> {
        let end = Instruction::new(op::FUNCTION_END, &[]);
        let mut out: Vec<u32> = self.globals.iter().flat_map(|instruction| &instruction.0).copied().collect();
        for function in &self.functions {
            out.extend(function.head.iter().flat_map(|instruction| &instruction.0));
            out.extend(function.blocks.iter().flat_map(|block| &block.code).flat_map(|instruction| &instruction.0));
            out.extend(&end.0);
        }
        out
    }
}

/// What an instruction comes to.
enum Folded {
    Value(bool),
    /// The value of another id.
    Copy(u32),
}

/// What an instruction comes to, if that is known and was not before.
fn folded(
    instruction: &Instruction,
    known: &Known,
    returns: &HashMap<u32, bool>,
    variables: &HashMap<u32, bool>,
) -> Option<Folded> {
    let value = |id: &u32| known.get(*id);
    let (opcode, [_, result, operands @ ..]) = (instruction.opcode(), instruction.operands()) else {
        return None;
    };
    if known.get(*result).is_some() {
        return None;
    }
    match (opcode, operands) {
        (op::LOGICAL_NOT, [a]) => Some(Folded::Value(!value(a)?)),
        (op::LOGICAL_AND | op::LOGICAL_OR, [a, b]) => {
            // The operand that decides, and the one that leaves the other.
            let decides = opcode == op::LOGICAL_OR;
            match (value(a), value(b)) {
                (Some(a), _) if a == decides => Some(Folded::Value(decides)),
                (_, Some(b)) if b == decides => Some(Folded::Value(decides)),
                (Some(_), Some(_)) => Some(Folded::Value(!decides)),
                (Some(_), None) => Some(Folded::Copy(*b)),
                (None, Some(_)) => Some(Folded::Copy(*a)),
                (None, None) => None,
            }
        }
        (op::SELECT, [condition, a, b]) => {
            let chosen = if value(condition)? { a } else { b };
            Some(value(chosen).map_or(Folded::Copy(*chosen), Folded::Value))
        }
        (op::PHI, [first, _]) => Some(Folded::Value(value(first)?)),
        (op::COPY_OBJECT, [source]) => Some(Folded::Value(value(source)?)),
        (op::LOAD, [variable, ..]) => variables.get(variable).copied().map(Folded::Value),
        (op::FUNCTION_CALL, [function, ..]) => returns.get(function).copied().map(Folded::Value),
        _ => None,
    }
}

impl Function {
    fn code(&self) -> impl Iterator<Item = &Instruction> {
        self.blocks.iter().flat_map(|block| &block.code)
    }

    fn calls(&self) -> impl Iterator<Item = u32> {
        let calls = self.code().filter(|instruction| instruction.opcode() == op::FUNCTION_CALL);
        calls.map(|call| call.operands()[2])
    }

    /// The boolean that it always returns, if there is one.
    fn returns(&self, known: &Known) -> Option<bool> {
        let mut values = self
            .code()
            .filter(|instruction| instruction.opcode() == op::RETURN_VALUE)
            .map(|instruction| known.get(instruction.operands()[0]));
        let first = values.next()??;
        values.all(|value| value == Some(first)).then_some(first)
    }

    /// Local variables that hold a known boolean wherever they hold anything: they are stored to
    /// once, and otherwise only loaded.
    fn constant_variables(&self, known: &Known) -> HashMap<u32, bool> {
        let is_known = |i: &Instruction| i.opcode() == op::STORE && known.get(i.operands()[1]).is_some();
        if !self.code().any(is_known) {
            return HashMap::new();
        }
        let declared = self.code().filter(|i| i.opcode() == op::VARIABLE && i.operands().len() == 3);
        let mut variables: HashMap<u32, Option<bool>> = declared.map(|i| (i.operands()[1], None)).collect();
        let mut others = HashSet::new();
        for instruction in self.code() {
            let operands = instruction.operands();
            let (own, rest) = match instruction.opcode() {
                op::VARIABLE => continue,
                op::STORE => (Some(operands[0]), &operands[1..]),
                op::LOAD => (None, &[][..]),
                _ => (None, operands),
            };
            if let Some(held) = own.and_then(|id| variables.get_mut(&id)) {
                match known.get(operands[1]) {
                    Some(value) if held.is_none() => *held = Some(value),
                    _ => {
                        others.insert(operands[0]);
                    }
                }
            }
            others.extend(rest.iter().filter(|word| variables.contains_key(word)));
        }
        variables
            .into_iter()
            .filter(|(id, _)| !others.contains(id))
            .filter_map(|(id, held)| Some((id, held?)))
            .collect()
    }

    /// Makes jumps of branches on known conditions, and removes the blocks that are not reached.
    fn jump(&mut self, known: &Known, removed: &mut HashSet<u32>) {
        let mut changed = false;
        for block in &mut self.blocks {
            let last = block.terminator();
            if last.opcode() != op::BRANCH_CONDITIONAL {
                continue;
            }
            let Some(condition) = known.get(last.operands()[0]) else {
                continue;
            };
            let target = last.operands()[if condition { 1 } else { 2 }];
            block.code.pop();
            // The header of a selection no longer is one; that of a loop is.
            block.code.pop_if(|merge| merge.opcode() == op::SELECTION_MERGE);
            block.code.push(Instruction::new(op::BRANCH, &[target]));
            changed = true;
        }
        if changed {
            self.remove_blocks(removed);
        }
    }

    fn remove_blocks(&mut self, removed: &mut HashSet<u32>) {
        let reached = self.reached();
        let headers = self.blocks.iter().filter(|block| reached.contains(&block.label));
        // Merge blocks and continue targets of what is left stay, with nothing in them.
        let mut stubs: HashMap<u32, Instruction> = HashMap::new();
        for header in headers {
            let (merge, target) = header.declared();
            stubs.extend(merge.map(|merge| (merge, Instruction::new(op::UNREACHABLE, &[]))));
            stubs.extend(target.map(|target| (target, Instruction::new(op::BRANCH, &[header.label]))));
        }
        for block in self.blocks.iter_mut().filter(|block| !reached.contains(&block.label)) {
            let stub = stubs.get(&block.label);
            let kept = if stub.is_some() { 1 } else { 0 };
            removed.extend(block.code[kept..].iter().filter_map(Instruction::result));
            block.code.truncate(kept);
            block.code.extend(stub.cloned());
        }
        self.blocks.retain(|block| !block.code.is_empty());
        self.mend_phis();
    }

    /// Labels of the blocks that the function may come to.
    fn reached(&self) -> HashSet<u32> {
        let places: HashMap<u32, usize> = self.blocks.iter().enumerate().map(|(i, block)| (block.label, i)).collect();
        let mut pending: Vec<u32> = self.blocks.first().map(|block| block.label).into_iter().collect();
        let mut reached = HashSet::new();
        while let Some(label) = pending.pop() {
            if let Some(place) = places.get(&label).filter(|_| reached.insert(label)) {
                pending.extend(self.blocks[*place].successors());
            }
        }
        reached
    }

    /// Takes out of phis the blocks that no longer lead to theirs.
    fn mend_phis(&mut self) {
        let edges: HashSet<[u32; 2]> = self
            .blocks
            .iter()
            .flat_map(|block| block.successors().into_iter().map(|successor| [block.label, successor]))
            .collect();
        for block in &mut self.blocks {
            for phi in block.code.iter_mut().filter(|instruction| instruction.opcode() == op::PHI) {
                let (head, pairs) = phi.operands().split_at(2);
                let kept = pairs.chunks_exact(2).filter(|pair| edges.contains(&[pair[1], block.label])).flatten();
                *phi = Instruction::new(op::PHI, &[head, &kept.copied().collect::<Vec<_>>()].concat());
            }
        }
    }
}

#[cfg(test)]
mod tests;
