//! The comparison: every method on the same unseen paths, against the true path, with the repeatability floor.

use std::sync::Arc;

use anyhow::Result;
use compensation::laws::{Gain, SpatialIlc, TrackingIlc};
use compensation::{CompensationLaw, Guard, ImpulseResponse, LowPass, StopRule, learn};
use machine::{Machine, MachineSpec, SimulationOptions};
use models::staged::StagedPredictor;
use models::{AxisPredictor, Bundle, LearnedMachine};
use motion::{DesiredPath, Limits, Trajectory};
use serde_json::{Map, Value, json};

use crate::evaluate;
use crate::input::{self, Input};
use crate::learning::{self, LawName, PROBE, RESPONSE_S, Settings, norm_optimal};
use crate::output::{table, um};
use crate::progress::Progress;

/// Settings of the comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompareSettings {
    /// Fresh machines (noise seeds) over which figures are averaged.
    pub seeds: u64,
    /// Learning runs of every ILC.
    pub ilc_runs: usize,
    /// Learning gain of the spatial ILC.
    pub ilc_gain: f64,
    /// Cut-off of ILC's zero-phase low-pass, Hz.
    pub ilc_low_pass_hz: f64,
    /// How the machine is simulated.
    pub simulation: SimulationOptions,
    /// Virtual learning's settings.
    pub learning: Settings,
    /// First seed.
    pub seed: u64,
}

impl Default for CompareSettings {
    fn default() -> Self {
        Self {
            seeds: 1,
            ilc_runs: 6,
            ilc_gain: 0.8,
            ilc_low_pass_hz: 100.0,
            simulation: SimulationOptions::default(),
            learning: Settings::default(),
            seed: 1,
        }
    }
}

/// What one method makes of one path, one entry a seed.
#[derive(Debug, Clone, Default)]
pub struct Figures {
    /// Root mean square of the tip's contour error over the samples of a run, mm.
    pub rms: Vec<f64>,
    /// Largest, mm.
    pub max: Vec<f64>,
    /// The same of the tool's direction, rad; empty where it does not turn.
    pub turn_rms: Vec<f64>,
    /// Largest, rad.
    pub turn_max: Vec<f64>,
}

impl Figures {
    fn push(&mut self, run: &evaluate::Figures) {
        self.rms.push(run.tip.rms_mm);
        self.max.push(run.tip.max_mm);
        if let Some(orientation) = &run.orientation {
            self.turn_rms.push(orientation.rms_rad);
            self.turn_max.push(orientation.max_rad);
        }
    }

    /// Mean RMS and mean MAX of the tip over the seeds, mm.
    #[must_use]
    pub fn mean(&self) -> (f64, f64) {
        (mean(&self.rms), mean(&self.max))
    }

    /// Mean RMS and mean MAX of the tool's direction over the seeds, rad, where it turns.
    #[must_use]
    pub fn mean_turn(&self) -> Option<(f64, f64)> {
        (!self.turn_rms.is_empty()).then(|| (mean(&self.turn_rms), mean(&self.turn_max)))
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn spread(values: &[f64]) -> f64 {
    let m = mean(values);
    (values.iter().map(|v| (v - m).powi(2)).sum::<f64>() / (values.len().max(2) - 1) as f64).sqrt()
}

/// Everything measured on one path.
#[derive(Debug)]
pub struct PathComparison {
    /// Name of the path.
    pub name: String,
    /// Method and figures, in the order of the table.
    pub methods: Vec<(&'static str, Figures)>,
    /// RMS of every ILC run, mean over the seeds; the first run is uncompensated.
    pub ilc_rms: Vec<f64>,
    /// The path.
    pub desired: DesiredPath,
    /// Runs of the first seed, for pictures: name and actual positions.
    pub runs: Vec<(&'static str, Trajectory)>,
}

/// Names of the methods in tables and JSON.
pub mod method {
    /// The desired path as reference.
    pub const UNCOMPENSATED: &str = "uncompensated";
    /// Virtual learning on the linear law of the model alone: what inverting the servo's linear response gives.
    pub const LINEAR_INVERSE: &str = "linear-inverse";
    /// Paper D's law on the model's prediction.
    pub const ONE_SHOT: &str = "one-shot";
    /// Virtual learning on the noise-free machine itself, then one run: what a perfect model would give.
    pub const PERFECT_MODEL: &str = "perfect-model";
    /// Virtual learning on the model, then one run.
    pub const FIRST_RUN: &str = "first-run";
    /// The same after one more run: half of what the first run's log shows is taken off (`precomp refine --run 2`).
    pub const REFINED: &str = "first-run-refined";
    /// Spatial ILC on the machine, after its learning runs.
    pub const SPATIAL_ILC: &str = "spatial-ilc";
    /// Spatial ILC with gain 1/j.
    pub const DECREASING_ILC: &str = "spatial-ilc-decreasing";
    /// Every axis's tracking error learned in time.
    pub const TRACKING_ILC: &str = "tracking-ilc";
    /// Norm-optimal ILC of every axis (Paper E, `a = 0`).
    pub const NORM_OPTIMAL_ILC: &str = "norm-optimal-ilc";
    /// Norm-optimal ILC of the contour error alone (Paper E, `a = 1`).
    pub const CROSS_COUPLED_ILC: &str = "cross-coupled-ilc";
    /// A run around the mean of runs: what no method can beat.
    pub const FLOOR: &str = "floor";
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

    /// The machine with noise of its own for every seed.
    fn machine(self, seed: u64, options: SimulationOptions) -> Result<Box<dyn Machine>> {
        Ok(match self {
            Self::Simulated(spec) => Box::new(input::simulated(spec, seed)?.with_options(options)?),
            Self::Learned(bundle) => Box::new(bundle.machine()?),
        })
    }
}

/// Measures every method on `paths`, run on `plant`; with a model also the methods that need one.
///
/// # Errors
/// When a path does not fit machine or model.
pub fn compare(
    paths: &[Input],
    plant: Plant<'_>,
    bundle: Option<&Bundle>,
    settings: &CompareSettings,
) -> Result<Vec<PathComparison>> {
    let limits = plant.limits()?;
    let mut progress = Progress::new("comparing", paths.len() as u64 * settings.seeds);
    let mut results = Vec::with_capacity(paths.len());
    for path in paths {
        let desired = &path.desired;
        let mut references: Vec<(&'static str, Trajectory)> = vec![(method::UNCOMPENSATED, desired.trajectory().clone())];
        if let Some(bundle) = bundle {
            let learned = |law: LawName| -> Result<Trajectory> {
                let settings = Settings { law, ..settings.learning };
                Ok(learning::compensate_with(bundle, &limits, desired, path.part.as_ref(), &settings)?.reference)
            };
            if let Some(mut linear) = linear_machine(bundle)? {
                let inverse = learning::compensate(
                    &mut linear,
                    &bundle.coverage(),
                    Some(&limits),
                    desired,
                    path.part.as_ref(),
                    &settings.learning,
                )?;
                references.push((method::LINEAR_INVERSE, inverse.reference));
            }
            references.push((method::ONE_SHOT, learned(LawName::OneShot)?));
            references.push((method::FIRST_RUN, learned(settings.learning.law)?));
        }
        if let (Plant::Simulated(spec), None) = (plant, &path.part) {
            let quiet = SimulationOptions { noise_scale: 0.0, ..settings.simulation };
            let mut machine = input::simulated(spec, 0)?.with_options(quiet)?;
            let reference = learning::on_machine(&mut machine, &limits, desired, &settings.learning)?;
            references.push((method::PERFECT_MODEL, reference));
        }
        let mut result = PathComparison {
            name: path.name.clone(),
            methods: Vec::new(),
            ilc_rms: vec![0.0; settings.ilc_runs + 1],
            desired: desired.clone(),
            runs: Vec::new(),
        };
        for seed in 0..settings.seeds {
            let mut machine = plant.machine(settings.seed.wrapping_add(1000 * (seed + 1)), settings.simulation)?;
            let machine = machine.as_mut();
            for (name, reference) in &references {
                let actual = machine.run(reference)?;
                result.push(name, &figures(path, &actual)?);
                if *name == method::FIRST_RUN {
                    let low_pass = LowPass::new(settings.ilc_low_pass_hz, desired.trajectory().period_s())?;
                    let refined = SpatialIlc::new(Gain::Constant(0.5), low_pass)?.update(desired, reference, &actual)?;
                    result.push(method::REFINED, &figures(path, &machine.run(&refined)?)?);
                }
                if seed == 0 && PICTURED.contains(name) {
                    result.runs.push((name, actual));
                }
            }
            let responses = ImpulseResponse::probe(machine, desired.trajectory(), PROBE, RESPONSE_S)?;
            for (name, mut law) in ilc_laws(settings, desired, &responses)? {
                let rounds = run_ilc(machine, law.as_mut(), desired, settings)?;
                if let Some(last) = rounds.last() {
                    result.push(name, &figures(path, last)?);
                    if name == method::SPATIAL_ILC {
                        for (sum, actual) in result.ilc_rms.iter_mut().zip(&rounds) {
                            *sum += figures(path, actual)?.tip.rms_mm / settings.seeds as f64;
                        }
                        if seed == 0 {
                            result.runs.push((name, last.clone()));
                        }
                    }
                }
            }
            result.push(method::FLOOR, &floor(machine, desired)?);
            progress.step(&path.name);
        }
        results.push(result);
    }
    Ok(results)
}

impl PathComparison {
    fn push(&mut self, name: &'static str, figures: &evaluate::Figures) {
        match self.methods.iter_mut().find(|(known, _)| *known == name) {
            Some((_, all)) => all.push(figures),
            None => {
                let mut all = Figures::default();
                all.push(figures);
                self.methods.push((name, all));
            }
        }
    }

    /// Figures of a method, where it was measured.
    #[must_use]
    pub fn of(&self, name: &str) -> Option<&Figures> {
        self.methods.iter().find(|(known, _)| *known == name).map(|(_, figures)| figures)
    }

    /// `(first − floor)/(ILC − floor)` of the RMS: below 1 the first run beats converged spatial ILC.
    #[must_use]
    pub fn gap(&self) -> Option<f64> {
        let rms = |name| self.of(name).map(|figures| figures.mean().0);
        let floor = rms(method::FLOOR)?;
        Some((rms(method::FIRST_RUN)? - floor) / (rms(method::SPATIAL_ILC)? - floor))
    }
}

/// Methods whose runs are kept for pictures, beside ILC.
const PICTURED: [&str; 2] = [method::UNCOMPENSATED, method::FIRST_RUN];

/// The machine as the first, linear pass of a staged model sees it.
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

fn figures(path: &Input, actual: &Trajectory) -> Result<evaluate::Figures> {
    evaluate::figures(&path.desired, path.part.as_ref(), actual)
}

type NamedLaw = (&'static str, Box<dyn CompensationLaw>);

fn ilc_laws(settings: &CompareSettings, desired: &DesiredPath, responses: &[ImpulseResponse]) -> Result<Vec<NamedLaw>> {
    let low_pass = LowPass::new(settings.ilc_low_pass_hz, desired.trajectory().period_s())?;
    let constant = Gain::Constant(settings.ilc_gain);
    let mut laws: Vec<NamedLaw> = vec![
        (method::SPATIAL_ILC, Box::new(SpatialIlc::new(constant, low_pass)?)),
        (method::DECREASING_ILC, Box::new(SpatialIlc::new(Gain::Decreasing, low_pass)?)),
        (method::TRACKING_ILC, Box::new(TrackingIlc::new(constant, low_pass))),
        (method::NORM_OPTIMAL_ILC, Box::new(norm_optimal(0.0, responses.to_vec())?)),
    ];
    // Across a path there is only a plane where the axes are the coordinates of the tip.
    if !desired.kinematics().turns() {
        laws.push((method::CROSS_COUPLED_ILC, Box::new(norm_optimal(1.0, responses.to_vec())?)));
    }
    Ok(laws)
}

/// Actual positions of every run, the uncompensated one first.
fn run_ilc(
    machine: &mut dyn Machine,
    law: &mut dyn CompensationLaw,
    desired: &DesiredPath,
    settings: &CompareSettings,
) -> Result<Vec<Trajectory>> {
    // Never stops early: the last run counts, whatever the noise of the one before.
    let stop = StopRule::after(settings.ilc_runs);
    let learned = learn(machine, law, desired, None, &Guard::default(), &stop, &mut |_, _| 0.0)?;
    Ok(learned.rounds.into_iter().map(|round| round.actual).collect())
}

/// Runs from which the mean path is taken.
const FLOOR_RUNS: usize = 8;

/// Contour distance of a run from the mean of runs: every figure the mean over the runs.
///
/// # Errors
/// When the machine does not run the path.
pub fn floor(machine: &mut dyn Machine, desired: &DesiredPath) -> Result<evaluate::Figures> {
    let reference = desired.trajectory();
    let runs: Vec<Trajectory> = (0..FLOOR_RUNS).map(|_| machine.run(reference)).collect::<Result<_, _>>()?;
    let mean = |axis: usize| -> Vec<f64> {
        (0..reference.len()).map(|k| runs.iter().map(|run| run.columns()[axis][k]).sum::<f64>() / FLOOR_RUNS as f64).collect()
    };
    let mean = reference.with_columns((0..reference.axes().len()).map(mean).collect())?;
    let path = DesiredPath::new(mean, Arc::clone(desired.kinematics()))?;
    let figures: Vec<evaluate::Figures> = runs.iter().map(|run| evaluate::figures(&path, None, run)).collect::<Result<_>>()?;
    let mut floor = evaluate::Figures::mean(&figures).ok_or_else(|| anyhow::anyhow!("the floor needs runs"))?;
    // A run around a mean of n runs that contains it is √((n−1)/n) of one around the true mean.
    let unbias = (FLOOR_RUNS as f64 / (FLOOR_RUNS - 1) as f64).sqrt();
    floor.tip.rms_mm *= unbias;
    floor.tip.max_mm *= unbias;
    if let Some(orientation) = &mut floor.orientation {
        orientation.rms_rad *= unbias;
        orientation.max_rad *= unbias;
    }
    Ok(floor)
}

/// The table: a row a method, RMS and MAX in µm for every path and their mean.
#[must_use]
pub fn render(results: &[PathComparison], settings: &CompareSettings) -> String {
    let Some(first) = results.first() else { return String::new() };
    let mut text = rows(results, first, "tool tip, RMS / MAX, µm", |figures| Some(figures.mean()), um);
    if first.desired.kinematics().turns() {
        text.push('\n');
        text.push_str(&rows(results, first, "tool direction, RMS / MAX, µrad", Figures::mean_turn, |rad| {
            format!("{:.2}", rad * 1e6)
        }));
    }
    text.push_str(&format!(
        "\nILC: gain {}, zero-phase low-pass {} Hz, {} learning runs on the machine (decreasing: gain 1, 1/2, 1/3 …); {} noise seed(s)",
        settings.ilc_gain, settings.ilc_low_pass_hz, settings.ilc_runs, settings.seeds
    ));
    let gaps: Vec<f64> = results.iter().filter_map(PathComparison::gap).collect();
    if !gaps.is_empty() {
        text.push_str(&format!("\ngap (first run − floor)/(spatial ILC − floor): {:.2} on the mean of the paths", mean(&gaps)));
    }
    text
}

fn rows(
    results: &[PathComparison],
    first: &PathComparison,
    title: &str,
    of: impl Fn(&Figures) -> Option<(f64, f64)>,
    show: impl Fn(f64) -> String,
) -> String {
    let mut header = vec![title.to_owned()];
    header.extend(results.iter().map(|result| result.name.clone()));
    header.push("mean".to_owned());
    let cell = |(rms, max): (f64, f64)| format!("{} / {}", show(rms), show(max));
    let rows: Vec<Vec<String>> = first
        .methods
        .iter()
        .map(|(name, _)| {
            let all: Vec<(f64, f64)> = results.iter().filter_map(|result| of(result.of(name)?)).collect();
            let count = all.len().max(1) as f64;
            let mean = all.iter().fold((0.0, 0.0), |sum, f| (sum.0 + f.0 / count, sum.1 + f.1 / count));
            std::iter::once((*name).to_owned()).chain(all.iter().map(|f| cell(*f))).chain([cell(mean)]).collect()
        })
        .collect();
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    table(&header, &rows)
}

/// The figures as JSON, by path and method.
#[must_use]
pub fn json(results: &[PathComparison], settings: &CompareSettings) -> Value {
    let paths: Vec<Value> = results
        .iter()
        .map(|result| {
            let methods: Map<String, Value> = result
                .methods
                .iter()
                .map(|(name, figures)| {
                    let (rms, max) = figures.mean();
                    let mut entry = json!({
                        "rms_um": rms * 1e3,
                        "max_um": max * 1e3,
                        "rms_spread_um": spread(&figures.rms) * 1e3,
                        "max_spread_um": spread(&figures.max) * 1e3,
                    });
                    if let Some((rms, max)) = figures.mean_turn() {
                        entry["orientation_rms_urad"] = json!(rms * 1e6);
                        entry["orientation_max_urad"] = json!(max * 1e6);
                    }
                    if name.contains("ilc") {
                        entry["runs"] = json!(settings.ilc_runs);
                    }
                    ((*name).to_owned(), entry)
                })
                .collect();
            let by_run: Vec<f64> = result.ilc_rms.iter().map(|rms| rms * 1e3).collect();
            json!({ "name": result.name, "methods": methods, "gap": result.gap(), "spatial_ilc_rms_by_run_um": by_run })
        })
        .collect();
    json!({
        "seeds": settings.seeds,
        "ilc": { "gain": settings.ilc_gain, "low_pass_hz": settings.ilc_low_pass_hz, "runs": settings.ilc_runs },
        "paths": paths,
    })
}
