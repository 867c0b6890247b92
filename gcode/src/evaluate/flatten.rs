//! Text of a program without variables, branches, loops and subprograms, whatever its language.

use super::recorded::Recorded;
use super::trace::Executed;
use super::value::Fault;
use crate::execution::Note;
use crate::format::format_number;
use crate::word::Word;

/// Decimals of written values: finer than any control resolves.
pub(super) const DECIMALS: usize = 9;

/// An execution that can be written block by block.
pub(super) trait Flatten {
    /// What stands before and behind the text of a comment.
    const COMMENT: [&'static str; 2];
    /// What stands before the name of a subprogram in a comment.
    const SUBPROGRAM: &'static str;
    /// Letters whose values are whole numbers, written without a decimal point.
    const WHOLE_LETTERS: &'static [u8];

    /// Name of the subprogram that holds the block within its file.
    fn subprogram_around(&self, executed: &Executed) -> Option<&str>;

    /// Text of a word of the block; empty if the word is left out, an error message if it cannot be written.
    fn word(&self, executed: &Executed, word: &Word) -> Result<Vec<u8>, &'static str>;

    /// Text of the value of an address.
    fn value(letter: u8, value: f64) -> String {
        if Self::WHOLE_LETTERS.contains(&letter) && value.fract() == 0.0 && value.abs() < 1e15 {
            return format!("{value}");
        }
        // Values are finite.
        format_number(value, DECIMALS).unwrap_or_default()
    }
}

/// Writes the executed blocks. Returns the text and the last block in it.
pub(super) fn write<'a, Run: Flatten>(run: &Run, recorded: &Recorded<'a>) -> Result<(Vec<u8>, Option<&'a Executed>), Note> {
    if let Some(note) = recorded.undecided {
        let message = "the program decides this when it runs: it cannot be written without branches and loops".to_owned();
        return Err(Note { message, help: Some("write the branch that applies as a program of its own"), ..note.clone() });
    }
    if let Some(note) = recorded.unwritable {
        return Err(note.clone());
    }
    let ending = recorded.programs[0].1.line_ending();
    let mut text = Vec::new();
    let mut last: Option<&Executed> = None;
    for executed in &recorded.trace.executed {
        let line = line(run, recorded, executed)?;
        if line.is_empty() {
            continue;
        }
        if let Some(origin) = origin(run, recorded, last, executed) {
            text.extend_from_slice(origin.as_bytes());
            text.extend_from_slice(ending);
        }
        text.extend_from_slice(&line);
        text.extend_from_slice(ending);
        last = Some(executed);
    }
    Ok((text, last))
}

/// The comment before a block that does not follow the block before it in its file.
fn origin<Run: Flatten>(run: &Run, recorded: &Recorded<'_>, last: Option<&Executed>, executed: &Executed) -> Option<String> {
    let around = run.subprogram_around(executed);
    let follows = match last {
        Some(last) => {
            let same = last.source() == executed.source() && last.run == executed.run && last.block() < executed.block();
            same && run.subprogram_around(last) == around
        }
        None => executed.source() == 0,
    };
    if follows {
        return None;
    }
    let place = match (around, executed.source()) {
        (Some(name), _) => format!("{}{name}, ", Run::SUBPROGRAM),
        (None, 0) => String::new(),
        (None, source) => format!("{}, ", recorded.programs[source].0),
    };
    let is_repeated = recorded.trace.runs(executed.source(), executed.block()) > 1;
    let again = if is_repeated { format!(", run {}", executed.run) } else { String::new() };
    let [open, close] = Run::COMMENT;
    Some(format!("{open}from {place}line {}{again}{close}", executed.block() + 1))
}

/// The block as text, without a line ending; empty if nothing is left of it.
fn line<Run: Flatten>(run: &Run, recorded: &Recorded<'_>, executed: &Executed) -> Result<Vec<u8>, Note> {
    let mut line: Vec<u8> = Vec::new();
    for word in recorded.words_of(executed) {
        let text = run.word(executed, word).map_err(|message| {
            let fault = Fault::new(message).at(word.span);
            recorded.note_at((executed.source(), executed.block()), executed.caller(), fault)
        })?;
        if !line.is_empty() && !text.is_empty() {
            line.push(b' ');
        }
        line.extend_from_slice(&text);
    }
    Ok(line)
}
