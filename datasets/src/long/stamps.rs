//! Time stamps of a long log, judged as they come.

use crate::timing::{UNIFORM_SHARE, uniform_period_s};

/// Largest number of corners of the hull: even stamps have some dozens.
const MOST_CORNERS: usize = 100_000;

/// Time stamps as they come. Which of them lies furthest from a uniform grid is known at the end only, when the period is; it is a corner of
/// the convex hull of stamps over rows, so that only the hull is kept.
#[derive(Debug, Default)]
pub(super) struct Stamps {
    rows: usize,
    first_s: f64,
    last_s: f64,
    upper: Vec<(f64, f64)>,
    lower: Vec<(f64, f64)>,
}

impl Stamps {
    pub fn note(&mut self, time_s: f64) {
        if self.rows == 0 {
            self.first_s = time_s;
        }
        let corner = (self.rows as f64, time_s - self.first_s);
        add_corner(&mut self.upper, corner, 1.0);
        add_corner(&mut self.lower, corner, -1.0);
        self.last_s = time_s;
        self.rows += 1;
    }

    pub fn first_s(&self) -> f64 {
        self.first_s
    }

    /// Whether the stamps are far from even, whatever comes.
    pub fn is_hopeless(&self) -> bool {
        self.upper.len().max(self.lower.len()) > MOST_CORNERS
    }

    /// The period of even stamps, s; `None` where they are uneven.
    pub fn period_s(&self) -> Option<f64> {
        let mean_s = (self.last_s - self.first_s) / self.rows.checked_sub(1)? as f64;
        let off = |(row, since_s): &(f64, f64)| (since_s - row * mean_s).abs();
        let off_grid = self.upper.iter().chain(&self.lower).map(off).fold(0.0, f64::max);
        (mean_s > 0.0 && off_grid <= UNIFORM_SHARE * mean_s).then(|| uniform_period_s(mean_s))
    }
}

/// Adds a corner on the right to the hull of one side.
fn add_corner(hull: &mut Vec<(f64, f64)>, next: (f64, f64), side: f64) {
    while let [.., before, last] = hull.as_slice() {
        let bend = (last.0 - before.0) * (next.1 - before.1) - (last.1 - before.1) * (next.0 - before.0);
        if side * bend < 0.0 {
            break;
        }
        hull.pop();
    }
    hull.push(next);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn period_s(times: &[f64]) -> Option<f64> {
        let mut stamps = Stamps::default();
        times.iter().for_each(|time| stamps.note(*time));
        assert!(!stamps.is_hopeless());
        stamps.period_s()
    }

    #[test]
    fn even_stamps_have_their_period_and_one_that_is_off_shows() {
        let jitter = |k: u32| 2e-5 * (f64::from(k) * 12.9898).sin();
        let mut times: Vec<f64> = (0..50_000).map(|k| 7.0 + 0.001 * f64::from(k) + jitter(k)).collect();
        assert_eq!(period_s(&times), Some(0.001));
        times[20_000] += 4e-4;
        assert_eq!(period_s(&times), None);
        assert_eq!(period_s(&[1.0]), None);
        assert_eq!(period_s(&[2.0, 1.0, 0.0]), None);
    }
}
