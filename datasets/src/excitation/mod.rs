//! Excitation: random motion within the machine's limits that identifies all effects of a model.
//!
//! Paper D, eq. 13: each axis passes random positions `~ N(c, σ²)` at random knots `t_{j+1} = t_j + 0.04 + U(0.04, 0.08)` on a spline of
//! degree five, with time scaled until speed and acceleration keep their limits. Unlike the paper's
//! single long path, each run is a few seconds long with its own starts and stops, and runs differ
//! in speed, sharpness and position (`c`; zero in the paper): variety improves a model more than
//! length. Some runs are straight lines with corners and stops, as in part programs.
//!
//! The control test ([`ControlTest`]) has no times of its own: it shows how a control plans.

mod control_test;
mod lines;
mod plan;
mod scale;
mod spline;

use motion::{Axis, AxisKind, Limits, Trajectory};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::DatasetError;
pub use control_test::{Block, ControlTest, Coordinates, Group};
use lines::Lines;
use plan::RESTING_PIECE;
pub use plan::{ExcitationPlan, RunPlan, Shape};
use scale::Sampled;
use spline::QuinticSpline;

/// Lever arm that converts a spread of positions in mm to one of angles, mm.
const LEVER_MM: f64 = 100.0;
/// Mean knot interval before time is scaled, s.
const MEAN_INTERVAL_S: f64 = 0.1;
/// Standstill before and after the motion of each run, s.
const STANDSTILL_S: f64 = 0.1;
/// Share of the distance to the travel limits within which pieces stop, so that the motion around
/// the stops has room.
const STOP_SHARE: f64 = 0.5;
/// Number of draws of a piece, and the accepted deviation from the planned duration (logarithm of
/// the ratio).
const DRAWS: usize = 8;
const NEAR: f64 = 0.1;

/// Random runs for a machine: name and reference of each, from standstill to standstill at the
/// middle of the travel.
///
/// `travel` holds the lowest and highest position of each axis (mm or rad); `period_s` is the
/// sampling period. The axes' limits hold for finite differences of the samples. The path's limits
/// do not apply, so that every axis reaches its top speed. The same plan, settings and seed give
/// the same runs.
///
/// # Errors
/// When a limit, the period, the plan or the travel is out of range.
pub fn excite(
    plan: &ExcitationPlan,
    limits: &Limits,
    axes: &[Axis],
    travel: &[(f64, f64)],
    period_s: f64,
    seed: u64,
) -> Result<Vec<(String, Trajectory)>, DatasetError> {
    limits.check()?;
    plan.check()?;
    if axes.is_empty() || limits.axes.len() != axes.len() || travel.len() != axes.len() {
        return Err(DatasetError::Runs(format!(
            "{} axes, limits for {} and travel for {}; every axis needs both",
            axes.len(),
            limits.axes.len(),
            travel.len()
        )));
    }
    if !(period_s > 0.0 && period_s <= 0.02) {
        return Err(DatasetError::BadSetting {
            name: "period_s",
            value: period_s,
            remedy: "excitation needs a sampling period above 0 and up to 0.02 s",
        });
    }
    if let Some((low, high)) = travel.iter().find(|(low, high)| !(low.is_finite() && high.is_finite() && high > low)) {
        return Err(DatasetError::BadSetting {
            name: "travel (highest − lowest)",
            value: high - low,
            remedy: "it must be positive and finite",
        });
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    plan.runs
        .iter()
        .zip(plan.names())
        .map(|(run, name)| {
            let mut generator = Generator { run, limits, axes, travel, period_s, rng: &mut rng };
            Ok((name, generator.generate()?))
        })
        .collect()
}

/// State of a run during its generation.
struct Generator<'a> {
    run: &'a RunPlan,
    limits: &'a Limits,
    axes: &'a [Axis],
    travel: &'a [(f64, f64)],
    period_s: f64,
    rng: &'a mut ChaCha8Rng,
}

impl Generator<'_> {
    fn generate(&mut self) -> Result<Trajectory, DatasetError> {
        let home: Vec<f64> = self.travel.iter().map(|(low, high)| f64::midpoint(*low, *high)).collect();
        match self.run.shape {
            Shape::Splines | Shape::Reversals => self.splines_and_dwells(&home),
            // A machine with other axis names, such as an arm's joints, has no lines.
            Shape::Lines => match self.lines(&home)? {
                Some(run) => Ok(run),
                None => self.splines_and_dwells(&home),
            },
        }
    }

    fn lines(&mut self, home: &[f64]) -> Result<Option<Trajectory>, DatasetError> {
        let centres: Vec<f64> = (0..home.len()).map(|axis| self.centre(axis)).collect();
        let lines = Lines {
            axes: self.axes,
            limits: self.limits,
            home,
            travel: self.travel,
            seconds: self.run.seconds,
            standstill_s: STANDSTILL_S,
            speed_share: self.run.speed_share,
            period_s: self.period_s,
        };
        let draws: Vec<Draw> = (0..home.len()).map(|axis| self.draw(axis)).collect();
        lines.generate(self.rng, |rng, axis| draws[axis].position(rng, centres[axis], 1.0))
    }

    /// Standstill, pieces with dwells between them, standstill.
    fn splines_and_dwells(&mut self, home: &[f64]) -> Result<Trajectory, DatasetError> {
        let mut columns: Vec<Vec<f64>> = home.iter().map(|&position| vec![position]).collect();
        self.dwell(&mut columns, STANDSTILL_S);
        for piece in 0..self.run.pieces {
            let start: Vec<f64> = columns.iter().filter_map(|column| column.last().copied()).collect();
            let rests: Vec<bool> =
                (0..home.len()).map(|axis| piece == RESTING_PIECE && self.run.rests(axis, home.len())).collect();
            let end = if piece + 1 == self.run.pieces {
                home.to_vec()
            } else {
                let end_of = |axis: usize| if rests[axis] { start[axis] } else { self.position(axis, home[axis], STOP_SHARE) };
                (0..home.len()).map(end_of).collect()
            };
            let motion = self.piece(&start, &end, &rests)?;
            for (column, samples) in columns.iter_mut().zip(motion) {
                column.extend(samples.into_iter().skip(1));
            }
            let standstill_s = if piece + 1 == self.run.pieces { STANDSTILL_S } else { self.run.dwell_s };
            self.dwell(&mut columns, standstill_s);
        }
        Ok(Trajectory::new(self.period_s, self.axes.to_vec(), columns)?)
    }

    fn dwell(&self, columns: &mut [Vec<f64>], standstill_s: f64) {
        let samples = (standstill_s / self.period_s).round() as usize;
        for column in columns {
            if let Some(&last) = column.last() {
                column.resize(column.len() + samples, last);
            }
        }
    }

    /// A piece from standstill to standstill: of a few draws, with more or fewer knots, the one
    /// with the duration nearest to the plan.
    fn piece(&mut self, start: &[f64], end: &[f64], rests: &[bool]) -> Result<Vec<Vec<f64>>, DatasetError> {
        let wanted_s = self.run.piece_s(STANDSTILL_S);
        let mut intervals: usize = 8;
        let mut best = (f64::INFINITY, Vec::new());
        for _ in 0..DRAWS {
            let splines = self.splines(intervals, start, end, rests)?;
            let sampled = Sampled::within(&splines, self.limits, self.run.speed_share, self.period_s);
            let ratio = wanted_s / sampled.duration_s;
            let miss = ratio.ln().abs();
            if miss < best.0 {
                best = (miss, sampled.columns);
            }
            if miss < NEAR {
                break;
            }
            intervals = ((intervals as f64 * ratio).round() as usize).clamp(2, 4000);
        }
        Ok(best.1)
    }

    fn splines(
        &mut self,
        intervals: usize,
        start: &[f64],
        end: &[f64],
        rests: &[bool],
    ) -> Result<Vec<QuinticSpline>, DatasetError> {
        let total_s = intervals as f64 * MEAN_INTERVAL_S;
        (0..self.axes.len())
            .map(|axis| {
                let centre = self.centre(axis);
                let mut times = vec![0.0];
                let mut time = 0.0;
                for _ in 0..intervals {
                    time += 0.04 + self.rng.random_range(0.04..0.08);
                    times.push(time);
                }
                // All axes end together.
                times.iter_mut().for_each(|t| *t *= total_s / time);
                let mut values = vec![start[axis]];
                let between = |_| if rests[axis] { start[axis] } else { self.position(axis, centre, 1.0) };
                values.extend((1..intervals).map(between));
                values.push(end[axis]);
                let spline = QuinticSpline::through(&times, &values)?;
                Ok(spline.squeezed(self.travel[axis]))
            })
            .collect()
    }

    /// Centre of an axis during a piece: anywhere at least two standard deviations from the ends of
    /// its travel, so that all pieces together cover the travel. Friction depends on the position.
    fn centre(&mut self, axis: usize) -> f64 {
        let draw = self.draw(axis);
        let room = (draw.half - 2.0 * draw.sigma).max(0.0);
        draw.middle + room * self.rng.random_range(-1.0..=1.0)
    }

    fn position(&mut self, axis: usize, centre: f64, share: f64) -> f64 {
        self.draw(axis).position(self.rng, centre, share)
    }

    fn draw(&self, axis: usize) -> Draw {
        let (low, high) = self.travel[axis];
        let sigma = match self.axes[axis].kind {
            AxisKind::Linear => self.run.sigma_mm,
            AxisKind::Rotary => self.run.sigma_mm / LEVER_MM,
        };
        let ramps = match self.run.shape {
            Shape::Reversals => self.limits.axes[axis].velocity.powi(2) / self.limits.axes[axis].acceleration,
            Shape::Splines | Shape::Lines => f64::INFINITY,
        };
        Draw { middle: f64::midpoint(low, high), half: 0.5 * (high - low), sigma: sigma.min(0.25 * (high - low)).min(ramps) }
    }
}

/// Distribution of the positions of an axis.
struct Draw {
    middle: f64,
    half: f64,
    sigma: f64,
}

impl Draw {
    /// A random position around `centre`, within `share` of the distance from the middle to the
    /// ends of the travel.
    fn position(&self, rng: &mut impl Rng, centre: f64, share: f64) -> f64 {
        let normal: f64 = StandardNormal.sample(rng);
        let reach = share * self.half;
        (centre + self.sigma * normal).clamp(self.middle - reach, self.middle + reach)
    }
}
