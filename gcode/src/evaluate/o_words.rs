//! O-words of LinuxCNC: branches, loops, subprograms.

use super::control::Next;
use super::expression::{brackets, term};
use super::run::{Body, Run};
use super::statement::{Keyword, Label};
use super::value::{Fault, Value};
use crate::dialect::Dialect;

/// Keywords that end or part a branch.
const BRANCHES: &[Keyword] = &[Keyword::ElseIf, Keyword::Else, Keyword::EndIf];
/// Keywords that begin a loop, and those that end one.
const LOOPS: &[Keyword] = &[Keyword::While, Keyword::Do, Keyword::Repeat];
const LOOP_ENDS: &[Keyword] = &[Keyword::While, Keyword::EndWhile, Keyword::EndRepeat];
/// Number of arguments of a call.
const MOST_ARGUMENTS: usize = 30;

impl Run<'_> {
    /// Executes an O-word.
    pub fn execute_o_word(&mut self, label: &Label, keyword: Keyword, arguments: &[u8]) -> Result<Next, Fault> {
        if keyword == Keyword::Call {
            return self.call(label, arguments);
        }
        let Label::Fixed(label) = label else { return Err(Fault::new("only a call may compute its label")) };
        match keyword {
            Keyword::Sub => Ok(Next::At(self.end(label, &[Keyword::EndSub])? + 1)),
            Keyword::EndSub | Keyword::Return => self.return_value(arguments),
            Keyword::If => self.branch(label, arguments),
            // Reached from above: the branch before ran.
            Keyword::ElseIf | Keyword::Else => Ok(Next::At(self.end(label, &[Keyword::EndIf])? + 1)),
            Keyword::EndIf | Keyword::Do => Ok(Next::Following),
            Keyword::While => self.repeat_while(label, arguments),
            Keyword::EndWhile => self.start(label).map(Next::At),
            Keyword::Repeat => self.repeat(label, arguments),
            Keyword::EndRepeat => self.start(label).map(Next::At),
            Keyword::Break | Keyword::Continue => self.leave_pass(label, keyword),
            Keyword::Call => Ok(Next::Following),
        }
    }

    /// The next block with this label and one of these keywords.
    fn end(&self, label: &[u8], keywords: &[Keyword]) -> Result<usize, Fault> {
        let found = self.sources[self.source].following(self.block, label, keywords);
        found.map(|(block, _)| block).ok_or_else(|| Fault::new("the end of this statement is missing"))
    }

    /// The block that begins the loop with this label.
    fn start(&self, label: &[u8]) -> Result<usize, Fault> {
        let found = self.sources[self.source].preceding(self.block, label, LOOPS);
        found.map(|(block, _)| block).ok_or_else(|| Fault::new("the start of this loop is missing"))
    }

    /// The value of a condition: whether it holds; `None` if it is unknown.
    fn condition(&self, text: &[u8]) -> Result<Option<bool>, Fault> {
        Ok(term(text, &self.parameters, self.dialect)?.number().map(|value| value != 0.0))
    }

    fn branch(&mut self, label: &[u8], arguments: &[u8]) -> Result<Next, Fault> {
        let last = self.end(label, &[Keyword::EndIf])?;
        let (mut at, mut keyword, mut arguments) = (self.block, Keyword::If, arguments.to_vec());
        while keyword != Keyword::EndIf {
            match if keyword == Keyword::Else { Some(true) } else { self.condition(&arguments)? } {
                Some(true) => return Ok(Next::At(at + 1)),
                None => return self.perhaps(self.block + 1..last, last),
                Some(false) => {}
            }
            let source = &self.sources[self.source];
            let Some(next) = source.following(at, label, BRANCHES) else { break };
            (at, keyword) = next;
            arguments = match source.statement(at).as_deref() {
                Some(super::statement::Statement::OWord { arguments, .. }) => arguments.clone(),
                _ => Vec::new(),
            };
        }
        Ok(Next::At(last + 1))
    }

    /// The head of a `while` loop, or the end of a `do` loop.
    fn repeat_while(&mut self, label: &[u8], arguments: &[u8]) -> Result<Next, Fault> {
        let source = &self.sources[self.source];
        let of_do = source.preceding(self.block, label, LOOPS).filter(|(_, keyword)| *keyword == Keyword::Do);
        let holds = self.condition(arguments)?;
        if let Some((start, _)) = of_do {
            let left = std::mem::take(&mut self.quirks.broke_while);
            if left && holds != Some(false) {
                let message = "LinuxCNC 2.9 leaves this do loop, because a while loop with a break ended before";
                return Err(Fault::new(message).help("end the while loop by its condition alone"));
            }
            return match holds {
                Some(true) => Ok(Next::At(start + 1)),
                Some(false) => Ok(Next::Following),
                None => self.perhaps(start + 1..self.block, self.block + 1),
            };
        }
        let end = self.end(label, &[Keyword::EndWhile])?;
        match holds {
            Some(true) => Ok(Next::Following),
            Some(false) => {
                let has_break = self.sources[self.source].following(self.block, label, &[Keyword::Break]);
                self.quirks.broke_while |= has_break.is_some_and(|(at, _)| at < end);
                Ok(Next::At(end + 1))
            }
            None => self.perhaps(self.block + 1..end, end + 1),
        }
    }

    fn repeat(&mut self, label: &[u8], arguments: &[u8]) -> Result<Next, Fault> {
        let (block, end) = (self.block, self.end(label, &[Keyword::EndRepeat])?);
        let begun = self.calls.last().and_then(|call| call.passes.get(&block).copied());
        let left = match begun {
            Some(left) => left,
            None => match term(arguments, &self.parameters, self.dialect)?.number() {
                Some(number) => number.round().max(0.0) as u64,
                None => return self.perhaps(block + 1..end, end + 1),
            },
        };
        let Some(call) = self.calls.last_mut() else { return Ok(Next::End) };
        if left == 0 {
            call.passes.remove(&block);
            call.pass_changes += 1;
            return Ok(Next::At(end + 1));
        }
        if self.quirks.continued_do {
            let message = "LinuxCNC 2.9 repeats this loop twice as often, because a do loop was continued before";
            return Err(Fault::new(message).help("write the do loop without continue"));
        }
        call.passes.insert(block, left - 1);
        call.pass_changes += 1;
        Ok(Next::Following)
    }

    fn leave_pass(&mut self, label: &[u8], keyword: Keyword) -> Result<Next, Fault> {
        let (start, end) = (self.start(label)?, self.end(label, LOOP_ENDS)?);
        if keyword == Keyword::Continue {
            let is_do =
                self.sources[self.source].following(self.block, label, LOOP_ENDS).map(|(_, end)| end) == Some(Keyword::While);
            self.quirks.continued_do |= is_do;
            return Ok(Next::At(if is_do { end } else { start }));
        }
        if let Some(call) = self.calls.last_mut() {
            call.pass_changes += u64::from(call.passes.remove(&start).is_some());
        }
        self.quirks.broke_while |=
            matches!(self.sources[self.source].following(self.block, label, LOOP_ENDS), Some((_, Keyword::EndWhile)));
        Ok(Next::At(end + 1))
    }

    /// Start and end of the loop with this label around the block `at`.
    pub fn loop_around(&self, at: usize, label: &[u8]) -> Option<(usize, usize)> {
        let source = &self.sources[self.source];
        Some((source.preceding(at, label, LOOPS)?.0, source.following(at, label, LOOP_ENDS)?.0))
    }

    fn return_value(&mut self, arguments: &[u8]) -> Result<Next, Fault> {
        if !self.in_call() {
            return Err(Fault::new("this statement is not in a subprogram that was called"));
        }
        let value = match arguments {
            [] => None,
            text => Some(term(text, &self.parameters, self.dialect)?),
        };
        let may_return = self.calls.last().is_some_and(|call| call.may_return);
        self.parameters.returned(value);
        if may_return {
            self.parameters.returned_unknown();
        }
        Ok(self.leave())
    }

    fn call(&mut self, label: &Label, arguments: &[u8]) -> Result<Next, Fault> {
        let values = brackets(arguments, &self.parameters, self.dialect)?;
        if values.len() > MOST_ARGUMENTS {
            return Err(Fault::new(format!("a call with more than {MOST_ARGUMENTS} arguments")));
        }
        let Some(body) = self.subprogram(label)? else {
            self.push(None, false);
            self.parameters.forget_global();
            return Ok(Next::Following);
        };
        let values = (1..).zip(values).collect();
        self.enter(body, 1, Some(values))
    }

    /// First block of the body of a subprogram: in this file, in one that was read, or in a file of its own. `None` if it is not found.
    pub fn subprogram(&mut self, label: &Label) -> Result<Option<Body>, Fault> {
        let label = match label {
            Label::Fixed(label) => label.clone(),
            Label::Computed(text) => match term(text, &self.parameters, Dialect::LinuxCnc)? {
                Value::Number(number) => format!("{}", number.round()).into_bytes(),
                _ => return Ok(None),
            },
        };
        let known = (0..self.sources.len()).map(|k| (self.source + k) % self.sources.len());
        let found = known.into_iter().find_map(|source| Some((source, self.body(source, &label)?)));
        if found.is_some() {
            return Ok(found);
        }
        let name = format!("{}.ngc", String::from_utf8_lossy(&label).to_lowercase());
        Ok(self.file(&[name]).and_then(|source| Some((source, self.body(source, &label)?))))
    }

    fn body(&self, source: usize, label: &[u8]) -> Option<usize> {
        let found = self.sources[source].labelled(label).iter().find(|(_, keyword)| *keyword == Keyword::Sub);
        found.map(|(block, _)| block + 1)
    }
}
