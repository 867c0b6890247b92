//! Columns as recorded, and how they become uniform.

use std::path::Path;

use motion::Axis;

use crate::columns::implied_period_s;
use crate::cycles::{counts, seconds};
use crate::even_rows::even_times;
use crate::quality::{SLOWEST_HZ, significant_digits, step_of};
use crate::resample::resample;
use crate::timing::{Gap, gaps, settle};
use crate::wraps;
use crate::{Check, DatasetError, Finding, Severity, Source, Table};

/// Largest magnitude of a position, mm or rad: a kilometre, or 160,000 revolutions of an endless
/// axis.
pub(crate) const FARTHEST: f64 = 1e6;
/// Largest magnitude of a time stamp, s: more than three thousand years; a clock may count from
/// 1601.
pub(crate) const LATEST_S: f64 = 1e11;
/// A day, s.
const DAY_S: f64 = 86_400.0;
/// Shortest and longest sampling period, s: 1 MHz, and slower than any log that shows a motion.
const SHORTEST_S: f64 = 1e-6;
const LONGEST_S: f64 = 10.0;

/// Columns as recorded, in s, mm and rad.
pub(crate) struct Recorded {
    columns: Vec<Vec<f64>>,
    clock: Clock,
}

enum Clock {
    /// Rows that are this far apart, s.
    Even(f64),
    /// Time stamps, s, and the lines of the rows.
    Stamps { times: Vec<f64>, lines: Vec<usize> },
}

/// Columns at a uniform rate.
pub(crate) struct Uniform {
    pub period_s: f64,
    /// Time of the first row, s; zero if unknown.
    pub start_s: f64,
    pub columns: Vec<Vec<f64>>,
    pub findings: Vec<Finding>,
}

impl Recorded {
    /// The columns of `sources`, whose rows are those of the table, with its time stamps or its period, or else `period_s`; findings.
    /// Without stamps a counter of cycles shows lost rows.
    ///
    /// # Errors
    /// When a time stamp is missing, or there is neither stamp nor period.
    pub fn new(
        path: &Path,
        table: &Table,
        time: Option<Source>,
        (sources, mut columns): (&[(Axis, Source)], Vec<Vec<f64>>),
        period_s: Option<f64>,
    ) -> Result<(Self, Vec<Finding>), DatasetError> {
        let Some(time) = time else {
            let period_s = stated_period_s(path, table, sources, period_s)?;
            let clock = match counts(table) {
                Some(counts) => Clock::Stamps { times: seconds(counts, period_s), lines: table.lines.clone() },
                None => Clock::Even(period_s),
            };
            return Ok((Self { columns, clock }, Vec::new()));
        };
        let mut times = table.within(path, time.column, time.scale, LATEST_S, "s")?;
        let mut lines = table.lines.clone();
        let mut findings = drop_repeated_rows(&mut times, &mut lines, &mut columns);
        findings.extend(wraps::go_on(&mut times));
        if let Some((even, finding)) = even_times(&times, &columns) {
            times = even;
            findings.push(finding);
        } else if let Some(message) = standing(&times) {
            let Some(period_s) = period_s else {
                let why = format!("{message}: the clock has too few digits; state the sampling period (--period)");
                return Err(DatasetError::format(path, why));
            };
            check_period(path, period_s)?;
            let (rows, ends) =
                (times.len() as f64 - 1.0, [times.first(), times.last()].map(|time| time.copied().unwrap_or_default()));
            let resolution =
                times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
            if (ends[1] - ends[0] - rows * period_s).abs() > 2.0 * resolution.min(ends[1] - ends[0]) {
                let why = format!(
                    "{message}: its time stamps span {:.3} s, and {} rows of the stated period {:.3} s; rows are lost, or the period is another",
                    ends[1] - ends[0],
                    times.len(),
                    rows * period_s
                );
                return Err(DatasetError::format(path, why));
            }
            findings.push(Finding::new(Severity::Warn, Check::Timing, format!("{message}: the stated period is used")));
            return Ok((Self { columns, clock: Clock::Even(period_s) }, findings));
        }
        findings.extend(period_s.and_then(|stated_s| other_period(&times, stated_s)));
        Ok((Self { columns, clock: Clock::Stamps { times, lines } }, findings))
    }

    /// The gaps of the time stamps, with the lines before them and the times at which they begin, s.
    pub fn gaps(&self) -> Vec<(Gap, usize, f64)> {
        let Clock::Stamps { times, lines } = &self.clock else { return Vec::new() };
        let placed = |gap: Gap| (gap, lines.get(gap.row).copied().unwrap_or(gap.row + 1), times[gap.row]);
        gaps(times).into_iter().map(placed).collect()
    }

    /// The rows from each of the gaps to the next one.
    pub fn cut(self, gaps: &[(Gap, usize, f64)]) -> Vec<Self> {
        let Clock::Stamps { times, lines } = &self.clock else { return vec![self] };
        let starts = std::iter::once(0).chain(gaps.iter().map(|(gap, ..)| gap.row + 1));
        let ends = gaps.iter().map(|(gap, ..)| gap.row + 1).chain([times.len()]);
        let part = |(from, to): (usize, usize)| Self {
            columns: self.columns.iter().map(|column| column[from..to].to_vec()).collect(),
            clock: Clock::Stamps { times: times[from..to].to_vec(), lines: lines[from..to].to_vec() },
        };
        starts.zip(ends).map(part).collect()
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// Time of the first row, s; zero if unknown.
    pub fn start_s(&self) -> f64 {
        match &self.clock {
            Clock::Even(_) => 0.0,
            Clock::Stamps { times, .. } => times.first().copied().unwrap_or_default(),
        }
    }

    /// Time from the first row to the last one, s.
    pub fn duration_s(&self) -> f64 {
        match &self.clock {
            Clock::Even(period_s) => period_s * self.len().saturating_sub(1) as f64,
            Clock::Stamps { times, .. } => times.last().zip(times.first()).map_or(0.0, |(last, first)| last - first),
        }
    }

    /// The columns at a uniform rate.
    ///
    /// # Errors
    /// When there are too few rows, the time goes back, or the period is implausible.
    pub fn uniform(self, path: &Path) -> Result<Uniform, DatasetError> {
        let (start_s, mut columns) = (self.start_s(), self.columns);
        match self.clock {
            Clock::Even(period_s) => Ok(Uniform { period_s, start_s, columns, findings: Vec::new() }),
            Clock::Stamps { mut times, lines } => {
                // A part of a log between gaps.
                let even = even_times(&times, &columns).map(|(even, finding)| {
                    times = even;
                    finding
                });
                let mut timing = settle(path, &times, &lines)?;
                timing.findings.extend(even);
                check_period(path, timing.period_s)?;
                if timing.resample {
                    columns = columns.iter().map(|column| resample(&times, column, timing.period_s)).collect();
                }
                Ok(Uniform { period_s: timing.period_s, start_s, columns, findings: timing.findings })
            }
        }
    }
}

/// The columns of `sources`.
///
/// # Errors
/// When a value is missing or out of range.
pub(crate) fn columns_of(path: &Path, table: &Table, sources: &[(Axis, Source)]) -> Result<Vec<Vec<f64>>, DatasetError> {
    let column = |(axis, source): &(Axis, Source)| table.within(path, source.column, source.scale, FARTHEST, axis.kind.unit());
    sources.iter().map(column).collect()
}

/// Refuses an implausible sampling period.
pub(crate) fn check_period(path: &Path, period_s: f64) -> Result<(), DatasetError> {
    if (SHORTEST_S..=LONGEST_S).contains(&period_s) {
        return Ok(());
    }
    let are_days = (SHORTEST_S..=LONGEST_S).contains(&(period_s * DAY_S));
    let days = if are_days { "; times of a spreadsheet are days: map them with `t=NAME*86400`" } else { "" };
    let why = format!(
        "the sampling period is {period_s:.3e} s; logs have one from {SHORTEST_S:e} to {LONGEST_S} s: mend the time column, its unit or the stated period{days}"
    );
    Err(DatasetError::format(path, why))
}

/// Least relative difference between the median period of the time stamps and the stated one that is reported.
const OTHER_SHARE: f64 = 0.01;

/// What to say where the time stamps have another period than the stated one.
fn other_period(times: &[f64], stated_s: f64) -> Option<Finding> {
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = steps.len() / 2;
    let (_, period_s, _) = (!steps.is_empty()).then(|| steps.select_nth_unstable_by(middle, f64::total_cmp))?;
    let differs = (stated_s / *period_s - 1.0).abs() > OTHER_SHARE;
    let message = format!(
        "the time stamps are {:.3} ms apart; the stated period of {:.3} ms is not used. Where the stamps are wrong, leave their column out by a mapping",
        *period_s * 1e3,
        stated_s * 1e3
    );
    differs.then(|| Finding::new(Severity::Warn, Check::Timing, message))
}

/// What is wrong with time stamps nearly all of which are those of the row before.
fn standing(times: &[f64]) -> Option<String> {
    let standing = times.windows(2).filter(|pair| pair[0] == pair[1]).count();
    let rows = times.len();
    (20 * standing > 19 * rows).then(|| format!("{standing} of {rows} time stamps are those of the row before"))
}

/// Other rows with the stamp of the row before them, as a share of the repeated ones, from which on the clock is coarser than the sampling and
/// rows at rest are no repetitions.
const COARSE_SHARE: f64 = 0.1;

/// A duplicated row (same stamp, same values) contains no information.
fn drop_repeated_rows(times: &mut Vec<f64>, lines: &mut Vec<usize>, columns: &mut [Vec<f64>]) -> Vec<Finding> {
    let stands = |k: usize| k > 0 && times[k] == times[k - 1];
    let keep: Vec<bool> =
        (0..times.len()).map(|k| !stands(k) || columns.iter().any(|column| column[k] != column[k - 1])).collect();
    let Some(first) = keep.iter().position(|keep| !keep) else {
        return Vec::new();
    };
    let repeated = keep.iter().filter(|keep| !**keep).count();
    let moved = (0..times.len()).filter(|k| stands(*k)).count() - repeated;
    if moved as f64 >= COARSE_SHARE * repeated as f64 {
        return Vec::new();
    }
    let message = format!(
        "{} rows repeat the row before them, stamp and all (first in line {}); they were left out",
        repeated, lines[first]
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

/// The sampling period of a table without time stamps, s: its own, or else `period_s`.
///
/// # Errors
/// When there is none, or it is implausible.
pub(crate) fn stated_period_s(
    path: &Path,
    table: &Table,
    sources: &[(Axis, Source)],
    period_s: Option<f64>,
) -> Result<f64, DatasetError> {
    let unknown = || DatasetError::NoTime { path: path.to_owned(), hints: hints(path, table, sources) };
    let period_s = table.period_s.or(period_s).ok_or_else(unknown)?;
    check_period(path, period_s)?;
    Ok(period_s)
}

/// Estimates from a file without time stamps: its probable rate and its digits.
fn hints(path: &Path, table: &Table, sources: &[(Axis, Source)]) -> String {
    let mut hints = String::from("; state the sampling period (--period) if it is known");
    if let Some(period_s) = implied_period_s(table) {
        hints += &format!(". Its velocity columns suggest about {:.2} s ({:.0} Hz)", period_s, 1.0 / period_s);
        if 1.0 / period_s < SLOWEST_HZ {
            hints += &format!(", too slow for training, which needs at least {} Hz", SLOWEST_HZ);
        }
    }
    let coarsest = sources
        .iter()
        .filter_map(|(axis, source)| {
            let column = table.finite(path, source.column, source.scale).ok()?;
            let step = step_of(&column)?;
            Some((axis, step, significant_digits(&column, step)))
        })
        .min_by_key(|(_, _, digits)| *digits);
    if let Some((axis, step, digits)) = coarsest
        && digits <= 4
    {
        hints += &format!("; positions of `{axis}` have {digits} significant digits (steps of {step} {})", axis.kind.unit());
    }
    hints
}
