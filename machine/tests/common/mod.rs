//! An independent planner and contour error: the tests must not depend on the code under test.
#![allow(dead_code, reason = "every test file uses some of these")]

use motion::{Axis, Limits, Trajectory, Vec3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

pub const PERIOD_S: f64 = 0.002;

/// A densely sampled curve.
pub struct Dense {
    pub points: Vec<Vec3>,
    length: Vec<f64>,
}

impl Dense {
    pub fn of(curve: impl Fn(f64) -> Vec3, last: f64) -> Self {
        let count = 200_000;
        let points: Vec<Vec3> = (0..=count).map(|i| curve(last * f64::from(i) / f64::from(count))).collect();
        let mut length = vec![0.0];
        for pair in points.windows(2) {
            length.push(length[length.len() - 1] + (pair[1] - pair[0]).norm());
        }
        Self { points, length }
    }

    fn at(&self, s: f64) -> Vec3 {
        let i = self.length.partition_point(|l| *l <= s).clamp(1, self.points.len() - 1);
        let f = ((s - self.length[i - 1]) / (self.length[i] - self.length[i - 1])).clamp(0.0, 1.0);
        self.points[i - 1] + f * (self.points[i] - self.points[i - 1])
    }

    fn total(&self) -> f64 {
        self.length[self.length.len() - 1]
    }

    /// Largest speed on a grid of `step` mm, from curvature and the standstill at both ends.
    fn speeds(&self, step: f64, limits: &Limits) -> Vec<f64> {
        let feed = limits.path_velocity_mm_s;
        let acceleration = limits.path_acceleration_mm_s2;
        let count = (self.total() / step) as usize;
        let grid: Vec<Vec3> = (0..=count).map(|i| self.at(i as f64 * step)).collect();
        let mut speed = vec![feed; count + 1];
        for i in 5..count.saturating_sub(5) {
            let curvature = (grid[i + 5] - 2.0 * grid[i] + grid[i - 5]).norm() / (25.0 * step * step);
            speed[i] = feed.min((limits.centripetal_mm_s2 / curvature.max(1e-9)).sqrt());
        }
        speed[0] = 0.0;
        speed[count] = 0.0;
        for i in 1..=count {
            speed[i] = speed[i].min((speed[i - 1].powi(2) + 2.0 * acceleration * step).sqrt());
        }
        for i in (0..count).rev() {
            speed[i] = speed[i].min((speed[i + 1].powi(2) + 2.0 * acceleration * step).sqrt());
        }
        speed
    }

    /// The curve within `limits`, jerk-limited by two 20 ms moving averages, with dwells of 0.1 s.
    pub fn plan(&self, limits: &Limits) -> Trajectory {
        let step = 0.01;
        let speed = self.speeds(step, limits);
        let mut times = vec![0.0];
        for pair in speed.windows(2) {
            times.push(times[times.len() - 1] + 2.0 * step / (pair[0] + pair[1]));
        }
        let (rest, end) = (0.1, times[times.len() - 1]);
        let samples = ((end + 2.0 * rest) / PERIOD_S) as usize;
        let mut arc_lengths: Vec<f64> = (0..samples)
            .map(|k| {
                let t = (k as f64 * PERIOD_S - rest).clamp(0.0, end);
                let i = times.partition_point(|x| *x <= t).clamp(1, times.len() - 1);
                (i as f64 - 1.0 + (t - times[i - 1]) / (times[i] - times[i - 1])) * step
            })
            .collect();
        for _ in 0..2 {
            arc_lengths = moving_average(&arc_lengths, 10);
        }
        let points: Vec<Vec3> = arc_lengths.iter().map(|s| self.at(*s)).collect();
        trajectory((0..3).map(|a| points.iter().map(|p| p[a]).collect()).collect())
    }

    /// Distance of every actual sample from the curve, mm. The foot point is searched near the last
    /// one.
    pub fn contour_error(&self, reference: &Trajectory, actual: &Trajectory) -> Vec<f64> {
        let mut near = 0;
        (0..actual.len())
            .map(|k| {
                let point = point(actual, k);
                // The reference sample lies on the curve: advance to it, then search around it.
                let commanded = self::point(reference, k);
                while near + 1 < self.points.len()
                    && (self.points[near + 1] - commanded).norm() <= (self.points[near] - commanded).norm()
                {
                    near += 1;
                }
                let window = near.saturating_sub(1500)..(near + 1500).min(self.points.len() - 1);
                window.map(|i| segment_distance(&point, &self.points[i], &self.points[i + 1])).fold(f64::INFINITY, f64::min)
            })
            .collect()
    }
}

pub fn segment_distance(point: &Vec3, a: &Vec3, b: &Vec3) -> f64 {
    let chord = b - a;
    let f = ((point - a).dot(&chord) / chord.norm_squared().max(1e-30)).clamp(0.0, 1.0);
    (point - a - f * chord).norm()
}

fn moving_average(values: &[f64], width: usize) -> Vec<f64> {
    let last = values.len() - 1;
    (0..=last)
        .map(|k| {
            let sum: f64 = (0..width).map(|i| values[(k + i).saturating_sub(width / 2).min(last)]).sum();
            sum / width as f64
        })
        .collect()
}

pub fn point(trajectory: &Trajectory, k: usize) -> Vec3 {
    let c = trajectory.columns();
    Vec3::new(c[0][k], c[1][k], c[2][k])
}

pub fn trajectory(columns: Vec<Vec<f64>>) -> Trajectory {
    Trajectory::new(PERIOD_S, Axis::xyz(), columns).unwrap()
}

/// The same positions on all three axes.
pub fn together(column: Vec<f64>) -> Trajectory {
    trajectory(vec![column; 3])
}

pub fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

pub fn peak(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, v| m.max(v.abs()))
}

pub fn crown() -> Dense {
    Dense::of(|u| Vec3::new(40.0 * u.cos(), 40.0 * u.sin(), 10.0 * (4.0 * u).sin()), std::f64::consts::TAU)
}

pub fn spiral() -> Dense {
    Dense::of(
        |u| {
            let r = 8.0 + 4.0 * u / std::f64::consts::PI;
            Vec3::new(r * u.cos(), r * u.sin(), 2.5 * u)
        },
        6.0 * std::f64::consts::PI,
    )
}

pub fn flower() -> Dense {
    Dense::of(
        |u| {
            let r = 30.0 + 25.0 * (6.0 * u).cos();
            Vec3::new(r * u.cos(), r * u.sin(), 10.0 * (3.0 * u).sin())
        },
        std::f64::consts::TAU,
    )
}

/// A curve of continuous curvature through 20 points of N(0, 18²) mm: quintic Hermite pieces with central-difference derivatives.
pub fn random_spline(seed: u64) -> Dense {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || 18.0 * Distribution::<f64>::sample(&StandardNormal, &mut rng);
    let knots: Vec<Vec3> = (0..20).map(|_| Vec3::new(normal(), normal(), normal())).collect();
    let knot = |i: usize| knots[i.min(19)];
    let slope = |i: usize| (knot(i + 1) - knot(i.saturating_sub(1))) * 0.5;
    let bend = |i: usize| knot(i + 1) - 2.0 * knot(i) + knot(i.saturating_sub(1));
    let pieces: Vec<[Vec3; 6]> = (0..19)
        .map(|i| {
            let (v0, v1, a0, a1) = (slope(i), slope(i + 1), bend(i), bend(i + 1));
            let delta = knot(i + 1) - knot(i) - v0 - 0.5 * a0;
            let speed = v1 - v0 - a0;
            let turn = a1 - a0;
            [
                knot(i),
                v0,
                0.5 * a0,
                10.0 * delta - 4.0 * speed + 0.5 * turn,
                -15.0 * delta + 7.0 * speed - turn,
                6.0 * delta - 3.0 * speed + 0.5 * turn,
            ]
        })
        .collect();
    Dense::of(
        move |u| {
            let i = (u as usize).min(18);
            let f = u - i as f64;
            pieces[i].iter().rev().fold(Vec3::zeros(), |sum, c| sum * f + c)
        },
        19.0,
    )
}
