//! How the logged position of an axis changes with friction, backlash and lag: derivatives of its servo model.

use diagnosis::record::AxisRecord;
use rayon::prelude::*;
use servo::{Servo, index, simulate};

/// Steps of the derivatives: of the logarithm of the friction, of the lag, s, and of the backlash, mm. That of the backlash is a secant over what has
/// to be found, since the effect of backlash is not linear near zero.
const FRICTION_STEP: f64 = 0.1;
const LAG_STEP_S: f64 = 1e-5;
const BACKLASH_STEP_MM: f64 = 2e-3;

/// What is told apart in the residual of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cause {
    /// Relative change of the friction level.
    Friction,
    /// Change of the backlash, mm.
    Backlash,
    /// Change of the lag, s.
    Lag,
    /// A constant deviation, mm.
    Offset,
}

impl Cause {
    /// The causes that the servo model of an axis knows.
    pub(crate) fn of(servo: &Servo) -> Vec<Self> {
        let mut all = vec![Self::Lag, Self::Offset];
        if servo.coulomb_mm > 0.0 {
            all.push(Self::Friction);
        }
        // Only where motor and table are two masses.
        if servo.table_pulsation_1_s > 0.0 {
            all.push(Self::Backlash);
        }
        all
    }

    /// The two servo models of a difference quotient, and the width between them; `None` for an offset.
    fn pair(self, servo: Servo) -> Option<(Servo, Servo, f64)> {
        let (parameter, down, up) = match self {
            Self::Friction => (index::COULOMB, -FRICTION_STEP, FRICTION_STEP),
            Self::Lag => (index::LOOP_LAG, -LAG_STEP_S, LAG_STEP_S),
            Self::Backlash if servo.outer_backlash_mm > 0.0 => (index::OUTER_BACKLASH, 0.0, BACKLASH_STEP_MM),
            Self::Backlash => (index::BACKLASH, 0.0, BACKLASH_STEP_MM),
            Self::Offset => return None,
        };
        let (low, high) = (servo.moved(parameter, down), servo.moved(parameter, up));
        Some((low, high, high.coordinate(parameter) - low.coordinate(parameter)))
    }
}

/// Derivative of the position by each cause, over the scored samples of all runs one after the other.
pub(crate) fn sensitivities(record: &AxisRecord, servo: &Servo, causes: &[Cause]) -> Vec<Vec<f64>> {
    let first = record.first_scored();
    let of = |cause: &Cause| -> Vec<f64> {
        let scored: usize = record.runs.iter().map(|run| run.len().saturating_sub(first)).sum();
        let Some((low, high, width)) = cause.pair(*servo).filter(|(_, _, width)| *width > 0.0) else {
            return vec![if *cause == Cause::Offset { 1.0 } else { 0.0 }; scored];
        };
        let mut column = Vec::with_capacity(scored);
        for run in &record.runs {
            let follow = |servo: &Servo| simulate(servo, &run.reference, record.period_s, run.start(record.period_s));
            let (below, above) = (follow(&low), follow(&high));
            let change = above.iter().zip(&below).map(|(above, below)| (above - below) / width);
            column.extend(change.take(run.len()).skip(first));
        }
        column
    };
    causes.par_iter().map(of).collect()
}
