//! The cascaded controller: position P, velocity PI, current lag.

use std::collections::VecDeque;

use super::reference::Command;
use crate::spec::LoopSpec;

/// Position loop `v* = K_pp (e + ∫e dt / T_i) + k_d ė + k_ff ṙ` with `e = r − x`, in the units of
/// its arguments. Its output may be delayed by some periods. Without integral time and derivative
/// gain it is the P loop of a cascade.
#[derive(Debug, Clone)]
pub(super) struct PositionLoop {
    gain: f64,
    feed_forward: f64,
    /// Integral per period and unit of error, 1/s; 0 for none.
    integral_gain_step: f64,
    integral: f64,
    /// Speed per change of the error between periods, 1/s; 0 for none.
    derivative_gain: f64,
    before: Option<f64>,
    /// Delayed outputs.
    late: VecDeque<f64>,
}

impl PositionLoop {
    pub(super) fn new(spec: &LoopSpec) -> Self {
        let gain = spec.position_gain_1_s;
        Self {
            gain,
            feed_forward: spec.feed_forward,
            integral_gain_step: spec.position_integral_ms.map_or(0.0, |time| gain * spec.position_period_ms / time),
            integral: 0.0,
            derivative_gain: spec.position_derivative / (spec.position_period_ms * 1e-3),
            before: None,
            late: VecDeque::from(vec![0.0; usize::from(spec.delay_periods)]),
        }
    }

    /// Commanded speed of this period.
    pub(super) fn step(&mut self, command: &Command, measured: f64) -> f64 {
        let error = command.position - measured;
        let mut speed = self.gain * error + self.feed_forward * command.slope;
        if self.integral_gain_step != 0.0 {
            self.integral += self.integral_gain_step * error;
            speed += self.integral;
        }
        if self.derivative_gain != 0.0 {
            speed += self.derivative_gain * (error - self.before.unwrap_or(error));
            self.before = Some(error);
        }
        if self.late.is_empty() {
            return speed;
        }
        self.late.push_back(speed);
        self.late.pop_front().unwrap_or(speed)
    }
}

/// Velocity loop: PI with a torque limit. The integrator stops while it would drive the torque
/// further into the limit.
#[derive(Debug, Clone)]
pub(super) struct VelocityLoop {
    gain: f64,
    integral_gain_step: f64,
    limit: f64,
    integral: f64,
}

impl VelocityLoop {
    pub(super) fn new(spec: &LoopSpec, torque_limit_n_m: f64) -> Self {
        let gain = spec.velocity_gain_n_m_s_rad;
        Self {
            gain,
            integral_gain_step: gain * spec.velocity_period_ms / spec.integral_time_ms,
            limit: torque_limit_n_m,
            integral: 0.0,
        }
    }

    /// Commanded torque, N·m, for a speed error in rad/s and a feed-forward torque, N·m.
    pub(super) fn step(&mut self, error_rad_s: f64, feed_torque: f64) -> f64 {
        let increment = self.integral_gain_step * error_rad_s;
        let torque = self.gain * error_rad_s + self.integral + increment + feed_torque;
        if torque.abs() <= self.limit || torque * increment < 0.0 {
            self.integral += increment;
        }
        torque.clamp(-self.limit, self.limit)
    }
}

/// Current loop: first-order lag, stepped exactly under a constant command.
#[derive(Debug, Clone)]
pub(super) struct CurrentLag {
    approach: f64,
    torque: f64,
}

impl CurrentLag {
    pub(super) fn new(lag_s: f64, step_s: f64) -> Self {
        Self { approach: 1.0 - (-step_s / lag_s).exp(), torque: 0.0 }
    }

    /// Torque one step later, N·m.
    pub(super) fn step(&mut self, command: f64) -> f64 {
        self.torque += self.approach * (command - self.torque);
        self.torque
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec() -> LoopSpec {
        LoopSpec {
            position_gain_1_s: 100.0,
            feed_forward: 0.9,
            velocity_gain_n_m_s_rad: 0.4,
            integral_time_ms: 12.0,
            current_lag_ms: 0.2,
            position_period_ms: 1.0,
            velocity_period_ms: 0.25,
            integration_step_us: 25.0,
            position_integral_ms: None,
            position_derivative: 0.0,
            acceleration_feed_forward: 0.0,
            command_average_ms: 0.0,
            command_lag_ms: 0.0,
            delay_periods: 0,
        }
    }

    #[test]
    fn the_torque_limit_holds_and_the_integrator_does_not_wind_up() {
        let mut velocity_loop = VelocityLoop::new(&spec(), 8.0);
        for _ in 0..10_000 {
            assert!(velocity_loop.step(50.0, 0.0) <= 8.0);
        }
        // Without anti-windup the integrator would hold thousands of N·m and stay at the limit for
        // seconds.
        assert!(velocity_loop.step(-25.0, 0.0) < 0.0);
    }

    #[test]
    fn the_position_loop_integrates_differentiates_and_delays() {
        let ramp = |t: f64| Command { position: 2.0 * t, slope: 2.0, acceleration: 0.0 };
        let all = |spec: &LoopSpec| {
            let mut position_loop = PositionLoop::new(spec);
            (0..4).map(|k| position_loop.step(&ramp(f64::from(k) * 1e-3), 0.0)).collect::<Vec<_>>()
        };
        let plain = all(&LoopSpec { feed_forward: 0.5, ..spec() });
        assert!((plain[3] - (100.0 * 6e-3 + 1.0)).abs() < 1e-12);
        let late = all(&LoopSpec { feed_forward: 0.5, delay_periods: 2, ..spec() });
        assert_eq!(late, [0.0, 0.0, plain[0], plain[1]]);
        let pid = all(&LoopSpec { feed_forward: 0.5, position_integral_ms: Some(10.0), position_derivative: 0.1, ..spec() });
        // ∫e of 0, 2, 4 and 6 µm of 1 ms each, and ė = 2 mm/s.
        assert!((pid[3] - (plain[3] + 100.0 / 10.0 * 12e-3 + 0.2)).abs() < 1e-12, "{}", pid[3]);
    }

    #[test]
    fn the_lag_is_exact() {
        let mut lag = CurrentLag::new(2e-4, 2.5e-5);
        let torque = (0..8).map(|_| lag.step(1.0)).last().unwrap();
        assert!((torque - (1.0 - (-1.0_f64).exp())).abs() < 1e-12);
    }
}
