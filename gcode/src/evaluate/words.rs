//! Blocks of words: the values of expressions, assignments.

use super::control::Next;
use super::expression::{Assigned, assignment, assignment_after, term};
use super::parameters::Name;
use super::run::Run;
use super::value::{Fault, Value};
use crate::dialect::Dialect;
use crate::word::{Word, WordKind};

/// Why an assignment that is more than a value for the program itself cannot be left out, and what to do.
pub(super) const LASTING: &str =
    "this assignment acts on the control or outlives the program: the program cannot be written without variables";
pub(super) const WITHOUT_EXPAND: &str = "do not expand it, or write out by hand what needs variables";
/// The same of a call.
const READS: &str = "the subprogram that is called here is not found, and may read what was assigned before: the program cannot be written \
                     without variables";

impl Run<'_> {
    /// Executes a block of words: assignments, codes, calls.
    pub fn execute_words(&mut self) -> Result<Next, Fault> {
        let (words, assigned) = self.evaluated_words(true)?;
        let alarm = assigned.iter().any(|(name, value)| self.is_alarm(name.as_ref(), *value));
        for (name, value) in assigned {
            self.assign(name, value)?;
        }
        if alarm {
            return Ok(Next::End);
        }
        self.execute_codes(words)
    }

    /// Fanuc's #3000 ends the program with an alarm.
    fn is_alarm(&self, name: Option<&Name>, value: Value) -> bool {
        self.dialect == Dialect::Fanuc && name == Some(&Name::Number(3000)) && value != Value::Number(0.0)
    }

    pub fn assign(&mut self, name: Option<Name>, value: Value) -> Result<(), Fault> {
        match name {
            Some(name) => {
                if self.parameters.outlives(&name) {
                    self.note_unwritable(LASTING);
                }
                self.assigns |= self.dialect == Dialect::Fanuc;
                self.parameters.set(name, value)
            }
            None => {
                self.parameters.forget_all();
                Ok(())
            }
        }
    }

    /// Notes a call of a subprogram that is not found, where parameters were assigned that it may read.
    pub fn note_read(&mut self) {
        if self.assigns {
            self.note_unwritable(READS);
        }
    }

    /// Notes the present block as one that a program without parameters cannot hold.
    pub fn note_unwritable(&mut self, message: &str) {
        if self.unwritable.is_none() {
            self.unwritable = Some(self.note(Fault::new(message).help(WITHOUT_EXPAND)));
        }
    }

    /// The words of the block with their values, without words of value null, and the assignments. `strict`: a faulty text is an error, not
    /// an unknown value.
    pub fn evaluated_words(&self, strict: bool) -> Result<(Vec<Word>, Vec<Assigned>), Fault> {
        let program = &self.sources[self.source].program;
        let (mut words, mut assigned) = (Vec::new(), Vec::new());
        for word in program.block_words(self.block) {
            match word.kind {
                WordKind::Expression => {
                    let value = term(program.text(word.value_span()), &self.parameters, self.dialect);
                    match value.or_else(|fault| if strict { Err(fault.at(word.span)) } else { Ok(Value::Unknown) })? {
                        Value::Number(value) => words.push(Word { value, ..*word }),
                        Value::Null => {}
                        Value::Unknown => words.push(*word),
                    }
                }
                WordKind::Assignment => {
                    let text = program.text(word.span);
                    let read = assignment(text, &self.parameters, self.dialect);
                    let (name, mut value) = match read {
                        Ok(read) => read,
                        Err(fault) if strict => return Err(fault.at(word.span)),
                        Err(_) => (None, Value::Unknown),
                    };
                    // LinuxCNC reads the block before it assigns. No manual states it for several assignments on Fanuc.
                    if self.dialect == Dialect::Fanuc && !assigned.is_empty() {
                        let after = assignment_after(&assigned, text, &self.parameters, self.dialect).ok();
                        if after != Some((name.clone(), value)) {
                            value = Value::Unknown;
                        }
                    }
                    if name.as_ref().is_none_or(|name| self.parameters.moves_frame(name)) {
                        words.push(*word);
                    }
                    assigned.push((name, value));
                }
                _ => words.push(*word),
            }
        }
        if self.dialect == Dialect::Fanuc && !assigned.is_empty() {
            words.iter_mut().filter(|word| word.kind == WordKind::Expression).for_each(|word| word.value = f64::NAN);
        }
        Ok((words, assigned))
    }
}
