//! The cascaded controller: position P, velocity PI, current lag.

use crate::spec::LoopSpec;

/// Position loop `v* = K_pp (r − x) + k_ff ṙ`, in the units of its arguments.
pub(super) fn position_loop(spec: &LoopSpec, reference: f64, slope: f64, measured: f64) -> f64 {
    spec.position_gain_1_s * (reference - measured) + spec.feed_forward * slope
}

/// Velocity loop: PI with a torque limit; its integrator stands still while it would push further into the limit.
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

    /// Commanded torque, N·m, for a speed error in rad/s.
    pub(super) fn step(&mut self, error_rad_s: f64) -> f64 {
        let increment = self.integral_gain_step * error_rad_s;
        let torque = self.gain * error_rad_s + self.integral + increment;
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
        }
    }

    #[test]
    fn the_torque_limit_holds_and_the_integrator_does_not_wind_up() {
        let mut velocity_loop = VelocityLoop::new(&spec(), 8.0);
        for _ in 0..10_000 {
            assert!(velocity_loop.step(50.0) <= 8.0);
        }
        // Without anti-windup the integrator would hold thousands of N·m and keep the limit for seconds.
        assert!(velocity_loop.step(-25.0) < 0.0);
    }

    #[test]
    fn the_lag_is_exact() {
        let mut lag = CurrentLag::new(2e-4, 2.5e-5);
        let torque = (0..8).map(|_| lag.step(1.0)).last().unwrap();
        assert!((torque - (1.0 - (-1.0_f64).exp())).abs() < 1e-12);
    }
}
