//! Reads logs from files.

use std::borrow::Cow;
use std::path::Path;

use motion::{Axis, Trajectory};

use crate::clocks::on_one_clock;
use crate::columns::Side;
use crate::formats::{read_table, table_of};
use crate::options::ReadOptions;
use crate::parts::{Parts, noted, of_one_period};
use crate::recorded::Recorded;
use crate::side_file::read_side_file;
use crate::usable::Usable;
use crate::{
    Check, ColumnMap, DatasetError, Finding, Log, Report, Severity, Source, Table, missing, spikes, tracking_errors, turns,
};

/// Reads one run, and reports the corrections for a uniform rate.
///
/// Columns with clocks of their own are joined to that of the command, with a finding. An axis with missing or implausible values, or whose actual position does not move with its command, is left out with a finding.
/// The report is about reading only; [`assess`](crate::assess) checks the fitness for a purpose. A file whose time stamps have gaps is
/// refused by a finding: it is no one run ([`read_runs`]).
///
/// # Errors
/// When the file cannot be read, its columns are not recognised, no axis can be used, a time stamp is missing, the
/// time stamps go back, or the sampling period is unknown.
pub fn read_log(path: &Path, options: &ReadOptions) -> Result<(Log, Report), DatasetError> {
    let (table, options, report) = opened(path, options)?;
    log_of(path, &table, &options, report)
}

/// As [`read_log`], cut into a run for every stretch without a gap in its time stamps. Every gap is a finding. Of a file that is cut, runs
/// that are too short to train on are left out, with a finding.
///
/// # Errors
/// As [`read_log`], and when all runs of a file that is cut are too short.
pub fn read_runs(path: &Path, options: &ReadOptions) -> Result<(Vec<Log>, Report), DatasetError> {
    let (table, options, report) = opened(path, options)?;
    runs_of(path, &table, &options, report)
}

/// The table of a file, and what is stated beside it.
///
/// # Errors
/// When the file cannot be read.
pub(crate) fn opened(path: &Path, options: &ReadOptions) -> Result<(Table, ReadOptions, Report), DatasetError> {
    let table = read_table(path)?;
    let mut report = Report { findings: table.findings.clone() };
    let options = stated(path, options, &mut report)?;
    Ok((table, options, report))
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
    log_from_table(name, &table, options)
}

/// As [`read_log`], from columns that are already in memory, named as in a file; errors and the run have the name `name`.
///
/// # Errors
/// As [`read_log`].
pub fn log_from_table(name: &Path, table: &Table, options: &ReadOptions) -> Result<(Log, Report), DatasetError> {
    log_of(name, table, options, Report { findings: table.findings.clone() })
}

/// As [`read_runs`], from columns that are already in memory, named as in a file; errors and the runs have the name `name`.
///
/// # Errors
/// As [`read_runs`].
pub fn runs_from_table(name: &Path, table: &Table, options: &ReadOptions) -> Result<(Vec<Log>, Report), DatasetError> {
    runs_of(name, table, options, Report { findings: table.findings.clone() })
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
fn log_of(path: &Path, table: &Table, options: &ReadOptions, mut report: Report) -> Result<(Log, Report), DatasetError> {
    let (axes, recorded) = recorded(path, table, options, &mut report)?;
    let log = log(path, run_name(path), &axes, recorded, &mut report)?;
    Ok((log, report))
}

/// The runs of a table, and `report` with what was found.
///
/// # Errors
/// As [`read_runs`].
pub(crate) fn runs_of(
    path: &Path,
    table: &Table,
    options: &ReadOptions,
    mut report: Report,
) -> Result<(Vec<Log>, Report), DatasetError> {
    let (axes, recorded) = recorded(path, table, options, &mut report)?;
    let Parts { parts, findings } = Parts::of(path, recorded)?;
    let is_cut = !findings.is_empty();
    report.findings.extend(findings);
    let mut logs: Vec<Log> = Vec::with_capacity(parts.len());
    for (number, part) in parts {
        let name = if is_cut { format!("{} part {number}", run_name(path)) } else { run_name(path) };
        let mut own = Report::default();
        let log = log(path, name, &axes, part, &mut own)?;
        report.findings.extend(own.findings.into_iter().map(|finding| if is_cut { noted(finding, &log.name) } else { finding }));
        logs.push(log);
    }
    if is_cut {
        let (same, findings) = of_one_period(logs)?;
        report.findings.extend(findings);
        return Ok((same, report));
    }
    Ok((logs, report))
}

/// The columns of a log as they were recorded, commanded ones first, with their axes.
fn recorded(
    path: &Path,
    table: &Table,
    options: &ReadOptions,
    report: &mut Report,
) -> Result<(Vec<Axis>, Recorded), DatasetError> {
    let mut map = map_of(path, table, options)?;
    report.findings.extend(map.findings());
    let table = complete(path, table, &mut map, options, report)?;
    let axes: Vec<Axis> = map.axes.iter().map(|columns| columns.axis.clone()).collect();
    let references = map.axes.iter().map(|axis| axis.reference);
    let sources: Vec<Source> = references.chain(map.axes.iter().map(|axis| axis.actual)).collect();
    let errors: Vec<Option<Side>> = map.axes.iter().map(|axis| axis.error_for).collect();
    let (kept, columns) = usable_columns(path, &table, &axes, (&sources, &errors), report)?;
    let unstated = kept.iter().zip(&columns).filter_map(|(axis, command)| map.axes[*axis].unstated_angle(travel(command)));
    report.findings.extend(unstated);
    let axes: Vec<Axis> = kept.iter().map(|axis| axes[*axis].clone()).collect();
    let named: Vec<(Axis, Source)> = axes.iter().cloned().zip(kept.iter().map(|axis| sources[*axis])).collect();
    let (recorded, findings) = Recorded::new(path, &table, map.time, (&named, columns), options.period_s)?;
    report.findings.extend(findings);
    Ok((axes, recorded))
}

/// Distance between the lowest and the highest position.
fn travel(positions: &[f64]) -> f64 {
    let (low, high) = positions.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(*at), high.max(*at)));
    (high - low).max(0.0)
}

/// The table with all columns at the instants of the command, without rows in which a position is missing or a spike.
fn complete<'a>(
    path: &Path,
    table: &'a Table,
    map: &mut ColumnMap,
    options: &ReadOptions,
    report: &mut Report,
) -> Result<Cow<'a, Table>, DatasetError> {
    let (table, findings) = spikes::without(table, map);
    report.findings.extend(findings);
    let (mut table, finding) = turns::in_table(table, map);
    report.findings.extend(finding);
    if let Some((split, clocks, finding)) = missing::apart(&table, map) {
        (table, map.clocks) = (Cow::Owned(split), clocks);
        report.push(finding);
    }
    if !map.clocks.is_empty() {
        let (joined, findings) = on_one_clock(path, &table, map.time, &map.clocks)?;
        report.findings.extend(findings);
        table = Cow::Owned(joined.into_owned());
    }
    if let Some((kept, time, finding)) = missing::without_rows(path, &table, map, options)? {
        (table, map.time) = (Cow::Owned(kept), Some(time));
        report.push(finding);
    }
    Ok(table)
}

/// Indices of the axes that can be used, and their columns: commands, then actual positions. The others are findings.
fn usable_columns(
    path: &Path,
    table: &Table,
    axes: &[Axis],
    (sources, errors): (&[Source], &[Option<Side>]),
    report: &mut Report,
) -> Result<(Vec<usize>, Vec<Vec<f64>>), DatasetError> {
    let columns = sources.iter().map(|source| table.scaled(path, source.column, source.scale));
    let mut columns = columns.collect::<Result<Vec<_>, _>>()?;
    tracking_errors::replace(&mut columns, errors, 0);
    let mut signs = tracking_errors::Signs::new(errors);
    signs.note(&columns);
    report.findings.extend(signs.finding(axes));
    let mut usable = Usable::new(path, table, axes, sources);
    usable.note(&columns, &table.lines);
    let (kept, findings) = usable.finish()?;
    report.findings.extend(findings);
    let slots = kept.iter().copied().chain(kept.iter().map(|axis| axis + axes.len()));
    let columns = slots.map(|slot| std::mem::take(&mut columns[slot])).collect();
    Ok((kept, columns))
}

/// A run at a uniform rate.
fn log(path: &Path, name: String, axes: &[Axis], recorded: Recorded, report: &mut Report) -> Result<Log, DatasetError> {
    let uniform = recorded.uniform(path)?;
    report.findings.extend(uniform.findings);
    let mut columns = uniform.columns;
    let actual = columns.split_off(axes.len());
    let of = |columns| Trajectory::new(uniform.period_s, axes.to_vec(), columns);
    Ok(Log::new(name, of(columns)?, of(actual)?)?.starting_at(uniform.start_s))
}

pub(crate) fn run_name(path: &Path) -> String {
    path.file_stem().map_or_else(|| "log".to_owned(), |stem| stem.to_string_lossy().into_owned())
}
