//! What the commands print and write.

use std::cell::RefCell;
use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use anyhow::{Context, Result};
use comfy_table::{CellAlignment, Table, presets};
use serde_json::Value;

use crate::same_file::called_at;

/// The exit status where input or model are not fit for the job.
pub const REFUSED: u8 = 1;

/// Why a command ended with that status, where the library has no error of its own for it.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Refusal(pub String);

/// Why a command ended with status 2: an error in its use.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Usage(pub String);

/// An error as it is printed after `error: `.
#[must_use]
pub fn text(error: &anyhow::Error) -> String {
    let text = format!("{error:#}");
    text.strip_prefix("error: ").map_or_else(|| text.clone(), str::to_owned)
}

/// The outputs of a command, collected before anything is written: a command that fails leaves no file.
#[derive(Debug, Default)]
pub struct Outputs {
    files: Vec<(PathBuf, Vec<u8>)>,
    spools: Vec<(PathBuf, File)>,
}

impl Outputs {
    /// One more file.
    pub fn add(&mut self, path: &Path, content: impl Into<Vec<u8>>) {
        self.files.push((path.to_owned(), content.into()));
    }

    /// One more log.
    ///
    /// # Errors
    /// When command and actual positions do not match.
    pub fn add_log(&mut self, path: &Path, log: &datasets::Log) -> Result<()> {
        self.add(path, datasets::log_content(path, log)?);
        Ok(())
    }

    /// One more file, whose content is in a file already.
    pub fn add_spool(&mut self, (path, spool): (PathBuf, File)) {
        self.spools.push((path, spool));
    }

    /// Writes all files, and the figures to the path of `--json`. All files are complete, under temporary names, before the first one is renamed.
    /// Missing folders are made.
    ///
    /// # Errors
    /// When a figure is absurd or a file cannot be written.
    pub fn write(mut self, json: Option<&Path>, figures: &Value) -> Result<()> {
        check_figures(figures, "")?;
        let text = serde_json::to_string_pretty(figures)? + "\n";
        let to_stdout = json == Some(Path::new("-"));
        if let Some(path) = json.filter(|_| !to_stdout) {
            self.add(path, text.as_bytes());
        }
        let paths = self.files.iter().map(|(path, _)| path).chain(self.spools.iter().map(|(path, _)| path));
        if let Some(called) = paths.into_iter().find_map(|path| called_at(path)) {
            let why = format!("{} would be written over, and is a file that the input calls or includes", called.display());
            return Err(Usage(format!("{why}; name another file")).into());
        }
        datasets::write_all_and(&self.files, &mut self.spools).context("cannot write")?;
        if to_stdout {
            std::io::stdout().write_all(text.as_bytes())?;
        }
        Ok(())
    }
}

/// Largest magnitude of a figure: far beyond a kilometre in micrometres or a year in milliseconds, far below what a damaged number gives.
const LARGEST_FIGURE: f64 = 1e15;

/// A figure far out of range, from a damaged number in the input.
#[derive(Debug, thiserror::Error)]
#[error("the figure `{key}` came out as {value}: the input holds a damaged number; nothing was written")]
pub struct AbsurdFigure {
    /// Where it stands in the JSON, as `worst[0].t_s`.
    pub key: String,
    /// The figure.
    pub value: f64,
}

/// Refuses figures that are out of range. Values that are not finite are `null` in JSON.
fn check_figures(value: &Value, key: &str) -> Result<(), AbsurdFigure> {
    match value {
        Value::Number(number) if number.is_f64() => match number.as_f64() {
            Some(value) if value.is_nan() || value.abs() > LARGEST_FIGURE => Err(AbsurdFigure { key: key.to_owned(), value }),
            _ => Ok(()),
        },
        Value::Array(values) => {
            values.iter().enumerate().try_for_each(|(index, value)| check_figures(value, &format!("{key}[{index}]")))
        }
        Value::Object(entries) => entries.iter().try_for_each(|(name, value)| {
            let dot = if key.is_empty() { "" } else { "." };
            check_figures(value, &format!("{key}{dot}{name}"))
        }),
        _ => Ok(()),
    }
}

/// Reads a file; a missing one is an error in use.
pub fn read_file(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|error| Usage(format!("cannot read {}: {error}", path.display())).into())
}

/// Reads at most `most` bytes of a file, and one more where it is longer; a missing one is an error in use.
pub fn read_file_up_to(path: &Path, most: usize) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let read = File::open(path).and_then(|file| file.take(most as u64 + 1).read_to_end(&mut bytes));
    read.map_err(|error| Usage(format!("cannot read {}: {error}", path.display())))?;
    Ok(bytes)
}

/// Writes the figures of a command that has no other output.
pub fn write_json(path: Option<&Path>, value: &Value) -> Result<()> {
    Outputs::default().write(path, value)
}

/// Prints to standard output, unless that carries the JSON.
#[derive(Debug)]
pub struct Printer(Sink);

/// Where lines go.
#[derive(Debug)]
enum Sink {
    Stdout,
    Stderr,
    /// Only warnings, to standard error.
    Warnings,
    Memory(RefCell<Vec<String>>),
}

/// How a line that is a warning begins.
const WARNING: &str = "warning";

impl Printer {
    /// The printer beside this `--json`.
    #[must_use]
    pub fn new(json: Option<&Path>) -> Self {
        Self(if json == Some(Path::new("-")) { Sink::Stderr } else { Sink::Stdout })
    }

    /// A printer of warnings only.
    #[must_use]
    pub fn quiet() -> Self {
        Self(Sink::Warnings)
    }

    /// A printer that keeps its lines.
    #[must_use]
    pub fn keeping() -> Self {
        Self(Sink::Memory(RefCell::default()))
    }

    /// The lines that were kept; none of a printer that prints.
    #[must_use]
    pub fn into_lines(self) -> Vec<String> {
        match self.0 {
            Sink::Memory(lines) => lines.into_inner(),
            Sink::Stdout | Sink::Stderr | Sink::Warnings => Vec::new(),
        }
    }

    /// Prints a line. A closed pipe (`| head`) is ignored: the files are still written. Other faults are kept for [`check_printed`].
    pub fn line(&self, text: impl std::fmt::Display) {
        let _ = match &self.0 {
            Sink::Stdout => {
                let printed = writeln!(std::io::stdout(), "{text}");
                if let Err(error) = &printed
                    && error.kind() != ErrorKind::BrokenPipe
                {
                    let _ = NOT_PRINTED.set(error.to_string());
                }
                printed
            }
            Sink::Stderr => writeln!(std::io::stderr(), "{text}"),
            Sink::Warnings => {
                let text = text.to_string();
                let mut warnings = text.lines().filter(|line| line.starts_with(WARNING));
                warnings.try_for_each(|line| writeln!(std::io::stderr(), "{line}"))
            }
            Sink::Memory(lines) => {
                lines.borrow_mut().push(text.to_string());
                Ok(())
            }
        };
    }
}

/// Why a line could not be printed.
static NOT_PRINTED: OnceLock<String> = OnceLock::new();

/// Refuses a command whose lines could not be printed, on a full disk.
///
/// # Errors
/// [`Refusal`] with the reason.
pub fn check_printed() -> Result<()> {
    match NOT_PRINTED.get() {
        Some(why) => Err(Refusal(format!("cannot write to standard output: {why}")).into()),
        None => Ok(()),
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

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn absurd_figures_are_named_and_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("figures.json");
        let error = write_json(Some(&path), &json!({ "worst": [{ "t_s": 1.0 }, { "t_s": 1e300 }] })).unwrap_err();
        assert!(error.to_string().contains("`worst[1].t_s` came out as 1"), "{error}");
        assert!(!path.exists());
        write_json(Some(&path), &json!({ "rms": f64::NAN, "max": f64::INFINITY, "seed": u64::MAX })).unwrap();
        let read: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        assert_eq!(read, json!({ "rms": null, "max": null, "seed": u64::MAX }));
    }
}
