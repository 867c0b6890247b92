//! Shared code of the contour tests: curves, a motion along them, a lagging axis, and distances by
//! brute force.
#![allow(dead_code)]

use motion::{Curve, Vec3};

pub const PERIOD_S: f64 = 0.002;

type Formula = Box<dyn Fn(f64) -> [Vec3; 4] + Send + Sync>;

/// A curve by its formula.
pub struct Analytic {
    pub domain: (f64, f64),
    pub formula: Formula,
}

impl std::fmt::Debug for Analytic {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Analytic({:?})", self.domain)
    }
}

impl Curve for Analytic {
    fn domain(&self) -> (f64, f64) {
        self.domain
    }

    fn derivatives(&self, u: f64) -> [Vec3; 4] {
        (self.formula)(u.clamp(self.domain.0, self.domain.1))
    }
}

/// `r(u)·(cos u, sin u)` and `z(u)`, each with two derivatives.
pub fn polar(
    domain: (f64, f64),
    r: impl Fn(f64) -> [f64; 3] + Send + Sync + 'static,
    z: impl Fn(f64) -> [f64; 3] + Send + Sync + 'static,
) -> Analytic {
    let formula = move |u: f64| {
        let ([r, r1, r2], [z, z1, z2]) = (r(u), z(u));
        let (sin, cos) = u.sin_cos();
        [
            Vec3::new(r * cos, r * sin, z),
            Vec3::new(r1 * cos - r * sin, r1 * sin + r * cos, z1),
            Vec3::new((r2 - r) * cos - 2.0 * r1 * sin, (r2 - r) * sin + 2.0 * r1 * cos, z2),
            Vec3::zeros(),
        ]
    };
    Analytic { domain, formula: Box::new(formula) }
}

const TURN: f64 = std::f64::consts::TAU;

pub fn circle(radius: f64) -> Analytic {
    polar((0.0, TURN), move |_| [radius, 0.0, 0.0], |_| [0.0; 3])
}

pub fn helix(radius: f64, pitch: f64, turns: f64) -> Analytic {
    let rise = pitch / TURN;
    polar((0.0, TURN * turns), move |_| [radius, 0.0, 0.0], move |u| [rise * u, rise, 0.0])
}

/// `r = 8 + 4u/π`, rising (MACHINE.md).
pub fn spiral() -> Analytic {
    let grow = 8.0 / TURN;
    polar((0.0, 3.0 * TURN), move |u| [8.0 + grow * u, grow, 0.0], |u| [2.5 * u, 2.5, 0.0])
}

/// `r = a + b cos cu` in the plane (Paper A, eq. 44; Paper D, eq. 25).
pub fn flower(a: f64, b: f64, c: f64) -> Analytic {
    polar(
        (0.0, TURN),
        move |u| {
            let (sin, cos) = (c * u).sin_cos();
            [a + b * cos, -b * c * sin, -b * c * c * cos]
        },
        |_| [0.0; 3],
    )
}

/// A line with a sine on it.
pub fn wave(length: f64, height: f64, waves: f64) -> Analytic {
    let k = TURN * waves / length;
    Analytic {
        domain: (0.0, length),
        formula: Box::new(move |u| {
            let (sin, cos) = (k * u).sin_cos();
            [
                Vec3::new(u, height * sin, 0.0),
                Vec3::new(1.0, height * k * cos, 0.0),
                Vec3::new(0.0, -height * k * k * sin, 0.0),
                Vec3::zeros(),
            ]
        }),
    }
}

/// A figure eight, self-intersecting at right angles.
pub fn eight(size: f64) -> Analytic {
    Analytic {
        domain: (0.0, TURN),
        formula: Box::new(move |u| {
            let ((s1, c1), (s2, c2)) = (u.sin_cos(), (2.0 * u).sin_cos());
            [
                Vec3::new(size * s1, 0.5 * size * s2, 0.0),
                Vec3::new(size * c1, size * c2, 0.0),
                Vec3::new(-size * s1, -2.0 * size * s2, 0.0),
                Vec3::zeros(),
            ]
        }),
    }
}

/// Straight legs along x, a gap apart in y, joined by half circles. The parameter is the arc
/// length.
pub fn hairpins(leg: f64, gap: f64, legs: usize) -> Analytic {
    let bend = 0.5 * gap * std::f64::consts::PI;
    let cell = leg + bend;
    let total = cell * legs as f64 - bend;
    Analytic {
        domain: (0.0, total),
        formula: Box::new(move |s| {
            let index = ((s / cell) as usize).min(legs - 1);
            let along = s - index as f64 * cell;
            let forth = index.is_multiple_of(2);
            let direction = if forth { 1.0 } else { -1.0 };
            let y = index as f64 * gap;
            if along <= leg {
                let x = if forth { along } else { leg - along };
                return [Vec3::new(x, y, 0.0), Vec3::new(direction, 0.0, 0.0), Vec3::zeros(), Vec3::zeros()];
            }
            let radius = 0.5 * gap;
            let (sin, cos) = ((along - leg) / radius).sin_cos();
            let end = if forth { leg } else { 0.0 };
            [
                Vec3::new(end + direction * radius * sin, y + radius * (1.0 - cos), 0.0),
                Vec3::new(direction * cos, sin, 0.0),
                Vec3::new(-direction * sin, cos, 0.0) / radius,
                Vec3::zeros(),
            ]
        }),
    }
}

/// A motion from standstill to standstill: curve parameter and position every `period_s`. The feed
/// keeps `acceleration` across and along the path and is smoothed by two moving averages of 20 ms.
pub fn travel(curve: &dyn Curve, feed_mm_s: f64, acceleration: f64, period_s: f64) -> (Vec<f64>, Vec<Vec3>) {
    const FINE: usize = 200_000;
    let (first, last) = curve.domain();
    let parameter = |i: usize| first + (last - first) * i as f64 / FINE as f64;
    let mut arcs = Vec::with_capacity(FINE + 1);
    let mut speeds = Vec::with_capacity(FINE + 1);
    let mut before = curve.point(first);
    let mut arc = 0.0;
    for i in 0..=FINE {
        let [point, slope, bend, _] = curve.derivatives(parameter(i));
        arc += (point - before).norm();
        before = point;
        arcs.push(arc);
        let speed = slope.norm();
        let curvature = slope.cross(&bend).norm() / (speed * speed * speed).max(1e-30);
        speeds.push(feed_mm_s.min((acceleration / curvature.max(1e-12)).sqrt()));
    }
    speeds[0] = 0.0;
    speeds[FINE] = 0.0;
    let reachable = |from: f64, distance: f64| (from * from + 2.0 * acceleration * distance).sqrt();
    for i in 1..=FINE {
        speeds[i] = speeds[i].min(reachable(speeds[i - 1], arcs[i] - arcs[i - 1]));
    }
    for i in (0..FINE).rev() {
        speeds[i] = speeds[i].min(reachable(speeds[i + 1], arcs[i + 1] - arcs[i]));
    }
    let mut times = vec![0.0];
    for i in 1..=FINE {
        let mean = (0.5 * (speeds[i] + speeds[i - 1])).max(1e-9);
        times.push(times[i - 1] + (arcs[i] - arcs[i - 1]) / mean);
    }
    let step_s = 1e-4;
    let count = (times[FINE] / step_s).ceil() as usize + 1;
    let mut at = 0;
    let mut arc_lengths: Vec<f64> = (0..count)
        .map(|k| {
            let t = k as f64 * step_s;
            while at + 2 < times.len() && times[at + 1] < t {
                at += 1;
            }
            let share = ((t - times[at]) / (times[at + 1] - times[at]).max(1e-30)).clamp(0.0, 1.0);
            arcs[at] + share * (arcs[at + 1] - arcs[at])
        })
        .collect();
    for _ in 0..2 {
        let width = 200;
        let padded: Vec<f64> =
            std::iter::repeat_n(0.0, width).chain(arc_lengths.iter().copied()).chain(std::iter::repeat_n(arc, width)).collect();
        let mut sum: f64 = padded[..width].iter().sum();
        arc_lengths = (0..padded.len() - width)
            .map(|k| {
                sum += padded[k + width] - padded[k];
                sum / width as f64
            })
            .collect();
    }
    let stride = (period_s / step_s).round() as usize;
    let mut at = 0;
    arc_lengths
        .iter()
        .step_by(stride)
        .map(|s| {
            while at + 2 < arcs.len() && arcs[at + 1] < *s {
                at += 1;
            }
            let share = ((s - arcs[at]) / (arcs[at + 1] - arcs[at]).max(1e-30)).clamp(0.0, 1.0);
            let u = parameter(at) + share * (parameter(at + 1) - parameter(at));
            (u, curve.point(u))
        })
        .unzip()
}

/// First-order lags, one per axis (s), of a piecewise linear reference. Positions at `per` instants
/// per sample.
pub fn lagged(reference: &[Vec3], lags_s: [f64; 3], period_s: f64, per: usize) -> Vec<Vec3> {
    let mut actual = vec![reference[0]];
    for pair in reference.windows(2) {
        let start = *actual.last().unwrap();
        for i in 1..=per {
            let t = period_s * i as f64 / per as f64;
            actual.push(Vec3::from_fn(|axis, _| {
                let rate = (pair[1][axis] - pair[0][axis]) / period_s;
                let behind = rate * lags_s[axis];
                let settled = pair[0][axis] + rate * t - behind;
                settled + (start[axis] - pair[0][axis] + behind) * (-t / lags_s[axis]).exp()
            }));
        }
    }
    actual
}

/// Least distance between `p` and `place(x)`, `low ≤ x ≤ high`: a scan of `points` points, then
/// golden section around every local minimum of the scan that can be the least.
pub fn brute_force(place: &dyn Fn(f64) -> Vec3, low: f64, high: f64, points: usize, p: &Vec3) -> (f64, f64) {
    let x = |i: usize| low + (high - low) * i as f64 / points as f64;
    let far = |x: f64| (place(x) - p).norm();
    let scan: Vec<f64> = (0..=points).map(|i| far(x(i))).collect();
    let least = scan.iter().copied().fold(f64::INFINITY, f64::min);
    let step = scan.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
    let mut best = (f64::INFINITY, low);
    for i in 0..=points {
        let dip = (i == 0 || scan[i] <= scan[i - 1]) && (i == points || scan[i] <= scan[i + 1]);
        if !dip || scan[i] > least + 2.0 * step {
            continue;
        }
        let (mut a, mut b) = (x(i.saturating_sub(1)), x((i + 1).min(points)));
        let golden = 0.618_033_988_749_894_9;
        for _ in 0..120 {
            let (c, d) = (b - golden * (b - a), a + golden * (b - a));
            if far(c) < far(d) {
                b = d;
            } else {
                a = c;
            }
        }
        for x in [a, b, 0.5 * (a + b), x(i)] {
            if far(x) < best.0 {
                best = (far(x), x);
            }
        }
    }
    best
}

pub fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, f64::max)
}
