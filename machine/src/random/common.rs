//! Parameters common to all axes of a random machine.

use super::draw::Draw;

/// Range of position gains, 1/s.
pub(super) const POSITION_GAIN_1_S: [f64; 2] = [20.0, 120.0];

/// Structure of the position loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Structure {
    Cascade,
    Pid,
}

/// Drive train.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Train {
    ElasticScrew,
    StiffScrew,
    LinearMotor,
}

/// Command smoothing, ms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Smoothing {
    None,
    Average(f64),
    Lag(f64),
}

/// Friction model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum FrictionKind {
    LuGre,
    Maxwell,
    Coulomb,
    Stribeck,
}

/// Parameters common to all axes of a machine.
#[derive(Debug, Clone, Copy)]
pub(super) struct Common {
    pub structure: Structure,
    pub position_gain_1_s: f64,
    /// Bandwidth of the velocity loops, as a multiple of the position gain.
    pub bandwidth_ratio: f64,
    /// Integral time and derivative gain of a PID.
    pub position_integral_ms: f64,
    pub position_derivative: f64,
    pub feed_forward: f64,
    pub acceleration_feed_forward: f64,
    pub smoothing: Smoothing,
    pub delay_periods: u8,
    pub train: Train,
    pub encoder_step_um: f64,
    pub friction: FrictionKind,
    /// Share and time constant, s.
    pub warming: Option<(f64, f64)>,
    pub velocity_mm_s: f64,
    pub acceleration_mm_s2: f64,
    pub jerk_mm_s3: f64,
}

impl Train {
    fn of(draw: &mut Draw) -> Self {
        match draw.uniform(0.0, 1.0) {
            p if p < 0.55 => Self::ElasticScrew,
            p if p < 0.75 => Self::StiffScrew,
            _ => Self::LinearMotor,
        }
    }
}

impl Smoothing {
    fn of(draw: &mut Draw) -> Self {
        let time_ms = draw.log_uniform(1.0, 30.0);
        match draw.uniform(0.0, 1.0) {
            p if p < 0.35 => Self::None,
            p if p < 0.75 => Self::Average(time_ms),
            _ => Self::Lag(time_ms),
        }
    }

    /// Squared time constant of a lag, or a twelfth of the squared window of an average, s².
    fn squared_time_s2(self) -> f64 {
        1e-6 * match self {
            Self::None => 0.0,
            Self::Average(window_ms) => window_ms * window_ms / 12.0,
            Self::Lag(time_ms) => time_ms * time_ms,
        }
    }
}

impl FrictionKind {
    fn of(draw: &mut Draw) -> Self {
        match draw.uniform(0.0, 1.0) {
            p if p < 0.35 => Self::LuGre,
            p if p < 0.7 => Self::Maxwell,
            p if p < 0.85 => Self::Coulomb,
            _ => Self::Stribeck,
        }
    }
}

impl Common {
    /// Draws in the order of the table of the module.
    pub(super) fn of(draw: &mut Draw) -> Self {
        let structure = if draw.chance(0.6) { Structure::Cascade } else { Structure::Pid };
        let position_gain_1_s = draw.log_uniform(POSITION_GAIN_1_S[0], POSITION_GAIN_1_S[1]);
        let bandwidth_ratio = draw.log_uniform(3.0, 10.0);
        let position_integral_ms = draw.log_uniform(40.0, 300.0);
        let derivative = draw.uniform(0.0, 0.2);
        let position_derivative = if draw.chance(0.5) { 0.0 } else { derivative };
        let share = |draw: &mut Draw, none: f64| if draw.chance(none) { 0.0 } else { draw.uniform(0.0, 1.0) };
        let feed_forward = match structure {
            Structure::Cascade => share(draw, 0.25),
            // Without feed-forward the integrator winds up on every curve. No PID is used in this
            // way.
            Structure::Pid => draw.uniform(0.8, 1.0),
        };
        let acceleration_feed_forward = share(draw, 0.5);
        let smoothing = Smoothing::of(draw);
        let delay_periods = if draw.chance(0.4) { 0 } else { *draw.one_of(&[1, 2, 3, 4, 5]) };
        let train = Train::of(draw);
        let encoder_step_um = draw.log_uniform(0.001, 1.0);
        let friction = FrictionKind::of(draw);
        let warming = (draw.uniform(0.02, 0.08), draw.log_uniform(100.0, 1500.0));
        let warming = if draw.chance(0.5) { None } else { Some(warming) };
        let lag_mm = draw.log_uniform(0.01, 0.06);
        // On a circle a lag reduces the radius by `a/2` times its squared time constant. The lag of
        // the velocity loop is about a fifth of that of the position loop.
        let loop_s2 = (1.04 - feed_forward * feed_forward) / position_gain_1_s.powi(2);
        // The tracking error of a PID is the acceleration without its feed-forward part, divided by
        // the integral gain.
        let wound_s2 = 2.0 * (1.0 - feed_forward) * position_integral_ms * 1e-3 / position_gain_1_s;
        let lag_s2 = smoothing.squared_time_s2() + if structure == Structure::Pid { loop_s2.max(wound_s2) } else { loop_s2 };
        let acceleration_mm_s2 = (2.0 * lag_mm / lag_s2).clamp(100.0, 2500.0);
        let velocity_mm_s = draw.log_uniform(40.0, 150.0).min(0.5 * acceleration_mm_s2);
        let jerk_mm_s3 = acceleration_mm_s2 * position_gain_1_s * draw.log_uniform(0.3, 1.2);
        Self {
            structure,
            position_gain_1_s,
            bandwidth_ratio,
            position_integral_ms,
            position_derivative,
            feed_forward,
            acceleration_feed_forward,
            smoothing,
            delay_periods,
            train,
            encoder_step_um,
            friction,
            warming,
            velocity_mm_s,
            acceleration_mm_s2,
            jerk_mm_s3,
        }
    }
}
