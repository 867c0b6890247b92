//! Scaling of features and targets to unit size.

use serde::{Deserialize, Serialize};

use crate::ranges::{DEVIATION, WEIGHT, singles_within};

/// Mean and standard deviation of every column.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scaler {
    mean: Vec<f32>,
    deviation: Vec<f32>,
}

impl Scaler {
    /// The scaler that gives the columns of `rows` (row-major, `width` columns) zero mean and unit deviation; constant columns are
    /// only shifted.
    #[must_use]
    pub fn fit<'a>(rows: impl Iterator<Item = &'a [f32]>, width: usize) -> Self {
        let (mut count, mut sum, mut squares) = (0.0_f64, vec![0.0_f64; width], vec![0.0_f64; width]);
        for block in rows {
            for row in block.chunks_exact(width) {
                count += 1.0;
                for (i, value) in row.iter().enumerate() {
                    sum[i] += f64::from(*value);
                    squares[i] += f64::from(*value).powi(2);
                }
            }
        }
        let count = count.max(1.0);
        let mean: Vec<f64> = sum.iter().map(|s| s / count).collect();
        let deviation = squares.iter().zip(&mean).map(|(q, m)| {
            let d = (q / count - m * m).max(0.0).sqrt();
            if d > 1e-9 * (1.0 + m.abs()) { d as f32 } else { 1.0 }
        });
        Self { deviation: deviation.collect(), mean: mean.iter().map(|m| *m as f32).collect() }
    }

    /// Number of columns.
    #[must_use]
    pub fn width(&self) -> usize {
        self.mean.len()
    }

    /// Whether it has `width` columns of valid numbers; the error describes the fault.
    pub(crate) fn check(&self, width: usize) -> Result<(), String> {
        if self.mean.len() != width || self.deviation.len() != width {
            return Err(format!("a scaler of {} and {} columns for {width}", self.mean.len(), self.deviation.len()));
        }
        singles_within("mean", &self.mean, WEIGHT)?;
        singles_within("deviation", &self.deviation, DEVIATION)
    }

    /// Scales rows in place.
    pub fn scale(&self, rows: &mut [f32]) {
        for row in rows.chunks_exact_mut(self.width()) {
            for ((value, mean), deviation) in row.iter_mut().zip(&self.mean).zip(&self.deviation) {
                *value = (*value - mean) / deviation;
            }
        }
    }

    /// Undoes [`Scaler::scale`].
    pub fn unscale(&self, rows: &mut [f32]) {
        for row in rows.chunks_exact_mut(self.width()) {
            for ((value, mean), deviation) in row.iter_mut().zip(&self.mean).zip(&self.deviation) {
                *value = *value * deviation + mean;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scaled_columns_have_unit_size_and_come_back() {
        let rows: Vec<f32> = (0..100).flat_map(|k| [k as f32, 5.0, -(k as f32) * 0.01]).collect();
        let scaler = Scaler::fit(std::iter::once(rows.as_slice()), 3);
        let mut scaled = rows.clone();
        scaler.scale(&mut scaled);
        let column: Vec<f32> = scaled.chunks_exact(3).map(|row| row[0]).collect();
        let rms = (column.iter().map(|v| v * v).sum::<f32>() / 100.0).sqrt();
        assert!((rms - 1.0).abs() < 1e-4);
        assert_eq!(scaled[1], 0.0);
        scaler.unscale(&mut scaled);
        assert!(scaled.iter().zip(&rows).all(|(a, b)| (a - b).abs() < 1e-4));
    }
}
