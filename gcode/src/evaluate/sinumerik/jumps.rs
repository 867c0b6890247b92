//! Branches, loops, jumps, repeated sections and definitions ("Check structures", "Program jumps", "Program section repetition").

use super::expression::evaluate;
use super::run::Run;
use super::statement::{Direction, Jump, Statement, items};
use super::variables::{Kind, Name};
use crate::evaluate::control::Next;
use crate::evaluate::value::{Fault, Value};

impl Run<'_> {
    /// Executes the flow statement in the word `flow`.
    pub(super) fn execute_statement(&mut self, flow: usize) -> Result<Next, Fault> {
        let span = self.sources[self.source].program.words()[flow].span;
        let Some(statement) = self.sources[self.source].shared_statement(self.block) else { return Ok(Next::Following) };
        let next = match &*statement {
            Statement::If { condition } => self.branch(condition),
            // Reached from above: the branch before ran.
            Statement::Else => self.partner().map(|end| Next::At(end + 1)),
            Statement::EndIf | Statement::Loop | Statement::Repeat | Statement::Procedure => Ok(Next::Following),
            Statement::While { condition } => self.repeat_while(condition),
            Statement::EndWhile => self.partner().map(Next::At),
            Statement::EndLoop => self.partner().map(|head| Next::At(head + 1)),
            Statement::Until { condition } => self.repeat_until(condition),
            Statement::For { variable, from, to } => self.start_count(variable, from, to),
            Statement::EndFor => self.count_on(),
            Statement::Again { start, end, times, is_block } => self.repeat_section(start, end.as_deref(), times, *is_block),
            Statement::Jump { condition, jump } => self.jump_if(condition.as_deref(), jump),
            Statement::Case { of, choices } => self.choose(of, choices),
            Statement::Define { kind, items } => self.define(*kind, items),
            Statement::Call { name, arguments } => self.call_by_name(name, arguments, flow),
            Statement::Return => Ok(self.end_program()),
            Statement::NotUnderstood => {
                self.push_flow(flow, false);
                self.variables.forget_all();
                Ok(Next::Following)
            }
        };
        next.map_err(|fault| fault.at(span))
    }

    fn value(&self, text: &[u8]) -> Result<Option<f64>, Fault> {
        Ok(evaluate(text, &self.variables)?.number())
    }

    /// Whether a condition holds; `None` if it is unknown.
    fn holds(&self, text: &[u8]) -> Result<Option<bool>, Fault> {
        Ok(self.value(text)?.map(|value| value != 0.0))
    }

    fn partner(&self) -> Result<usize, Fault> {
        let found = self.sources[self.source].partner(self.block);
        found.ok_or_else(|| Fault::new("the other end of this statement is missing"))
    }

    fn branch(&mut self, condition: &[u8]) -> Result<Next, Fault> {
        let next = self.partner()?;
        let source = &self.sources[self.source];
        let end = match source.statement(next) {
            Some(Statement::Else) => source.partner(next).ok_or_else(|| Fault::new("ENDIF is missing"))?,
            _ => next,
        };
        match self.holds(condition)? {
            Some(true) => Ok(Next::Following),
            Some(false) => Ok(Next::At(next + 1)),
            None => self.perhaps(self.block + 1..end, end + 1),
        }
    }

    fn repeat_while(&mut self, condition: &[u8]) -> Result<Next, Fault> {
        let end = self.partner()?;
        match self.holds(condition)? {
            Some(true) => Ok(Next::Following),
            Some(false) => Ok(Next::At(end + 1)),
            None => self.perhaps(self.block + 1..end, end + 1),
        }
    }

    fn repeat_until(&mut self, condition: &[u8]) -> Result<Next, Fault> {
        let head = self.partner()?;
        match self.holds(condition)? {
            Some(true) => Ok(Next::Following),
            Some(false) => Ok(Next::At(head + 1)),
            None => self.perhaps(head + 1..self.block, self.block + 1),
        }
    }

    fn start_count(&mut self, variable: &[u8], from: &[u8], to: &[u8]) -> Result<Next, Fault> {
        let end = self.partner()?;
        let name = self.variable(variable)?;
        let from = evaluate(from, &self.variables)?;
        self.variables.set(&name, from);
        self.pass(&name, to, self.block + 1, end)
    }

    /// ENDFOR: the next pass, while the counter does not exceed the end value.
    fn count_on(&mut self) -> Result<Next, Fault> {
        let (head, end) = (self.partner()?, self.block);
        let statement = self.sources[self.source].shared_statement(head);
        let Some(Statement::For { variable, to, .. }) = statement.as_deref() else {
            return Err(Fault::new("FOR is missing"));
        };
        let name = self.variable(variable)?;
        let next = self.variables.get(&name).number().map_or(Value::Unknown, |value| Value::Number(value + 1.0));
        self.variables.set(&name, next);
        self.pass(&name, to, head + 1, end)
    }

    fn pass(&mut self, counter: &Name, to: &[u8], body: usize, end: usize) -> Result<Next, Fault> {
        match (self.variables.get(counter).number(), self.value(to)?) {
            (Some(at), Some(last)) if at <= last => Ok(Next::At(body)),
            (Some(_), Some(_)) => Ok(Next::At(end + 1)),
            _ => {
                self.variables.set(counter, Value::Unknown);
                self.perhaps(body..end, end + 1)
            }
        }
    }

    /// The block to which a jump leads.
    pub(super) fn place(&mut self, jump: &Jump) -> Result<usize, Fault> {
        if jump.target.is_empty() {
            return Err(Fault::new("the target of this jump is not known before the program runs"));
        }
        let body = self.program_body();
        let found = self.sources[self.source].place(&jump.target, self.block, jump.direction, &body);
        let found = found.ok_or_else(|| Fault::new(format!("there is no {} to jump to", jump.target)))?;
        if self.source == 0 {
            self.targets.insert(found);
        }
        Ok(found)
    }

    fn jump_if(&mut self, condition: Option<&[u8]>, jump: &Jump) -> Result<Next, Fault> {
        match condition.map_or(Ok(Some(true)), |text| self.holds(text))? {
            Some(false) => Ok(Next::Following),
            Some(true) => self.jump(jump),
            None => {
                let target = self.place(jump)?;
                self.perhaps_jump(target)
            }
        }
    }

    fn jump(&mut self, jump: &Jump) -> Result<Next, Fault> {
        let target = self.place(jump)?;
        self.check_section(target)?;
        Ok(Next::At(target))
    }

    /// A jump out of a section that is being repeated is not followed.
    fn check_section(&self, target: usize) -> Result<(), Fault> {
        let section = self.calls.last().filter(|call| call.arguments.is_none() && self.calls.len() > 1);
        match section {
            Some(section) if !section.body.contains(&target) => Err(Fault::new("this jump leaves a section that is repeated")),
            _ => Ok(()),
        }
    }

    fn choose(&mut self, of: &[u8], choices: &[(Option<Vec<u8>>, Jump)]) -> Result<Next, Fault> {
        let Some(value) = self.value(of)? else {
            let jumps: Vec<Jump> = choices.iter().map(|(_, jump)| jump.clone()).collect();
            let targets: Result<Vec<usize>, Fault> = jumps.iter().map(|jump| self.place(jump)).collect();
            return self.give_up(targets?.into_iter().min());
        };
        for (constant, jump) in choices {
            let matches = match constant {
                Some(text) => self.value(text)? == Some(value),
                None => true,
            };
            if matches {
                return self.jump(jump);
            }
        }
        Ok(Next::Following)
    }

    /// REPEAT and REPEATB. The section ends before this statement, at its end label with that block, or at ENDLABEL.
    fn repeat_section(&mut self, start: &str, end: Option<&str>, times: &[u8], is_block: bool) -> Result<Next, Fault> {
        let place = |run: &Self, target: &str, from: usize, direction: Direction| {
            let found = run.sources[run.source].place(target, from, direction, &run.program_body());
            found.ok_or_else(|| Fault::new(format!("there is no label {target}")))
        };
        let here = self.block;
        let first = place(self, start, here, Direction::Backward).or_else(|_| place(self, start, here, Direction::Forward))?;
        let last = match end {
            _ if is_block => first + 1,
            Some(end) => place(self, end, first.saturating_sub(1), Direction::Forward)? + 1,
            None => match place(self, "ENDLABEL", first, Direction::Forward) {
                Ok(end) if end < here || first > here => end,
                _ if first < here => here,
                _ => return Err(Fault::new("the end of this section is missing")),
            },
        };
        if (first..last).contains(&here) {
            return Err(Fault::new("a section that repeats itself"));
        }
        let Some(times) = self.value(times)?.filter(|n| n.fract() == 0.0 && (0.0..=9999.0).contains(n)) else {
            return self.perhaps(first..last, here + 1);
        };
        if self.source == 0 {
            self.targets.insert(first);
        }
        self.enter(self.source, first..last, times as u32, None)
    }

    fn define(&mut self, kind: Kind, text: &[u8]) -> Result<Next, Fault> {
        for (name, initial) in items(text) {
            self.variables.define(&name, kind);
            let value = match initial {
                None => continue,
                Some(_) if kind == Kind::Other => continue,
                // The values of an array.
                Some(text) if text.is_empty() => {
                    self.variables.set(&Name { base: name, index: None }, Value::Unknown);
                    continue;
                }
                Some(text) => evaluate(&text, &self.variables)?,
            };
            self.variables.set(&Name::plain(name), value);
        }
        Ok(Next::Following)
    }
}
