//! Executes a program block by block and records the executed blocks.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

use super::control::{Limit, Next, check_alone, check_depth, main_block};
use super::files::{Files, Library};
use super::parameters::Parameters;
use super::progress::Progress;
use super::quirks::Quirks;
use super::recorded::Recorded;
use super::source::{BlockKind, Source};
use super::trace::Trace;
use super::value::{Fault, Value};
use crate::dialect::{Dialect, Options};
use crate::execution::Note;
use crate::program::Program;
use crate::word::{Word, WordKind};

/// First block of a subprogram, with the index of its source.
pub(super) type Body = (usize, usize);

/// An open call.
#[derive(Debug)]
pub(super) struct Call {
    /// The calling block.
    pub source: usize,
    pub block: usize,
    /// First block of the body.
    pub body: Body,
    /// Executions of the body that are still to come after this one.
    pub again: u32,
    /// Values of local parameters, if the call opens a level of its own.
    pub arguments: Option<Vec<(u32, Value)>>,
    /// Remaining passes of `repeat`, by block.
    pub passes: HashMap<usize, u64>,
    /// Number of changes of these.
    pub pass_changes: u64,
    pub progress: Progress,
    /// Whether a `return` may have been executed.
    pub may_return: bool,
    /// Block of an M73, and its M72 for the return.
    pub restores: Option<(usize, Word)>,
}

/// The execution.
pub(super) struct Run<'a> {
    pub options: &'a Options,
    pub dialect: Dialect,
    pub library: Library<'a>,
    pub sources: Vec<Source<'a>>,
    pub parameters: Parameters,
    pub calls: Vec<Call>,
    pub source: usize,
    pub block: usize,
    pub trace: Trace,
    /// The first statement that only the running program decides.
    pub undecided: Option<Note>,
    /// The first assignment or call that a program without parameters cannot hold.
    pub unwritable: Option<Note>,
    /// Blocks of the main file to which sequence numbers led.
    pub targets: HashSet<usize>,
    pub limit: Limit,
    /// Whether anything was assigned that a subprogram may read.
    pub assigns: bool,
    content_seen: bool,
    pub quirks: Quirks,
}

impl<'a> Run<'a> {
    pub fn new(program: &'a Program, options: &'a Options, files: Files<'a>) -> Self {
        Self {
            options,
            dialect: options.dialect,
            library: Library::new(files),
            sources: vec![Source::new(String::new(), Cow::Borrowed(program))],
            parameters: Parameters::new(options.dialect),
            calls: vec![Call {
                source: 0,
                block: 0,
                body: (0, 0),
                again: 0,
                arguments: None,
                passes: HashMap::new(),
                pass_changes: 0,
                progress: Progress::default(),
                may_return: false,
                restores: None,
            }],
            source: 0,
            block: 0,
            trace: Trace::default(),
            undecided: None,
            unwritable: None,
            assigns: false,
            targets: HashSet::new(),
            limit: Limit::new(program),
            content_seen: false,
            quirks: Quirks::default(),
        }
    }

    /// Executes the program to its end.
    pub fn execute(&mut self) -> Result<(), Note> {
        loop {
            if self.block >= self.sources[self.source].blocks() {
                if self.in_call() {
                    let fault = Fault::new("this call leads into a subprogram without an end").help("end it with endsub or M99");
                    (self.source, self.block) = self.calls.last().map_or((0, 0), |call| (call.source, call.block));
                    return Err(self.note(fault));
                }
                return Ok(());
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
        let [global, local] = self.parameters.changes();
        let Quirks { broke_while, continued_do } = self.quirks;
        let Some(call) = self.calls.last_mut() else { return Ok(()) };
        let own = 8 * call.pass_changes + 4 * u64::from(call.may_return) + 2 * u64::from(broke_while) + u64::from(continued_do);
        call.progress.count([global, local, own], self.sources[self.source].blocks())
    }

    pub fn in_call(&self) -> bool {
        self.calls.len() > 1
    }

    fn execute_block(&mut self) -> Result<Next, Fault> {
        let block = self.block;
        match self.sources[self.source].kind(block) {
            BlockKind::Empty => return Ok(Next::Following),
            kind @ (BlockKind::Comment | BlockKind::Inert) => {
                self.content_seen |= kind == BlockKind::Inert;
                self.push(None, false);
                return Ok(Next::Following);
            }
            BlockKind::Active => {}
        }
        let words = self.sources[self.source].program.block_words(block);
        let optional = self.sources[self.source].program.is_optional(block);
        if optional && self.options.block_delete == Some(true) {
            return Ok(Next::Following);
        }
        if words.iter().any(|word| word.kind == WordKind::Percent) {
            let ends = self.content_seen || self.source > 0;
            self.content_seen = true;
            if self.source == 0 {
                self.push(None, false);
            }
            return Ok(if ends && !self.in_call() { Next::End } else { Next::Following });
        }
        self.content_seen = true;
        let undecided = optional && self.options.block_delete.is_none();
        match self.sources[self.source].flow_word(block) {
            Some(word) => {
                let is_allowed = |word: &Word| matches!(word.kind, WordKind::Comment | WordKind::BlockDelete);
                check_alone(&self.sources[self.source].program, block, word, undecided, is_allowed)?;
                self.execute_statement(word)
            }
            None if undecided => self.skip_perhaps(),
            None => self.execute_words(),
        }
    }

    /// Records the block. `None`: its words stand as in the file.
    pub fn push(&mut self, words: Option<&[Word]>, perhaps: bool) {
        self.trace.push(self.source, self.block, words, perhaps, self.main_block());
    }

    /// The block of the main file that is executed, or that called what is executed.
    fn main_block(&self) -> usize {
        let calls = self.calls.iter().map(|call| (call.source, call.block));
        main_block(calls.chain([(self.source, self.block)]))
    }

    /// The fault at the present block.
    pub fn note(&self, fault: Fault) -> Note {
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

    /// Opens a call of the body at `body`.
    pub fn enter(&mut self, body: Body, times: u32, arguments: Option<Vec<(u32, Value)>>) -> Result<Next, Fault> {
        check_depth(self.calls.len())?;
        let Some(again) = times.checked_sub(1) else { return Ok(Next::Following) };
        if let Some(arguments) = &arguments {
            self.parameters.enter(arguments);
        }
        let (source, block) = (self.source, self.block);
        self.calls.push(Call {
            source,
            block,
            body,
            again,
            arguments,
            passes: HashMap::new(),
            pass_changes: 0,
            progress: Progress::default(),
            may_return: false,
            restores: None,
        });
        (self.source, self.block) = body;
        Ok(Next::Set)
    }

    /// Closes the innermost call, or executes its body once more.
    pub fn leave(&mut self) -> Next {
        if let Some((block, word)) = self.calls.last_mut().and_then(|call| call.restores.take()) {
            self.block = block;
            self.push(Some(&[word]), false);
        }
        let Some(mut call) = self.calls.pop() else { return Next::End };
        if call.arguments.is_some() {
            self.parameters.leave();
        }
        if call.again > 0 {
            call.again -= 1;
            call.passes.clear();
            call.progress = Progress::default();
            if let Some(arguments) = &call.arguments {
                self.parameters.enter(arguments);
            }
            (self.source, self.block) = call.body;
            self.calls.push(call);
        } else {
            (self.source, self.block) = (call.source, call.block + 1);
        }
        Next::Set
    }
}
