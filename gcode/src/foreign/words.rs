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
    if has_commands_in_parentheses(program) {
        return Some(Foreign::Parenthesised);
    }
    lathe_sign(program).map(Foreign::Lathe)
}

/// Commands in parentheses of OSAI and Acramatic controls that shift, turn, mirror or scale what follows, repeat or call it, or jump, as their users and
/// post-processors write them: a name of three letters and its first argument.
const COMMANDS: [&[u8]; 17] = [
    b"UTO", b"UIO", b"UAO", b"ROT", b"URT", b"MIR", b"INV", b"SCF", b"RPT", b"GTO", b"CLS", b"CLD", b"EPP", b"EPB", b"DFS",
    b"UPR", b"TCP",
];

/// Whether comments are such commands. An origin may be selected before the first motion, as by G54.
fn has_commands_in_parentheses(program: &Program) -> bool {
    let words = program.words();
    let first = words.iter().position(|word| [b'X', b'Y', b'Z'].iter().any(|letter| word.is(*letter))).unwrap_or(words.len());
    let is_command = |(at, word): (usize, &Word)| {
        let Some(text) = (word.kind == WordKind::Comment).then(|| inside(program.text(word.span))).flatten() else {
            return false;
        };
        let Some((name, rest)) = text.split_at_checked(3) else { return false };
        let argument = rest.strip_prefix(b",").and_then(|rest| rest.trim_ascii_start().first());
        let has_argument = argument.is_some_and(|first| first.is_ascii_alphanumeric() || b"+-.\"".contains(first));
        has_argument && COMMANDS.contains(&name) && (name != b"UAO" || at > first)
    };
    words.iter().enumerate().any(is_command)
}

/// Blocks in parentheses that a Fagor control executes: calls, jumps, and subroutines up to their `(RET)`. An assignment such as `(P1=10)` may be a
/// comment; where its parameter is used, as in `XP1`, the interpreter refuses the move.
fn is_fagor(program: &Program) -> bool {
    let comments = program.words().iter().filter(|word| word.kind == WordKind::Comment);
    let inner: Vec<_> = comments.filter_map(|word| inside(program.text(word.span))).collect();
    let returns = inner.iter().any(|text| text == b"RET");
    inner.iter().any(|text| is_executed(text) || (returns && is_behind(text, b"SUB ", is_number)))
}

/// The text within parentheses, in capitals.
fn inside(comment: &[u8]) -> Option<Vec<u8>> {
    Some(comment.strip_prefix(b"(")?.strip_suffix(b")")?.trim_ascii().to_ascii_uppercase())
}

/// `CALL 5`, `MCALL 5`, `PCALL 5,P0=2`, `GOTO N100`, `RPT N60,N70`, `IF P1 GT 5 GOTO N100`.
fn is_executed(text: &[u8]) -> bool {
    let has_number = |rest: &[u8]| is_number(&rest[..rest.iter().position(|byte| *byte == b',').unwrap_or(rest.len())]);
    let is_label = |rest: &[u8]| rest.strip_prefix(b"N").and_then(<[u8]>::first).is_some_and(u8::is_ascii_digit);
    [&b"CALL "[..], b"MCALL "].iter().any(|name| is_behind(text, name, is_number))
        || is_behind(text, b"PCALL ", has_number)
        || [&b"GOTO "[..], b"RPT "].iter().any(|name| is_behind(text, name, is_label))
        || (text.starts_with(b"IF ") && text.windows(7).any(|run| run.starts_with(b"GOTO N") && run[6].is_ascii_digit()))
}

fn is_behind(text: &[u8], name: &[u8], fits: impl Fn(&[u8]) -> bool) -> bool {
    text.strip_prefix(name).is_some_and(|rest| fits(rest.trim_ascii()))
}

fn is_number(text: &[u8]) -> bool {
    !text.is_empty() && text.iter().all(u8::is_ascii_digit)
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

/// The first sign of a lathe. In a program that states G8, LinuxCNC's radius mode, X is a radius.
fn lathe_sign(program: &Program) -> Option<&'static str> {
    let words = || program.words().iter();
    let names = |letter: u8| words().any(|word| word.is(letter));
    let in_radii = blocks(program).any(|words| has_code(words, b'G', &[8.0]) && !has(words, b'P'));
    if !names(b'X') || !names(b'Z') || in_radii {
        return None;
    }
    let any = |is: &dyn Fn(&[Word]) -> bool| blocks(program).any(is);
    let turning = |words: &[Word]| has_code(words, b'G', &TURNING_CYCLES) && has(words, b'P') && has(words, b'Q');
    let limits_speed = |words: &[Word]| has_code(words, b'G', &[50.0, 92.0]) && has(words, b'S') && !has(words, b'X');
    // Mills change tools by M6, or measure their length.
    let in_mill = || any(&|words| has_code(words, b'M', &[6.0]) || has_code(words, b'G', &[43.0, 44.0]));
    let in_turret = || words().any(|word| is_tool_and_offset(program, word)) && !in_mill();
    let increments = |letters: &[u8]| letters.iter().any(|letter| names(*letter));
    if names(b'Y') {
        // Of a lathe with a Y axis the turret alone says it, together with increments or a speed that follows the diameter.
        let others = any(&limits_speed) || any(&has_constant_speed) || increments(b"UVW");
        return (others && in_turret()).then_some("tools with offsets, and U, W or G96");
    }
    let four_digits = |word: &Word| is_number(program.text(word.value_span())) && word.value_span().len() == 4;
    let selects_offset = || words().any(|word| word.kind == WordKind::Number && word.is(b'T') && four_digits(word));
    if any(&turning) {
        Some("no Y; G70 to G73 with P and Q")
    } else if any(&|words| has_code(words, b'G', &[7.0])) {
        Some("no Y; G7")
    } else if any(&has_constant_speed) {
        Some("no Y; G96")
    } else if any(&limits_speed) {
        Some("no Y; G50 S")
    } else if any(&|words| has_code(words, b'G', &[28.0, 30.0]) && (has(words, b'U') || has(words, b'W'))) {
        Some("no Y; G28 with U or W")
    } else if selects_offset() && increments(b"UW") {
        Some("no Y; tools with offsets, U and W")
    } else if in_turret() {
        Some("no Y; tools with offsets, without M6")
    } else {
        None
    }
}

fn has_constant_speed(words: &[Word]) -> bool {
    has_code(words, b'G', &[96.0])
}

/// A tool of a turret with its offset, which lathes select by one word: `T0303`, `T0312`, `T101` (Haas), `T010101` (Okuma). Tools of mills have such
/// numbers only by chance: no other number begins with a zero, or repeats itself.
fn is_tool_and_offset(program: &Program, word: &Word) -> bool {
    // Mazak selects the same tool again by `T0101.1`.
    let digits = program.text(word.value_span()).split(|byte| *byte == b'.').next().unwrap_or_default();
    let is_tool = word.kind == WordKind::Number && word.is(b'T') && digits.iter().all(u8::is_ascii_digit);
    let number = |digits: &[u8]| digits.iter().fold(0_u32, |number, digit| 10 * number + u32::from(digit - b'0'));
    is_tool
        && match digits.len() {
            3 => digits[0] != b'0' && number(&digits[..1]) == number(&digits[1..]),
            4 => number(&digits[..2]) > 0 && (digits[0] == b'0' || digits[..2] == digits[2..]),
            6 => number(&digits[..2]) > 0 && digits[..2] == digits[2..4],
            _ => false,
        }
}
