//! What a control commanded, against what its program was to make it command.

use anyhow::Result;
use datasets::Log;
use motion::contour::{ContourEstimator, ContourSummary};
use serde_json::{Value, json};

use super::{Match, match_places};
use crate::evaluate::{contour_json, summary_of_feed_moves};
use crate::input::Input;
use crate::output::um;

/// A command this near to the intended path, mm at most, is what was meant: a tenth of what a first run leaves.
const NEAR_MM: f64 = 1e-3;
/// Share by which the time between the path's ends may differ.
const SAME_TIME: f64 = 0.03;

/// A command beside its intention.
#[derive(Debug, Clone, Copy)]
pub struct Readback {
    /// Distance of the commanded path from the intended one, over feed moves, mm.
    pub path: ContourSummary,
    /// Time from the path's start to its end as intended, s.
    pub intended_s: f64,
    /// The same as commanded, s.
    pub commanded_s: f64,
    /// Largest difference between the instants at which both pass a place, both starting together, s.
    pub largest_delay_s: f64,
}

impl Readback {
    /// Whether the carrier of the program's points is faithful in space, and in time.
    #[must_use]
    pub fn is_faithful(&self) -> [bool; 2] {
        let ratio = self.commanded_s / self.intended_s;
        [self.path.max_mm <= NEAR_MM, (ratio - 1.0).abs() <= SAME_TIME]
    }

    /// The figures in words.
    #[must_use]
    pub fn in_words(&self) -> String {
        format!(
            "commanded path beside the planned one: {} µm RMS, {} µm MAX; {:.3} s planned, {:.3} s commanded, at most {:.1} ms apart",
            um(self.path.rms_mm),
            um(self.path.max_mm),
            self.intended_s,
            self.commanded_s,
            self.largest_delay_s * 1e3
        )
    }

    /// The figures as JSON.
    #[must_use]
    pub fn json(&self) -> Value {
        let [space, time] = self.is_faithful();
        json!({
            "readback_um": contour_json(&self.path),
            "planned_s": self.intended_s,
            "commanded_s": self.commanded_s,
            "largest_delay_ms": self.largest_delay_s * 1e3,
            "path_is_kept": space,
            "time_is_kept": time,
        })
    }
}

/// Compares the command of `log` with what is planned for `intended`; with how the one lies against the other.
///
/// # Errors
/// When the command leads elsewhere.
pub fn readback(log: &Log, intended: &Input, estimator: &mut dyn ContourEstimator) -> Result<(Readback, Match)> {
    let period = log.period_s();
    let commanded = intended.desired.tips_of(&log.reference)?;
    let matched = match_places(&intended.desired, &commanded, period)?;
    let rests = |k: usize| k == 0 || commanded[k] == commanded[k - 1];
    let on_path: Vec<_> = commanded.iter().map(|point| point - matched.offset).collect();
    let errors = estimator.estimate(&on_path, &matched.path)?;
    let places = &matched.places;
    let path = summary_of_feed_moves(intended.part.as_ref(), places.iter().map(|place| place.round() as usize).zip(errors))?;
    // From where the intended path leaves its start to where it comes to its end.
    let tips = intended.desired.tips();
    let moves = |k: &usize| tips[*k] != tips[k - 1];
    let ends = (1..tips.len()).find(moves).zip((1..tips.len()).rev().find(moves));
    let (start, end) = ends.ok_or_else(|| anyhow::anyhow!("the path does not move"))?;
    let passed = |place: usize| places.partition_point(|known| *known < place as f64) as f64;
    let (first, last) = (passed(start), passed(end));
    // A rest is one place at many instants: it makes no one late.
    let within = |(k, place): &(usize, &f64)| !rests(*k) && **place >= start as f64 && **place <= end as f64;
    let late = places.iter().enumerate().filter(within);
    let largest = late.map(|(k, place)| ((k as f64 - first) - (place - start as f64)).abs()).fold(0.0, f64::max);
    let found = Readback {
        path,
        intended_s: (end - start) as f64 * period,
        commanded_s: (last - first) * period,
        largest_delay_s: largest * period,
    };
    Ok((found, matched))
}
