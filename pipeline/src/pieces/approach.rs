//! Approach to a piece of a path, which puts backlash and friction on their side.

use std::f64::consts::PI;
use std::ops::Range;

use super::heading::Heading;

/// Length of the approach, mm or rad: far above presliding distances and backlash.
const LENGTH: f64 = 0.5;
/// Its time, and that of the standstill after it, s.
const TIME_S: f64 = 0.5;

/// Direction of the last motion of an axis before a piece of its path. Pieces come in their order.
#[derive(Debug)]
pub(crate) struct Approach {
    heading: Heading,
    /// Samples that are read before every piece.
    before: usize,
    /// Sample of the path up to which the direction is that of the last motion.
    until: usize,
}

impl Approach {
    pub fn new(before: usize) -> Self {
        Self { heading: Heading::default(), before, until: 0 }
    }

    /// The positions `reference`, which begin with sample `first` of the path and hold the samples `own` of the piece itself, behind a
    /// motion to the first of them in the direction of the last motion of the axis. None is put before the start of the path.
    pub fn to(&mut self, reference: &[f64], first: usize, own: Range<usize>, period_s: f64) -> Vec<f64> {
        let samples = (TIME_S / period_s).ceil();
        let start = reference.first().copied().unwrap_or_default();
        let mut out = Vec::new();
        if first > 0 {
            let away = |k: usize| 0.5 * (1.0 + (PI * k as f64 / samples).cos());
            out.extend((0..samples as usize).map(|k| start - self.heading.sign * LENGTH * away(k)));
            out.resize(2 * samples as usize, start);
        }
        out.extend_from_slice(reference);
        // The next piece begins there.
        let end = own.end.saturating_sub(self.before);
        for at in reference.iter().take(end).skip(self.until - first) {
            self.heading.turns(*at, period_s);
        }
        self.until = self.until.max(first + end);
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_approached_in_the_direction_of_the_last_motion() {
        // There and back, a long standstill, and on.
        let path: Vec<f64> = (0..4000)
            .map(|k| match k {
                0..1000 => 0.01 * f64::from(k),
                1000..1500 => 10.0 - 0.01 * f64::from(k - 1000),
                1500..3500 => 5.0,
                _ => 5.0 + 0.01 * f64::from(k - 3500),
            })
            .collect();
        let (mut approach, before, mut signs) = (Approach::new(200), 200, Vec::new());
        for from in (0..4000).step_by(500) {
            let first = usize::saturating_sub(from, before);
            let found = approach.to(&path[first..from + 500], first, from - first..from - first + 500, 0.002);
            let prefix = found.len() - (from + 500 - first);
            assert_eq!(found[prefix..], path[first..from + 500]);
            assert_eq!(prefix > 0, first > 0);
            signs.push((found[prefix] - found[0]).signum() * f64::from(u8::from(prefix > 0)));
        }
        assert_eq!(signs, [0.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0, -1.0]);
    }
}
