//! A servo model below the least-squares stages, where it lowers the error on held-out runs.

use models::staged::{ServoBase, StagedPredictor};
use servo::{Fit, Free, Record, Run};

use super::fit::{fit, fit_on};
use super::recipe::StagedRecipe;
use super::report::StagedReport;
use crate::{AxisRun, TrainingError};

/// Lever arm on which a rotary axis is treated as a linear one, mm.
const LEVER_MM: f64 = 100.0;
/// Time over which the errors of a fitted servo model are correlated, s: friction levels drift over seconds, loops settle in a tenth of one.
const CORRELATED_S: f64 = 0.25;

/// A servo model fitted to runs of an axis.
#[derive(Debug, Clone)]
pub struct ServoFit {
    fit: Fit,
    mm_per_unit: f64,
    /// Time of the samples that it was fitted to, s.
    fitted_s: f64,
}

impl ServoFit {
    /// The models whose structure and parameters follow the runs of each axis of a machine best, with whether it is rotary; `None` where none does.
    /// The axes have one control.
    #[must_use]
    pub fn identify_all(axes: &[(Vec<AxisRun>, bool)]) -> Vec<Option<Self>> {
        let mm_per_unit = |rotary: bool| if rotary { LEVER_MM } else { 1.0 };
        let of = |(runs, rotary): &(Vec<AxisRun>, bool)| record(runs, mm_per_unit(*rotary));
        let records: Vec<Option<Record>> = axes.iter().map(of).collect();
        let (indices, known): (Vec<usize>, Vec<Record>) =
            records.into_iter().enumerate().filter_map(|(index, record)| Some((index, record?))).unzip();
        let mut found = vec![None; axes.len()];
        // The backlash has to pay for itself: a log does not say where its sensor is.
        for ((index, fit), record) in indices.into_iter().zip(servo::identify_all(&known)).zip(&known) {
            let mm_per_unit = mm_per_unit(axes[index].1);
            found[index] = fit.map(|fit| Self { fit, mm_per_unit, fitted_s: record.fitted_s() });
        }
        found
    }

    /// The same structure fitted to other runs of the axis; `None` where it does not follow them.
    #[must_use]
    pub fn refit(&self, runs: &[AxisRun]) -> Option<Self> {
        let record = record(runs, self.mm_per_unit)?;
        let fit = servo::refit(&self.fit, &record)?;
        Some(Self { fit, fitted_s: record.fitted_s(), ..*self })
    }

    /// The model, as a base of the stages.
    #[must_use]
    pub fn base(&self) -> ServoBase {
        ServoBase { servo: self.fit.servo, mm_per_unit: self.mm_per_unit }
    }

    /// Ratio of the RMS error on other runs to that on those of the fit: as the fit has measured it, else `√((n + p)/(n − p))` of `p`
    /// parameters and `n` independent samples (final prediction error, Akaike 1970).
    #[must_use]
    pub fn optimism(&self) -> f64 {
        if let Some(measured) = self.fit.optimism {
            return measured;
        }
        let independent = self.fitted_s / CORRELATED_S;
        let parameters = self.fit.effective.min(0.5 * independent);
        ((independent + parameters) / (independent - parameters)).sqrt()
    }
}

/// The model with gains and friction of these runs, and all else as it is; `None` where it does not follow them.
pub fn refitted(base: &ServoBase, runs: &[AxisRun]) -> Option<ServoBase> {
    use servo::index::{BANDWIDTH, COULOMB, GAIN, INTEGRAL, LOOP_LAG, POSITION_INTEGRAL};
    let record = record(runs, base.mm_per_unit)?;
    let mut free = Free(vec![GAIN, LOOP_LAG, BANDWIDTH, COULOMB]);
    if base.servo.integral > 0.0 {
        free = free.with([INTEGRAL]);
    }
    if base.servo.position_integral_1_s > 0.0 {
        free = free.with([POSITION_INTEGRAL]);
    }
    Some(ServoBase { servo: servo::fit(base.servo, &record, &free, None)?.servo, ..*base })
}

fn record(runs: &[AxisRun], mm_per_unit: f64) -> Option<Record> {
    let scaled = |column: &[f64]| column.iter().map(|x| x * mm_per_unit).collect();
    let run =
        |run: &AxisRun| Run { reference: scaled(&run.reference), actual: scaled(&run.actual), start: None, rows: run.scored() };
    let period_s = runs.first()?.period_s;
    let runs: Vec<Run> = runs.iter().filter(|run| run.reference.len() == run.actual.len()).map(run).collect();
    let finite = runs.iter().all(|run| run.reference.iter().chain(&run.actual).all(|x| x.is_finite()));
    finite.then_some(Record { period_s, runs })
}

/// The stages on the reference, or on the servo model where that is better on held-out runs, and whether it is.
///
/// # Errors
/// As [`fit`].
pub fn fit_best(
    runs: &[AxisRun],
    servo: Option<&ServoFit>,
    recipe: &StagedRecipe,
) -> Result<(StagedPredictor, StagedReport, bool), TrainingError> {
    let (plain, report) = fit(runs, recipe)?;
    let Some(servo) = servo else { return Ok((plain, report, false)) };
    // What a servo model leaves is short, or has the memory of the whole where the model misses something.
    let whole_s = report.window_s.0 / recipe.memories;
    let chosen = recipe.memory_s.iter().copied().min_by(|a, b| (a - whole_s).abs().total_cmp(&(b - whole_s).abs()));
    let mut memory_s: Vec<f64> = recipe.memory_s.first().copied().into_iter().chain(chosen).collect();
    memory_s.dedup();
    let shorter = StagedRecipe { memory_s, ..recipe.clone() };
    let Ok((predictor, mut on_servo)) = fit_on(runs, Some(&servo.base()), &shorter) else { return Ok((plain, report, false)) };
    on_servo.stages.iter_mut().for_each(|stage| stage.held_out_rms *= servo.optimism());
    let is_better = match (on_servo.held_out_rms(), report.held_out_rms()) {
        (Some(mine), Some(theirs)) => mine < theirs,
        _ => false,
    };
    Ok(if is_better { (predictor, on_servo, true) } else { (plain, report, false) })
}
