//! Recognition by the words of a program: 3D printers and lathes.

use super::kind::Foreign;
use crate::program::Program;
use crate::word::{Word, WordKind};

/// Nozzle and bed temperature, extruder mode.
const PRINTER_CODES: [f64; 6] = [82.0, 83.0, 104.0, 109.0, 140.0, 190.0];
/// Lathe cycles, which have P and Q: roughing, facing, pattern, finishing.
const TURNING_CYCLES: [f64; 4] = [70.0, 71.0, 72.0, 73.0];

/// Recognises a program by its words.
pub(super) fn recognise(program: &Program) -> Option<Foreign> {
    if is_printer(program) {
        return Some(Foreign::Printer);
    }
    if is_fagor(program) {
        return Some(Foreign::Fagor);
    }
    lathe_sign(program).map(Foreign::Lathe)
}

/// Blocks in parentheses that a Fagor control executes (CNC 8055, Programming Manual, "Programming in high-level language").
fn is_fagor(program: &Program) -> bool {
    let mut comments = program.words().iter().filter(|word| word.kind == WordKind::Comment);
    comments.any(|word| is_high_level(&program.text(word.span).to_ascii_uppercase()))
}

/// `(P1=10)`, `(CALL 5)`, `(PCALL 5,P0=2)`, `(MCALL 5)`, `(SUB 5)`, `(GOTO N100)`, `(RPT N60,N70)`, `(IF P1 GT 5 GOTO N100)`.
fn is_high_level(comment: &[u8]) -> bool {
    let Some(text) = comment.strip_prefix(b"(").and_then(|text| text.strip_suffix(b")")) else { return false };
    let is_number = |text: &[u8]| !text.is_empty() && text.iter().all(u8::is_ascii_digit);
    let behind = |name: &[u8]| text.strip_prefix(name).map(<[u8]>::trim_ascii);
    let first = |text: &[u8]| -> usize { text.iter().take_while(|byte| byte.is_ascii_digit()).count() };
    let is_call = [&b"CALL "[..], b"SUB ", b"MCALL "].iter().any(|name| behind(name).is_some_and(is_number))
        || behind(b"PCALL ").is_some_and(|rest| first(rest) > 0 && (is_number(rest) || rest.get(first(rest)) == Some(&b',')));
    let is_label = |rest: &[u8]| rest.strip_prefix(b"N").is_some_and(|rest| first(rest) > 0);
    let jumps = [&b"GOTO "[..], b"RPT "].iter().any(|name| behind(name).is_some_and(is_label))
        || (text.starts_with(b"IF ") && text.windows(7).any(|run| run.starts_with(b"GOTO N") && run[6].is_ascii_digit()));
    let is_value = |text: &[u8]| !text.is_empty() && text.iter().all(|byte| byte.is_ascii_digit() || b"P.+-*/() ".contains(byte));
    let assigns = text.strip_prefix(b"P").is_some_and(|rest| {
        let value = rest[first(rest)..].trim_ascii().strip_prefix(b"=");
        first(rest) > 0 && value.is_some_and(|value| is_value(value.trim_ascii()))
    });
    is_call || jumps || assigns
}

fn blocks(program: &Program) -> impl Iterator<Item = &[Word]> {
    (0..program.blocks().len()).map(|block| program.block_words(block))
}

fn has(words: &[Word], letter: u8) -> bool {
    words.iter().any(|word| word.is(letter))
}

fn has_code(words: &[Word], letter: u8, codes: &[f64]) -> bool {
    words.iter().any(|word| word.is(letter) && codes.contains(&word.value))
}

/// A printer pushes material with E in its moves, and heats the nozzle.
fn is_printer(program: &Program) -> bool {
    let heats = blocks(program).any(|words| has_code(words, b'M', &PRINTER_CODES));
    heats && blocks(program).any(|words| has_code(words, b'G', &[0.0, 1.0]) && has(words, b'E'))
}

/// The first sign of a lathe in a program that never names Y. In a program that states G8, LinuxCNC's radius mode, X is a radius.
fn lathe_sign(program: &Program) -> Option<&'static str> {
    let words = || program.words().iter();
    let names = |letter: u8| words().any(|word| word.is(letter));
    let in_radii = blocks(program).any(|words| has_code(words, b'G', &[8.0]) && !has(words, b'P'));
    if !names(b'X') || !names(b'Z') || names(b'Y') || in_radii {
        return None;
    }
    let turning = |words: &[Word]| has_code(words, b'G', &TURNING_CYCLES) && has(words, b'P') && has(words, b'Q');
    let limits_speed = |words: &[Word]| has_code(words, b'G', &[50.0, 92.0]) && has(words, b'S') && !has(words, b'X');
    let tool_and_offset = |word: &Word| {
        let digits = program.text(word.value_span());
        word.kind == WordKind::Number && word.is(b'T') && digits.len() == 4 && digits.iter().all(u8::is_ascii_digit)
    };
    if blocks(program).any(turning) {
        Some("G70 to G73 with P and Q")
    } else if blocks(program).any(|words| has_code(words, b'G', &[7.0])) {
        Some("G7")
    } else if blocks(program).any(|words| has_code(words, b'G', &[96.0])) {
        Some("G96")
    } else if blocks(program).any(limits_speed) {
        Some("G50 S")
    } else if words().any(tool_and_offset) && (names(b'U') || names(b'W')) {
        Some("tools with offsets, U and W")
    } else {
        None
    }
}
