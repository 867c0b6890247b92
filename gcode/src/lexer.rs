//! Splits one line into words. Total: every non-blank byte belongs to exactly one word.

use crate::number::{is_blank, scan_number, skip_blanks};
use crate::word::{Word, WordKind, offset, plain};

/// Functions whose bracketed argument may follow a letter or be part of an expression.
const FUNCTIONS: [&[u8]; 17] = [
    b"ABS", b"ACOS", b"ADP", b"ASIN", b"ATAN", b"BCD", b"BIN", b"COS", b"EXISTS", b"EXP", b"FIX", b"FUP", b"LN", b"POW",
    b"ROUND", b"SIN", b"TAN",
];
/// Words that open a macro statement.
const STATEMENTS: [&[u8]; 9] = [b"IF", b"THEN", b"ELSE", b"ENDIF", b"GOTO", b"WHILE", b"DO", b"END", b"GOTOF"];
/// Keywords after the number of an O-word.
pub(crate) const O_KEYWORDS: [&[u8]; 15] = [
    b"SUB",
    b"ENDSUB",
    b"CALL",
    b"RETURN",
    b"IF",
    b"ELSEIF",
    b"ELSE",
    b"ENDIF",
    b"WHILE",
    b"ENDWHILE",
    b"DO",
    b"REPEAT",
    b"ENDREPEAT",
    b"BREAK",
    b"CONTINUE",
];
/// Output to an interface (Fanuc 0i-F Operator's Manual, "External output commands").
const OUTPUTS: [&[u8]; 4] = [b"BPRNT", b"DPRNT", b"PCLOS", b"POPEN"];
/// Operators between the terms of an unbracketed expression.
const OPERATORS: [&[u8]; 10] = [b"AND", b"OR", b"XOR", b"MOD", b"EQ", b"NE", b"GT", b"GE", b"LT", b"LE"];

fn listed(list: &[&[u8]], text: &[u8]) -> bool {
    list.iter().any(|entry| entry.eq_ignore_ascii_case(text))
}

/// Whether the text of a word is output to an interface.
pub(crate) fn is_output(text: &[u8]) -> bool {
    listed(&OUTPUTS, letters(text, 0))
}

/// The run of ASCII letters at `at`.
pub(crate) fn letters(line: &[u8], at: usize) -> &[u8] {
    let rest = line.get(at..).unwrap_or_default();
    let length = rest.iter().position(|b| !b.is_ascii_alphabetic()).unwrap_or(rest.len());
    &rest[..length]
}

/// Splits `line`, whose first byte is at offset `base` of the program, and appends its words.
pub(crate) fn lex_line(line: &[u8], base: u32, words: &mut Vec<Word>) {
    // Block delete is at the start, before or after the line number.
    let mut at_head = true;
    let mut at = 0;
    while let Some(&byte) = line.get(at) {
        if is_blank(byte) {
            at += 1;
            continue;
        }
        let (kind, end) = match byte {
            b'(' => (WordKind::Comment, comment_end(line, at)),
            b';' => (WordKind::Comment, line.len()),
            b'%' => (WordKind::Percent, at + 1),
            b'/' if is_slash_comment(line, at, at_head) => (WordKind::Comment, line.len()),
            b'/' if at_head => (WordKind::BlockDelete, delete_end(line, at)),
            b'#' => assignment(line, at),
            _ if byte.is_ascii_alphabetic() => {
                let word = address(line, at, base);
                at = (word.span.end - base) as usize;
                at_head &= word.is(b'N');
                words.push(word);
                continue;
            }
            _ => (WordKind::Unknown, unknown_end(line, at)),
        };
        words.push(plain(kind, at, end, base));
        at_head = false;
        at = end;
    }
}

fn comment_end(line: &[u8], at: usize) -> usize {
    line[at..].iter().position(|b| *b == b')').map_or(line.len(), |close| at + close + 1)
}

/// Whether `//` begins a comment, as some CAM systems write it. At the head of a line it may be block delete: there it is none where words of
/// a block follow.
fn is_slash_comment(line: &[u8], at: usize, at_head: bool) -> bool {
    let has_words = |text: &[u8]| {
        let mut at = 0;
        std::iter::from_fn(|| {
            at += text[at..].iter().position(u8::is_ascii_alphabetic)?;
            let run = letters(text, at).len();
            at += run;
            Some(run == 1 && scan_number(text, skip_blanks(text, at)).is_some())
        })
        .any(|is_word| is_word)
    };
    line[at..].starts_with(b"//") && !(at_head && has_words(&line[at..]))
}

fn delete_end(line: &[u8], at: usize) -> usize {
    at + 1 + usize::from(line.get(at + 1).is_some_and(u8::is_ascii_digit))
}

/// A statement extends to the next comment behind which no bracket goes on with it, or to the end of the line.
fn statement_end(line: &[u8], at: usize) -> usize {
    let mut end = at;
    loop {
        end += line[end..].iter().position(|b| matches!(b, b'(' | b';')).unwrap_or(line.len() - end);
        let past = comment_end(line, end);
        let goes_on = line.get(end) == Some(&b'(') && line.get(skip_blanks(line, past)) == Some(&b'[');
        if !goes_on {
            break;
        }
        end = past;
    }
    while end > at + 1 && is_blank(line[end - 1]) {
        end -= 1;
    }
    end
}

/// Bytes that are not interpreted. `,R5.` and `=3` stay one word.
fn unknown_end(line: &[u8], at: usize) -> usize {
    let mut end = at + 1;
    if matches!(line[at], b',' | b'=') {
        let value = end + letters(line, end).len();
        return scan_number(line, value).map_or(value, |(past, _)| past).max(end);
    }
    while line.get(end).is_some_and(|b| !is_blank(*b) && !b.is_ascii_alphabetic() && !b"(;%/#,=".contains(b)) {
        end += 1;
    }
    end
}

fn address(line: &[u8], at: usize, base: u32) -> Word {
    let run = letters(line, at);
    if run.len() > 1 && listed(&STATEMENTS, run) {
        return plain(WordKind::Flow, at, statement_end(line, at), base);
    }
    if listed(&OUTPUTS, run) {
        let value = skip_blanks(line, at + run.len());
        let end = if line.get(value) == Some(&b'[') { bracket_end(line, value) } else { at + run.len() };
        return plain(WordKind::Unknown, at, end, base);
    }
    let letter = line[at].to_ascii_uppercase();
    if letter == b'O' && is_o_word(line, at + 1) {
        return plain(WordKind::Flow, at, statement_end(line, at), base);
    }
    let value_at = skip_blanks(line, at + 1);
    let (kind, end, value) = if let Some((end, value)) = scan_number(line, value_at) {
        (WordKind::Number, end, value)
    } else if let Some(end) = term_end(line, value_at) {
        (WordKind::Expression, end, f64::NAN)
    } else {
        return plain(WordKind::Unknown, at, at + run.len(), base);
    };
    Word { value_start: offset(base, value_at), letter, value, ..plain(kind, at, end, base) }
}

/// Whether an `O` begins an O-word (`100 sub`, `<name> call`, `#1 call`), not a program number.
fn is_o_word(line: &[u8], after: usize) -> bool {
    let at = skip_blanks(line, after);
    match line.get(at) {
        Some(b'<' | b'#' | b'[') => true,
        Some(byte) if byte.is_ascii_digit() => {
            let past = line[at..].iter().position(|b| !b.is_ascii_digit()).map_or(line.len(), |length| at + length);
            let first = skip_blanks(line, past);
            let word = letters(line, first);
            // Blanks count nowhere: `100 end sub`.
            let next = letters(line, skip_blanks(line, first + word.len()));
            listed(&O_KEYWORDS, word) || listed(&O_KEYWORDS, &[word, next].concat())
        }
        _ => false,
    }
}

/// End of a parameter, bracket, function call or number at `at`, leading signs included.
fn term_end(line: &[u8], at: usize) -> Option<usize> {
    let mut at = skip_blanks(line, at);
    while matches!(line.get(at), Some(b'+' | b'-')) {
        at = skip_blanks(line, at + 1);
    }
    match line.get(at)? {
        b'[' => Some(bracket_end(line, at)),
        b'#' => parameter_end(line, at),
        b'.' | b'0'..=b'9' => scan_number(line, at).map(|(end, _)| end),
        _ => {
            let name = letters(line, at);
            let open = skip_blanks(line, at + name.len());
            let call = (listed(&FUNCTIONS, name) || name.eq_ignore_ascii_case(b"SQRT")) && line.get(open) == Some(&b'[');
            call.then(|| function_end(line, open, name))
        }
    }
}

/// End of a function call whose bracket opens at `open`. `ATAN[1]/[2]` has two brackets.
fn function_end(line: &[u8], open: usize, name: &[u8]) -> usize {
    let end = bracket_end(line, open);
    let slash = skip_blanks(line, end);
    let second = skip_blanks(line, slash + 1);
    let is_pair = name.eq_ignore_ascii_case(b"ATAN") && line.get(slash) == Some(&b'/') && line.get(second) == Some(&b'[');
    if is_pair { bracket_end(line, second) } else { end }
}

fn bracket_end(line: &[u8], at: usize) -> usize {
    let mut depth = 0_usize;
    for (index, byte) in line[at..].iter().enumerate() {
        match byte {
            b'[' => depth += 1,
            b']' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at + index + 1;
        }
    }
    line.len()
}

/// End of `#101`, `##101`, `#<name>`, `#[#1+2]`.
fn parameter_end(line: &[u8], at: usize) -> Option<usize> {
    let mut at = at;
    while line.get(at) == Some(&b'#') {
        at += 1;
    }
    at = skip_blanks(line, at);
    match line.get(at)? {
        b'<' => Some(line[at..].iter().position(|b| *b == b'>').map_or(line.len(), |close| at + close + 1)),
        b'[' => Some(bracket_end(line, at)),
        b'0'..=b'9' => Some(line[at..].iter().position(|b| !b.is_ascii_digit()).map_or(line.len(), |length| at + length)),
        _ => None,
    }
}

fn assignment(line: &[u8], at: usize) -> (WordKind, usize) {
    let Some(name_end) = parameter_end(line, at) else {
        let marks = line[at..].iter().position(|b| *b != b'#').unwrap_or(line.len() - at);
        return (WordKind::Unknown, at + marks);
    };
    let equals = skip_blanks(line, name_end);
    if line.get(equals) != Some(&b'=') {
        return (WordKind::Unknown, name_end);
    }
    let Some(mut end) = term_end(line, equals + 1) else {
        return (WordKind::Unknown, equals + 1);
    };
    // `#1 = #2 * 3 MOD 4`: terms joined by operators. Text without an operator before it is the
    // next word.
    loop {
        let operator = skip_blanks(line, end);
        let length = match line.get(operator) {
            Some(b'+' | b'-' | b'*' | b'/') => 1,
            _ if listed(&OPERATORS, letters(line, operator)) => letters(line, operator).len(),
            _ => return (WordKind::Assignment, end),
        };
        match term_end(line, operator + length) {
            Some(past) => end = past,
            None => return (WordKind::Assignment, end),
        }
    }
}
