//! Blocks of which only the running program decides whether, and how often, they are executed.
//!
//! They are recorded once and marked. What they may assign is unknown from their start on. Where a jump may leave them, everything up to the end of
//! the program is of this kind.

use std::ops::Range;

use super::run::Run;
use super::statement::Statement;
use crate::evaluate::control::{DEEPEST_PERHAPS, MOST_BEFORE_END, Next, undecided};
use crate::evaluate::value::{Fault, Value};
use crate::word::{Word, WordKind};

/// Source and blocks of a subprogram if it is found, and the text of its arguments.
type Callee = (Option<(usize, Range<usize>)>, Vec<u8>);

impl Run<'_> {
    /// Records the blocks of `range` as perhaps executed and goes on at `after`.
    pub(super) fn perhaps(&mut self, range: Range<usize>, after: usize) -> Result<Next, Fault> {
        self.note_undecided();
        if self.leaves(&range) {
            return self.give_up(Some(range.start));
        }
        for _ in 0..2 {
            self.forget_assigned(range.clone(), 0)?;
        }
        self.record(range, 0)?;
        Ok(Next::At(after))
    }

    /// A jump that only the running program decides.
    pub(super) fn perhaps_jump(&mut self, target: usize) -> Result<Next, Fault> {
        self.note_undecided();
        if self.only_ends(target) {
            return Ok(Next::Following);
        }
        let block = self.block;
        if target > block && self.is_level(block + 1..target) {
            self.perhaps(block + 1..target, target)
        } else {
            self.give_up(Some(target))
        }
    }

    /// Everything from `first` to the end of this program, and behind the calls that led here, is perhaps executed. Ends the execution.
    pub(super) fn give_up(&mut self, first: Option<usize>) -> Result<Next, Fault> {
        self.note_undecided();
        self.variables.forget_all();
        let mut first = first.unwrap_or(self.block).min(self.block);
        loop {
            let body = self.program_body();
            self.record(first.max(body.start)..body.end, 0)?;
            while self.calls.last().is_some_and(|call| call.arguments.is_none()) && self.calls.len() > 1 {
                self.calls.pop();
            }
            if self.calls.len() < 2 {
                return Ok(Next::End);
            }
            let Some(call) = self.calls.pop() else { return Ok(Next::End) };
            self.variables.leave();
            (self.source, self.block) = (call.source, call.block + 1);
            first = self.block;
        }
    }

    /// Whether branches and loops lie in the range with both ends or not at all.
    fn is_level(&self, range: Range<usize>) -> bool {
        let source = &self.sources[self.source];
        let is_whole = |block: usize| source.partner(block).is_none_or(|partner| range.contains(&partner));
        range.clone().all(is_whole)
    }

    /// Whether a jump or an end leads out of the range.
    fn leaves(&mut self, range: &Range<usize>) -> bool {
        let here = self.block;
        let mut leaves = false;
        for block in range.clone() {
            self.block = block;
            leaves |= match self.sources[self.source].statement(block).cloned() {
                Some(Statement::Jump { jump, .. }) => {
                    let target = self.place(&jump).unwrap_or(usize::MAX);
                    !(range.contains(&target) || target == range.end || self.only_ends(target))
                }
                Some(Statement::Case { .. } | Statement::Again { .. } | Statement::NotUnderstood) => true,
                // Behind the end of the main program nothing follows.
                Some(Statement::Return) => self.in_subprogram(),
                _ => self.in_subprogram() && self.ends_at(block),
            };
        }
        self.block = here;
        leaves
    }

    fn ends_at(&self, block: usize) -> bool {
        self.sources[self.source].program.block_words(block).iter().any(is_end)
    }

    /// Reports the first statement that the program decides when it runs.
    fn note_undecided(&mut self) {
        if self.undecided.is_none() {
            self.undecided = Some(self.note(undecided(&self.sources[self.source].program, self.block)));
        }
    }

    /// Whether execution from `block` on ends the program without a move.
    fn only_ends(&self, block: usize) -> bool {
        let source = &self.sources[self.source];
        for at in (block..source.blocks()).take(MOST_BEFORE_END) {
            let words = source.program.block_words(at);
            if words.iter().any(is_end) {
                return !self.in_subprogram() && words.iter().all(|word| is_end(word) || is_idle(word));
            }
            if !words.iter().all(is_idle) {
                return false;
            }
        }
        false
    }

    /// Makes unknown what the blocks of `range` may assign.
    fn forget_assigned(&mut self, range: Range<usize>, depth: usize) -> Result<(), Fault> {
        let here = self.block;
        for block in range {
            self.limit.count(&self.sources[self.source].program, block)?;
            self.block = block;
            let source = &self.sources[self.source];
            let mut names = Vec::new();
            for word in source.program.block_words(block).iter().filter(|word| word.kind == WordKind::Assignment) {
                let read = super::expression::target(source.program.text(word.span), &self.variables);
                names.extend(read.map(|(name, _)| name));
            }
            if let Some(Statement::For { variable, .. }) = source.statement(block) {
                names.extend(self.variable(variable));
            }
            names.iter().for_each(|name| self.variables.set(name, Value::Unknown));
            if let Some((_, written)) = self.callee(depth) {
                self.variables.forget_global();
                self.forget_arguments(&written);
            }
        }
        self.block = here;
        Ok(())
    }

    /// The subprogram that the present block calls, if it is found, and the text of its arguments.
    fn callee(&mut self, depth: usize) -> Option<Callee> {
        let (name, written) = match self.sources[self.source].statement(self.block) {
            Some(Statement::Call { name, arguments }) => (name.clone(), arguments.clone()),
            Some(_) => return None,
            None => self.call_of_block().map(|call| (call.name, call.arguments))?,
        };
        let found = if depth < DEEPEST_PERHAPS { self.subprogram(&name) } else { None };
        Some((found, written))
    }

    /// Records the words of `range`, and of the subprograms called in it.
    fn record(&mut self, range: Range<usize>, depth: usize) -> Result<(), Fault> {
        let here = self.block;
        for block in range {
            self.limit.count(&self.sources[self.source].program, block)?;
            self.block = block;
            let called = self.callee(depth);
            if let Some((Some((source, body)), _)) = called {
                self.record_call(source, body, depth)?;
                continue;
            }
            match self.sources[self.source].flow_word(block) {
                Some(flow) => {
                    let kept = matches!(
                        self.sources[self.source].statement(block),
                        Some(Statement::NotUnderstood | Statement::Call { .. })
                    );
                    if kept {
                        self.push_flow(flow, true);
                    }
                }
                None => {
                    let (words, _) = self.evaluated_words(false)?;
                    let is_mark = words.iter().any(|word| word.kind == WordKind::Percent);
                    if !words.is_empty() && !is_mark {
                        self.push(Some(&words), true);
                    }
                }
            }
        }
        self.block = here;
        Ok(())
    }

    fn record_call(&mut self, source: usize, body: Range<usize>, depth: usize) -> Result<(), Fault> {
        let (here, block) = (self.source, self.block);
        self.enter(source, body.clone(), 1, Some(super::run::Arguments::default()))?;
        self.variables.forget_all();
        let recorded = self.record(body, depth + 1);
        self.leave();
        (self.source, self.block) = (here, block);
        recorded
    }
}

fn is_end(word: &Word) -> bool {
    word.is(b'M') && [2.0, 17.0, 30.0].contains(&word.value)
}

/// Whether a word does nothing on the way to an end: messages, stops, labels.
fn is_idle(word: &Word) -> bool {
    match word.kind {
        WordKind::Comment | WordKind::Keyword => true,
        WordKind::Number => word.letter == b'N' || word.letter == b'M' && [0.0, 1.0, 5.0, 9.0].contains(&word.value),
        _ => false,
    }
}
