//! Calls of subprograms by name, by L number, by CALL and EXTCALL ("Subprogram technique").

use std::borrow::Cow;
use std::ops::Range;

use super::expression::{arguments, evaluate};
use super::run::{Arguments, Run};
use super::source::Source;
use super::statement::{Parameter, parameters, program_name, saves};
use super::variables::{Kind, Name};
use crate::evaluate::control::Next;
use crate::evaluate::value::{Fault, Value};
use crate::program::{Language, parse_in};
use crate::sinumerik::names::Name as Meaning;
use crate::sinumerik::scan::{bracket_end, name};
use crate::word::{Word, WordKind};

/// A call as it is written.
#[derive(Clone, Debug)]
pub(super) struct Written {
    pub name: String,
    /// Text in the parentheses.
    pub arguments: Vec<u8>,
}

impl Run<'_> {
    /// The call of the present block: a name that is not known or an L number, with nothing but a block number, a label and P.
    pub(super) fn call_of_block(&self) -> Option<Written> {
        let program = &self.sources[self.source].program;
        let words = program.block_words(self.block);
        let is_call = |word: &Word| word.kind == WordKind::Unknown || word.is(b'L');
        let at = words.iter().position(is_call)?;
        let beside = |(index, word): (usize, &Word)| {
            index == at
                || word.is(b'N')
                || word.is(b'P')
                || matches!(word.kind, WordKind::Comment | WordKind::BlockDelete)
                || word.name == Meaning::Label
        };
        if !words.iter().enumerate().all(beside) {
            return None;
        }
        let text = program.text(words[at].span);
        let own = name(text, 0);
        if own.len() < 2 || own[0].is_ascii_digit() {
            return None;
        }
        let rest = text[own.len()..].trim_ascii();
        let inside = match rest.first() {
            None => &[][..],
            Some(b'(') if bracket_end(rest, 0) == rest.len() => rest.get(1..rest.len().saturating_sub(1)).unwrap_or_default(),
            Some(_) => return None,
        };
        let name = String::from_utf8_lossy(own).to_ascii_uppercase();
        Some(Written { name, arguments: inside.trim_ascii().to_vec() })
    }

    /// Executes a call. A subprogram that is not found is recorded as it stands.
    pub(super) fn call(&mut self, call: Written, words: &[Word]) -> Result<Next, Fault> {
        let times = match words.iter().find(|word| word.is(b'P')) {
            None => Some(1),
            Some(word) => word.number().filter(|n| n.fract() == 0.0 && (0.0..=9999.0).contains(n)).map(|n| n as u32),
        };
        let body = self.subprogram(&call.name);
        let (Some((source, body)), Some(times)) = (body, times) else {
            self.push(Some(words), false);
            self.variables.forget_global();
            return Ok(Next::Following);
        };
        let Some(arguments) = self.arguments(source, &body, &call.arguments)? else {
            self.push(Some(words), false);
            self.variables.forget_all();
            return Ok(Next::Following);
        };
        self.enter(source, body, times, Some(arguments))
    }

    /// CALL, EXTCALL and PCALL of a fixed name.
    pub(super) fn call_by_name(&mut self, name: &str, written: &[u8], flow: usize) -> Result<Next, Fault> {
        let inside = written.strip_prefix(b"(").and_then(|rest| rest.strip_suffix(b")")).unwrap_or_default();
        if let Some((source, body)) = self.subprogram(name)
            && let Some(arguments) = self.arguments(source, &body, inside.trim_ascii())?
        {
            return self.enter(source, body, 1, Some(arguments));
        }
        self.push_flow(flow, false);
        self.variables.forget_global();
        Ok(Next::Following)
    }

    /// Records a statement that is not evaluated.
    pub(super) fn push_flow(&mut self, flow: usize, perhaps: bool) {
        let word = self.sources[self.source].program.words()[flow];
        self.push(Some(&[word]), perhaps);
    }

    /// Blocks of a subprogram: of the present file or of the main file if they are archives, else of a file of its own.
    pub(super) fn subprogram(&mut self, name: &str) -> Option<(usize, Range<usize>)> {
        let known = (0..self.sources.len()).map(|k| (self.source + k) % self.sources.len());
        for source in known {
            if let Some(body) = self.sources[source].program_named(name) {
                return Some((source, body));
            }
            let file = &self.sources[source].name;
            if source > 0 && program_name(&file.to_ascii_uppercase()) == name {
                return Some((source, self.sources[source].first_program()));
            }
        }
        let lower = name.to_lowercase();
        let files = [
            format!("{name}.SPF"),
            format!("{name}.spf"),
            format!("{lower}.spf"),
            format!("{name}.MPF"),
            format!("{name}.mpf"),
            format!("{lower}.mpf"),
            format!("_N_{name}_SPF"),
            format!("_N_{name}_MPF"),
        ];
        for file in files {
            if let Some(bytes) = self.library.read(&file) {
                let program = parse_in(bytes, Language::Sinumerik);
                self.sources.push(Source::new(file, Cow::Owned(program)));
                let source = self.sources.len() - 1;
                return Some((source, self.sources[source].first_program()));
            }
        }
        None
    }

    /// The PROC statement of a subprogram.
    fn procedure(&self, source: usize, body: &Range<usize>) -> Option<usize> {
        let source = &self.sources[source];
        source.flow_word(source.procedure(body)?)
    }

    /// The PROC statement of a subprogram with SAVE, as a word that is not known: which modes it restores is not followed.
    pub(super) fn saving_statement(&self, source: usize, body: &Range<usize>) -> Option<Word> {
        let program = &self.sources[source].program;
        let word = program.words()[self.procedure(source, body)?];
        saves(program.text(word.span)).then_some(Word { kind: WordKind::Unknown, ..word })
    }

    /// Values of the parameters of a subprogram; `None` if they are not understood.
    fn arguments(&self, source: usize, body: &Range<usize>, written: &[u8]) -> Result<Option<Arguments>, Fault> {
        let program = &self.sources[source].program;
        let declared = match self.procedure(source, body) {
            Some(word) => parameters(program.text(program.words()[word].span)),
            None => Some(Vec::new()),
        };
        let given = if written.is_empty() { Vec::new() } else { arguments(written) };
        let Some(declared) = declared.filter(|declared| declared.len() >= given.len()) else { return Ok(None) };
        let mut out = Arguments::default();
        for (index, Parameter { kind, name, default, returns }) in declared.into_iter().enumerate() {
            let text = given.get(index).copied().filter(|text| !text.is_empty());
            let value = match (text, &default) {
                (Some(text), _) => self.argument(text, kind)?,
                (None, Some(text)) => self.argument(text, kind)?,
                (None, None) => Value::Number(0.0),
            };
            if let (true, Some(text)) = (returns, text)
                && let Ok(target) = self.variable(text)
            {
                out.returns.push((name.clone(), target));
            }
            out.values.push((kind, name, value));
        }
        Ok(Some(out))
    }

    fn argument(&self, text: &[u8], kind: Kind) -> Result<Value, Fault> {
        if kind == Kind::Other { Ok(Value::Unknown) } else { evaluate(text, &self.variables) }
    }

    /// Variables that a subprogram returns to its caller become unknown.
    pub(super) fn forget_arguments(&mut self, written: &[u8]) {
        for text in arguments(written) {
            if let Ok(target) = self.variable(text) {
                self.variables.set(&target, Value::Unknown);
            }
        }
    }

    /// A variable by its text.
    pub(super) fn variable(&self, text: &[u8]) -> Result<Name, Fault> {
        Ok(super::expression::target(&[text, b"="].concat(), &self.variables)?.0)
    }
}
