//! Files of an execution: subprograms that are read when they are called, and where a fault is in them.

use std::borrow::Cow;

use super::run::Run;
use super::source::Source;
use super::trace::{Executed, Words};
use super::value::Fault;
use crate::execution::Note;
use crate::program::parse;
use crate::word::{Span, Word};

impl Run<'_> {
    /// Index of a subprogram file among the sources; reads it if necessary.
    pub fn file(&mut self, names: &[String]) -> Option<usize> {
        for name in names {
            if let Some(known) = self.sources.iter().position(|source| source.name == *name) {
                return Some(known);
            }
            if self.missing.contains(name) {
                continue;
            }
            match (self.files)(name) {
                Some(bytes) => {
                    self.sources.push(Source::new(name.clone(), Cow::Owned(parse(bytes))));
                    return Some(self.sources.len() - 1);
                }
                None => self.missing.insert(name.clone()),
            };
        }
        None
    }

    /// The fault at the present block; in another file at the call, with the line in the text.
    pub fn note(&self, fault: Fault) -> Note {
        self.note_at(self.source, self.block, self.main_block(), fault)
    }

    /// The fault at a block of a source that `caller`, a block of the main file, executes.
    pub fn note_at(&self, source: usize, block: usize, caller: usize, fault: Fault) -> Note {
        let main = &self.sources[0].program;
        let whole = main.blocks().get(caller).map_or(Span { start: 0, end: 0 }, |block| block.span);
        let (span, message) = match (source, fault.at) {
            (0, Some(at)) => (Span { start: at.start, end: at.end }, fault.message),
            (0, None) => (whole, fault.message),
            (other, _) => {
                let (name, line) = (&self.sources[other].name, block + 1);
                (whole, format!("{} (line {line} of {name})", fault.message))
            }
        };
        Note { span, message, help: fault.help }
    }

    /// The words of an executed block with their values.
    pub fn words_of(&self, executed: &Executed) -> &[Word] {
        match &executed.words {
            Words::Own => self.sources[executed.source].program.block_words(executed.block),
            Words::Valued(range) => &self.trace.words[range.clone()],
        }
    }
}
