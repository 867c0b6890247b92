//! Steps that no motion explains: counter resets, lost rows, spikes, and jumps of the command.

use super::purpose::Purpose;
use super::signals::{Signals, quantile, steps};
use crate::{Check, Finding, Report, Severity};

/// A step exceeds its two neighbours, and all but 1 % of its kind, by this factor …
const ISOLATED: f64 = 4.0;
/// … and is at least this large: 5 µm or 0.05 mrad.
const SMALLEST: (f64, f64) = (5e-3, 5e-5);
/// Largest ratio of the bends that 1 and 10 % of the samples exceed; beyond it they are spikes themselves.
const MANY_SPIKES: f64 = 4.0;
/// Spikes of a run from which on it is not fit for training: 14 of 0.9 mm made a model of 0.125 µm one of 77 µm.
const MANY: usize = 5;
/// A command's speed may change in one sample by this share of its largest.
const SPEED_SHARE: f64 = 0.4;
/// Samples within which a jump of the command explains one of the tracking error, and size of a change of its steps, as a share of the error's,
/// from which on that does.
const NEAR: usize = 3;
const BENT_SHARE: f64 = 0.5;

/// Outliers of an axis's signals.
struct Jumps {
    /// Steps of the command, and those of them with a step of the actual position.
    alone: Vec<usize>,
    together: Vec<usize>,
    /// Changes of the command's speed.
    speed_changes: Vec<usize>,
    /// Steps of the tracking error that the command does not explain.
    resets: Vec<usize>,
    /// Single samples, and their distances from their neighbours.
    spikes: Vec<(usize, f64)>,
}

impl Jumps {
    /// Outliers of an axis, without rows that are known to be `lost`.
    fn find(axis: &Signals, lost: &[bool]) -> Self {
        let smallest = axis.of_kind(SMALLEST.0, SMALLEST.1);
        let lost_at = |k: usize| lost.get(k).copied().unwrap_or(false);
        let commanded = isolated(&axis.reference_steps, smallest);
        let moved = isolated(&axis.actual_steps, smallest);
        let error_steps = steps(&axis.error);
        let deviated = isolated(&error_steps, smallest);
        let bends = steps(&axis.reference_steps);
        let speed_changes = isolated(&bends, SPEED_SHARE * quantile(&axis.reference_steps, 0.999).max(smallest * 0.1));
        // After a jump of the command or of its speed the tracking error itself has a kink.
        let explained = |k: usize| {
            let near = |other: &usize| other.abs_diff(k) <= NEAR;
            commanded.iter().any(near) || speed_changes.iter().any(near)
        };
        // A control without a limit of jerk passes corners with a jump of speed, which the actual position follows with its lag.
        let bent = |k: usize| {
            let near = &bends[k.saturating_sub(NEAR).min(bends.len())..(k + NEAR).min(bends.len())];
            near.iter().any(|bend| bend.abs() >= BENT_SHARE * error_steps[k].abs())
        };
        let resets = deviated.iter().copied().filter(|&k| !explained(k) && !bent(k) && !lost_at(k) && !lost_at(k + 1)).collect();
        let spikes = spikes(&axis.error, smallest).into_iter().filter(|(k, _)| !explained(*k) && !lost_at(*k)).collect();
        let (together, alone) = commanded.iter().partition(|k| moved.contains(k));
        Self { alone, together, speed_changes, resets, spikes }
    }
}

pub(super) fn check(axis: &Signals, lost: &[bool], purpose: Purpose, report: &mut Report) {
    let mut push = |severity, check, found: Vec<(usize, f64)>, what: &str| {
        let Some(&(first, _)) = found.first() else {
            return;
        };
        let largest = found.iter().map(|(_, size)| size.abs()).fold(0.0, f64::max);
        let times = if found.len() == 1 { "once".to_owned() } else { format!("{} times", found.len()) };
        let column = if check == Check::Command { axis.reference_name() } else { axis.actual_name() };
        report.push(
            Finding::new(severity, check, format!("{times}, at most {largest:.4} {}: {what}", axis.unit()))
                .in_column(column)
                .at_sample(first, axis.period_s),
        );
    };
    // A step from sample k to k + 1 is reported at k + 1.
    let arrive = |steps: &[f64], found: Vec<usize>| found.into_iter().map(|k| (k + 1, steps[k])).collect();
    let jumps = Jumps::find(axis, lost);
    push(
        purpose.grave(),
        Check::Jumps,
        arrive(&axis.reference_steps, jumps.together),
        "command and actual position jump together: rows are lost there; cut the file at these rows into separate runs",
    );
    push(
        Severity::Warn,
        Check::Command,
        arrive(&axis.reference_steps, jumps.alone),
        "the command jumps from one sample to the next: infinite speed, which no axis follows; leave these runs out or smooth the program",
    );
    push(
        purpose.grave(),
        Check::Jumps,
        arrive(&axis.actual_steps, jumps.resets),
        "the actual position steps while the command goes on smoothly: a counter was reset or counts were lost; cut the file at these \
         rows into separate runs",
    );
    push(
        if jumps.spikes.len() < MANY { Severity::Warn } else { purpose.grave() },
        Check::Jumps,
        jumps.spikes,
        "single samples of the actual position stand out of their neighbours: transmission faults; leave these fields empty, and they are \
         interpolated",
    );
    let speeds: Vec<f64> = steps(&axis.reference_steps).iter().map(|step| step / axis.period_s).collect();
    push(
        Severity::Warn,
        Check::Command,
        arrive(&speeds, jumps.speed_changes),
        "the command's speed (per s) jumps within one sample: infinite acceleration; what follows is not learned well",
    );
}

/// Indices of steps that exceed their neighbours and nearly all steps.
fn isolated(steps: &[f64], smallest: f64) -> Vec<usize> {
    let usual = (ISOLATED * quantile(steps, 0.99)).max(smallest);
    let size = |k: Option<usize>| k.and_then(|k| steps.get(k)).map_or(0.0, |step| step.abs());
    (0..steps.len())
        .filter(|&k| {
            let step = steps[k].abs();
            step > usual && step > ISOLATED * size(k.checked_sub(1)).max(size(Some(k + 1)))
        })
        .collect()
}

/// Samples off the line between their neighbours, which lie close together, and their distances.
fn spikes(values: &[f64], smallest: f64) -> Vec<(usize, f64)> {
    let bends: Vec<f64> = values.windows(3).map(|three| three[1] - 0.5 * (three[0] + three[2])).collect();
    // Each spike has three bends: many of them are no measure of what is usual.
    let usual = 2.0 * ISOLATED * quantile(&bends, 0.99).min(MANY_SPIKES * quantile(&bends, 0.9));
    let usual = usual.max(smallest);
    let apart = |k: usize| (values[k + 2] - values[k]).abs();
    (0..bends.len())
        .filter(|&k| bends[k].abs() > usual && bends[k].abs() > ISOLATED * apart(k))
        .map(|k| (k + 1, bends[k]))
        .collect()
}
