//! Resonance of the drive, from the spectrum of what the servo model leaves.

use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, Schur};

use crate::bootstrap::interval;
use crate::context::AxisContext;
use crate::finding::{Finding, Label, Mark, Picture, Quantity, Series, Verdict};
use crate::threshold;

/// Memory of the autoregressive model, s, and its least and largest order.
const MEMORY_S: f64 = 0.08;
const ORDERS: (usize, usize) = (16, 60);
/// Length of the exchangeable stretches, s.
const STRETCH_S: f64 = 2.0;
/// Damping ratio above which a pole is no resonance.
const DAMPED: f64 = 0.2;
/// Lowest frequency, Hz, and highest as a share of the Nyquist frequency.
const LOWEST_HZ: f64 = 8.0;
const HIGHEST: f64 = 0.85;
/// Least ratio of the power at the peak to that a third of an octave to either side.
const PROMINENT: f64 = 3.0;
/// Points of the picture.
const POINTS: usize = 300;
/// Iterations and tolerance of a Schur decomposition: without exceptional shifts it may go round in circles.
const SCHUR_ITERATIONS: usize = 2000;
const SCHUR_TOLERANCE: f64 = 1e-14;
/// Shift of a second try: any that is no eigenvalue's.
const SHIFT: f64 = 0.3;

/// Autocovariance of one stretch: sums of products by lag, and their number.
struct Stretch {
    products: Vec<f64>,
    samples: usize,
}

/// A pole pair of the autoregressive model.
#[derive(Debug, Clone, Copy)]
struct Pole {
    frequency_hz: f64,
    damping: f64,
}

/// An autoregressive model of a signal.
struct Autoregressive {
    coefficients: Vec<f64>,
    /// Variance of its innovations, mm².
    innovation: f64,
    period_s: f64,
}

/// The resonance of an axis that shows most.
pub fn finding(axis: &AxisContext<'_>) -> Finding {
    let period_s = axis.record.period_s;
    let order = ((MEMORY_S / period_s) as usize).clamp(ORDERS.0, ORDERS.1);
    let stretches = stretches(axis, order);
    let all: Vec<&Stretch> = stretches.iter().collect();
    let nyquist_hz = 0.5 / period_s;
    let none = |why: String| {
        let record = "record at a higher rate, with stops at full acceleration or a tap on the table";
        Finding::not_observable(Quantity::Resonance, axis.name(), "Hz", why, record)
    };
    let Some(model) = Autoregressive::of(&all, order, period_s) else { return none("too little motion".to_owned()) };
    let prominent =
        model.poles().into_iter().filter(|pole| pole.frequency_hz < HIGHEST * nyquist_hz && model.prominence(pole) > PROMINENT);
    let strongest = prominent.max_by(|a, b| model.amplitude_mm(a).total_cmp(&model.amplitude_mm(b)));
    let Some(pole) = strongest else { return none(format!("nothing rings in the error up to {:.0} Hz", HIGHEST * nyquist_hz)) };
    let nearest = |drawn: &[&Stretch]| {
        let poles = Autoregressive::of(drawn, order, period_s).map(|model| model.poles()).unwrap_or_default();
        poles
            .into_iter()
            .min_by(|a, b| (a.frequency_hz - pole.frequency_hz).abs().total_cmp(&(b.frequency_hz - pole.frequency_hz).abs()))
    };
    let Some(estimate) = interval(&stretches, |drawn| nearest(drawn).map_or(f64::NAN, |pole| pole.frequency_hz)) else {
        return none("too few stretches of motion".to_owned());
    };
    let amplitude = interval(&stretches, |drawn| {
        let model = Autoregressive::of(drawn, order, period_s);
        1e3 * model.map_or(f64::NAN, |model| nearest(drawn).map_or(f64::NAN, |pole| model.amplitude_mm(&pole)))
    });
    let effect = amplitude.unwrap_or_else(|| crate::finding::Estimate::within(1e3 * model.amplitude_mm(&pole), 0.0));
    let verdict = threshold::of_deviation(&effect);
    Finding {
        quantity: Quantity::Resonance,
        axis: axis.name().to_owned(),
        estimate: Some(estimate),
        unit: "Hz",
        effect_um: Some(effect),
        verdict,
        details: vec![("damping ratio", pole.damping)],
        meaning: "frequency at which the closed loop rings; effect: its amplitude in these logs".to_owned(),
        remedy: match verdict {
            Verdict::Good => String::new(),
            _ => "lower the jerk so that acceleration builds up over at least one period, or set a notch filter. SINUMERIK: MD32431 MAX_AX_JERK, \
                  MD32414 AX_JERK_FREQ; Fanuc: No. 2113 (resonance elimination filter), 1773"
                .to_owned(),
        },
        picture: Some(model.picture(axis.name(), nyquist_hz)),
    }
}

/// Stretches of the residuals of all runs.
fn stretches(axis: &AxisContext<'_>, order: usize) -> Vec<Stretch> {
    let length = ((STRETCH_S / axis.record.period_s) as usize).max(1);
    let runs = axis.residuals.iter().map(|run| run.get(axis.record.first_scored()..).unwrap_or_default());
    let parts = runs.flat_map(|run| run.chunks(length)).filter(|part| part.len() > 4 * order);
    parts
        .map(|part| {
            let mean = part.iter().sum::<f64>() / part.len() as f64;
            let centred: Vec<f64> = part.iter().map(|r| r - mean).collect();
            let product = |lag: usize| centred[lag..].iter().zip(&centred).map(|(a, b)| a * b).sum();
            Stretch { products: (0..=order).map(product).collect(), samples: part.len() }
        })
        .collect()
}

impl Autoregressive {
    /// Yule–Walker equations by Levinson's recursion.
    fn of(stretches: &[&Stretch], order: usize, period_s: f64) -> Option<Self> {
        let samples: usize = stretches.iter().map(|stretch| stretch.samples).sum();
        let covariance = |lag: usize| stretches.iter().map(|stretch| stretch.products[lag]).sum::<f64>() / samples.max(1) as f64;
        let mut covariances: Vec<f64> = (0..=order).map(covariance).collect();
        if covariances[0] <= 0.0 {
            return None;
        }
        covariances[0] *= 1.0 + 1e-9;
        let mut coefficients: Vec<f64> = Vec::with_capacity(order);
        let mut innovation = covariances[0];
        for lag in 1..=order {
            let known: f64 = coefficients.iter().enumerate().map(|(i, a)| a * covariances[lag - 1 - i]).sum();
            let reflection = (covariances[lag] - known) / innovation;
            let before = coefficients.clone();
            coefficients.iter_mut().zip(before.iter().rev()).for_each(|(a, b)| *a -= reflection * b);
            coefficients.push(reflection);
            innovation *= 1.0 - reflection * reflection;
            if innovation <= 0.0 {
                return None;
            }
        }
        Some(Self { coefficients, innovation, period_s })
    }

    /// Lightly damped poles, as continuous ones; none where they are not found.
    fn poles(&self) -> Vec<Pole> {
        let order = self.coefficients.len();
        let companion = DMatrix::from_fn(order, order, |i, j| match i {
            0 => self.coefficients[j],
            _ => f64::from(u8::from(i == j + 1)),
        });
        // Eigenvalues that are alike to the iteration are distinguished by a shift.
        let eigenvalues = |shift: f64| {
            let shifted = &companion + DMatrix::identity(order, order) * shift;
            let schur = Schur::try_new(shifted, SCHUR_TOLERANCE, SCHUR_ITERATIONS)?;
            Some(schur.complex_eigenvalues().map(|z| z - shift))
        };
        let Some(poles) = eigenvalues(0.0).or_else(|| eigenvalues(SHIFT)) else { return Vec::new() };
        let continuous = poles.iter().filter(|z| z.im > 1e-9).map(|z| {
            let s = z.ln() / self.period_s;
            Pole { frequency_hz: s.norm() / TAU, damping: -s.re / s.norm() }
        });
        continuous.filter(|pole| pole.damping < DAMPED && pole.frequency_hz > LOWEST_HZ).collect()
    }

    /// Power density, one-sided, mm²/Hz.
    fn density(&self, frequency_hz: f64) -> f64 {
        let step = TAU * frequency_hz * self.period_s;
        let (mut re, mut im) = (1.0, 0.0);
        for (i, a) in self.coefficients.iter().enumerate() {
            let (sin, cos) = (step * (i + 1) as f64).sin_cos();
            re -= a * cos;
            im += a * sin;
        }
        2.0 * self.period_s * self.innovation / (re * re + im * im)
    }

    /// Power around a pole: geometric mean of the densities a third of an octave to either side.
    fn background(&self, pole: &Pole) -> f64 {
        let third = 2f64.powf(1.0 / 3.0);
        (self.density(pole.frequency_hz / third) * self.density((pole.frequency_hz * third).min(0.5 / self.period_s))).sqrt()
    }

    fn prominence(&self, pole: &Pole) -> f64 {
        self.density(pole.frequency_hz) / self.background(pole)
    }

    /// Amplitude of a sine of the power above the background: a peak of half-power width `2ζf` holds `π ζ f` times its height.
    fn amplitude_mm(&self, pole: &Pole) -> f64 {
        let above = (self.density(pole.frequency_hz) - self.background(pole)).max(0.0);
        (2.0 * above * PI * pole.damping * pole.frequency_hz).sqrt()
    }

    fn picture(&self, name: &str, nyquist_hz: f64) -> Picture {
        let points = (1..=POINTS).map(|i| {
            let frequency = nyquist_hz * i as f64 / POINTS as f64;
            (frequency, 1e3 * self.density(frequency).sqrt())
        });
        Picture {
            title: format!("{name}: spectrum of the error beyond the servo model"),
            x: Label::new("frequency", "Hz"),
            y: Label::new("amplitude density", "µm/√Hz"),
            series: vec![Series::new("autoregressive spectrum", Mark::Line, points)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    #[test]
    fn poles_on_a_circle_end_the_search() {
        // z⁸ = 0.98: every shift of the QR iteration is as good as any other.
        let coefficients = (1..=8).map(|i| if i == 8 { 0.98 } else { 0.0 }).collect();
        let model = Autoregressive { coefficients, innovation: 1.0, period_s: 0.002 };
        let mut found: Vec<f64> = model.poles().iter().map(|pole| pole.frequency_hz).collect();
        found.sort_by(f64::total_cmp);
        assert_eq!(found.len(), 3, "{found:?}");
        assert!(found.iter().zip([62.5, 125.0, 187.5]).all(|(found, expected)| (found - expected).abs() < 0.5), "{found:?}");
    }

    #[test]
    fn a_ringing_signal_gives_its_pole() {
        let (period_s, frequency, damping) = (0.002, 60.0, 0.03);
        let pulsation = TAU * frequency;
        let radius = (-damping * pulsation * period_s).exp();
        let turn = pulsation * (1.0 - damping * damping).sqrt() * period_s;
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let (mut signal, mut before) = (Vec::new(), [0.0, 0.0]);
        for _ in 0..30_000 {
            let next = 2.0 * radius * turn.cos() * before[0] - radius * radius * before[1] + rng.random_range(-1e-3..1e-3);
            before = [next, before[0]];
            signal.push(next);
        }
        let product = |lag: usize| signal[lag..].iter().zip(&signal).map(|(a, b)| a * b).sum();
        let stretch = Stretch { products: (0..=40).map(product).collect(), samples: signal.len() };
        let model = Autoregressive::of(&[&stretch], 40, period_s).unwrap();
        let strongest = model.poles().into_iter().max_by(|a, b| model.prominence(a).total_cmp(&model.prominence(b))).unwrap();
        assert!((strongest.frequency_hz - frequency).abs() < 0.5 && (strongest.damping - damping).abs() < 0.006, "{strongest:?}");
        // Nearly all of the signal is the peak.
        let rms = (signal.iter().map(|x| x * x).sum::<f64>() / signal.len() as f64).sqrt();
        assert!((model.amplitude_mm(&strongest) / (rms * 2f64.sqrt()) - 1.0).abs() < 0.15);
    }
}
