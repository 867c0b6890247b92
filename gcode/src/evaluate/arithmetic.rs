//! Operators and functions of expressions, in the arithmetic of each control.
//!
//! LinuxCNC: "RS274/NGC Interpreter", binary operators and functions; its values were compared with `rs274` 2.9. Fanuc:
//! Series 0i Operator's Manual, custom macro, "Arithmetic and logic operation".

use super::value::{Fault, Value, finite, truth};
use crate::dialect::Dialect;

/// A binary operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Operator {
    Power,
    Times,
    Over,
    Modulo,
    Plus,
    Minus,
    Equal,
    NotEqual,
    Greater,
    GreaterEqual,
    Less,
    LessEqual,
    And,
    Or,
    Xor,
}

/// Spellings in upper case. An operator stands before any that it begins with.
const SPELLINGS: [(&[u8], Operator); 15] = [
    (b"**", Operator::Power),
    (b"*", Operator::Times),
    (b"/", Operator::Over),
    (b"MOD", Operator::Modulo),
    (b"+", Operator::Plus),
    (b"-", Operator::Minus),
    (b"EQ", Operator::Equal),
    (b"NE", Operator::NotEqual),
    (b"GT", Operator::Greater),
    (b"GE", Operator::GreaterEqual),
    (b"LT", Operator::Less),
    (b"LE", Operator::LessEqual),
    (b"AND", Operator::And),
    (b"OR", Operator::Or),
    (b"XOR", Operator::Xor),
];

/// Below this difference LinuxCNC takes two numbers as equal in EQ and NE (measured with `rs274`: 0.00009 is equal, 0.00011 is not).
const EQUAL: f64 = 1e-4;
/// Fanuc computes with about eight decimal digits: the order of numbers that are closer, relative to their size, is not certain.
const FANUC_DIGITS: f64 = 1e-7;

impl Operator {
    /// The operator at the start of `text`, with its length.
    pub fn read(text: &[u8]) -> Option<(Self, usize)> {
        SPELLINGS.iter().find(|(spelling, _)| text.starts_with(spelling)).map(|(spelling, operator)| (*operator, spelling.len()))
    }

    /// Operators of a higher rank are evaluated first, those of one rank from left to right.
    pub fn rank(self, dialect: Dialect) -> u8 {
        match (self, dialect) {
            (Self::Power, _) => 5,
            (Self::Times | Self::Over | Self::Modulo, _) | (Self::And, Dialect::Fanuc) => 4,
            (Self::Plus | Self::Minus, _) | (Self::Or | Self::Xor, Dialect::Fanuc) => 3,
            (Self::And | Self::Or | Self::Xor, Dialect::LinuxCnc) => 1,
            _ => 2,
        }
    }

    pub fn is_relation(self) -> bool {
        use Operator::*;
        matches!(self, Equal | NotEqual | Greater | GreaterEqual | Less | LessEqual)
    }

    pub fn is_logic(self) -> bool {
        matches!(self, Self::And | Self::Or | Self::Xor)
    }

    /// The value of `left operator right`.
    pub fn apply(self, left: Value, right: Value, dialect: Dialect) -> Result<Value, Fault> {
        // Null equals nothing but null. The other relations take it as 0.
        if let (Self::Equal | Self::NotEqual, true) = (self, left == Value::Null || right == Value::Null)
            && left != Value::Unknown
            && right != Value::Unknown
        {
            return Ok(truth((left == right) == (self == Self::Equal)));
        }
        let (Some(a), Some(b)) = (left.number(), right.number()) else { return Ok(Value::Unknown) };
        match dialect {
            Dialect::LinuxCnc => self.linux_cnc(a, b),
            Dialect::Fanuc | Dialect::Sinumerik => self.fanuc(a, b),
        }
    }

    fn linux_cnc(self, a: f64, b: f64) -> Result<Value, Fault> {
        let equal = (a - b).abs() < EQUAL;
        Ok(match self {
            Self::Power if a < 0.0 && b.fract() != 0.0 => {
                return Err(Fault::new("a negative number to a power that is not whole"));
            }
            Self::Power => return finite(a.powf(b)),
            Self::Modulo => {
                let rest = a % b;
                return finite(if rest < 0.0 { rest + b.abs() } else { rest });
            }
            Self::Equal => truth(equal),
            Self::NotEqual => truth(!equal),
            Self::Greater => truth(a > b),
            Self::GreaterEqual => truth(a >= b),
            Self::Less => truth(a < b),
            Self::LessEqual => truth(a <= b),
            Self::And => truth(a != 0.0 && b != 0.0),
            Self::Or => truth(a != 0.0 || b != 0.0),
            Self::Xor => truth((a != 0.0) != (b != 0.0)),
            _ => return self.basic(a, b),
        })
    }

    fn fanuc(self, a: f64, b: f64) -> Result<Value, Fault> {
        if self.is_relation() && a != b && (a - b).abs() <= FANUC_DIGITS * a.abs().max(b.abs()) {
            return Ok(Value::Unknown);
        }
        Ok(match self {
            Self::Power => return Err(Fault::new("this control has no operator **").help("write POW[base,exponent]")),
            // The sign of the remainder of negative numbers is not documented.
            Self::Modulo if a < 0.0 || b < 0.0 => Value::Unknown,
            Self::Modulo => return finite(a % b),
            Self::Equal => truth(a == b),
            Self::NotEqual => truth(a != b),
            Self::Greater => truth(a > b),
            Self::GreaterEqual => truth(a >= b),
            Self::Less => truth(a < b),
            Self::LessEqual => truth(a <= b),
            Self::And => bits(a, b, |a, b| a & b),
            Self::Or => bits(a, b, |a, b| a | b),
            Self::Xor => bits(a, b, |a, b| a ^ b),
            _ => return self.basic(a, b),
        })
    }

    fn basic(self, a: f64, b: f64) -> Result<Value, Fault> {
        match self {
            Self::Over if b == 0.0 => Err(Fault::new("a division by zero")),
            Self::Over => finite(a / b),
            Self::Times => finite(a * b),
            Self::Minus => finite(a - b),
            _ => finite(a + b),
        }
    }
}

/// Bit operations are defined for whole numbers from 0 to 2³²−1.
fn bits(a: f64, b: f64, of: fn(u32, u32) -> u32) -> Value {
    let whole = |value: f64| (value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value)).then_some(value as u32);
    match (whole(a), whole(b)) {
        (Some(a), Some(b)) => Value::Number(f64::from(of(a, b))),
        _ => Value::Unknown,
    }
}

/// ATAN with two arguments, degrees.
pub(super) fn atan2(y: Value, x: Value, dialect: Dialect) -> Result<Value, Fault> {
    let (Some(y), Some(x)) = (y.number(), x.number()) else { return Ok(Value::Unknown) };
    angle(y.atan2(x), dialect)
}

/// POW.
pub(super) fn power(base: Value, exponent: Value) -> Result<Value, Fault> {
    match (base.number(), exponent.number()) {
        (Some(base), Some(exponent)) => finite(base.powf(exponent)),
        _ => Ok(Value::Unknown),
    }
}

/// An angle in degrees. A parameter of the Fanuc control (6004, bit 0) decides whether negative angles are counted from 360.
fn angle(radians: f64, dialect: Dialect) -> Result<Value, Fault> {
    if dialect == Dialect::Fanuc && radians < 0.0 { Ok(Value::Unknown) } else { finite(radians.to_degrees()) }
}

/// A function of one argument, by its name in upper case.
pub(super) fn function(name: &[u8], argument: Value, dialect: Dialect) -> Result<Value, Fault> {
    let Some(x) = argument.number() else { return Ok(Value::Unknown) };
    let fanuc = dialect == Dialect::Fanuc;
    match name {
        b"ABS" => finite(x.abs()),
        b"SIN" => finite(x.to_radians().sin()),
        b"COS" => finite(x.to_radians().cos()),
        b"TAN" => finite(x.to_radians().tan()),
        b"ASIN" | b"ACOS" if x.abs() > 1.0 => Err(Fault::new("an argument beyond -1 to 1")),
        b"ASIN" => angle(x.asin(), dialect),
        b"ACOS" => finite(x.acos().to_degrees()),
        b"ATAN" if fanuc => finite(x.atan().to_degrees()),
        b"EXP" => finite(x.exp()),
        b"LN" if x <= 0.0 => Err(Fault::new("the logarithm of a number that is not positive")),
        b"LN" => finite(x.ln()),
        b"SQRT" if x < 0.0 => Err(Fault::new("the root of a negative number")),
        b"SQRT" => finite(x.sqrt()),
        b"ROUND" => finite(x.round()),
        // Fanuc rounds by magnitude, LinuxCNC down and up.
        b"FIX" => finite(if fanuc { x.trunc() } else { x.floor() }),
        b"FUP" if fanuc => finite(x.abs().ceil().copysign(x)),
        b"FUP" => finite(x.ceil()),
        b"BIN" if fanuc => Ok(from_decimal_digits(x)),
        b"BCD" if fanuc => Ok(to_decimal_digits(x)),
        // Depends on parameters of the control.
        b"ADP" if fanuc => Ok(Value::Unknown),
        _ => Err(Fault::new(format!("{} is no function of this control", String::from_utf8_lossy(name)))),
    }
}

/// Largest argument of BCD: eight digits of four bits.
const LARGEST_BCD: f64 = 99_999_999.0;

/// BCD: the decimal digits as groups of four bits.
fn to_decimal_digits(x: f64) -> Value {
    if x.fract() != 0.0 || !(0.0..=LARGEST_BCD).contains(&x) {
        return Value::Unknown;
    }
    let (mut rest, mut out) = (x as u64, 0_u64);
    for group in 0..8 {
        out |= (rest % 10) << (4 * group);
        rest /= 10;
    }
    Value::Number(out as f64)
}

/// BIN: groups of four bits as decimal digits.
fn from_decimal_digits(x: f64) -> Value {
    if x.fract() != 0.0 || !(0.0..=f64::from(u32::MAX)).contains(&x) {
        return Value::Unknown;
    }
    let digits = (0..8).map(|group| (x as u64 >> (4 * group)) & 15).collect::<Vec<_>>();
    if digits.iter().any(|digit| *digit > 9) {
        return Value::Unknown;
    }
    Value::Number(digits.iter().rev().fold(0, |sum, digit| sum * 10 + digit) as f64)
}
