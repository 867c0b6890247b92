//! The executed blocks, in order, with the values of their words.

use std::ops::Range;

use crate::word::Word;

/// Words of an executed block.
#[derive(Clone, Debug)]
pub(super) enum Words {
    /// All words as they stand in the file.
    Own,
    /// Range of [`Trace::words`].
    Valued(Range<usize>),
}

/// One execution of a block.
#[derive(Clone, Debug)]
pub(super) struct Executed {
    pub source: usize,
    pub block: usize,
    pub words: Words,
    /// Which execution of the block it is, from 1.
    pub run: u32,
    /// Whether only the running program decides if it is executed.
    pub perhaps: bool,
    /// Block of the main program that was left by a call, else the block itself.
    pub caller: usize,
}

/// All executed blocks.
#[derive(Debug, Default)]
pub(super) struct Trace {
    pub executed: Vec<Executed>,
    pub words: Vec<Word>,
    /// Number of executions of each block, by file.
    runs: Vec<Vec<u32>>,
}

impl Trace {
    pub fn runs(&self, source: usize, block: usize) -> u32 {
        self.runs.get(source).and_then(|runs| runs.get(block)).copied().unwrap_or(0)
    }

    /// Appends a block. `None`: its words stand as in the file.
    pub fn push(&mut self, source: usize, block: usize, words: Option<&[Word]>, perhaps: bool, caller: usize) {
        if self.runs.len() <= source {
            self.runs.resize(source + 1, Vec::new());
        }
        let runs = &mut self.runs[source];
        if runs.len() <= block {
            runs.resize(block + 1, 0);
        }
        runs[block] += 1;
        let run = runs[block];
        let words = match words {
            None => Words::Own,
            Some(words) => {
                let start = self.words.len();
                self.words.extend_from_slice(words);
                Words::Valued(start..self.words.len())
            }
        };
        self.executed.push(Executed { source, block, words, run, perhaps, caller });
    }
}
