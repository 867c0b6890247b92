//! The command that the position loop receives: delayed, averaged, with its slope.

/// A command, linear between its samples, behind a delay and a moving average.
pub struct Command<'a> {
    samples: &'a [f64],
    /// Integral of the samples up to each one, in sample periods; empty without an average.
    integral: Vec<f64>,
    /// Delay and window, sample periods.
    delay: f64,
    window: f64,
}

/// Windows below this many sample periods count as none.
const NO_WINDOW: f64 = 1e-3;

impl<'a> Command<'a> {
    /// The samples behind a delay and an average, both in sample periods.
    pub fn new(samples: &'a [f64], delay: f64, window: f64) -> Self {
        let window = if window > NO_WINDOW { window } else { 0.0 };
        let mut integral = Vec::new();
        if window > 0.0 {
            let first = samples.first().copied().unwrap_or(0.0);
            let mut sum = 0.0;
            integral.push(0.0);
            for pair in samples.windows(2) {
                // From the first position, so that long sums keep their digits.
                sum += 0.5 * (pair[0] + pair[1]) - first;
                integral.push(sum);
            }
        }
        Self { samples, integral, delay, window }
    }

    /// Position at `time`, sample periods.
    pub fn position(&self, time: f64) -> f64 {
        let time = time - self.delay;
        if self.window > 0.0 {
            let first = self.samples.first().copied().unwrap_or(0.0);
            return first + (self.area(time) - self.area(time - self.window)) / self.window;
        }
        self.at(time)
    }

    fn at(&self, time: f64) -> f64 {
        let last = self.samples.len() - 1;
        if time <= 0.0 {
            return self.samples[0];
        }
        let k = time as usize;
        if k >= last {
            return self.samples[last];
        }
        self.samples[k] + (time - k as f64) * (self.samples[k + 1] - self.samples[k])
    }

    /// Integral of the position, less the first one, up to `time`.
    fn area(&self, time: f64) -> f64 {
        let (first, last) = (self.samples[0], self.samples.len() - 1);
        if time <= 0.0 {
            return 0.0;
        }
        let k = (time as usize).min(last);
        let beyond = time - k as f64;
        self.integral[k] + beyond * (0.5 * (self.samples[k] + self.at(time)) - first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_is_late_by_the_delay_and_half_the_window() {
        let samples: Vec<f64> = (0..40).map(f64::from).collect();
        assert!((Command::new(&samples, 1.25, 0.0).position(20.5) - 19.25).abs() < 1e-12);
        assert!((Command::new(&samples, 1.25, 5.0).position(20.5) - 16.75).abs() < 1e-12);
        assert_eq!(Command::new(&samples, 0.0, 5.0).position(-3.0), 0.0);
        assert_eq!(Command::new(&samples, 0.0, 0.0).position(90.0), 39.0);
    }
}
