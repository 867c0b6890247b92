//! What a control is to command for another version of a program of which it ran one: its own command, plus the difference of the plans.

use motion::contour::follow_axes;
use motion::{MotionError, Trajectory, cubic};

use crate::error::Result;
use crate::part::{Part, Recording, TAPER_S};
use crate::path_time::{Stop, instants, linear};

/// Least advance of the run by a sample of the recorded one, samples: where the plan slowed down and the control did not, a faster plan saves nothing.
const LEAST_STEP: f64 = 0.8;

/// Command for `version` by a control that commanded `recorded` for the program, and the position of every of its samples in the recorded
/// run, as a sample index with fraction.
///
/// At every place of the path the command differs from the recorded one as the plan of `version` from that of the program, and so does the time at
/// which it is there; differences of time are averaged over [`TAPER_S`], for the two plans and the run need not slow down at the same micrometre.
/// Next to a corner it differs by `shifts`, those of the correction, one column an axis: plan and control may round a corner otherwise, and a shifted
/// one is rounded as the recorded one.
///
/// # Errors
/// When the version leaves the path.
pub(super) fn rerun(
    recorded: &Trajectory,
    recording: &Recording,
    version: &Part,
    shifts: &[Vec<f64>],
) -> Result<(Trajectory, Vec<f64>)> {
    let plan = &recording.plan.desired;
    let follows = follow_axes(version.plan.desired.trajectory(), plan)?;
    // For every sample of the plan the instant at which the version is there, in samples.
    let passes = instants(plan.trajectory(), &follows, Stop::Passed);
    let there: Vec<f64> = recording.path_positions.iter().map(|at| linear(&passes, *at)).collect();
    let later = there.iter().zip(&recording.path_positions).map(|(there, at)| there - at).collect();
    let times = increasing(&averaged(later, TAPER_S / recorded.period_s()));
    let commands = version.command.as_ref().unwrap_or(version.plan.desired.trajectory());
    let axes = recorded.columns().iter().zip(shifts).zip(recording.command().columns().iter().zip(commands.columns()));
    let shifted = axes.map(|((run, shifts), (planned, commanded))| {
        let places = there.iter().zip(&recording.path_positions);
        let of_plans = places.map(|(there, at)| cubic(commanded, *there).0 - cubic(planned, *at).0);
        let of_both = of_plans.zip(shifts).zip(&recording.away).map(|((of_plan, shift), away)| shift + away * (of_plan - shift));
        run.iter().zip(of_both).map(|(at, shift)| at + shift).collect::<Vec<f64>>()
    });
    in_new_time(recorded, shifted.collect(), &times).map_err(Into::into)
}

/// Instant of every sample of the recorded run, in samples, where it is there `later`.
fn increasing(later: &[f64]) -> Vec<f64> {
    let mut last = -LEAST_STEP;
    let mut times = Vec::with_capacity(later.len());
    for (sample, later) in later.iter().enumerate() {
        last = (sample as f64 + later).max(last + LEAST_STEP);
        times.push(last);
    }
    times
}

/// Moving average over `samples`, shorter at the ends.
fn averaged(values: Vec<f64>, samples: f64) -> Vec<f64> {
    let half = (samples / 2.0).round() as usize;
    let sums: Vec<f64> = std::iter::once(0.0)
        .chain(values.iter().scan(0.0, |sum, value| {
            *sum += value;
            Some(*sum)
        }))
        .collect();
    let mean = |sample: usize| {
        let half = half.min(sample).min(values.len() - 1 - sample);
        (sums[sample + half + 1] - sums[sample - half]) / (2 * half + 1) as f64
    };
    (0..values.len()).map(mean).collect()
}

/// `columns` at the samples of `recorded`, which pass at `times`, at whole samples of time; with the position of each.
fn in_new_time(recorded: &Trajectory, columns: Vec<Vec<f64>>, times: &[f64]) -> Result<(Trajectory, Vec<f64>), MotionError> {
    let count = times.last().map_or(0, |last| last.ceil() as usize + 1);
    let mut before = 0;
    let mut position = |time: f64| {
        while before + 1 < times.len() && times[before + 1] <= time {
            before += 1;
        }
        let next = times.get(before + 1).copied().unwrap_or(f64::INFINITY);
        before as f64 + ((time - times[before]) / (next - times[before])).clamp(0.0, 1.0)
    };
    let positions: Vec<f64> = (0..count).map(|sample| position(sample as f64)).collect();
    let columns = columns.iter().map(|column| positions.iter().map(|at| cubic(column, *at).0).collect());
    Ok((Trajectory::new(recorded.period_s(), recorded.axes().to_vec(), columns.collect())?, positions))
}

#[cfg(test)]
mod tests {
    use machine::MachineSpec;

    use super::*;
    use crate::part::WorkOffsets;
    use crate::setup::Setup;

    const PART: &str = "G21 G90\nG1 X10. Y0. F1200\nG1 X40. Y0.\nG1 X40. Y20.\nM30\n";

    /// Planned on a machine with another acceleration.
    fn planned(text: &str, acceleration: f64) -> Part {
        let mut setup = Setup::new(&MachineSpec::builtin("ballscrew").unwrap(), None).unwrap();
        setup.limits.axes.iter_mut().for_each(|axis| axis.acceleration = acceleration);
        let (program, options) = (gcode::parse(text), gcode::Options::default());
        Part::planned("part.nc", program, options, &WorkOffsets::default().or_zero(), &setup, &setup.plan_settings()).unwrap()
    }

    /// The command of a slow control for [`PART`], and what it says beside the plan of a fast one.
    fn recorded() -> (Trajectory, Recording) {
        let (run, part) = (planned(PART, 150.0).plan.desired, planned(PART, 800.0));
        let path_positions = follow_axes(run.trajectory(), &part.plan.desired).unwrap();
        let away = vec![1.0; path_positions.len()];
        let recording = Recording { desired: run.clone(), plan: part.plan, command: None, away, path_positions };
        (run.trajectory().clone(), recording)
    }

    /// No shift of any axis.
    fn none(run: &Trajectory) -> Vec<Vec<f64>> {
        vec![vec![0.0; run.len()]; run.columns().len()]
    }

    #[test]
    fn the_same_program_is_commanded_as_recorded() {
        let (run, recording) = recorded();
        let (command, positions) = rerun(&run, &recording, &planned(PART, 800.0), &none(&run)).unwrap();
        assert_eq!(command.len(), run.len());
        assert!(positions.iter().enumerate().all(|(sample, at)| (at - sample as f64).abs() < 1e-6));
        for (column, wanted) in command.columns().iter().zip(run.columns()) {
            assert!(column.iter().zip(wanted).all(|(at, wanted)| (at - wanted).abs() < 1e-6));
        }
    }

    #[test]
    fn shifted_points_shift_the_recorded_command() {
        let (run, recording) = recorded();
        let shifted = PART.replace("X10. Y0. F1200\nG1 X40. Y0.", "X10. Y0.01 F1200\nG1 X40. Y0.01");
        let version = planned(&shifted, 800.0);
        let (command, _) = rerun(&run, &recording, &version, &none(&run)).unwrap();
        // The nearly straight corner at X10 is rounded over a long way.
        let at = |of: &Trajectory, x: f64| {
            let sample = of.columns()[0].iter().position(|at| *at >= x).unwrap();
            of.columns()[1][sample]
        };
        for x in [5.0, 10.0, 20.0, 30.0] {
            let wanted = at(version.plan.desired.trajectory(), x);
            assert!((at(&command, x) - wanted).abs() < 1e-4 && wanted > 4e-3, "{x}: {} for {wanted}", at(&command, x));
            assert!(at(&run, x).abs() < 1e-9);
        }
    }

    #[test]
    fn slower_lines_take_longer_by_the_difference_of_the_plans() {
        let (run, recording) = recorded();
        let slower = PART.replace("G1 X40. Y0.", "G1 X40. Y0. F600");
        let version = planned(&slower, 800.0);
        let later_s = version.plan.desired.trajectory().duration_s() - recording.plan.desired.trajectory().duration_s();
        let (command, _) = rerun(&run, &recording, &version, &none(&run)).unwrap();
        assert!(later_s > 1.0 && (command.duration_s() - run.duration_s() - later_s).abs() < 0.01, "{later_s}");
        let speeds = command.columns()[0].windows(2).map(|pair| (pair[1] - pair[0]).abs() / command.period_s());
        assert!(speeds.fold(0.0, f64::max) < 20.5);
    }

    #[test]
    fn next_to_a_corner_the_correction_counts() {
        let (run, mut recording) = recorded();
        recording.away.fill(0.0);
        let shifts: Vec<Vec<f64>> = run.columns().iter().map(|column| vec![0.01; column.len()]).collect();
        // The plan of the version would be half a millimetre off.
        let version = planned(&PART.replace("X40. Y0.", "X40. Y0.5"), 800.0);
        let (command, positions) = rerun(&run, &recording, &version, &shifts).unwrap();
        for (sample, at) in positions.iter().enumerate() {
            assert!((command.columns()[1][sample] - cubic(&run.columns()[1], *at).0 - 0.01).abs() < 1e-6);
        }
    }
}
