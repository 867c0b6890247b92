//! Paper A, figure 3: its contour-error estimator on a circle, beside the distance from the centre.

use std::f64::consts::TAU;
use std::sync::Arc;

use anyhow::Result;
use machine::{Machine, SimulatedMachine};
use motion::contour::{ContourEstimator, HermiteFootPoint};
use motion::curves::Arc as CircleArc;
use motion::{Vec3, plan_curve_on};
use pipeline::Setup;
use pipeline::units::um;
use serde_json::json;

use super::Reproduce;
use super::found::{Entry, Found, Printed, Section};
use crate::output::{Printer, table};
use crate::read;

/// Radius of the circle.
const RADIUS_MM: f64 = 1.5;
/// Feed, mm/min; the paper does not print it. That of its other experiments.
const FEED_MM_MIN: f64 = 1000.0;
/// Largest difference of the two, as printed.
const PRINTED_MM: f64 = 5.9e-5;

const WHY: &str = "Another machine, and a feed that the paper does not print. Radii are interpolated between the two samples around the foot point.";
const INSTANT: &str = "The actual point trails behind the desired one of its instant, so that the two see the error at different places of the circle. The \
                       paper does not say which pairing it uses.";

impl Reproduce {
    pub(super) fn circle(&self, printer: &Printer) -> Result<Found> {
        let spec = read::machine(&self.machine.machine)?;
        let setup = Setup::new(&spec, None)?;
        let start = Vec3::new(RADIUS_MM, 0.0, 0.0);
        let circle = CircleArc::new(start, Vec3::zeros(), Vec3::z(), TAU, RADIUS_MM, 0.0)?;
        let desired =
            plan_curve_on(Arc::new(circle), FEED_MM_MIN / 60.0, &setup.kinematics, &setup.limits, &setup.plan_settings())?;
        let actual = SimulatedMachine::new(&spec, self.common.seed)?.run(desired.trajectory())?;
        let tips = desired.tips_of(&actual)?;
        // Searched to the path's end, as printed, the first samples of a closed curve would find its last ones.
        let errors = HermiteFootPoint::default().estimate(&desired.tips(), &tips)?;
        let by_radius: Vec<f64> = tips.iter().map(|tip| tip.norm() - RADIUS_MM).collect();
        let largest = by_radius.iter().fold(0.0_f64, |largest, error| largest.max(error.abs()));
        // A desired point inside an actual path that is too large lies to its left: the same sign as the radius.
        let (mut at_place, mut at_instant) = (0.0_f64, 0.0_f64);
        for (k, error) in errors.iter().enumerate().filter(|(_, error)| !error.at_end) {
            let (segment, share) = (error.location.segment, error.location.fraction);
            let there = by_radius[segment] * (1.0 - share) + by_radius[(segment + 1).min(tips.len() - 1)] * share;
            at_place = at_place.max((error.left_mm() - there).abs());
            at_instant = at_instant.max((error.left_mm() - by_radius[k]).abs());
        }
        printer.line(format!("Paper A, figure 3: its estimator on a circle of {RADIUS_MM} mm at {FEED_MM_MIN} mm/min"));
        let lines = [
            vec!["largest contour error, by the radius".to_owned(), "–".to_owned(), um(largest)],
            vec!["largest difference of estimator and radius, at the foot point".to_owned(), um(PRINTED_MM), um(at_place)],
            vec!["the same, at the same instant".to_owned(), "–".to_owned(), um(at_instant)],
        ];
        printer.line(table(&["", "printed µm", "µm"], &lines));
        let section = Section {
            paper: 'A',
            title: "Figure 3: the estimator on a circle of 1.5 mm".into(),
            note: format!("At {FEED_MM_MIN} mm/min; the error is the distance from the centre less the radius (eq. 11)."),
            entries: vec![
                Entry::um("largest contour error, by the radius", Printed::None, largest, "Shown as a curve only."),
                Entry::um(
                    "largest difference of estimator and radius, at the foot point",
                    Printed::Value(PRINTED_MM * 1e3),
                    at_place,
                    WHY,
                ),
                Entry::um("the same, at the same instant", Printed::None, at_instant, INSTANT),
            ],
            pictures: Vec::new(),
        };
        let rows = json!([
            { "name": "contour error by the radius", "printed": null, "measured": { "max_um": largest * 1e3 } },
            { "name": "estimator less radius", "printed": { "max_um": PRINTED_MM * 1e3 }, "measured": { "max_um": at_place * 1e3, "at_instant_um": at_instant * 1e3 } },
        ]);
        Ok(Found { tables: vec![json!({ "paper": "A", "table": "figure 3", "rows": rows })], sections: vec![section] })
    }
}
