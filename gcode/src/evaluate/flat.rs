//! Words of a program that is written without parameters, branches, loops and subprograms.

use super::flatten::{self, Flatten};
use super::run::Run;
use super::trace::Executed;
use crate::dialect::Dialect;
use crate::execution::Note;
use crate::lexer::is_output;
use crate::number::has_two_signs;
use crate::word::{Span, Word, WordKind};

/// Writes the executed blocks.
pub(super) fn write(run: &Run<'_>) -> Result<Vec<u8>, Note> {
    let recorded = run.recorded();
    let (mut text, last) = flatten::write(run, &recorded)?;
    // The mark that closes a tape stands behind the end of the program.
    let is_mark = |executed: &Executed| recorded.words_of(executed).iter().any(|word| word.kind == WordKind::Percent);
    if run.trace.executed.first().is_some_and(is_mark) && !last.is_some_and(is_mark) {
        text.push(b'%');
        text.extend_from_slice(run.sources[0].program.line_ending());
    }
    Ok(text)
}

impl Flatten for Run<'_> {
    const COMMENT: [&'static str; 2] = ["(", ")"];
    const SUBPROGRAM: &'static str = "sub ";
    const WHOLE_LETTERS: &'static [u8] = b"GMNOPLDHST";

    fn subprogram_around(&self, executed: &Executed) -> Option<&str> {
        self.sources[executed.source()].body_around(executed.block())
    }

    fn word(&self, executed: &Executed, word: &Word) -> Result<Vec<u8>, &'static str> {
        let is_repeated = self.trace.runs(executed.source(), executed.block()) > 1 || executed.source() > 0;
        let is_level = || !is_repeated && !executed.perhaps && self.subprogram_around(executed).is_none();
        if saves_modes(word) && !is_level() || self.is_profile(word) {
            return Err(reason(word));
        }
        Ok(match word.kind {
            WordKind::Flow | WordKind::Assignment => return Err(reason(word)),
            WordKind::Expression if self.dialect == Dialect::Fanuc && has_two_signs(self.text(executed, word.value_span())) => {
                return Err("two signs, which controls differ in: the value cannot be written");
            }
            WordKind::Expression => valued(word.letter, word.number().ok_or(reason(word))?).into_bytes(),
            // Numbers of repeated blocks would stand twice.
            WordKind::Number if matches!(word.letter, b'N' | b'O') && is_repeated => Vec::new(),
            WordKind::Percent if executed.source() > 0 => Vec::new(),
            // A parameter whose assignment is left out.
            WordKind::Unknown if self.text(executed, word.span).contains(&b'#') => {
                return Err("a parameter stands in a word that is not read: the program cannot be written without it");
            }
            // What it puts out are values of the run.
            WordKind::Unknown if is_output(self.text(executed, word.span)) => return Err(reason(word)),
            _ => self.text(executed, word.span).to_vec(),
        })
    }
}

impl Run<'_> {
    /// The text of a part of an executed block.
    fn text(&self, executed: &Executed, span: Span) -> &[u8] {
        self.sources[executed.source()].program.text(span)
    }

    /// G70 to G72 of LinuxCNC: cycles whose profile is a subprogram.
    fn is_profile(&self, word: &Word) -> bool {
        let number = word.number().unwrap_or_default();
        self.dialect == Dialect::LinuxCnc && word.letter == b'G' && (70.0..73.0).contains(&number)
    }
}

/// M70 to M73 of LinuxCNC: saved modes belong to the level of a call.
fn saves_modes(word: &Word) -> bool {
    word.letter == b'M' && word.number().is_some_and(|number| (70.0..=73.0).contains(&number))
}

fn valued(letter: u8, value: f64) -> String {
    // A code such as 61.1 that was computed has the error of the computation.
    let value = if matches!(letter, b'G' | b'M') { (value * 10.0).round() / 10.0 } else { value };
    format!("{}{}", char::from(letter), Run::value(letter, value))
}

/// Why a word cannot be written.
fn reason(word: &Word) -> &'static str {
    match word.kind {
        WordKind::Flow => "this subprogram is not found: the program cannot be written without it",
        WordKind::Assignment => "this assignment may move the coordinate system: the program cannot be written without it",
        WordKind::Number if word.letter == b'M' => {
            "modes are saved here for the subprogram: the program cannot be written without it"
        }
        WordKind::Number => "this cycle reads a subprogram: the program cannot be written without it",
        _ => "this value is known only when the program runs: the program cannot be written without it",
    }
}
