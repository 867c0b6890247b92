//! What was read of a program.

use gcode::{Diagnostic, Dialect, Language, Options, Program};

use crate::output::Printer;

/// The dialect that was found in the program, where no option and no profile states one.
pub fn show_dialect(printer: &Printer, program: &Program, options: &Options) {
    if program.language() == Language::Dialogue {
        return;
    }
    let (name, dialect) = (dialect_name(program, options), options.dialect);
    printer.line(if dialect.is_certain(program) {
        format!("dialect: {name}, found in the program or its name")
    } else {
        format!("dialect: {name}, a guess, since the program holds no code that decides; --dialect or --controller states it")
    });
}

/// The dialect in which a program was read, as `--dialect` calls it.
pub fn dialect_name(program: &Program, options: &Options) -> &'static str {
    match (program.language(), options.dialect) {
        (Language::Dialogue, _) => "heidenhain",
        (_, Dialect::Fanuc) => "fanuc",
        (_, Dialect::LinuxCnc) => "linuxcnc",
        (_, Dialect::Sinumerik) => "sinumerik",
    }
}

/// Warnings of a program that are printed without `--verbose`.
const WARNINGS: usize = 20;

/// The warnings of a program: `all`, or those of the same text in one and at most twenty.
pub fn show_warnings(printer: &Printer, warnings: &[Diagnostic], (program, name): (&Program, &str), all: bool) {
    if all {
        return warnings.iter().for_each(|warning| printer.line(warning.render(program, name)));
    }
    let (texts, left_out) = gcode::render_merged(warnings, program, name, WARNINGS);
    texts.iter().for_each(|text| printer.line(text));
    if left_out > 0 {
        printer.line(format!("warning: {left_out} more warnings; --verbose shows all"));
    }
}
