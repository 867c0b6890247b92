//! Plan of an excitation: its runs.

use crate::DatasetError;

/// Shortest run, s: a motion between the standstills of a tenth of a second.
const SHORTEST_S: f64 = 0.3;
/// The longest run, s: variety improves a model more than length.
const LONGEST_S: f64 = 400.0;

/// Kind of motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// Splines through random positions (Paper D, eq. 13).
    Splines,
    /// The same through positions no further apart than an axis needs to reach its speed and to stop again, so that
    /// acceleration, not speed, is the limit.
    Reversals,
    /// Straight lines with rounded corners and stops, as by jerk-limited controls.
    Lines,
}

/// One run of an excitation.
#[derive(Debug, Clone, PartialEq)]
pub struct RunPlan {
    /// Part of the run's name.
    pub name: String,
    /// Planned duration including standstills, s; reached within about a quarter.
    pub seconds: f64,
    /// Standard deviation of the positions of linear axes, mm; rotary axes use it at a lever arm of
    /// 100 mm.
    pub sigma_mm: f64,
    /// Share of the speed limits, 0 to 1; acceleration and jerk use their full limits.
    pub speed_share: f64,
    /// Kind of motion.
    pub shape: Shape,
    /// Number of spline pieces from standstill to standstill.
    pub pieces: usize,
    /// Dwell between pieces, s.
    pub dwell_s: f64,
    /// Axes that rest in the second piece of three or more while the others move: this one, counted from 0, and every third one after it. `None`, and on
    /// a machine with one axis, none does.
    pub resting: Option<usize>,
}

/// The piece in which axes rest: they have moved before, and move home after it.
pub(super) const RESTING_PIECE: usize = 1;
/// Shortest run at full speed in which axes rest, s. In a shorter one the three pieces are too short for the travel and the speeds of parts: the run of 6 s of a
/// minute of log of `bc` left 1.8 instead of 0.3 µm RMS on the saddle butterfly, runs of 12 s save a twentieth on three axes (`docs/random-machines.md`).
const RESTS_FROM_S: f64 = 10.0;
/// Distance between resting axes.
const RESTING_STEP: usize = 3;

impl RunPlan {
    /// The paper's spread of positions, σ = 18 mm, at a share of the speed limits.
    #[must_use]
    pub fn standard(name: &str, seconds: f64, speed_share: f64) -> Self {
        Self {
            name: name.to_owned(),
            seconds,
            sigma_mm: 18.0,
            speed_share,
            shape: Shape::Splines,
            pieces: 2,
            dwell_s: 0.1,
            resting: None,
        }
    }

    /// The standard motion at full speed, with a third of it in which axes rest, others in every `number`. In most programs an axis stands for
    /// long while others move.
    #[must_use]
    pub fn resting(name: &str, seconds: f64, number: usize) -> Self {
        Self { pieces: 3, resting: Some(number % RESTING_STEP), ..Self::standard(name, seconds, 1.0) }
    }

    /// Many small sharp reversals, σ = 4 mm or less.
    #[must_use]
    pub fn sharp(name: &str, seconds: f64) -> Self {
        Self { sigma_mm: 4.0, shape: Shape::Reversals, ..Self::standard(name, seconds, 1.0) }
    }

    /// Straight lines with lengths up to a few times σ = 18 mm.
    #[must_use]
    pub fn lines(name: &str, seconds: f64) -> Self {
        Self { shape: Shape::Lines, ..Self::standard(name, seconds, 1.0) }
    }

    /// Whether an axis out of `axes` rests in its piece.
    pub(super) fn rests(&self, axis: usize, axes: usize) -> bool {
        axes > 1
            && self.pieces > RESTING_PIECE + 1
            && self.resting.is_some_and(|first| axis >= first && (axis - first).is_multiple_of(RESTING_STEP))
    }

    /// Planned duration of one piece, s, without `standstill_s` before and after the run.
    pub(super) fn piece_s(&self, standstill_s: f64) -> f64 {
        let dwells_s = self.pieces.saturating_sub(1) as f64 * self.dwell_s;
        ((self.seconds - 2.0 * standstill_s - dwells_s) / self.pieces as f64).max(0.2)
    }

    fn check(&self) -> Result<(), DatasetError> {
        let positive = "it must be positive and finite";
        let settings = [
            (
                "seconds of a run",
                self.seconds,
                (SHORTEST_S..=LONGEST_S).contains(&self.seconds),
                "it must be at least 0.3 and at most 400; more excitations of other seeds teach more than a longer one",
            ),
            ("sigma_mm", self.sigma_mm, self.sigma_mm > 0.0, positive),
            (
                "speed_share",
                self.speed_share,
                self.speed_share > 0.0 && self.speed_share <= 1.0,
                "it must be above 0 and at most 1",
            ),
            ("pieces", self.pieces as f64, self.pieces > 0, "a run has at least one piece"),
            ("dwell_s", self.dwell_s, self.dwell_s >= 0.0, "it must not be negative"),
        ];
        match settings.iter().find(|(_, value, fits, _)| !(value.is_finite() && *fits)) {
            Some(&(name, value, _, remedy)) => Err(DatasetError::BadSetting { name, value, remedy }),
            None => Ok(()),
        }
    }
}

/// The runs of an excitation, in order.
#[derive(Debug, Clone, PartialEq)]
pub struct ExcitationPlan {
    /// The runs.
    pub runs: Vec<RunPlan>,
}

impl Default for ExcitationPlan {
    /// One minute.
    fn default() -> Self {
        Self::of_seconds(60.0)
    }
}

impl ExcitationPlan {
    /// Ten runs of about `seconds` in total: four at full speed, one each at half and at a quarter of it, two with sharp
    /// reversals, two of straight lines. From 100 s on axes rest in a third of the runs at full speed.
    #[must_use]
    pub fn of_seconds(seconds: f64) -> Self {
        let each = seconds / 10.0;
        let full = |number: usize| match each >= RESTS_FROM_S {
            true => RunPlan::resting("full", each, number),
            false => RunPlan::standard("full", each, 1.0),
        };
        let sharp = || RunPlan::sharp("sharp", each);
        let lines = || RunPlan::lines("lines", each);
        Self {
            runs: vec![
                full(2),
                RunPlan::standard("slow", each, 0.25),
                sharp(),
                lines(),
                full(0),
                RunPlan::standard("half", each, 0.5),
                sharp(),
                full(1),
                lines(),
                full(2),
            ],
        }
    }

    /// Planned duration of all runs, s.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.runs.iter().map(|run| run.seconds).sum()
    }

    /// Names of the runs, numbered from 1.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        self.runs.iter().enumerate().map(|(index, run)| format!("{:02}-{}", index + 1, run.name)).collect()
    }

    pub(super) fn check(&self) -> Result<(), DatasetError> {
        if self.runs.is_empty() {
            return Err(DatasetError::Runs("the excitation plan has no run".to_owned()));
        }
        self.runs.iter().try_for_each(RunPlan::check)
    }
}
