//! Steps that no motion makes: counter resets, lost rows, spikes, and commands that jump.

use super::Purpose;
use super::signals::{Signals, quantile, steps};
use crate::{Check, Finding, Report, Severity};

/// A step is one when it exceeds its two neighbours, and all but 1 % of its kind, by this factor …
const ISOLATED: f64 = 4.0;
/// … and is at least this large: 5 µm or 0.05 mrad.
const SMALLEST: (f64, f64) = (5e-3, 5e-5);
/// A command's speed may change in one sample by this share of its largest.
const SPEED_SHARE: f64 = 0.4;

pub(super) fn check(axis: &Signals, lost: &[bool], purpose: Purpose, report: &mut Report) {
    let smallest = axis.of_kind(SMALLEST.0, SMALLEST.1);
    let lost_at = |k: usize| lost.get(k).copied().unwrap_or(false);
    let commanded = isolated(&axis.reference_steps, smallest);
    let moved = isolated(&axis.actual_steps, smallest);
    let deviated = isolated(&steps(&axis.error), smallest);
    let speed_changes =
        isolated(&steps(&axis.reference_steps), SPEED_SHARE * quantile(&axis.reference_steps, 0.999).max(smallest * 0.1));

    let both: Vec<usize> = commanded.iter().copied().filter(|k| moved.contains(k)).collect();
    push(
        axis,
        &both,
        &axis.reference_steps,
        purpose.grave(),
        Check::Jumps,
        report,
        "command and actual position jump together: rows are lost there; cut the file at these rows into separate runs",
    );
    let command_only: Vec<usize> = commanded.iter().copied().filter(|k| !moved.contains(k)).collect();
    push(
        axis,
        &command_only,
        &axis.reference_steps,
        Severity::Warn,
        Check::Command,
        report,
        "the command jumps from one sample to the next: infinite speed, which no axis follows; leave these runs out or smooth the program",
    );
    // After a jump of the command's speed the tracking error has a kink of its own.
    let explained = |k: usize| {
        let near = |other: &usize| other.abs_diff(k) <= 3;
        commanded.iter().any(near) || speed_changes.iter().any(near)
    };
    let resets: Vec<usize> = deviated.iter().copied().filter(|&k| !explained(k) && !lost_at(k) && !lost_at(k + 1)).collect();
    push(
        axis,
        &resets,
        &axis.actual_steps,
        purpose.grave(),
        Check::Jumps,
        report,
        "the actual position steps while the command goes on smoothly: a counter was reset or counts were lost; cut the file at these rows into separate runs",
    );
    let spikes: Vec<usize> = spikes(&axis.error, smallest).into_iter().filter(|&k| !explained(k) && !lost_at(k)).collect();
    push(
        axis,
        &spikes,
        &axis.error,
        Severity::Warn,
        Check::Jumps,
        report,
        "single samples of the actual position stand out of their neighbours: transmission faults; mend or leave out these rows",
    );
    if !speed_changes.is_empty() {
        let sizes = steps(&axis.reference_steps);
        let speeds: Vec<f64> = sizes.iter().map(|step| step / axis.period_s).collect();
        push(
            axis,
            &speed_changes,
            &speeds,
            Severity::Warn,
            Check::Command,
            report,
            "the command's speed (per s) jumps within one sample: infinite acceleration; what follows is not learned well",
        );
    }
}

fn push(axis: &Signals, found: &[usize], sizes: &[f64], severity: Severity, check: Check, report: &mut Report, what: &str) {
    let Some(&first) = found.first() else {
        return;
    };
    let largest = found.iter().map(|&k| sizes[k].abs()).fold(0.0, f64::max);
    let column = if check == Check::Command { axis.reference_name() } else { axis.actual_name() };
    let places = if found.len() == 1 { "once" } else { "times" };
    let count = if found.len() == 1 { String::new() } else { format!("{} ", found.len()) };
    report.push(
        Finding::new(severity, check, format!("{count}{places}, at most {largest:.4} {}: {what}", axis.unit()))
            .in_column(column)
            .at_sample(first + 1, axis.period_s),
    );
}

/// Indices of steps that stand out of their neighbours and of all steps.
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

/// Samples that lie off the line between their neighbours, which lie close together.
fn spikes(values: &[f64], smallest: f64) -> Vec<usize> {
    let bends: Vec<f64> = values.windows(3).map(|three| three[1] - 0.5 * (three[0] + three[2])).collect();
    let usual = (2.0 * ISOLATED * quantile(&bends, 0.99)).max(smallest);
    (0..bends.len())
        .filter(|&k| {
            let apart = (values[k + 2] - values[k]).abs();
            bends[k].abs() > usual && bends[k].abs() > ISOLATED * apart
        })
        .map(|k| k + 1)
        .collect()
}
