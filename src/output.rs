//! What the commands print and write.

use std::io::Write;
use std::path::Path;

use anyhow::{Context, Result};
use comfy_table::{CellAlignment, Table, presets};
use motion::AxisKind;
use serde_json::Value;

/// Why a command ended with status 1: input or model not fit for the job.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Refusal(pub String);

impl Refusal {
    /// The exit status.
    pub const CODE: u8 = 1;
}

/// Why a command ended with status 2: an error in its use.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Usage(pub String);

/// Writes `content` to a temporary file beside `path`, syncs it and renames it: nothing half-written is ever seen. Missing folders
/// are made.
pub fn write_file(path: &Path, content: &[u8]) -> Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    datasets::write_atomically(path, |file| {
        file.write_all(content).map_err(|source| datasets::DatasetError::Io { path: path.to_owned(), source })
    })
    .with_context(|| format!("cannot write {}", path.display()))
}

/// Refuses to write over an input.
pub fn check_not_input(input: &Path, out: &Path) -> Result<()> {
    let same = match (input.canonicalize(), out.canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    };
    if same {
        return Err(Usage(format!("{} is the input; name another file for the output", out.display())).into());
    }
    Ok(())
}

/// Reads a file; a missing one is an error in use.
pub fn read_file(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|error| Usage(format!("cannot read {}: {error}", path.display())).into())
}

/// Writes the figures where `--json` says.
pub fn write_json(path: Option<&Path>, value: &Value) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    let text = serde_json::to_string_pretty(value)? + "\n";
    if path == Path::new("-") {
        std::io::stdout().write_all(text.as_bytes())?;
        return Ok(());
    }
    write_file(path, text.as_bytes())
}

/// Prints to standard output, unless that carries the JSON.
pub struct Printer {
    to_stderr: bool,
}

impl Printer {
    /// The printer beside this `--json`.
    pub fn new(json: Option<&Path>) -> Self {
        Self { to_stderr: json == Some(Path::new("-")) }
    }

    /// Prints a line. A reader that has gone away (`| head`) does not matter: what is written to files is still wanted.
    pub fn line(&self, text: impl std::fmt::Display) {
        let _ = if self.to_stderr { writeln!(std::io::stderr(), "{text}") } else { writeln!(std::io::stdout(), "{text}") };
    }
}

/// A plain table: the first column to the left, the others to the right.
pub fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header(header);
    for row in rows {
        table.add_row(row);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.to_string()
}

/// Micrometres of a length in mm, as printed.
pub fn um(value_mm: f64) -> String {
    format!("{:.3}", value_mm * 1e3)
}

/// How programs and tables state positions of an axis: what its mm or rad are multiplied by, and the unit.
pub fn in_programs(kind: AxisKind) -> (f64, &'static str) {
    match kind {
        AxisKind::Linear => (1.0, "mm"),
        AxisKind::Rotary => (1.0_f64.to_degrees(), "deg"),
    }
}
