//! Straight lines with corners and stops, planned as by a control: the content of most part
//! programs.

use std::sync::Arc;

use motion::curves::Line;
use motion::{
    Axis, Cartesian, Kinematics, Limits, MM_PER_RAD, Piece, PlanSettings, RotaryPath, ToolPath, Trajectory, Turning, Vec3, plan,
};
use rand::{Rng, RngExt};

use crate::DatasetError;

/// Corner tolerance, mm.
const CORNER_TOLERANCE_MM: f64 = 0.02;
/// Share of lines that end at a stop, and the longest dwell there, s.
const STOPS: f64 = 0.35;
const LONGEST_DWELL_S: f64 = 0.15;
/// Share of lines along a single axis: only these reach its full speed.
const SINGLE: f64 = 0.4;
/// Share of lines at full speed, and the slowest speed of the others, as a share of it.
const FULL: f64 = 0.5;
const SLOWEST: f64 = 0.25;
/// Share of lines that approach a stop like a plunging tool: short, slow and along one linear axis;
/// their lengths, mm, and speeds as a share of full speed. The standstill error after a slow stop
/// differs from that after a fast one.
const APPROACHES: f64 = 0.25;
const APPROACH_MM: std::ops::Range<f64> = 0.2..2.0;
const APPROACH_SPEED: std::ops::Range<f64> = 0.02..0.2;

/// Lines through positions that `position` draws for an axis, from `home` and back.
pub(super) struct Lines<'a> {
    pub axes: &'a [Axis],
    pub limits: &'a Limits,
    pub home: &'a [f64],
    /// Lowest and highest position of every axis, mm or rad.
    pub travel: &'a [(f64, f64)],
    pub seconds: f64,
    pub standstill_s: f64,
    pub speed_share: f64,
    pub period_s: f64,
}

impl Lines<'_> {
    /// `None` if the machine has none of the axes x, y, z, a, b, c.
    pub fn generate<R: Rng>(
        &self,
        rng: &mut R,
        mut position: impl FnMut(&mut R, usize) -> f64,
    ) -> Result<Option<Trajectory>, DatasetError> {
        // The axes of the lines, each with its index among x, y, z, a, b, c.
        let moved: Vec<(usize, usize)> = (0..self.axes.len()).filter_map(|axis| Some((axis, self.axes[axis].slot()?))).collect();
        if moved.is_empty() {
            return Ok(None);
        }
        let path = self.draw(&moved, rng, &mut position);
        self.planned(&path, &moved).map(Some)
    }

    /// Lines drawn until their estimated time is reached, and the return home.
    fn draw<R: Rng>(&self, moved: &[(usize, usize)], rng: &mut R, position: &mut impl FnMut(&mut R, usize) -> f64) -> ToolPath {
        let has_linear = moved.iter().any(|(_, slot)| *slot < 3);
        let turns = moved.iter().any(|(_, slot)| *slot >= 3);
        let mut home = [0.0; 6];
        moved.iter().for_each(|&(axis, slot)| home[slot] = self.home[axis]);
        let (mut at, mut path, mut planned_s) = (home, ToolPath::default(), 0.0);
        loop {
            let last = planned_s >= self.seconds - 2.0 * self.standstill_s;
            let approach = !last && has_linear && rng.random_bool(APPROACHES);
            let end = if last { home } else { self.end_of_line(&at, approach, moved, rng, position) };
            let distance: [f64; 6] = std::array::from_fn(|slot| (end[slot] - at[slot]) * distance_mm(slot));
            let length = distance.iter().map(|step| step * step).sum::<f64>().sqrt();
            if length > 1e-3 {
                let top = self.speed_share * self.top_speed(moved, &distance.map(|step| step / length));
                let share = match approach {
                    true => rng.random_range(APPROACH_SPEED),
                    false if rng.random_bool(FULL) => 1.0,
                    false => rng.random_range(SLOWEST..1.0),
                };
                let feed_mm_s = top * share;
                let stop_after = approach || rng.random_bool(STOPS);
                let dwell_s = if stop_after { rng.random_range(0.0..LONGEST_DWELL_S) } else { 0.0 };
                let line = Line { start: linear(&at), end: linear(&end) };
                let piece =
                    Piece { stop_after, dwell_s: if last { 0.0 } else { dwell_s }, ..Piece::whole(Arc::new(line), feed_mm_s) };
                let turning = Turning::Axes(RotaryPath::linear(rotary(&at), rotary(&end)));
                path.push(if turns { piece.turning(turning) } else { piece });
                planned_s += length / feed_mm_s + dwell_s + 0.05;
                at = end;
            }
            if last {
                return path;
            }
        }
    }

    /// End of a line from `at`: a short distance along a linear axis for an `approach`, else along
    /// one axis or all of them.
    fn end_of_line<R: Rng>(
        &self,
        at: &[f64; 6],
        approach: bool,
        moved: &[(usize, usize)],
        rng: &mut R,
        position: &mut impl FnMut(&mut R, usize) -> f64,
    ) -> [f64; 6] {
        let mut end = *at;
        if approach {
            let plunging: Vec<(usize, usize)> = moved.iter().copied().filter(|(_, slot)| *slot < 3).collect();
            let (axis, slot) = plunging[rng.random_range(0..plunging.len())];
            let towards = (position(rng, axis) - at[slot]).signum();
            let (lowest, highest) = self.travel[axis];
            end[slot] = (end[slot] + towards * rng.random_range(APPROACH_MM)).clamp(lowest, highest);
        } else if rng.random_bool(SINGLE) {
            let (axis, slot) = moved[rng.random_range(0..moved.len())];
            end[slot] = position(rng, axis);
        } else {
            moved.iter().for_each(|&(axis, slot)| end[slot] = position(rng, axis));
        }
        end
    }

    /// The motion of all axes along `path`; other axes stay at home.
    fn planned(&self, path: &ToolPath, moved: &[(usize, usize)]) -> Result<Trajectory, DatasetError> {
        let settings = PlanSettings {
            period_s: self.period_s,
            corner_tolerance_mm: CORNER_TOLERANCE_MM,
            rest_s: self.standstill_s,
            ..PlanSettings::default()
        };
        let kinematics: Arc<dyn Kinematics> = Arc::new(Cartesian::new(self.axes.to_vec()));
        let planned = plan(path, &kinematics, &self.axis_limits_only(moved), &settings)?.desired.trajectory().clone();
        let mut columns = planned.columns().to_vec();
        for (axis, column) in columns.iter_mut().enumerate() {
            if !moved.iter().any(|(known, _)| *known == axis) {
                column.fill(self.home[axis]);
            }
        }
        Ok(planned.with_columns(columns)?)
    }

    /// The limits without those of the path.
    fn axis_limits_only(&self, moved: &[(usize, usize)]) -> Limits {
        let norm = |of: fn(&motion::AxisLimits) -> f64| {
            let linear = moved.iter().filter(|(_, slot)| *slot < 3);
            linear.map(|(axis, _)| of(&self.limits.axes[*axis]).powi(2)).sum::<f64>().sqrt().max(f64::MIN_POSITIVE)
        };
        let acceleration = norm(|axis| axis.acceleration);
        Limits {
            axes: self.limits.axes.clone(),
            path_velocity_mm_s: norm(|axis| axis.velocity),
            path_acceleration_mm_s2: acceleration,
            path_jerk_mm_s3: norm(|axis| axis.jerk),
            centripetal_mm_s2: acceleration,
        }
    }

    /// Speed along `direction` at which the first axis reaches its limit, mm/s.
    fn top_speed(&self, moved: &[(usize, usize)], direction: &[f64; 6]) -> f64 {
        moved
            .iter()
            .map(|&(axis, slot)| self.limits.axes[axis].velocity * distance_mm(slot) / direction[slot].abs().max(1e-9))
            .fold(f64::INFINITY, f64::min)
    }
}

/// Distance per unit of an axis, mm.
fn distance_mm(slot: usize) -> f64 {
    if slot < 3 { 1.0 } else { MM_PER_RAD }
}

fn linear(at: &[f64; 6]) -> Vec3 {
    Vec3::new(at[0], at[1], at[2])
}

fn rotary(at: &[f64; 6]) -> Vec3 {
    Vec3::new(at[3], at[4], at[5])
}
