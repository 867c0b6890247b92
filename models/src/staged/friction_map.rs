//! Friction level along the axis.

use serde::{Deserialize, Serialize};

use crate::ranges::{DIVISOR, POSITION, WEIGHT, all_within, within};

/// Least level: friction never helps.
const LEAST: f64 = 0.05;

/// Friction level at positions along the axis, relative to the level elsewhere: one series for each
/// direction of motion.
///
/// The level is linear between positions, and 1 from one spacing beyond the first and the last.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrictionMap {
    /// First position, from the middle of the trained positions, in the axis's unit.
    pub first: f64,
    /// Distance of successive positions.
    pub spacing: f64,
    /// Level in motion towards larger positions.
    pub forwards: Vec<f64>,
    /// Level in motion towards smaller positions.
    pub backwards: Vec<f64>,
}

impl FrictionMap {
    /// Levels at a position relative to the middle, forwards and backwards.
    #[must_use]
    pub fn at(&self, position: f64) -> [f64; 2] {
        let (before, share) = self.cell(position);
        [&self.forwards, &self.backwards].map(|levels| {
            let level = |index: isize| usize::try_from(index).ok().and_then(|index| levels.get(index)).copied().unwrap_or(1.0);
            let between = (1.0 - share) * level(before) + share * level(before + 1);
            between.max(LEAST)
        })
    }

    /// Index of the map position before `position`, from −1, and the fraction of the distance to
    /// the next one, 0…1.
    #[must_use]
    pub fn cell(&self, position: f64) -> (isize, f64) {
        let steps = ((position - self.first) / self.spacing).clamp(-1.0, self.forwards.len() as f64);
        let before = steps.floor();
        (before as isize, steps - before)
    }

    /// Checks that there is a position and all numbers are valid.
    pub(super) fn check(&self) -> Result<(), String> {
        if self.forwards.len() != self.backwards.len() {
            return Err("a friction map whose directions differ in length".into());
        }
        within("friction_map.first", self.first, POSITION)?;
        within("friction_map.spacing", self.spacing, DIVISOR)?;
        all_within("friction_map.forwards", &self.forwards, WEIGHT)?;
        all_within("friction_map.backwards", &self.backwards, WEIGHT)
    }
}

/// Levels along a path.
#[derive(Debug, Clone, Default)]
pub struct Levels {
    /// Forwards, one a sample.
    pub forwards: Vec<f64>,
    /// Backwards, one a sample.
    pub backwards: Vec<f64>,
}

impl Levels {
    /// Levels of `map` along `position`, which counts from `centre`.
    #[must_use]
    pub fn along(map: &FrictionMap, position: &[f64], centre: f64) -> Self {
        let (forwards, backwards) = position.iter().map(|x| map.at(x - centre)).map(|[f, b]| (f, b)).unzip();
        Self { forwards, backwards }
    }

    /// Level at a sample in motion in the direction of `sign`.
    #[must_use]
    pub fn towards(&self, sample: usize, sign: f64) -> f64 {
        if sign < 0.0 { self.backwards[sample] } else { self.forwards[sample] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_linear_between_places_and_one_beyond() {
        let map = FrictionMap { first: -2.0, spacing: 2.0, forwards: vec![1.2, 1.4, 1.0], backwards: vec![1.0, 0.5, 1.0] };
        assert_eq!(map.at(-2.0), [1.2, 1.0]);
        assert!((map.at(-1.0)[0] - 1.3).abs() < 1e-12 && (map.at(-1.0)[1] - 0.75).abs() < 1e-12);
        assert!((map.at(-3.0)[0] - 1.1).abs() < 1e-12);
        for far in [-4.0, -1e9, 4.0, 1e9] {
            assert_eq!(map.at(far), [1.0, 1.0]);
        }
        assert!(map.check().is_ok());
        assert!(FrictionMap { spacing: 0.0, ..map.clone() }.check().is_err());
        assert!(FrictionMap { forwards: vec![f64::NAN; 3], ..map }.check().is_err());
    }
}
