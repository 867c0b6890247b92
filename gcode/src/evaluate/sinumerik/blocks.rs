//! Blocks of words: the values of expressions, assignments, ends.

use super::expression::{evaluate, evaluate_after, target};
use super::run::Run;
use super::variables::Name;
use crate::evaluate::control::Next;
use crate::evaluate::value::{Fault, Value};
use crate::evaluate::words::{LASTING, WITHOUT_EXPAND};
use crate::word::{Word, WordKind};

/// Targets and values of the assignments of a block.
type Assigned = Vec<(Name, Value)>;

impl Run<'_> {
    /// Executes a block of words: assignments, codes, calls. `perhaps`: a switch may skip it.
    pub(super) fn execute_words(&mut self, perhaps: bool) -> Result<Next, Fault> {
        let (words, assigned) = self.evaluated_words(!perhaps)?;
        if self.unwritable.is_none() && assigned.iter().any(|(name, _)| name.acts()) {
            self.unwritable = Some(self.note(Fault::new(LASTING).help(WITHOUT_EXPAND)));
        }
        for (name, value) in assigned {
            self.variables.set(&name, if perhaps { Value::Unknown } else { value });
        }
        if let Some(call) = self.call_of_block() {
            if perhaps {
                let fault = Fault::new("a call in a block that a switch may skip");
                return Err(fault.help("state the position of the switch (--block-delete)"));
            }
            return self.call(call, &words);
        }
        let is_end = |word: &Word| word.letter == b'M' && word.number().is_some_and(|n| [2.0, 17.0, 30.0].contains(&n));
        let ends = !perhaps && words.iter().any(is_end);
        // In a subprogram these words return to the caller.
        let returns = ends && self.in_subprogram();
        let kept: Vec<Word> = words.into_iter().filter(|word| !(returns && is_end(word))).collect();
        if !kept.is_empty() {
            self.push(Some(&kept), perhaps);
        }
        Ok(if ends { self.end_program() } else { Next::Following })
    }

    /// The words of the block with their values, and the assignments. `strict`: a faulty text is an error, not an unknown value.
    pub(super) fn evaluated_words(&self, strict: bool) -> Result<(Vec<Word>, Assigned), Fault> {
        let program = &self.sources[self.source].program;
        let (mut words, mut assigned): (Vec<Word>, Assigned) = (Vec::new(), Vec::new());
        for word in program.block_words(self.block) {
            match word.kind {
                WordKind::Expression => {
                    let value = evaluate(program.text(word.value_span()), &self.variables);
                    let value = match value {
                        Ok(value) => value,
                        Err(fault) if strict => return Err(fault.at(word.span)),
                        Err(_) => Value::Unknown,
                    };
                    words.push(Word { value: value.number().unwrap_or(f64::NAN), ..*word });
                }
                WordKind::Assignment => {
                    let (name, value) = match self.assignment(word, &assigned) {
                        Ok(read) => read,
                        Err(fault) if strict => return Err(fault.at(word.span)),
                        Err(_) => continue,
                    };
                    if name.moves_frame() {
                        words.push(*word);
                    } else if self.may_be_axis(&name) {
                        words.push(Word { kind: WordKind::Unknown, ..*word });
                    }
                    assigned.push((name, value));
                }
                _ => words.push(*word),
            }
        }
        if !assigned.is_empty() {
            words.iter_mut().filter(|word| word.kind == WordKind::Expression).for_each(|word| word.value = f64::NAN);
        }
        Ok((words, assigned))
    }

    /// Whether a name that the program does not define may be an axis of the machine or a function such as TOFF or FXS: variables of the control
    /// begin with an underscore, and stand in no block with codes.
    fn may_be_axis(&self, name: &Name) -> bool {
        let program = &self.sources[self.source].program;
        let is_aside = |word: &Word| word.is(b'N') || !matches!(word.kind, WordKind::Number | WordKind::Expression);
        let is_alone = program.block_words(self.block).iter().all(is_aside);
        !(name.base.starts_with('$') || self.variables.is_defined(name) || is_alone && name.base.starts_with('_'))
    }

    /// Target and value of an assignment. Its value is unknown if it reads what the block assigned before: no manual states the order.
    fn assignment(&self, word: &Word, assigned: &[(Name, Value)]) -> Result<(Name, Value), Fault> {
        let text = self.sources[self.source].program.text(word.span);
        let (name, value) = target(text, &self.variables)?;
        let before = self.assigned_value(&name, value, &[])?;
        let is_same = assigned.is_empty() || self.assigned_value(&name, value, assigned)? == before;
        Ok((name, if is_same { before } else { Value::Unknown }))
    }

    /// The value of an assignment. Those of system variables are not evaluated: they may be frames or strings.
    fn assigned_value(&self, name: &Name, text: &[u8], assigned: &[(Name, Value)]) -> Result<Value, Fault> {
        if name.base.starts_with('$') {
            return Ok(Value::Unknown);
        }
        match evaluate_after(assigned, text, &self.variables) {
            // A list of values or the chain of frames.
            Err(_) if text.contains(&b':') || text.contains(&b',') => Ok(Value::Unknown),
            value => value,
        }
    }
}
