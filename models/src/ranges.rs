//! Ranges of all numbers of a model file.
//!
//! A model file may come from anyone. Each range holds what any axis and log can give, and excludes
//! what would overflow, or take hours or gigabytes, in a prediction.

/// Lowest and highest value.
pub(crate) type Range = [f64; 2];

/// Largest position, mm or rad: a kilometre, as in logs.
const FARTHEST: f64 = 1e6;
/// Sampling period, s: as in logs.
pub(crate) const PERIOD_S: Range = [1e-6, 10.0];
/// Delay, s: of the order of the longest sampling period, on either side.
pub(crate) const DELAY_S: Range = [-10.0, 10.0];
/// Position of an axis, mm or rad.
pub(crate) const POSITION: Range = [-FARTHEST, FARTHEST];
/// Width, length or error, mm or rad.
pub(crate) const LENGTH: Range = [0.0, FARTHEST];
/// Length or speed by which signals are divided, from a nanometre on.
pub(crate) const DIVISOR: Range = [1e-9, FARTHEST];
/// Velocity, mm/s or rad/s; acceleration and jerk likewise: of a jump by [`FARTHEST`] within the
/// shortest period.
pub(crate) const VELOCITY: Range = [0.0, 1e12];
/// Acceleration, mm/s² or rad/s².
pub(crate) const ACCELERATION: Range = [0.0, 1e18];
/// Jerk, mm/s³ or rad/s³.
pub(crate) const JERK: Range = [0.0, 1e24];
/// Ratio of two errors or times.
pub(crate) const RATIO: Range = [0.0, 1e9];
/// Weight, tap or mean: far above those of any fit, far below an overflow in a product of three.
pub(crate) const WEIGHT: Range = [-1e12, 1e12];
/// Deviation that scales a signal.
pub(crate) const DEVIATION: Range = [1e-12, 1e12];

/// Axes of a model: more than any control moves.
pub(crate) const MOST_AXES: usize = 32;
/// Samples of a window or lag: ten seconds at 10 kHz.
pub(crate) const MOST_SAMPLES: usize = 100_000;
/// Signals of one kind in a pass: twenty times as many as the default recipe has.
pub(crate) const MOST_SIGNALS: usize = 200;
/// Regressors of a pass: likewise.
pub(crate) const MOST_REGRESSORS: usize = 1_000;
/// Passes of a predictor: likewise.
pub(crate) const MOST_PASSES: usize = 100;
/// Products per sample of a pass: ten times as many as the default recipe takes at 10 kHz.
pub(crate) const MOST_PRODUCTS: usize = 1_000_000;

/// Refuses a value outside its range.
pub(crate) fn within(key: &str, value: f64, [low, high]: Range) -> Result<(), String> {
    if (low..=high).contains(&value) { Ok(()) } else { Err(format!("`{key}` is {value:e}; its range is {low:e} to {high:e}")) }
}

/// Refuses a list with a value outside its range.
pub(crate) fn all_within(key: &str, values: &[f64], range: Range) -> Result<(), String> {
    values.iter().enumerate().try_for_each(|(index, value)| within(&format!("{key}[{index}]"), *value, range))
}

/// The same in single precision.
pub(crate) fn singles_within(key: &str, values: &[f32], range: Range) -> Result<(), String> {
    values.iter().enumerate().try_for_each(|(index, value)| within(&format!("{key}[{index}]"), f64::from(*value), range))
}

/// Refuses a count above `most`.
pub(crate) fn at_most(key: &str, count: usize, most: usize) -> Result<(), String> {
    if count <= most { Ok(()) } else { Err(format!("`{key}` is {count}; it must be {most} or less")) }
}
