//! First values of a control, from what the recorded commands show without any plan: a search that begins far away ends far away.

use datasets::Log;
use machine::MachineSpec;
use motion::{AxisKind, AxisLimits};

use super::observed::{Observed, Passage};
use super::structure::FirstCorners;
use crate::training::limits_of_logs;

/// A command that is further from a corner does not round it, mm.
const FAR_MM: f64 = 1.0;
/// Turns from which on a corner is a reversal, rad.
const REVERSAL_RAD: f64 = 2.9;
/// Share of its largest speed that a rapid keeps over so many spans of 10 ms where that is the limit. Where it is not, the speed of an axis at 100 mm/s with
/// a jerk of 800 mm/s³ stays within this share of its peak for 70 ms; a log in whole micrometres shows 30 mm/s within it.
const KEPT_SHARE: f64 = 0.995;
const KEPT_SPANS: usize = 12;
/// Share of the corners at which the control keeps what is taken for its limit: others may be misread.
const MOST_CORNERS: f64 = 0.9;

/// First values of every rule of corners: what the command keeps at nearly all of them. `machine` gives the acceleration along the path.
pub(super) fn first_corners(machine: &MachineSpec, observed: &[Observed]) -> FirstCorners {
    let most = |of: &dyn Fn(&Passage) -> f64| {
        let corners = observed.iter().flat_map(Observed::corners).filter(|corner| corner.rounded_mm < FAR_MM);
        let mut values: Vec<f64> = corners.map(of).filter(|value| value.is_finite()).collect();
        motion::quantile(&mut values, MOST_CORNERS).filter(|value| *value > 0.0)
    };
    let deviation_mm = |corner: &Passage| {
        let cos = (0.5 * corner.turn_rad).cos();
        // At a reversal no deviation lets it pass.
        let is_reversal = corner.turn_rad > REVERSAL_RAD;
        if is_reversal { f64::NAN } else { corner.speed_mm_s.powi(2) * (1.0 - cos) / (machine.path.acceleration_mm_s2 * cos) }
    };
    let others = FirstCorners::default();
    FirstCorners {
        blend_mm: most(&|corner| corner.rounded_mm).unwrap_or(others.blend_mm),
        jump_mm_s: most(&|corner| corner.speed_mm_s * corner.change).unwrap_or(others.jump_mm_s),
        deviation_mm: most(&deviation_mm).unwrap_or(others.deviation_mm),
    }
}

/// The machine with the limits and the jerk that the logs reach. A speed is limited at what the logs reach only where a rapid keeps it; else a
/// higher one of `machine` stands: its rapids were too short, or there were none.
pub(super) fn first_limits(machine: &MachineSpec, logs: &[&Log], observed: &[Observed]) -> MachineSpec {
    let Ok(reached) = limits_of_logs(logs) else { return machine.clone() };
    let kept = kept_speeds(machine, observed);
    let speed = |limit: usize, given: f64, reached: f64| if kept[limit] { reached } else { reached.max(given) };
    let given_mm_s = machine.path.velocity_mm_s;
    let mut machine = machine.clone();
    for (index, axis) in machine.axes.iter_mut().enumerate() {
        let Some(of_logs) = reached.axes.iter().find(|other| other.name() == axis.name()) else { continue };
        let limits = of_logs.limits();
        let velocity = speed(index, axis.limits().velocity, limits.velocity);
        axis.set_limits(AxisLimits { velocity, ..limits });
    }
    machine.path.velocity_mm_s = speed(machine.axes.len(), given_mm_s, reached.path.velocity_mm_s);
    machine.path.acceleration_mm_s2 = reached.path.acceleration_mm_s2;
    machine.path.centripetal_mm_s2 = reached.path.acceleration_mm_s2;
    machine.path.jerk_mm_s3 = reached.path.jerk_mm_s3;
    machine
}

/// Whether rapids keep the largest speed that they reach, of every axis and then of the path: it is the limit there, by the proportions of
/// the limits of `machine`.
fn kept_speeds(machine: &MachineSpec, observed: &[Observed]) -> Vec<bool> {
    let limits: Vec<f64> = machine.axes.iter().map(|axis| axis.limits().velocity).chain([machine.path.velocity_mm_s]).collect();
    let is_linear: Vec<bool> = machine.axes.iter().map(|axis| axis.axis().kind == AxisKind::Linear).collect();
    let with_path = |speeds: &Vec<f64>| {
        let linear = speeds.iter().zip(&is_linear).filter(|(_, linear)| **linear);
        let path = linear.map(|(speed, _)| speed * speed).sum::<f64>().sqrt();
        speeds.iter().copied().chain([path]).collect::<Vec<f64>>()
    };
    let spans: Vec<Option<Vec<f64>>> =
        observed.iter().flat_map(|run| run.rapids().iter().map(|span| span.as_ref().map(with_path)).chain([None])).collect();
    let is_kept = |limit: usize| {
        let top = spans.iter().flatten().map(|speeds| speeds[limit]).fold(0.0, f64::max);
        let holds = |speeds: &Vec<f64>| {
            let share = speeds[limit] / limits[limit];
            speeds[limit] >= KEPT_SHARE * top
                && speeds.iter().zip(&limits).all(|(speed, most)| speed / most <= share * (1.0 + 1e-9))
        };
        top > 0.0 && spans.windows(KEPT_SPANS).any(|spans| spans.iter().all(|span| span.as_ref().is_some_and(holds)))
    };
    (0..limits.len()).map(is_kept).collect()
}

#[cfg(test)]
mod tests {
    use machine::MachineSpec;

    use super::first_limits;
    use crate::identification::{KnownRun, observe};
    use crate::input::Input;
    use crate::part::{Part, ReadSettings};
    use crate::setup::Setup;

    /// The axes' and the path's speed that a control test of rapids of this length shows, with a machine file of twice the speeds.
    fn speeds(length_mm: f64) -> (Vec<f64>, f64) {
        let machine = MachineSpec::builtin("ballscrew").unwrap();
        let program: String =
            ["X", "Y", "Z"].map(|axis| format!("G0 {axis}{length_mm}\nG4 P0.1\nG0 {axis}0\nG4 P0.1\n")).concat();
        let program = format!("G21 G90 G94\nG0 X0 Y0 Z0\nG4 P0.1\n{program}G1 X1 F600\nM30\n");
        let setup = Setup::new(&machine, None).unwrap();
        let settings = ReadSettings { at_zero: true, ..Default::default() };
        let command = Input::from(Part::read("rapids.nc", program.clone(), &setup, &settings).unwrap()).command().clone();
        let log = datasets::Log::new("rapids", command.clone(), command).unwrap();
        let mut guess = machine;
        guess.path.velocity_mm_s *= 2.0;
        for axis in &mut guess.axes {
            let limits = axis.limits();
            axis.set_limits(motion::AxisLimits { velocity: 2.0 * limits.velocity, ..limits });
        }
        let observed =
            observe(&[KnownRun { name: "rapids.nc".into(), program: program.into_bytes(), log: &log }], &guess).unwrap();
        let found = first_limits(&guess, &[&log], &observed);
        (found.axes.iter().map(|axis| axis.limits().velocity).collect(), found.path.velocity_mm_s)
    }

    #[test]
    fn a_speed_is_a_limit_where_a_rapid_keeps_it() {
        let true_mm_s: Vec<f64> =
            MachineSpec::builtin("ballscrew").unwrap().axes.iter().map(|axis| axis.limits().velocity).collect();
        let (long, _) = speeds(100.0);
        for (found, expected) in long.iter().zip(&true_mm_s) {
            assert!((found / expected - 1.0).abs() < 0.01, "{long:?} for {true_mm_s:?}");
        }
        // Too short for the speed: that of the machine file stands.
        let (short, _) = speeds(3.0);
        for (found, expected) in short.iter().zip(&true_mm_s) {
            assert_eq!(*found, 2.0 * expected, "{short:?}");
        }
    }
}
