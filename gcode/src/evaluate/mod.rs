//! Evaluates parameters, expressions, branches, loops and subprograms, as the control does when it runs the program.
//!
//! LinuxCNC: O-words, numbered and named parameters, M98 and M99. Fanuc: custom macro B with local, common and system variables, IF, GOTO,
//! WHILE, G65, M98, M97 (Haas) and M198. G66 is not evaluated. Values that an earlier program, the operator or the machine sets (system
//! variables, probe results, tool data, parameters that the program does not assign) are unknown, and so is what depends on them.

mod arithmetic;
mod calls;
mod control;
mod expression;
mod files;
mod flat;
mod flatten;
mod hash;
mod macros;
mod o_words;
mod parameters;
mod perhaps;
mod progress;
mod quirks;
mod recorded;
mod run;
mod sinumerik;
mod source;
mod statement;
#[cfg(test)]
mod tests;
mod trace;
mod value;
mod words;

pub use files::Files;

use crate::block_end::{has_remarks, is_behind};
use crate::diagnostic::{Diagnostic, Severity};
use crate::dialect::{Dialect, Options};
use crate::error::GcodeError;
use crate::execution::Note;
use crate::program::{Language, Program};
use crate::word::{Word, WordKind};
use run::Run;

/// Evaluates a program in place: its expressions get their values, and [`interpret`](crate::interpret) reads the blocks in the order of
/// their execution. No byte changes.
///
/// `files` gives the content of subprogram files by their names: `name.ngc` in lower case for LinuxCNC; `O1234.nc`, `1234.nc`, `O1234` and
/// `O1234.NC` for Fanuc; `NAME.SPF`, `NAME.MPF` and `_N_NAME_SPF` for SINUMERIK, in any case: the first that exists. A subprogram that is not found is not read: the position after it is unknown, and so
/// are the modes ([`Macros`](crate::Macros)).
///
/// # Errors
/// [`GcodeError::Refused`] if the control would refuse an expression or a statement, if a jump depends on a value that is unknown, and if
/// the program repeats itself, or does not end within 4 million repeated blocks.
pub fn evaluate(program: &mut Program, options: &Options, files: Files<'_>) -> Result<(), GcodeError> {
    if let Some(language) = options.dialect.language_of(program) {
        *program = std::mem::take(program).in_language(language);
    }
    if is_plain(program) || program.execution().is_some() {
        return Ok(());
    }
    let (values, again, execution) = if program.language() == Language::Sinumerik {
        let mut run = sinumerik::Run::new(program, options, files);
        run.execute().map_err(|note| refused(program, note))?;
        run.recorded().in_place()
    } else {
        let mut run = Run::new(program, options, files);
        run.execute().map_err(|note| refused(program, note))?;
        run.recorded().in_place()
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
    if let Some(language) = options.dialect.language_of(program) {
        return expand(&program.clone().in_language(language), options, files);
    }
    if is_plain(program) {
        return Ok(program.bytes().to_vec());
    }
    if let Some(word) = block_behind(program, options.dialect) {
        let message =
            "words behind `;` may be a block of their own: the program cannot be written without what it does".to_owned();
        let help = Some("write one block a line, or the comment in parentheses");
        let diagnostic = Diagnostic::new(program, Severity::Error, word.span, message);
        return Err(GcodeError::Refused { diagnostics: vec![Diagnostic { help: help.map(str::to_owned), ..diagnostic }] });
    }
    if program.language() == Language::Sinumerik {
        let mut run = sinumerik::Run::new(program, options, files);
        run.execute().map_err(|note| refused(program, note))?;
        return flatten::write(&run, &run.recorded()).map(|(text, _)| text).map_err(|note| refused(program, note));
    }
    let mut run = Run::new(program, options, files);
    run.execute().map_err(|note| refused(program, note))?;
    flat::write(&run).map_err(|note| refused(program, note))
}

/// The first words behind `;` that may be a block of their own.
fn block_behind(program: &Program, dialect: Dialect) -> Option<Word> {
    if dialect != Dialect::Fanuc || has_remarks(program) {
        return None;
    }
    let of_block = |block: usize| {
        let mut words = program.block_words(block).iter().enumerate();
        words.find(|(index, word)| is_behind(program, word, *index == 0)).map(|(_, word)| *word)
    };
    (0..program.blocks().len()).find_map(of_block)
}

/// Whether a program has nothing to evaluate.
pub(crate) fn is_plain(program: &Program) -> bool {
    // Q parameters and labels of dialogue are interpreted with its blocks.
    let is_dialogue = program.language() == Language::Dialogue;
    is_dialogue
        || program.words().iter().all(|word| match word.kind {
            WordKind::Expression | WordKind::Assignment | WordKind::Flow => false,
            // Names that are not known may be subprograms.
            WordKind::Unknown => program.language() != Language::Sinumerik,
            WordKind::Number if word.letter == b'L' => program.language() != Language::Sinumerik,
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
