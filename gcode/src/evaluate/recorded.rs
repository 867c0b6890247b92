//! An execution as it was recorded, whatever the language of its program.

use std::collections::HashSet;

use super::trace::{Executed, Trace, Words};
use super::value::Fault;
use crate::execution::{Execution, Note, Ran, Step};
use crate::program::Program;
use crate::word::{Span, Word, WordKind};

/// A recorded execution. The main program is the first.
pub(super) struct Recorded<'a> {
    /// Names of the files with their programs.
    pub programs: Vec<(&'a str, &'a Program)>,
    pub trace: &'a Trace,
    pub undecided: Option<&'a Note>,
    /// What cannot be written without parameters.
    pub unwritable: Option<&'a Note>,
    /// Blocks of the main file to which jumps lead.
    pub targets: &'a HashSet<usize>,
}

impl Recorded<'_> {
    /// The words of an executed block with their values.
    pub fn words_of(&self, executed: &Executed) -> &[Word] {
        match executed.words() {
            Words::Own => self.programs[executed.source()].1.block_words(executed.block()),
            Words::Valued(range) => self.trace.words.get(range).unwrap_or_default(),
        }
    }

    /// The fault at a block of a source that `caller`, a block of the main file, executes: in another file at the call, with the line in the
    /// text.
    pub fn note_at(&self, (source, block): (usize, usize), caller: usize, fault: Fault) -> Note {
        let whole = self.programs[0].1.blocks().get(caller).map_or(Span { start: 0, end: 0 }, |block| block.span);
        let (span, message) = match (source, fault.at) {
            (0, Some(at)) => (Span { start: at.start, end: at.end }, fault.message),
            (0, None) => (whole, fault.message),
            (other, _) => {
                let (name, line) = (self.programs[other].0, block + 1);
                (whole, format!("{} (line {line} of {name})", fault.message))
            }
        };
        Note { span, message, help: fault.help }
    }

    /// Values of the program's own words, the words of further executions, and the order of all.
    pub fn in_place(&self) -> (Vec<(usize, f64)>, Vec<Word>, Execution) {
        let main = self.programs[0].1;
        let (mut values, mut again, mut steps) = (Vec::new(), Vec::new(), Vec::with_capacity(self.trace.executed.len()));
        let own_words = main.words().len();
        let mut once = vec![false; main.blocks().len()];
        for executed in &self.trace.executed {
            let words = match executed.words() {
                Words::Own if executed.source() == 0 => main.word_range(executed.block()),
                _ => {
                    let start = again.len();
                    let caller = main.blocks()[executed.caller()].span;
                    let at = |word: &Word| placed(word, (executed.source() > 0).then_some(caller));
                    again.extend(self.words_of(executed).iter().map(at));
                    own_words + start..own_words + again.len()
                }
            };
            if executed.source() == 0 && executed.run == 1 {
                values.extend(own_values(main, executed.block(), self.words_of(executed)));
            }
            let (block, first_word, end_word) = (executed.caller() as u32, words.start as u32, words.end as u32);
            let ran = self.ran(executed);
            once[executed.caller()] |= ran == Ran::Once;
            steps.push(Step { block, first_word, end_word, ran });
        }
        let files = self.programs[1..].iter().map(|(name, program)| ((*name).to_owned(), program.bytes().to_vec())).collect();
        let notes = self.undecided.into_iter().cloned().collect();
        (values, again, Execution { once, targets: self.targets.clone(), steps, notes, files })
    }

    fn ran(&self, executed: &Executed) -> Ran {
        match executed.source() {
            _ if executed.perhaps => Ran::Perhaps,
            1.. => Ran::Elsewhere,
            0 if self.trace.runs(0, executed.block()) > 1 => Ran::Repeated,
            0 => Ran::Once,
        }
    }
}

/// A word of another file refers to the block that calls it.
fn placed(word: &Word, caller: Option<Span>) -> Word {
    match caller {
        Some(span) => Word { span, value_start: span.end, ..*word },
        None => *word,
    }
}

/// Indices and values of the expressions of a block. The executed words are some of its words, in order.
fn own_values(main: &Program, block: usize, executed: &[Word]) -> impl Iterator<Item = (usize, f64)> {
    let mut rest = executed.iter().peekable();
    main.word_range(block).filter_map(move |index| {
        let own = main.words()[index];
        let value = rest.next_if(|word| word.span == own.span)?.value;
        (own.kind == WordKind::Expression).then_some((index, value))
    })
}
