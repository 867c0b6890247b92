//! Minimises the contour error by steps through a machine's linear response.

use motion::contour::{ContourEstimator, Exact, Location};
use motion::{DesiredPath, Trajectory, Vec3};
use rayon::prelude::*;

use crate::{CompensationError, CompensationLaw, ImpulseResponse, LowPass, PoseErrors, pose_errors};

/// One Gauss–Newton step on the contour error of a machine whose axes place the tip directly.
///
/// With the shift `δ` of the reference, the impulse responses `P` of the axes and the foot point of
/// desired sample `k` at the (fractional) sample `p(k)` of the run, the error becomes `ε(k) −
/// N(k)·(Pδ)(p(k))`. `N = I − (1 − c)·ττᵀ` removes the component along the path's tangent `τ`. The
/// squared cosine `c` between error and tangent keeps all of it where the nearest point is no foot
/// point: at starts, stops and corners. The step minimises
/// ```text
/// Σ w(k) |ε(k) − N(k)(Pδ)(p(k))|² + λ·Σ |δ|²
/// ```
/// by matrix-free conjugate gradients: `P` is a filter, its adjoint the same filter in reversed
/// time. Nothing is learned at frequencies where the response of the machine is small, nor above the
/// cut-off of a low-pass, where one is set. The weights `w = 1 + (|ε|/2·RMS)²`, at most 10, emphasise
/// large errors.
pub struct ContourOptimal {
    responses: Vec<ImpulseResponse>,
    estimator: Box<dyn ContourEstimator>,
    damping: f64,
    low_pass: Option<LowPass>,
}

/// Iterations of the solver. The first ones solve for directions with a large response; the later
/// ones for directions that the damping limits anyway.
const ITERATIONS: usize = 25;
/// Relative residual at which it stops: a step through a linear response is not more accurate.
const TOLERANCE: f64 = 0.01;
/// Largest weight of a sample.
const MOST_WEIGHT: f64 = 10.0;

impl ContourOptimal {
    /// The law for a machine with these responses, one per axis, with damping `λ` relative to a
    /// response of 1.
    ///
    /// # Errors
    /// When the damping is not positive.
    pub fn new(responses: Vec<ImpulseResponse>, damping: f64) -> Result<Self, CompensationError> {
        let mut law = Self { responses, estimator: Box::new(Exact::default()), damping, low_pass: None };
        law.damp(damping)?;
        Ok(law)
    }

    /// Sets the damping `λ` of the next steps.
    ///
    /// # Errors
    /// When it is not positive.
    pub fn damp(&mut self, damping: f64) -> Result<(), CompensationError> {
        if !(damping.is_finite() && damping > 0.0) {
            let remedy = "it must be positive and finite";
            return Err(CompensationError::BadSetting { name: "damping of a step", value: damping, remedy });
        }
        self.damping = damping;
        Ok(())
    }

    /// Sets the zero-phase low-pass on the shift of the next steps.
    pub fn smooth(&mut self, low_pass: Option<LowPass>) {
        self.low_pass = low_pass;
    }

    /// Largest mean delay of the responses, samples.
    #[must_use]
    pub fn delay_samples(&self) -> f64 {
        self.responses.iter().map(ImpulseResponse::delay_samples).fold(0.0, f64::max)
    }

    /// Samples after which most of the slowest response has arrived.
    #[must_use]
    pub fn reach(&self) -> usize {
        (2.0 * self.delay_samples()).ceil() as usize + 5
    }
}

impl CompensationLaw for ContourOptimal {
    fn name(&self) -> &'static str {
        "contour-optimal"
    }

    fn update(
        &mut self,
        desired: &DesiredPath,
        reference: &Trajectory,
        actual: &Trajectory,
    ) -> Result<Trajectory, CompensationError> {
        let path = desired.trajectory();
        if desired.kinematics().has_rotary_axes() || path.axes().len() != self.responses.len() || path.axes().len() > 3 {
            return Err(CompensationError::BadSetting {
                name: "number of axes",
                value: path.axes().len() as f64,
                remedy: "this law needs a response for every axis, and axes that are coordinates of the tip",
            });
        }
        let PoseErrors { contour, actual: poses, .. } = pose_errors(desired, actual, self.estimator.as_mut())?;
        let tips = desired.tips();
        let run: Vec<Vec3> = poses.iter().map(|pose| pose.tip).collect();
        let from_run = self.estimator.estimate(&run, &tips)?;
        let squares = contour.iter().chain(&from_run).map(|error| error.vector.norm_squared());
        let mean_square = squares.sum::<f64>() / (2 * contour.len()).max(1) as f64;
        let weight =
            |error: Vec3| (1.0 + 0.25 * error.norm_squared() / mean_square.max(f64::MIN_POSITIVE)).min(MOST_WEIGHT).sqrt();
        // Share of the tangential component that `N` removes: none if the error itself is
        // tangential.
        let across = |tangent: Vec3, error: Vec3| {
            let along = tangent.dot(&error).powi(2) / error.norm_squared().max(f64::MIN_POSITIVE);
            tangent * (1.0 - along).max(0.0).sqrt()
        };
        let of_desired = contour.iter().enumerate().map(|(k, error)| {
            let step = tips[(k + 1).min(tips.len() - 1)] - tips[k.saturating_sub(1)];
            let tangent = step.try_normalize(1e-9).unwrap_or_else(Vec3::zeros);
            // At the run's last sample a lagging axis is still moving: the remaining distance is no
            // contour error.
            let off = if error.at_end { tangent } else { across(tangent, error.vector) };
            (Row { off, weight: weight(error.vector), location: error.location }, error.vector)
        });
        let of_run = from_run.iter().enumerate().map(|(k, error)| {
            let location = Location { segment: k, fraction: 0.0, arc_mm: 0.0 };
            (Row { off: across(error.tangent, error.vector), weight: weight(error.vector), location }, -error.vector)
        });
        let (rows, errors): (Vec<Row>, Vec<Vec3>) = of_desired.chain(of_run).unzip();
        let system = System { responses: &self.responses, rows: &rows, samples: path.len(), damping: self.damping };
        let errors: Vec<Vec3> = errors.into_iter().zip(&rows).map(|(error, row)| row.project(error) * row.weight).collect();
        let change = system.solve(&system.transposed(&errors));
        let columns = reference.columns().iter().zip(change.chunks_exact(path.len().max(1)));
        let shifted = columns.map(|(column, change)| {
            let smooth = self.low_pass.map(|low_pass| low_pass.zero_phase(change));
            column.iter().zip(smooth.as_deref().unwrap_or(change)).map(|(r, d)| r + d).collect()
        });
        Ok(reference.with_columns(shifted.collect())?)
    }
}

/// Linear response of the error at one desired sample.
struct Row {
    /// `√(1 − c)·τ`: `N = I − off·offᵀ`.
    off: Vec3,
    /// `√w`.
    weight: f64,
    location: Location,
}

impl Row {
    fn project(&self, vector: Vec3) -> Vec3 {
        vector - self.off * self.off.dot(&vector)
    }
}

/// The normal equations; vectors hold all samples of the first axis, then of the second, and so on.
struct System<'a> {
    responses: &'a [ImpulseResponse],
    rows: &'a [Row],
    samples: usize,
    damping: f64,
}

impl System<'_> {
    /// `√w·N·(Pδ)(p)` at every desired sample.
    fn forward(&self, shift: &[f64]) -> Vec<Vec3> {
        let moved = self.filtered(shift, ImpulseResponse::apply);
        let last = self.samples.saturating_sub(1);
        self.rows
            .par_iter()
            .with_min_len(4096)
            .map(|row| {
                let (before, share) = (row.location.segment.min(last), row.location.fraction);
                let after = (before + 1).min(last);
                let mut vector = Vec3::zeros();
                for axis in 0..self.responses.len() {
                    let column = &moved[axis * self.samples..];
                    vector[axis] = column[before] + share * (column[after] - column[before]);
                }
                row.project(vector) * row.weight
            })
            .collect()
    }

    /// The adjoint of [`System::forward`].
    fn transposed(&self, errors: &[Vec3]) -> Vec<f64> {
        let mut spread = vec![0.0; self.samples * self.responses.len()];
        let last = self.samples.saturating_sub(1);
        for (row, error) in self.rows.iter().zip(errors) {
            let vector = row.project(*error) * row.weight;
            let (before, share) = (row.location.segment.min(last), row.location.fraction);
            let after = (before + 1).min(last);
            for axis in 0..self.responses.len() {
                let column = &mut spread[axis * self.samples..];
                column[before] += (1.0 - share) * vector[axis];
                column[after] += share * vector[axis];
            }
        }
        self.filtered(&spread, ImpulseResponse::apply_transposed)
    }

    fn filtered(&self, from: &[f64], filter: impl Fn(&ImpulseResponse, &[f64], &mut [f64]) + Sync) -> Vec<f64> {
        let mut to = vec![0.0; from.len()];
        let samples = self.samples.max(1);
        let parts = to.par_chunks_exact_mut(samples).zip(from.par_chunks_exact(samples)).zip(self.responses);
        parts.for_each(|((to, from), response)| filter(response, from, to));
        to
    }

    /// `(AᵀA + λ)⁻¹·right` by conjugate gradients.
    fn solve(&self, right: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; right.len()];
        let mut residual = right.to_vec();
        let mut direction = residual.clone();
        let mut square = dot(&residual, &residual);
        let enough = TOLERANCE * TOLERANCE * square;
        for _ in 0..ITERATIONS {
            if square <= enough || square == 0.0 {
                break;
            }
            let mut image = self.transposed(&self.forward(&direction));
            image.iter_mut().zip(&direction).for_each(|(i, d)| *i += self.damping * d);
            let step = square / dot(&direction, &image);
            for ((x, r), (d, i)) in x.iter_mut().zip(&mut residual).zip(direction.iter().zip(&image)) {
                *x += step * d;
                *r -= step * i;
            }
            let next = dot(&residual, &residual);
            let keep = next / square;
            square = next;
            direction.iter_mut().zip(&residual).for_each(|(d, r)| *d = r + keep * *d);
        }
        x
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_transposed_system_is_the_adjoint() {
        let responses: Vec<ImpulseResponse> =
            [0.6, 0.8].map(|p: f64| ImpulseResponse::new((0..20).map(|k| (1.0 - p) * p.powi(k)).collect()).unwrap()).into();
        let samples = 60;
        let rows: Vec<Row> = (0..samples)
            .map(|k| {
                let angle = k as f64 * 0.1;
                let location = Location { segment: (k + 3).min(samples - 1), fraction: 0.3, arc_mm: 0.0 };
                Row { off: Vec3::new(angle.cos(), angle.sin(), 0.0) * 0.9, weight: 1.0 + angle.sin().abs(), location }
            })
            .collect();
        let system = System { responses: &responses, rows: &rows, samples, damping: 0.1 };
        let shift: Vec<f64> = (0..2 * samples).map(|i| ((i * i) as f64 * 0.37).sin()).collect();
        let errors: Vec<Vec3> = (0..samples).map(|k| Vec3::new((k as f64).sin(), (k as f64 * 1.7).cos(), 0.0)).collect();
        let left: f64 = system.forward(&shift).iter().zip(&errors).map(|(a, b)| a.dot(b)).sum();
        let right = dot(&shift, &system.transposed(&errors));
        assert!((left - right).abs() < 1e-9 * left.abs().max(1.0), "{left} {right}");
    }
}
