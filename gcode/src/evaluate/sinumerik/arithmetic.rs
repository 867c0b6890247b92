//! Operators and functions ("Arithmetic functions", "Comparison operations and logic operations", "Priority of the operations").

use crate::evaluate::value::{Fault, Value, finite, truth};

/// A binary operator, in the order of the manual's priorities from the highest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Operator {
    Times,
    Over,
    Div,
    Mod,
    Plus,
    Minus,
    BitAnd,
    BitXor,
    BitOr,
    And,
    Xor,
    Or,
    Join,
    Equal,
    NotEqual,
    GreaterEqual,
    LessEqual,
    Greater,
    Less,
}

const SPELLINGS: [(&[u8], Operator); 19] = [
    (b"*", Operator::Times),
    (b"/", Operator::Over),
    (b"DIV", Operator::Div),
    (b"MOD", Operator::Mod),
    (b"+", Operator::Plus),
    (b"-", Operator::Minus),
    (b"B_AND", Operator::BitAnd),
    (b"B_XOR", Operator::BitXor),
    (b"B_OR", Operator::BitOr),
    (b"AND", Operator::And),
    (b"XOR", Operator::Xor),
    (b"OR", Operator::Or),
    (b"<<", Operator::Join),
    (b"==", Operator::Equal),
    (b"<>", Operator::NotEqual),
    (b">=", Operator::GreaterEqual),
    (b"<=", Operator::LessEqual),
    (b">", Operator::Greater),
    (b"<", Operator::Less),
];

/// Numbers that differ by less, relative to their size, are equal or not by the rounding of the control, which states 1e-12.
const DOUBTFUL: f64 = 1e-10;

impl Operator {
    /// The operator with this spelling in upper case.
    pub fn read(text: &[u8]) -> Option<Self> {
        SPELLINGS.iter().find(|(spelling, _)| *spelling == text).map(|(_, operator)| *operator)
    }

    /// Operators of a higher rank are evaluated first, those of one rank from left to right.
    pub fn rank(self) -> u8 {
        use Operator::*;
        match self {
            Times | Over | Div | Mod => 9,
            Plus | Minus => 8,
            BitAnd => 7,
            BitXor => 6,
            BitOr => 5,
            And => 4,
            Xor => 3,
            Or => 2,
            Join => 1,
            Equal | NotEqual | GreaterEqual | LessEqual | Greater | Less => 0,
        }
    }

    pub fn is_relation(self) -> bool {
        self.rank() == 0
    }

    pub fn is_logic(self) -> bool {
        (2..=7).contains(&self.rank())
    }

    /// The value of `left operator right`.
    pub fn apply(self, left: Value, right: Value) -> Result<Value, Fault> {
        use Operator::*;
        let (Some(a), Some(b)) = (left.number(), right.number()) else { return Ok(Value::Unknown) };
        if self.is_relation() && a != b && (a - b).abs() <= DOUBTFUL * a.abs().max(b.abs()) {
            return Ok(Value::Unknown);
        }
        match self {
            Over | Div | Mod if b == 0.0 => Err(Fault::new("a division by zero")),
            Times => finite(a * b),
            Over => finite(a / b),
            // The rounding of negative quotients is not documented.
            Div | Mod if a < 0.0 || b < 0.0 => Ok(Value::Unknown),
            Div => finite((a / b).trunc()),
            Mod => finite(a % b),
            Plus => finite(a + b),
            Minus => finite(a - b),
            BitAnd => Ok(bits(a, b, |a, b| a & b)),
            BitXor => Ok(bits(a, b, |a, b| a ^ b)),
            BitOr => Ok(bits(a, b, |a, b| a | b)),
            And => Ok(truth(a != 0.0 && b != 0.0)),
            Xor => Ok(truth((a != 0.0) != (b != 0.0))),
            Or => Ok(truth(a != 0.0 || b != 0.0)),
            Join => Ok(Value::Unknown),
            Equal => Ok(truth(a == b)),
            NotEqual => Ok(truth(a != b)),
            GreaterEqual => Ok(truth(a >= b)),
            LessEqual => Ok(truth(a <= b)),
            Greater => Ok(truth(a > b)),
            Less => Ok(truth(a < b)),
        }
    }
}

/// Bit operations are evaluated for whole numbers from 0 to 2³¹−1.
fn bits(a: f64, b: f64, of: fn(u32, u32) -> u32) -> Value {
    let whole = |value: f64| (value.fract() == 0.0 && (0.0..=f64::from(i32::MAX)).contains(&value)).then_some(value as u32);
    match (whole(a), whole(b)) {
        (Some(a), Some(b)) => Value::Number(f64::from(of(a, b))),
        _ => Value::Unknown,
    }
}

/// The nearest whole number; unknown for negative halves, of which no manual states the direction.
pub(super) fn rounded(x: f64) -> Value {
    if x < 0.0 && x.fract() == -0.5 { Value::Unknown } else { Value::Number(x.round()) }
}

/// A function by its name in upper case; angles in degrees. `None`: no such function.
pub(super) fn function(name: &[u8], arguments: &[Value]) -> Option<Result<Value, Fault>> {
    let numbers: Option<Vec<f64>> = arguments.iter().map(|value| value.number()).collect();
    let known = matches!(
        name,
        b"SIN"
            | b"COS"
            | b"TAN"
            | b"ASIN"
            | b"ACOS"
            | b"ATAN2"
            | b"SQRT"
            | b"POT"
            | b"ABS"
            | b"TRUNC"
            | b"ROUND"
            | b"ROUNDUP"
            | b"LN"
            | b"EXP"
            | b"MINVAL"
            | b"MAXVAL"
            | b"BOUND"
            | b"AC"
            | b"IC"
    );
    if !known {
        return None;
    }
    let Some(numbers) = numbers else { return Some(Ok(Value::Unknown)) };
    Some(match (name, numbers.as_slice()) {
        (b"SIN", [x]) => finite(x.to_radians().sin()),
        (b"COS", [x]) => finite(x.to_radians().cos()),
        (b"TAN", [x]) => finite(x.to_radians().tan()),
        (b"ASIN" | b"ACOS", [x]) if x.abs() > 1.0 => Err(Fault::new("an argument beyond -1 to 1")),
        (b"ASIN", [x]) => finite(x.asin().to_degrees()),
        (b"ACOS", [x]) => finite(x.acos().to_degrees()),
        (b"ATAN2", [y, x]) => finite(y.atan2(*x).to_degrees()),
        (b"SQRT", [x]) if *x < 0.0 => Err(Fault::new("the root of a negative number")),
        (b"SQRT", [x]) => finite(x.sqrt()),
        (b"POT", [x]) => finite(x * x),
        (b"ABS", [x]) => finite(x.abs()),
        (b"TRUNC", [x]) => finite(x.trunc()),
        (b"ROUND", [x]) => Ok(rounded(*x)),
        (b"ROUNDUP", [x]) if *x < 0.0 => Ok(Value::Unknown),
        (b"ROUNDUP", [x]) => finite(x.ceil()),
        (b"LN", [x]) if *x <= 0.0 => Err(Fault::new("the logarithm of a number that is not positive")),
        (b"LN", [x]) => finite(x.ln()),
        (b"EXP", [x]) => finite(x.exp()),
        (b"MINVAL", [a, b]) => finite(a.min(*b)),
        (b"MAXVAL", [a, b]) => finite(a.max(*b)),
        (b"BOUND", [least, most, x]) if least <= most => finite(x.clamp(*least, *most)),
        (b"AC" | b"IC", [x]) => finite(*x),
        _ => Err(Fault::new("this function has another number of arguments")),
    })
}
