//! The order in which the blocks of a program are executed.

use std::collections::HashSet;
use std::ops::Range;

use crate::word::Span;

/// How often a block is executed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ran {
    /// Once.
    Once,
    /// Several times, in loops or subprograms.
    Repeated,
    /// In a file of its own, as part of the block that calls it.
    Elsewhere,
    /// Only the running program decides.
    Perhaps,
}

/// One execution of a block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// The block; for a subprogram in another file the block that calls it.
    pub block: u32,
    pub first_word: u32,
    pub end_word: u32,
    pub ran: Ran,
}

impl Step {
    /// Indices of its words.
    pub fn words(&self) -> Range<usize> {
        self.first_word as usize..self.end_word as usize
    }
}

/// Something that the user should know.
#[derive(Clone, Debug)]
pub(crate) struct Note {
    pub span: Span,
    pub message: String,
    pub help: Option<&'static str>,
}

/// A program as it runs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Execution {
    /// Whether each block is executed once.
    pub once: Vec<bool>,
    /// Blocks to which jumps lead. A line before such a block is skipped.
    pub targets: HashSet<usize>,
    /// The executed blocks, in order.
    pub steps: Vec<Step>,
    pub notes: Vec<Note>,
    /// Names and contents of the subprogram files that were read.
    pub files: Vec<(String, Vec<u8>)>,
}

impl Execution {
    pub fn runs_once(&self, block: usize) -> bool {
        self.once.get(block).copied().unwrap_or(false)
    }
}
