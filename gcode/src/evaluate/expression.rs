//! Expressions: read and evaluated in one pass.

use std::borrow::Cow;

use super::arithmetic::{Operator, atan2, function, power};
use super::parameters::{Name, Parameters};
use super::value::{Fault, Value};
use crate::dialect::Dialect;
use crate::number::{is_blank, scan_number};

/// Largest depth of brackets, functions and `##`. It bounds the stack.
const DEEPEST: usize = 64;
/// Distance from a whole number within which a parameter number is accepted, as on LinuxCNC.
const WHOLE: f64 = 1e-4;

/// A text in upper case without blanks and comments. Blanks have no meaning, names are the same in either case.
pub(crate) fn packed(text: &[u8]) -> Cow<'_, [u8]> {
    if !text.iter().any(|byte| is_blank(*byte) || byte.is_ascii_lowercase() || matches!(byte, b'(' | b')')) {
        return Cow::Borrowed(text);
    }
    let mut out = Vec::with_capacity(text.len());
    let mut in_comment = false;
    for byte in text {
        match byte {
            b'(' => in_comment = true,
            b')' if in_comment => in_comment = false,
            _ if in_comment || is_blank(*byte) => {}
            _ => out.push(byte.to_ascii_uppercase()),
        }
    }
    Cow::Owned(out)
}

/// The value of a term, as behind an address letter: `#1`, `[#1+2]`, `-SIN[30]`, `1.5`.
pub(crate) fn term(text: &[u8], parameters: &Parameters, dialect: Dialect) -> Result<Value, Fault> {
    let text = packed(text);
    let mut reader = Reader::new(&text, parameters, dialect);
    let value = reader.term()?;
    reader.end()?;
    Ok(value)
}

/// The values of bracketed expressions that follow each other: the arguments of a call, a condition.
pub(crate) fn brackets(text: &[u8], parameters: &Parameters, dialect: Dialect) -> Result<Vec<Value>, Fault> {
    let text = packed(text);
    let mut reader = Reader::new(&text, parameters, dialect);
    let mut values = Vec::new();
    while !reader.rest().is_empty() {
        if !reader.rest().starts_with(b"[") {
            return Err(Fault::new("an expression in brackets is missing here"));
        }
        values.push(reader.term()?);
    }
    Ok(values)
}

/// Target and value of an assignment. Without target its number is unknown.
pub(crate) type Assigned = (Option<Name>, Value);

/// Target and value of an assignment such as `#1=[#2*3]`.
pub(crate) fn assignment(text: &[u8], parameters: &Parameters, dialect: Dialect) -> Result<Assigned, Fault> {
    assignment_after(&[], text, parameters, dialect)
}

/// The same after the assignments `before`.
pub(crate) fn assignment_after(
    before: &[Assigned],
    text: &[u8],
    parameters: &Parameters,
    dialect: Dialect,
) -> Result<Assigned, Fault> {
    let text = packed(text);
    let mut reader = Reader { before, ..Reader::new(&text, parameters, dialect) };
    let name = reader.name()?;
    reader.require(b'=')?;
    let value = match dialect {
        // Operators need brackets.
        Dialect::LinuxCnc => reader.term()?,
        Dialect::Fanuc | Dialect::Sinumerik => reader.expression()?,
    };
    reader.end()?;
    Ok((name, value))
}

struct Reader<'a> {
    text: &'a [u8],
    at: usize,
    depth: usize,
    /// Operators outside of inner brackets.
    has_relation: bool,
    has_logic: bool,
    /// Assignments that `parameters` does not hold yet.
    before: &'a [Assigned],
    parameters: &'a Parameters,
    dialect: Dialect,
}

impl<'a> Reader<'a> {
    fn new(text: &'a [u8], parameters: &'a Parameters, dialect: Dialect) -> Self {
        Self { text, at: 0, depth: 0, has_relation: false, has_logic: false, before: &[], parameters, dialect }
    }

    fn rest(&self) -> &'a [u8] {
        &self.text[self.at.min(self.text.len())..]
    }

    fn take(&mut self, byte: u8) -> bool {
        let found = self.rest().first() == Some(&byte);
        self.at += usize::from(found);
        found
    }

    fn require(&mut self, byte: u8) -> Result<(), Fault> {
        if self.take(byte) { Ok(()) } else { Err(Fault::new(format!("`{}` is missing in this expression", char::from(byte)))) }
    }

    fn end(&self) -> Result<(), Fault> {
        match self.rest().first() {
            None => Ok(()),
            Some(byte) => Err(Fault::new(format!("`{}` has no meaning in this expression", char::from(*byte)))),
        }
    }

    /// A whole expression, up to its bracket or to the end.
    fn expression(&mut self) -> Result<Value, Fault> {
        let outer = (self.has_relation, self.has_logic);
        (self.has_relation, self.has_logic) = (false, false);
        let value = self.joined(0)?;
        // Controls differ in whether AND comes before a relation: only brackets make it certain.
        let ambiguous = self.dialect == Dialect::Fanuc && self.has_relation && self.has_logic;
        (self.has_relation, self.has_logic) = outer;
        Ok(if ambiguous { Value::Unknown } else { value })
    }

    /// Terms joined by operators of at least this rank.
    fn joined(&mut self, least: u8) -> Result<Value, Fault> {
        let mut left = self.term()?;
        while let Some((operator, length)) = Operator::read(self.rest()) {
            let rank = operator.rank(self.dialect);
            if rank < least {
                break;
            }
            self.at += length;
            self.has_relation |= operator.is_relation();
            self.has_logic |= operator.is_logic();
            let right = self.joined(rank + 1)?;
            left = operator.apply(left, right, self.dialect)?;
        }
        Ok(left)
    }

    fn term(&mut self) -> Result<Value, Fault> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(Fault::new(format!("an expression nested deeper than {DEEPEST}")));
        }
        let mut negative = false;
        while let Some(sign @ (b'+' | b'-')) = self.rest().first() {
            negative ^= *sign == b'-';
            self.at += 1;
        }
        let value = self.unsigned()?;
        self.depth -= 1;
        Ok(match value {
            Value::Number(number) if negative => Value::Number(-number),
            value => value,
        })
    }

    fn unsigned(&mut self) -> Result<Value, Fault> {
        match self.rest().first() {
            Some(b'[') => self.bracket(),
            Some(b'#') => self.parameter(),
            Some(b'0'..=b'9' | b'.') => match scan_number(self.text, self.at) {
                Some((end, value)) => {
                    self.at = end;
                    Ok(Value::Number(value))
                }
                None => Err(Fault::new("a number is missing in this expression")),
            },
            Some(byte) if byte.is_ascii_alphabetic() => self.function(),
            Some(byte) => Err(Fault::new(format!("`{}` has no meaning in this expression", char::from(*byte)))),
            None => Err(Fault::new("this expression is incomplete")),
        }
    }

    fn bracket(&mut self) -> Result<Value, Fault> {
        self.require(b'[')?;
        let value = self.expression()?;
        self.require(b']')?;
        Ok(value)
    }

    fn parameter(&mut self) -> Result<Value, Fault> {
        let Some(name) = self.name()? else { return Ok(Value::Unknown) };
        if let Some((target, value)) =
            self.before.iter().rfind(|(target, _)| target.as_ref().is_none_or(|target| *target == name))
        {
            // The values of system parameters stay unknown; so do all where a target is not known.
            let is_known = target.is_some() && self.parameters.holds(&name);
            return Ok(if is_known { *value } else { Value::Unknown });
        }
        self.parameters.get(&name)?.ok_or_else(|| match &name {
            Name::Named(text) => Fault::new(format!("#<{}> was not assigned", String::from_utf8_lossy(text).to_lowercase())),
            Name::Number(number) => Fault::new(format!("#{number} was not assigned")),
        })
    }

    /// The name of a parameter. `None` if its number is unknown.
    fn name(&mut self) -> Result<Option<Name>, Fault> {
        self.require(b'#')?;
        if self.take(b'<') {
            let rest = self.rest();
            let length = rest.iter().position(|byte| *byte == b'>').ok_or_else(|| Fault::new("`>` is missing in this name"))?;
            self.at += length + 1;
            return Ok(Some(Name::Named(rest[..length].to_vec())));
        }
        let value = self.term()?;
        let Some(number) = value.number() else { return Ok(None) };
        let whole = number.round();
        if (number - whole).abs() > WHOLE || !(0.0..=f64::from(u32::MAX)).contains(&whole) {
            return Err(Fault::new(format!("{number} is no number of a parameter")));
        }
        Ok(Some(Name::Number(whole as u32)))
    }

    fn function(&mut self) -> Result<Value, Fault> {
        let rest = self.rest();
        let length = rest.iter().position(|byte| !byte.is_ascii_alphabetic()).unwrap_or(rest.len());
        let name = &rest[..length];
        self.at += length;
        if name == b"EXISTS" {
            return self.exists();
        }
        self.require(b'[')?;
        let first = self.expression()?;
        let second = if self.take(b',') { Some(self.expression()?) } else { None };
        self.require(b']')?;
        match (name, second) {
            (b"ATAN", None) if self.rest().starts_with(b"/[") => {
                self.at += 1;
                let second = self.bracket()?;
                atan2(first, second, self.dialect)
            }
            (b"ATAN", Some(second)) if self.dialect == Dialect::Fanuc => atan2(first, second, self.dialect),
            (b"POW", Some(second)) if self.dialect == Dialect::Fanuc => power(first, second),
            (_, Some(_)) => Err(Fault::new("this function has one argument")),
            (name, None) => function(name, first, self.dialect),
        }
    }

    /// EXISTS[#<name>]: whether the name was assigned. The control may know global names that the program does not assign.
    fn exists(&mut self) -> Result<Value, Fault> {
        self.require(b'[')?;
        let name = self.name()?;
        self.require(b']')?;
        Ok(match name {
            None => Value::Unknown,
            Some(name) => match (self.parameters.get(&name)?, name) {
                (None, _) => Value::Number(0.0),
                (Some(Value::Unknown), Name::Named(text)) if text.starts_with(b"_") => Value::Unknown,
                (Some(_), _) => Value::Number(1.0),
            },
        })
    }
}
