//! Words of written lines, in the language of their program.

use gcode::{Language, Move, Program, Word, WordKind, append_number};

use crate::error::Result;

/// Decimals of a feed: those of RS-274 controls, and those of dialogue (TNC 640, Technical Information).
const FEED_DECIMALS: usize = 4;
const DIALOGUE_FEED_DECIMALS: usize = 3;

/// How numbers and path functions are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Notation {
    /// `G1X1.5Y-2.F600.`, which SINUMERIK reads too: no axis of a letter needs an equals sign before a number.
    Rs274,
    /// `L X+1.5 Y-2 F600`, with the decimal point or comma of the program.
    Dialogue {
        /// Point or comma.
        mark: char,
    },
}

impl Notation {
    /// Notation of a program.
    pub(super) fn of(program: &Program) -> Self {
        let text = |word: &gcode::Word| program.text(word.value_span());
        let is_value = |word: &&gcode::Word| matches!(word.kind, WordKind::Number | WordKind::Motion);
        let mark =
            || program.words().iter().filter(is_value).find_map(|word| text(word).iter().find(|byte| b".,".contains(byte)));
        match program.language() {
            Language::Rs274 | Language::Sinumerik => Self::Rs274,
            Language::Dialogue => Self::Dialogue { mark: if mark() == Some(&b',') { ',' } else { '.' } },
        }
    }

    /// Appends a coordinate word. Returns its value as read.
    pub(super) fn append_coordinate(self, text: &mut String, letter: char, value: f64, decimals: usize) -> Result<f64> {
        let Self::Dialogue { mark } = self else {
            text.push(letter);
            return Ok(append_number(text, value, decimals)?);
        };
        let mut number = String::new();
        let read = append_number(&mut number, value, decimals)?;
        let sign = if number.starts_with('-') { "" } else { "+" };
        text.extend([" ", letter.encode_utf8(&mut [0; 4]), sign, &with_mark(&number, mark)]);
        Ok(read)
    }

    /// Appends an F word.
    pub(super) fn append_feed(self, text: &mut String, feed: f64) -> Result<()> {
        let Self::Dialogue { mark } = self else {
            text.push('F');
            append_number(text, feed, FEED_DECIMALS)?;
            return Ok(());
        };
        let mut number = String::new();
        append_number(&mut number, feed, DIALOGUE_FEED_DECIMALS)?;
        text.extend([" F", &with_mark(&number, mark)]);
        Ok(())
    }

    /// Appends the program's own feed word.
    pub(super) fn append_own_feed(self, text: &mut String, word: &str) {
        if self != Self::Rs274 {
            text.push(' ');
        }
        text.push_str(word);
    }

    /// Whether the block of a move of dialogue takes the feed of the tool call: `F AUTO`.
    pub(super) fn takes_feed_of_tool(self, program: &Program, step: &Move) -> bool {
        let is_auto = |word: &Word| [&b"AUTO"[..], b"FAUTO"].contains(&program.text(word.span).to_ascii_uppercase().as_slice());
        self != Self::Rs274 && program.block_words(step.block as usize).iter().any(is_auto)
    }

    /// Appends R0 where the block of a move states it. It stands between coordinates and feed.
    pub(super) fn append_compensation_off(self, text: &mut String, program: &Program, step: &Move) {
        let states = || program.block_words(step.block as usize).iter().any(|word| word.is(b'R') && word.value == 0.0);
        if self != Self::Rs274 && states() {
            text.push_str(" R0");
        }
    }

    /// A line with nothing but this feed, as [`Self::append_feed`] writes it.
    pub(super) fn feed_line(self, feed: f64) -> Result<String> {
        if self == Self::Rs274 {
            return Ok(format!("F{}", gcode::format_number(feed, 6)?));
        }
        let mut text = String::from("L");
        self.append_feed(&mut text, feed)?;
        Ok(text)
    }
}

/// A number without a final decimal point, and with this mark instead of a point.
fn with_mark(number: &str, mark: char) -> String {
    number.trim_end_matches('.').replace('.', mark.encode_utf8(&mut [0; 4]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coordinate(notation: Notation, value: f64) -> (String, f64) {
        let mut text = String::new();
        let read = notation.append_coordinate(&mut text, 'X', value, 4).unwrap();
        (text, read)
    }

    #[test]
    fn dialogue_has_signs_and_the_mark_of_its_program() {
        let of = |text: &str| Notation::of(&gcode::parse(text));
        assert_eq!(of("G1 X1.5"), Notation::Rs274);
        let point = of("0 BEGIN PGM A MM\n1 L X+1.5 Y+2,5\n");
        let comma = of("0 BEGIN PGM A MM\n1 TOOL CALL 1.1 Z\n2 L X+1 IY+2,5\n");
        assert_eq!(coordinate(point, 10.0), (" X+10".into(), 10.0));
        assert_eq!(coordinate(point, -0.25), (" X-0.25".into(), -0.25));
        assert_eq!(coordinate(comma, 1.23456), (" X+1,2346".into(), 1.2346));
        assert_eq!(coordinate(comma, -0.00001), (" X+0".into(), 0.0));
        assert_eq!(coordinate(Notation::Rs274, 10.0), ("X10.".into(), 10.0));
        assert_eq!(comma.feed_line(1200.5).unwrap(), "L F1200,5");
        assert_eq!(Notation::Rs274.feed_line(600.0).unwrap(), "F600.");
    }
}
