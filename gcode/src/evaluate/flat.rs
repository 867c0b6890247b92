//! Text of a program without parameters, branches, loops and subprograms.

use super::run::Run;
use super::trace::Executed;
use super::value::Fault;
use crate::dialect::Dialect;
use crate::execution::Note;
use crate::format::format_number;
use crate::word::{Word, WordKind};

/// Decimals of written values: finer than any control resolves.
const DECIMALS: usize = 9;
/// Letters whose values are whole numbers, written without a decimal point.
const WHOLE_LETTERS: &[u8] = b"GMNOPLDHST";

/// Writes the executed blocks.
pub(super) fn write(run: &Run<'_>) -> Result<Vec<u8>, Note> {
    if let Some(note) = &run.undecided {
        let message = "the program decides this when it runs: it cannot be written without branches and loops".to_owned();
        return Err(Note { message, help: Some("write the branch that applies as a program of its own"), ..note.clone() });
    }
    let ending = run.sources[0].program.line_ending();
    let mut text = Vec::new();
    let mut last: Option<&Executed> = None;
    for executed in &run.trace.executed {
        let line = line(run, executed)?;
        if line.is_empty() {
            continue;
        }
        if let Some(origin) = origin(run, last, executed) {
            text.extend_from_slice(origin.as_bytes());
            text.extend_from_slice(ending);
        }
        text.extend_from_slice(&line);
        text.extend_from_slice(ending);
        last = Some(executed);
    }
    // The mark that closes a tape stands behind the end of the program.
    let is_mark = |executed: &Executed| run.words_of(executed).iter().any(|word| word.kind == WordKind::Percent);
    if run.trace.executed.first().is_some_and(is_mark) && !last.is_some_and(is_mark) {
        text.push(b'%');
        text.extend_from_slice(ending);
    }
    Ok(text)
}

/// The comment before a block that does not follow the block before it in its file.
fn origin(run: &Run<'_>, last: Option<&Executed>, executed: &Executed) -> Option<String> {
    let follows = match last {
        Some(last) => {
            let same = last.source == executed.source && last.run == executed.run && last.block < executed.block;
            same && run.sources[executed.source].body_around(last.block)
                == run.sources[executed.source].body_around(executed.block)
        }
        None => executed.source == 0,
    };
    if follows {
        return None;
    }
    let body = match run.sources[executed.source].body_around(executed.block) {
        Some(name) => format!("sub {name}, "),
        None if executed.source > 0 => format!("{}, ", run.sources[executed.source].name),
        None => String::new(),
    };
    let again =
        if run.trace.runs(executed.source, executed.block) > 1 { format!(", run {}", executed.run) } else { String::new() };
    Some(format!("(from {body}line {}{again})", executed.block + 1))
}

/// The block as text, without a line ending; empty if nothing is left of it.
fn line(run: &Run<'_>, executed: &Executed) -> Result<Vec<u8>, Note> {
    let program = &run.sources[executed.source].program;
    let repeated = run.trace.runs(executed.source, executed.block) > 1 || executed.source > 0;
    let mut line: Vec<u8> = Vec::new();
    for word in run.words_of(executed) {
        if saves_modes(word)
            && (repeated || executed.perhaps || run.sources[executed.source].body_around(executed.block).is_some())
            || is_profile(run, word)
        {
            return Err(open(run, executed, word));
        }
        let text = match word.kind {
            WordKind::Flow | WordKind::Assignment => return Err(open(run, executed, word)),
            WordKind::Expression => match word.number() {
                Some(value) => valued(word.letter, value).into_bytes(),
                None => return Err(open(run, executed, word)),
            },
            // Numbers of repeated blocks would stand twice.
            WordKind::Number if matches!(word.letter, b'N' | b'O') && repeated => continue,
            WordKind::Percent if executed.source > 0 => continue,
            _ => program.text(word.span).to_vec(),
        };
        if !line.is_empty() {
            line.push(b' ');
        }
        line.extend_from_slice(&text);
    }
    Ok(line)
}

/// M70 to M73 of LinuxCNC: saved modes belong to the level of a call.
fn saves_modes(word: &Word) -> bool {
    word.letter == b'M' && word.number().is_some_and(|number| (70.0..=73.0).contains(&number))
}

/// G70 to G72 of LinuxCNC: cycles whose profile is a subprogram.
fn is_profile(run: &Run<'_>, word: &Word) -> bool {
    let number = word.number().unwrap_or_default();
    run.dialect == Dialect::LinuxCnc && word.letter == b'G' && (70.0..73.0).contains(&number)
}

fn valued(letter: u8, value: f64) -> String {
    let letter_text = char::from(letter);
    // A code such as 61.1 that was computed has the error of the computation.
    let value = if matches!(letter, b'G' | b'M') { (value * 10.0).round() / 10.0 } else { value };
    if WHOLE_LETTERS.contains(&letter) && value.fract() == 0.0 && value.abs() < 1e15 {
        return format!("{letter_text}{value}");
    }
    // Values are finite.
    format!("{letter_text}{}", format_number(value, DECIMALS).unwrap_or_default())
}

/// The error for a word that cannot be written.
fn open(run: &Run<'_>, executed: &Executed, word: &Word) -> Note {
    let message = match word.kind {
        WordKind::Flow => "this subprogram is not found: the program cannot be written without it",
        WordKind::Assignment => "this assignment may move the coordinate system: the program cannot be written without it",
        WordKind::Number if word.letter == b'M' => {
            "modes are saved here for the subprogram: the program cannot be written without it"
        }
        WordKind::Number => "this cycle reads a subprogram: the program cannot be written without it",
        _ => "this value is known only when the program runs: the program cannot be written without it",
    };
    run.note_at(executed.source, executed.block, executed.caller, Fault::new(message).at(word.span))
}
