//! Macro statements of Fanuc: IF, GOTO, WHILE, DO, END; and the choice between them and O-words.

use super::control::Next;
use super::expression::{assignment, term};
use super::run::Run;
use super::statement::{Statement, Then};
use super::value::Fault;
use crate::sinumerik::signs::{SINUMERIK_HELP, is_likely};

impl Run<'_> {
    /// Executes the flow statement in the word `flow`.
    pub fn execute_statement(&mut self, flow: usize) -> Result<Next, Fault> {
        let program = &self.sources[self.source].program;
        let span = program.words()[flow].span;
        let Some(statement) = self.sources[self.source].statement(self.block) else { return Ok(Next::Following) };
        let next = match &*statement {
            Statement::OWord { label, keyword, arguments } => self.execute_o_word(label, *keyword, arguments),
            Statement::If { condition, then } => self.execute_if(condition, then),
            Statement::While { condition, .. } => self.execute_while(condition),
            Statement::Do { .. } => self.loop_end().map(|_| Next::Following),
            Statement::End { .. } => self.loop_end().map(Next::At),
            Statement::Goto(target) => self.target(target).map(Next::At),
            Statement::NotUnderstood => {
                let line = program.blocks().get(self.block).map_or(&[][..], |block| program.text(block.span));
                let help = if is_likely(line) { SINUMERIK_HELP } else { "write the program without it" };
                Err(Fault::new("this statement is not understood").help(help))
            }
        };
        next.map_err(|fault| fault.at(span))
    }

    fn target(&mut self, text: &[u8]) -> Result<usize, Fault> {
        self.jump_target(term(text, &self.parameters, self.dialect)?.number())
    }

    fn loop_end(&self) -> Result<usize, Fault> {
        self.sources[self.source].loop_end(self.block).ok_or_else(|| Fault::new("the other end of this loop is missing"))
    }

    fn execute_if(&mut self, condition: &[u8], then: &Then) -> Result<Next, Fault> {
        let holds = term(condition, &self.parameters, self.dialect)?.number().map(|value| value != 0.0);
        match (then, holds) {
            (_, Some(false)) => Ok(Next::Following),
            (Then::Goto(target), Some(true)) => self.target(target).map(Next::At),
            (Then::Goto(target), None) => {
                let target = self.target(target)?;
                self.perhaps_jump(target)
            }
            (Then::Assign(text), _) => {
                let (name, value) = assignment(text, &self.parameters, self.dialect)?;
                let value = if holds.is_some() { value } else { super::value::Value::Unknown };
                self.note_frame(name.as_ref());
                self.assign(name, value)?;
                Ok(Next::Following)
            }
        }
    }

    fn execute_while(&mut self, condition: &[u8]) -> Result<Next, Fault> {
        let end = self.loop_end()?;
        match term(condition, &self.parameters, self.dialect)?.number().map(|value| value != 0.0) {
            Some(true) => Ok(Next::Following),
            Some(false) => Ok(Next::At(end + 1)),
            None => self.perhaps(self.block + 1..end, end + 1),
        }
    }
}
