//! Splits one line of a SINUMERIK program into words. Total: every non-blank byte belongs to exactly one word.
//!
//! Source: SINUMERIK "NC programming", "Structure and contents of an NC program", "Rules for block format", "Value assignments".

use super::names::{Name, meaning};
use super::scan::{assigns, bracket_end, expression_end, is_dimension, name, number, statement_end, string_end};
use crate::number::{is_blank, skip_blanks};
use crate::word::{Word, WordKind, offset, plain};

/// Words that begin a statement up to the end of the line.
const STATEMENTS: [&str; 30] = [
    "CALL", "CASE", "DEF", "DEFINE", "ELSE", "ENDFOR", "ENDIF", "ENDLOOP", "ENDPROC", "ENDWHILE", "EXTCALL", "FOR", "GOTO",
    "GOTOB", "GOTOC", "GOTOF", "GOTOS", "IF", "ISOCALL", "LOOP", "PCALL", "PROC", "REDEF", "REPEAT", "REPEATB", "RET", "UNTIL",
    "WHILE", "MCALL", "CALLPATH",
];
/// Words of synchronized actions, whose line is not interpreted.
const SYNCHRONIZED: [&str; 8] = ["WHEN", "WHENEVER", "EVERY", "FROM", "ID", "IDS", "DO", "CANCEL"];
/// M functions that may have the number of a spindle.
const SPINDLE_M: [f64; 11] = [3.0, 4.0, 5.0, 19.0, 40.0, 41.0, 42.0, 43.0, 44.0, 45.0, 70.0];

/// Splits `line`, whose first byte is at offset `base` of the program, and appends its words.
pub(crate) fn lex_line(line: &[u8], base: u32, words: &mut Vec<Word>) {
    let mut reader = Reader { line, base, at: 0, at_head: true };
    reader.at = skip_blanks(line, 0);
    if line.get(reader.at) == Some(&b'%') {
        words.push(reader.plain(WordKind::Percent, statement_end(line, reader.at), Name::None));
    }
    while let Some(&byte) = line.get(reader.at) {
        if is_blank(byte) {
            reader.at += 1;
            continue;
        }
        let word = reader.word(byte);
        reader.at_head &= word.is(b'N') || word.kind == WordKind::BlockDelete;
        words.push(word);
    }
}

struct Reader<'a> {
    line: &'a [u8],
    base: u32,
    at: usize,
    /// Only a block number and a slash stand before.
    at_head: bool,
}

/// Arguments of CYCLE800 up to its last shift.
const SWIVEL_NUMBERS: usize = 13;

fn arguments(list: &[u8]) -> Vec<Vec<u8>> {
    list.split(|byte| *byte == b',').map(|argument| argument.trim_ascii().to_ascii_uppercase()).collect()
}

/// FGROUP(X,Y,Z): what a control without rotary axes does anyway.
fn is_default(name: &str, list: &[u8]) -> bool {
    let mut axes = arguments(list);
    axes.sort();
    name == "FGROUP" && axes == [b"X", b"Y", b"Z"]
}

/// `CYCLE800(FR, TC, ST, MODE, X0, Y0, Z0, A, B, C, X1, Y1, Z1, …)` for a new plane (the units of ST are 0) without shift or angle.
fn is_untilted(name: &str, list: &[u8]) -> bool {
    let all = arguments(list);
    let is_zero = |argument: &Vec<u8>| argument.is_empty() || number(argument, 0) == Some((argument.len(), 0.0));
    let is_new = |status: &Vec<u8>| status.iter().all(u8::is_ascii_digit) && (status.is_empty() || status.ends_with(b"0"));
    name == "CYCLE800"
        && all.get(2).is_some_and(is_new)
        && all.get(4..SWIVEL_NUMBERS).is_some_and(|numbers| numbers.iter().all(is_zero))
}

impl Reader<'_> {
    /// A word from here to `end`, behind which reading goes on.
    fn plain(&mut self, kind: WordKind, end: usize, name: Name) -> Word {
        let start = std::mem::replace(&mut self.at, end);
        Word { name, ..plain(kind, start, end, self.base) }
    }

    /// A word with a value from `value` to `end`.
    fn valued(&mut self, letter: u8, value: usize, end: usize, name: Name) -> Word {
        let value_start = offset(self.base, value);
        let read = number(self.line, value).filter(|(past, _)| *past == end);
        let kind = if read.is_some() { WordKind::Number } else { WordKind::Expression };
        let value = read.map_or(f64::NAN, |(_, value)| value);
        Word { value_start, letter, value, ..self.plain(kind, end, name) }
    }

    fn word(&mut self, byte: u8) -> Word {
        let (line, at) = (self.line, self.at);
        match byte {
            b';' => self.plain(WordKind::Comment, line.len(), Name::None),
            b'/' if self.at_head => {
                let digit = line.get(at + 1).is_some_and(u8::is_ascii_digit);
                self.plain(WordKind::BlockDelete, at + 1 + usize::from(digit), Name::None)
            }
            b':' if self.at_head && line.get(at + 1).is_some_and(u8::is_ascii_digit) => {
                let end = number(line, at + 1).map_or(at + 1, |(end, _)| end);
                self.valued(b'N', at + 1, end, Name::None)
            }
            b'$' => self.system_variable(),
            b'"' => self.plain(WordKind::Unknown, string_end(line, at), Name::None),
            b'(' => self.plain(WordKind::Unknown, bracket_end(line, at), Name::None),
            _ if byte.is_ascii_alphabetic() || byte == b'_' => {
                let next = line.get(at + 1).copied().unwrap_or_default();
                if byte == b'_' || next.is_ascii_alphabetic() || next == b'_' { self.named() } else { self.address(byte) }
            }
            _ => {
                let ends = |byte: &u8| is_blank(*byte) || byte.is_ascii_alphabetic() || b";\"($".contains(byte);
                let end = line[at + 1..].iter().position(ends).map_or(line.len(), |length| at + 1 + length);
                self.plain(WordKind::Unknown, end, Name::None)
            }
        }
    }

    /// An address letter with a value: `X10`, `X=R1`, `R1=5`, `S1=1000`.
    fn address(&mut self, byte: u8) -> Word {
        let (line, at) = (self.line, self.at);
        let letter = byte.to_ascii_uppercase();
        let digits = line[at + 1..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        let past = skip_blanks(line, at + 1 + digits);
        if assigns(line, past) {
            let Some(end) = expression_end(line, past + 1) else {
                return self.plain(WordKind::Unknown, past + 1, Name::None);
            };
            let value = skip_blanks(line, past + 1);
            return match &line[at + 1..at + 1 + digits] {
                [] => self.axis_value(letter, value, end),
                number => self.extended(letter, number, value, end),
            };
        }
        if digits == 0 && letter == b'R' && line.get(past) == Some(&b'[') {
            return self.variable(bracket_end(line, past));
        }
        let value = skip_blanks(line, at + 1);
        match number(line, value) {
            Some((end, _)) if line.get(past) != Some(&b'[') => self.valued(letter, value, end, Name::None),
            _ => {
                let end = if line.get(past) == Some(&b'[') { bracket_end(line, past) } else { at + 1 };
                self.plain(WordKind::Unknown, end, Name::None)
            }
        }
    }

    /// `X=10`, `X=IC(5)`, `T="MILL"`.
    fn axis_value(&mut self, letter: u8, value: usize, end: usize) -> Word {
        let of = name(self.line, value).to_ascii_uppercase();
        let name = match of.as_slice() {
            b"AC" => Name::Absolute,
            b"IC" => Name::Incremental,
            // The direction of a modulo axis, and positions from a table, are not interpreted.
            of if is_dimension(of) => Name::Geometry,
            _ => Name::None,
        };
        self.valued(letter, value, end, name)
    }

    /// An address with a number: R1=5 assigns, S1=1000 turns a spindle, A3=0 is part of an orientation.
    fn extended(&mut self, letter: u8, number: &[u8], value: usize, end: usize) -> Word {
        match letter {
            b'R' => self.plain(WordKind::Assignment, end, Name::None),
            b'T' | b'D' => self.valued(letter, value, end, Name::None),
            b'S' => self.valued(0, value, end, Name::Spindle),
            b'H' => self.valued(letter, value, end, Name::Silent),
            b'F' => self.valued(0, value, end, Name::Silent),
            b'M' => {
                let word = self.valued(0, value, end, Name::Silent);
                let known = word.number().is_some_and(|number| SPINDLE_M.contains(&number));
                if known { word } else { Word { kind: WordKind::Unknown, name: Name::None, ..word } }
            }
            b'I'..=b'K' if number == b"1" => self.valued(0, value, end, Name::Intermediate(letter - b'I')),
            _ => self.valued(0, value, end, Name::Geometry),
        }
    }

    fn system_variable(&mut self) -> Word {
        let (line, at) = (self.line, self.at);
        let mut end = at + 1 + name(line, at + 1).len();
        if line.get(end) == Some(&b'[') {
            end = bracket_end(line, end);
        }
        self.variable(end)
    }

    /// An assignment to the variable up to `past`, or a word that is not known.
    fn variable(&mut self, past: usize) -> Word {
        let equals = skip_blanks(self.line, past);
        if !assigns(self.line, equals) {
            return self.plain(WordKind::Unknown, past, Name::None);
        }
        match expression_end(self.line, equals + 1) {
            Some(end) => self.plain(WordKind::Assignment, end, Name::None),
            None => self.plain(WordKind::Unknown, equals + 1, Name::None),
        }
    }

    /// A name of several letters: a label, a statement, an address, a variable, a function, a subprogram.
    fn named(&mut self) -> Word {
        let (line, at) = (self.line, self.at);
        let text = String::from_utf8_lossy(name(line, at)).to_ascii_uppercase();
        let past = at + text.len();
        if self.at_head && line.get(past) == Some(&b':') && line.get(past + 1) != Some(&b'=') {
            return self.plain(WordKind::Keyword, past + 1, Name::Label);
        }
        let next = skip_blanks(line, past);
        if SYNCHRONIZED.contains(&text.as_str()) {
            return self.plain(WordKind::Unknown, statement_end(line, at), Name::None);
        }
        if STATEMENTS.contains(&text.as_str()) && !assigns(line, next) {
            return self.statement(&text, past);
        }
        if line.get(next) == Some(&b'[') && meaning(&text, true).is_none() {
            return self.variable(bracket_end(line, next));
        }
        let index = if line.get(next) == Some(&b'[') { bracket_end(line, next) } else { past };
        let equals = skip_blanks(line, index);
        if assigns(line, equals) {
            return self.named_value(&text, index, equals);
        }
        let (end, has_arguments) = match line.get(equals) {
            Some(b'(') => {
                let end = bracket_end(line, equals);
                let inside = line.get(equals + 1..end.saturating_sub(1)).unwrap_or_default();
                if is_untilted(&text, inside) {
                    return self.plain(WordKind::Keyword, end, Name::Untilted);
                }
                (end, inside.iter().any(|byte| !is_blank(*byte)) && !is_default(&text, inside))
            }
            _ => (index, false),
        };
        // Frames are stated by words. Rexroth has them in parentheses: `Trans(X10,Y5)`.
        let is_frame = |name: &Name| matches!(name, Name::Translate | Name::AddTranslate | Name::Replace | Name::Add);
        match meaning(&text, has_arguments).filter(|name| !(has_arguments && is_frame(name))) {
            Some(name) => self.plain(WordKind::Keyword, end, name),
            None => self.plain(WordKind::Unknown, end, Name::None),
        }
    }

    fn statement(&mut self, text: &str, past: usize) -> Word {
        let end = statement_end(self.line, self.at);
        if text != "MCALL" {
            return self.plain(WordKind::Flow, end, Name::None);
        }
        let name = meaning(text, skip_blanks(self.line, past) < end).unwrap_or_default();
        self.plain(WordKind::Keyword, end, name)
    }

    /// A name with a value: `CR=5` is the radius of an arc, others are addresses or variables.
    fn named_value(&mut self, text: &str, index: usize, equals: usize) -> Word {
        let Some(end) = expression_end(self.line, equals + 1) else {
            return self.plain(WordKind::Unknown, equals + 1, Name::None);
        };
        let value = skip_blanks(self.line, equals + 1);
        match (text, meaning(text, true)) {
            ("CR", _) => self.valued(b'R', value, end, Name::None),
            // Coefficients of a polynomial.
            (_, Some(name)) if self.line.get(value..end).is_some_and(|list| list.starts_with(b"(") && list.contains(&b',')) => {
                self.plain(WordKind::Keyword, end, name)
            }
            ("LEAD" | "TILT" | "THETA" | "PHI" | "PSI", _) => self.valued(0, value, end, Name::Geometry),
            (_, Some(Name::Silent)) => self.valued(0, value, end, Name::Silent),
            (_, Some(name)) => self.valued(0, value, end, name),
            (_, None) => self.variable(index),
        }
    }
}
