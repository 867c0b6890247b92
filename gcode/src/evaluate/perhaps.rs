//! Blocks of which only the running program decides whether, and how often, they are executed.
//!
//! They are recorded once and marked. What they may assign is unknown from their start on.

use std::collections::HashSet;
use std::ops::Range;

use super::calls::value_of;
use super::control::{DEEPEST_PERHAPS, MOST_BEFORE_END, Next, undecided};
use super::expression::assignment;
use super::parameters::Name;
use super::run::{Body, Run};
use super::statement::{Keyword, Statement, Then};
use super::value::{Fault, Value};
use crate::word::{Word, WordKind};

impl Run<'_> {
    /// Records the blocks of `range` as perhaps executed and goes on at `after`, or behind what jumps out of the range may skip.
    pub fn perhaps(&mut self, range: Range<usize>, after: usize) -> Result<Next, Fault> {
        self.note_undecided();
        let range = self.widened(range)?;
        // The second pass meets targets of assignments whose number the first made unknown.
        for _ in 0..2 {
            self.forget_assigned(range.clone())?;
        }
        self.record(range.clone(), 0)?;
        Ok(Next::At(range.end.max(after)))
    }

    /// A jump that only the running program decides.
    pub fn perhaps_jump(&mut self, target: usize) -> Result<Next, Fault> {
        self.note_undecided();
        if self.only_ends(target) {
            return Ok(Next::Following);
        }
        let block = self.block;
        if target > block { self.perhaps(block + 1..target, target) } else { self.perhaps(target..block, block + 1) }
    }

    /// A block that a switch may skip.
    pub fn skip_perhaps(&mut self) -> Result<Next, Fault> {
        let (words, assigned) = self.evaluated_words(false)?;
        for (name, _) in assigned {
            self.assign(name, Value::Unknown)?;
        }
        if self.callee(&words).is_some() {
            return Err(
                Fault::new("a call in a block that a switch may skip").help("state the position of the switch (--block-delete)")
            );
        }
        if self.calls_by_code(&words) {
            self.forget_unread(words.iter().any(|word| word.is(b'G') && word.value == 65.0));
        }
        self.push(Some(&words), true);
        Ok(Next::Following)
    }

    /// Reports the first statement that the program decides when it runs.
    fn note_undecided(&mut self) {
        if self.undecided.is_none() {
            self.undecided = Some(self.note(undecided(&self.sources[self.source].program, self.block)));
        }
    }

    /// Whether execution from `block` on ends the program without a move: an alarm or an end.
    fn only_ends(&self, block: usize) -> bool {
        let source = &self.sources[self.source];
        for at in (block..source.blocks()).take(MOST_BEFORE_END) {
            for word in source.program.block_words(at) {
                match word.kind {
                    WordKind::Comment => {}
                    WordKind::Number if word.letter == b'N' => {}
                    WordKind::Number if word.letter == b'M' => {
                        return matches!(word.value, 2.0 | 30.0) || self.ends_by_return(word);
                    }
                    WordKind::Assignment => {
                        let read = assignment(source.program.text(word.span), &self.parameters, self.dialect);
                        return matches!(read, Ok((Some(Name::Number(3000)), _)));
                    }
                    _ => return false,
                }
            }
        }
        false
    }

    fn ends_by_return(&self, word: &Word) -> bool {
        word.value == 99.0 && !self.in_call()
    }

    /// The range with all that jumps out of it may skip or repeat.
    fn widened(&mut self, range: Range<usize>) -> Result<Range<usize>, Fault> {
        let mut range = range;
        let mut at = range.start;
        while at < range.end {
            let before = range.clone();
            let statement = self.sources[self.source].statement(at);
            match statement.as_deref() {
                Some(Statement::OWord { label: super::statement::Label::Fixed(label), keyword, .. }) => match keyword {
                    Keyword::Return => range.end = range.end.max(self.end_of_body()?),
                    Keyword::Break | Keyword::Continue => {
                        if let Some((start, end)) = self.loop_around(at, label)
                            && !(range.contains(&start) && range.contains(&end))
                        {
                            range = range.start.min(start)..range.end.max(end + 1);
                        }
                    }
                    _ => {}
                },
                Some(Statement::Goto(target) | Statement::If { then: Then::Goto(target), .. }) => {
                    let text = super::expression::term(target, &self.parameters, self.dialect)?;
                    let target = self.jump_target(text.number())?;
                    if !self.only_ends(target) {
                        range = range.start.min(target)..range.end.max(target);
                    }
                }
                _ if self.in_call() && self.returns(at) => range.end = range.end.max(self.end_of_body()?),
                _ => {}
            }
            at = if range.start < before.start { range.start } else { at + 1 };
        }
        Ok(range)
    }

    fn returns(&self, block: usize) -> bool {
        self.sources[self.source].program.block_words(block).iter().any(|word| word.is(b'M') && word.value == 99.0)
    }

    /// The block that ends the present subprogram. A value that it returns becomes unknown.
    fn end_of_body(&mut self) -> Result<usize, Fault> {
        let (source, start) = self.calls.last().map_or((0, 0), |call| call.body);
        if let Some(call) = self.calls.last_mut() {
            call.may_return = true;
        }
        let missing = || Fault::new("the end of this subprogram is missing");
        if source != self.source {
            return Err(missing());
        }
        let own = self.sources[source].statement(start.wrapping_sub(1));
        if let Some((label, Keyword::Sub)) = own.as_deref().and_then(Statement::labelled) {
            let end = self.sources[source].following(start - 1, label, &[Keyword::EndSub]);
            return end.map(|(block, _)| block).ok_or_else(missing);
        }
        let last = self.sources[source].program_around(start).rfind(|block| self.returns(*block));
        let last = last.ok_or_else(missing)?;
        if value_of(self.sources[source].program.block_words(last), b'P').is_some() {
            return Err(Fault::new("the program decides when it runs where this subprogram returns to"));
        }
        Ok(last)
    }

    /// Makes unknown what the blocks of `range`, and the subprograms called there, may assign.
    fn forget_assigned(&mut self, range: Range<usize>) -> Result<(), Fault> {
        let here = self.source;
        let (mut open, mut seen) = (vec![(here, range)], HashSet::new());
        let mut forgotten = Ok(());
        while let Some((source, range)) = open.pop().filter(|_| forgotten.is_ok()) {
            self.source = source;
            forgotten = range.into_iter().try_for_each(|block| {
                let called = self.forget_in(block)?;
                open.extend(called.filter(|(source, body)| seen.insert((*source, body.start))));
                Ok(())
            });
        }
        self.source = here;
        forgotten
    }

    /// Makes unknown what a block may assign. Returns source and blocks of a subprogram whose local parameters are those of its caller.
    fn forget_in(&mut self, block: usize) -> Result<Option<(usize, Range<usize>)>, Fault> {
        self.limit.count(&self.sources[self.source].program, block)?;
        let mut names = Vec::new();
        let source = &self.sources[self.source];
        let read = |text: &[u8]| assignment(text, &self.parameters, self.dialect).map_or(None, |(name, _)| name);
        for word in source.program.block_words(block).iter().filter(|word| word.kind == WordKind::Assignment) {
            names.push(read(source.program.text(word.span)));
        }
        let statement = source.statement(block);
        if let Some(Statement::If { then: Then::Assign(text), .. }) = statement.as_deref() {
            names.push(read(text));
        }
        for name in names {
            self.assign(name, Value::Unknown)?;
        }
        let Some(body) = self.called(block, statement.as_deref())? else { return Ok(None) };
        self.forget_unread(body.own_level || body.range.is_some());
        self.parameters.returned_unknown();
        Ok(body.range.filter(|_| !body.own_level).map(|range| (body.source, range)))
    }

    /// Records the words of `range`, and of the subprograms called in it.
    fn record(&mut self, range: Range<usize>, depth: usize) -> Result<(), Fault> {
        let here = self.block;
        let mut block = range.start;
        while block < range.end {
            self.limit.count(&self.sources[self.source].program, block)?;
            self.block = block;
            let statement = self.sources[self.source].statement(block);
            if let Some((label, Keyword::Sub)) = statement.as_deref().and_then(Statement::labelled) {
                let end = self.sources[self.source].following(block, label, &[Keyword::EndSub]);
                block = end.map_or(range.end, |(end, _)| end) + 1;
                continue;
            }
            let has_flow = statement.is_some();
            let called = self.called(block, statement.as_deref())?;
            let (words, _) = self.evaluated_words(false)?;
            match called {
                Some(Callee { range: Some(body), own_level, source }) if self.may_record((source, body.start), depth) => {
                    self.record_call(source, body, own_level, depth)?;
                }
                Some(_) => self.push(Some(&words), true),
                None if !has_flow && !words.is_empty() => self.push(Some(&words), true),
                None => {}
            }
            block += 1;
        }
        self.block = here;
        Ok(())
    }

    /// Whether a subprogram is recorded with its blocks: not within itself.
    fn may_record(&self, body: Body, depth: usize) -> bool {
        depth < DEEPEST_PERHAPS && self.calls.iter().skip(1).all(|call| call.body != body)
    }

    fn record_call(&mut self, source: usize, body: Range<usize>, own_level: bool, depth: usize) -> Result<(), Fault> {
        let (here, block) = (self.source, self.block);
        self.enter((source, body.start), 1, own_level.then(Vec::new))?;
        if own_level {
            self.parameters.forget_local();
        }
        let recorded = self.record(body, depth + 1);
        self.leave();
        (self.source, self.block) = (here, block);
        recorded
    }

    /// What a block calls.
    fn called(&mut self, block: usize, statement: Option<&Statement>) -> Result<Option<Callee>, Fault> {
        let here = std::mem::replace(&mut self.block, block);
        let (body, own_level) = match statement {
            Some(Statement::OWord { label, keyword: Keyword::Call, .. }) => (Some(self.subprogram(label)), true),
            Some(_) => (None, false),
            None => {
                let words = self.sources[self.source].program.block_words(block).to_vec();
                let is_macro = words.iter().any(|word| word.is(b'G') && word.value == 65.0);
                let calls = self.calls_by_code(&words);
                (calls.then(|| Ok(self.callee(&words))), is_macro)
            }
        };
        self.block = here;
        let Some(body) = body else { return Ok(None) };
        let Some((source, start)) = body? else { return Ok(Some(Callee { source: self.source, range: None, own_level })) };
        let of = &self.sources[source];
        let own = of.statement(start.wrapping_sub(1));
        let end = match own.as_deref().and_then(Statement::labelled) {
            Some((label, Keyword::Sub)) => of.following(start - 1, label, &[Keyword::EndSub]).map(|(end, _)| end),
            _ => Some(of.program_around(start).end),
        };
        Ok(Some(Callee { source, range: end.map(|end| start..end), own_level }))
    }

    /// An assignment under a condition: one that may move the frame is recorded.
    pub fn note_frame(&mut self, name: Option<&Name>) {
        if name.is_none_or(|name| self.parameters.moves_frame(name)) {
            let word =
                self.sources[self.source].flow_word(self.block).map(|word| self.sources[self.source].program.words()[word]);
            let word = word.map(|word| Word { kind: WordKind::Assignment, ..word });
            self.push(word.as_slice().into(), false);
        }
    }
}

/// A subprogram that may be called.
struct Callee {
    source: usize,
    /// Its blocks; `None` if it is not found.
    range: Option<Range<usize>>,
    /// Whether it has local parameters of its own.
    own_level: bool,
}
