//! Replaces the motion of one block by several lines. The other words of the block keep their order
//! of execution.

use crate::edit::Edits;
use crate::error::GcodeError;
use crate::program::Program;
use crate::word::{Span, Word, WordKind};

/// Letters that describe a motion.
const MOTION_LETTERS: &[u8] = b"XYZABCIJKRF";
/// M codes that act after the motion of their block: stops, spindle and coolant off, pallet change (NIST RS274NGC, 3.8: order of execution), calls and returns
/// (Fanuc 0i Operator's Manual, subprograms; M97 on Haas).
const AFTER_MOTION: [f64; 11] = [0.0, 1.0, 2.0, 5.0, 9.0, 30.0, 60.0, 97.0, 98.0, 99.0, 198.0];

/// Whether a word belongs to the motion of a feed move: G0-G3, axis, arc and feed words; in dialogue also path function, direction and radius
/// compensation.
pub fn is_motion_word(word: &Word) -> bool {
    match word.kind {
        WordKind::Number | WordKind::Expression if word.letter == b'G' => [0.0, 1.0, 2.0, 3.0].contains(&word.value),
        WordKind::Number | WordKind::Expression => MOTION_LETTERS.contains(&word.letter),
        WordKind::Motion => true,
        _ => false,
    }
}

/// Whether the motion of a block may become several lines. Not if some words act before the motion
/// and some after.
pub(crate) fn is_splittable(words: &[Word]) -> bool {
    !(words.iter().any(acts_after) && words.iter().any(acts_before))
}

/// Whether the lines that replace the motion of a block stand before it.
pub(crate) fn is_split_before(words: &[Word]) -> bool {
    words.iter().any(acts_after)
}

impl Edits {
    /// Replaces the motion words of a block (G0-G3, axes, I J K R, F) by `lines`.
    ///
    /// The block keeps its other words and its comments. One line replaces the motion in the block.
    /// The others become lines of their own: after the block, or before it if the block holds an M
    /// code that acts after its motion.
    ///
    /// # Errors
    /// [`GcodeError::NoSuchBlock`]. [`GcodeError::Unsplittable`] if the block has no motion words,
    /// or if it holds words that act before its motion and words that act after it and `lines` is
    /// longer than one.
    pub fn replace_motion<L: AsRef<[u8]>>(&mut self, program: &Program, block: usize, lines: &[L]) -> Result<(), GcodeError> {
        let blocks = program.blocks().len();
        if block >= blocks {
            return Err(GcodeError::NoSuchBlock { block, blocks });
        }
        let refuse = |reason| GcodeError::Unsplittable { line: block + 1, lines: lines.len(), reason };
        let words = program.block_words(block);
        let spans = motion_spans(words);
        let Some((first_span, others)) = spans.split_first() else {
            return Err(refuse("it has no motion words"));
        };
        let acts_after = is_split_before(words);
        if lines.len() > 1 && !is_splittable(words) {
            return Err(refuse("some of its words act before its motion and some after"));
        }
        let in_place = match lines {
            [] => None,
            [all @ .., last] if acts_after => {
                self.insert_before(program, block, all)?;
                Some(last)
            }
            [first, rest @ ..] => {
                self.insert_after(program, block, rest)?;
                Some(first)
            }
        };
        self.replace(*first_span, in_place.map_or(&[][..], |line| line.as_ref()));
        for span in others {
            self.replace(*span, "");
        }
        Ok(())
    }
}

/// Motion words. Neighbours are joined with the blanks between them.
fn motion_spans(words: &[Word]) -> Vec<Span> {
    let mut spans: Vec<Span> = Vec::new();
    let mut previous_is_motion = false;
    for word in words {
        let is_motion = is_motion_word(word);
        match spans.last_mut() {
            Some(last) if is_motion && previous_is_motion => last.end = word.span.end,
            _ if is_motion => spans.push(word.span),
            _ => {}
        }
        previous_is_motion = is_motion;
    }
    spans
}

fn acts_after(word: &Word) -> bool {
    word.is(b'M') && AFTER_MOTION.contains(&word.value)
}

/// Whether a word acts before the motion. The P, L and Q of a call belong to the call.
fn acts_before(word: &Word) -> bool {
    match word.kind {
        WordKind::Comment => false,
        WordKind::Number | WordKind::Expression if matches!(word.letter, b'N' | b'P' | b'L' | b'Q') => false,
        WordKind::Number if word.letter == b'M' => !AFTER_MOTION.contains(&word.value),
        _ => !is_motion_word(word),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{edit, parse};

    fn replaced(text: &str, lines: &[&str]) -> String {
        let program = parse(text);
        let mut edits = Edits::new();
        edits.replace_motion(&program, 1, lines).expect("the block can be split");
        String::from_utf8(edit(&program, &edits).expect("no overlap")).expect("ASCII")
    }

    #[test]
    fn other_words_stay_where_they_act() {
        let two = ["G1 X1", "X2"];
        assert_eq!(replaced("%\nN10G1X3Y4S100(c)\nM2\n", &two), "%\nN10G1 X1S100(c)\nX2\nM2\n");
        assert_eq!(replaced("%\nG1 X60 F3000 M98 P1000\nM2\n", &two), "%\nG1 X1\nX2 M98 P1000\nM2\n");
        assert_eq!(replaced("%\nN10 G1 X3 Y4 M9\nM2\n", &two), "%\nG1 X1\nN10 X2 M9\nM2\n");
        assert_eq!(replaced("%\nG2 M62 P1 X3 Y4 I1", &two), "%\nG1 X1 M62 P1 \nX2");
        assert_eq!(replaced("%\nX3\n", &["X3.1"]), "%\nX3.1\n");
    }

    #[test]
    fn a_block_that_would_change_meaning_is_refused() {
        let program = parse("S500 G1 X1 M9\nM3\n");
        let mut edits = Edits::new();
        assert!(matches!(
            edits.replace_motion(&program, 0, &["X1", "X2"]),
            Err(GcodeError::Unsplittable { line: 1, lines: 2, .. })
        ));
        assert!(matches!(edits.replace_motion(&program, 1, &["X1"]), Err(GcodeError::Unsplittable { line: 2, .. })));
        assert!(matches!(edits.replace_motion(&program, 2, &["X1"]), Err(GcodeError::NoSuchBlock { .. })));
        assert!(edits.replace_motion(&program, 0, &["X1"]).is_ok());
    }
}
