//! The residual behind reversals of an axis, where backlash and friction act.
//!
//! Backlash leaves the table standing while the command has turned; a loop that sees the table closes the gap within its own time. Over a whole log that is
//! little beside what a model leaves anyway (of 5 µm on machines with table scales a tenth to a half of the RMS error); in the short time behind a reversal it is most of
//! the residual.

use diagnosis::record::AxisRecord;

/// Time behind a reversal of the command, s, in addition to the lag of the axis.
const BEHIND_S: f64 = 0.05;
/// Smallest number of reversals that show something.
const LEAST: usize = 10;
/// Motion on both sides of a reversal, mm: less is rest.
const MOTION_MM: f64 = 0.02;

/// RMS of the residuals behind reversals, mm; `None` where there are too few. The residuals are those of the scored samples of every run.
pub(crate) fn rms_behind(record: &AxisRecord, residuals: &[Vec<f64>], lag_s: f64) -> Option<f64> {
    let behind = ((BEHIND_S + lag_s.max(0.0)) / record.period_s).round() as usize;
    let first = record.first_scored();
    let (mut squares, mut samples, mut count) = (0.0, 0_usize, 0_usize);
    for (run, residuals) in record.runs.iter().zip(residuals) {
        let mut counted_to = 0;
        for at in reversals(&run.reference) {
            let from = at.saturating_sub(first).max(counted_to);
            let to = (at + behind).saturating_sub(first).min(residuals.len());
            if from < to {
                squares += residuals[from..to].iter().map(|value| value * value).sum::<f64>();
                samples += to - from;
                counted_to = to;
                count += 1;
            }
        }
    }
    (count >= LEAST).then(|| (squares / samples as f64).sqrt())
}

/// Samples at which a position turns, after moving by [`MOTION_MM`] and before it does so the other way.
fn reversals(positions: &[f64]) -> Vec<usize> {
    let Some(&first) = positions.first() else { return Vec::new() };
    let mut found = Vec::new();
    // The last extreme position in the present direction, and its sample.
    let (mut extreme, mut at, mut direction) = (first, 0, 0.0);
    for (k, &position) in positions.iter().enumerate() {
        let moved = position - extreme;
        if direction == 0.0 && moved.abs() >= MOTION_MM {
            direction = moved.signum();
        }
        if direction == 0.0 {
            continue;
        }
        // A rest at the turn belongs to it: the axis turns where it leaves again.
        if moved * direction >= 0.0 {
            (extreme, at) = (position, k);
        } else if moved.abs() >= MOTION_MM {
            found.push(at);
            (extreme, at, direction) = (position, k, -direction);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use diagnosis::record::Run;

    use super::*;

    #[test]
    fn a_position_turns_where_it_leaves_its_extreme_and_small_motion_is_rest() {
        let up = (0..=10).map(|k| 0.1 * f64::from(k));
        let rest = std::iter::repeat_n(1.0, 5);
        let down = (1..=10).map(|k| 1.0 - 0.1 * f64::from(k));
        let trembling = (1..=6).map(|k| 0.005 * f64::from(k % 2));
        let positions: Vec<f64> = up.chain(rest).chain(down).chain(trembling).chain([0.5, 1.0]).collect();
        // At the end of the rest, and where the trembling ends within 5 µm of the lower extreme.
        let found = reversals(&positions);
        assert_eq!(found.len(), 2, "{found:?}");
        assert_eq!(found[0], 15);
        assert!((25..=31).contains(&found[1]), "{found:?}");
    }

    #[test]
    fn only_what_lies_behind_reversals_counts() {
        let reference: Vec<f64> = (0..20_000).map(|k| (std::f64::consts::TAU * f64::from(k) / 1000.0).sin()).collect();
        let record = AxisRecord {
            name: "x".to_owned(),
            rotary: false,
            period_s: 0.001,
            runs: vec![Run { name: String::new(), actual: reference.clone(), reference }],
        };
        // 2 µm in the 50 ms behind the turns at 250, 750, …, 1 µm everywhere else.
        let first = record.first_scored();
        let is_behind = |k: usize| (k + 250) % 500 < 50;
        let residual: Vec<f64> = (first..20_000).map(|k| if is_behind(k) { 2e-3 } else { 1e-3 }).collect();
        let rms = rms_behind(&record, &[residual], 0.0).unwrap();
        assert!((rms - 2e-3).abs() < 2e-5, "{rms}");
        let few =
            AxisRecord { runs: vec![Run { reference: vec![0.0; 5000], actual: vec![0.0; 5000], name: String::new() }], ..record };
        assert!(rms_behind(&few, &[vec![0.0; 5000 - first]], 0.0).is_none());
    }
}
