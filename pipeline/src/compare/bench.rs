//! All methods on one path.

use compensation::Iteration;
use machine::Machine;
use models::staged::StagedPredictor;
use models::{AxisPredictor, Bundle, LearnedMachine};
use motion::Trajectory;
use rayon::prelude::*;

use super::floor::floor_runs;
use super::method::{Ilc, Method};
use super::plant::Plant;
use super::results::{KeptRun, Measured, PathComparison};
use super::settings::CompareSettings;
use super::tuning::{Tuned, ilc_correction_limits, probe, run_ilc};
use crate::error::Result;
use crate::input::Input;
use crate::model_based_ilc::{LawName, Settings, model_based_ilc, on_learned_machine, on_machine};
use crate::progress::{SILENT, Steps};
use crate::refine::{RefineSettings, refine};

/// Data that all paths share.
pub(super) struct Bench<'a> {
    pub(super) plant: Plant<'a>,
    pub(super) bundle: Option<&'a Bundle>,
    pub(super) settings: &'a CompareSettings,
    pub(super) tuned: &'a Tuned,
    pub(super) steps: Steps<'a>,
}

/// Results of one noise seed on a path.
#[derive(Default)]
struct Seed {
    measured: Vec<(Method, Measured)>,
    learning: Vec<(Ilc, Vec<f64>)>,
    runs: Vec<KeptRun>,
}

impl Bench<'_> {
    pub(super) fn path(&self, path: &Input) -> Result<PathComparison> {
        let references = self.references(path)?;
        let seeds = (0..self.settings.seeds).into_par_iter().map(|seed| self.seed(path, &references, seed));
        let streams_part = path.part().is_some();
        let mut result = PathComparison { streams_part, ..PathComparison::empty(path.name(), path.desired()) };
        for (index, seed) in seeds.collect::<Result<Vec<_>>>()?.into_iter().enumerate() {
            for (method, measured) in seed.measured {
                result.push(method, &measured);
            }
            if index == 0 {
                result.learning = seed.learning.iter().map(|(law, rms)| (*law, vec![0.0; rms.len()])).collect();
                result.runs = seed.runs;
            }
            for ((_, sums), (_, rms)) in result.learning.iter_mut().zip(&seed.learning) {
                sums.iter_mut().zip(rms).for_each(|(sum, rms)| *sum += rms / self.settings.seeds as f64);
            }
        }
        result.insert_best_ilc();
        Ok(result)
    }

    /// References that do not depend on runs of the machine.
    fn references(&self, path: &Input) -> Result<Vec<(Method, Trajectory)>> {
        let mut references = vec![(Method::Uncompensated, path.trajectory().clone())];
        let Some(bundle) = self.bundle else { return Ok(references) };
        let given = &self.settings.learning;
        if let Some(mut machine) = self.plant.noise_free(self.settings.simulation)? {
            references.push((Method::PerfectModel, on_machine(&mut machine, path, given)?.reference));
        }
        let learned = |law: LawName| -> Result<Trajectory> {
            self.steps.at(&format!("{}: learning on the model", path.name()))?;
            let settings = Settings { law, ..*given };
            Ok(model_based_ilc(path, bundle, &settings, SILENT)?.reference)
        };
        if let Some(mut linear) = linear_machine(bundle)? {
            let inverse = on_learned_machine(path, &mut linear, &bundle.coverage(), given, 0.0, SILENT)?;
            references.push((Method::LinearInverse, inverse.reference));
        }
        references.push((Method::OneShot, learned(LawName::OneShot)?));
        references.push((Method::FirstRun, learned(given.law)?));
        Ok(references)
    }

    /// Every method on the machine of one noise seed.
    fn seed(&self, path: &Input, references: &[(Method, Trajectory)], index: u64) -> Result<Seed> {
        let desired = path.desired();
        let mut machine = self.plant.machine(self.settings.noise_seed(index), self.settings.simulation)?;
        let machine = machine.as_mut();
        let mut seed = Seed::default();
        let mut uncompensated = None;
        for (method, reference) in references {
            let actual = machine.run(reference)?;
            seed.measured.push((*method, Measured::of(path, &actual)?));
            if *method == Method::FirstRun {
                let refined = self.refined(path, reference, &actual)?;
                seed.measured.push((Method::Refined, Measured::of(path, &machine.run(&refined)?)?));
            }
            if PICTURED.contains(method) {
                seed.runs.push(KeptRun { name: method.name(), reference: reference.clone(), actual: actual.clone() });
            }
            if *method == Method::Uncompensated {
                uncompensated = Some(actual);
            }
        }
        let uncompensated = uncompensated.unwrap_or_else(|| desired.trajectory().clone());
        self.learning_laws(path, machine, &uncompensated, &mut seed)?;
        for figures in floor_runs(machine, desired, path.part())? {
            seed.measured.push((Method::Floor, Measured { figures, max_sample: 0, seconds: None }));
        }
        self.steps.step(path.name())?;
        Ok(seed)
    }

    /// Runs every ILC law on the machine.
    fn learning_laws(&self, path: &Input, machine: &mut dyn Machine, uncompensated: &Trajectory, seed: &mut Seed) -> Result<()> {
        let desired = path.desired();
        let responses = probe(machine, desired)?;
        for law in self.plant.laws()? {
            let Some(settings) = self.tuned.of(law) else { continue };
            self.steps.at(&format!("{}: {}", path.name(), law.name()))?;
            let correction_limits = ilc_correction_limits(desired, path.limits(), uncompensated, settings)?;
            let mut learner = settings.law(law, desired.trajectory().period_s(), &responses)?;
            let runs = run_ilc(machine, learner.as_mut(), desired, &correction_limits, self.settings.ilc_runs)?;
            let Some(last) = runs.last() else { continue };
            seed.measured.push((Method::Ilc(law), Measured::of(path, &last.actual)?));
            let rms = |run: &Iteration| Ok(path.figures(&run.actual)?.tip.rms_mm);
            seed.learning.push((law, runs.iter().map(rms).collect::<Result<_>>()?));
            if law == Ilc::Spatial {
                seed.runs.push(KeptRun { name: law.name(), reference: last.reference.clone(), actual: last.actual.clone() });
            }
        }
        Ok(())
    }

    /// Reference of the second run, computed from the first run's log like `precomp refine --run 2`.
    pub(super) fn refined(&self, path: &Input, reference: &Trajectory, actual: &Trajectory) -> Result<Trajectory> {
        let Settings { max_shift, max_rotation_rad, .. } = self.settings.learning;
        let settings = RefineSettings { max_shift, max_rotation_rad, ..RefineSettings::of_run(2) };
        Ok(refine(path, reference, actual, &settings)?.reference)
    }
}

/// Methods whose runs are kept for plots, beside spatial ILC.
const PICTURED: [Method; 2] = [Method::Uncompensated, Method::FirstRun];

/// Machine of the first, linear stage of a grey-box model; `None` for other models.
fn linear_machine(bundle: &Bundle) -> Result<Option<LearnedMachine>> {
    let mut linear: Vec<Box<dyn AxisPredictor>> = Vec::new();
    for predictor in bundle.predictors()? {
        if predictor.kind() != models::staged::KIND {
            return Ok(None);
        }
        let staged = StagedPredictor::from_saved(&predictor.save())?;
        linear.push(Box::new(staged.linear_part()));
    }
    Ok(Some(LearnedMachine::new(bundle.manifest.period_s, bundle.axes(), linear)?))
}
