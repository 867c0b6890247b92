//! Evaluates parameters, expressions, branches, loops and subprograms, as the control does when it runs the program.
//!
//! LinuxCNC: O-words, numbered and named parameters, M98 and M99. Fanuc: custom macro B with local, common and system variables, IF, GOTO,
//! WHILE, G65, M98, M97 (Haas) and M198. G66 is not evaluated. Values that an earlier program, the operator or the machine sets (system
//! variables, probe results, tool data, parameters that the program does not assign) are unknown, and so is what depends on them.

mod arithmetic;
mod calls;
mod expression;
mod files;
mod flat;
mod macros;
mod o_words;
mod parameters;
mod perhaps;
mod quirks;
mod run;
mod source;
mod statement;
#[cfg(test)]
mod tests;
mod trace;
mod value;
mod words;

pub use run::Files;

use crate::diagnostic::{Diagnostic, Severity};
use crate::dialect::Options;
use crate::error::GcodeError;
use crate::execution::{Execution, Note, Ran, Step};
use crate::program::{Language, Program};
use crate::word::{Span, Word, WordKind};
use run::Run;
use trace::{Executed, Words};

/// Evaluates a program in place: its expressions get their values, and [`interpret`](crate::interpret) reads the blocks in the order of
/// their execution. No byte changes.
///
/// `files` gives the content of subprogram files by their names: `name.ngc` in lower case for LinuxCNC; `O1234.nc`, `1234.nc`, `O1234` and
/// `O1234.NC` for Fanuc, the first that exists. A subprogram that is not found is not read: the position after it is unknown.
///
/// # Errors
/// [`GcodeError::Refused`] if the control would refuse an expression or a statement, if a jump depends on a value that is unknown, and if
/// the program does not end within 4 million repeated blocks.
pub fn evaluate(program: &mut Program, options: &Options, files: Files<'_>) -> Result<(), GcodeError> {
    if is_plain(program) || program.execution().is_some() {
        return Ok(());
    }
    let (values, again, execution) = {
        let mut run = Run::new(program, options, files);
        run.execute().map_err(|note| refused(program, note))?;
        in_place(&run)
    };
    program.set_execution(&values, &again, execution);
    Ok(())
}

/// Writes a program without parameters, expressions, branches, loops and subprograms: one block for every executed block, with the values
/// of its words. A comment before each run of blocks names their origin. Programs that have none of these come back as they are.
///
/// `files`: as for [`evaluate`].
///
/// # Errors
/// As [`evaluate`]; also if a value or a branch is known only when the program runs.
pub fn expand(program: &Program, options: &Options, files: Files<'_>) -> Result<Vec<u8>, GcodeError> {
    if is_plain(program) {
        return Ok(program.bytes().to_vec());
    }
    let mut run = Run::new(program, options, files);
    run.execute().map_err(|note| refused(program, note))?;
    flat::write(&run).map_err(|note| refused(program, note))
}

/// Whether a program has nothing to evaluate.
pub(crate) fn is_plain(program: &Program) -> bool {
    // Q parameters and labels of dialogue are interpreted with its blocks.
    let is_dialogue = program.language() == Language::Dialogue;
    is_dialogue
        || program.words().iter().all(|word| match word.kind {
            WordKind::Expression | WordKind::Assignment | WordKind::Flow => false,
            WordKind::Number if word.letter == b'M' => ![97.0, 98.0, 99.0, 198.0].contains(&word.value),
            WordKind::Number if word.letter == b'G' => word.value != 65.0,
            _ => true,
        })
}

fn refused(program: &Program, note: Note) -> GcodeError {
    let mut diagnostic = Diagnostic::new(program, Severity::Error, note.span, note.message);
    diagnostic.help = note.help.map(str::to_owned);
    GcodeError::Refused { diagnostics: vec![diagnostic] }
}

/// Values of the program's own words, the words of further executions, and the order of all.
fn in_place(run: &Run<'_>) -> (Vec<(usize, f64)>, Vec<Word>, Execution) {
    let main = &run.sources[0].program;
    let (mut values, mut again, mut steps) = (Vec::new(), Vec::new(), Vec::with_capacity(run.trace.executed.len()));
    let own_words = main.words().len();
    let mut once = vec![false; main.blocks().len()];
    for executed in &run.trace.executed {
        let words = match &executed.words {
            Words::Own if executed.source == 0 => main.word_range(executed.block),
            _ => {
                let start = again.len();
                let caller = main.blocks()[executed.caller].span;
                let at = |word: &Word| placed(word, (executed.source > 0).then_some(caller));
                again.extend(run.words_of(executed).iter().map(at));
                own_words + start..own_words + again.len()
            }
        };
        if executed.source == 0 && executed.run == 1 {
            values.extend(own_values(main, executed.block, run.words_of(executed)));
        }
        let (block, first_word, end_word) = (executed.caller as u32, words.start as u32, words.end as u32);
        let ran = ran(run, executed);
        once[executed.caller] |= ran == Ran::Once;
        steps.push(Step { block, first_word, end_word, ran });
    }
    let files = run.sources[1..].iter().map(|source| (source.name.clone(), source.program.bytes().to_vec())).collect();
    let notes = run.undecided.iter().cloned().collect();
    (values, again, Execution { once, targets: run.targets.clone(), steps, notes, files })
}

fn ran(run: &Run<'_>, executed: &Executed) -> Ran {
    match executed {
        Executed { perhaps: true, .. } => Ran::Perhaps,
        Executed { source: 1.., .. } => Ran::Elsewhere,
        Executed { block, .. } if run.trace.runs(0, *block) > 1 => Ran::Repeated,
        _ => Ran::Once,
    }
}

/// A word of another file refers to the block that calls it.
fn placed(word: &Word, caller: Option<Span>) -> Word {
    match caller {
        Some(span) => Word { span, value_start: span.end, ..*word },
        None => *word,
    }
}

/// Indices and values of the expressions of a block. The executed words are some of its words, in order.
fn own_values(main: &Program, block: usize, executed: &[Word]) -> impl Iterator<Item = (usize, f64)> {
    let mut rest = executed.iter().peekable();
    main.word_range(block).filter_map(move |index| {
        let own = main.words()[index];
        let value = rest.next_if(|word| word.span == own.span)?.value;
        (own.kind == WordKind::Expression).then_some((index, value))
    })
}
