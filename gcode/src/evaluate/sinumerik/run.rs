//! Executes a program block by block and records the executed blocks.

use std::borrow::Cow;
use std::collections::HashSet;
use std::ops::Range;

use super::source::Source;
use super::variables::{Kind, Name, Variables};
use crate::dialect::Options;
use crate::evaluate::control::{Limit, Next, check_alone, check_depth, main_block};
use crate::evaluate::files::{Files, Library};
use crate::evaluate::progress::Progress;
use crate::evaluate::recorded::Recorded;
use crate::evaluate::trace::Trace;
use crate::evaluate::value::{Fault, Value};
use crate::execution::Note;
use crate::program::Program;
use crate::word::{Word, WordKind};

/// Values of a subprogram's parameters, and the caller's variables that get them at the end.
#[derive(Clone, Debug, Default)]
pub(super) struct Arguments {
    pub values: Vec<(Kind, String, Value)>,
    pub returns: Vec<(String, Name)>,
}

/// An open call, or an open repetition of a section.
#[derive(Clone, Debug)]
pub(super) struct Call {
    /// The calling block.
    pub source: usize,
    pub block: usize,
    pub body: Range<usize>,
    /// Executions of the body that are still to come after this one.
    pub again: u32,
    pub progress: Progress,
    /// `None` for a section, which has no variables of its own.
    pub arguments: Option<Arguments>,
    /// The PROC statement of a subprogram that restores modes at its end.
    pub saved: Option<Word>,
}

/// The execution.
pub(in crate::evaluate) struct Run<'a> {
    pub(super) options: &'a Options,
    pub(super) library: Library<'a>,
    pub(super) sources: Vec<Source<'a>>,
    pub(super) variables: Variables,
    pub(super) calls: Vec<Call>,
    pub(super) source: usize,
    pub(super) block: usize,
    pub(super) trace: Trace,
    /// The first statement that only the running program decides.
    pub(super) undecided: Option<Note>,
    /// The first assignment that a program without variables cannot hold.
    pub(super) unwritable: Option<Note>,
    pub(super) targets: HashSet<usize>,
    pub(super) limit: Limit,
}

impl<'a> Run<'a> {
    pub fn new(program: &'a Program, options: &'a Options, files: Files<'a>) -> Self {
        let source = Source::new(String::new(), Cow::Borrowed(program));
        let body = source.first_program();
        Self {
            options,
            library: Library::new(files),
            sources: vec![source],
            variables: Variables::new(),
            calls: vec![Call {
                source: 0,
                block: 0,
                body,
                again: 0,
                progress: Progress::default(),
                arguments: None,
                saved: None,
            }],
            source: 0,
            block: 0,
            trace: Trace::default(),
            undecided: None,
            unwritable: None,
            targets: HashSet::new(),
            limit: Limit::new(program),
        }
    }

    /// Executes the program to its end.
    pub fn execute(&mut self) -> Result<(), Note> {
        loop {
            if self.block >= self.body().end {
                match self.leave() {
                    Next::End => return Ok(()),
                    _ => continue,
                }
            }
            let counted = self.limit.count(&self.sources[self.source].program, self.block).and_then(|()| self.check_progress());
            match counted.and_then(|()| self.execute_block()).map_err(|fault| self.note(fault))? {
                Next::Following => self.block += 1,
                Next::At(block) => self.block = block,
                Next::Set => {}
                Next::End => return Ok(()),
            }
        }
    }

    /// Refuses a program that repeats itself.
    fn check_progress(&mut self) -> Result<(), Fault> {
        let [global, local] = self.variables.changes();
        let Some(call) = self.calls.last_mut() else { return Ok(()) };
        call.progress.count([global, local, 0], self.sources[self.source].blocks())
    }

    pub(super) fn in_subprogram(&self) -> bool {
        self.calls.iter().any(|call| call.arguments.is_some())
    }

    fn body(&self) -> Range<usize> {
        self.calls.last().map_or(0..0, |call| call.body.clone())
    }

    /// Blocks of the program or subprogram that is executed, sections apart.
    pub(super) fn program_body(&self) -> Range<usize> {
        let own = self.calls.iter().rev().find(|call| call.arguments.is_some()).or(self.calls.first());
        own.map_or(0..0, |call| call.body.clone())
    }

    fn execute_block(&mut self) -> Result<Next, Fault> {
        let block = self.block;
        let program = &self.sources[self.source].program;
        let words = program.block_words(block);
        if words.is_empty() {
            return Ok(Next::Following);
        }
        let optional = program.is_optional(block);
        if optional && self.options.block_delete == Some(true) {
            return Ok(Next::Following);
        }
        if words.iter().all(is_inert) {
            // The head of a subprogram is none of the program.
            if !(self.in_subprogram() && words.iter().any(|word| word.kind == WordKind::Percent)) {
                self.push(None, optional && self.options.block_delete.is_none());
            }
            return Ok(Next::Following);
        }
        let undecided = optional && self.options.block_delete.is_none();
        match self.sources[self.source].flow_word(block) {
            Some(word) => {
                let is_allowed = |word: &Word| is_inert(word) && word.letter == 0;
                check_alone(&self.sources[self.source].program, block, word, undecided, is_allowed)?;
                self.execute_statement(word)
            }
            None => self.execute_words(undecided),
        }
    }

    /// Records the block. `None`: its words stand as in the file.
    pub(super) fn push(&mut self, words: Option<&[Word]>, perhaps: bool) {
        self.trace.push(self.source, self.block, words, perhaps, self.main_block());
    }

    /// The block of the main file that is executed, or that called what is executed.
    fn main_block(&self) -> usize {
        let calls = self.calls.iter().map(|call| (call.source, call.block));
        main_block(calls.chain([(self.source, self.block)]))
    }

    /// The fault at the present block.
    pub(super) fn note(&self, fault: Fault) -> Note {
        self.recorded().note_at((self.source, self.block), self.main_block(), fault)
    }

    /// What was executed so far.
    pub fn recorded(&self) -> Recorded<'_> {
        let programs = self.sources.iter().map(|source| (source.name.as_str(), &*source.program)).collect();
        Recorded {
            programs,
            trace: &self.trace,
            undecided: self.undecided.as_ref(),
            unwritable: self.unwritable.as_ref(),
            targets: &self.targets,
        }
    }

    /// Executes the blocks of `body` of a file `times` times, then goes on behind the present block.
    pub(super) fn enter(
        &mut self,
        source: usize,
        body: Range<usize>,
        times: u32,
        arguments: Option<Arguments>,
    ) -> Result<Next, Fault> {
        check_depth(self.calls.len())?;
        let Some(again) = times.checked_sub(1) else { return Ok(Next::Following) };
        let saved = arguments.as_ref().and_then(|_| self.saving_statement(source, &body));
        let progress = Progress::default();
        let call = Call { source: self.source, block: self.block, body, again, progress, arguments, saved };
        (self.source, self.block) = (source, call.body.start);
        self.open_level(&call);
        self.calls.push(call);
        Ok(Next::Set)
    }

    fn open_level(&mut self, call: &Call) {
        let Some(arguments) = &call.arguments else { return };
        self.variables.enter();
        for (kind, name, value) in &arguments.values {
            self.variables.define(name, *kind);
            self.variables.set(&Name::plain(name.as_str()), *value);
        }
    }

    /// Closes the innermost call, or executes its body once more.
    pub(super) fn leave(&mut self) -> Next {
        if self.calls.len() < 2 {
            return Next::End;
        }
        let Some(mut call) = self.calls.pop() else { return Next::End };
        if let Some(word) = call.saved {
            self.block = self.block.min(call.body.end.saturating_sub(1));
            self.push(Some(&[word]), false);
        }
        if let Some(arguments) = &call.arguments {
            let values: Vec<Value> =
                arguments.returns.iter().map(|(own, _)| self.variables.get(&Name::plain(own.as_str()))).collect();
            self.variables.leave();
            for ((_, name), value) in arguments.returns.iter().zip(values) {
                self.variables.set(name, value);
            }
        }
        if call.again > 0 {
            call.again -= 1;
            call.progress = Progress::default();
            self.block = call.body.start;
            self.open_level(&call);
            self.calls.push(call);
        } else {
            (self.source, self.block) = (call.source, call.block + 1);
        }
        Next::Set
    }

    /// RET, M17, M2, M30: ends the subprogram with all sections that are open in it, or the program.
    pub(super) fn end_program(&mut self) -> Next {
        if !self.in_subprogram() {
            return Next::End;
        }
        while self.calls.last().is_some_and(|call| call.arguments.is_none()) {
            self.calls.pop();
        }
        self.leave()
    }
}

/// Whether a word needs no evaluation and no control of the execution.
fn is_inert(word: &Word) -> bool {
    match word.kind {
        WordKind::Comment | WordKind::Keyword | WordKind::Percent | WordKind::BlockDelete => true,
        WordKind::Number => match word.letter {
            b'M' => ![2.0, 17.0, 30.0].contains(&word.value),
            b'L' => false,
            _ => true,
        },
        _ => false,
    }
}
