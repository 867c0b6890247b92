//! Flow statements, read from their text.

use super::variables::Kind;
use crate::number::skip_blanks;
use crate::sinumerik::scan::{bracket_end, expression_end, name, string_end};

/// Where a jump looks for its target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    /// GOTOF: towards the end.
    Forward,
    /// GOTOB: towards the start.
    Backward,
    /// GOTO, GOTOC: first forward, then from the start.
    Both,
}

/// A jump. The target is a label or a block number, in upper case; empty if it is neither.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Jump {
    pub direction: Direction,
    pub target: String,
}

/// A flow statement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Statement {
    If {
        condition: Vec<u8>,
    },
    Else,
    EndIf,
    While {
        condition: Vec<u8>,
    },
    EndWhile,
    For {
        variable: Vec<u8>,
        from: Vec<u8>,
        to: Vec<u8>,
    },
    EndFor,
    Loop,
    EndLoop,
    /// REPEAT without a label.
    Repeat,
    Until {
        condition: Vec<u8>,
    },
    /// REPEAT and REPEATB with labels.
    Again {
        start: String,
        end: Option<String>,
        times: Vec<u8>,
        is_block: bool,
    },
    Jump {
        condition: Option<Vec<u8>>,
        jump: Jump,
    },
    /// CASE: values with their jumps; the last without value is the default.
    Case {
        of: Vec<u8>,
        choices: Vec<(Option<Vec<u8>>, Jump)>,
    },
    Define {
        kind: Kind,
        items: Vec<u8>,
    },
    Procedure,
    /// CALL, EXTCALL, PCALL of a fixed name, with the text of its arguments.
    Call {
        name: String,
        arguments: Vec<u8>,
    },
    Return,
    NotUnderstood,
}

const JUMPS: [(&str, Direction); 4] =
    [("GOTOF", Direction::Forward), ("GOTOB", Direction::Backward), ("GOTOC", Direction::Both), ("GOTO", Direction::Both)];

impl Statement {
    pub fn read(text: &[u8]) -> Self {
        let word = String::from_utf8_lossy(name(text, 0)).to_ascii_uppercase();
        let rest = text[word.len().min(text.len())..].trim_ascii();
        let condition = || rest.to_vec();
        let read = match word.as_str() {
            "IF" => if_statement(rest),
            "ELSE" if rest.is_empty() => Some(Self::Else),
            "ENDIF" if rest.is_empty() => Some(Self::EndIf),
            "WHILE" => Some(Self::While { condition: condition() }),
            "ENDWHILE" if rest.is_empty() => Some(Self::EndWhile),
            "FOR" => for_statement(rest),
            "ENDFOR" if rest.is_empty() => Some(Self::EndFor),
            "LOOP" if rest.is_empty() => Some(Self::Loop),
            "ENDLOOP" if rest.is_empty() => Some(Self::EndLoop),
            "REPEAT" if rest.is_empty() => Some(Self::Repeat),
            "UNTIL" => Some(Self::Until { condition: condition() }),
            "REPEAT" | "REPEATB" => again(rest, word == "REPEATB"),
            "CASE" => case(rest),
            "DEF" => define(rest),
            "PROC" => Some(Self::Procedure),
            "RET" if rest.is_empty() => Some(Self::Return),
            "CALL" | "EXTCALL" | "PCALL" => call(rest, word == "PCALL"),
            _ => jump(text).map(|jump| Self::Jump { condition: None, jump }),
        };
        read.unwrap_or(Self::NotUnderstood)
    }
}

/// A jump that is the whole text.
fn jump(text: &[u8]) -> Option<Jump> {
    let word = String::from_utf8_lossy(name(text, 0)).to_ascii_uppercase();
    let (_, direction) = JUMPS.iter().find(|(known, _)| *known == word)?;
    let rest = text[word.len()..].trim_ascii();
    let rest = rest.strip_prefix(b":").unwrap_or(rest);
    let target = name(rest, 0);
    let is_whole = target.len() == rest.len() && !rest.is_empty();
    let target = if is_whole { String::from_utf8_lossy(target).to_ascii_uppercase() } else { String::new() };
    Some(Jump { direction: *direction, target })
}

fn if_statement(rest: &[u8]) -> Option<Statement> {
    let at = keyword(rest, |word| word.starts_with("GOTO"));
    let Some(at) = at else { return Some(Statement::If { condition: rest.to_vec() }) };
    let jump = jump(&rest[at..])?;
    Some(Statement::Jump { condition: Some(rest[..at].trim_ascii().to_vec()), jump })
}

/// Place of the first name outside of brackets and strings that `is` accepts.
fn keyword(text: &[u8], is: impl Fn(&str) -> bool) -> Option<usize> {
    let mut at = 0;
    while let Some(byte) = text.get(at) {
        match byte {
            b'(' | b'[' => at = bracket_end(text, at),
            b'"' => at = string_end(text, at),
            _ if byte.is_ascii_alphanumeric() || *byte == b'_' => {
                let word = name(text, at);
                if is(&String::from_utf8_lossy(word).to_ascii_uppercase()) {
                    return Some(at);
                }
                at += word.len();
            }
            _ => at += 1,
        }
    }
    None
}

fn for_statement(rest: &[u8]) -> Option<Statement> {
    let equals = rest.iter().position(|byte| *byte == b'=')?;
    let bounds = &rest[equals + 1..];
    let to = keyword(bounds, |word| word == "TO")?;
    Some(Statement::For {
        variable: rest[..equals].trim_ascii().to_vec(),
        from: bounds[..to].trim_ascii().to_vec(),
        to: bounds[to + 2..].trim_ascii().to_vec(),
    })
}

fn again(rest: &[u8], is_block: bool) -> Option<Statement> {
    let at = keyword(rest, |word| word == "P" || word.strip_prefix('P').is_some_and(|n| n.bytes().all(|b| b.is_ascii_digit())));
    let (labels, times) = match at {
        Some(at) => {
            let times = rest[at + 1..].trim_ascii();
            (&rest[..at], times.strip_prefix(b"=").unwrap_or(times).to_vec())
        }
        None => (rest, b"1".to_vec()),
    };
    let labels = String::from_utf8_lossy(labels).to_ascii_uppercase();
    let mut labels = labels.split_whitespace().map(str::to_owned);
    let (start, end) = (labels.next()?, labels.next());
    (labels.next().is_none() && !(is_block && end.is_some())).then_some(Statement::Again { start, end, times, is_block })
}

fn case(rest: &[u8]) -> Option<Statement> {
    let of = keyword(rest, |word| word == "OF")?;
    let mut choices = Vec::new();
    let mut text = rest[of + 2..].trim_ascii();
    while !text.is_empty() {
        let at = keyword(text, |word| word.starts_with("GOTO"))?;
        let value = text[..at].trim_ascii();
        let value = (!value.eq_ignore_ascii_case(b"DEFAULT")).then(|| value.to_vec());
        let target = skip_blanks(text, at + name(text, at).len());
        let end = target + name(text, target).len();
        choices.push((value, jump(&text[at..end])?));
        text = text[end..].trim_ascii();
    }
    Some(Statement::Case { of: rest[..of].trim_ascii().to_vec(), choices })
}

fn define(rest: &[u8]) -> Option<Statement> {
    let mut text = rest;
    loop {
        let word = String::from_utf8_lossy(name(text, 0)).to_ascii_uppercase();
        if word.is_empty() {
            return None;
        }
        let mut end = word.len();
        if text.get(end) == Some(&b'[') {
            end = bracket_end(text, end);
        }
        text = text[end..].trim_ascii();
        if let Some(kind) = Kind::read(&word) {
            return Some(Statement::Define { kind, items: text.to_vec() });
        }
        // NCK, CHAN, SYNR, SYNW, SYNRW before the type.
        if !(word.starts_with("SYN") || word == "NCK" || word == "CHAN") {
            return None;
        }
    }
}

fn call(rest: &[u8], has_arguments: bool) -> Option<Statement> {
    let rest = rest.strip_prefix(b"(").and_then(|rest| rest.strip_suffix(b")")).map_or(rest, <[u8]>::trim_ascii);
    let (path, arguments) = if has_arguments {
        let open = rest.iter().position(|byte| *byte == b'(').unwrap_or(rest.len());
        (&rest[..open], &rest[open..])
    } else {
        (rest.strip_prefix(b"\"")?.strip_suffix(b"\"")?, &[][..])
    };
    let file = path.rsplit(|byte| *byte == b'/').next()?.trim_ascii();
    let name = program_name(&String::from_utf8_lossy(file).to_ascii_uppercase());
    (!name.is_empty()).then(|| Statement::Call { name, arguments: arguments.trim_ascii().to_vec() })
}

/// Name of a program without the marks of its file: `_N_POCKET_SPF` and `POCKET.SPF` are `POCKET`.
pub(super) fn program_name(file: &str) -> String {
    let name = file.strip_prefix("_N_").unwrap_or(file);
    let ends = ["_SPF", "_MPF", ".SPF", ".MPF"];
    ends.iter().find_map(|end| name.strip_suffix(end)).unwrap_or(name).to_owned()
}

/// A parameter of a subprogram.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Parameter {
    pub kind: Kind,
    pub name: String,
    /// Text of the value without argument.
    pub default: Option<Vec<u8>>,
    /// VAR: the value returns to the caller's variable.
    pub returns: bool,
}

/// Parameters of a PROC statement. `None`: not understood.
pub(super) fn parameters(text: &[u8]) -> Option<Vec<Parameter>> {
    let Some(open) = text.iter().position(|byte| *byte == b'(') else { return Some(Vec::new()) };
    let inside = text.get(open + 1..bracket_end(text, open).saturating_sub(1))?;
    if inside.trim_ascii().is_empty() {
        return Some(Vec::new());
    }
    super::expression::arguments(inside).into_iter().map(parameter).collect()
}

fn parameter(text: &[u8]) -> Option<Parameter> {
    let mut rest = text;
    let mut word = name(rest, 0);
    let returns = word.eq_ignore_ascii_case(b"VAR");
    if returns {
        rest = rest[word.len()..].trim_ascii();
        word = name(rest, 0);
    }
    let kind = Kind::read(&String::from_utf8_lossy(word).to_ascii_uppercase())?;
    rest = rest[word.len()..].trim_ascii();
    if rest.first() == Some(&b'[') {
        rest = rest[bracket_end(rest, 0)..].trim_ascii();
    }
    let own = name(rest, 0);
    let after = rest[own.len()..].trim_ascii();
    let default = after.strip_prefix(b"=").map(|value| value.trim_ascii().to_vec());
    let is_array = after.first() == Some(&b'[');
    let name = String::from_utf8_lossy(own).to_ascii_uppercase();
    (!own.is_empty() && !is_array).then_some(Parameter { kind, name, default, returns })
}

/// Whether a PROC statement restores the modes of its caller (SAVE).
pub(super) fn saves(text: &[u8]) -> bool {
    let open = text.iter().position(|byte| *byte == b'(').map_or(0, |open| bracket_end(text, open));
    keyword(&text[open.min(text.len())..], |word| word == "SAVE").is_some()
}

/// Items of a definition: names with their initial values.
pub(super) fn items(text: &[u8]) -> Vec<(String, Option<Vec<u8>>)> {
    let item = |part: &[u8]| {
        let own = name(part, 0);
        let rest = part[own.len()..].trim_ascii();
        let is_array = rest.first() == Some(&b'[');
        let past = if is_array { rest[bracket_end(rest, 0)..].trim_ascii() } else { rest };
        let value = past.strip_prefix(b"=").map(|value| value.trim_ascii());
        // The initial values of an array are not evaluated.
        let value =
            value.map(|value| if is_array { Vec::new() } else { value[..expression_end(value, 0).unwrap_or(0)].to_vec() });
        (String::from_utf8_lossy(own).to_ascii_uppercase(), value)
    };
    super::expression::arguments(text).into_iter().map(item).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_are_distinguished() {
        let to = |direction, target: &str| Jump { direction, target: target.to_owned() };
        let cases = [
            ("IF R1>5 GOTOF END_1", Statement::Jump { condition: Some("R1>5".into()), jump: to(Direction::Forward, "END_1") }),
            ("if (r1==1) and (r2==2)", Statement::If { condition: "(r1==1) and (r2==2)".into() }),
            ("GOTOB N100", Statement::Jump { condition: None, jump: to(Direction::Backward, "N100") }),
            ("FOR I=1 TO R5+2", Statement::For { variable: "I".into(), from: "1".into(), to: "R5+2".into() }),
            (
                "REPEAT START ENDE P=3",
                Statement::Again { start: "START".into(), end: Some("ENDE".into()), times: "3".into(), is_block: false },
            ),
            ("REPEATB LBL P5", Statement::Again { start: "LBL".into(), end: None, times: "5".into(), is_block: true }),
            ("CALL \"/_N_WKS_DIR/_N_TASCHE_SPF\"", Statement::Call { name: "TASCHE".into(), arguments: Vec::new() }),
            ("EXTCALL(\"ROUGH.SPF\")", Statement::Call { name: "ROUGH".into(), arguments: Vec::new() }),
            ("DEF REAL A=5, B", Statement::Define { kind: Kind::Real, items: "A=5, B".into() }),
            ("CALL PROGVAR", Statement::NotUnderstood),
            ("DEFINE A AS G1 X5", Statement::NotUnderstood),
            (
                "CASE(R1) OF 1 GOTOF A 2 GOTOF B DEFAULT GOTOF C",
                Statement::Case {
                    of: "(R1)".into(),
                    choices: vec![
                        (Some("1".into()), to(Direction::Forward, "A")),
                        (Some("2".into()), to(Direction::Forward, "B")),
                        (None, to(Direction::Forward, "C")),
                    ],
                },
            ),
        ];
        for (text, expected) in cases {
            assert_eq!(Statement::read(text.as_bytes()), expected, "{text}");
        }
    }
}
