//! Text of a program without variables, branches, loops and subprograms.

use super::expression::{arguments, evaluate};
use super::run::Run;
use crate::evaluate::trace::{Executed, Words};
use crate::evaluate::value::{Fault, Value};
use crate::execution::Note;
use crate::format::format_number;
use crate::sinumerik::names::Name;
use crate::word::{Word, WordKind};

/// Decimals of written values: finer than any control resolves.
const DECIMALS: usize = 9;
/// Letters whose values are whole numbers, written without a decimal point.
const WHOLE_LETTERS: &[u8] = b"GMNPLDHST";

/// Writes the executed blocks.
pub(in crate::evaluate) fn write(run: &Run<'_>) -> Result<Vec<u8>, Note> {
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
    Ok(text)
}

/// The comment before a block that does not follow the block before it in its file.
fn origin(run: &Run<'_>, last: Option<&Executed>, executed: &Executed) -> Option<String> {
    let around = |of: &Executed| run.sources[of.source].program_around(of.block).to_owned();
    let follows = match last {
        Some(last) => {
            let same = last.source == executed.source && last.run == executed.run && last.block < executed.block;
            same && around(last) == around(executed)
        }
        None => executed.source == 0,
    };
    if follows {
        return None;
    }
    let body = match (around(executed).as_str(), executed.source) {
        ("", 0) => String::new(),
        ("", source) => format!("{}, ", run.sources[source].name),
        (name, _) => format!("{name}, "),
    };
    let again =
        if run.trace.runs(executed.source, executed.block) > 1 { format!(", run {}", executed.run) } else { String::new() };
    Some(format!("; from {body}line {}{again}", executed.block + 1))
}

/// The block as text, without a line ending; empty if nothing is left of it.
fn line(run: &Run<'_>, executed: &Executed) -> Result<Vec<u8>, Note> {
    let program = &run.sources[executed.source].program;
    let repeated = run.trace.runs(executed.source, executed.block) > 1 || executed.source > 0;
    let words = match &executed.words {
        Words::Own => program.block_words(executed.block),
        Words::Valued(range) => &run.trace.words[range.clone()],
    };
    let mut line: Vec<u8> = Vec::new();
    for word in words {
        let text = match word.kind {
            WordKind::Flow | WordKind::Assignment => return Err(open(run, executed, word)),
            WordKind::Expression => valued(run, executed, word)?,
            // Numbers of repeated blocks and labels would stand twice.
            WordKind::Number if word.letter == b'N' && repeated => continue,
            WordKind::Keyword if word.name == Name::Label => continue,
            WordKind::Percent if executed.source > 0 => continue,
            WordKind::Keyword | WordKind::Unknown => with_values(run, executed, word)?,
            _ => program.text(word.span).to_vec(),
        };
        if !line.is_empty() {
            line.push(b' ');
        }
        line.extend_from_slice(&text);
    }
    Ok(line)
}

/// A word with the value of its expression: `X=R1` is written as `X=5.`, `X=IC(R1)` as `X=IC(5.)`.
fn valued(run: &Run<'_>, executed: &Executed, word: &Word) -> Result<Vec<u8>, Note> {
    let program = &run.sources[executed.source].program;
    let value = program.text(word.value_span());
    let Some(number) = word.number() else {
        // A name, as of a tool.
        let is_string = value.first() == Some(&b'"') && value.last() == Some(&b'"');
        return if is_string { Ok(program.text(word.span).to_vec()) } else { Err(open(run, executed, word)) };
    };
    let address = &program.text(word.span)[..(word.value_start - word.span.start) as usize];
    let whole = WHOLE_LETTERS.contains(&word.letter) && number.fract() == 0.0 && number.abs() < 1e15;
    let text = if whole { format!("{number}") } else { format_number(number, DECIMALS).unwrap_or_default() };
    let text = match word.name {
        Name::Absolute => format!("AC({text})"),
        Name::Incremental => format!("IC({text})"),
        _ => text,
    };
    Ok([address.trim_ascii(), text.as_bytes()].concat())
}

/// A cycle or another name with the values of its arguments. Variables end with the program that defined them.
fn with_values(run: &Run<'_>, executed: &Executed, word: &Word) -> Result<Vec<u8>, Note> {
    let text = run.sources[executed.source].program.text(word.span);
    let Some(at) = text.iter().position(|byte| *byte == b'(').filter(|_| text.ends_with(b")")) else {
        return if word.kind == WordKind::Keyword || !is_name(text) { Ok(text.to_vec()) } else { Err(open(run, executed, word)) };
    };
    let mut out = text[..=at].to_vec();
    for (index, argument) in arguments(&text[at + 1..text.len() - 1]).into_iter().enumerate() {
        if index > 0 {
            out.push(b',');
        }
        let is_constant = !argument.iter().any(u8::is_ascii_alphabetic) || argument.first() == Some(&b'"');
        if is_constant {
            out.extend_from_slice(argument);
            continue;
        }
        // Variables have the values of the end of the execution: only constants may be written.
        match evaluate(argument, &super::variables::Variables::new()) {
            Ok(Value::Number(number)) => out.extend_from_slice(format_number(number, DECIMALS).unwrap_or_default().as_bytes()),
            _ => return Err(open(run, executed, word)),
        }
    }
    out.push(b')');
    Ok(out)
}

fn is_name(text: &[u8]) -> bool {
    text.first().is_some_and(u8::is_ascii_alphabetic)
}

/// The error for a word that cannot be written.
fn open(run: &Run<'_>, executed: &Executed, word: &Word) -> Note {
    let message = match word.kind {
        WordKind::Flow | WordKind::Unknown => {
            "this is no statement or subprogram that is found: the program cannot be written without it"
        }
        WordKind::Assignment => "this assignment may move the coordinate system: the program cannot be written without it",
        WordKind::Keyword => "the arguments of this name are variables: the program cannot be written without them",
        _ => "this value is known only when the program runs: the program cannot be written without it",
    };
    run.note_at(executed.source, executed.block, executed.caller, Fault::new(message).at(word.span))
}
