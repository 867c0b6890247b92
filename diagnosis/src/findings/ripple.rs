//! Error that repeats with the position: cogging, torque ripple, screw and nut.

use std::f64::consts::TAU;

use nalgebra::Complex;
use rayon::prelude::*;

use crate::context::{AxisContext, SPREAD};
use crate::disturbance::{Regression, responses};
use crate::finding::{Estimate, Finding, Label, Mark, Picture, Quantity, Series, Verdict};
use crate::threshold;
use servo::Servo;

/// Longest and shortest period, mm: longer ones are friction by place, shorter ones pass too fast for a log.
const PERIODS_MM: (f64, f64) = (25.0, 0.2);
/// Frequencies per cycle over the travel, and their largest number.
const PER_CYCLE: f64 = 2.0;
const MOST_BINS: usize = 3000;
/// Speed above which samples count, mm/s, and their largest number in the search.
const MOVING_MM_S: f64 = 1.0;
const SAMPLES: usize = 20_000;
/// Bins to either side whose median a peak is compared with, its least ratio, and the number of peaks that are fitted.
const NEIGHBOURS: usize = 25;
const RATIO: f64 = 8.0;
const FITTED: usize = 6;
/// Peaks that are fitted because they explain most, whatever their neighbourhood.
const STRONGEST: usize = 3;
/// Wald statistic per weight above which a wave is there: of 3000 frequencies one in a hundred logs exceeds it by chance.
const CERTAIN: f64 = 13.0;
/// Least RMS of a wave as a share of that of the residual: what the model gets wrong repeats with the motion and may look like a small wave (EMPS
/// under pulses: 0.08).
const LEAST: f64 = 0.1;
/// Least share of a force that logs show, for the upper bound of an unseen one.
const LEAST_SHOWN: f64 = 1e-3;

/// Relative standard deviation of what the model's response to forces gets wrong, and the share of the residual that a wave may hold
/// without being seen: from the blind test's development machines.
const STRUCTURAL: f64 = 0.15;
const HIDDEN: f64 = 0.7;

/// Waves of the force along the axis.
pub fn finding(axis: &AxisContext<'_>) -> Finding {
    let Some(spectrum) = Spectrum::of(axis) else {
        let why = "too little motion at speed";
        return Finding::not_observable(
            Quantity::Ripple,
            axis.name(),
            "µm",
            why,
            "record strokes over several turns of the screw at 5 to 50 mm/s",
        );
    };
    let peaks = spectrum.peaks();
    let waves = fitted(axis, &peaks);
    let residual_um = 1e3 * axis.fit.mean_square.sqrt();
    let is_there =
        |wave: &&WaveFit| wave.certainty > CERTAIN && wave.effect_um.value > std::f64::consts::SQRT_2 * LEAST * residual_um;
    let strongest = waves.iter().filter(is_there).max_by(|a, b| a.effect_um.value.total_cmp(&b.effect_um.value));
    let picture = Some(spectrum.picture(axis));
    let Some(wave) = strongest else {
        // What would have been seen.
        let hidden = HIDDEN * residual_um;
        let unseen = |high: f64| Estimate { value: 0.0, low: 0.0, high };
        let effect = unseen(waves.iter().map(|wave| wave.effect_um.high).fold(hidden, f64::max));
        let estimate = unseen(
            waves.iter().map(|wave| wave.deflection_um.high.max(hidden / wave.shown.max(LEAST_SHOWN))).fold(hidden, f64::max),
        );
        return Finding {
            quantity: Quantity::Ripple,
            axis: axis.name().to_owned(),
            estimate: Some(estimate),
            unit: "µm",
            effect_um: Some(effect),
            verdict: Verdict::Good,
            details: Vec::new(),
            meaning: format!(
                "no error is seen to repeat with the position over 0.2 to 25 mm; one of up to {:.2} µm in these logs could hide",
                effect.high
            ),
            remedy: String::new(),
            picture,
        };
    };
    let verdict = threshold::of_deviation(&wave.effect_um);
    Finding {
        quantity: Quantity::Ripple,
        axis: axis.name().to_owned(),
        estimate: Some(wave.deflection_um),
        unit: "µm",
        effect_um: Some(wave.effect_um),
        verdict,
        details: vec![
            ("period, mm", 1.0 / wave.per_mm),
            ("waves found", waves.iter().filter(is_there).count() as f64),
        ],
        meaning: format!(
            "amplitude of a force that repeats every {:.3} mm, as a deflection of the loops without integrator: lead of the screw, pole pitch of the \
             motor, or a fraction of them; effect: amplitude of the error in these logs",
            1.0 / wave.per_mm
        ),
        remedy: match verdict {
            Verdict::Good => String::new(),
            _ => "compare the period with lead and pole pitch: a whole lead is screw or coupling, a fraction the motor's cogging. SINUMERIK: cogging torque \
                  compensation (p5250); Fanuc: No. 2157 ff. (torque ripple); or precomp compensate, which learns it"
                .to_owned(),
        },
        picture,
    }
}

/// Share of the residual that a wave of each frequency explains.
struct Spectrum {
    per_mm: Vec<f64>,
    power: Vec<f64>,
    travel_mm: f64,
}

impl Spectrum {
    /// The response is taken as that of the present speed: exact for constant speed, near enough to find waves.
    fn of(axis: &AxisContext<'_>) -> Option<Self> {
        let (record, first) = (axis.record, axis.record.first_scored());
        // Position, velocity, residual.
        let mut samples: Vec<[f64; 3]> = Vec::new();
        for (run, residual) in record.runs.iter().zip(&axis.residuals) {
            let moving = (first..run.len()).map(|k| [run.actual[k], run.velocity(k, record.period_s), residual[k]]);
            samples.extend(moving.filter(|[_, velocity, _]| velocity.abs() > MOVING_MM_S));
        }
        let every = samples.len().div_ceil(SAMPLES).max(1);
        let samples: Vec<[f64; 3]> = samples.into_iter().step_by(every).collect();
        let (low, high) =
            samples.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), [x, ..]| (low.min(*x), high.max(*x)));
        let travel_mm = high - low;
        if samples.len() < 500 || travel_mm < 2.0 {
            return None;
        }
        let (lowest, highest) = ((1.0 / PERIODS_MM.0).max(2.0 / travel_mm), 1.0 / PERIODS_MM.1);
        let spacing = (1.0 / (PER_CYCLE * travel_mm)).max((highest - lowest) / MOST_BINS as f64);
        let count = ((highest - lowest) / spacing) as usize;
        let per_mm: Vec<f64> = (0..count).map(|i| lowest + spacing * i as f64).collect();
        let nyquist = 0.5 * TAU / (2.0 * record.period_s);
        let power = per_mm.par_iter().map(|&wave| explained(&samples, wave, &axis.fit.servo, nyquist)).collect();
        Some(Self { per_mm, power, travel_mm })
    }

    /// Frequencies of the strongest peaks: those that explain most, then those that stand out most from their neighbourhood, at least a
    /// cycle and a half over the travel apart.
    fn peaks(&self) -> Vec<f64> {
        let count = self.power.len();
        let is_peak = |i: &usize| self.power[*i] >= self.power[i - 1] && self.power[*i] >= self.power[i + 1];
        let peaks: Vec<usize> = (1..count.saturating_sub(1)).filter(is_peak).collect();
        let ratio = |&i: &usize| {
            let around = self.power[i.saturating_sub(NEIGHBOURS)..(i + NEIGHBOURS + 1).min(count)].to_vec();
            self.power[i] / crate::bootstrap::median(around).max(f64::MIN_POSITIVE)
        };
        let mut by_power: Vec<(f64, usize)> = peaks.iter().map(|&i| (self.power[i], i)).collect();
        let mut by_ratio: Vec<(f64, usize)> = peaks.iter().map(|i| (ratio(i), *i)).filter(|(ratio, _)| *ratio > RATIO).collect();
        let mut found: Vec<f64> = Vec::new();
        for (peaks, most) in [(&mut by_power, STRONGEST), (&mut by_ratio, FITTED)] {
            peaks.sort_by(|a, b| b.0.total_cmp(&a.0));
            for &(_, i) in peaks.iter() {
                let is_apart = found.iter().all(|other| (other - self.per_mm[i]).abs() > 1.5 / self.travel_mm);
                if found.len() < most && is_apart {
                    found.push(self.per_mm[i]);
                }
            }
        }
        found
    }

    fn picture(&self, axis: &AxisContext<'_>) -> Picture {
        let points = self.per_mm.iter().zip(&self.power).map(|(per_mm, power)| (1.0 / per_mm, 1e3 * power.sqrt()));
        Picture {
            title: format!("{}: error that repeats with the position", axis.name()),
            x: Label::new("period", "mm"),
            y: Label::new("RMS in the logs", "µm"),
            series: vec![Series::new("residual of the servo model", Mark::Line, points)],
        }
    }
}

/// Mean square of the residual that a wave of a force explains, mm².
fn explained(samples: &[[f64; 3]], per_mm: f64, servo: &Servo, nyquist: f64) -> f64 {
    // A wave's response by speed, on a grid.
    const GRID: usize = 64;
    let table: Vec<Complex<f64>> = (0..=GRID).map(|i| servo.disturbance_response(nyquist * i as f64 / GRID as f64)).collect();
    let at = |pulsation: f64| {
        let place = pulsation.abs() / nyquist * GRID as f64;
        let k = (place as usize).min(GRID - 1);
        let here = table[k] + (table[k + 1] - table[k]) * (place - k as f64);
        if pulsation < 0.0 { here.conj() } else { here }
    };
    let (mut cc, mut cs, mut ss, mut cr, mut sr, mut count) = (1e-18, 0.0, 1e-18, 0.0, 0.0, 0_usize);
    for &[position, velocity, residual] in samples {
        let pulsation = TAU * per_mm * velocity;
        if pulsation.abs() > nyquist {
            continue;
        }
        let wave = at(pulsation) * Complex::from_polar(1.0, TAU * per_mm * position);
        cc += wave.re * wave.re;
        cs += wave.re * wave.im;
        ss += wave.im * wave.im;
        cr += wave.re * residual;
        sr += wave.im * residual;
        count += 1;
    }
    let determinant = cc * ss - cs * cs;
    if count < 200 || determinant <= 0.0 {
        return 0.0;
    }
    (ss * cr * cr - 2.0 * cs * cr * sr + cc * sr * sr) / determinant / samples.len() as f64
}

/// A fitted wave.
struct WaveFit {
    per_mm: f64,
    /// Amplitude of the error in the logs.
    effect_um: Estimate,
    /// Amplitude of the force as a deflection.
    deflection_um: Estimate,
    /// Share of the deflection that the logs show.
    shown: f64,
    /// Wald statistic per weight.
    certainty: f64,
}

/// All waves fitted together, with their exact responses.
fn fitted(axis: &AxisContext<'_>, peaks: &[f64]) -> Vec<WaveFit> {
    let (record, first) = (axis.record, axis.record.first_scored());
    let wave = |per_mm: f64, phase: f64| responses(axis, 0.0, |run, k| (TAU * per_mm * record.runs[run].actual[k] - phase).cos());
    let regressors: Vec<Vec<Vec<f64>>> =
        peaks.iter().flat_map(|&per_mm| [0.0, 0.25 * TAU].map(|phase| wave(per_mm, phase))).collect();
    let Some(regression) = Regression::of(&axis.residuals, &regressors, first, record.period_s) else { return Vec::new() };
    let fit = |(i, &per_mm): (usize, &f64)| {
        let (a, b) = (regression.weights[2 * i], regression.weights[2 * i + 1]);
        let amplitude = a.hypot(b);
        let covariance = regression.covariance.fixed_view::<2, 2>(2 * i, 2 * i);
        let variance = (a * a * covariance[(0, 0)] + 2.0 * a * b * covariance[(0, 1)] + b * b * covariance[(1, 1)])
            / amplitude.powi(2).max(1e-30);
        let deflection_um = Estimate::within(amplitude, SPREAD * variance.max(0.0).sqrt().hypot(STRUCTURAL * amplitude))
            .times(1e3)
            .not_negative();
        let (mut squares, mut count) = (0.0, 0_usize);
        for (run, (cosine, sine)) in record.runs.iter().zip(regressors[2 * i].iter().zip(&regressors[2 * i + 1])) {
            for k in first..run.len() {
                if run.velocity(k, record.period_s).abs() > MOVING_MM_S {
                    squares += (a * cosine[k] + b * sine[k]).powi(2);
                    count += 1;
                }
            }
        }
        let shown = (2.0 * squares / count.max(1) as f64).sqrt() / amplitude.max(1e-30);
        WaveFit {
            per_mm,
            effect_um: deflection_um.times(shown),
            deflection_um,
            shown,
            certainty: regression.wald(2 * i, 2 * i + 2),
        }
    };
    peaks.iter().enumerate().map(fit).collect()
}
