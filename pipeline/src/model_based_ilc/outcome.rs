//! Result of model-based ILC.

use std::path::Path;

use compensation::Ended;
use motion::Trajectory;

use super::gain::WithoutGain;
use super::outside::OutsideRange;
use crate::error::Result;
use crate::input::Input;
use crate::output::{Output, OutputSettings};
use crate::refit::{Mark, RefitSettings};
use crate::statistics::Figures;

/// Result of model-based ILC.
#[derive(Debug)]
pub struct Outcome {
    /// Computed reference; the desired path itself where nothing is gained.
    pub reference: Trajectory,
    /// Predicted actual positions for `reference`.
    pub forecast: Trajectory,
    /// Predicted actual positions without compensation.
    pub uncompensated: Trajectory,
    /// Bound of the correction of the tool tip, mm.
    pub max_shift: f64,
    /// Predicted figures without compensation, against the path that the program is compensated for.
    pub before: Figures,
    /// Predicted figures with `reference`, against the same.
    pub after: Figures,
    /// Both figures against the planned path of the program, where corners are to stay as they were recorded.
    pub of_program: Option<[Figures; 2]>,
    /// Number of updates.
    pub updates: usize,
    /// Reason why the iteration on the reference ended; `None` for the papers' laws and where no Gauss–Newton steps are
    /// made.
    pub ended: Option<Ended>,
    /// Whether the predicted gain is large enough for the path to be changed.
    pub gained: bool,
    /// Predicted cycle time before and after, s, of a replanned program; `None` where the control takes the reference.
    pub cycle_s: Option<(f64, f64)>,
    /// Relative increase of the cycle time by timed points, where it is too large and the program therefore keeps its
    /// feeds.
    pub kept_feeds: Option<f64>,
    /// Least relative increase of the cycle time that was found, where it is beyond its limit whatever the points; nothing is changed then.
    pub too_slow: Option<f64>,
    /// Points of the written program, where they were chosen by the forecast of the replanned program.
    pub written: Option<RefitSettings>,
    /// Segments of a program that are not changed, because the forecast gains nothing by it.
    pub without_gain: Vec<WithoutGain>,
    /// Where the largest error is that is left, if beside a move that is not changed.
    pub beside_unchanged: Option<BesideUnchanged>,
    /// Expected RMS without and with compensation, mm, where the model's own error grows by more than the forecast gains; nothing is changed then.
    pub uncertain_mm: Option<[f64; 2]>,
    /// Path ranges outside the operating range of the model.
    pub outside: Vec<OutsideRange>,
    /// Comment at the head of the written program; `None` where no model file was involved.
    pub mark: Option<Mark>,
}

/// The largest predicted error of a compensated program, where it is beside a rapid or another move that is not changed: no correction reaches it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BesideUnchanged {
    /// Program line, from 1.
    pub line: usize,
    /// Largest error, mm.
    pub max_mm: f64,
    /// Largest error elsewhere, mm.
    pub elsewhere_mm: f64,
}

impl Outcome {
    /// The outcome that changes nothing, for this expected RMS without and with compensation.
    pub(super) fn unchanged(self, input: &Input, expected_mm: [f64; 2]) -> Self {
        Self {
            reference: input.trajectory().clone(),
            forecast: self.uncompensated.clone(),
            after: self.before,
            of_program: self.of_program.map(|[before, _]| [before; 2]),
            gained: false,
            cycle_s: None,
            written: None,
            without_gain: Vec::new(),
            beside_unchanged: None,
            uncertain_mm: Some(expected_mm),
            ..self
        }
    }

    /// Predicted figures without and with compensation, against the planned path of the program.
    #[must_use]
    pub fn figures(&self) -> [Figures; 2] {
        self.of_program.unwrap_or([self.before, self.after])
    }

    /// Writes the reference for the `input` that it was computed for: refits, edits and verifies the program, marks it so that
    /// [`Input::check_original`] recognises it, and takes the points of [`Outcome::written`].
    ///
    /// `format` has to be the one whose [`OutputSettings::program`] was given as `Settings::written`. The extension of `name` selects the
    /// format of a reference: `.csv` or `.parquet`.
    ///
    /// # Errors
    /// As [`Input::write`].
    pub fn write(&self, input: &Input, format: &OutputSettings, name: &Path) -> Result<Output> {
        let mut format = match &self.mark {
            Some(mark) => format.clone().marked(mark.clone()),
            None => format.clone(),
        };
        if let Some(written) = self.written {
            format = format.with_points(written);
        }
        input.write(&self.reference, &format, self.max_shift, name)
    }
}
