//! Comparison on G-code programs: every reference is written as a program, and the control replans its feed profile.

use compensation::CorrectionLimits;
use machine::Machine;
use models::Bundle;
use motion::Trajectory;
use rayon::prelude::*;

use super::bench::Bench;
use super::floor::floor_runs;
use super::method::{Ilc, Method};
use super::plant::Plant;
use super::results::{Measured, PathComparison};
use super::settings::{CompareSettings, FEED_MM_S};
use super::tuning::{LawSettings, Tuned, ilc_correction_limits};
use crate::control::{MOVE_POINTS, Pairing, ProgramRun, curve_program, is_replanned, learn_program, run_program};
use crate::error::{Error, Result};
use crate::input::Input;
use crate::model_based_ilc::{Settings, model_based_ilc, on_machine};
use crate::output::OutputSettings;
use crate::part::Part;
use crate::progress::{Job, Progress, SILENT, Steps};
use crate::refit::RefitSettings;
use crate::setup::Setup;

/// Length of program lines, mm, as in a finishing path of a CAM system.
const SPACING_MM: f64 = 0.5;
/// Laws that are compared on programs. Tracking laws diverge where the control replans the time (Paper A; `precomp
/// reproduce spatial`), and norm-optimal laws need a reference that keeps its time.
const LAWS: [Ilc; 2] = [Ilc::Spatial, Ilc::SpatialDecreasing];
/// Candidate cut-offs, Hz. A control slows down for corrections above them.
const CUT_OFFS_HZ: [f64; 3] = [20.0, 40.0, 80.0];
/// Tuning curve, which no table reports.
const TUNING_CURVE: &str = "polygon-7";
/// Offset of the tuning noise seed from the first seed.
pub(super) const TUNING_SEED: u64 = 501;

/// Compares the uncompensated program, the first run, every ILC law and the floor on programs: part programs with points
/// as [`OutputSettings`] has them for the machine's control, and built-in curves as programs of short lines at 80 mm/s, whose points
/// move. Recorded references have no program and are left out.
///
/// Gains are those of `tuned`. The cut-off of every law is that of `CUT_OFFS_HZ` or `tuned` with the lowest cost of the
/// last run on the program of another curve with another noise seed. On part programs a law learns with these points and with
/// those of the program alone, and the lower cost counts. It keeps the moves that a compensated program keeps, but no limit of the cycle time.
///
/// # Errors
/// When a curve cannot be planned on the machine, a program cannot be written, or it states the times of its lines.
pub fn compare_programs(
    paths: Vec<Input>,
    plant: Plant<'_>,
    bundle: Option<&Bundle>,
    settings: &CompareSettings,
    tuned: &Tuned,
    progress: Progress<'_>,
) -> Result<(Vec<PathComparison>, Tuned)> {
    let setup = plant.setup()?;
    let tuning = curve_program(TUNING_CURVE, FEED_MM_S, SPACING_MM, &setup)?;
    let trial = |law: &Ilc| -> Result<Option<(Ilc, LawSettings)>> {
        let Some(own) = tuned.of(*law) else { return Ok(None) };
        let tried = CUT_OFFS_HZ.into_iter().filter(|_| settings.ilc_low_pass_hz.is_none()).chain(own.low_pass_hz());
        let tried: Vec<LawSettings> = tried.map(|hz| own.for_programs(hz)).collect();
        if let [only] = tried[..] {
            return Ok(Some((*law, only)));
        }
        let cost = |one: &LawSettings| -> Result<f64> {
            let mut machine = plant.machine(settings.seed.wrapping_add(TUNING_SEED), settings.simulation)?;
            let run = learned(&tuning, machine.as_mut(), settings.ilc_runs, *law, *one, MOVE_POINTS);
            // A law whose program cannot be planned any more has diverged.
            Ok(run.map_or(f64::INFINITY, |run| run.figures.cost_mm()))
        };
        let costs: Vec<f64> = tried.par_iter().map(cost).collect::<Result<_>>()?;
        let best = costs.iter().zip(&tried).min_by(|one, other| one.0.total_cmp(other.0));
        Ok(best.map(|(_, settings)| (*law, *settings)))
    };
    let chosen: Vec<Option<(Ilc, LawSettings)>> = LAWS.par_iter().map(trial).collect::<Result<_>>()?;
    let chosen = Tuned { laws: chosen.into_iter().flatten().collect(), searched: tuned.searched };
    let programs = paths.into_iter().filter_map(|path| Programmed::of(path, &setup).transpose()).collect::<Result<Vec<_>>>()?;
    let steps = Steps::new(progress, Job::ComparingPrograms, programs.len() * settings.seeds as usize);
    let bench = Bench { plant, bundle, settings, tuned: &chosen, steps };
    let results = programs.par_iter().map(|program| bench.program(program)).collect::<Result<_>>()?;
    Ok((results, chosen))
}

/// A program, and how its compensated points are written.
struct Programmed {
    program: Input,
    /// Points of the first run and of ILC; several where ILC takes the best.
    points: Vec<RefitSettings>,
    /// Largest relative increase of the cycle time of the first run.
    cycle_limit: f64,
}

impl Programmed {
    /// The program of a path; `None` for a recorded reference.
    fn of(path: Input, setup: &Setup) -> Result<Option<Self>> {
        let mut part = match path {
            Input::Program(part) => part,
            Input::Path(path) if path.desired.curve().is_some() => {
                let program = Input::from(curve_program(&path.name, FEED_MM_S, SPACING_MM, setup)?);
                return Ok(Some(Self { program, points: vec![MOVE_POINTS], cycle_limit: f64::INFINITY }));
            }
            Input::Path(_) => return Ok(None),
        };
        let output = OutputSettings::new(setup, None, None, None);
        output.prepare(&mut part);
        let points = output.refit().suited_to(&part)?;
        if !is_replanned(&part, points) {
            return Err(Error::NotReplanned(part.name));
        }
        let cycle_limit = Settings::default().cycle_limit;
        Ok(Some(Self { program: Input::Program(part), points: vec![points, MOVE_POINTS], cycle_limit }))
    }
}

/// Last run of `law` on a program with these points.
fn learned(
    part: &Part,
    machine: &mut dyn Machine,
    updates: usize,
    law: Ilc,
    settings: LawSettings,
    points: RefitSettings,
) -> Result<ProgramRun> {
    let desired = &part.plan.desired;
    let uncompensated = machine.run(desired.trajectory())?;
    let correction_limits = ilc_correction_limits(desired, Some(&part.limits), &uncompensated, settings)?;
    let correction_limits = CorrectionLimits { weights: kept_moves(part), ..correction_limits };
    let mut learner = settings.law(law, desired.trajectory().period_s(), &[])?;
    let runs = learn_program(part, machine, learner.as_mut(), (Pairing::Place, points), updates, &correction_limits)?;
    runs.into_iter().next_back().ok_or(Error::NoRun(law.name()))
}

/// Correction weights of ILC where a compensated program keeps some of its moves, such as rapids; empty where it may move all of its points.
fn kept_moves(part: &Part) -> Vec<f64> {
    let keeps = (0..part.plan.samples.len()).any(|sample| !part.shiftable_at(sample));
    if keeps { part.taper() } else { Vec::new() }
}

impl Bench<'_> {
    /// Every method on a program.
    fn program(&self, Programmed { program, points, cycle_limit }: &Programmed) -> Result<PathComparison> {
        let desired = program.desired();
        let mut references = vec![(Method::Uncompensated, desired.trajectory().clone(), MOVE_POINTS)];
        if let Some(bundle) = self.bundle {
            let written = points[0];
            let settings = Settings { written: Some(written), cycle_limit: *cycle_limit, ..self.settings.learning };
            self.steps.at(&format!("{}: learning on the model", program.name()))?;
            let first = model_based_ilc(program, bundle, &settings, SILENT)?;
            if let Some(mut machine) = self.plant.noise_free(self.settings.simulation)? {
                let perfect = on_machine(&mut machine, program, &settings)?;
                references.push((Method::PerfectModel, perfect.reference, perfect.written.unwrap_or(MOVE_POINTS)));
            }
            references.push((Method::FirstRun, first.reference, first.written.unwrap_or(MOVE_POINTS)));
        }
        let mut result = PathComparison::empty(program.name(), desired);
        let part = program.program()?;
        let seeds = (0..self.settings.seeds).into_par_iter().map(|seed| self.program_seed(part, points, &references, seed));
        for (method, measured) in seeds.collect::<Result<Vec<_>>>()?.into_iter().flatten() {
            result.push(method, &measured);
        }
        result.insert_best_ilc();
        Ok(result)
    }

    fn program_seed(
        &self,
        part: &Part,
        points: &[RefitSettings],
        references: &[(Method, Trajectory, RefitSettings)],
        index: u64,
    ) -> Result<Vec<(Method, Measured)>> {
        let mut machine = self.plant.machine(self.settings.noise_seed(index), self.settings.simulation)?;
        let mut measured = Vec::new();
        for (method, reference, written) in references {
            measured.push((*method, Measured::of_program(part, &run_program(part, machine.as_mut(), reference, written)?)));
        }
        for law in LAWS {
            let Some(settings) = self.tuned.of(law) else { continue };
            self.steps.at(&format!("{}: {}", part.name, law.name()))?;
            let mut tried = points.iter().map(|one| learned(part, machine.as_mut(), self.settings.ilc_runs, law, settings, *one));
            let first = tried.next().unwrap_or(Err(Error::NoRun(law.name())));
            let run = tried.fold(first, |best, next| match (&best, &next) {
                (Ok(one), Ok(other)) if one.figures.cost_mm() <= other.figures.cost_mm() => best,
                (Ok(_), Err(_)) => best,
                _ => next,
            })?;
            measured.push((Method::Ilc(law), Measured::of_program(part, &run)));
        }
        for figures in floor_runs(machine.as_mut(), &part.plan.desired, Some(part))? {
            measured.push((Method::Floor, Measured { figures, max_sample: 0, seconds: None }));
        }
        self.steps.step(&part.name)?;
        Ok(measured)
    }
}

impl Measured {
    /// Figures of a program run in the time planned by the control.
    fn of_program(part: &Part, ProgramRun { run, figures }: &ProgramRun) -> Self {
        let position = |k: usize| run.path_positions[k].round() as usize;
        let mut counted = (0..run.path_positions.len()).map(position).filter(|sample| part.feeds_at(*sample));
        let max_sample = counted.nth(figures.tip.max_at).unwrap_or_default();
        Self { figures: *figures, max_sample, seconds: Some(run.command.duration_s()) }
    }
}

#[cfg(test)]
mod tests {
    use machine::MachineSpec;

    use super::*;
    use crate::part::WorkOffsets;

    #[test]
    fn a_program_that_states_its_times_is_none_to_compare_and_a_reference_has_no_program() {
        let setup = Setup::new(&MachineSpec::builtin("ballscrew").unwrap(), None).unwrap();
        let planned = |text: &str| {
            let (program, options) = (gcode::parse(text), gcode::Dialect::LinuxCnc.into());
            let part = Part::planned("a.nc", program, options, &WorkOffsets::default().or_zero(), &setup, &setup.plan_settings());
            Programmed::of(Input::from(part.unwrap()), &setup)
        };
        let refused = planned("G21 G90\nG0 X0 Y0 Z0\nG93\nG1 F60 X20\nF60 Y20\nM2\n").err().unwrap().to_string();
        assert!(refused.contains("a.nc: it states the times of its lines"), "{refused}");
        let program = planned("G21 G90\nG0 X0 Y0 Z0\nG1 F600 X20\nY20\nM2\n").unwrap().unwrap();
        assert!(program.points[0].spacing_s.is_finite() && program.points[1] == MOVE_POINTS);
        let curve = Programmed::of(Input::curve("circle", FEED_MM_S, &setup).unwrap(), &setup).unwrap().unwrap();
        assert!(curve.points == [MOVE_POINTS] && curve.program.part().is_some());
    }
}
