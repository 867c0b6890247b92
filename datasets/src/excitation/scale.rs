//! Time scaling: the highest speed that the limits allow at each position.
//!
//! The splines are functions of a parameter `u` (the time of Paper D, eq. 13). Its rate `du/dt`
//! starts from the limits at each parameter value, is smoothed, and is reduced by one factor until
//! the finite differences of the samples keep every limit.

use motion::Limits;

use super::spline::QuinticSpline;

/// Parameter values between two knots.
const PER_KNOT: usize = 40;
/// Reserve of each limit for the motion between the samples.
const KEPT_BACK: f64 = 0.995;
/// Shares of speed, acceleration and jerk limits for a constant rate; the remainder is for changes
/// of the rate.
const SHARES: [f64; 3] = [1.0, 0.97, 0.75];
/// Largest ratio of the rate to its median; at the ends, where the splines stop, the rate would be
/// unlimited.
const FASTEST: f64 = 1.5;
/// Iterations that bring the samples within the limits.
const ROUNDS: usize = 10;

/// Splines sampled at a uniform rate, within all limits.
pub(super) struct Sampled {
    /// One per axis.
    pub columns: Vec<Vec<f64>>,
    pub duration_s: f64,
}

impl Sampled {
    /// Traverses all splines (of equal duration) with one common, varying rate, at a share of the
    /// speed limits.
    pub fn within(splines: &[QuinticSpline], limits: &Limits, speed_share: f64, period_s: f64) -> Self {
        let bounds = Bounds { limits, speed_share };
        // Approximate duration of a change from zero to full speed.
        let change_s = speed_share * limits.path_velocity_mm_s / limits.path_acceleration_mm_s2;
        let rate = Rate::allowed(splines, &bounds).smoothed(change_s.clamp(0.01, 0.5), period_s);
        let natural_s = rate.duration_s(period_s);
        let mut stretch = 1.0;
        let mut columns = Vec::new();
        let mut samples = 0;
        for _ in 0..ROUNDS {
            // A whole number of samples, so that the last one is the end.
            samples = ((natural_s * stretch / period_s).ceil() as usize).max(2);
            let parameters = rate.parameters(natural_s, samples);
            columns = splines.iter().map(|spline| parameters.iter().map(|u| spline.at(*u)[0]).collect()).collect();
            let excess = sampled_slowdown(&columns, &bounds, period_s);
            if excess <= 1.0 {
                break;
            }
            stretch = (samples as f64 * period_s / natural_s) * excess * 1.001;
        }
        Self { columns, duration_s: samples as f64 * period_s }
    }
}

/// `du/dt` over `u`, linear between parameter values.
struct Rate {
    parameters: Vec<f64>,
    rates: Vec<f64>,
}

impl Rate {
    /// The largest constant rate at each parameter value.
    fn allowed(splines: &[QuinticSpline], bounds: &Bounds) -> Self {
        let end = splines.iter().map(QuinticSpline::duration_s).fold(0.0, f64::max);
        let knots = splines.iter().map(|spline| spline.times().len()).max().unwrap_or(2);
        let count = PER_KNOT * knots;
        let parameters: Vec<f64> = (0..=count).map(|k| end * k as f64 / count as f64).collect();
        let mut rates: Vec<f64> = parameters
            .iter()
            .map(|&u| {
                let derivatives: Vec<[f64; 4]> = splines.iter().map(|spline| spline.at(u)).collect();
                1.0 / bounds.slowdown(SHARES, |axis, order| derivatives[axis][order]).max(f64::MIN_POSITIVE)
            })
            .collect();
        let mut sorted = rates.clone();
        sorted.sort_by(f64::total_cmp);
        // Without motion any rate is possible.
        let fastest = (FASTEST * sorted[sorted.len() / 2]).min(1e3);
        rates.iter_mut().for_each(|rate| *rate = rate.min(fastest));
        Self { parameters, rates }
    }

    fn at(&self, u: f64) -> f64 {
        let next = self.parameters.partition_point(|parameter| *parameter <= u).clamp(1, self.parameters.len() - 1);
        let (before, after) = (self.parameters[next - 1], self.parameters[next]);
        let share = ((u - before) / (after - before)).clamp(0.0, 1.0);
        self.rates[next - 1] + share * (self.rates[next] - self.rates[next - 1])
    }

    fn end(&self) -> f64 {
        self.parameters[self.parameters.len() - 1]
    }

    /// The parameter `step_s` later (fourth-order Runge-Kutta).
    fn advance(&self, u: f64, step_s: f64) -> f64 {
        let a = self.at(u);
        let b = self.at(u + 0.5 * step_s * a);
        let c = self.at(u + 0.5 * step_s * b);
        let d = self.at(u + step_s * c);
        u + step_s * (a + 2.0 * (b + c) + d) / 6.0
    }

    /// A rate that is nowhere higher and takes about `change_s` for its changes: the minimum within
    /// a window, averaged twice.
    fn smoothed(self, change_s: f64, period_s: f64) -> Self {
        let mut parameters = vec![0.0];
        let mut u = 0.0;
        while u < self.end() {
            u = self.advance(u, period_s);
            parameters.push(u.min(self.end()));
        }
        let half = ((0.5 * change_s / period_s).round() as usize).max(1);
        let rates: Vec<f64> = parameters.iter().map(|&u| self.at(u)).collect();
        let lowest = windowed(&rates, 2 * half, |window| window.iter().copied().fold(f64::INFINITY, f64::min));
        let mean = |window: &[f64]| window.iter().sum::<f64>() / window.len() as f64;
        let rates = windowed(&windowed(&lowest, half, mean), half, mean);
        Self { parameters, rates }
    }

    /// Time to the end, s.
    fn duration_s(&self, period_s: f64) -> f64 {
        let (mut u, mut time_s) = (0.0, 0.0);
        loop {
            let next = self.advance(u, period_s);
            if next >= self.end() {
                return time_s + (self.end() - u) / self.at(u);
            }
            (u, time_s) = (next, time_s + period_s);
        }
    }

    /// Parameters at `samples + 1` equal time steps from the start to the end, which is reached
    /// after `natural_s`.
    fn parameters(&self, natural_s: f64, samples: usize) -> Vec<f64> {
        let step_s = natural_s / samples as f64;
        let mut u = 0.0;
        let mut parameters = vec![0.0];
        for _ in 1..samples {
            u = self.advance(u, step_s).min(self.end());
            parameters.push(u);
        }
        parameters.push(self.end());
        parameters
    }
}

/// `of` each value's neighbourhood, `half` values to either side.
fn windowed(values: &[f64], half: usize, of: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    (0..values.len()).map(|k| of(&values[k.saturating_sub(half)..(k + half + 1).min(values.len())])).collect()
}

/// Ratio by which the finite differences of samples, with standstill before and after them, exceed
/// the limits; 1 at the limits.
fn sampled_slowdown(columns: &[Vec<f64>], bounds: &Bounds, period_s: f64) -> f64 {
    let count = columns.first().map_or(0, Vec::len);
    let position = |axis: usize, k: usize| {
        let column = &columns[axis];
        column[k.saturating_sub(3).min(column.len() - 1)]
    };
    (3..count + 6)
        .map(|k| {
            bounds.slowdown([1.0; 3], |axis, order| {
                let p = |back: usize| position(axis, k - back);
                match order {
                    1 => (p(0) - p(1)) / period_s,
                    2 => (p(0) - 2.0 * p(1) + p(2)) / period_s.powi(2),
                    _ => (p(0) - 3.0 * (p(1) - p(2)) - p(3)) / period_s.powi(3),
                }
            })
        })
        .fold(0.0, f64::max)
}

/// Limits of the axes.
struct Bounds<'a> {
    limits: &'a Limits,
    speed_share: f64,
}

impl Bounds<'_> {
    /// Time scaling factor for which the derivatives `of(axis, order)`, orders 1 to 3, keep
    /// `shares` of the limits.
    ///
    /// The path's own limits do not apply: with them no axis would reach its top speed in a random
    /// motion, and programs that do would leave the operating range of the model.
    fn slowdown(&self, shares: [f64; 3], of: impl Fn(usize, usize) -> f64) -> f64 {
        let mut most: f64 = 0.0;
        for order in 1..=3 {
            let stretch = |value: f64, limit: f64| {
                let ratio = value / (KEPT_BACK * shares[order - 1] * limit);
                match order {
                    1 => ratio / self.speed_share,
                    2 => ratio.sqrt(),
                    _ => ratio.cbrt(),
                }
            };
            for (index, limits) in self.limits.axes.iter().enumerate() {
                let limit = [limits.velocity, limits.acceleration, limits.jerk][order - 1];
                most = most.max(stretch(of(index, order).abs(), limit));
            }
        }
        most
    }
}
