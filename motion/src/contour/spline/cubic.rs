//! One cubic piece of a path, and its nearest point.

use crate::Vec3;

/// Accuracy of minimised distances, mm.
pub(in crate::contour) const TOLERANCE_MM: f64 = 1e-10;
/// The iteration ends with a Newton step that provably misses the minimum by less than this, mm
/// along the piece.
const MISS_MM: f64 = 1e-10;

/// A point on a piece.
#[derive(Debug, Clone, Copy)]
pub(in crate::contour) struct Near {
    /// Parameter in `[0, 1]`.
    pub t: f64,
    /// Squared distance from the query point, mm².
    pub squared: f64,
}

/// A Newton step.
#[derive(Debug, Clone, Copy)]
struct Step {
    /// Parameter after the step.
    next: f64,
    /// Squared tangential distance there, mm².
    squared: f64,
    /// Whether the step misses the minimum by less than [`MISS_MM`].
    is_last: bool,
}

/// `C(t) = c0 + c1 τ + c2 τ² + c3 τ³`, `τ = t − ½`, `t ∈ [0, 1]`, mm, with bounds that exclude most
/// pieces.
///
/// With `s` the larger of `|C′ − chord|/4` at the two ends, the Bézier points give: no point of the
/// piece is farther than `s` from the chord, `|C″| ≤ 24 s` and `|C′| ≥ |chord| − 8 s`.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::contour) struct Cubic {
    c: [Vec3; 4],
    /// Length of the chord, mm.
    pub length: f64,
    /// The bound `s` above, mm.
    slack: f64,
    /// Squared distance from `c0` below which the squared distance to a point is strictly convex
    /// along the piece.
    convex_within_squared: f64,
}

impl Cubic {
    /// The piece between two points with these end derivatives (Paper A, eq. 5).
    #[inline]
    pub fn hermite(start: Vec3, start_slope: Vec3, end: Vec3, end_slope: Vec3) -> Self {
        let chord = end - start;
        let length = chord.norm();
        let (off_start, off_end) = (start_slope - chord, end_slope - chord);
        let slack = 0.25 * off_start.norm_squared().max(off_end.norm_squared()).sqrt();
        let (sum, difference) = (off_start + off_end, off_end - off_start);
        Self {
            c: [0.5 * (start + end) - 0.125 * difference, chord - 0.25 * sum, 0.5 * difference, sum],
            length,
            slack,
            convex_within_squared: convex_within_squared(length, slack),
        }
    }

    /// Whether the bounding sphere excludes any point of the piece nearer to `p` than `distance`.
    #[inline]
    pub fn is_beyond(&self, distance: f64, p: &Vec3) -> bool {
        let reach = self.radius() + distance;
        (p - self.c[0]).norm_squared() >= reach * reach
    }

    /// Whether the piece has zero length.
    #[inline]
    pub fn is_point(&self) -> bool {
        self.length == 0.0 && self.slack == 0.0
    }

    /// Radius of the bounding sphere about `c0`, mm: `|c0 − middle of the chord| ≤ s`.
    fn radius(&self) -> f64 {
        0.5 * self.length + 2.0 * self.slack
    }

    /// Whether the squared distance to `p` is strictly convex along the piece.
    #[inline]
    pub fn is_convex_to(&self, p: &Vec3) -> bool {
        (p - self.c[0]).norm_squared() < self.convex_within_squared
    }

    /// Position at `t`.
    #[inline]
    pub fn point(&self, t: f64) -> Vec3 {
        let [c0, c1, c2, c3] = &self.c;
        let t = t - 0.5;
        c0 + (c1 + (c2 + c3 * t) * t) * t
    }

    /// Derivative with respect to `t` at `t`.
    #[inline]
    pub fn slope(&self, t: f64) -> Vec3 {
        let [_, c1, c2, c3] = &self.c;
        let t = t - 0.5;
        c1 + (2.0 * c2 + 3.0 * c3 * t) * t
    }

    /// The point at `t` and its distance from `p`.
    fn near_at(&self, t: f64, p: &Vec3) -> Near {
        Near { t, squared: (self.point(t) - p).norm_squared() }
    }

    /// The part between `from` and `to`, with its own parameter.
    fn part(&self, from: f64, to: f64) -> Self {
        let width = to - from;
        let (start, end) = (self.point(from), self.point(to));
        let (leaving, arriving) = (self.slope(from) * width, self.slope(to) * width);
        Self::hermite(start, leaving, end, arriving)
    }

    /// Lower bound on the distance from `p`, mm.
    pub fn lower_bound(&self, p: &Vec3) -> f64 {
        off_chord(p - self.point(0.0), self.c[1] + 0.25 * self.c[3]) - self.slack
    }

    /// Nearest point to `p`, searched from `start`. `convex` is [`Self::is_convex_to`].
    #[inline]
    pub fn nearest_from(&self, p: &Vec3, start: f64, convex: bool) -> Near {
        if convex {
            self.newton(p, start)
        } else {
            let near = self.near_at(start, p);
            self.branch(p, near.squared).unwrap_or(near)
        }
    }

    /// Nearest point to `p`, searched from `start`. `None` if none is nearer than `best_squared`.
    pub fn nearer_than(&self, p: &Vec3, start: f64, best_squared: f64) -> Option<Near> {
        if self.is_convex_to(p) {
            let near = self.newton(p, start);
            (near.squared < best_squared).then_some(near)
        } else {
            self.branch(p, best_squared)
        }
    }

    /// Minimum of a strictly convex squared distance: Newton's method on `(C − p)·C′ = 0`.
    #[inline]
    fn newton(&self, p: &Vec3, start: f64) -> Near {
        let step = self.step(p, start);
        if step.is_last && step.next > 0.0 && step.next < 1.0 {
            return Near { t: step.next, squared: step.squared };
        }
        self.bracketed(p, start, step)
    }

    /// Newton's method within a shrinking bracket, from the step `step` at `t`.
    #[inline(never)]
    fn bracketed(&self, p: &Vec3, mut t: f64, mut step: Step) -> Near {
        // Ends that were not evaluated do not bound the bracket.
        let (mut low, mut high) = (-1.0, 2.0);
        for _ in 0..64 {
            if step.next < t {
                high = t;
            } else {
                low = t;
            }
            if low >= 1.0 || high <= 0.0 {
                break;
            }
            let next = step.next.clamp(0.0, 1.0);
            if step.is_last && next == step.next {
                return Near { t: next, squared: step.squared };
            }
            t = if next > low && next < high {
                next
            } else if step.is_last {
                break;
            } else {
                0.5 * (f64::max(low, 0.0) + f64::min(high, 1.0))
            };
            step = self.step(p, t);
        }
        self.near_at(t, p)
    }

    /// One Newton step from `t`.
    #[inline(always)]
    fn step(&self, p: &Vec3, t: f64) -> Step {
        let [c0, c1, c2, c3] = &self.c;
        let from_middle = t - 0.5;
        let gap = (c0 - p) + (c1 + (c2 + c3 * from_middle) * from_middle) * from_middle;
        let bend = c2 + 3.0 * c3 * from_middle;
        let slope = c1 + (c2 + bend) * from_middle;
        let (speed_squared, squared) = (slope.norm_squared(), gap.norm_squared());
        let convexity = speed_squared + 2.0 * gap.dot(&bend);
        let moved = -gap.dot(&slope) / convexity;
        // The step misses by `½|g″|/g′·moved²`, where `|g″| ≤ 3|C′||C″| + |C − p||C‴|` and `|C‴| ≤
        // 48 s`. The curvature of so short a step is negligible.
        let miss = moved * moved * self.slack * (48.0 * speed_squared + 12.0 * squared);
        Step { next: t + moved, squared: (gap + slope * moved).norm_squared(), is_last: miss <= MISS_MM * convexity }
    }

    /// Global minimum if the squared distance may have several: bisects until a part is convex,
    /// cannot be nearer, or is a point.
    #[cold]
    #[inline(never)]
    fn branch(&self, p: &Vec3, best_squared: f64) -> Option<Near> {
        let mut best = None;
        let mut least = best_squared;
        for t in [0.0, 0.5, 1.0] {
            let near = self.near_at(t, p);
            if near.squared < least {
                least = near.squared;
                best = Some(near);
            }
        }
        self.branch_part(self, p, (0.0, 1.0), &mut least, &mut best);
        best
    }

    /// The only minimum of the distance from `p` within the piece. `Some(None)`: the nearest point
    /// is an end. `None`: there may be several minima.
    ///
    /// `(C − p)·C′` is a polynomial of degree five. It changes sign at most as often as its
    /// Bernstein coefficients.
    fn single_minimum(&self, p: &Vec3) -> Option<Option<f64>> {
        let (leaving, arriving) = (self.slope(0.0), self.slope(1.0));
        let (start, end) = (self.point(0.0) - p, self.point(1.0) - p);
        let gap = [start, start + leaving / 3.0, end - arriving / 3.0, end];
        let slope = [leaving, 3.0 * (gap[2] - gap[1]), arriving];
        let [a, b, c, d] = gap.map(|gap| slope.map(|slope| gap.dot(&slope)));
        let signs = [
            a[0],
            2.0 * a[1] + 3.0 * b[0],
            a[2] + 6.0 * b[1] + 3.0 * c[0],
            3.0 * b[2] + 6.0 * c[1] + d[0],
            3.0 * c[2] + 2.0 * d[1],
            d[2],
        ];
        let changes = signs.windows(2).filter(|pair| (pair[0] < 0.0) != (pair[1] < 0.0)).count();
        match changes {
            0 => Some(None),
            1 if signs[0] < 0.0 => Some(Some(self.only_minimum(p))),
            1 => Some(None),
            _ => None,
        }
    }

    /// The minimum of a distance that falls and then grows: Newton's method within a bracket.
    fn only_minimum(&self, p: &Vec3) -> f64 {
        let (mut low, mut high, mut t) = (0.0, 1.0, 0.5);
        for _ in 0..60 {
            let (gap, slope) = (self.point(t) - p, self.slope(t));
            let bend = 2.0 * self.c[2] + 6.0 * self.c[3] * (t - 0.5);
            let along = gap.dot(&slope);
            if along > 0.0 {
                high = t;
            } else {
                low = t;
            }
            let convexity = slope.norm_squared() + gap.dot(&bend);
            let newton = t - along / convexity;
            let next = if convexity > 0.0 && newton > low && newton < high { newton } else { 0.5 * (low + high) };
            let moved = (next - t).abs() * slope.norm();
            t = next;
            if moved < 1e-2 * TOLERANCE_MM {
                break;
            }
        }
        t
    }

    fn branch_part(&self, part: &Self, p: &Vec3, (from, to): (f64, f64), least: &mut f64, best: &mut Option<Near>) {
        let width = to - from;
        if part.lower_bound(p) >= least.sqrt() - TOLERANCE_MM || width < 1e-13 {
            return;
        }
        let single_minimum = part.single_minimum(p);
        // The ends were evaluated before.
        let Some(t) = single_minimum.unwrap_or(Some(0.5)) else { return };
        let near = self.near_at(from + width * t, p);
        if near.squared < *least {
            *least = near.squared;
            *best = Some(near);
        }
        if single_minimum.is_some() || part.radius() < TOLERANCE_MM {
            return;
        }
        let middle = 0.5 * (from + to);
        let mut halves = [(from, middle), (middle, to)].map(|span| (self.part(span.0, span.1), span));
        if halves[1].0.lower_bound(p) < halves[0].0.lower_bound(p) {
            halves.swap(0, 1);
        }
        for (half, span) in &halves {
            self.branch_part(half, p, *span, least, best);
        }
    }
}

/// The squared distance to `p` is strictly convex if `|C′|² > |C − p||C″|` everywhere, with `|C −
/// p|² ≤ 2|p − c0|² + 2 radius²`.
#[inline]
fn convex_within_squared(length: f64, slack: f64) -> f64 {
    let radius = 0.5 * length + 2.0 * slack;
    let slowest = (length - 8.0 * slack).max(0.0);
    let reach = slowest * slowest / (24.0 * slack).max(f64::MIN_POSITIVE);
    0.5 * reach * reach - radius * radius
}

/// Distance of `point` from the chord `[0, chord]`, mm.
fn off_chord(point: Vec3, chord: Vec3) -> f64 {
    let length_squared = chord.norm_squared();
    let along = point.dot(&chord);
    let share = if along <= 0.0 {
        0.0
    } else if along >= length_squared {
        1.0
    } else {
        along / length_squared
    };
    (point - chord * share).norm()
}
