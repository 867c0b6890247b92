//! Paper D's table I: every estimator on the same pair of paths.

use crate::contour::{
    ContourError, ContourEstimator, Exact, HermiteFootPoint, MovingWindow, OsculatingCircle, SplineSearch, Tangent,
};

/// One row of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct TableRow {
    /// The estimator.
    pub estimator: &'static str,
    /// Largest error of the estimate, µm.
    pub max_error_um: f64,
    /// Root mean square error of the estimate, µm.
    pub rms_error_um: f64,
    /// Computing time, ns per sample.
    pub ns_per_sample: f64,
}

/// The estimators that need samples only, in table order.
#[must_use]
pub fn sample_estimators() -> Vec<Box<dyn ContourEstimator>> {
    vec![
        Box::new(SplineSearch::default()),
        Box::new(HermiteFootPoint::default()),
        Box::new(OsculatingCircle::default()),
        Box::new(Tangent::default()),
        Box::new(MovingWindow::default()),
        Box::new(Exact::default()),
    ]
}

/// The row of an estimator with these `errors`, computed within `elapsed_s`. `truth` are the
/// magnitudes by [`ExactOnCurve`](crate::contour::ExactOnCurve) on the same samples. Samples
/// without a partner are ignored.
#[must_use]
pub fn table_row(estimator: &'static str, errors: &[ContourError], truth: &[ContourError], elapsed_s: f64) -> TableRow {
    let misses_um = errors.iter().zip(truth).map(|(error, truth)| (error.magnitude_mm - truth.magnitude_mm).abs() * 1e3);
    let (max, squares, count) =
        misses_um.fold((0.0_f64, 0.0, 0.0), |(max, squares, count), miss| (max.max(miss), squares + miss * miss, count + 1.0));
    TableRow {
        estimator,
        max_error_um: max,
        rms_error_um: if count > 0.0 { (squares / count).sqrt() } else { 0.0 },
        ns_per_sample: elapsed_s * 1e9 / f64::max(count, 1.0),
    }
}
