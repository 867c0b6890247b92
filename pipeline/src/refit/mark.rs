//! The comment at the head of a compensated program, by which it is recognised.

use gcode::{Edits, Language, Program, Word, WordKind};
use machine::CommentStyle;
use models::Bundle;
use sha2::{Digest, Sha256};

use crate::error::Result;
use crate::model_based_ilc::Settings;
use crate::setup::machine_of;

/// First word of the comment, and the word that states what was done.
const TOOL: &str = "PRECOMP";
const DONE: &str = "COMPENSATED -";
/// Words before the hash of the original.
const ORIGINAL: &str = "ORIGINAL SHA256 ";
/// Hexadecimal digits of a hash: two programs agree by chance once in 10¹⁹.
const DIGITS: usize = 16;
/// Largest length of a machine's name in the comment: old controls read blocks of 80 characters.
const NAME_LENGTH: usize = 24;

/// Origin of a compensated program, as stated in its comment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mark {
    /// What moved the points, in capital letters without parentheses.
    by: String,
    /// Date of the model and settings, where a model moved the points.
    how: Option<String>,
    /// Comments of the control, where the program holds none to go by.
    comments: CommentStyle,
}

impl Mark {
    /// Mark of a program that was compensated with a model: its machine, the hash of its training data, its date and the settings.
    ///
    /// # Errors
    /// When the description of the machine in the model is invalid.
    pub fn of_model(model: &Bundle, settings: &Settings) -> Result<Self> {
        let name: String = machine_of(model)?.name.chars().take(NAME_LENGTH).collect();
        let data: String = model.manifest.data_sha256.chars().take(DIGITS).collect();
        let trained = model.manifest.date.as_ref().map(|date| format!("trained {date} - ")).unwrap_or_default();
        let how = format!(
            "{trained}law {}, updates {}, cycle up to {} percent",
            settings.law.name(),
            settings.iterations,
            // Rounded as it is stated: 0.07 is a little more than seven hundredths.
            (settings.cycle_limit * 1e4).round() / 1e2,
        );
        Ok(Self { how: Some(plain(&how)), ..Self::by(&format!("model of {name}, data {data}")) })
    }

    /// Mark of the program that follows the run with this number, from 1.
    #[must_use]
    pub fn of_run(run: u32) -> Self {
        Self::by(&format!("errors of run {run}"))
    }

    fn by(text: &str) -> Self {
        Self { by: plain(text), how: None, comments: CommentStyle::default() }
    }

    /// The same for a control with these comments.
    #[must_use]
    pub fn in_comments(self, comments: CommentStyle) -> Self {
        Self { comments, ..self }
    }

    /// Puts the comment behind the program's own head. It holds the version of precomp, what moved the points, the largest shift, mm, the hash of
    /// the original, and, where a model moved them, its date and the settings.
    pub(super) fn write(&self, program: &Program, largest_shift_mm: f64, edits: &mut Edits) -> Result<()> {
        let origin = [
            format!("{TOOL} {} {DONE} {}", env!("CARGO_PKG_VERSION"), self.by),
            plain(&format!("largest shift {largest_shift_mm:.4} mm - {ORIGINAL}{}", hash(program))),
        ];
        let style = style_of(program).unwrap_or(self.comments);
        let commented = |text: String| match style {
            CommentStyle::Parentheses => format!("({text})"),
            CommentStyle::Semicolon => format!("; {text}"),
        };
        let lines: Vec<String> = origin.into_iter().chain(self.how.clone()).map(commented).collect();
        match last_of_head(program) {
            Some(block) => edits.insert_after(program, block, &lines)?,
            None => edits.insert_before(program, 0, &lines)?,
        }
        Ok(())
    }
}

/// The line, from 1, that states that precomp compensated the program already.
#[must_use]
pub fn marked_line(program: &Program) -> Option<usize> {
    let states = |block: &usize| {
        comments(program, *block).any(|text| {
            let text = text.to_ascii_uppercase();
            let text = text.trim_start_matches(['(', ';', ' ']);
            text.starts_with(TOOL) && text.contains(DONE)
        })
    };
    // Comments of a user may stand above it, but no move.
    let moves = |block: &usize| program.block_words(*block).iter().any(gcode::is_motion_word);
    (0..program.blocks().len()).take_while(|block| !moves(block)).find(states).map(|block| block + 1)
}

/// Whether a program is `original`, or states at its head that it was computed from it.
#[must_use]
pub fn comes_from(program: &Program, original: &Program) -> bool {
    let stated = marked_line(program).and_then(|line| {
        comments(program, line).find_map(|text| Some(text.to_ascii_uppercase().split_once(ORIGINAL)?.1.to_owned()))
    });
    program.bytes() == original.bytes() || stated.is_some_and(|stated| stated.starts_with(&hash(original).to_ascii_uppercase()))
}

/// The first digits of a program's hash.
fn hash(program: &Program) -> String {
    models::hex(&Sha256::digest(program.bytes())).chars().take(DIGITS).collect()
}

/// The last block of what has to stay at the head of a program: tape mark, program number or name, and the path in the control's memory that
/// SINUMERIK wants below the name. `None` where there is no such block.
fn last_of_head(program: &Program) -> Option<usize> {
    let text = |word: &Word| program.text(word.span);
    let is_head = |word: &Word| match word.kind {
        WordKind::Percent => true,
        WordKind::Keyword => text(word).eq_ignore_ascii_case(b"BEGIN"),
        WordKind::Number => word.letter == b'O',
        WordKind::Comment => text(word).starts_with(b";$"),
        // The definition of a subprogram comes before all other blocks.
        WordKind::Flow => text(word).get(..4).is_some_and(|start| start.eq_ignore_ascii_case(b"PROC")),
        _ => text(word).starts_with(b":"),
    };
    let words = |block: usize| program.block_words(block);
    let before_code = |block: &usize| {
        let own = words(*block).iter().any(is_head);
        own || words(*block).iter().all(|word| word.kind == WordKind::Comment)
    };
    let head = (0..program.blocks().len()).take_while(before_code);
    head.filter(|block| words(*block).iter().any(is_head)).last()
}

/// The style of the language, or of the first comment that has a line of its own. A semicolon without text ends a block on some controls and is none.
fn style_of(program: &Program) -> Option<CommentStyle> {
    if program.language() != Language::Rs274 {
        return Some(CommentStyle::Semicolon);
    }
    (0..program.blocks().len()).find_map(|block| {
        let first = program.block_words(block).iter().find(|word| !word.is(b'N'))?;
        let text = program.text(first.span);
        match (first.kind, text) {
            (WordKind::Comment, [b'(', ..]) => Some(CommentStyle::Parentheses),
            (WordKind::Comment, [b';', rest @ ..]) if !rest.trim_ascii().is_empty() => Some(CommentStyle::Semicolon),
            _ => None,
        }
    })
}

/// The comments of a block; none beyond the last block.
fn comments(program: &Program, block: usize) -> impl Iterator<Item = String> {
    let words = if block < program.blocks().len() { program.block_words(block) } else { &[] };
    let words = words.iter().filter(|word| word.kind == WordKind::Comment);
    words.map(|word| String::from_utf8_lossy(program.text(word.span)).into_owned())
}

/// Text that every control accepts within a comment.
fn plain(text: &str) -> String {
    let allowed = |c: char| c.is_ascii_alphanumeric() || " .,-_".contains(c);
    text.to_ascii_uppercase().chars().map(|c| if allowed(c) { c } else { ' ' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The program with a mark, which is recognised.
    fn marked(text: &str) -> String {
        let program = gcode::parse(text);
        assert_eq!(marked_line(&program), None);
        let mut edits = Edits::new();
        Mark::of_run(3).write(&program, 0.0123, &mut edits).unwrap();
        let out = String::from_utf8(gcode::edit(&program, &edits).unwrap()).unwrap();
        assert!(marked_line(&gcode::parse(out.as_str())).is_some(), "{out}");
        out
    }

    /// What stands before the mark.
    fn before(text: &str) -> String {
        let out = marked(text);
        let at = out.find("PRECOMP ").unwrap();
        out[..at].trim_end_matches(['(', ';', ' ']).to_owned()
    }

    #[test]
    fn the_head_of_a_program_stays_at_its_head() {
        for head in [
            "%\r\nO0001 (BRACKET)\r\n",
            "\n%\nO0001\n",
            "(A)\n%\n",
            "%\n(A)\nO12\n",
            "O1000 G21 G90\n",
            ":1000\n",
            "%_N_PLATE_MPF\n;$PATH=/_N_WKS_DIR\n",
            "0 BEGIN PGM A MM\n",
            "%_N_SLOT_SPF\nPROC SLOT(REAL A)\n",
        ] {
            let line = if head.contains("\r\n") { "\r\n" } else { "\n" };
            assert_eq!(before(&format!("{head}G21{line}G1 X1 F100{line}M30{line}")), head);
        }
        for text in ["G21\nG1 X1 F100\n", "(PLATE)\nG21\nG1 X1 F100\n", "N10 G21\n"] {
            assert_eq!(before(text), "", "{text}");
        }
    }

    #[test]
    fn the_comment_states_origin_shift_and_original() {
        let out = marked("%\nG1 X1 F100\n");
        assert!(out.contains(" COMPENSATED - ERRORS OF RUN 3)\n(LARGEST SHIFT 0.0123 MM - ORIGINAL SHA256 "), "{out}");
    }

    #[test]
    fn a_compensated_program_belongs_to_its_original() {
        let original = gcode::parse("%\nG1 X1 F100\n");
        let other = gcode::parse("%\nG1 X2 F100\n");
        let compensated = gcode::parse(marked("%\nG1 X1 F100\n"));
        assert!(comes_from(&compensated, &original) && comes_from(&original, &original));
        assert!(!comes_from(&compensated, &other));
        // Without the hash nothing is stated.
        assert!(!comes_from(&original, &other));
        assert!(!comes_from(&gcode::parse("(PRECOMP 1 COMPENSATED - X)"), &other));
    }

    #[test]
    fn comments_are_in_the_style_of_the_program_and_else_of_the_control() {
        assert!(marked("; PLATE\nG1 X1 F100\n").starts_with("; PRECOMP "));
        assert!(marked("N1 (PLATE)\nG1 X1 F100 ; END\n").starts_with("(PRECOMP "));
        // A semicolon that only ends the block is no comment.
        assert!(marked("G21;\n;\nG1 X1 F100;\n").starts_with("(PRECOMP "));
        let program = gcode::parse("G1 X1 F100\n");
        let mut edits = Edits::new();
        Mark::of_run(1).in_comments(CommentStyle::Semicolon).write(&program, 0.0, &mut edits).unwrap();
        assert!(gcode::edit(&program, &edits).unwrap().starts_with(b"; PRECOMP "));
    }

    #[test]
    fn a_comment_that_mentions_the_words_is_no_mark() {
        for text in [
            "(FOR PRECOMP, TO BE COMPENSATED)\nG1 X1\n",
            "(PRECOMP EXCITATION 01-FULL)\nG1 X1\n",
            "G1 X1\n(PRECOMP 1 COMPENSATED - X)\n",
        ] {
            assert_eq!(marked_line(&gcode::parse(text)), None, "{text}");
        }
        assert_eq!(marked_line(&gcode::parse("(A)\n\n(precomp 0.1.0 compensated - model of x)\nG1 X1\n")), Some(3));
    }
}
