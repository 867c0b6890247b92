//! Control of an execution, whatever the language of its program: where it goes on, and how far.

use super::value::Fault;
use crate::program::Program;
use crate::word::{Word, WordKind};

/// Largest number of blocks that may be executed beyond one execution of every block of the program. It ends a loop that counts without end after half a second.
const MOST_REPEATED: usize = 4_000_000;
/// Largest depth of calls.
const DEEPEST: usize = 100;
/// Largest depth of calls within blocks that are perhaps executed.
pub(super) const DEEPEST_PERHAPS: usize = 8;
/// Number of blocks within which an end must follow a jump.
pub(super) const MOST_BEFORE_END: usize = 100;

/// Where the execution goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    Following,
    At(usize),
    /// The position is set already.
    Set,
    End,
}

/// The number of blocks that may still be executed.
#[derive(Debug)]
pub(super) struct Limit(usize);

impl Limit {
    pub fn new(main: &Program) -> Self {
        let all: usize = (0..main.blocks().len()).map(|block| weight(main, block)).sum();
        Self(all + MOST_REPEATED)
    }

    /// Counts an executed block. Without an end the execution is refused.
    pub fn count(&mut self, program: &Program, block: usize) -> Result<(), Fault> {
        if let Some(left) = self.0.checked_sub(weight(program, block)) {
            self.0 = left;
            return Ok(());
        }
        let message = format!(
            "the program does not end: more than {MOST_REPEATED} blocks are repeated (one with expressions counts twice)"
        );
        Err(Fault::new(message).help("check the condition of the loop"))
    }
}

/// Words and bytes of a block up to which it counts as one. Longer ones take the time of several.
const USUAL_WORDS: usize = 16;
const USUAL_BYTES: usize = 256;
/// Bytes that take the time of a short block.
const BYTES_A_BLOCK: usize = 16;

/// What a block counts. With expressions and statements it takes the time of two (200 and 100 ns, measured with `#1=[#1+1]` and `G0 X1`).
fn weight(program: &Program, block: usize) -> usize {
    let bytes = program.blocks().get(block).map_or(0, |block| block.span.len());
    let is_evaluated = |word: &Word| matches!(word.kind, WordKind::Flow | WordKind::Assignment | WordKind::Expression);
    let own = 1 + usize::from(program.block_words(block).iter().any(is_evaluated));
    own + program.word_range(block).len().saturating_sub(USUAL_WORDS) + bytes.saturating_sub(USUAL_BYTES) / BYTES_A_BLOCK
}

/// Refuses a further call within `open` others.
pub(super) fn check_depth(open: usize) -> Result<(), Fault> {
    if open > DEEPEST { Err(Fault::new(format!("calls nested deeper than {DEEPEST}"))) } else { Ok(()) }
}

/// A flow statement has a block of its own, which no switch may skip. `is_allowed`: what may stand beside it and its block
/// number.
pub(super) fn check_alone(
    program: &Program,
    block: usize,
    flow: usize,
    is_optional: bool,
    is_allowed: impl Fn(&Word) -> bool,
) -> Result<(), Fault> {
    let span = program.words()[flow].span;
    if is_optional {
        let fault = Fault::new("a flow statement in a block that a switch may skip").at(span);
        return Err(fault.help("state the position of the switch (--block-delete)"));
    }
    let fits = |index: usize| {
        let word = &program.words()[index];
        index == flow || word.is(b'N') || is_allowed(word)
    };
    if program.word_range(block).all(fits) {
        return Ok(());
    }
    Err(Fault::new("a flow statement in a block with codes or axis words").at(span).help("give it a line of its own"))
}

/// The block of the main file that is executed, or that called what is executed. `places`: sources and blocks of the open calls, then of the
/// execution.
pub(super) fn main_block(places: impl DoubleEndedIterator<Item = (usize, usize)>) -> usize {
    places.rev().find(|(source, _)| *source == 0).map_or(0, |(_, block)| block)
}

/// The report of a statement that only the running program decides.
pub(super) fn undecided(program: &Program, block: usize) -> Fault {
    let fault = Fault::new("the program decides this when it runs: moves that depend on it are left alone");
    let flow = program.block_words(block).iter().find(|word| word.kind == WordKind::Flow);
    match flow {
        Some(word) => fault.at(word.span),
        None => fault,
    }
}
