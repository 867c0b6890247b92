//! Zero-phase low-pass: a filter that smooths without delay.

use crate::CompensationError;

/// Second-order Butterworth low-pass, run forwards and backwards: no phase, attenuation `−6 dB` at the cut-off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowPass {
    /// Numerator, symmetric: `b0, b1, b0`.
    b: [f64; 2],
    /// Denominator after the leading one.
    a: [f64; 2],
    /// Samples until the initial state has decayed.
    memory: usize,
}

impl LowPass {
    /// The filter with cut-off `cutoff_hz` for signals sampled every `period_s`.
    ///
    /// # Errors
    /// When the cut-off is not positive. At or above a third of the sampling rate the filter passes everything.
    pub fn new(cutoff_hz: f64, period_s: f64) -> Result<Option<Self>, CompensationError> {
        if cutoff_hz.is_nan() || cutoff_hz <= 0.0 {
            return Err(CompensationError::BadSetting {
                name: "low-pass cut-off (Hz)",
                value: cutoff_hz,
                remedy: "it must be positive; leave it out for no filter",
            });
        }
        let relative = cutoff_hz * period_s;
        if relative >= 1.0 / 3.0 {
            return Ok(None);
        }
        // Bilinear transform of 1/(s² + √2 s + 1).
        let c = 1.0 / (std::f64::consts::PI * relative).tan();
        let norm = 1.0 / (1.0 + std::f64::consts::SQRT_2 * c + c * c);
        Ok(Some(Self {
            b: [norm, 2.0 * norm],
            a: [2.0 * (1.0 - c * c) * norm, (1.0 - std::f64::consts::SQRT_2 * c + c * c) * norm],
            memory: (3.0 / relative).ceil() as usize,
        }))
    }

    /// The smoothed signal; it is extended by its end values.
    #[must_use]
    pub fn zero_phase(&self, signal: &[f64]) -> Vec<f64> {
        let one: Vec<[f64; 1]> = signal.iter().map(|value| [*value]).collect();
        self.zero_phase_of(&one).into_iter().map(|[value]| value).collect()
    }

    /// As [`LowPass::zero_phase`], of several signals side by side.
    #[must_use]
    pub fn zero_phase_of<const N: usize>(&self, signals: &[[f64; N]]) -> Vec<[f64; N]> {
        let (Some(first), Some(last)) = (signals.first(), signals.last()) else {
            return Vec::new();
        };
        let mut padded = vec![*first; self.memory];
        padded.extend_from_slice(signals);
        padded.extend(std::iter::repeat_n(*last, self.memory));
        self.pass(padded.iter_mut());
        self.pass(padded.iter_mut().rev());
        padded[self.memory..self.memory + signals.len()].to_vec()
    }

    fn pass<'a, const N: usize>(&self, mut signals: impl Iterator<Item = &'a mut [f64; N]>) {
        let Some(first) = signals.next() else { return };
        // The initial state is the steady state at the first value.
        let steady = |x: f64| self.b[0] * (x + x) + self.b[1] * x - self.a[0] * x - self.a[1] * x;
        let (mut x1, mut x2) = (*first, *first);
        let (mut y1, mut y2) = (first.map(steady), *first);
        *first = y1;
        for values in signals {
            let x = *values;
            for i in 0..N {
                values[i] = self.b[0] * (x[i] + x2[i]) + self.b[1] * x1[i] - self.a[0] * y1[i] - self.a[1] * y2[i];
            }
            (x2, x1, y2, y1) = (x1, x, y1, *values);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(hz: f64) -> Vec<f64> {
        (0..2000).map(|k| (std::f64::consts::TAU * hz * f64::from(k) * 0.002).sin()).collect()
    }

    fn gain(filter: &LowPass, hz: f64) -> f64 {
        let (before, after) = (sine(hz), filter.zero_phase(&sine(hz)));
        let middle = 500..1500;
        let dot = |a: &[f64], b: &[f64]| middle.clone().map(|k| a[k] * b[k]).sum::<f64>();
        // Projection on the input: a phase shift would also lower it.
        dot(&after, &before) / dot(&before, &before)
    }

    #[test]
    fn passes_low_halves_at_the_cut_off_and_stops_high() {
        let filter = LowPass::new(50.0, 0.002).unwrap().unwrap();
        assert!((gain(&filter, 2.0) - 1.0).abs() < 1e-4);
        assert!((gain(&filter, 50.0) - 0.5).abs() < 1e-3);
        assert!(gain(&filter, 200.0).abs() < 1e-3);
    }

    #[test]
    fn constants_pass_and_bad_cut_offs_do_not() {
        let filter = LowPass::new(100.0, 0.002).unwrap().unwrap();
        assert!(filter.zero_phase(&[3.0; 10]).iter().all(|v| (v - 3.0).abs() < 1e-12));
        assert!(filter.zero_phase(&[]).is_empty());
        assert!(LowPass::new(0.0, 0.002).is_err());
        assert!(LowPass::new(300.0, 0.002).unwrap().is_none());
    }
}
