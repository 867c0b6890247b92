//! What a run is expected to come to: the forecast, and what the model itself is off by.

use models::{AxisSignal, Bundle, PEAK_S, Spread};
use motion::{DesiredPath, Trajectory, Vec3};
use serde::Serialize;

use crate::error::Result;
use crate::input::Input;
use crate::statistics::{contour_errors, counts};

/// A figure that a run is expected to have: nine runs in ten lie between `low` and `high`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Expected {
    /// 5 % of the runs stay below, mm.
    pub low: f64,
    /// The middle, mm.
    pub middle: f64,
    /// 95 % stay below, mm.
    pub high: f64,
}

/// Contour error of the tool tip that a run is expected to show: what the forecast leaves and, on top, errors of the model as large as those on
/// the runs that training held out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expectation {
    /// Root mean square.
    pub rms: Expected,
    /// Largest.
    pub max: Expected,
}

/// Step of an axis by which its effect on the tool tip is found, mm or rad.
const STEP: f64 = 1e-4;

impl Expectation {
    /// What a run of `reference` comes to of which the model forecasts `forecast`; over feed moves of a program. `None` where the model does not say how large
    /// its errors are.
    ///
    /// An axis's error counts across the path: with the direction of motion `t` and `J` the way of the tip for a unit of the axis, `|J − t(t·J)|`. Errors of
    /// axes are taken as independent, their squares add up.
    ///
    /// # Errors
    /// When forecast and path do not match.
    pub fn of(bundle: &Bundle, input: &Input, reference: &Trajectory, forecast: &Trajectory) -> Result<Option<Self>> {
        let (desired, part) = (input.desired(), input.part());
        let Some(axes) = axis_errors(bundle, desired.trajectory(), reference) else { return Ok(None) };
        let counted: Vec<usize> = (0..desired.trajectory().len()).filter(|k| counts(part, *k)).collect();
        if counted.is_empty() || axes.is_empty() {
            return Ok(None);
        }
        let errors = contour_errors(desired, forecast)?;
        let left: Vec<f64> = counted.iter().map(|k| errors[*k].magnitude_mm).collect();
        let across = across(desired, &axes, &counted);
        let samples = (PEAK_S / desired.trajectory().period_s()).round().max(1.0) as usize;
        Ok(Some(Self { rms: rms(&axes, &across, &left), max: max(&axes, &across, &left, samples) }))
    }
}

/// What the model says of its errors on an axis.
struct AxisError<'a> {
    /// Index of the axis.
    axis: usize,
    /// Root mean square at every sample, mm or rad.
    rms: Vec<f64>,
    spread: &'a Spread,
}

/// What the model says of its errors on the axes of `path`; `None` where it does not.
fn axis_errors<'a>(bundle: &'a Bundle, path: &Trajectory, reference: &Trajectory) -> Option<Vec<AxisError<'a>>> {
    let mut axes = Vec::new();
    for known in &bundle.manifest.axes {
        let Some(axis) = path.axes().iter().position(|axis| axis.name == known.name) else { continue };
        let desired = Some(path.columns()[axis].as_slice());
        let signal = AxisSignal { desired, ..AxisSignal::uncompensated(&reference.columns()[axis], path.period_s()) };
        let spread = known.band.spread()?;
        axes.push(AxisError { axis, rms: spread.at(&signal), spread });
    }
    Some(axes)
}

/// The root mean square: that of the forecast, and of every axis's error.
fn rms(axes: &[AxisError<'_>], across: &[Vec<f64>], left: &[f64]) -> Expected {
    let mean_square = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64;
    let mut squares = [mean_square(left); 3];
    for (axis, across) in axes.iter().zip(across) {
        let own = mean_square(across);
        for (square, multiple) in squares.iter_mut().zip(axis.spread.multiples()) {
            *square += own * multiple * multiple;
        }
    }
    let [low, middle, high] = squares.map(f64::sqrt);
    Expected { low, middle, high }
}

/// The largest error, from the peaks of every axis in every stretch of so many samples.
fn max(axes: &[AxisError<'_>], across: &[Vec<f64>], left: &[f64], samples: usize) -> Expected {
    let largest = |of: &[f64]| of.iter().copied().fold(0.0, f64::max);
    let stretch = |from: usize| {
        let rows = from..(from + samples).min(left.len());
        let peaks = axes.iter().zip(across).map(|(axis, of)| (largest(&of[rows.clone()]), axis.spread));
        Stretch { left_mm: largest(&left[rows.clone()]), axes: peaks.collect() }
    };
    let stretches: Vec<Stretch<'_>> = (0..left.len()).step_by(samples).map(stretch).collect();
    Expected {
        low: quantile(&stretches, 0.05, |spread| spread.multiples()[0]),
        middle: quantile(&stretches, 0.5, |_| 1.0),
        high: quantile(&stretches, 0.95, Spread::upper),
    }
}

/// Size of every axis's error across the path at the samples that count, mm.
fn across(desired: &DesiredPath, axes: &[AxisError<'_>], counted: &[usize]) -> Vec<Vec<f64>> {
    let (path, kinematics) = (desired.trajectory(), desired.kinematics());
    let tip = |k: usize| desired.poses()[k].tip;
    let direction = |k: usize| (tip((k + 1).min(path.len() - 1)) - tip(k.saturating_sub(1))).try_normalize(1e-9);
    let of = |axis: &AxisError<'_>| {
        let effect = |k: usize| -> Vec3 {
            if let Some(slot) = path.axes()[axis.axis].slot().filter(|_| !kinematics.has_rotary_axes()) {
                return Vec3::from_fn(|row, _| f64::from(u8::from(row == slot)));
            }
            let mut joints: Vec<f64> = path.at(k).collect();
            joints[axis.axis] += STEP;
            (kinematics.forward(&joints).tip - tip(k)) / STEP
        };
        let size = |k: &usize| {
            let effect = effect(*k);
            let along = direction(*k).map_or(Vec3::zeros(), |t| t * t.dot(&effect));
            (effect - along).norm() * axis.rms[*k]
        };
        counted.iter().map(size).collect()
    };
    axes.iter().map(of).collect()
}

/// Half a second of a run.
struct Stretch<'a> {
    /// Largest error that the forecast leaves, mm.
    left_mm: f64,
    /// Expected root mean square of the model's error of every axis across the path, mm.
    axes: Vec<(f64, &'a Spread)>,
}

/// The largest error that so large a share of the runs stay below, mm, with errors of every axis so many times as large as expected: each axis has a largest one of
/// its own in each stretch.
fn quantile(stretches: &[Stretch<'_>], share: f64, times: impl Fn(&Spread) -> f64) -> f64 {
    let below = |max_mm: f64| -> f64 {
        let one = |stretch: &Stretch<'_>| {
            let room = max_mm * max_mm - stretch.left_mm * stretch.left_mm;
            if room < 0.0 {
                return 0.0;
            }
            let axis = |(rms_mm, spread): &(f64, &Spread)| {
                if *rms_mm > 0.0 { spread.below(room.sqrt() / (rms_mm * times(spread))) } else { 1.0 }
            };
            stretch.axes.iter().map(axis).product::<f64>()
        };
        stretches.iter().map(one).product()
    };
    let mut high = stretches.iter().map(|stretch| stretch.left_mm).fold(1e-6, f64::max);
    while below(high) < share && high < 1e6 {
        high *= 2.0;
    }
    let mut low = 0.0;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if below(middle) < share { low = middle } else { high = middle }
    }
    high
}
