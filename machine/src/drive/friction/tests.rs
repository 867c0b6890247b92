use super::*;
use crate::MachineSpec;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Uniform};

const STEP_S: f64 = 2.5e-5;

fn both() -> [(&'static str, Friction); 2] {
    ["ballscrew", "maxwell"].map(|name| {
        let spec = MachineSpec::builtin(name).unwrap();
        let drive = spec.axes[0].drive().unwrap();
        (name, Friction::new(&drive.friction, 0.6))
    })
}

/// Energy dissipated by friction along a closed motion, J, per cycle, and the forces of each cycle.
fn cycles(friction: &mut Friction, amplitude: f64, frequency: f64, count: usize) -> Vec<(f64, Vec<f64>)> {
    let steps = (1.0 / (frequency * STEP_S)).round() as usize;
    let position = |k: usize| amplitude * (std::f64::consts::TAU * k as f64 / steps as f64).sin();
    (0..count)
        .map(|_| {
            let mut work = 0.0;
            let forces = (0..steps)
                .map(|k| {
                    let travelled = position(k + 1) - position(k);
                    let force = friction.step(travelled / STEP_S, 1.0, STEP_S);
                    work += force * travelled;
                    force
                })
                .collect();
            (work, forces)
        })
        .collect()
}

#[test]
fn closed_cycles_dissipate_from_presliding_to_fast_sliding() {
    for (name, friction) in both() {
        for (amplitude, frequency) in [(2e-7, 20.0), (2e-6, 5.0), (2e-5, 10.0), (1e-3, 5.0), (1e-2, 1.0)] {
            let last = cycles(&mut friction.clone(), amplitude, frequency, 6).pop().unwrap().0;
            assert!(last > 0.0, "{name}: {last} J at amplitude {amplitude} m");
            // Never above the breakaway force.
            assert!(last <= 4.0 * amplitude * friction.static_n * 1.1, "{name} {last}");
        }
    }
}

#[test]
fn random_motion_never_draws_energy_beyond_what_was_stored() {
    for (name, friction) in both() {
        for seed in 0..20 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let kick = Uniform::new(-1.0, 1.0).unwrap();
            let mut friction = friction.clone();
            let (mut velocity, mut work, mut lowest) = (0.0, 0.0, 0.0_f64);
            let scale = 10.0_f64.powi(-2 - (seed % 4) as i32);
            for _ in 0..20_000 {
                velocity = 0.999 * velocity + 0.05 * scale * kick.sample(&mut rng);
                work += friction.step(velocity, 1.0, STEP_S) * velocity * STEP_S;
                lowest = lowest.min(work);
            }
            // Starting unloaded, a passive model never returns net energy, rounding aside.
            assert!(lowest > -1e-9 && work > 0.0, "{name}, seed {seed}: {lowest} J");
        }
    }
}

#[test]
fn presliding_loops_close() {
    for (name, mut friction) in both() {
        let loops = cycles(&mut friction, 1.5e-6, 5.0, 40);
        let (last, before) = (&loops[39].1, &loops[38].1);
        let range = last.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        let gap = last.iter().zip(before).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
        assert!(gap < 0.01 * range, "{name}: {gap} of {range} N");
    }
}

#[test]
fn steady_sliding_follows_the_stribeck_curve() {
    for (name, friction) in both() {
        for speed in [2e-4, 1e-3, 2e-3, 5e-3, 5e-2] {
            for sign in [1.0, -1.0] {
                let mut friction = friction.clone();
                let mut force = 0.0;
                for _ in 0..((1e-3 / speed / STEP_S) as usize).max(2000) {
                    force = friction.step(sign * speed, 1.0, STEP_S);
                }
                let fade = (-(speed * friction.per_stribeck_s_m).powi(2)).exp();
                let steady = friction.coulomb_n + (friction.static_n - friction.coulomb_n) * fade;
                let expected = sign * steady * (1.0 + sign * friction.asymmetry);
                // The sticking damping of the Maxwell model is the only additional force.
                assert!((force / expected - 1.0).abs() < 0.03, "{name} at {speed}: {force}, {expected}");
            }
        }
    }
}

#[test]
fn no_friction_is_no_force() {
    for (_, mut friction) in both() {
        (friction.coulomb_n, friction.static_n) = (0.0, 0.0);
        if let Model::Maxwell(model) = &mut friction.model {
            *model = MaxwellSlip::new(0.0, &[1.0], &[1.0], 0.0);
        }
        assert_eq!(friction.step(0.01, 1.0, STEP_S), 0.0);
    }
}
