//! Values of parameters and expressions, and the faults of their text.

use std::ops::Range;

/// A value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Value {
    /// A number, finite.
    Number(f64),
    /// Fanuc's vacant value. A word with it is ignored.
    Null,
    /// Known only when the program runs.
    Unknown,
}

impl Value {
    /// Whether nothing tells the values apart, not even the sign of a zero.
    pub fn is_same(self, other: Self) -> bool {
        match (self, other) {
            (Self::Number(a), Self::Number(b)) => a.to_bits() == b.to_bits(),
            _ => self == other,
        }
    }

    /// The number; 0 for null, as in arithmetic. `None` if unknown.
    pub fn number(self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(value),
            Self::Null => Some(0.0),
            Self::Unknown => None,
        }
    }
}

/// Value of a comparison or a logic operation.
pub(super) fn truth(holds: bool) -> Value {
    Value::Number(f64::from(u8::from(holds)))
}

/// The result of an arithmetic operation. Refused if it is not finite.
pub(super) fn finite(value: f64) -> Result<Value, Fault> {
    if value.is_finite() { Ok(Value::Number(value)) } else { Err(Fault::new("the result is not a number")) }
}

/// Reason why a control refuses a text, or why it cannot be evaluated.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Fault {
    /// One line without a full stop.
    pub message: String,
    /// Remedy.
    pub help: Option<&'static str>,
    /// Bytes of the program. `None`: the whole block.
    pub at: Option<Range<u32>>,
}

impl Fault {
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), help: None, at: None }
    }

    /// Adds a remedy.
    pub fn help(self, help: &'static str) -> Self {
        Self { help: Some(help), ..self }
    }

    /// Refers to these bytes, unless it already refers to others.
    pub fn at(self, span: crate::word::Span) -> Self {
        Self { at: self.at.or(Some(span.start..span.end)), ..self }
    }
}
