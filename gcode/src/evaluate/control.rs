//! Control of an execution, whatever the language of its program: where it goes on, and how far.

use super::value::Fault;
use crate::program::Program;
use crate::word::{Word, WordKind};

/// Largest number of blocks that may be executed beyond one execution of every block of the program. It ends `while [1]` after a second.
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
        Self(main.blocks().len() + MOST_REPEATED)
    }

    /// Counts an executed block. Without an end the execution is refused.
    pub fn count(&mut self) -> Result<(), Fault> {
        if let Some(left) = self.0.checked_sub(1) {
            self.0 = left;
            return Ok(());
        }
        let message = format!("the program does not end: more than {MOST_REPEATED} blocks are repeated");
        Err(Fault::new(message).help("check the condition of the loop"))
    }
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
