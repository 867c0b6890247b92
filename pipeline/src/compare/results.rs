//! Results of a comparison.

use motion::{DesiredPath, Trajectory};

use super::method::{Ilc, Method};
use crate::error::Result;
use crate::input::Input;
use crate::statistics;

/// Figures of one method on one path, one entry for each seed.
#[derive(Debug, Clone, Default)]
pub struct Figures {
    /// RMS of the tip's contour error, mm.
    pub rms: Vec<f64>,
    /// Largest contour error of the tip, mm.
    pub max: Vec<f64>,
    /// Path sample of the largest contour error.
    pub max_sample: Vec<usize>,
    /// RMS orientation error, rad; empty on a machine without rotary axes.
    pub turn_rms: Vec<f64>,
    /// Largest orientation error, rad; empty on a machine without rotary axes.
    pub turn_max: Vec<f64>,
    /// Duration of the run, s; of programs only.
    pub seconds: Vec<f64>,
}

impl Figures {
    pub(super) fn push(&mut self, run: &Measured) {
        self.rms.push(run.figures.tip.rms_mm);
        self.max.push(run.figures.tip.max_mm);
        self.max_sample.push(run.max_sample);
        if let Some(orientation) = &run.figures.orientation {
            self.turn_rms.push(orientation.rms_rad);
            self.turn_max.push(orientation.max_rad);
        }
        self.seconds.extend(run.seconds);
    }

    /// Mean RMS and mean MAX of the tip over the seeds, mm.
    #[must_use]
    pub fn mean(&self) -> (f64, f64) {
        (mean(&self.rms), mean(&self.max))
    }

    /// Mean RMS and mean MAX of the orientation error over the seeds, rad; `None` on a machine without rotary axes.
    #[must_use]
    pub fn mean_turn(&self) -> Option<(f64, f64)> {
        (!self.turn_rms.is_empty()).then(|| (mean(&self.turn_rms), mean(&self.turn_max)))
    }

    /// Path sample of the largest error over all seeds.
    #[must_use]
    pub fn worst_sample(&self) -> Option<usize> {
        let worst = self.max.iter().zip(&self.max_sample).max_by(|one, other| one.0.total_cmp(other.0));
        worst.map(|(_, sample)| *sample)
    }
}

/// Arithmetic mean; 0 for an empty slice.
#[must_use]
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Sample standard deviation; 0 for fewer than two values.
#[must_use]
pub fn spread(values: &[f64]) -> f64 {
    let m = mean(values);
    (values.iter().map(|v| (v - m).powi(2)).sum::<f64>() / (values.len().max(2) - 1) as f64).sqrt()
}

/// Figures of one run.
#[derive(Debug, Clone, Copy)]
pub(super) struct Measured {
    pub(super) figures: statistics::Figures,
    pub(super) max_sample: usize,
    pub(super) seconds: Option<f64>,
}

impl Measured {
    /// Figures of a run in the path's own time.
    pub(super) fn of(path: &Input, actual: &Trajectory) -> Result<Self> {
        let figures = path.figures(actual)?;
        // In a program only samples of feed moves count.
        let counts = |k: &usize| path.part().is_none_or(|part| part.feeds_at(*k));
        let max_sample = (0..path.trajectory().len()).filter(counts).nth(figures.tip.max_at).unwrap_or_default();
        Ok(Self { figures, max_sample, seconds: None })
    }
}

/// Results of all methods on one path.
#[derive(Debug)]
pub struct PathComparison {
    /// Name of the path.
    pub name: String,
    /// Methods with their figures, in the order of the table.
    pub methods: Vec<(Method, Figures)>,
    /// RMS of every run of each ILC law, mean over the seeds, mm; the first run is uncompensated. Empty for programs.
    pub learning: Vec<(Ilc, Vec<f64>)>,
    /// Desired path.
    pub desired: DesiredPath,
    /// Whether the path is that of a part program whose reference is streamed. ILC then shifts the moves too that a program keeps.
    pub streams_part: bool,
    /// Runs of the first seed for plots.
    pub runs: Vec<KeptRun>,
}

/// A run that is kept for plots.
#[derive(Debug, Clone)]
pub struct KeptRun {
    /// Name of the method.
    pub name: &'static str,
    /// Commanded positions.
    pub reference: Trajectory,
    /// Actual positions.
    pub actual: Trajectory,
}

/// The laws with the lowest figures on a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BestIlc {
    /// Law with the lowest mean RMS.
    pub rms: Ilc,
    /// Law with the lowest mean MAX.
    pub max: Ilc,
}

impl PathComparison {
    pub(super) fn empty(name: &str, desired: &DesiredPath) -> Self {
        Self {
            name: name.to_owned(),
            methods: Vec::new(),
            learning: Vec::new(),
            desired: desired.clone(),
            streams_part: false,
            runs: Vec::new(),
        }
    }

    pub(super) fn push(&mut self, method: Method, measured: &Measured) {
        match self.methods.iter_mut().find(|(known, _)| *known == method) {
            Some((_, all)) => all.push(measured),
            None => {
                let mut all = Figures::default();
                all.push(measured);
                self.methods.push((method, all));
            }
        }
    }

    /// Inserts the best ILC after the last law: every figure is that of the law with its lowest value.
    pub(super) fn insert_best_ilc(&mut self) {
        let Some(best) = self.best_ilc() else { return };
        let (Some(by_rms), Some(by_max)) = (self.of(Method::Ilc(best.rms)), self.of(Method::Ilc(best.max))) else { return };
        let (mut figures, lowest_max) = (by_rms.clone(), by_max.clone());
        (figures.max, figures.max_sample) = (lowest_max.max, lowest_max.max_sample);
        let turning = |of: fn(&Figures) -> &Vec<f64>| {
            let all = self.laws().map(|(_, figures)| of(figures)).filter(|values| !values.is_empty());
            all.min_by(|one, other| mean(one).total_cmp(&mean(other))).cloned().unwrap_or_default()
        };
        let (turn_rms, turn_max) = (turning(|figures| &figures.turn_rms), turning(|figures| &figures.turn_max));
        let after = self.methods.iter().rposition(|(method, _)| matches!(method, Method::Ilc(_))).map_or(0, |at| at + 1);
        self.methods.insert(after, (Method::BestIlc, Figures { turn_rms, turn_max, ..figures }));
    }

    pub(super) fn laws(&self) -> impl Iterator<Item = (Ilc, &Figures)> {
        self.methods.iter().filter_map(|(method, figures)| match method {
            Method::Ilc(law) => Some((*law, figures)),
            _ => None,
        })
    }

    /// The laws with the lowest mean RMS and the lowest mean MAX over the seeds.
    #[must_use]
    pub fn best_ilc(&self) -> Option<BestIlc> {
        let lowest =
            |of: fn(&Figures) -> f64| self.laws().min_by(|one, other| of(one.1).total_cmp(&of(other.1))).map(|(law, _)| law);
        Some(BestIlc { rms: lowest(|figures| figures.mean().0)?, max: lowest(|figures| figures.mean().1)? })
    }

    /// RMS of every run of an ILC law, mm; empty where that was not run.
    #[must_use]
    pub fn learning_of(&self, law: Ilc) -> &[f64] {
        self.learning.iter().find(|(known, _)| *known == law).map_or(&[], |(_, rms)| rms)
    }

    /// Figures of a method; `None` where it was not run.
    #[must_use]
    pub fn of(&self, method: Method) -> Option<&Figures> {
        self.methods.iter().find(|(known, _)| *known == method).map(|(_, figures)| figures)
    }

    /// `(first run − floor)/(best ILC − floor)` of RMS and of MAX. Below 1 the first run is better than every ILC law.
    /// `None` where the best ILC is not above the floor.
    #[must_use]
    pub fn gap(&self) -> (Option<f64>, Option<f64>) {
        gap(std::slice::from_ref(self))
    }
}

/// Same as [`PathComparison::gap`], of the means over `results`.
#[must_use]
pub fn gap(results: &[PathComparison]) -> (Option<f64>, Option<f64>) {
    let over = |method: Method, of: fn((f64, f64)) -> f64| -> Option<f64> {
        let all: Option<Vec<f64>> = results.iter().map(|result| Some(of(result.of(method)?.mean()))).collect();
        all.filter(|all| !all.is_empty()).map(|all| mean(&all))
    };
    let share = |of: fn((f64, f64)) -> f64| -> Option<f64> {
        let floor = over(Method::Floor, of)?;
        let opponent = over(Method::BestIlc, of)? - floor;
        (opponent > 0.0).then_some((over(Method::FirstRun, of)? - floor) / opponent)
    };
    (share(|figures| figures.0), share(|figures| figures.1))
}
