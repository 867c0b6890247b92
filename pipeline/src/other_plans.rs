//! What a program is expected to come to where nothing says how its control plans.

use machine::Machine;
use models::Bundle;
use motion::Limits;

use crate::control::{Replanned, is_replanned};
use crate::error::Result;
use crate::expectation::{Expectation, Expected, ExpectedFigures};
use crate::input::Input;
use crate::model_based_ilc::Outcome;
use crate::part::Part;
use crate::position_terms::machine_for;
use crate::refit::RefitSettings;

/// Other controls, as ratios to the acceleration that logs reached and to the time in which it rises. Moves at a feed need not reach the acceleration of a
/// control: the excitation of `random:468`, written for 0.4 of its limits, reached 0.39. Rises are found within a third of the true ones (`Swings`).
const OTHERS: [[f64; 2]; 5] = [[3.0, 1.0], [2.0, 1.0], [1.4, 0.7], [1.0, 0.7], [1.0, 1.4]];

/// Limits with this multiple of the accelerations, and of the time in which they rise.
fn other(limits: &Limits, [acceleration, rise]: [f64; 2]) -> Limits {
    let jerk = acceleration / rise;
    let mut limits = limits.clone();
    for axis in &mut limits.axes {
        axis.acceleration *= acceleration;
        axis.jerk *= jerk;
    }
    limits.path_acceleration_mm_s2 *= acceleration;
    limits.path_jerk_mm_s3 *= jerk;
    limits.centripetal_mm_s2 *= acceleration;
    limits
}

impl Expectation {
    /// Expected figures of `outcome`, written as `content`. Where `guessed`, it is planned by limits that are known from logs alone: the bounds then reach as
    /// far as those of controls that accelerate more, or whose acceleration rises faster or slower. Also returns whether they do.
    ///
    /// # Errors
    /// As [`Self::of`], and when the model cannot run a plan.
    pub fn of_written(
        bundle: &Bundle,
        input: &Input,
        outcome: &Outcome,
        content: &[u8],
        guessed: bool,
    ) -> Result<(Option<Self>, bool)> {
        let expected = Self::of(bundle, input, &outcome.reference, &outcome.forecast)?;
        match (expected, input.part()) {
            (Some(expected), Some(part)) if guessed => {
                let (bounds, covers) = expected.of_any_plan(bundle, part, content)?;
                Ok((Some(bounds), covers))
            }
            _ => Ok((expected, false)),
        }
    }

    /// The same for any control that plans `part`, written as `content`, and whether one of them can. The median stays.
    fn of_any_plan(self, bundle: &Bundle, part: &Part, content: &[u8]) -> Result<(Self, bool)> {
        let (mut bounds, mut covers) = (self, false);
        for ratios in OTHERS {
            // A control that cannot run the program is none of those in question.
            let limits = other(&part.limits, ratios);
            let plans = || -> Result<[Part; 2]> {
                Ok([part.planned_by(part.program.bytes().to_vec(), &limits)?, part.planned_by(content.to_vec(), &limits)?])
            };
            let Ok([original, written]) = plans() else { continue };
            let Ok(replanned) = Replanned::of(&original, written) else { continue };
            let mut machine = machine_for(bundle, Some(part))?;
            machine.freeze_flags(&replanned.path()?);
            let actual = replanned.in_path_time_standing(&machine.run(&replanned.command)?)?;
            let command = replanned.in_path_time_standing(&replanned.command)?;
            let input = Input::from(original);
            if let Some(found) = Self::of(bundle, &input, &command, &actual)? {
                bounds = bounds.widened(found);
                covers = true;
            }
        }
        Ok((bounds, covers))
    }

    fn widened(self, other: Self) -> Self {
        let wide = |one: Expected, other: Expected| Expected {
            low: one.low.min(other.low),
            middle: one.middle,
            high: one.high.max(other.high),
        };
        let both = |one: ExpectedFigures, other: ExpectedFigures| ExpectedFigures {
            rms: wide(one.rms, other.rms),
            max: wide(one.max, other.max),
        };
        let direction = self.direction.map(|one| other.direction.map_or(one, |other| both(one, other)));
        Self { tip: both(self.tip, other.tip), direction }
    }
}

/// Whether nothing but logs says how a control plans the program of `input`, written with these settings.
#[must_use]
pub fn is_plan_guessed(bundle: &Bundle, input: &Input, written: Option<RefitSettings>) -> bool {
    let is_planned = |part: &Part| part.recording.is_none() && written.is_some_and(|written| is_replanned(part, written));
    is_control_unknown(bundle) && input.part().is_some_and(is_planned)
}

/// Whether nothing but logs says how the control of a model plans.
#[must_use]
pub fn is_control_unknown(bundle: &Bundle) -> bool {
    bundle.manifest.limits_from_log && bundle.manifest.control.is_none()
}
