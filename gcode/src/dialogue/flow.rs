//! Calls, repeats and jumps: from where on blocks may run in another order than they are written.

use std::collections::BTreeMap;

use super::block::Block;
use crate::program::Program;
use crate::word::Span;

/// A call or jump.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Uncertain {
    /// The first block that may run more than once, or after blocks that are not the ones before it.
    pub from: usize,
    /// The call or jump.
    pub cause: Span,
}

/// The earliest effect of the calls and jumps up to the end of the program: the call itself, or its label where that comes first.
pub(super) fn first_uncertain(program: &Program) -> Option<Uncertain> {
    let mut labels: BTreeMap<Vec<u8>, usize> = BTreeMap::new();
    let mut found: Option<Uncertain> = None;
    for index in 0..program.blocks().len() {
        let block = Block::of(program, index);
        if block.begins(&["END", "PGM"]) || block.words.iter().any(|word| word.is(b'M') && [2.0, 30.0].contains(&word.value)) {
            break;
        }
        if block.begins(&["LBL"]) {
            if let Some(name) = block.words.get(1) {
                labels.entry(block.text(name)).or_insert(index);
            }
        } else if (block.begins(&["CALL"]) || block.has("GOTO"))
            && let Some(first) = block.words.first()
        {
            let label = block.words.iter().position(|word| block.text(word) == b"LBL").and_then(|at| block.words.get(at + 1));
            let target = label.and_then(|label| labels.get(&block.text(label))).copied();
            let from = target.unwrap_or(index).min(index);
            if found.is_none_or(|earlier| from < earlier.from) {
                found = Some(Uncertain { from, cause: first.span });
            }
        }
    }
    found
}
