//! Words of a program that is written without variables, branches, loops and subprograms.

use super::expression::{arguments, evaluate};
use super::run::Run;
use super::variables::Variables;
use crate::evaluate::flatten::{DECIMALS, Flatten};
use crate::evaluate::trace::Executed;
use crate::evaluate::value::Value;
use crate::format::format_number;
use crate::program::Program;
use crate::sinumerik::names::Name;
use crate::sinumerik::scan::{is_dimension, name};
use crate::word::{Word, WordKind};

impl Flatten for Run<'_> {
    const COMMENT: [&'static str; 2] = ["; ", ""];
    const SUBPROGRAM: &'static str = "";
    const WHOLE_LETTERS: &'static [u8] = b"GMNPLDHST";

    fn subprogram_around(&self, executed: &Executed) -> Option<&str> {
        Some(self.sources[executed.source()].program_around(executed.block())).filter(|name| !name.is_empty())
    }

    fn word(&self, executed: &Executed, word: &Word) -> Result<Vec<u8>, &'static str> {
        let program = &self.sources[executed.source()].program;
        let is_repeated = self.trace.runs(executed.source(), executed.block()) > 1 || executed.source() > 0;
        match word.kind {
            WordKind::Flow | WordKind::Assignment => Err(reason(word)),
            WordKind::Expression => valued(program, word),
            // Numbers of repeated blocks and labels would stand twice.
            WordKind::Number if word.letter == b'N' && is_repeated => Ok(Vec::new()),
            WordKind::Keyword if word.name == Name::Label => Ok(Vec::new()),
            WordKind::Percent if executed.source() > 0 => Ok(Vec::new()),
            WordKind::Keyword | WordKind::Unknown => with_values(program, word),
            _ => Ok(program.text(word.span).to_vec()),
        }
    }
}

/// A word with the value of its expression: `X=R1` is written as `X=5.`, `X=IC(R1)` as `X=IC(5.)`, `I1=IC(R1)` as `I1=IC(5.)`.
fn valued(program: &Program, word: &Word) -> Result<Vec<u8>, &'static str> {
    let value = program.text(word.value_span());
    let Some(number) = word.number() else {
        // A name, as of a tool.
        let is_string = value.first() == Some(&b'"') && value.last() == Some(&b'"');
        return if is_string { Ok(program.text(word.span).to_vec()) } else { Err(reason(word)) };
    };
    let address = &program.text(word.span)[..(word.value_start - word.span.start) as usize];
    let text = Run::value(word.letter, number);
    let of = name(value, 0);
    let is_kept = matches!(word.name, Name::Absolute | Name::Incremental) || (word.name.is_coordinate() && is_dimension(of));
    if is_kept {
        return Ok([address.trim_ascii(), of, b"(", text.as_bytes(), b")"].concat());
    }
    Ok([address.trim_ascii(), text.as_bytes()].concat())
}

/// Constants for the kind of machining in CYCLE832 (SINUMERIK, "High-speed settings").
const MODES: [&str; 9] = [
    "_OFF",
    "_FINISH",
    "_SEMIFIN",
    "_ROUGH",
    "_ORI_FINISH",
    "_ORI_SEMIFIN",
    "_ORI_ROUGH",
    "_TOP_SURFACE_SMOOTH_OFF",
    "_TOP_SURFACE_SMOOTH_ON",
];

/// A cycle or another name with the values of its arguments. Variables end with the program that defined them.
fn with_values(program: &Program, word: &Word) -> Result<Vec<u8>, &'static str> {
    let text = program.text(word.span);
    let Some(at) = text.iter().position(|byte| *byte == b'(').filter(|_| text.ends_with(b")")) else {
        return if word.kind == WordKind::Keyword || !is_name(text) { Ok(text.to_vec()) } else { Err(reason(word)) };
    };
    let mut out = text[..=at].to_vec();
    for (index, argument) in arguments(&text[at + 1..text.len() - 1]).into_iter().enumerate() {
        if index > 0 {
            out.push(b',');
        }
        let is_named = MODES.iter().any(|mode| argument.trim_ascii().eq_ignore_ascii_case(mode.as_bytes()));
        let is_constant = is_named || !argument.iter().any(u8::is_ascii_alphabetic) || argument.first() == Some(&b'"');
        if is_constant {
            out.extend_from_slice(argument);
            continue;
        }
        // Variables have the values of the end of the execution: only constants may be written.
        match evaluate(argument, &Variables::new()) {
            Ok(Value::Number(number)) => out.extend_from_slice(format_number(number, DECIMALS).unwrap_or_default().as_bytes()),
            _ => return Err(reason(word)),
        }
    }
    out.push(b')');
    Ok(out)
}

fn is_name(text: &[u8]) -> bool {
    text.first().is_some_and(u8::is_ascii_alphabetic)
}

/// Why a word cannot be written.
fn reason(word: &Word) -> &'static str {
    match word.kind {
        WordKind::Flow | WordKind::Unknown => {
            "this is no statement or subprogram that is found: the program cannot be written without it"
        }
        WordKind::Assignment => "this assignment may move the coordinate system: the program cannot be written without it",
        WordKind::Keyword => "the arguments of this name are variables: the program cannot be written without them",
        _ => "this value is known only when the program runs: the program cannot be written without it",
    }
}
