//! Joins recordings that were written to several files.

use crate::{Check, Finding, Log, Severity};

/// Largest deviation of the time between the last sample of a file and the first of the next, as a
/// share of a period.
const STAMP_SHARE: f64 = 0.25;
/// Largest deviation of the first step over the boundary from the last one before it, as a share of
/// the largest step of the run.
const STEP_SHARE: f64 = 0.2;

/// Joins files that continue each other, by their time stamps and commands, to one run each; the
/// others are unchanged.
///
/// The parts of a cut run lack their command history: their first samples cannot be used, and the
/// initial side of the backlash is unknown.
#[must_use]
pub fn joined(logs: Vec<Log>) -> (Vec<Log>, Vec<Finding>) {
    let mut out: Vec<Log> = Vec::with_capacity(logs.len());
    let mut parts: Vec<Vec<String>> = Vec::new();
    let mut logs: Vec<Option<Log>> = logs.into_iter().map(Some).collect();
    while let Some(first) = logs.iter().position(Option::is_some) {
        let Some(mut whole) = logs[first].take() else { break };
        let mut names = vec![whole.name.clone()];
        // First the continuation, then the part before.
        while let Some((index, after)) = neighbour(&logs, &whole) {
            let Some(other) = logs[index].take() else { break };
            let name = other.name.clone();
            let both = if after { append(&whole, &other) } else { append(&other, &whole) };
            let Some(both) = both else { break };
            whole = both;
            names.insert(if after { names.len() } else { 0 }, name);
        }
        out.push(whole);
        parts.push(names);
    }
    let findings = parts.iter().filter(|names| names.len() > 1).map(|names| {
        let text = format!("{} go on from one another in time and command: they are one run", names.join(", "));
        Finding::new(Severity::Note, Check::Runs, text)
    });
    let findings = findings.collect();
    (out, findings)
}

/// A log that continues `whole` (`true`) or ends where it begins.
fn neighbour(logs: &[Option<Log>], whole: &Log) -> Option<(usize, bool)> {
    logs.iter().enumerate().find_map(|(index, other)| {
        let other = other.as_ref()?;
        if follows(whole, other) {
            return Some((index, true));
        }
        follows(other, whole).then_some((index, false))
    })
}

/// Whether `next` continues `log`.
fn follows(log: &Log, next: &Log) -> bool {
    let period_s = log.period_s();
    let alike = log.axes() == next.axes() && (next.period_s() / period_s - 1.0).abs() < 1e-6 && log.len() > 2 && next.len() > 2;
    let due_s = log.start_s + log.len() as f64 * period_s;
    alike
        && (next.start_s - due_s).abs() <= STAMP_SHARE * period_s
        && log.reference.columns().iter().zip(next.reference.columns()).all(|(before, after)| {
            let largest = before.windows(2).chain(after.windows(2)).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
            let n = before.len();
            let bend = (after[0] - before[n - 1]) - (before[n - 1] - before[n - 2]);
            bend.abs() <= STEP_SHARE * largest + 1e-9
        })
}

fn append(log: &Log, next: &Log) -> Option<Log> {
    let both = |a: &motion::Trajectory, b: &motion::Trajectory| {
        a.with_columns(a.columns().iter().zip(b.columns()).map(|(a, b)| [a.as_slice(), b.as_slice()].concat()).collect())
    };
    let (reference, actual) = (both(&log.reference, &next.reference).ok()?, both(&log.actual, &next.actual).ok()?);
    Some(Log::new(log.name.clone(), reference, actual).ok()?.starting_at(log.start_s))
}

#[cfg(test)]
mod tests {
    use motion::{Axis, Trajectory};

    use super::*;

    fn log() -> Log {
        let column = |late: f64| (0..900).map(|k| 20.0 * (f64::from(k) * 0.01 - late).sin()).collect::<Vec<f64>>();
        let of = |late| Trajectory::new(0.002, vec![Axis::named("x")], vec![column(late)]).unwrap();
        Log::new("run", of(0.0), of(0.03)).unwrap().starting_at(12.0)
    }

    #[test]
    fn parts_of_a_run_are_joined_in_any_order() {
        let whole = log();
        let part = |from: usize, to: usize| whole.part("run", from, to).unwrap();
        let other = log().starting_at(500.0);
        let (found, findings) = joined(vec![part(300, 700), other.clone(), part(700, 900), part(0, 300)]);
        assert_eq!(found, [whole, other]);
        assert_eq!(findings.len(), 1);
    }

    #[test]
    fn runs_that_only_look_alike_stay_apart() {
        let whole = log();
        // A gap in time, a jump of the command at the boundary, and missing time stamps.
        let late = whole.part("late", 300, 900).unwrap().starting_at(12.7);
        let far = whole.part("far", 500, 900).unwrap().starting_at(12.6);
        let unstamped = whole.part("none", 300, 900).unwrap().starting_at(0.0);
        let first = whole.part("run", 0, 300).unwrap();
        for next in [late, far, unstamped] {
            assert_eq!(joined(vec![first.clone(), next]).0.len(), 2);
        }
    }
}
