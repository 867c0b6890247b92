//! What was to be done: the desired path, sample by sample, with the program behind it.

use gcode::Feed;
use motion::contour::poses_at_places;
use motion::{Axis, DesiredPath, Pose, Vec3};
use pipeline::measure::Measurement;
use pipeline::statistics::counts;
use pipeline::{Input, Part};

/// Longest text of a program line that is shown, characters.
const LONGEST_LINE: usize = 200;

/// The desired motion that belongs to every sample of the runs.
pub struct Track<'a> {
    /// Desired path.
    pub desired: &'a DesiredPath,
    part: Option<&'a Part>,
    /// Sample of the desired path that belongs to each sample of the runs.
    pub places: Vec<usize>,
    /// Desired pose of each sample.
    pub poses: Vec<Pose>,
    /// Weight of each sample in the figures; `None` where it does not count, as in rapids.
    pub weights: Vec<Option<f64>>,
    /// Time between samples, s.
    pub period_s: f64,
}

impl<'a> Track<'a> {
    /// The path of an input, for runs in its own time.
    #[must_use]
    pub fn of(input: &'a Input) -> Self {
        Self::in_own_time(input.program_path(), input.part())
    }

    /// A path that no program states, for runs in its own time.
    #[must_use]
    pub fn of_path(desired: &'a DesiredPath) -> Self {
        Self::in_own_time(desired, None)
    }

    fn in_own_time(desired: &'a DesiredPath, part: Option<&'a Part>) -> Self {
        let places: Vec<usize> = (0..desired.trajectory().len()).collect();
        Self {
            desired,
            part,
            weights: places.iter().map(|place| counts(part, *place).then_some(1.0)).collect(),
            poses: desired.poses().to_vec(),
            period_s: desired.trajectory().period_s(),
            places,
        }
    }

    /// The path of an input in the time of a measured run, sampled every `period_s`.
    #[must_use]
    pub fn of_measured(input: &'a Input, measured: &Measurement, period_s: f64) -> Self {
        let last = input.trajectory().len().saturating_sub(1);
        let positions = &measured.matched.path_positions;
        Self {
            places: positions.iter().map(|position| (position.round() as usize).min(last)).collect(),
            poses: poses_at_places(input.desired().poses(), positions),
            weights: measured.weights.clone(),
            period_s,
            ..Self::in_own_time(input.desired(), input.part())
        }
    }

    /// The axes of the machine.
    #[must_use]
    pub fn axes(&self) -> &[Axis] {
        self.desired.trajectory().axes()
    }

    /// Tool tips, mm.
    #[must_use]
    pub fn tips(&self) -> Vec<Vec3> {
        self.poses.iter().map(|pose| pose.tip).collect()
    }

    /// Whether each sample counts in the figures.
    #[must_use]
    pub fn counts(&self) -> Vec<bool> {
        self.weights.iter().map(Option::is_some).collect()
    }

    /// Whether the machine turns the tool.
    #[must_use]
    pub fn turns(&self) -> bool {
        self.desired.kinematics().has_rotary_axes()
    }

    /// Whether a program states the path.
    #[must_use]
    pub fn has_lines(&self) -> bool {
        self.part.is_some()
    }

    /// Program line of every sample, from 1; 0 where there is none.
    #[must_use]
    pub fn lines(&self) -> Vec<usize> {
        let line = |place: &usize| self.part.and_then(|part| part.line_at(*place)).unwrap_or(0);
        self.places.iter().map(line).collect()
    }

    /// Text of a program line, from 1.
    #[must_use]
    pub fn text(&self, line: usize) -> String {
        let text = self.part.and_then(|part| {
            let block = part.program.blocks().get(line.checked_sub(1)?)?;
            Some(String::from_utf8_lossy(part.program.text(block.span)).trim().chars().take(LONGEST_LINE).collect())
        });
        text.unwrap_or_default()
    }

    /// Programmed feed of every sample, mm/s; not a number where none is stated. `None` without a program.
    #[must_use]
    pub fn feeds_mm_s(&self) -> Option<Vec<f64>> {
        let part = self.part?;
        let feed = |place: &usize| match part.move_at(*place).and_then(|index| part.toolpath.moves[index].feed) {
            Some(Feed::Linear { mm_s }) => mm_s,
            _ => f64::NAN,
        };
        let feeds: Vec<f64> = self.places.iter().map(feed).collect();
        feeds.iter().any(|feed| feed.is_finite()).then_some(feeds)
    }

    /// Speed of the tip, mm/s, and its acceleration, mm/s², at every sample: central differences.
    #[must_use]
    pub fn speed_and_acceleration(&self) -> (Vec<f64>, Vec<f64>) {
        let last = self.poses.len().saturating_sub(1);
        let at = |k: usize| {
            let [before, here, after] = [k.saturating_sub(1), k, (k + 1).min(last)].map(|k| self.poses[k].tip);
            let speed = (after - before).norm() / (2.0 * self.period_s);
            (speed, (after - 2.0 * here + before).norm() / self.period_s.powi(2))
        };
        (0..self.poses.len()).map(at).unzip()
    }

    /// Length of the path up to every sample, mm.
    #[must_use]
    pub fn arc_mm(&self) -> Vec<f64> {
        let mut arc = 0.0;
        let step = |k: usize| {
            arc += if k > 0 { (self.poses[k].tip - self.poses[k - 1].tip).norm() } else { 0.0 };
            arc
        };
        (0..self.poses.len()).map(step).collect()
    }
}
