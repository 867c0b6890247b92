//! Logs and references that are too long to be held: read once for what they are, then in pieces as often as needed.

mod extent;
mod findings;
mod pieces;
mod recording;
mod stamps;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use motion::Axis;

use crate::columns::{CommandColumns, PROBED_ROWS, Side, recognise_reference, table_encoders};
use crate::cycles::has_counter;
use crate::formats::{CsvHead, CsvRows, ParquetRows, Rows, parquet_head};
use crate::missing::is_incomplete;
use crate::options::ReadOptions;
use crate::read::{map_of, run_name, stated};
use crate::recorded::{LATEST_S, check_period, stated_period_s};
use crate::reference::commands_of;
use crate::spikes::Spikes;
use crate::tracking_errors::{Positions, Signs};
use crate::turns::steps_by_a_turn;
use crate::usable::Usable;
use crate::{Check, DatasetError, Finding, Report, Severity, Source, Table};
use stamps::Stamps;

pub use extent::Extent;
pub use findings::PieceFindings;
pub use pieces::{Lengths, Piece, Pieces};
pub use recording::Recording;

/// Rows that are read at once in the first pass.
const BATCH: usize = 1 << 16;

/// A log or reference in a file, with what the first pass over it found.
#[derive(Debug)]
pub struct LongFile {
    path: PathBuf,
    format: Format,
    axes: Vec<Axis>,
    /// Columns of the commanded positions, then those of the reported ones.
    sources: Vec<Source>,
    /// The side of every axis whose column holds the tracking error.
    errors: Vec<Option<Side>>,
    period_s: f64,
    start_s: f64,
    rows: usize,
    extents: Vec<Extent>,
    /// What reading found.
    pub report: Report,
}

#[derive(Debug)]
enum Format {
    Csv(Box<CsvHead>),
    Parquet,
}

/// Axes, time column, columns of positions, and what is to be known of them.
struct Columns {
    axes: Vec<Axis>,
    time: Option<Source>,
    sources: Vec<Source>,
    /// The side of every axis whose column holds the tracking error; none of a reference.
    errors: Vec<Option<Side>>,
    findings: Vec<Finding>,
}

/// Travel of an axis that is not known before all of the file is read, rad.
const UNKNOWN_TRAVEL: f64 = f64::MIN_POSITIVE;

impl LongFile {
    /// The log in `path`, where it has more than `most` rows. `None` for a shorter one, and for what is read whole only: formats other than
    /// CSV and Parquet, uneven or repeated time stamps, missing values, spikes, turns of rotary axes that begin anew, counters of cycles, and columns with clocks of their own.
    ///
    /// # Errors
    /// As [`read_log`](crate::read_log).
    pub fn log(path: &Path, options: &ReadOptions, most: usize) -> Result<Option<Self>, DatasetError> {
        Self::open(path, options, most, |table, options| {
            let map = map_of(path, table, options)?;
            let sources = map.axes.iter().map(|axis| axis.reference).chain(map.axes.iter().map(|axis| axis.actual)).collect();
            let errors = map.axes.iter().map(|axis| axis.error_for).collect();
            let (time, mut findings) = (map.time, map.findings());
            findings.extend(map.axes.iter().filter_map(|axis| axis.unstated_angle(UNKNOWN_TRAVEL)));
            let is_one = map.clocks.is_empty();
            let axes = map.axes.into_iter().map(|axis| axis.axis).collect();
            Ok(is_one.then_some(Columns { axes, time, sources, errors, findings }))
        })
    }

    /// The same for a reference; of a log, the commanded columns.
    ///
    /// # Errors
    /// As [`read_reference`](crate::read_reference).
    pub fn reference(path: &Path, options: &ReadOptions, most: usize) -> Result<Option<Self>, DatasetError> {
        Self::open(path, options, most, |table, options| {
            let columns = match &options.columns {
                Some(_) => commands_of(path, table, map_of(path, table, options)?)?,
                None => recognise_reference(path, table)?,
            };
            let CommandColumns { time, clocks, axes } = columns;
            let (axes, sources) = axes.into_iter().unzip();
            Ok(clocks.is_empty().then_some(Columns { axes, time, sources, errors: Vec::new(), findings: Vec::new() }))
        })
    }

    fn open(
        path: &Path,
        options: &ReadOptions,
        most: usize,
        columns: impl FnOnce(&Table, &ReadOptions) -> Result<Option<Columns>, DatasetError>,
    ) -> Result<Option<Self>, DatasetError> {
        let (format, table, rows) = match parquet_head(path)? {
            Some((mut table, rows)) => {
                probe_encoders(path, &mut table)?;
                (Format::Parquet, table, rows)
            }
            None => match CsvHead::of(path)? {
                Some(head) => {
                    let (table, rows) = (head.table.clone(), head.rows);
                    (Format::Csv(Box::new(head)), table, rows)
                }
                None => return Ok(None),
            },
        };
        if rows <= most {
            return Ok(None);
        }
        let mut report = Report::default();
        let options = stated(path, options, &mut report)?;
        let Some(Columns { axes, time, sources, errors, findings }) = columns(&table, &options)? else { return Ok(None) };
        report.findings.extend(findings);
        if time.is_none() {
            // The head has all that an error about the period says.
            let named: Vec<(Axis, Source)> = axes.iter().cloned().zip(sources.iter().copied()).collect();
            stated_period_s(path, &table, &named, options.period_s)?;
            if has_counter(&table) {
                return Ok(None);
            }
        }
        let (period_s, extents) = (options.period_s.unwrap_or_default(), vec![Extent::default(); axes.len()]);
        let mut file =
            Self { path: path.to_owned(), format, axes, sources, errors, period_s, start_s: 0.0, rows: 0, extents, report };
        Ok(file.scan(&table, time)?.then_some(file))
    }

    /// The first pass: checks every value, and finds period, extents and the number of rows. Whether the file can be read in pieces.
    fn scan(&mut self, head: &Table, time: Option<Source>) -> Result<bool, DatasetError> {
        let mut wanted = self.sources.clone();
        wanted.extend(time);
        let (mut rows, is_log) = (self.rows_of(&wanted)?, !self.is_reference());
        let (mut columns, mut lines, mut stamps) = (vec![Vec::new(); wanted.len()], Vec::new(), Stamps::default());
        let positions = self.sources.len();
        let mut signs = Signs::new(&self.errors);
        let mut usable = Usable::new(&self.path, head, &self.axes, &self.sources);
        let (mut missing, mut last) = (vec![0; positions], vec![f64::NAN; positions]);
        let mut spikes: Vec<Spikes> = (0..positions).map(|slot| Spikes::new(&self.axes[slot % self.axes.len()])).collect();
        while rows.read(BATCH, &mut columns, &mut lines)? > 0 {
            usable.note(&columns[..positions], &lines);
            if self.is_reference() {
                usable.check_all()?;
            }
            if time.is_some() && columns[positions].iter().any(|time| time.is_nan()) {
                return Ok(false);
            }
            if let Some(time) = time {
                self.check_times(head, time, &columns[positions], &lines)?;
            }
            signs.note(&columns[..positions]);
            for (slot, column) in columns[..positions].iter().enumerate() {
                missing[slot] += column.iter().filter(|value| !value.is_finite()).count();
                let axis = &self.axes[slot % self.axes.len()];
                for value in column {
                    if steps_by_a_turn(axis, last[slot], *value) || is_log && spikes[slot].note(*value).is_some() {
                        return Ok(false);
                    }
                    last[slot] = *value;
                }
            }
            for (extent, column) in self.extents.iter_mut().zip(&columns) {
                column.iter().for_each(|at| extent.note(*at));
            }
            if time.is_some() {
                columns[positions].iter().for_each(|time| stamps.note(*time));
            }
            self.rows += lines.len();
            columns.iter_mut().for_each(Vec::clear);
            lines.clear();
            if stamps.is_hopeless() {
                return Ok(false);
            }
        }
        if missing.iter().any(|missing| is_incomplete(*missing, self.rows)) {
            return Ok(false);
        }
        self.report.findings.extend(signs.finding(&self.axes));
        let (kept, left_out) = usable.finish()?;
        self.report.findings.extend(left_out);
        self.keep(&kept);
        if let Some(why) = rows.cut_off() {
            self.report.findings.insert(0, Finding::new(Severity::Warn, Check::Mended, why));
        }
        if time.is_some() {
            let Some(period_s) = stamps.period_s() else { return Ok(false) };
            check_period(&self.path, period_s)?;
            (self.period_s, self.start_s) = (period_s, stamps.first_s());
        }
        Ok(true)
    }

    /// Whether the file holds commanded positions only.
    fn is_reference(&self) -> bool {
        self.sources.len() == self.axes.len()
    }

    /// Keeps these axes only.
    fn keep(&mut self, kept: &[usize]) {
        let axes = self.axes.len();
        self.sources =
            (0..self.sources.len()).filter(|slot| kept.contains(&(slot % axes))).map(|slot| self.sources[slot]).collect();
        self.extents = kept.iter().map(|axis| self.extents[*axis]).collect();
        self.errors = kept.iter().filter_map(|axis| self.errors.get(*axis).copied()).collect();
        self.axes = kept.iter().map(|axis| self.axes[*axis].clone()).collect();
    }

    /// Refuses time stamps that are missing or out of range.
    fn check_times(&self, head: &Table, time: Source, values: &[f64], lines: &[usize]) -> Result<(), DatasetError> {
        let (most, unit) = (LATEST_S, "s");
        let Some(row) = values.iter().position(|value| !(-most..=most).contains(value)) else { return Ok(()) };
        let (path, line, value) = (self.path.clone(), lines[row], values[row]);
        let column = head.names.get(time.column).cloned().unwrap_or_default();
        Err(if value.is_finite() {
            DatasetError::Absurd { path, line, column, value, most, unit }
        } else {
            DatasetError::Missing { path, line, column }
        })
    }

    fn rows_of(&self, wanted: &[Source]) -> Result<Box<dyn Rows>, DatasetError> {
        let rows: Box<dyn Rows> = match &self.format {
            Format::Csv(head) => Box::new(CsvRows::open(&self.path, head, wanted)?),
            Format::Parquet => Box::new(ParquetRows::open(&self.path, wanted)?),
        };
        let sides = self.errors.clone();
        Ok(if sides.iter().any(Option::is_some) { Box::new(Positions { rows, sides }) } else { rows })
    }

    fn positions(&self) -> Vec<Source> {
        self.sources.clone()
    }

    /// The axes, in column order.
    #[must_use]
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// Time between samples, s.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Time stamp of the first sample, s; zero if unknown.
    #[must_use]
    pub fn start_s(&self) -> f64 {
        self.start_s
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rows
    }

    /// Whether there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows == 0
    }

    /// Name of the run: that of the file without its ending.
    #[must_use]
    pub fn name(&self) -> String {
        run_name(&self.path)
    }

    /// Extents of the commanded positions, one an axis.
    #[must_use]
    pub fn extents(&self) -> &[Extent] {
        &self.extents
    }

    /// The pieces of the log, from its start.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn pieces(&self, lengths: Lengths) -> Result<Pieces<'_>, DatasetError> {
        Pieces::new(self, lengths)
    }
}

/// Reads the first rows of the columns of second encoders, which show whether these are there.
fn probe_encoders(path: &Path, table: &mut Table) -> Result<(), DatasetError> {
    for column in table_encoders(table) {
        let mut values = vec![Vec::new()];
        ParquetRows::open(path, &[Source { column, scale: 1.0 }])?.read(PROBED_ROWS, &mut values, &mut Vec::new())?;
        table.columns[column] = values.swap_remove(0);
    }
    Ok(())
}
