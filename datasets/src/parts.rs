//! Cuts a recording at the gaps of its time stamps.

use std::path::Path;

use motion::Trajectory;

use crate::quality::{FEWEST_SAMPLES, SHORT_S};
use crate::recorded::Recorded;
use crate::{Check, DatasetError, Finding, Log, Severity};

/// Gaps that are reported one by one.
const LISTED: usize = 20;

/// The parts of a recording between its gaps.
pub(crate) struct Parts {
    /// Parts that are long enough, with their numbers from 1.
    pub parts: Vec<(usize, Recorded)>,
    /// The gaps, and the parts that were left out; empty for a recording without gaps.
    pub findings: Vec<Finding>,
}

impl Parts {
    /// The parts of a recording; a recording without gaps is one, however short.
    ///
    /// # Errors
    /// When there are gaps, and no part is long enough.
    pub fn of(path: &Path, recorded: Recorded) -> Result<Self, DatasetError> {
        let gaps = recorded.gaps();
        if gaps.is_empty() {
            return Ok(Self { parts: vec![(1, recorded)], findings: Vec::new() });
        }
        let start_s = recorded.start_s();
        let mut findings: Vec<Finding> = Vec::new();
        for (gap, line, time_s) in gaps.iter().take(LISTED) {
            let mut finding = note(format!(
                "the time steps by {:.6} s after line {line}: {:.0} rows are missing; the log is cut there into two runs",
                gap.step_s, gap.lost
            ));
            finding.place.time_s = Some(time_s - start_s);
            findings.push(finding);
        }
        if gaps.len() > LISTED {
            findings.push(note(format!("{} more gaps; the log is cut at each of them", gaps.len() - LISTED)));
        }
        let parts = recorded.cut(&gaps).into_iter().enumerate().map(|(index, part)| (index + 1, part));
        let is_long = |part: &Recorded| part.len() >= FEWEST_SAMPLES && part.duration_s() >= SHORT_S;
        let (parts, short): (Vec<_>, Vec<_>) = parts.partition(|(_, part)| is_long(part));
        if parts.is_empty() {
            let longest_s = short.iter().map(|(_, part)| part.duration_s()).fold(0.0, f64::max);
            let why = format!(
                "the time stamps have {} gaps, the first after line {}, and no run between them lasts {SHORT_S} s (the longest {longest_s:.3} s); \
                 log without loss",
                gaps.len(),
                gaps[0].1
            );
            return Err(DatasetError::format(path, why));
        }
        if !short.is_empty() {
            let listed: Vec<String> = short
                .iter()
                .take(LISTED)
                .map(|(number, part)| format!("{number} ({} rows, {:.3} s)", part.len(), part.duration_s()))
                .collect();
            let more = if short.len() > LISTED { format!(" and {} more", short.len() - LISTED) } else { String::new() };
            findings.push(note(format!("too short to train on and left out: part {}{more}", listed.join(", "))));
        }
        Ok(Self { parts, findings })
    }
}

/// Stamps of a run and the grid of another period may be this far apart at its end, periods.
const SAME_GRID: f64 = 0.2;

/// The parts of one recording at one period, that of the longest: over short ones the period of rounded stamps is less certain. Parts whose
/// samples are elsewhere at that period are interpolated, with a finding.
///
/// # Errors
/// When a part has too few samples to be interpolated.
pub(crate) fn of_one_period(logs: Vec<Log>) -> Result<(Vec<Log>, Vec<Finding>), DatasetError> {
    let period_s = logs.iter().max_by_key(|log| log.len()).map_or(0.0, Log::period_s);
    let mut findings = Vec::new();
    let one = |log: Log| {
        if (log.period_s() / period_s - 1.0).abs() * log.len() as f64 <= SAME_GRID {
            let of = |columns: &Trajectory| Trajectory::new(period_s, columns.axes().to_vec(), columns.columns().to_vec());
            return Ok(Log::new(log.name.clone(), of(&log.reference)?, of(&log.actual)?)?.starting_at(log.start_s));
        }
        let (log, finding) = log.resampled(period_s)?;
        findings.extend(finding.map(|finding| noted(finding, &log.name)));
        Ok(log)
    };
    let logs = logs.into_iter().map(one).collect::<Result<_, DatasetError>>()?;
    Ok((logs, findings))
}

fn note(message: String) -> Finding {
    Finding::new(Severity::Note, Check::Timing, message)
}

/// A finding about one of several runs.
pub(crate) fn noted(mut finding: Finding, run: &str) -> Finding {
    finding.place.run = Some(run.to_owned());
    finding
}
