//! Coordinates without a decimal point: their value in increments, and programs whose reading is open.

use crate::diagnostic::{Diagnostic, Severity};
use crate::dialect::{DecimalPoint, Dialect, Options};
use crate::interpret::{Reader, interpret};
use crate::modal::Units;
use crate::program::{Language, Program};
use crate::word::{Word, WordKind};

/// Letters of coordinates, which have a least input increment.
const COORDINATES: &[u8] = b"XYZABCIJKRUVW";
/// The same in canned cycles, where K is a number of repetitions and Q the depth of a peck or a shift.
const CYCLE_COORDINATES: &[u8] = b"XYZABCIJRUVWQ";
/// The same beside codes that have switches and levels in Q and R: contour control, look-ahead (Fanuc 0i-F, "AI contour control").
const AXES: &[u8] = b"XYZABCUVW";
const SWITCHING_G: [f64; 4] = [5.0, 5.1, 8.0, 187.0];

/// Least input increment of a length, program units (IS-B).
pub fn length_increment(units: Units) -> f64 {
    match units {
        Units::Mm => 1e-3,
        Units::Inch => 1e-4,
    }
}

/// Least input increment of an angle, degrees (IS-B).
pub const ANGLE_INCREMENT: f64 = 1e-3;

/// Whether the number of a word has a decimal point. The value of a variable counts as if it had one: with `#101=15`, `X#101` is X15. (Fanuc 0i-F
/// Operator's Manual, "Custom Macro", "Variables").
pub(crate) fn has_point(program: &Program, word: &Word) -> bool {
    word.kind == WordKind::Expression || program.text(word.value_span()).contains(&b'.')
}

/// The coordinates of a program that are numbers other than 0.
fn coordinates(program: &Program) -> impl Iterator<Item = &Word> {
    let mut in_cycle = false;
    let mut has_begun = false;
    // What stands behind the end of the tape is no program.
    let is_program = move |block: &usize| {
        let (signs, words): (Vec<&Word>, Vec<&Word>) =
            program.block_words(*block).iter().partition(|word| word.kind == WordKind::Percent);
        let ends = has_begun && !signs.is_empty();
        has_begun |= !words.is_empty();
        !ends
    };
    (0..program.blocks().len()).take_while(is_program).flat_map(move |block| {
        let words = program.block_words(block);
        let codes = || words.iter().filter(|word| word.is(b'G')).map(|word| word.value);
        for code in codes() {
            match code {
                73.0..=89.0 => in_cycle = code != 80.0,
                0.0..=3.0 => in_cycle = false,
                _ => {}
            }
        }
        let letters = match in_cycle {
            _ if codes().any(|code| SWITCHING_G.contains(&code)) => AXES,
            true => CYCLE_COORDINATES,
            false => COORDINATES,
        };
        words.iter().filter(|word| letters.contains(&word.letter) && word.number().is_some_and(|value| value != 0.0))
    })
}

/// Whether the program writes coordinates, and none of them with a decimal point.
pub fn is_integer_program(program: &Program) -> bool {
    coordinates(program).next().is_some() && !coordinates(program).any(|word| has_point(program, word))
}

/// Moves that are held at a time.
const BLOCKS: usize = 4096;

/// Whether a program has no fault that [`interpret`] reports. The moves of a long one are not held.
fn is_read(program: &Program, options: &Options) -> bool {
    let Some(mut reader) = Reader::new(program, options) else { return interpret(program, options).is_ok() };
    while reader.read(BLOCKS).is_some() {}
    match reader.finish() {
        Ok(Some(_)) => true,
        Ok(None) => interpret(program, options).is_ok(),
        Err(_) => false,
    }
}

/// The first coordinate without a decimal point, as an error, where nothing decides how the control reads it: the
/// dialect knows both readings, and the arcs of the program fit both or neither.
pub fn undecided_point(program: &Program, options: &Options) -> Option<Diagnostic> {
    if options.dialect != Dialect::Fanuc || program.language() == Language::Dialogue {
        return None;
    }
    let word = coordinates(program).find(|word| !has_point(program, word))?;
    let is_read = |decimal_point| is_read(program, &Options { decimal_point, ..*options });
    if is_read(DecimalPoint::Unit) && !is_read(DecimalPoint::LeastIncrement) {
        return None;
    }
    Some(question(program, word))
}

/// Largest coordinate of a machine, in units: gantry machines are shorter than 10 m.
const LARGEST_UNITS: f64 = 1e4;

/// The first coordinate without a decimal point that lies beyond any machine if it counts units, as an error. A machine description whose
/// control reads units does not fit such a program.
pub fn oversized_point(program: &Program, options: &Options) -> Option<Diagnostic> {
    if options.dialect != Dialect::Fanuc || program.language() == Language::Dialogue {
        return None;
    }
    // Rotary axes may turn without end.
    let is_length = |word: &Word| !b"ABC".contains(&word.letter);
    let is_large = |word: &&Word| is_length(word) && !has_point(program, word) && word.value.abs() > LARGEST_UNITS;
    let word = coordinates(program).find(is_large)?;
    Some(question(program, word))
}

/// The question how a coordinate is read.
fn question(program: &Program, word: &Word) -> Diagnostic {
    let text = String::from_utf8_lossy(program.text(word.span)).into_owned();
    let value = word.value;
    let message = format!("{text} has no decimal point: controls read it as {value} or as {} mm", value * 1e-3);
    let help =
        "state --decimal-point unit, or --decimal-point least-increment (0.001 mm, 0.0001 in, 0.001°), as the control is set";
    Diagnostic::new(program, Severity::Error, word.span, message).with_help(help)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parse;

    fn is_open(text: &str, dialect: Dialect) -> bool {
        undecided_point(&parse(text), &dialect.into()).is_some()
    }

    #[test]
    fn only_a_program_that_can_be_read_in_two_ways_is_open() {
        let integers = "G21 G90\nG0 X0 Y0 Z0\nG1 X50 F600\nM30\n";
        assert!(is_open(integers, Dialect::Fanuc) && !is_open(integers, Dialect::LinuxCnc));
        assert!(is_open(&integers.replace("Y0", "Y1.5"), Dialect::Fanuc), "a mixed program");
        let remark = "%\nO1\nG21 G90\nG0 X0. Y0. Z0.\nG1 X50. F600.\nM30\n%\nDATUM 12.11 X5\n";
        assert!(!is_open(remark, Dialect::Fanuc), "behind the end of the tape");
        assert!(!is_open(&integers.replace("X50", "X50."), Dialect::Fanuc), "zero is zero in both readings");
        // 5 µm and 5.25 mm make no circle.
        let arc = "G21 G90\nG0 X0. Y0. Z0.\nG1 X10 F600\nG2 X10. Y10.5 I0 J5.25\nM30\n";
        assert!(!is_open(arc, Dialect::Fanuc));
        assert!(is_open(&arc.replace("X10. Y10.5", "X10 Y10").replace("5.25", "5"), Dialect::Fanuc));
    }

    #[test]
    fn coordinates_beyond_any_machine_are_a_question_of_their_own() {
        let asks = |text: &str, dialect: Dialect| oversized_point(&parse(text), &dialect.into()).is_some();
        let integers = "O1\nG21 G90\nG0 X0 Y0 Z0\nG1 X40000 F600\nY40000\nM30\n";
        assert!(asks(integers, Dialect::Fanuc) && is_open(integers, Dialect::Fanuc));
        assert!(!asks(integers, Dialect::LinuxCnc));
        for text in [
            integers.replace("40000", "4000"),
            integers.replace("40000", "40000."),
            integers.replace("Y40000", "S40000 M3").replace("X40000", "A36000"),
        ] {
            assert!(!asks(&text, Dialect::Fanuc), "{text}");
        }
    }

    #[test]
    fn switches_and_repetitions_are_no_coordinates() {
        let head = "G21 G90\nG0 X0. Y0. Z5.\n";
        for text in ["G5.1 Q1 R5\nG1 X5. F600\n", "G81 X1. Z-1. R1. K3 F100\nX2. K2\nG80\n", "G1 X5. F600 P1\n"] {
            assert!(
                !coordinates(&parse(format!("{head}{text}"))).any(|word| !has_point(&parse(format!("{head}{text}")), word)),
                "{text}"
            );
        }
        assert!(is_open(&format!("{head}G83 Z-9. R1. Q2 F100\nG80\n"), Dialect::Fanuc));
        assert!(is_open(&format!("{head}G18 G2 X5. K3 F100\n"), Dialect::Fanuc));
    }

    #[test]
    fn increments_are_thousandths() {
        let options = Options { decimal_point: DecimalPoint::LeastIncrement, ..Dialect::Fanuc.into() };
        let text = "G21 G90\nG0 X0 Y0 Z0\nG1 X50000 F600\nG3 Y20000 J10000\nG1 X1.5\nG20 X10000 F20.\nM30\n";
        let path = interpret(&parse(text), &options).expect("accepted");
        let x = |index: usize| path.moves[index].end.nominal_mm()[0];
        assert_eq!([x(1), x(2), x(3)], [50.0, 50.0, 1.5]);
        assert!((x(4) - 25.4).abs() < 1e-9);
    }
}
