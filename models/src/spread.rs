//! Distribution of the errors of a prediction, and the scatter of single runs.

use serde::{Deserialize, Serialize};

use crate::AxisSignal;
use crate::features::{events, velocity};
use crate::quantile::quantile;
use crate::ranges::{LENGTH, RATIO, VELOCITY, all_within, within};

/// Length of the windows whose RMS errors show the scatter between segments of motion, s.
const WINDOW_S: f64 = 2.0;
/// Length of the windows of which only the largest error counts, s: longer than the correlation of
/// the errors, shorter than the gaps between reversals of a part.
pub const PEAK_S: f64 = 0.5;
/// Minimum number of windows for a scatter.
const FEWEST_WINDOWS: usize = 5;
/// Steps of the distribution of peaks.
const STEPS: usize = 20;

/// Limits of the regimes after a reversal or a start, s: friction settles in the first, slow
/// position loops in the second.
pub(crate) const SETTLING_S: [f64; 2] = [0.06, 0.25];
/// Number of speed regimes, in octaves below the top speed of the training data.
const OCTAVES: usize = 3;
/// Standstill, after an event, and one regime per octave of speed.
pub const REGIMES: usize = 1 + SETTLING_S.len() + OCTAVES;
/// The regimes in words.
pub const REGIME_NAMES: [&str; REGIMES] = [
    "at rest",
    "within 60 ms of a start or reversal",
    "60 to 250 ms after a start or reversal",
    "below a quarter of the log's top speed",
    "from a quarter to half of the log's top speed",
    "above half of the log's top speed",
];
/// Minimum number of samples for a regime of its own.
const FEWEST: usize = 200;

/// Distribution of an axis's prediction errors: RMS by regime of motion, scatter of windows around
/// it, and peaks.
///
/// Two figures describe the size of the errors on new motions. The expected error is that of the
/// final predictor in the cross-validation within its fit, which leaves out little at a time. The
/// upper bound comes from held-out runs: their predictor lacks a good part of the log, and perhaps
/// the only run of a kind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spread {
    /// RMS by regime, mm or rad.
    rms: [f64; REGIMES],
    /// Length of each regime in the training data, s; zero where it is not known.
    #[serde(default)]
    seconds: [f64; REGIMES],
    /// Reference speed of the octaves, mm/s or rad/s.
    top_speed: f64,
    /// The upper bound as a multiple of the RMS, at least 1.
    upper: f64,
    /// RMS over a window as a multiple of the RMS of its regimes: 5 % quantile and 95 % quantile.
    windows: [f64; 2],
    /// Largest error over [`PEAK_S`] as a multiple of the largest RMS of its regimes: every
    /// twentieth quantile, in ascending order.
    peaks: Vec<f64>,
    /// Number of those windows.
    peaks_seen: usize,
}

impl Spread {
    pub(crate) fn check(&self) -> Result<(), String> {
        all_within("spread.rms", &self.rms, LENGTH)?;
        all_within("spread.seconds", &self.seconds, RATIO)?;
        within("spread.top_speed", self.top_speed, VELOCITY)?;
        within("spread.upper", self.upper, RATIO)?;
        all_within("spread.windows", &self.windows, RATIO)?;
        all_within("spread.peaks", &self.peaks, RATIO)?;
        if self.peaks.len() == STEPS + 1 && self.peaks.is_sorted() {
            Ok(())
        } else {
            Err(format!("`spread.peaks` has {} values; {} in ascending order are needed", self.peaks.len(), STEPS + 1))
        }
    }

    /// The distribution of the errors of `runs`, scaled to `expected`, with the upper bound
    /// `upper`: RMS, mm or rad. `None` if the runs are too short.
    #[must_use]
    pub fn fit(runs: &[(AxisSignal<'_>, Vec<f64>)], top_speed: f64, expected: f64, upper: f64) -> Option<Self> {
        let regimes: Vec<Vec<usize>> = runs.iter().map(|(signal, _)| regimes(signal, top_speed)).collect();
        let mut sums = [(0.0, 0_usize); REGIMES];
        for (regimes, (_, errors)) in regimes.iter().zip(runs) {
            for (regime, error) in regimes.iter().zip(errors) {
                let (sum, count) = &mut sums[*regime];
                *sum += error * error;
                *count += 1;
            }
        }
        let (sum, count) = sums.iter().fold((0.0, 0), |(sum, count), of| (sum + of.0, count + of.1));
        let overall = (sum / count.max(1) as f64).sqrt();
        let rms = sums.map(|(sum, count)| if count < FEWEST { overall } else { (sum / count as f64).sqrt() });
        let (mut windows, mut peaks) = (Vec::new(), Vec::new());
        for (regimes, (signal, errors)) in regimes.iter().zip(runs) {
            let samples = |time_s: f64| (time_s / signal.period_s).round().max(1.0) as usize;
            let square = |regime: &usize| rms[*regime].powi(2);
            let long = regimes.chunks_exact(samples(WINDOW_S)).zip(errors.chunks_exact(samples(WINDOW_S)));
            windows.extend(long.filter_map(|(regimes, errors)| {
                let expected: f64 = regimes.iter().map(square).sum();
                (expected > 0.0).then(|| (errors.iter().map(|error| error * error).sum::<f64>() / expected).sqrt())
            }));
            let short = regimes.chunks_exact(samples(PEAK_S)).zip(errors.chunks_exact(samples(PEAK_S)));
            peaks.extend(short.filter_map(|(regimes, errors)| {
                let largest = regimes.iter().map(|regime| rms[*regime]).fold(0.0, f64::max);
                (largest > 0.0).then(|| errors.iter().fold(0.0_f64, |top, error| top.max(error.abs())) / largest)
            }));
        }
        if windows.len() < FEWEST_WINDOWS || peaks.is_empty() || expected.is_nan() || expected <= 0.0 {
            return None;
        }
        let of = |values: &Vec<f64>, share: f64| quantile(values.clone(), share);
        let period_s = runs.first().map_or(0.0, |(signal, _)| signal.period_s);
        Some(Self {
            rms: rms.map(|rms| rms * expected / overall),
            seconds: sums.map(|(_, count)| count as f64 * period_s),
            top_speed,
            upper: (upper / expected).max(1.0),
            windows: [of(&windows, 0.05).min(1.0), of(&windows, 0.95).max(1.0)],
            peaks_seen: peaks.len(),
            peaks: (0..=STEPS).map(|step| of(&peaks, step as f64 / STEPS as f64)).collect(),
        })
    }

    /// The same distribution of errors of another size: of the RMS `expected` over the motion it was fitted to, mm or rad.
    #[must_use]
    pub fn scaled_to(&self, expected: f64) -> Self {
        let (square, seconds) =
            self.rms.iter().zip(self.seconds).fold((0.0, 0.0), |(square, all), (rms, s)| (square + rms * rms * s, all + s));
        // Models of before stated no lengths.
        let overall = if seconds > 0.0 { (square / seconds).sqrt() } else { self.rms.iter().sum::<f64>() / REGIMES as f64 };
        Self { rms: self.rms.map(|rms| rms * expected / overall), ..self.clone() }
    }

    /// Expected RMS at every sample of `signal`, mm or rad.
    #[must_use]
    pub fn at(&self, signal: &AxisSignal<'_>) -> Vec<f64> {
        regimes(signal, self.top_speed).into_iter().map(|regime| self.rms[regime]).collect()
    }

    /// Expected RMS of each regime, mm or rad.
    #[must_use]
    pub fn by_regime(&self) -> [f64; REGIMES] {
        self.rms
    }

    /// Length of each regime in the training data, s; zero where the model does not say.
    #[must_use]
    pub fn trained_s(&self) -> [f64; REGIMES] {
        self.seconds
    }

    /// Length of each regime in `signal`, s.
    #[must_use]
    pub fn seconds_of(&self, signal: &AxisSignal<'_>) -> [f64; REGIMES] {
        let mut seconds = [0.0; REGIMES];
        regimes(signal, self.top_speed).into_iter().for_each(|regime| seconds[regime] += signal.period_s);
        seconds
    }

    /// Range of the RMS of a run of a few seconds as multiples of [`Self::at`]: nine in ten lie
    /// between the first and the last.
    #[must_use]
    pub fn multiples(&self) -> [f64; 3] {
        let [low, high] = self.windows;
        [low, 1.0, high * self.upper]
    }

    /// The upper bound as a multiple of the expected error, at least 1.
    #[must_use]
    pub fn upper(&self) -> f64 {
        self.upper
    }

    /// Share of the windows of [`PEAK_S`] whose largest error stays below this multiple of the RMS.
    /// Beyond the largest observed multiple the remaining share decreases exponentially; the decay
    /// constant is the mean excess of the top fifth of the peaks.
    #[must_use]
    pub fn below(&self, multiple: f64) -> f64 {
        let Some((&largest, &smallest)) = self.peaks.last().zip(self.peaks.first()) else { return 1.0 };
        let rarest = 1.0 / (self.peaks_seen as f64 + 1.0);
        if multiple >= largest {
            let top = &self.peaks[STEPS - STEPS / 5..];
            let excess = top.iter().map(|peak| peak - top[0]).sum::<f64>() / top.len() as f64;
            return 1.0 - rarest * (-(multiple - largest) / excess.max(1e-9 * largest)).exp();
        }
        if multiple < smallest {
            return 0.0;
        }
        let after = self.peaks.partition_point(|peak| *peak <= multiple).clamp(1, STEPS);
        let (low, high) = (self.peaks[after - 1], self.peaks[after]);
        let share = (after as f64 - 1.0 + if high > low { (multiple - low) / (high - low) } else { 0.0 }) / STEPS as f64;
        share.min(1.0 - rarest)
    }
}

/// The regime of every sample.
fn regimes(signal: &AxisSignal<'_>, top_speed: f64) -> Vec<usize> {
    let moving = 1 + SETTLING_S.len();
    let of_speed = |v: &f64| match v.abs() {
        0.0 => 0,
        speed => moving + OCTAVES - 1 - ((top_speed / speed).log2().max(0.0) as usize).min(OCTAVES - 1),
    };
    let mut regimes: Vec<usize> = velocity(signal.reference, signal.period_s).iter().map(of_speed).collect();
    let events = events(&velocity(signal.flag_source(), signal.period_s));
    for (index, settling_s) in SETTLING_S.iter().enumerate().rev() {
        let settling = (settling_s / signal.period_s).ceil() as usize;
        for event in &events {
            let to = (event.sample + settling).min(regimes.len());
            regimes[event.sample.min(to)..to].fill(1 + index);
        }
    }
    regimes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_scatter_and_peaks_of_even_noise() {
        let reference: Vec<f64> = (0..60_000).map(|k| f64::from(k) * 0.02).collect();
        let mut state = 1_u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let errors: Vec<f64> = (0..reference.len()).map(|_| 2.0 * (12.0_f64.sqrt() * (unit() - 0.5))).collect();
        let signal = AxisSignal::uncompensated(&reference, 0.002);
        let spread = Spread::fit(&[(signal, errors)], 10.0, 1.0, 2.0).unwrap();
        assert!(spread.at(&signal).iter().all(|rms| (rms - 1.0).abs() < 0.1));
        assert!(spread.scaled_to(3.0).at(&signal).iter().all(|rms| (rms - 3.0).abs() < 0.3));
        // A steady 10 mm/s: all but the start.
        let seconds = spread.seconds_of(&signal);
        assert!(seconds.iter().zip(spread.trained_s()).all(|(own, trained)| (own - trained).abs() < 1e-6), "{seconds:?}");
        assert!((seconds.iter().sum::<f64>() - 120.0).abs() < 1e-6 && seconds[REGIMES - 1] > 119.0, "{seconds:?}");
        let [low, middle, high] = spread.multiples();
        assert!((0.94..1.0).contains(&low) && middle == 1.0 && (2.0..2.12).contains(&high), "{low} {middle} {high}");
        // Uniform noise ends at √3 times its RMS.
        assert!(spread.below(1.6) < 0.01 && spread.below(1.74) > 0.99);
        let grid: Vec<f64> = (0..400).map(|step| spread.below(f64::from(step) * 0.01)).collect();
        assert!(grid.windows(2).all(|pair| pair[0] <= pair[1]) && grid.iter().all(|share| (0.0..=1.0).contains(share)));
    }
}
