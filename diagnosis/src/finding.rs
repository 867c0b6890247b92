//! What a diagnosis states: findings with value, interval, verdict, remedy and picture.

use serde::Serialize;

/// A quantity that is diagnosed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// Position gain `K_v` of the servo loop.
    VelocityGain,
    /// Time by which the axis lags at constant speed.
    FollowingLag,
    /// Difference of the lags of two axes, as the ellipse that it makes of a circle.
    ServoMismatch,
    /// Delay between the channels of command and actual position, and averaging of the command.
    ChannelDelay,
    /// Velocity feed-forward.
    VelocityFeedForward,
    /// Acceleration feed-forward.
    AccelerationFeedForward,
    /// Coulomb friction.
    CoulombFriction,
    /// Stribeck effect: static over sliding friction.
    StribeckFriction,
    /// Backlash.
    Backlash,
    /// Peaks after reversals.
    ReversalPeak,
    /// Error that repeats with the position: screw, motor, magnets.
    Ripple,
    /// Pitch error of screw or scale.
    PitchError,
    /// Resonance of the drive.
    Resonance,
    /// Stick–slip at low speed.
    StickSlip,
    /// Noise and what does not repeat.
    Repeatability,
    /// Drift between the logs.
    Drift,
    /// Friction that depends on the place.
    PlaceFriction,
}

/// Rating of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Below the lower threshold.
    Good,
    /// Between the thresholds.
    Fair,
    /// Above the upper threshold.
    Poor,
    /// A figure without a threshold.
    Figure,
    /// The logs do not show it.
    NotObservable,
}

/// A value with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

impl Estimate {
    /// A value with a symmetric interval.
    #[must_use]
    pub fn within(value: f64, half: f64) -> Self {
        Self { value, low: value - half, high: value + half }
    }

    /// The same in another unit: all three times a positive `factor`.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self { value: self.value * factor, low: self.low * factor, high: self.high * factor }
    }

    /// With no end below zero, for a quantity that cannot be negative.
    #[must_use]
    pub fn not_negative(self) -> Self {
        Self { value: self.value.max(0.0), low: self.low.max(0.0), high: self.high.max(0.0) }
    }

    /// Whether `truth` lies in the interval.
    #[must_use]
    pub fn covers(&self, truth: f64) -> bool {
        (self.low..=self.high).contains(&truth)
    }
}

/// A plain picture: series of points on common axes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Picture {
    /// Title.
    pub title: String,
    /// Label and unit of the horizontal axis.
    pub x: Label,
    /// Label and unit of the vertical axis.
    pub y: Label,
    /// The series.
    pub series: Vec<Series>,
}

/// Label of an axis of a picture.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Label {
    /// What it shows.
    pub name: String,
    /// Its unit.
    pub unit: String,
}

impl Label {
    /// A label with its unit.
    #[must_use]
    pub fn new(name: &str, unit: &str) -> Self {
        Self { name: name.to_owned(), unit: unit.to_owned() }
    }
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mark {
    /// A line.
    Line,
    /// Points that are not joined, in any order.
    Points,
    /// The lower edge of a band; the upper one follows.
    Lower,
    /// The upper edge of a band.
    Upper,
}

/// One series of points.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Series {
    /// Name.
    pub name: String,
    /// How it is drawn.
    pub mark: Mark,
    /// Horizontal values.
    pub x: Vec<f64>,
    /// Vertical values, as many.
    pub y: Vec<f64>,
}

impl Series {
    /// A series of points.
    #[must_use]
    pub fn new(name: impl Into<String>, mark: Mark, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let (x, y) = points.into_iter().unzip();
        Self { name: name.into(), mark, x, y }
    }
}

/// What the logs say about one quantity.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// The quantity.
    pub quantity: Quantity,
    /// Axis, or axes of a pair: `x`, `x-y`.
    pub axis: String,
    /// Value with its interval; `None` where it is not observable.
    pub estimate: Option<Estimate>,
    /// Unit of the value.
    pub unit: &'static str,
    /// Deviation that it makes on the test circle or in the logs, µm; what the verdict goes by.
    pub effect_um: Option<Estimate>,
    /// The verdict.
    pub verdict: Verdict,
    /// Further figures: name with unit, value.
    pub details: Vec<(&'static str, f64)>,
    /// What it means.
    pub meaning: String,
    /// What to do; what to record where it is not observable. Empty where nothing is to be done.
    pub remedy: String,
    /// The picture.
    pub picture: Option<Picture>,
}

impl Finding {
    /// A quantity that the logs do not show.
    #[must_use]
    pub fn not_observable(
        quantity: Quantity,
        axis: &str,
        unit: &'static str,
        why: impl Into<String>,
        record: impl Into<String>,
    ) -> Self {
        Self {
            quantity,
            axis: axis.to_owned(),
            estimate: None,
            unit,
            effect_um: None,
            verdict: Verdict::NotObservable,
            details: Vec::new(),
            meaning: why.into(),
            remedy: record.into(),
            picture: None,
        }
    }
}
