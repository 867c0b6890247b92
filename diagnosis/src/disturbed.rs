//! Response of the loops to a force.

use servo::Servo;

/// Step of the integration, s.
const STEP_S: f64 = 5e-4;

/// Deviation of the position by a force, mm, at the samples of `deflection_mm`: the force as the deflection that it makes of the loops
/// without integrator, positive forces in positive direction. The axis does not stick: it answers as in motion.
#[must_use]
pub fn disturbed(servo: &Servo, deflection_mm: &[f64], period_s: f64) -> Vec<f64> {
    let steps = (period_s / STEP_S).ceil().max(1.0) as usize;
    let step_s = period_s / steps as f64;
    let bandwidth = servo.bandwidth_1_s;
    let stiffness = bandwidth * servo.position_gain_1_s;
    let implicit = 1.0 / (1.0 + step_s * bandwidth * (1.0 + servo.viscous));
    let (mut position, mut velocity, mut integral, mut position_integral) = (0.0, 0.0, 0.0, 0.0);
    let late = (servo.loop_delay_s / step_s).round() as usize;
    let mut wanted = vec![0.0; late + 1];
    let mut next = 0;
    let mut out = Vec::with_capacity(deflection_mm.len());
    for (k, &here) in deflection_mm.iter().enumerate() {
        out.push(position);
        let ahead = deflection_mm.get(k + 1).copied().unwrap_or(here);
        for i in 0..steps {
            let force = here + (ahead - here) * i as f64 / steps as f64;
            position_integral -= servo.position_integral_1_s * position * step_s;
            wanted[next] = servo.position_gain_1_s * (position_integral - position);
            next = if next == late { 0 } else { next + 1 };
            let command = wanted[next];
            integral += servo.integral * bandwidth * bandwidth * (command - velocity) * step_s;
            velocity = (velocity + step_s * (bandwidth * command + integral + stiffness * force)) * implicit;
            position += step_s * velocity;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_force_deflects_a_stiff_loop_and_is_removed_by_an_integrator() {
        let stiff = Servo { integral: 0.0, ..Servo::usual(60.0, 0.0) };
        let force = vec![5e-3; 1000];
        assert!((disturbed(&stiff, &force, 0.002)[999] - 5e-3).abs() < 1e-6);
        let cascade = disturbed(&Servo::usual(60.0, 0.0), &force, 0.002);
        assert!(cascade[999].abs() < 1e-5 && cascade.iter().any(|x| *x > 1e-3));
    }
}
