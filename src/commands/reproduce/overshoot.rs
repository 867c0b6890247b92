//! Paper D, figure 3: what the tracking error does in a circular test where the axis reverses and where it starts, the reason for its two flags.

use anyhow::Result;
use machine::{Machine, SimulatedMachine};
use pipeline::{Input, Setup};
use serde_json::json;

use super::Reproduce;
use super::found::{Entry, Found, Printed, Section};
use super::picture::{Line, Panel, Picture, draw};
use crate::output::{Printer, table};
use crate::read;

/// Feed, mm/s; the paper does not print it. 1000 mm/min, at which peaks stand out from the lag.
const FEED_MM_S: f64 = 1000.0 / 60.0;
/// Time shown before and after the reversal or start, s. A peak of the simulated drives is over within it.
const BEFORE_S: f64 = 0.04;
const AFTER_S: f64 = 0.16;
/// Time before a reversal through which the course of the error is taken as a line, and time after it in which the peak beside this line is looked
/// for, s.
const COURSE_S: f64 = 0.02;
const PEAK_S: f64 = 0.1;
/// Way after which a starting axis counts as moving, mm: above the noise of the simulated drives.
const MOVED_MM: f64 = 1e-3;

const CURVE: &str = "Shown as a curve only. The lengths n1 and n2 of the flags follow from it; the paper does not print them.";

/// Reference velocity, mm/s, and tracking error, µm, of one axis around a sample.
struct Event {
    what: &'static str,
    axis: usize,
    sample: usize,
}

impl Reproduce {
    /// The circle of 20 mm begins at its point furthest in X: there Y starts, and half a turn later X reverses.
    pub(super) fn overshoot(&self, printer: &Printer) -> Result<Found> {
        let spec = read::machine(&self.machine.machine)?;
        let path = Input::curve("circle", FEED_MM_S, &Setup::new(&spec, None)?)?;
        let reference = path.trajectory();
        let period_s = reference.period_s();
        let actual = SimulatedMachine::new(&spec, self.common.seed)?.run(reference)?;
        let errors = reference.tracking_error(&actual)?;
        let velocity = |axis: usize| -> Vec<f64> {
            reference.columns()[axis].windows(2).map(|pair| (pair[1] - pair[0]) / period_s).collect()
        };
        let (x, y) = (velocity(0), velocity(1));
        let start = y.iter().position(|v| *v != 0.0).unwrap_or_default();
        let Some(reversal) = (start + 1..x.len()).find(|k| x[k - 1] < 0.0 && x[*k] >= 0.0) else {
            anyhow::bail!("X does not reverse on the circle");
        };
        let events =
            [Event { what: "reversal of X", axis: 0, sample: reversal }, Event { what: "start of Y", axis: 1, sample: start }];
        let samples = |seconds: f64| (seconds / period_s).round() as usize;
        let (peak_mm, peak_s) = peak(&errors[0], reversal, [COURSE_S, PEAK_S].map(samples), period_s);
        let position = &actual.columns()[1];
        let moved = (start..position.len()).find(|k| (position[*k] - position[start]).abs() > MOVED_MM).unwrap_or(start);
        let started_s = (moved - start) as f64 * period_s;
        let mut panels = Vec::new();
        for event in &events {
            let from = event.sample.saturating_sub(samples(BEFORE_S));
            let to = (event.sample + samples(AFTER_S)).min(x.len());
            let window = |values: &[f64], factor: f64| -> Vec<Vec<(f64, f64)>> {
                let at = |k: usize| ((k as f64 - event.sample as f64) * period_s, values[k] * factor);
                vec![(from..to).map(at).collect()]
            };
            let velocity = if event.axis == 0 { &x } else { &y };
            let panel = |what: &str, unit, line| Panel {
                title: format!("{what}, {}", event.what),
                axes: ("t, s", unit),
                is_path: false,
                lines: vec![line],
            };
            let line = Line { name: "reference velocity", pieces: window(velocity, 1.0) };
            panels.push(panel("velocity", "mm/s", line));
            let line = Line { name: "tracking error", pieces: window(&errors[event.axis], 1e3) };
            panels.push(panel("tracking error", "µm", line));
        }
        printer.line(format!("Paper D, figure 3: circular test, radius 20 mm at {:.1} mm/s", FEED_MM_S));
        let rows = [
            ("reversal of X: largest deviation from the course of the tracking error", "µm", peak_mm * 1e3),
            ("reversal of X: time until then", "ms", peak_s * 1e3),
            ("start of Y: time until the axis has moved by 1 µm", "ms", started_s * 1e3),
        ];
        let cells = |(name, unit, value): &(&str, &str, f64)| vec![(*name).to_owned(), format!("{value:.2} {unit}")];
        printer.line(table(&["", "measured"], &rows.iter().map(cells).collect::<Vec<_>>()));
        let section = Section {
            paper: 'D',
            title: "Figure 3: tracking error of a circular test at a reversal and at a start".into(),
            note: format!(
                "Radius 20 mm at 1000 mm/min; the paper prints neither. The course of the error is the line through its values of the last {:.0} ms.",
                COURSE_S * 1e3
            ),
            entries: rows.iter().map(|(name, unit, value)| Entry::of(*name, unit, Printed::None, *value, CURVE)).collect(),
            pictures: vec![Picture {
                file: "d-figure-3",
                caption: "Figure 3: reference velocity and tracking error where X reverses and where Y starts".into(),
                svg: draw(2, &panels),
            }],
        };
        let rows: Vec<_> = rows
            .iter()
            .map(|(name, unit, value)| json!({ "name": name, "unit": unit, "printed": null, "measured": value }))
            .collect();
        Ok(Found { tables: vec![json!({ "paper": "D", "table": "figure 3", "rows": rows })], sections: vec![section] })
    }
}

/// Largest distance of an error from the line through its values of the `course` samples before `at`, within `reach` samples after it, mm, and the
/// time until then, s.
fn peak(error: &[f64], at: usize, [course, reach]: [usize; 2], period_s: f64) -> (f64, f64) {
    let course = course.clamp(1, at.max(1));
    let slope = (error[at] - error[at.saturating_sub(course)]) / course as f64;
    let off = |k: usize| (error[k] - error[at] - slope * (k - at) as f64).abs();
    let to = (at + reach).min(error.len() - 1);
    let largest = (at..=to).max_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap_or(at);
    (off(largest), (largest - at) as f64 * period_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_peak_stands_beside_the_course_of_the_error() {
        // A ramp with a triangle of 3 µm on it, 10 samples after the reversal.
        let error: Vec<f64> =
            (0..200).map(|k| 1e-4 * f64::from(k) + 3e-3 * (1.0 - (f64::from(k) - 110.0).abs() / 5.0).max(0.0)).collect();
        let (peak_mm, peak_s) = peak(&error, 100, [20, 50], 0.002);
        assert!((peak_mm - 3e-3).abs() < 1e-12 && (peak_s - 0.02).abs() < 1e-12, "{peak_mm} {peak_s}");
    }
}
