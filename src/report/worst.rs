//! The worst lines of a program, or the worst places of a path without one, each with what the motion does there.

use std::collections::BTreeMap;

use pipeline::analysis::{Lagged, MotionAt, motion_at, worst_samples};
use serde::Serialize;

use super::run::Run;
use super::track::Track;

/// Lines or places that are shown of a run.
const SHOWN: usize = 15;
/// Least time between two places, s.
const APART_S: f64 = 0.05;
/// Share of the error from which on it lies along a direction.
const ALONG: f64 = 0.85;

/// A line or place.
#[derive(Debug, Serialize)]
pub struct Worst {
    /// Sample of its largest error.
    sample: usize,
    /// Program line, from 1; 0 without a program.
    pub line: usize,
    /// Where that is, mm.
    at_mm: [f64; 3],
    /// Largest error of every run on the line or near the place, µm; `None` where none counts.
    max_um: Vec<Option<f64>>,
    /// RMS of every run there, µm.
    rms_um: Vec<Option<f64>>,
    /// What the motion does there, and where the error points.
    why: String,
}

/// The worst lines or places by the largest error of each run. `contour` are the errors of the runs, µm, `lines` the line of each sample.
#[must_use]
pub fn worst(track: &Track<'_>, runs: &[Run], contour: &[Vec<f64>], lines: &[usize]) -> Vec<Vec<Worst>> {
    let apart = (APART_S / track.period_s).ceil() as usize;
    let groups = if track.has_lines() { by_line(lines) } else { BTreeMap::new() };
    let of_run = |(run, errors): (&Run, &Vec<f64>)| -> Vec<Worst> {
        let samples = if groups.is_empty() {
            worst_samples(errors, SHOWN, apart)
        } else {
            let mut largest: Vec<usize> = groups.values().filter_map(|samples| largest_of(errors, samples)).collect();
            largest.sort_by(|a, b| errors[*b].total_cmp(&errors[*a]));
            largest.truncate(SHOWN);
            largest
        };
        let entry = |k: usize| {
            let near: Vec<usize> = match groups.get(&lines[k]) {
                Some(samples) => samples.clone(),
                None => (k.saturating_sub(apart)..(k + apart + 1).min(errors.len())).collect(),
            };
            let tip = track.poses[k].tip;
            Worst {
                sample: k,
                line: lines[k],
                at_mm: [tip.x, tip.y, tip.z],
                max_um: contour.iter().map(|of| largest_of(of, &near).map(|k| of[k])).collect(),
                rms_um: contour.iter().map(|of| rms_of(of, &near)).collect(),
                why: why(track, run, k),
            }
        };
        samples.into_iter().map(entry).collect()
    };
    runs.iter().zip(contour).map(of_run).collect()
}

/// The samples of every line.
fn by_line(lines: &[usize]) -> BTreeMap<usize, Vec<usize>> {
    let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (k, line) in lines.iter().enumerate().filter(|(_, line)| **line > 0) {
        groups.entry(*line).or_default().push(k);
    }
    groups
}

fn largest_of(values: &[f64], samples: &[usize]) -> Option<usize> {
    let finite = samples.iter().copied().filter(|k| values[*k].is_finite());
    finite.max_by(|a, b| values[*a].total_cmp(&values[*b]).then(b.cmp(a)))
}

fn rms_of(values: &[f64], samples: &[usize]) -> Option<f64> {
    let finite: Vec<f64> = samples.iter().map(|k| values[*k]).filter(|value| value.is_finite()).collect();
    (!finite.is_empty()).then(|| pipeline::statistics::rms_max(&finite).0)
}

/// What the motion does at a sample, and what the error there comes from or where it points, as far as that is clear.
fn why(track: &Track<'_>, run: &Run, k: usize) -> String {
    let motion = motion_at(track.desired, track.places[k]);
    let error = &run.errors[k];
    if let Some(lagged) = run.lags.as_ref().and_then(|lags| lags.explains(k, &error.vector)) {
        let Lagged { slow, fast, by_s } = lagged;
        return format!("{motion}; axis {slow} lags {:.3} ms more than {fast}", by_s * 1e3);
    }
    if let MotionAt::Curve { inward, .. } = &motion {
        let share = inward.dot(&error.vector) / error.magnitude_mm;
        if share.abs() > ALONG {
            return format!(
                "{motion}; the tool {}",
                if share > 0.0 { "cuts the curve on its inside" } else { "swings to its outside" }
            );
        }
    }
    let along = ["X", "Y", "Z"].into_iter().enumerate().find(|(c, _)| error.vector[*c].abs() > ALONG * error.magnitude_mm);
    match along {
        Some((_, axis)) => format!("{motion}; the error points along {axis}"),
        None => motion.to_string(),
    }
}
