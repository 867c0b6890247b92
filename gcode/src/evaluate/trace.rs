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

/// One execution of a block. Millions may be held: indices take 32 bits, as many as a program of 4 GiB needs.
#[derive(Clone, Debug)]
pub(super) struct Executed {
    source: u32,
    block: u32,
    /// First word and number of words in [`Trace::words`]; [`OWN`] for those of the file.
    words: [u32; 2],
    caller: u32,
    /// Which execution of the block it is, from 1.
    pub run: u32,
    /// Whether only the running program decides if it is executed.
    pub perhaps: bool,
}

const OWN: [u32; 2] = [u32::MAX; 2];

fn index(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}

impl Executed {
    pub fn source(&self) -> usize {
        self.source as usize
    }

    pub fn block(&self) -> usize {
        self.block as usize
    }

    /// Block of the main program that was left by a call, else the block itself.
    pub fn caller(&self) -> usize {
        self.caller as usize
    }

    pub fn words(&self) -> Words {
        let [start, count] = self.words.map(|number| number as usize);
        if self.words == OWN { Words::Own } else { Words::Valued(start..start + count) }
    }
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
            None => OWN,
            Some(words) => {
                let start = self.words.len();
                self.words.extend_from_slice(words);
                [index(start), index(words.len())]
            }
        };
        let (source, block, caller) = (index(source), index(block), index(caller));
        self.executed.push(Executed { source, block, words, caller, run, perhaps });
    }
}
