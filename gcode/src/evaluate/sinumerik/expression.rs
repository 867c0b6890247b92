//! Expressions: read and evaluated in one pass.

use super::arithmetic::{Operator, function};
use super::variables::{Name, Variables};
use crate::evaluate::value::{Fault, Value, truth};
use crate::number::skip_blanks;
use crate::sinumerik::scan::{bracket_end, name, number, operator, string_end};

/// Largest depth of brackets and functions. It bounds the stack.
const DEEPEST: usize = 64;

/// The value of an expression that is the whole text.
pub(super) fn evaluate(text: &[u8], variables: &Variables) -> Result<Value, Fault> {
    evaluate_after(&[], text, variables)
}

/// The same after the assignments `before`.
pub(super) fn evaluate_after(before: &[(Name, Value)], text: &[u8], variables: &Variables) -> Result<Value, Fault> {
    let mut reader = Reader { text, at: 0, depth: 0, before, variables };
    let value = reader.expression()?;
    reader.blanks();
    match text.get(reader.at) {
        None => Ok(value),
        Some(byte) => Err(Fault::new(format!("`{}` has no meaning in this expression", char::from(*byte)))),
    }
}

/// Target and value text of an assignment such as `R1=R2*3` or `LIST[R1]=5`.
pub(super) fn target<'a>(text: &'a [u8], variables: &Variables) -> Result<(Name, &'a [u8]), Fault> {
    let mut reader = Reader { text, at: 0, depth: 0, before: &[], variables };
    let name = reader.variable()?;
    reader.blanks();
    match text.get(reader.at) {
        Some(b'=') => Ok((name, &text[reader.at + 1..])),
        _ => Err(Fault::new("`=` is missing in this assignment")),
    }
}

/// The texts between commas of a list of arguments.
pub(super) fn arguments(text: &[u8]) -> Vec<&[u8]> {
    let (mut parts, mut start, mut at) = (Vec::new(), 0, 0);
    while let Some(byte) = text.get(at) {
        match byte {
            b'(' | b'[' => at = bracket_end(text, at),
            b'"' => at = string_end(text, at),
            b',' => {
                parts.push(text[start..at].trim_ascii());
                at += 1;
                start = at;
            }
            _ => at += 1,
        }
    }
    parts.push(text[start.min(text.len())..].trim_ascii());
    parts
}

struct Reader<'a> {
    text: &'a [u8],
    at: usize,
    depth: usize,
    /// Assignments that `variables` does not hold yet.
    before: &'a [(Name, Value)],
    variables: &'a Variables,
}

impl Reader<'_> {
    fn blanks(&mut self) {
        self.at = skip_blanks(self.text, self.at);
    }

    fn expression(&mut self) -> Result<Value, Fault> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(Fault::new(format!("an expression nested deeper than {DEEPEST}")));
        }
        let (mut has_relation, mut has_logic) = (false, false);
        let value = self.joined(0, &mut has_relation, &mut has_logic)?;
        self.depth -= 1;
        // Relations come last: `R1>0 AND R2>0` compares the result of AND. What was meant is not certain.
        Ok(if has_relation && has_logic { Value::Unknown } else { value })
    }

    /// Operands joined by operators of at least this rank.
    fn joined(&mut self, least: u8, has_relation: &mut bool, has_logic: &mut bool) -> Result<Value, Fault> {
        let mut left = self.operand()?;
        loop {
            let at = skip_blanks(self.text, self.at);
            let Some(length) = operator(self.text, at) else { return Ok(left) };
            let spelling = self.text[at..at + length].to_ascii_uppercase();
            let Some(operator) = Operator::read(&spelling) else {
                // The chain operator of frames.
                return Err(Fault::new("this operator is not evaluated"));
            };
            if operator.rank() < least {
                return Ok(left);
            }
            self.at = at + length;
            *has_relation |= operator.is_relation();
            *has_logic |= operator.is_logic();
            let right = self.joined(operator.rank() + 1, has_relation, has_logic)?;
            left = operator.apply(left, right)?;
        }
    }

    fn operand(&mut self) -> Result<Value, Fault> {
        let (mut negative, mut inverted) = (false, false);
        loop {
            self.blanks();
            let word = name(self.text, self.at);
            match self.text.get(self.at) {
                Some(b'-') => negative = !negative,
                Some(b'+') => {}
                _ if word.eq_ignore_ascii_case(b"NOT") => {
                    inverted = !inverted;
                    self.at += 2;
                }
                _ => break,
            }
            self.at += 1;
        }
        let value = self.primary()?;
        let value = match value {
            Value::Number(number) if negative => Value::Number(-number),
            value => value,
        };
        Ok(match value {
            Value::Number(number) if inverted => truth(number == 0.0),
            value => value,
        })
    }

    fn primary(&mut self) -> Result<Value, Fault> {
        match self.text.get(self.at) {
            Some(b'(') => {
                self.at += 1;
                let value = self.expression()?;
                self.blanks();
                if self.text.get(self.at) != Some(&b')') {
                    return Err(Fault::new("`)` is missing in this expression"));
                }
                self.at += 1;
                Ok(value)
            }
            Some(b'0'..=b'9' | b'.') => match number(self.text, self.at) {
                Some((end, value)) => {
                    self.at = end;
                    Ok(Value::Number(value))
                }
                None => Err(Fault::new("a number is missing in this expression")),
            },
            Some(b'"' | b'\'') => {
                let end = string_end(self.text, self.at);
                let value = coded(&self.text[self.at..end]);
                self.at = end;
                Ok(value)
            }
            Some(byte) if byte.is_ascii_alphabetic() || matches!(byte, b'_' | b'$') => self.named(),
            Some(byte) => Err(Fault::new(format!("`{}` has no meaning in this expression", char::from(*byte)))),
            None => Err(Fault::new("this expression is incomplete")),
        }
    }

    /// A constant, a function or a variable.
    fn named(&mut self) -> Result<Value, Fault> {
        let text = name(self.text, self.at).to_ascii_uppercase();
        let open = skip_blanks(self.text, self.at + text.len());
        if self.text.get(self.at) != Some(&b'$') && self.text.get(open) == Some(&b'(') {
            let end = bracket_end(self.text, open);
            let inside = self.text.get(open + 1..end.saturating_sub(1)).unwrap_or_default();
            self.depth += 1;
            if self.depth > DEEPEST {
                return Err(Fault::new(format!("an expression nested deeper than {DEEPEST}")));
            }
            let values: Result<Vec<Value>, Fault> = arguments(inside).into_iter().map(|part| self.inner(part)).collect();
            self.depth -= 1;
            self.at = end;
            // What is no function of the control is a subprogram's value or one of the builder's.
            return match function(&text, &values.unwrap_or_else(|_| vec![Value::Unknown])) {
                Some(value) => value,
                None => Ok(Value::Unknown),
            };
        }
        match text.as_slice() {
            b"TRUE" => self.constant(4, 1.0),
            b"FALSE" => self.constant(5, 0.0),
            b"PI" => self.constant(2, std::f64::consts::PI),
            _ => {
                let name = self.variable()?;
                Ok(self.variables.get_after(self.before, &name))
            }
        }
    }

    fn constant(&mut self, length: usize, value: f64) -> Result<Value, Fault> {
        self.at += length;
        Ok(Value::Number(value))
    }

    fn inner(&self, text: &[u8]) -> Result<Value, Fault> {
        let mut reader = Reader { text, at: 0, depth: self.depth, ..*self };
        let value = reader.expression()?;
        reader.blanks();
        if reader.at < text.len() { Err(Fault::new("this argument is not understood")) } else { Ok(value) }
    }

    /// A variable with its indices.
    fn variable(&mut self) -> Result<Name, Fault> {
        self.blanks();
        let dollar = usize::from(self.text.get(self.at) == Some(&b'$'));
        let base = name(self.text, self.at + dollar);
        if base.is_empty() {
            return Err(Fault::new("a name is missing here"));
        }
        let text = String::from_utf8_lossy(&self.text[self.at..self.at + dollar + base.len()]).to_ascii_uppercase();
        self.at += text.len();
        if self.text.get(self.at) != Some(&b'[') {
            return Ok(Name::plain(text));
        }
        let end = bracket_end(self.text, self.at);
        let inside = self.text.get(self.at + 1..end.saturating_sub(1)).unwrap_or_default();
        let index = arguments(inside).into_iter().map(|part| self.inner(part).ok().and_then(Value::number)).collect();
        self.at = end;
        Ok(Name::of(text, index))
    }
}

/// `'H1F'` and `'B101'`; the value of other strings is unknown.
fn coded(text: &[u8]) -> Value {
    let inside = text.strip_prefix(b"'").and_then(|rest| rest.strip_suffix(b"'")).unwrap_or_default();
    let digits = std::str::from_utf8(inside.get(1..).unwrap_or_default()).unwrap_or_default();
    let base = match inside.first() {
        Some(b'H' | b'h') => 16,
        Some(b'B' | b'b') => 2,
        _ => return Value::Unknown,
    };
    u32::from_str_radix(digits, base).map_or(Value::Unknown, |value| Value::Number(f64::from(value)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> Value {
        let mut variables = Variables::new();
        variables.set(&Name::plain("R1"), Value::Number(5.0));
        variables.set(&Name::plain("R2"), Value::Number(-2.0));
        evaluate(text.as_bytes(), &variables).unwrap_or_else(|fault| panic!("{text}: {}", fault.message))
    }

    #[test]
    fn values_follow_the_priorities_of_the_control() {
        let cases = [
            ("R1+2*3", 11.0),
            ("(R1+2)*3", 21.0),
            ("-R2", 2.0),
            ("r[1] - R2*R2", 1.0),
            ("R1/2", 2.5),
            ("7 DIV 2", 3.0),
            ("7 MOD 4", 3.0),
            ("SIN(30)*2", 1.0),
            ("ATAN2(30,80.054)", 20.543),
            ("POT(R1)+SQRT(16)", 29.0),
            ("TRUNC(-2.7)+ROUND(2.5)", 1.0),
            ("R1==5", 1.0),
            ("R1 <> 5", 0.0),
            ("(R1>4) AND (R2<0)", 1.0),
            ("NOT (R1>4)", 0.0),
            ("NOT FALSE", 1.0),
            ("'H1F'+'B101'", 36.0),
            ("1.5EX2", 150.0),
            ("2EX-3", 0.002),
            ("MINVAL(R1,3)+MAXVAL(1,R2)", 4.0),
            ("5 B_AND 4 B_OR 2", 6.0),
        ];
        for (text, expected) in cases {
            let Value::Number(found) = value(text) else { panic!("{text} is unknown") };
            assert!((found - expected).abs() < 1e-3, "{text}: {found}");
        }
    }

    #[test]
    fn what_only_the_control_knows_is_unknown() {
        for text in ["R3", "$P_EP[X]", "$AA_IM[X]+1", "R1>4 AND R2<0", "NAME", "GETFREELOC(1)", "\"TEXT\"", "LIST[1]", "-7 MOD 4"]
        {
            assert_eq!(value(text), Value::Unknown, "{text}");
        }
    }

    #[test]
    fn faults_of_the_control_are_errors() {
        let deep = "(".repeat(200);
        for text in ["1/0", "SQRT(-1)", "R1+", "(R1", "5 5", "SIN(1,2)", "", &deep] {
            assert!(
                evaluate(text.as_bytes(), &{
                    let mut variables = Variables::new();
                    variables.set(&Name::plain("R1"), Value::Number(5.0));
                    variables
                })
                .is_err(),
                "{text}"
            );
        }
    }
}
