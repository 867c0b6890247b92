//! Axis positions, sampled at a uniform rate.

use crate::{Axis, MotionError};

/// Positions of any number of axes, one sample per period, one column per axis (mm or rad).
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    period_s: f64,
    axes: Vec<Axis>,
    columns: Vec<Vec<f64>>,
}

impl Trajectory {
    /// A trajectory from one column per axis.
    ///
    /// # Errors
    /// If the period is not positive, an axis is named twice, columns differ in length, or a value
    /// is not finite.
    pub fn new(period_s: f64, axes: Vec<Axis>, columns: Vec<Vec<f64>>) -> Result<Self, MotionError> {
        if !(period_s.is_finite() && period_s > 0.0) {
            return Err(MotionError::BadPeriod(period_s));
        }
        for (i, axis) in axes.iter().enumerate() {
            if axes[..i].iter().any(|other| other.name == axis.name) {
                return Err(MotionError::DuplicateAxis(axis.name.clone()));
            }
        }
        let lengths: Vec<usize> = columns.iter().map(Vec::len).collect();
        if lengths.len() != axes.len() || lengths.windows(2).any(|pair| pair[0] != pair[1]) {
            return Err(MotionError::Ragged { axes: axes.len(), lengths });
        }
        for (axis, column) in axes.iter().zip(&columns) {
            if let Some(sample) = column.iter().position(|value| !value.is_finite()) {
                return Err(MotionError::NotFinite { axis: axis.name.clone(), sample });
            }
        }
        Ok(Self { period_s, axes, columns })
    }

    /// The same axes and period with other positions.
    ///
    /// # Errors
    /// As [`Trajectory::new`].
    pub fn with_columns(&self, columns: Vec<Vec<f64>>) -> Result<Self, MotionError> {
        Self::new(self.period_s, self.axes.clone(), columns)
    }

    /// Time between samples, s.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// The axes, in column order.
    #[must_use]
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// Whether there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Time from the first sample to the last, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.len().saturating_sub(1) as f64 * self.period_s
    }

    /// All columns, one per axis.
    #[must_use]
    pub fn columns(&self) -> &[Vec<f64>] {
        &self.columns
    }

    /// The column of the axis called `name`.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let index = self.axes.iter().position(|axis| axis.name == name)?;
        Some(&self.columns[index])
    }

    /// The columns, by value.
    #[must_use]
    pub fn into_columns(self) -> Vec<Vec<f64>> {
        self.columns
    }

    /// Positions of all axes at sample `k` (`k < len`), in axis order.
    pub fn at(&self, k: usize) -> impl Iterator<Item = f64> + '_ {
        self.columns.iter().map(move |column| column[k])
    }

    /// Tracking error `reference − actual` of every axis: positive for an axis that lags in
    /// positive motion.
    ///
    /// # Errors
    /// If axes, period or length differ.
    pub fn tracking_error(&self, actual: &Self) -> Result<Vec<Vec<f64>>, MotionError> {
        self.check_matches(actual)?;
        Ok(self
            .columns
            .iter()
            .zip(&actual.columns)
            .map(|(reference, actual)| reference.iter().zip(actual).map(|(r, a)| r - a).collect())
            .collect())
    }

    /// Checks that the trajectory has these axes, in this order.
    ///
    /// # Errors
    /// Names both.
    pub fn check_axes(&self, axes: &[Axis]) -> Result<(), MotionError> {
        if self.axes == axes {
            return Ok(());
        }
        let names = |axes: &[Axis]| axes.iter().map(|a| a.name.clone()).collect::<Vec<_>>().join(" ");
        Err(MotionError::Mismatch(format!("axes {} against {}", names(&self.axes), names(axes))))
    }

    /// Checks that `other` has the same axes, period and length.
    ///
    /// # Errors
    /// States which of the three differs.
    pub fn check_matches(&self, other: &Self) -> Result<(), MotionError> {
        self.check_axes(&other.axes)?;
        if (self.period_s - other.period_s).abs() > 1e-9 * self.period_s {
            return Err(MotionError::Mismatch(format!("a period of {} s against {} s", self.period_s, other.period_s)));
        }
        if self.len() != other.len() {
            return Err(MotionError::Mismatch(format!("{} samples against {}", self.len(), other.len())));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(values: &[f64]) -> Trajectory {
        Trajectory::new(0.002, vec![Axis::named("x")], vec![values.to_vec()]).unwrap()
    }

    #[test]
    fn a_lagging_axis_has_a_positive_tracking_error() {
        let error = one(&[0.0, 1.0, 2.0]).tracking_error(&one(&[0.0, 0.9, 1.9])).unwrap();
        assert!(error[0][1] > 0.0 && error[0][2] > 0.0);
    }

    #[test]
    fn bad_columns_are_refused() {
        assert!(matches!(Trajectory::new(0.0, vec![], vec![]), Err(MotionError::BadPeriod(_))));
        let axes = || vec![Axis::named("x"), Axis::named("y")];
        assert!(matches!(Trajectory::new(0.002, axes(), vec![vec![0.0], vec![]]), Err(MotionError::Ragged { .. })));
        assert!(matches!(
            Trajectory::new(0.002, axes(), vec![vec![0.0], vec![f64::NAN]]),
            Err(MotionError::NotFinite { sample: 0, .. })
        ));
        assert!(one(&[0.0]).check_matches(&one(&[0.0, 1.0])).is_err());
    }
}
