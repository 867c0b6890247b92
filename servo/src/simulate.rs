//! The servo model of an axis, run on a command.
//!
//! ```text
//! command   r = the logged command, late by the delay, averaged, then behind a first-order lag
//! ```

use pulp::{Arch, Simd, WithSimd};

use crate::axis::{Axis, Start};
use crate::command::Command;
use crate::lanes::Lanes;
use crate::parameters::Servo;

/// Largest step of the integration, s: half the period of a usual position loop.
pub const STEP_S: f64 = 5e-4;

/// A simulated run.
#[derive(Debug, Clone, Default)]
pub struct Simulated {
    /// Actual positions at the samples of the reference, mm.
    pub positions: Vec<f64>,
    /// Friction at the samples, as a deflection, mm: against the direction of motion.
    pub friction_mm: Vec<f64>,
}

/// Speed above which an axis moves, mm/s.
pub const MOVING_MM_S: f64 = 0.05;
/// Samples over which the speed at the start of a command is taken.
const START_SAMPLES: usize = 5;

/// Actual positions of the model at the samples of `reference`, mm. Starts at `start`.
#[must_use]
pub fn simulate(servo: &Servo, reference: &[f64], period_s: f64, start: impl Into<Start>) -> Vec<f64> {
    simulate_with_friction(servo, reference, period_s, start).positions
}

/// Speed of a command at its start, mm/s; 0 where it is at rest.
#[must_use]
pub fn speed_at_start(reference: &[f64], period_s: f64) -> f64 {
    let over = START_SAMPLES.min(reference.len().saturating_sub(1));
    let moves = reference.windows(2).take(over).any(|pair| (pair[1] - pair[0]).abs() > MOVING_MM_S * period_s);
    if moves { (reference[over] - reference[0]) / (over as f64 * period_s) } else { 0.0 }
}

impl Servo {
    /// Actual positions that the axis takes under a command, mm, where nothing but the command is known: it starts at the rest that the
    /// fit found, or in steady motion.
    #[must_use]
    pub fn follow(&self, reference: &[f64], period_s: f64) -> Vec<f64> {
        simulate(self, reference, period_s, self.start(reference, period_s))
    }

    /// Expected start of a run.
    #[must_use]
    pub fn start(&self, reference: &[f64], period_s: f64) -> Start {
        let velocity = speed_at_start(reference, period_s);
        let first = reference.first().copied().unwrap_or(0.0);
        let behind = if velocity == 0.0 { self.start_error_mm } else { velocity * self.lag_s() };
        Start { position_mm: first - behind, velocity_mm_s: velocity, held: true }
    }
}

/// As [`simulate`], with the friction.
#[must_use]
pub fn simulate_with_friction(servo: &Servo, reference: &[f64], period_s: f64, start: impl Into<Start>) -> Simulated {
    let mut out = Simulated { positions: Vec::with_capacity(reference.len()), friction_mm: Vec::with_capacity(reference.len()) };
    let see = |axis: &Axis<1>| {
        out.positions.push(axis.logged().0[0]);
        out.friction_mm.push(axis.friction().0[0] / servo.stiffness_1_s2());
    };
    // Vectors have nothing to hold here.
    Together { servos: &[*servo], reference, period_s, starts: [start.into()], see }.run();
    out
}

/// As [`simulate`], for several models of one structure at once.
pub(crate) fn simulate_together<const L: usize>(
    servos: &[Servo; L],
    reference: &[f64],
    period_s: f64,
    starts: [Start; L],
) -> [Vec<f64>; L] {
    let mut out = std::array::from_fn(|_| Vec::with_capacity(reference.len()));
    let see = |axis: &Axis<L>| {
        for (positions, position) in out.iter_mut().zip(axis.logged().0) {
            positions.push(position);
        }
    };
    Arch::new().dispatch(Together { servos, reference, period_s, starts, see });
    out
}

/// Models of one structure on a command, with what looks at their state at every sample.
struct Together<'a, const L: usize, F> {
    servos: &'a [Servo; L],
    reference: &'a [f64],
    period_s: f64,
    starts: [Start; L],
    see: F,
}

impl<const L: usize, F: FnMut(&Axis<L>)> WithSimd for Together<'_, L, F> {
    type Output = ();

    /// Plain code, which the compiler turns into the processor's widest vectors. Every term is rounded on its own: the same bits at every width.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.run();
    }
}

impl<const L: usize, F: FnMut(&Axis<L>)> Together<'_, L, F> {
    #[inline(always)]
    fn run(self) {
        let Self { servos, reference, period_s, starts, mut see } = self;
        if reference.is_empty() {
            return;
        }
        let steps = (period_s / STEP_S).ceil().max(1.0) as usize;
        let step_s = period_s / steps as f64;
        let commands = Commands::of(servos, reference, period_s);
        let mut here = commands.position(0.0);
        let mut axis = Axis::at(servos, step_s, steps, here, starts);
        let approach = |servo: &Servo| if servo.command_lag_s > 0.0 { 1.0 - (-step_s / servo.command_lag_s).exp() } else { 1.0 };
        let approach = Lanes::each(servos, approach);
        here = here - Lanes::of(|lane| starts[lane].velocity_mm_s * servos[lane].command_lag_s);
        for k in 0..reference.len() {
            see(&axis);
            axis.take_level();
            for i in 1..=steps {
                let given = commands.position(k as f64 + i as f64 / steps as f64);
                let next = here + approach * (given - here);
                axis.step(here, (next - here) * step_s.recip());
                here = next;
            }
        }
    }
}

/// The commands of several models on one reference; those with the same delay and average share one.
struct Commands<'a, const L: usize> {
    distinct: Vec<Command<'a>>,
    of_lane: [usize; L],
}

impl<'a, const L: usize> Commands<'a, L> {
    fn of(servos: &[Servo; L], reference: &'a [f64], period_s: f64) -> Self {
        let times = servos.map(|servo| (servo.channel_delay_s, servo.command_average_s));
        let mut seen: Vec<(f64, f64)> = Vec::new();
        let of_lane = times.map(|times| {
            seen.iter().position(|known| *known == times).unwrap_or_else(|| {
                seen.push(times);
                seen.len() - 1
            })
        });
        let command = |(delay_s, average_s): (f64, f64)| Command::new(reference, delay_s / period_s, average_s / period_s);
        Self { distinct: seen.into_iter().map(command).collect(), of_lane }
    }

    /// Positions at `time`, sample periods.
    #[inline(always)]
    fn position(&self, time: f64) -> Lanes<L> {
        if let [command] = &self.distinct[..] {
            return Lanes::all(command.position(time));
        }
        let mut positions = [0.0; L];
        for (position, command) in positions.iter_mut().zip(&self.distinct) {
            *position = command.position(time);
        }
        Lanes::of(|lane| positions[self.of_lane[lane]])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scales::index;

    const PERIOD_S: f64 = 0.002;

    fn error_at_the_end(servo: &Servo, speed: f64) -> f64 {
        let ramp: Vec<f64> = (0..1500).map(|k| speed * PERIOD_S * f64::from(k)).collect();
        let actual = simulate(servo, &ramp, PERIOD_S, (0.0, 0.0));
        ramp[1499] - actual[1499]
    }

    #[test]
    fn a_ramp_lags_by_the_stated_time() {
        let cascade = Servo { coulomb_mm: 0.0, ..Servo::usual(50.0, 0.6) };
        for servo in [
            cascade,
            Servo { integral: 0.0, viscous: 0.05, ..cascade },
            Servo { channel_delay_s: 0.0031, command_average_s: 0.012, ..cascade },
            Servo { loop_delay_s: 0.0023, ..cascade },
        ] {
            let error = error_at_the_end(&servo, 40.0);
            assert!((error - 40.0 * servo.lag_s()).abs() < 1e-4, "{error} {servo:?}");
        }
    }

    #[test]
    fn friction_deflects_a_loop_without_integrator_by_its_own_measure() {
        let servo = Servo { integral: 0.0, coulomb_mm: 7e-3, ..Servo::usual(60.0, 1.0) };
        for sign in [1.0, -1.0] {
            let error = error_at_the_end(&servo, sign * 30.0);
            assert!((sign * error - 7e-3).abs() < 1e-5, "{error}");
        }
        let asymmetric = Servo { asymmetry: 0.1, ..servo };
        assert!((error_at_the_end(&asymmetric, 30.0) - 7.7e-3).abs() < 1e-5);
        assert!((error_at_the_end(&asymmetric, -30.0) + 6.3e-3).abs() < 1e-5);
    }

    #[test]
    fn the_table_stands_while_the_motor_crosses_the_backlash() {
        let servo = Servo { backlash_mm: 0.02, table_pulsation_1_s: 1500.0, coulomb_mm: 0.0, ..Servo::usual(60.0, 1.0) };
        let wave: Vec<f64> = (0..2000).map(|k| 5.0 - 5.0 * (3.0 * PERIOD_S * f64::from(k)).cos()).collect();
        let swing = |servo: &Servo| {
            let actual = simulate(servo, &wave, PERIOD_S, (0.0, 0.0));
            wave.iter().zip(&actual).skip(500).map(|(r, x)| (r - x).abs()).fold(0.0, f64::max)
        };
        // Crossed within a few milliseconds near standstill: the error is most of the width, then decays by K_v.
        let (with, without) = (swing(&servo), swing(&Servo { backlash_mm: 0.0, ..servo }));
        assert!(with - without > 0.006 && with < 0.03, "{with} {without}");
    }

    #[test]
    fn models_together_move_as_each_alone_to_the_last_bit() {
        let lugre = Servo { creep_mm_s: 0.01, contact_damping: 0.3, asymmetry: 0.1, offset_mm: 2e-3, ..Servo::usual(60.0, 0.8) };
        let smoothed = Servo { channel_delay_s: 0.0013, command_average_s: 0.006, command_lag_s: 0.002, ..lugre };
        let seen = Servo { table_pulsation_1_s: 700.0, backlash_mm: 0.01, viscous: 0.02, table_viscous: 0.4, ..lugre };
        let outer = Servo { backlash_mm: 0.0, outer_backlash_mm: 0.01, ..seen };
        let slips = Servo { slips: true, ..Servo { hides_table: true, ..seen }.with_places(-6.0, 6.0) };
        let wave: Vec<f64> = (0..700).map(|k| 5.0 * (4.0 * PERIOD_S * f64::from(k)).sin().powi(3)).collect();
        for servo in [lugre, smoothed, seen, outer, slips] {
            let parameters = [index::GAIN, index::LOOP_DELAY, index::AVERAGE, index::SHARES.start, index::LEVELS.start + 9];
            let servos = parameters.map(|parameter| servo.moved(parameter, 3e-3));
            let starts = servos.map(|servo| servo.start(&wave, PERIOD_S));
            for (servo, moved) in servos.iter().zip(simulate_together(&servos, &wave, PERIOD_S, starts)) {
                assert_eq!(servo.follow(&wave, PERIOD_S), moved);
            }
        }
    }
}
