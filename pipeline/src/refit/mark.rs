//! The comment at the head of a compensated program, by which it is known again.

use gcode::{Edits, Program, WordKind};
use models::Bundle;
use sha2::{Digest, Sha256};

use crate::error::Result;
use crate::setup::machine_of;

/// The word that begins the comment, and the one that tells what was done.
const TOOL: &str = "PRECOMP";
const DONE: &str = "COMPENSATED";
/// Hexadecimal digits of a hash that are written: chance makes two programs alike once in 10¹⁹.
const DIGITS: usize = 16;
/// Blocks at the head of a program in which the comment is looked for.
const HEAD: usize = 32;

/// Origin of a compensated program, as stated in its comment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mark {
    /// What moved the points, in capital letters without parentheses.
    by: String,
}

impl Mark {
    /// Of a program that was compensated with a model: its machine, and the hash of the data that it was trained on.
    ///
    /// # Errors
    /// When the description of the machine in the model is invalid.
    pub fn of_model(model: &Bundle) -> Result<Self> {
        let machine = machine_of(model)?.name;
        let data: String = model.manifest.data_sha256.chars().take(DIGITS).collect();
        Ok(Self { by: plain(&format!("model of {machine}, data {data}")) })
    }

    /// Of the program that follows the run with this number, from 1.
    #[must_use]
    pub fn of_run(run: u32) -> Self {
        Self { by: plain(&format!("what run {run} left")) }
    }

    /// Puts the comment behind the tape mark and the program number. It holds the version of precomp, what moved the points, the largest shift,
    /// mm, and the hash of the original.
    pub(super) fn write(&self, program: &Program, largest_shift_mm: f64, edits: &mut Edits) -> Result<()> {
        let hash: String = models::hex(&Sha256::digest(program.bytes())).chars().take(DIGITS).collect();
        let lines = [
            format!("{TOOL} {} {DONE} - {}", env!("CARGO_PKG_VERSION"), self.by),
            plain(&format!("largest shift {largest_shift_mm:.4} mm - original sha256 {hash}")),
        ];
        let semicolon = comments(program).all(|text| text.starts_with(b";")) && comments(program).next().is_some();
        let lines = lines.map(|text| if semicolon { format!("; {text}") } else { format!("({text})") });
        Ok(edits.insert_before(program, first_block(program), &lines)?)
    }
}

/// The line, from 1, that says that precomp compensated the program already.
#[must_use]
pub fn marked_line(program: &Program) -> Option<usize> {
    let says = |block: &usize| {
        program.block_words(*block).iter().filter(|word| word.kind == WordKind::Comment).any(|word| {
            let text = String::from_utf8_lossy(program.text(word.span)).to_ascii_uppercase();
            let text = text.trim_start_matches(['(', ';', ' ']);
            text.starts_with(TOOL) && text.contains(DONE)
        })
    };
    (0..program.blocks().len().min(HEAD)).find(says).map(|block| block + 1)
}

/// The first block that is neither blank, nor a tape mark, nor a program number.
fn first_block(program: &Program) -> usize {
    let leads = |block: &usize| {
        let words = program.block_words(*block);
        let number = |word: &gcode::Word| word.kind == WordKind::Number && word.letter == b'O';
        words.iter().all(|word| matches!(word.kind, WordKind::Percent | WordKind::Comment) || number(word))
            && words.iter().any(|word| word.kind == WordKind::Percent || number(word))
    };
    (0..program.blocks().len()).take_while(leads).count().min(program.blocks().len().saturating_sub(1))
}

fn comments(program: &Program) -> impl Iterator<Item = &[u8]> {
    let words = program.words().iter().filter(|word| word.kind == WordKind::Comment);
    words.map(|word| program.text(word.span))
}

/// Text that every control takes within a comment.
fn plain(text: &str) -> String {
    let allowed = |c: char| c.is_ascii_alphanumeric() || " .,-_".contains(c);
    text.to_ascii_uppercase().chars().map(|c| if allowed(c) { c } else { ' ' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn marked(text: &str) -> String {
        let program = gcode::parse(text);
        assert_eq!(marked_line(&program), None);
        let mut edits = Edits::new();
        Mark::of_run(3).write(&program, 0.0123, &mut edits).unwrap();
        String::from_utf8(gcode::edit(&program, &edits).unwrap()).unwrap()
    }

    #[test]
    fn the_comment_follows_tape_mark_and_number() {
        let out = marked("%\r\nO0001 (BRACKET)\r\nG21 (MM)\r\nG1 X1 F100\r\nM30\r\n%\r\n");
        assert!(out.starts_with("%\r\nO0001 (BRACKET)\r\n(PRECOMP "), "{out}");
        assert!(out.contains(" COMPENSATED - WHAT RUN 3 LEFT)\r\n(LARGEST SHIFT 0.0123 MM - ORIGINAL SHA256 "), "{out}");
        assert_eq!(marked_line(&gcode::parse(out)), Some(3));
    }

    #[test]
    fn a_program_whose_comments_follow_semicolons_gets_such_ones() {
        let out = marked("; PLATE\nG1 X1 F100\n");
        assert!(out.starts_with("; PRECOMP ") && !out.contains('('), "{out}");
        assert_eq!(marked_line(&gcode::parse(out)), Some(1));
        assert!(marked("G1 X1 F100\n").starts_with("(PRECOMP "));
    }
}
