//! Paper D's table I: every estimator against the exact error on the analytic flower.

mod contour_common;

use std::sync::Arc;

use contour_common::*;
use motion::contour::{ContourEstimator, ContourQuery, ExactOnCurve, TableRow, TimeMatch, sample_estimators, table_row};
use motion::{Curve, Vec3};

/// Rows at a sampling rate. Every estimator in the direction of the truth, actual → desired.
fn rows(times: usize) -> Vec<TableRow> {
    let curve: Arc<dyn Curve> = Arc::new(flower(30.0, 25.0, 6.0));
    let (parameters, desired) = travel(curve.as_ref(), 80.0, 800.0, PERIOD_S);
    let actual = lagged(&desired, [0.0090, 0.0092, 0.0090], PERIOD_S, 1);
    let coarse = |path: &[Vec3]| path.iter().copied().step_by(times).collect::<Vec<_>>();
    let (desired, actual) = (coarse(&desired), coarse(&actual));
    let parameters = parameters.into_iter().step_by(times).collect();
    let truth = ExactOnCurve::new(curve).with_parameters(parameters).unwrap().estimate(&actual, &desired).unwrap();
    let mut errors = Vec::new();
    sample_estimators()
        .iter_mut()
        .map(|estimator| {
            let started = std::time::Instant::now();
            estimator.estimate_into(ContourQuery::new(&actual, &desired, TimeMatch::SAME), &mut errors).unwrap();
            table_row(estimator.name(), &errors, &truth, started.elapsed().as_secs_f64())
        })
        .collect()
}

#[test]
fn the_order_of_table_i() {
    for (hz, times) in [(500, 1), (250, 2), (125, 4)] {
        let rows = rows(times);
        let max = |name: &str| rows.iter().find(|row| row.estimator == name).map(|row| row.max_error_um);
        let exact = max("exact").unwrap();
        println!("{hz} Hz");
        for row in &rows {
            println!(
                "  {:14} max {:9.4} µm  rms {:9.5} µm  {:6.0} ns a sample",
                row.estimator, row.max_error_um, row.rms_error_um, row.ns_per_sample
            );
        }
        for other in ["spline-search", "circle", "tangent"] {
            assert!(max(other).unwrap() > 5.0 * exact, "{other} at {hz} Hz");
        }
        assert!(max("hermite-foot").unwrap() > 0.9 * exact);
        assert!(max("tangent").unwrap() > max("circle").unwrap());
        assert!(max("tangent").unwrap() > max("spline-search").unwrap());
        // One percent of the error of the paper's own method.
        assert!(hz < 500 || exact < 0.049);
    }
}
