//! Comparison of compensation methods on unseen paths, against the desired path and with the repeatability floor.
//!
//! [`compare`] tunes every ILC law on the machine, then runs every [`Method`] on every path and noise seed.

mod bench;
mod floor;
mod method;
mod plant;
mod programs;
mod results;
mod settings;
mod tuning;

use models::Bundle;
use rayon::prelude::*;

use crate::error::Result;
use crate::input::Input;
use crate::progress::{Job, Progress, Steps};

use bench::Bench;

pub use floor::floor;
pub use method::{Ilc, Method};
pub use plant::{OwnMachine, Plant};
pub use programs::compare_programs;
pub use results::{BestIlc, Figures, KeptRun, PathComparison, gap, mean, spread};
pub use settings::{CompareSettings, FEED_MM_S, PAPER_D, UNSEEN, UNSEEN_TURNED};
pub use tuning::{LawSettings, Tuned};

/// Result of a comparison.
#[derive(Debug)]
pub struct Comparison {
    /// One result for each path.
    pub paths: Vec<PathComparison>,
    /// Settings of the ILC laws.
    pub tuned: Tuned,
}

/// Runs every method on `paths` on the machine `plant`; with a model also the methods that need one. ILC is tuned on
/// the machine first.
///
/// # Errors
/// When a path does not fit the machine or the model, or ILC cannot be tuned.
pub fn compare(
    paths: &[Input],
    plant: Plant<'_>,
    bundle: Option<&Bundle>,
    settings: &CompareSettings,
    progress: Progress<'_>,
) -> Result<Comparison> {
    let tuned = Tuned::on(plant, &plant.laws()?, &plant.setup()?, settings, progress)?;
    let paths = compare_tuned(paths, plant, bundle, settings, &tuned, progress)?;
    Ok(Comparison { paths, tuned })
}

/// Same as [`compare`], with given settings of the ILC laws.
///
/// # Errors
/// As [`compare`].
pub fn compare_tuned(
    paths: &[Input],
    plant: Plant<'_>,
    bundle: Option<&Bundle>,
    settings: &CompareSettings,
    tuned: &Tuned,
    progress: Progress<'_>,
) -> Result<Vec<PathComparison>> {
    let steps = Steps::new(progress, Job::Comparing, paths.len() * settings.seeds as usize);
    let bench = Bench { plant, bundle, settings, tuned, steps };
    paths.par_iter().map(|path| bench.path(path)).collect()
}

#[cfg(test)]
mod tests {
    use machine::MachineSpec;

    use super::*;
    use crate::model_based_ilc::Settings;
    use crate::progress::SILENT;
    use crate::setup::Setup;

    fn path(figures: &[(Method, f64, f64)]) -> PathComparison {
        let spec = MachineSpec::builtin("ballscrew").unwrap();
        let desired = Input::curve("circle", FEED_MM_S, &Setup::new(&spec, None).unwrap()).unwrap();
        let mut result = PathComparison::empty("circle", desired.desired());
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
        // There is no gap where ILC is not above the floor.
        let below = path(&[(Method::FirstRun, 0.25, 0.9), (Method::Ilc(Ilc::Spatial), 0.2, 0.6), (Method::Floor, 0.2, 0.7)]);
        assert_eq!(below.gap(), (None, None));
    }

    #[test]
    fn the_refined_reference_keeps_the_correction_limits_of_refine() {
        let spec = MachineSpec::builtin("ballscrew").unwrap();
        let path = Input::curve("circle", FEED_MM_S, &Setup::new(&spec, None).unwrap()).unwrap();
        let desired = path.desired();
        let bound = 2e-3;
        let learning = Settings { max_shift: Some(bound), ..Settings::default() };
        let settings = CompareSettings { learning, ilc_gain: Some(0.8), ilc_low_pass_hz: Some(100.0), ..Default::default() };
        let plant = Plant::Simulated(&spec);
        let tuned = Tuned::on(plant, &[], &plant.setup().unwrap(), &settings, SILENT).unwrap();
        let steps = Steps::new(SILENT, Job::Comparing, 1);
        let bench = Bench { plant, bundle: None, settings: &settings, tuned: &tuned, steps };
        // An axis with an error of 1 mm asks for a correction of half of it.
        let columns = desired.trajectory().columns().iter().map(|column| column.iter().map(|x| x + 1.0).collect());
        let actual = desired.trajectory().with_columns(columns.collect()).unwrap();
        let next = bench.refined(&path, desired.trajectory(), &actual).unwrap();
        let largest = path.largest_shift(&next);
        assert!(largest > 0.5 * bound && largest <= bound + 1e-12, "{largest}");
    }

    #[test]
    fn ilc_keeps_the_limits_of_the_axes_like_the_first_run() {
        let spec = MachineSpec::builtin("ballscrew").unwrap();
        let path = Input::curve("circle", FEED_MM_S, &Setup::new(&spec, None).unwrap()).unwrap();
        let (desired, limits) = (path.desired(), path.limits().unwrap());
        let settings = tuning::LawSettings::NormOptimal { s: 0.0, r: 0.0 };
        let bounds = tuning::ilc_correction_limits(desired, Some(limits), desired.trajectory(), settings).unwrap();
        // 20 µm to and fro every other sample.
        let shaken = |column: &Vec<f64>| column.iter().enumerate().map(|(k, x)| x + 0.02 * f64::from(k as u32 % 2)).collect();
        let asked = desired.trajectory().with_columns(desired.trajectory().columns().iter().map(shaken).collect()).unwrap();
        let period_s = asked.period_s();
        let most = |reference: &motion::Trajectory| {
            let rate = |at: &[f64]| (at[2] - 2.0 * at[1] + at[0]).abs() / (period_s * period_s);
            reference.columns().iter().flat_map(|column| column.windows(3).map(rate)).fold(0.0, f64::max)
        };
        let allowed = compensation::OVERSHOOT[1] * limits.axes[0].acceleration;
        let kept = most(&bounds.apply(desired, &asked).unwrap());
        assert!(most(&asked) > 5.0 * allowed && kept <= allowed * (1.0 + 1e-6), "{kept} of {allowed}");
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
