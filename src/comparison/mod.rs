//! The comparison: every method on the same unseen paths, against the true path, with the repeatability floor.

mod method;
mod programs;
mod render;
mod results;
mod tuning;

use std::sync::{Arc, Mutex};

use anyhow::Result;
use compensation::laws::{Gain, SpatialIlc};
use compensation::{CompensationLaw, Guard, LowPass};
use machine::{Machine, MachineSpec, SimulationOptions};
use models::staged::StagedPredictor;
use models::{AxisPredictor, Bundle, LearnedMachine};
use motion::{DesiredPath, Limits, Trajectory};
use rayon::prelude::*;

use crate::evaluate;
use crate::input::{self, Frame, Input};
use crate::learning::{self, FADE_S, LawName, Settings};
use crate::pipeline::Part;
use crate::progress::Progress;

use results::{Measured, mean, spread};

pub use method::{Ilc, Method};
pub use programs::compare_programs;
pub use render::{json, programs_json, render, render_programs};
pub use results::{BestIlc, Figures, PathComparison, gap};
pub use tuning::{LawSettings, Tuned};

/// The curves that are compared when none is named. No excitation holds them, and no setting of the product was chosen by them: settings are
/// developed on Paper D's curves ([`PAPER_D`]).
pub const UNSEEN: [&str; 4] = ["nurbs-2", "nurbs-3", "polygon-5", "spiral-6mm"];
/// The same on a machine that turns tool or workpiece (Paper C).
pub const UNSEEN_TURNED: [&str; 2] = ["saddle", "saddle-butterfly"];
/// The curves of Paper D's tables IV to VI.
pub const PAPER_D: [&str; 4] = ["crown", "spiral", "flower", "nurbs-1"];

/// Feed of built-in curves, mm/s: Paper D's.
pub const FEED_MM_S: f64 = 80.0;

/// Settings of the comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompareSettings {
    /// Fresh machines (noise seeds) over which figures are averaged.
    pub seeds: u64,
    /// Learning runs of every ILC; the last one counts. The papers take 5 to 8.
    pub ilc_runs: usize,
    /// Learning gain of laws with a constant one; tuned on the machine when `None`.
    pub ilc_gain: Option<f64>,
    /// Cut-off of ILC's zero-phase low-pass, Hz; tuned on the machine when `None`.
    pub ilc_low_pass_hz: Option<f64>,
    /// How the machine is simulated.
    pub simulation: SimulationOptions,
    /// Settings of model-based ILC.
    pub learning: Settings,
    /// First seed.
    pub seed: u64,
}

impl Default for CompareSettings {
    fn default() -> Self {
        Self {
            seeds: 1,
            ilc_runs: 8,
            ilc_gain: None,
            ilc_low_pass_hz: None,
            simulation: SimulationOptions::default(),
            learning: Settings::default(),
            seed: 1,
        }
    }
}

impl CompareSettings {
    /// Seed of the noise of one of [`CompareSettings::seeds`] machines; training's and the tuning's seeds are others.
    #[must_use]
    pub fn noise_seed(&self, index: u64) -> u64 {
        self.seed.wrapping_add(1000 * (index + 1))
    }
}

/// The comparison of all paths.
#[derive(Debug)]
pub struct Comparison {
    /// One entry a path.
    pub paths: Vec<PathComparison>,
    /// The settings that every ILC got.
    pub tuned: Tuned,
}

/// What the methods run on.
#[derive(Debug, Clone, Copy)]
pub enum Plant<'a> {
    /// The simulated machine of a description.
    Simulated(&'a MachineSpec),
    /// What a model makes of a machine that is not at hand; it repeats itself exactly.
    Learned(&'a Bundle),
}

impl Plant<'_> {
    fn limits(self) -> Result<Limits> {
        Ok(match self {
            Self::Simulated(spec) => spec.limits(),
            Self::Learned(bundle) => input::machine_of(bundle)?.limits(),
        })
    }

    fn frame(self) -> Result<Frame> {
        match self {
            Self::Simulated(spec) => Frame::of(spec),
            Self::Learned(bundle) => Frame::of(&input::machine_of(bundle)?),
        }
    }

    /// The machine with noise of its own for every seed.
    fn machine(self, seed: u64, options: SimulationOptions) -> Result<Box<dyn Machine>> {
        Ok(match self {
            Self::Simulated(spec) => Box::new(input::simulated(spec, seed)?.with_options(options)?),
            Self::Learned(bundle) => Box::new(bundle.machine()?),
        })
    }

    /// The laws that can learn on it. Across a path there is only a plane where the axes are the coordinates of the tip.
    fn laws(self) -> Result<Vec<Ilc>> {
        let turns = self.frame()?.kinematics.turns();
        Ok(Ilc::ALL.into_iter().filter(|law| !(turns && *law == Ilc::CrossCoupled)).collect())
    }
}

/// Measures every method on `paths`, run on `plant`; with a model also the methods that need one. ILC is tuned on the machine before.
///
/// # Errors
/// When a path does not fit machine or model, or ILC cannot be tuned.
pub fn compare(paths: &[Input], plant: Plant<'_>, bundle: Option<&Bundle>, settings: &CompareSettings) -> Result<Comparison> {
    let tuned = Tuned::on(plant, &plant.laws()?, &plant.frame()?, settings)?;
    let paths = compare_tuned(paths, plant, bundle, settings, &tuned)?;
    Ok(Comparison { paths, tuned })
}

/// As [`compare`], with the settings of every ILC given.
///
/// # Errors
/// As [`compare`].
pub fn compare_tuned(
    paths: &[Input],
    plant: Plant<'_>,
    bundle: Option<&Bundle>,
    settings: &CompareSettings,
    tuned: &Tuned,
) -> Result<Vec<PathComparison>> {
    let progress = Mutex::new(Progress::new("comparing", paths.len() as u64 * settings.seeds));
    let bench = Bench { plant, bundle, settings, tuned, limits: plant.limits()?, progress };
    paths.par_iter().map(|path| bench.path(path)).collect()
}

/// What every path is measured with.
struct Bench<'a> {
    plant: Plant<'a>,
    bundle: Option<&'a Bundle>,
    settings: &'a CompareSettings,
    tuned: &'a Tuned,
    limits: Limits,
    progress: Mutex<Progress>,
}

/// What one seed's machine made of a path.
#[derive(Default)]
struct Seed {
    measured: Vec<(Method, Measured)>,
    ilc_rms: Vec<f64>,
    runs: Vec<(&'static str, Trajectory)>,
}

impl Bench<'_> {
    /// Shows how far the comparison is.
    fn tell(&self, show: impl FnOnce(&mut Progress)) {
        if let Ok(mut progress) = self.progress.lock() {
            show(&mut progress);
        }
    }

    fn path(&self, path: &Input) -> Result<PathComparison> {
        let references = self.references(path)?;
        let seeds = (0..self.settings.seeds).into_par_iter().map(|seed| self.seed(path, &references, seed));
        let mut result = PathComparison::empty(&path.name, &path.desired);
        for (index, seed) in seeds.collect::<Result<Vec<_>>>()?.into_iter().enumerate() {
            for (method, measured) in seed.measured {
                result.push(method, &measured);
            }
            result.ilc_rms.resize(seed.ilc_rms.len(), 0.0);
            for (sum, rms) in result.ilc_rms.iter_mut().zip(seed.ilc_rms) {
                *sum += rms / self.settings.seeds as f64;
            }
            if index == 0 {
                result.runs = seed.runs;
            }
        }
        result.insert_best_ilc();
        Ok(result)
    }

    /// The references that are known before the machine runs.
    fn references(&self, path: &Input) -> Result<Vec<(Method, Trajectory)>> {
        let Input { desired, part, .. } = path;
        let mut references = vec![(Method::Uncompensated, desired.trajectory().clone())];
        let Some(bundle) = self.bundle else { return Ok(references) };
        let given = &self.settings.learning;
        if let (Plant::Simulated(spec), None) = (self.plant, part) {
            let quiet = SimulationOptions { noise_scale: 0.0, ..self.settings.simulation };
            let mut machine = input::simulated(spec, 0)?.with_options(quiet)?;
            references.push((Method::PerfectModel, learning::on_machine(&mut machine, &self.limits, desired, given)?));
        }
        let learned = |law: LawName| -> Result<Trajectory> {
            self.tell(|progress| progress.at(&format!("{}: learning on the model", path.name)));
            let settings = Settings { law, ..*given };
            Ok(learning::compensate_with(bundle, &self.limits, desired, part.as_ref(), &settings)?.reference)
        };
        if let Some(mut linear) = linear_machine(bundle)? {
            let inverse =
                learning::compensate(&mut linear, &bundle.coverage(), Some(&self.limits), desired, part.as_ref(), given)?;
            references.push((Method::LinearInverse, inverse.reference));
        }
        references.push((Method::OneShot, learned(LawName::OneShot)?));
        references.push((Method::FirstRun, learned(given.law)?));
        Ok(references)
    }

    /// Every method on the machine of one noise seed.
    fn seed(&self, path: &Input, references: &[(Method, Trajectory)], index: u64) -> Result<Seed> {
        let desired = &path.desired;
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
                seed.runs.push((method.name(), actual.clone()));
            }
            if *method == Method::Uncompensated {
                uncompensated = Some(actual);
            }
        }
        let uncompensated = uncompensated.unwrap_or_else(|| desired.trajectory().clone());
        self.learning_laws(path, machine, &uncompensated, &mut seed)?;
        for figures in floor_runs(machine, desired, path.part.as_ref())? {
            seed.measured.push((Method::Floor, Measured { figures, max_sample: 0, seconds: None }));
        }
        self.tell(|progress| progress.step(&path.name));
        Ok(seed)
    }

    /// Every law that learns on the machine.
    fn learning_laws(&self, path: &Input, machine: &mut dyn Machine, uncompensated: &Trajectory, seed: &mut Seed) -> Result<()> {
        let desired = &path.desired;
        let responses = tuning::probe(machine, desired)?;
        for law in self.plant.laws()? {
            let Some(settings) = self.tuned.of(law) else { continue };
            self.tell(|progress| progress.at(&format!("{}: {}", path.name, law.name())));
            let guard = tuning::ilc_guard(desired, uncompensated, settings)?;
            let mut learner = settings.law(law, desired.trajectory().period_s(), &responses)?;
            let runs = tuning::run_ilc(machine, learner.as_mut(), desired, &guard, self.settings.ilc_runs)?;
            let Some(last) = runs.last() else { continue };
            seed.measured.push((Method::Ilc(law), Measured::of(path, last)?));
            if law == Ilc::Spatial {
                let rms = |actual: &Trajectory| Ok(evaluate::figures(desired, path.part.as_ref(), actual)?.tip.rms_mm);
                seed.ilc_rms = runs.iter().map(rms).collect::<Result<_>>()?;
                seed.runs.push((law.name(), last.clone()));
            }
        }
        Ok(())
    }

    /// The reference of the second run, as `precomp refine --run 2` makes it of the first run's log.
    fn refined(&self, path: &Input, reference: &Trajectory, actual: &Trajectory) -> Result<Trajectory> {
        let Input { desired, part, .. } = path;
        let low_pass = LowPass::new(REFINE_LOW_PASS_HZ, desired.trajectory().period_s())?;
        let next = SpatialIlc::new(Gain::Constant(REFINE_GAIN), low_pass)?.update(desired, reference, actual)?;
        let weights = part.as_ref().map(|part| part.weights(FADE_S)).unwrap_or_default();
        let Settings { max_shift, max_turn_rad, .. } = self.settings.learning;
        let bound = || -> Result<f64> {
            let before = evaluate::contour(desired, part.as_ref(), actual)?;
            Ok(learning::shift_bound(path.largest_shift(reference), before.max_mm))
        };
        let max_shift = max_shift.map_or_else(bound, Ok)?;
        let guard = Guard { max_shift, max_turn_rad, limits: Some(self.limits.clone()), weights, ..Guard::default() };
        Ok(guard.apply(desired, &next)?)
    }
}

/// Gain and cut-off of `precomp refine --run 2`.
const REFINE_GAIN: f64 = 0.5;
const REFINE_LOW_PASS_HZ: f64 = 100.0;

/// Methods whose runs are kept for pictures, beside spatial ILC.
const PICTURED: [Method; 2] = [Method::Uncompensated, Method::FirstRun];

/// The machine as the first, linear stage of a staged model sees it.
fn linear_machine(bundle: &Bundle) -> Result<Option<LearnedMachine>> {
    let mut linear: Vec<Box<dyn AxisPredictor>> = Vec::new();
    for predictor in bundle.predictors()? {
        if predictor.kind() != models::staged::KIND {
            return Ok(None);
        }
        let staged = StagedPredictor::from_saved(&predictor.save())?;
        linear.push(Box::new(StagedPredictor::new(staged.period_s(), staged.passes()[..1].to_vec())?));
    }
    Ok(Some(LearnedMachine::new(bundle.manifest.period_s, bundle.axes(), linear)?))
}

/// Runs from which the mean path is taken.
const FLOOR_RUNS: usize = 8;

/// Run-to-run repeatability, the expected error of a perfect compensation: contour error of each run against the mean of runs.
///
/// A single run, compensated or not, may lie below it; the spread of these figures says by how much.
///
/// # Errors
/// When the machine does not run the path.
fn floor_runs(machine: &mut dyn Machine, desired: &DesiredPath, part: Option<&Part>) -> Result<Vec<evaluate::Figures>> {
    let reference = desired.trajectory();
    let runs: Vec<Trajectory> = (0..FLOOR_RUNS).map(|_| machine.run(reference)).collect::<Result<_, _>>()?;
    let mean = |axis: usize| -> Vec<f64> {
        (0..reference.len()).map(|k| runs.iter().map(|run| run.columns()[axis][k]).sum::<f64>() / FLOOR_RUNS as f64).collect()
    };
    let mean = reference.with_columns((0..reference.axes().len()).map(mean).collect())?;
    let mean = DesiredPath::new(mean, Arc::clone(desired.kinematics()))?;
    // A run around a mean of n runs that contains it is √((n−1)/n) of one around the true mean.
    let unbias = (FLOOR_RUNS as f64 / (FLOOR_RUNS - 1) as f64).sqrt();
    let figures = |run: &Trajectory| -> Result<evaluate::Figures> {
        let mut floor = evaluate::figures(&mean, part, run)?;
        floor.tip.rms_mm *= unbias;
        floor.tip.max_mm *= unbias;
        if let Some(orientation) = &mut floor.orientation {
            orientation.rms_rad *= unbias;
            orientation.max_rad *= unbias;
        }
        Ok(floor)
    };
    runs.iter().map(figures).collect()
}

/// As the floor of the comparison: every figure the mean over the runs.
///
/// # Errors
/// When the machine does not run the path.
pub fn floor(machine: &mut dyn Machine, desired: &DesiredPath) -> Result<evaluate::Figures> {
    evaluate::Figures::mean(&floor_runs(machine, desired, None)?).ok_or_else(|| anyhow::anyhow!("the floor needs runs"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(figures: &[(Method, f64, f64)]) -> PathComparison {
        let spec = MachineSpec::builtin("ballscrew").unwrap();
        let desired = Input::curve("circle", FEED_MM_S, &Frame::of(&spec).unwrap()).unwrap().desired;
        let mut result = PathComparison::empty("circle", &desired);
        for (method, rms, max) in figures {
            let figures = Figures { rms: vec![*rms], max: vec![*max], max_sample: vec![7], ..Figures::default() };
            result.methods.push((*method, figures));
        }
        result.insert_best_ilc();
        result
    }

    #[test]
    fn the_best_ilc_is_the_lowest_figure_by_figure() {
        let result = path(&[
            (Method::FirstRun, 0.25, 0.9),
            (Method::Ilc(Ilc::Spatial), 0.26, 1.2),
            (Method::Ilc(Ilc::Tracking), 0.30, 0.8),
            (Method::Floor, 0.2, 0.7),
        ]);
        assert_eq!(result.best_ilc(), Some(BestIlc { rms: Ilc::Spatial, max: Ilc::Tracking }));
        assert_eq!(result.of(Method::BestIlc).unwrap().mean(), (0.26, 0.8));
        assert_eq!(result.methods[3].0, Method::BestIlc);
        let (rms, max) = result.gap();
        assert!((rms.unwrap() - 0.05 / 0.06).abs() < 1e-12 && (max.unwrap() - 2.0).abs() < 1e-12);
        // No gap is told where ILC is not above the floor.
        let below = path(&[(Method::FirstRun, 0.25, 0.9), (Method::Ilc(Ilc::Spatial), 0.2, 0.6), (Method::Floor, 0.2, 0.7)]);
        assert_eq!(below.gap(), (None, None));
    }

    #[test]
    fn the_refined_reference_is_guarded_as_refine_does() {
        let spec = MachineSpec::builtin("ballscrew").unwrap();
        let path = Input::curve("circle", FEED_MM_S, &Frame::of(&spec).unwrap()).unwrap();
        let desired = &path.desired;
        let bound = 2e-3;
        let learning = Settings { max_shift: Some(bound), ..Settings::default() };
        let settings = CompareSettings { learning, ilc_gain: Some(0.8), ilc_low_pass_hz: Some(100.0), ..Default::default() };
        let plant = Plant::Simulated(&spec);
        let tuned = Tuned::on(plant, &[], &plant.frame().unwrap(), &settings).unwrap();
        let progress = Mutex::new(Progress::new("", 1));
        let bench = Bench { plant, bundle: None, settings: &settings, tuned: &tuned, limits: spec.limits(), progress };
        // An axis that stands 1 mm off asks for half of that.
        let columns = desired.trajectory().columns().iter().map(|column| column.iter().map(|x| x + 1.0).collect());
        let actual = desired.trajectory().with_columns(columns.collect()).unwrap();
        let next = bench.refined(&path, desired.trajectory(), &actual).unwrap();
        let largest = path.largest_shift(&next);
        assert!(largest > 0.5 * bound && largest <= bound + 1e-12, "{largest}");
    }

    #[test]
    fn training_tuning_and_every_compared_seed_have_noise_of_their_own() {
        let settings = CompareSettings { seeds: 20, ..CompareSettings::default() };
        let mut seeds: Vec<u64> = (0..settings.seeds).map(|index| settings.noise_seed(index)).collect();
        seeds.extend([settings.seed, settings.seed + tuning::TUNING_SEED, settings.seed + programs::TUNING_SEED]);
        let count = seeds.len();
        seeds.sort_unstable();
        seeds.dedup();
        assert_eq!(seeds.len(), count);
    }
}
