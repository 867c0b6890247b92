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
    lathe_sign(program).map(Foreign::Lathe)
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
