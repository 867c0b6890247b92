//! Columns with clocks of their own, at the instants of the command.

use std::borrow::Cow;
use std::path::Path;

use crate::columns::Clock;
use crate::recorded::LATEST_S;
use crate::timing::gaps;
use crate::{Check, DatasetError, Finding, Severity, Source, Table};

/// Period of a clock in periods of the command's above which motion between its samples is lost.
const SLOW: f64 = 1.5;
/// Distance of a sample from the next one, as a multiple of that between the two beside an instant, beyond which it lies behind a gap.
const NEAR: f64 = 4.0;

/// The table with all columns at the time stamps `time` of the command, and findings; the table itself where no column has other stamps.
///
/// A column with other stamps is interpolated between the two samples beside an instant, by a cubic. The nearest sample would be up to half a
/// period from it, 50 µm at 100 mm/s and 1 ms; a line between two samples is off by a·T²/8, 2 µm at 1 m/s² and 4 ms. Instants before the
/// first sample, after the last and in gaps are left out.
///
/// # Errors
/// When time stamps are missing or go back, or have no instant in common.
pub(crate) fn on_one_clock<'a>(
    path: &Path,
    table: &'a Table,
    time: Option<Source>,
    clocks: &[Clock],
) -> Result<(Cow<'a, Table>, Vec<Finding>), DatasetError> {
    let Some(time) = time.filter(|_| !clocks.is_empty()) else { return Ok((Cow::Borrowed(table), Vec::new())) };
    let own = stamps(path, table, time)?;
    let channels = clocks
        .iter()
        .map(|clock| Ok((clock, Channel::new(path, table, clock.time)?)))
        .collect::<Result<Vec<_>, DatasetError>>()?;
    let rows: Vec<usize> = (0..own.len()).filter(|row| channels.iter().all(|(_, channel)| channel.covers(own[*row]))).collect();
    if rows.is_empty() {
        return Err(apart(path, &own, &channels));
    }
    let mut joined = Table { names: table.names.clone(), period_s: table.period_s, ..Table::default() };
    joined.lines = rows.iter().map(|row| table.lines[*row]).collect();
    let at = |column: &Vec<f64>| rows.iter().map(|row| column.get(*row).copied().unwrap_or(f64::NAN)).collect();
    joined.columns = table.columns.iter().map(at).collect();
    let mut findings = Vec::new();
    for (clock, channel) in &channels {
        for signal in &clock.signals {
            joined.columns[*signal] = rows.iter().map(|row| channel.at(&table.columns[*signal], own[*row])).collect();
        }
        let instants: Vec<f64> = rows.iter().map(|row| own[*row]).collect();
        let names: Vec<&str> = clock.signals.iter().map(|signal| table.names[*signal].as_str()).collect();
        findings.extend(channel.findings(&instants, &names.join(", "), own.len() - rows.len()));
    }
    Ok((Cow::Owned(joined), findings))
}

/// Time stamps, s, without the empty fields at the end of a shorter channel.
fn stamps(path: &Path, table: &Table, time: Source) -> Result<Vec<f64>, DatasetError> {
    let mut times = table.scaled(path, time.column, time.scale)?;
    let length = times.iter().rposition(|time| !time.is_nan()).map_or(0, |last| last + 1);
    times.truncate(length);
    let Some(row) = times.iter().position(|time| !(-LATEST_S..=LATEST_S).contains(time)) else { return Ok(times) };
    let (path, line, column, value) = (path.to_owned(), table.lines[row], table.names[time.column].clone(), times[row]);
    Err(if value.is_finite() {
        DatasetError::Absurd { path, line, column, value, most: LATEST_S, unit: "s" }
    } else {
        DatasetError::Missing { path, line, column }
    })
}

/// Time stamps of a column, in order.
struct Channel {
    times: Vec<f64>,
    /// Stamps between which samples are lost.
    gaps: Vec<(f64, f64)>,
}

impl Channel {
    fn new(path: &Path, table: &Table, time: Source) -> Result<Self, DatasetError> {
        let times = stamps(path, table, time)?;
        if let Some(row) = times.windows(2).position(|pair| pair[1] < pair[0]) {
            return Err(DatasetError::TimeOrder {
                path: path.to_owned(),
                line: table.lines[row + 1],
                time_s: times[row + 1],
                before_s: times[row],
            });
        }
        let gaps = gaps(&times).into_iter().map(|gap| (times[gap.row], times[gap.row + 1])).collect();
        Ok(Self { times, gaps })
    }

    /// Whether there are samples on both sides of an instant.
    fn covers(&self, time: f64) -> bool {
        let within = self.times.first().zip(self.times.last()).is_some_and(|(first, last)| (*first..=*last).contains(&time));
        let next = self.gaps.partition_point(|(_, end)| *end <= time);
        within && self.gaps.get(next).is_none_or(|(start, _)| time <= *start)
    }

    /// Index of the last sample at or before an instant that is covered.
    fn before(&self, time: f64) -> usize {
        self.times.partition_point(|stamp| *stamp <= time).saturating_sub(1)
    }

    /// The value of a column at an instant that is covered: on the cubic between the two samples beside it, whose slopes are those of parabolas
    /// through their neighbours; on a line where a neighbour is missing, or beyond a gap.
    fn at(&self, column: &[f64], time: f64) -> f64 {
        let before = self.before(time);
        let value = |row: usize| column.get(row).copied().unwrap_or(f64::NAN);
        if self.times[before] == time || before + 1 == self.times.len() {
            return value(before);
        }
        let [from, to] = [before, before + 1].map(|row| (self.times[row], value(row)));
        let width = to.0 - from.0;
        let line = (to.1 - from.1) / width;
        // Slope at the sample `at` with the neighbour `row` on its other side.
        let slope = |at: (f64, f64), row: Option<usize>| {
            let next = row.filter(|row| *row < self.times.len()).map(|row| (self.times[row], value(row)));
            let near = next.filter(|(stamp, _)| (stamp - at.0).abs() <= NEAR * width && *stamp != at.0);
            near.filter(|(_, value)| value.is_finite()).map_or(line, |(stamp, value)| {
                let (other, distance) = ((value - at.1) / (stamp - at.0), (stamp - at.0).abs());
                (other * width + line * distance) / (width + distance)
            })
        };
        let (leaving, arriving) = (slope(from, before.checked_sub(1)), slope(to, Some(before + 2)));
        motion::hermite(from.1, to.1, leaving * width, arriving * width, (time - from.0) / width).0
    }

    /// Time of the nearest sample after an instant, s; negative before it.
    fn offset(&self, time: f64) -> f64 {
        let before = self.before(time);
        let after = (before + 1).min(self.times.len() - 1);
        let (early, late) = (self.times[before] - time, self.times[after] - time);
        if late.abs() < early.abs() { late } else { early }
    }

    /// How the columns `names` lie to the instants of the command.
    fn findings(&self, instants: &[f64], names: &str, left_out: usize) -> Vec<Finding> {
        let offsets = instants.iter().map(|time| 1e3 * self.offset(*time));
        let (low, high) = offsets.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), ms| (low.min(ms), high.max(ms)));
        let beyond = match left_out {
            0 => String::new(),
            rows => format!("; {rows} rows of the command without samples on both sides are left out"),
        };
        let message = format!(
            "{names}: joined to the clock of the command by cubic interpolation; the nearest samples are {low:.3} to {high:.3} ms from its \
             instants{beyond}"
        );
        let mut findings = vec![Finding::new(Severity::Note, Check::Timing, message)];
        let (own_s, command_s) = (mean_step_s(&self.times), mean_step_s(instants));
        if own_s > SLOW * command_s {
            let message = format!(
                "{names}: sampled every {:.3} ms, the command every {:.3} ms; motion between these samples is lost: log both at one rate",
                1e3 * own_s,
                1e3 * command_s
            );
            findings.push(Finding::new(Severity::Warn, Check::Timing, message));
        }
        findings
    }
}

fn mean_step_s(times: &[f64]) -> f64 {
    let span = times.last().zip(times.first()).map_or(0.0, |(last, first)| last - first);
    span / times.len().saturating_sub(1).max(1) as f64
}

fn apart(path: &Path, own: &[f64], channels: &[(&Clock, Channel)]) -> DatasetError {
    let span = |times: &[f64]| match (times.first(), times.last()) {
        (Some(first), Some(last)) => format!("{first} to {last} s"),
        _ => "no stamps".to_owned(),
    };
    let others: Vec<String> = channels.iter().map(|(_, channel)| span(&channel.times)).collect();
    let message = format!(
        "the clocks have no instant in common: the command {}, others {}; log with one clock, or take off the offset",
        span(own),
        others.join(", ")
    );
    DatasetError::format(path, message)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joined(time: &[f64], own: &[f64], values: &[f64]) -> Result<(Table, Vec<Finding>), DatasetError> {
        let rows = time.len().max(own.len());
        let padded = |column: &[f64]| (0..rows).map(|row| column.get(row).copied().unwrap_or(f64::NAN)).collect();
        let table = Table {
            names: ["t_cmd", "t_act", "x_act"].map(str::to_owned).to_vec(),
            columns: vec![padded(time), padded(own), padded(values)],
            lines: (2..rows + 2).collect(),
            ..Table::default()
        };
        let source = |column| Source { column, scale: 1.0 };
        let clocks = [Clock { time: source(1), signals: vec![2] }];
        on_one_clock(Path::new("log.csv"), &table, Some(source(0)), &clocks).map(|(table, found)| (table.into_owned(), found))
    }

    #[test]
    fn columns_are_read_between_their_samples() {
        let (table, found) = joined(&[0.0, 1.0, 2.0, 3.0, 4.0], &[0.5, 1.0, 2.5, 3.5], &[5.0, 10.0, 25.0, 35.0]).unwrap();
        assert_eq!((table.columns[2].clone(), table.lines), (vec![10.0, 20.0, 30.0], vec![3, 4, 5]));
        assert!(
            found[0].message.contains("-500.000 to 500.000 ms") && found[0].message.contains("2 rows"),
            "{}",
            found[0].message
        );
    }

    #[test]
    fn instants_in_a_gap_are_left_out() {
        let time: Vec<f64> = (0..100).map(f64::from).collect();
        let own: Vec<f64> = time.iter().map(|t| t + 0.25).filter(|t| !(30.0..60.0).contains(t)).collect();
        let (table, _) = joined(&time, &own, &own).unwrap();
        assert!(table.columns[2].iter().zip(&table.columns[0]).all(|(value, time)| (value - time).abs() < 1e-12));
        assert!(table.columns[0].iter().all(|time| !(30.0..60.0).contains(time)) && table.len() == 68, "{}", table.len());
    }

    #[test]
    fn clocks_without_a_common_instant_are_refused() {
        let error = joined(&[0.0, 1.0], &[50.0, 51.0], &[1.0, 2.0]).unwrap_err().to_string();
        assert!(error.contains("0 to 1 s") && error.contains("50 to 51 s"), "{error}");
        assert!(joined(&[0.0, 1.0], &[], &[]).is_err());
        assert!(matches!(joined(&[0.0, 1.0], &[0.0, 2.0, 1.0], &[0.0; 3]), Err(DatasetError::TimeOrder { line: 4, .. })));
        assert!(matches!(joined(&[0.0, 1.0], &[0.0, f64::NAN, 1.0], &[0.0; 3]), Err(DatasetError::Missing { line: 3, .. })));
    }
}
