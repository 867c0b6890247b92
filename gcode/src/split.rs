//! Replaces the motion of one block by several lines. The other words of the block keep their order
//! of execution.

use crate::acting::{Acting, acting};
use crate::dialect::Dialect;
use crate::edit::Edits;
use crate::error::GcodeError;
use crate::program::Program;
use crate::word::{Span, WordKind};

/// Whether the motion of a block may become several lines. Not if some words act before the motion
/// and some after, or if it is not known when they act.
pub(crate) fn is_splittable(program: &Program, block: usize, dialect: Dialect) -> bool {
    let acts = |when| program.block_words(block).iter().any(|word| acting(program, block, word, dialect) == when);
    !(acts(Acting::Unclear) || acts(Acting::After) && acts(Acting::Before))
}

/// Whether the lines that replace the motion of a block stand before it.
pub(crate) fn is_split_before(program: &Program, block: usize, dialect: Dialect) -> bool {
    program.block_words(block).iter().any(|word| acting(program, block, word, dialect) == Acting::After)
}

impl Edits {
    /// Replaces the motion words of a block (G0-G3, axes, I J K R, F, the P of an arc) by `lines`.
    ///
    /// The block keeps its other words and its comments. One line replaces the motion in the block.
    /// The others become lines of their own: after the block, or before it if the block holds an M
    /// code that acts after its motion in this dialect. Behind the slash of an optional block they are optional too.
    ///
    /// # Errors
    /// [`GcodeError::NoSuchBlock`]. [`GcodeError::Unsplittable`] if the block has no motion words,
    /// or if it holds words that act before its motion and words that act after it, or at a time that
    /// is not known, and `lines` is longer than one.
    pub fn replace_motion<L: AsRef<[u8]>>(
        &mut self,
        program: &Program,
        block: usize,
        dialect: Dialect,
        lines: &[L],
    ) -> Result<(), GcodeError> {
        let blocks = program.blocks().len();
        if block >= blocks {
            return Err(GcodeError::NoSuchBlock { block, blocks });
        }
        let refuse = |reason| GcodeError::Unsplittable { line: block + 1, lines: lines.len(), reason };
        let spans = motion_spans(program, block, dialect);
        let Some((first_span, others)) = spans.split_first() else {
            return Err(refuse("it has no motion words"));
        };
        let acts_after = is_split_before(program, block, dialect);
        if lines.len() > 1 && !is_splittable(program, block, dialect) {
            return Err(refuse("some of its words act before its motion and some after, or when is not known"));
        }
        let slash = program.block_words(block).iter().find(|word| word.kind == WordKind::BlockDelete);
        let slash = slash.map_or(&[][..], |word| program.text(word.span));
        let optional = |lines: &[L]| lines.iter().map(|line| [slash, line.as_ref()].concat()).collect::<Vec<Vec<u8>>>();
        let in_place = match lines {
            [] => None,
            [all @ .., last] if acts_after => {
                self.insert_before(program, block, &optional(all))?;
                Some(last)
            }
            [first, rest @ ..] => {
                self.insert_after(program, block, &optional(rest))?;
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
fn motion_spans(program: &Program, block: usize, dialect: Dialect) -> Vec<Span> {
    let mut spans: Vec<Span> = Vec::new();
    let mut previous_is_motion = false;
    for word in program.block_words(block) {
        let is_motion = acting(program, block, word, dialect) == Acting::Motion;
        match spans.last_mut() {
            Some(last) if is_motion && previous_is_motion => last.end = word.span.end,
            _ if is_motion => spans.push(word.span),
            _ => {}
        }
        previous_is_motion = is_motion;
    }
    spans
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{edit, parse};

    fn replaced(text: &str, dialect: Dialect, lines: &[&str]) -> String {
        let program = parse(text);
        let mut edits = Edits::new();
        edits.replace_motion(&program, 1, dialect, lines).expect("the block can be split");
        String::from_utf8(edit(&program, &edits).expect("no overlap")).expect("ASCII")
    }

    #[test]
    fn other_words_stay_where_they_act() {
        use Dialect::{Fanuc, LinuxCnc};
        let two = ["G1 X1", "X2"];
        assert_eq!(replaced("%\nN10G1X3Y4S100(c)\nM2\n", Fanuc, &two), "%\nN10G1 X1S100(c)\nX2\nM2\n");
        assert_eq!(replaced("%\nG1 X60 F3000 M98 P1000\nM2\n", Fanuc, &two), "%\nG1 X1\nX2 M98 P1000\nM2\n");
        assert_eq!(replaced("%\nN10 G1 X3 Y4 M9\nM2\n", Fanuc, &two), "%\nG1 X1\nN10 X2 M9\nM2\n");
        assert_eq!(replaced("%\nN10 G1 X3 Y4 M9\nM2\n", LinuxCnc, &two), "%\nN10 G1 X1 M9\nX2\nM2\n");
        assert_eq!(replaced("%\nN10 G1 X3 Y4 M0\nM2\n", LinuxCnc, &two), "%\nG1 X1\nN10 X2 M0\nM2\n");
        assert_eq!(replaced("%\n/G1 X3 Y4\nM2\n", Fanuc, &two), "%\n/G1 X1\n/X2\nM2\n");
        assert_eq!(replaced("%\n/2N10 X3 Y4\nM2\n", Fanuc, &two), "%\n/2N10 G1 X1\n/2X2\nM2\n");
        assert_eq!(replaced("%\nG2 M62 P1 X3 Y4 I1", LinuxCnc, &two), "%\nG1 X1 M62 P1 \nX2");
        assert_eq!(replaced("%\nG2 X3 Y4 I1 P2 M5", LinuxCnc, &["X2"]), "%\nX2 P2 M5");
        assert_eq!(replaced("%\nG2 X3 Y4 I1 P2", LinuxCnc, &["G1 X2"]), "%\nG1 X2");
        assert_eq!(replaced("%\nX3\n", Fanuc, &["X3.1"]), "%\nX3.1\n");
    }

    #[test]
    fn a_block_that_would_change_meaning_is_refused() {
        let program = parse("S500 G1 X1 M9\nM3\nG1 X1 M62\n");
        let mut edits = Edits::new();
        let mut replace = |block, lines: &[&str]| edits.replace_motion(&program, block, Dialect::Fanuc, lines);
        assert!(matches!(replace(0, &["X1", "X2"]), Err(GcodeError::Unsplittable { line: 1, lines: 2, .. })));
        assert!(matches!(replace(2, &["X1", "X2"]), Err(GcodeError::Unsplittable { line: 3, .. })));
        assert!(matches!(replace(1, &["X1"]), Err(GcodeError::Unsplittable { line: 2, .. })));
        assert!(matches!(replace(3, &["X1"]), Err(GcodeError::NoSuchBlock { .. })));
        assert!(replace(0, &["X1"]).is_ok());
    }
}
