//! Reads logs from files.

use std::path::Path;

use motion::{Axis, Trajectory};

use crate::columns::implied_period_s;
use crate::formats::{read_table, table_of};
use crate::options::ReadOptions;
use crate::quality::{significant_digits, step_of};
use crate::side_file::read_side_file;
use crate::timing::{resample, settle};
use crate::{Check, ColumnMap, DatasetError, Finding, Log, Report, Severity, Source, Table};

/// Largest magnitude of a position, mm or rad: a kilometre, or 160,000 revolutions of an endless
/// axis.
pub(crate) const FARTHEST: f64 = 1e6;
/// Largest magnitude of a time stamp, s: more than three thousand years; a clock may count from
/// 1601.
pub(crate) const LATEST_S: f64 = 1e11;
/// Shortest and longest sampling period, s: 1 MHz, and slower than any log that shows a motion.
const SHORTEST_S: f64 = 1e-6;
const LONGEST_S: f64 = 10.0;

/// Reads one run, and reports the corrections for a uniform rate.
///
/// The report is about reading only; [`assess`](crate::assess) checks the fitness for a purpose.
///
/// # Errors
/// When the file cannot be read, its columns are not recognised, a required value is missing, the
/// time stamps go back, or the sampling period is unknown.
pub fn read_log(path: &Path, options: &ReadOptions) -> Result<(Log, Report), DatasetError> {
    let table = read_table(path)?;
    let mut report = Report { findings: table.findings.clone() };
    let options = stated(path, options, &mut report)?;
    log_of(path, &table, &options, report)
}

/// The options, with what a side file says beside them.
///
/// # Errors
/// When the side file cannot be read.
pub(crate) fn stated(path: &Path, options: &ReadOptions, report: &mut Report) -> Result<ReadOptions, DatasetError> {
    let mut options = options.clone();
    if let Some((beside, said)) = read_side_file(path)? {
        options.columns = options.columns.or(said.columns);
        options.period_s = options.period_s.or(said.period_s);
        let message = format!("what columns and period are is taken from {}", beside.display());
        report.push(Finding::new(Severity::Note, Check::Mended, message));
    }
    Ok(options)
}

/// As [`read_log`], from bytes; errors and the run have the name `name`.
///
/// # Errors
/// As [`read_log`].
pub fn log_from_bytes(name: &Path, bytes: Vec<u8>, options: &ReadOptions) -> Result<(Log, Report), DatasetError> {
    let table = table_of(name, bytes)?;
    let report = Report { findings: table.findings.clone() };
    log_of(name, &table, options, report)
}

/// As [`read_log`], from columns that are already in memory, named as in a file; errors and the run have the name `name`.
///
/// # Errors
/// As [`read_log`].
pub fn log_from_table(name: &Path, table: &Table, options: &ReadOptions) -> Result<(Log, Report), DatasetError> {
    log_of(name, table, options, Report { findings: table.findings.clone() })
}

/// The columns that the options state, or that are recognised.
///
/// # Errors
/// When there are none.
pub(crate) fn map_of(path: &Path, table: &Table, options: &ReadOptions) -> Result<ColumnMap, DatasetError> {
    match &options.columns {
        Some(text) => ColumnMap::parse(text, path, table),
        None => ColumnMap::recognise(path, table),
    }
}

/// The run of a table, and `report` with the corrections for a uniform rate.
///
/// # Errors
/// As [`read_log`].
pub(crate) fn log_of(
    path: &Path,
    table: &Table,
    options: &ReadOptions,
    mut report: Report,
) -> Result<(Log, Report), DatasetError> {
    let map = map_of(path, table, options)?;
    report.findings.extend(map.findings());
    let mut sources = Vec::new();
    for axis in &map.axes {
        sources.push((axis.axis.clone(), axis.reference));
    }
    for axis in &map.axes {
        sources.push((axis.axis.clone(), axis.actual));
    }
    let ((period_s, start_s), mut columns, findings) = uniform_columns(path, table, map.time, &sources, options.period_s)?;
    report.findings.extend(findings);
    let actual = columns.split_off(map.axes.len());
    let axes: Vec<Axis> = map.axes.into_iter().map(|columns| columns.axis).collect();
    let log =
        Log::new(run_name(path), Trajectory::new(period_s, axes.clone(), columns)?, Trajectory::new(period_s, axes, actual)?)?;
    Ok((log.starting_at(start_s), report))
}

pub(crate) fn run_name(path: &Path) -> String {
    path.file_stem().map_or_else(|| "log".to_owned(), |stem| stem.to_string_lossy().into_owned())
}

/// Period and time of the first row, s; the columns; findings.
type Uniform = ((f64, f64), Vec<Vec<f64>>, Vec<Finding>);

/// The columns of `sources` at a uniform rate, that rate and the first time stamp, and findings.
pub(crate) fn uniform_columns(
    path: &Path,
    table: &Table,
    time: Option<Source>,
    sources: &[(Axis, Source)],
    period_s: Option<f64>,
) -> Result<Uniform, DatasetError> {
    let mut columns = sources
        .iter()
        .map(|(axis, source)| table.within(path, source.column, source.scale, FARTHEST, axis.kind.unit()))
        .collect::<Result<Vec<_>, _>>()?;
    let Some(time) = time else {
        let period_s = table
            .period_s
            .or(period_s)
            .ok_or_else(|| DatasetError::NoTime { path: path.to_owned(), hints: hints(table, sources, &columns) })?;
        check_period(path, period_s)?;
        return Ok(((period_s, 0.0), columns, Vec::new()));
    };
    let mut times = table.within(path, time.column, time.scale, LATEST_S, "s")?;
    let mut lines = table.lines.clone();
    let mut findings = drop_repeated_rows(&mut times, &mut lines, &mut columns);
    let timing = settle(path, &times, &lines)?;
    check_period(path, timing.period_s)?;
    findings.extend(timing.findings);
    if timing.resample {
        columns = columns.iter().map(|column| resample(&times, column, timing.period_s)).collect();
    }
    let start_s = times.first().copied().unwrap_or_default();
    Ok(((timing.period_s, start_s), columns, findings))
}

/// Refuses an implausible sampling period.
pub(crate) fn check_period(path: &Path, period_s: f64) -> Result<(), DatasetError> {
    if (SHORTEST_S..=LONGEST_S).contains(&period_s) {
        return Ok(());
    }
    let why = format!(
        "the sampling period is {period_s:e} s; logs have one from {SHORTEST_S:e} to {LONGEST_S} s: mend the time column, its unit or the stated period"
    );
    Err(DatasetError::format(path, why))
}

/// A duplicated row (same stamp, same values) contains no information.
fn drop_repeated_rows(times: &mut Vec<f64>, lines: &mut Vec<usize>, columns: &mut [Vec<f64>]) -> Vec<Finding> {
    let keep: Vec<bool> = (0..times.len())
        .map(|k| k == 0 || times[k] != times[k - 1] || columns.iter().any(|column| column[k] != column[k - 1]))
        .collect();
    let Some(first) = keep.iter().position(|keep| !keep) else {
        return Vec::new();
    };
    let message = format!(
        "{} rows repeat the row before them, stamp and all (first in line {}); they were left out",
        keep.iter().filter(|keep| !**keep).count(),
        lines[first]
    );
    let retain = |column: &mut Vec<f64>| {
        let mut kept = keep.iter();
        column.retain(|_| kept.next().copied().unwrap_or(true));
    };
    retain(times);
    columns.iter_mut().for_each(retain);
    let mut kept = keep.iter();
    lines.retain(|_| kept.next().copied().unwrap_or(true));
    vec![Finding::new(Severity::Warn, Check::Mended, message)]
}

/// Estimates from a file without time stamps: its probable rate and its digits.
fn hints(table: &Table, sources: &[(Axis, Source)], columns: &[Vec<f64>]) -> String {
    let mut hints = String::from("; state the sampling period if it is known");
    if let Some(period_s) = implied_period_s(table) {
        hints += &format!(". Its velocity columns suggest about {:.2} s ({:.0} Hz)", period_s, 1.0 / period_s);
        if 1.0 / period_s < crate::quality::SLOWEST_HZ {
            hints += &format!(", too slow for training, which needs at least {} Hz", crate::quality::SLOWEST_HZ);
        }
    }
    let coarsest = sources
        .iter()
        .zip(columns)
        .filter_map(|((axis, _), column)| {
            let step = step_of(column)?;
            Some((axis, step, significant_digits(column, step)))
        })
        .min_by_key(|(_, _, digits)| *digits);
    if let Some((axis, step, digits)) = coarsest
        && digits <= 4
    {
        hints += &format!("; positions of `{axis}` have {digits} significant digits (steps of {step} {})", axis.kind.unit());
    }
    hints
}
