//! Norm-optimal ILC and its cross-coupled form, N.O.-CCILC (Paper E).

use motion::{DesiredPath, Trajectory};

use crate::{CompensationError, CompensationLaw, ImpulseResponse};

/// Weights of the cost `J = eᵀ(a·Q_cc + b·I)e + uᵀSu + (u⁺ − u)ᵀR(u⁺ − u)`, `b = 1 − a` (Paper E, eq. 18); `S = s·I`, `R = r·I`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormOptimalSettings {
    /// Share of the contour error: 0 weighs the error of every axis separately (N.O.-ILC), 1 the
    /// contour error only (N.O.-CCILC).
    pub a: f64,
    /// Weight of the shift; it limits effort and sets the robustness.
    pub s: f64,
    /// Weight of the change of the shift from run to run; it damps noise.
    pub r: f64,
}

impl Default for NormOptimalSettings {
    /// The paper's `S = R = 1e-3·I` (eq. 21).
    fn default() -> Self {
        Self { a: 0.0, s: 1e-3, r: 1e-3 }
    }
}

/// `u⁺ = 𝒬u + ℒe` (Paper E, eq. 9) with the shift `u` = reference − desired, the tracking error
/// `e`, and `P` the axes' impulse responses (eq. 3-6). Solved as `(PᵀQP + S + R)(u⁺ − u) = PᵀQe −
/// Su` by matrix-free conjugate gradients: `P` is a filter, `Pᵀ` the same filter in reversed time.
///
/// In `n` axes the contour error's weight at a sample is the projector `I − ττᵀ` off the path's tangent `τ` (in the plane `CᵀC`, eq. 1-2).
pub struct NormOptimalIlc {
    settings: NormOptimalSettings,
    responses: Vec<ImpulseResponse>,
}

/// Relative residual at which the solver stops.
const TOLERANCE: f64 = 1e-11;
/// Maximum number of iterations.
const ITERATIONS: usize = 2000;

impl NormOptimalIlc {
    /// The law for a machine with these responses, one per axis.
    ///
    /// # Errors
    /// When `a` is not within 0…1, or `s` and `r` are negative or both zero.
    pub fn new(settings: NormOptimalSettings, responses: Vec<ImpulseResponse>) -> Result<Self, CompensationError> {
        let NormOptimalSettings { a, s, r } = settings;
        let bad = |name, value, remedy| Err(CompensationError::BadSetting { name, value, remedy });
        if !(0.0..=1.0).contains(&a) {
            return bad("share of the contour error `a`", a, "it lies between 0 and 1");
        }
        if !(s >= 0.0 && r >= 0.0 && s + r > 0.0 && (s + r).is_finite()) {
            return bad("weight `S + R`", s + r, "both are at least zero, and one of them is positive");
        }
        Ok(Self { settings, responses })
    }

    /// Relative error of the responses up to which learning converges monotonically: `1/‖(PᵀQP +
    /// S)⁻¹PᵀQP‖` (Paper E, section III-C), independent of `R`. By power iteration.
    ///
    /// # Errors
    /// When the axes of the path are not those of the responses.
    pub fn permitted_model_error(&self, desired: &DesiredPath) -> Result<f64, CompensationError> {
        let lifted = self.lifted(desired.trajectory(), self.settings.s.max(1e-9))?;
        let mut x: Vec<f64> = (0..lifted.size()).map(|i| ((i * 7919) % 101) as f64 - 50.0).collect();
        let mut gain: f64 = 0.0;
        for _ in 0..30 {
            let norm = dot(&x, &x).sqrt();
            x.iter_mut().for_each(|value| *value /= norm);
            // With N = PᵀQP and s·I, T = (N + sI)⁻¹N is symmetric.
            let mut image = lifted.normal(&x);
            for (image, x) in image.iter_mut().zip(&x) {
                *image -= lifted.damping * x;
            }
            let y = lifted.solve(&image);
            gain = dot(&y, &y).sqrt();
            x = y;
        }
        Ok(1.0 / gain)
    }

    fn lifted(&self, path: &Trajectory, damping: f64) -> Result<Lifted<'_>, CompensationError> {
        if path.axes().len() != self.responses.len() {
            return Err(CompensationError::BadSetting {
                name: "number of impulse responses",
                value: self.responses.len() as f64,
                remedy: "give one for every axis of the path",
            });
        }
        Ok(Lifted { responses: &self.responses, tangents: tangents(path), samples: path.len(), a: self.settings.a, damping })
    }
}

impl CompensationLaw for NormOptimalIlc {
    fn name(&self) -> &'static str {
        if self.settings.a > 0.0 { "cross-coupled-ilc" } else { "norm-optimal-ilc" }
    }

    fn update(
        &mut self,
        desired: &DesiredPath,
        reference: &Trajectory,
        actual: &Trajectory,
    ) -> Result<Trajectory, CompensationError> {
        let path = desired.trajectory();
        let lifted = self.lifted(path, self.settings.s + self.settings.r)?;
        let shift = reference.tracking_error(path)?;
        let mut error: Vec<f64> = path.tracking_error(actual)?.concat();
        lifted.weigh(&mut error);
        let mut right = lifted.transposed(&error);
        for (right, shift) in right.iter_mut().zip(shift.iter().flatten()) {
            *right -= self.settings.s * shift;
        }
        let change = lifted.solve(&right);
        let columns = reference.columns().iter().zip(change.chunks_exact(lifted.samples.max(1)));
        let columns = columns.map(|(column, change)| column.iter().zip(change).map(|(r, d)| r + d).collect()).collect();
        Ok(reference.with_columns(columns)?)
    }
}

/// The lifted system: vectors hold all samples of the first axis, then of the second, and so on.
struct Lifted<'a> {
    responses: &'a [ImpulseResponse],
    /// Unit tangent at every sample, axis by axis; zero where the path has no direction.
    tangents: Vec<f64>,
    samples: usize,
    a: f64,
    damping: f64,
}

impl Lifted<'_> {
    fn size(&self) -> usize {
        self.samples * self.responses.len()
    }

    /// `e ← Q·e = e − a·τ(τᵀe)`: `a·(I − ττᵀ) + (1 − a)·I`.
    fn weigh(&self, e: &mut [f64]) {
        if self.a == 0.0 {
            return;
        }
        let axes = self.responses.len();
        for k in 0..self.samples {
            let index = |axis: usize| axis * self.samples + k;
            let along: f64 = (0..axes).map(|axis| self.tangents[index(axis)] * e[index(axis)]).sum();
            for axis in 0..axes {
                e[index(axis)] -= self.a * along * self.tangents[index(axis)];
            }
        }
    }

    /// `P·u`, the axes side by side.
    fn forward(&self, u: &[f64]) -> Vec<f64> {
        self.each_axis(u, ImpulseResponse::apply)
    }

    /// `Pᵀ·e`.
    fn transposed(&self, e: &[f64]) -> Vec<f64> {
        self.each_axis(e, ImpulseResponse::apply_transposed)
    }

    fn each_axis(&self, from: &[f64], filter: impl Fn(&ImpulseResponse, &[f64], &mut [f64]) + Sync) -> Vec<f64> {
        let mut to = vec![0.0; from.len()];
        let filter = &filter;
        std::thread::scope(|scope| {
            let samples = self.samples.max(1);
            let parts = from.chunks_exact(samples).zip(to.chunks_exact_mut(samples));
            for (response, (from, to)) in self.responses.iter().zip(parts) {
                if self.samples < SPAWN_SAMPLES {
                    filter(response, from, to);
                } else {
                    scope.spawn(move || filter(response, from, to));
                }
            }
        });
        to
    }

    /// `(PᵀQP + damping·I)·u`.
    fn normal(&self, u: &[f64]) -> Vec<f64> {
        let mut e = self.forward(u);
        self.weigh(&mut e);
        let mut out = self.transposed(&e);
        for (out, u) in out.iter_mut().zip(u) {
            *out += self.damping * u;
        }
        out
    }

    /// `(PᵀQP + damping·I)⁻¹·right` by conjugate gradients.
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
            let image = self.normal(&direction);
            let step = square / dot(&direction, &image);
            for ((x, r), (d, i)) in x.iter_mut().zip(&mut residual).zip(direction.iter().zip(&image)) {
                *x += step * d;
                *r -= step * i;
            }
            let next = dot(&residual, &residual);
            let keep = next / square;
            square = next;
            for (d, r) in direction.iter_mut().zip(&residual) {
                *d = r + keep * *d;
            }
        }
        x
    }
}

/// Minimum number of samples for one thread per axis.
const SPAWN_SAMPLES: usize = 10_000;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Independent partial sums: the additions need not wait for each other.
    let (a_chunks, a_rest) = a.as_chunks::<8>();
    let (b_chunks, b_rest) = b.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for (a, b) in a_chunks.iter().zip(b_chunks) {
        for i in 0..8 {
            sums[i] += a[i] * b[i];
        }
    }
    sums.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f64>()
}

/// Unit tangents by central differences, axis by axis; zero at standstill, so that the whole error
/// counts.
fn tangents(path: &Trajectory) -> Vec<f64> {
    let samples = path.len();
    let mut tangents: Vec<f64> = path
        .columns()
        .iter()
        .flat_map(|column| (0..samples).map(|k| column[(k + 1).min(samples - 1)] - column[k.saturating_sub(1)]))
        .collect();
    for k in 0..samples {
        let norm = (0..path.columns().len()).map(|axis| tangents[axis * samples + k].powi(2)).sum::<f64>().sqrt();
        for axis in 0..path.columns().len() {
            let value = &mut tangents[axis * samples + k];
            *value = if norm > 1e-9 { *value / norm } else { 0.0 };
        }
    }
    tangents
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    fn lifted(responses: &[ImpulseResponse], samples: usize, a: f64) -> Lifted<'_> {
        let angle = |k: usize| (k as f64 * 0.01).sin() * 3.0;
        let directions: [fn(f64) -> f64; 3] = [|t| t.cos() * 0.8, |t| t.sin() * 0.8, |_| 0.6];
        let tangents =
            directions[..responses.len()].iter().flat_map(|direction| (0..samples).map(|k| direction(angle(k)))).collect();
        Lifted { responses, tangents, samples, a, damping: 2e-3 }
    }

    fn responses() -> Vec<ImpulseResponse> {
        [0.80, 0.77, 0.83].map(|p: f64| ImpulseResponse::new((0..90).map(|k| (1.0 - p) * p.powi(k)).collect()).unwrap()).into()
    }

    /// The same system with its matrices written out.
    fn dense(lifted: &Lifted<'_>, right: &[f64]) -> Vec<f64> {
        let (n, size) = (lifted.samples, lifted.size());
        let mut p = DMatrix::zeros(size, size);
        for (axis, response) in lifted.responses.iter().enumerate() {
            for (lag, tap) in response.taps().iter().enumerate() {
                for k in lag..n {
                    p[(axis * n + k, axis * n + k - lag)] = *tap;
                }
            }
        }
        let mut q = DMatrix::identity(size, size);
        for k in 0..n {
            for (i, j) in (0..lifted.responses.len()).flat_map(|i| (0..lifted.responses.len()).map(move |j| (i, j))) {
                q[(i * n + k, j * n + k)] -= lifted.a * lifted.tangents[i * n + k] * lifted.tangents[j * n + k];
            }
        }
        let normal = p.transpose() * q * &p + DMatrix::identity(size, size) * lifted.damping;
        normal.cholesky().unwrap().solve(&DVector::from_column_slice(right)).iter().copied().collect()
    }

    #[test]
    fn without_matrices_the_solution_is_that_of_the_dense_equations() {
        let responses = responses();
        for (a, samples) in [(0.0, 150), (0.5, 150), (1.0, 150), (1.0, 500)] {
            let lifted = lifted(&responses, samples, a);
            let right: Vec<f64> = (0..lifted.size()).map(|i| ((i * i) as f64 * 0.37).sin()).collect();
            let (free, dense) = (lifted.solve(&right), dense(&lifted, &right));
            let largest = dense.iter().fold(0.0_f64, |top, x| top.max(x.abs()));
            let off = free.iter().zip(&dense).fold(0.0_f64, |top, (x, y)| top.max((x - y).abs()));
            assert!(off <= 1e-9 * largest, "a = {a}: off by {off} of {largest}");
        }
    }

    /// The axes' RMS error after so many updates of a run along an L, on the machine that the responses describe.
    fn settled(settings: NormOptimalSettings, updates: usize) -> f64 {
        let leg = |from: i32, k: i32| f64::from((k - from).clamp(0, 60)) * 0.05;
        let columns = vec![(0..150).map(|k| leg(10, k)).collect(), (0..150).map(|k| leg(70, k)).collect(), vec![0.0; 150]];
        let path = Trajectory::new(0.002, motion::Axis::xyz(), columns).unwrap();
        let kinematics = std::sync::Arc::new(motion::Cartesian::new(motion::Axis::xyz()));
        let desired = DesiredPath::new(path.clone(), kinematics).unwrap();
        let run = |reference: &Trajectory| {
            let columns = reference.columns().iter().zip(responses()).map(|(column, response)| {
                let mut actual = vec![0.0; column.len()];
                response.apply(column, &mut actual);
                actual
            });
            reference.with_columns(columns.collect()).unwrap()
        };
        let mut law = NormOptimalIlc::new(settings, responses()).unwrap();
        let mut reference = path.clone();
        for _ in 0..updates {
            reference = law.update(&desired, &reference, &run(&reference)).unwrap();
        }
        let error = path.tracking_error(&run(&reference)).unwrap().concat();
        (dot(&error, &error) / error.len() as f64).sqrt()
    }

    #[test]
    fn without_r_learning_is_deadbeat() {
        let settings = NormOptimalSettings { r: 0.0, ..NormOptimalSettings::default() };
        let (none, one, five) = (settled(settings, 0), settled(settings, 1), settled(settings, 5));
        assert!(one < 0.1 * none, "{none} {one}");
        assert!((one - five).abs() < 1e-6 * one, "{one} {five}");
    }

    #[test]
    fn the_settled_error_depends_on_s_and_not_on_r() {
        let error = |s, r| settled(NormOptimalSettings { a: 0.0, s, r }, 60);
        let (least, slow, loose) = (error(1e-3, 1e-4), error(1e-3, 3e-3), error(1e-2, 1e-3));
        assert!((slow - least).abs() < 1e-3 * least, "{least} {slow}");
        assert!(loose > 1.5 * least, "{least} {loose}");
    }
}
