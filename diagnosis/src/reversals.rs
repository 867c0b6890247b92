//! Reversals of a command and what the actual position does after them.

use servo::MOVING_MM_S;

/// Time before a reversal from which its level is taken, and time after it in which its peak is searched, s.
pub const BEFORE_S: f64 = 0.03;
/// See [`BEFORE_S`].
pub const AFTER_S: f64 = 0.12;
/// Longest standstill between the two directions of a reversal, s.
const STANDSTILL_S: f64 = 0.02;

/// A reversal of the command, far from others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reversal {
    /// Sample of the turning point.
    pub sample: usize,
    /// Direction after it, ±1.
    pub direction: f64,
}

/// Peak after a reversal.
#[derive(Debug, Clone, PartialEq)]
pub struct Peak {
    /// Direction after the reversal, ±1.
    pub direction: f64,
    /// Height above the level before the reversal, mm; positive where the axis stays behind.
    pub height_mm: f64,
    /// Time from the reversal of the command to the peak, s.
    pub time_s: f64,
    /// Time during which the deviation exceeds half its height, s.
    pub duration_s: f64,
    /// Deviation less its level, from [`BEFORE_S`] before to [`AFTER_S`] after the reversal, mm.
    pub course_mm: Vec<f64>,
}

/// Reversals of `reference` without another one within the window of their peak.
pub fn reversals(reference: &[f64], period_s: f64) -> Vec<Reversal> {
    let threshold = MOVING_MM_S * period_s;
    let mut turns: Vec<Reversal> = Vec::new();
    // Sample and direction of the last motion.
    let mut last: Option<(usize, f64)> = None;
    for k in 1..reference.len() {
        let step = reference[k] - reference[k - 1];
        if step.abs() < threshold {
            continue;
        }
        if let Some((before, direction)) = last
            && direction * step < 0.0
            && (k - before) as f64 * period_s <= STANDSTILL_S
        {
            turns.push(Reversal { sample: usize::midpoint(before, k), direction: step.signum() });
        }
        last = Some((k, step.signum()));
    }
    let window = ((BEFORE_S + AFTER_S) / period_s) as usize;
    let alone = |i: usize| {
        (i == 0 || turns[i].sample - turns[i - 1].sample > window)
            && turns.get(i + 1).is_none_or(|next| next.sample - turns[i].sample > window)
    };
    (0..turns.len()).filter(|&i| alone(i)).map(|i| turns[i]).collect()
}

/// The peak of `deviation` (actual position less that without friction, mm) after a reversal. `None` at the ends of a run.
pub fn peak(deviation: &[f64], reversal: Reversal, period_s: f64) -> Option<Peak> {
    let (before, after) = ((BEFORE_S / period_s).round() as usize, (AFTER_S / period_s).round() as usize);
    let (start, end) = (reversal.sample.checked_sub(before)?, reversal.sample + after);
    let course: Vec<f64> = deviation.get(start..end)?.iter().map(|d| -reversal.direction * d).collect();
    let level = course[..before].iter().sum::<f64>() / before.max(1) as f64;
    let course_mm: Vec<f64> = course.iter().map(|d| d - level).collect();
    let (place, &height_mm) = course_mm.iter().enumerate().skip(before).max_by(|a, b| a.1.total_cmp(b.1))?;
    let wide = course_mm[before..].iter().filter(|d| **d > 0.5 * height_mm).count();
    Some(Peak {
        direction: reversal.direction,
        height_mm,
        time_s: (place - before) as f64 * period_s,
        duration_s: wide as f64 * period_s,
        course_mm,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_peak_behind_a_reversal_is_measured() {
        let period_s = 0.002;
        let time = |k: usize| k as f64 * period_s;
        let reference: Vec<f64> = (0..2000).map(|k| 10.0 * (2.0 * time(k)).sin()).collect();
        let found = reversals(&reference, period_s);
        // Turning points at 2t = π/2 + nπ within 4 s.
        assert_eq!(found.len(), 3);
        assert!((time(found[0].sample) - std::f64::consts::FRAC_PI_4).abs() < 0.01);
        assert_eq!(found[0].direction, -1.0);
        let bump = |k: usize| {
            let t = time(k) - time(found[0].sample) - 0.03;
            0.004 * (-(t / 0.01).powi(2)).exp()
        };
        let deviation: Vec<f64> = (0..2000).map(|k| 0.01 + bump(k)).collect();
        let peak = peak(&deviation, found[0], period_s).unwrap();
        assert!((peak.height_mm - 0.004).abs() < 1e-5 && (peak.time_s - 0.03).abs() < 0.0021, "{peak:?}");
        // Full width at half maximum: 2 · 0.01 · √ln 2.
        assert!((peak.duration_s - 0.01665).abs() < 0.0025, "{}", peak.duration_s);
    }
}
