//! Positions of rotary axes that begin anew at every turn.

use std::f64::consts::{PI, TAU};

use motion::{Axis, AxisKind};

use crate::{Check, Finding, Severity};

/// Range of a column that begins anew at every turn, turns: a rounded last digit beyond one.
const ONE_TURN: f64 = 1.001;

/// Whether a rotary position steps by more than half a turn from one row to the next.
pub(crate) fn steps_by_a_turn(axis: &Axis, before: f64, after: f64) -> bool {
    axis.kind == AxisKind::Rotary && (after - before).abs() > PI
}

/// Lets positions of rotary axes go on beyond a turn, rad, where they begin anew at every one. `columns` are the commands of the axes, then
/// their actual positions, which get the turns of the command, or commands only.
pub(crate) fn go_on(axes: &[Axis], columns: &mut [Vec<f64>]) -> Option<Finding> {
    let mut names = Vec::new();
    for (index, axis) in axes.iter().enumerate() {
        let slots: Vec<usize> = (index..columns.len()).step_by(axes.len()).collect();
        let turned = slots.iter().filter(|slot| turn_on(axis, &mut columns[**slot])).count();
        if turned == 0 {
            continue;
        }
        names.push(axis.name.as_str());
        if let [command, actual] = slots[..] {
            let apart = columns[command].iter().zip(&columns[actual]).map(|(command, actual)| command - actual);
            let turns = apart.clone().find(|apart| apart.is_finite()).map_or(0.0, |apart| (apart / TAU).round());
            columns[actual].iter_mut().for_each(|value| *value += turns * TAU);
        }
    }
    (!names.is_empty()).then(|| {
        let message = format!("the positions of {} begin anew at every turn and were taken as going on", names.join(", "));
        Finding::new(Severity::Note, Check::Mended, message)
    })
}

/// Adds the turns of one column; whether there are any.
fn turn_on(axis: &Axis, column: &mut [f64]) -> bool {
    let (low, high) =
        column.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)));
    let turns = column.windows(2).any(|pair| steps_by_a_turn(axis, pair[0], pair[1]));
    if !turns || high - low > ONE_TURN * TAU {
        return false;
    }
    let (mut before, mut ahead) = (column[0], 0.0);
    for value in column {
        let step = *value - before;
        if step.abs() > PI {
            ahead -= (step / TAU).round() * TAU;
        }
        before = *value;
        *value += ahead;
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_go_on_in_both_directions_and_the_actual_position_follows_its_command() {
        let axes = ["x", "c"].map(Axis::named);
        let angle: Vec<f64> = (0..400).map(|k| 8.0 * (f64::from(k) * 0.02).sin()).collect();
        let late: Vec<f64> = angle.iter().map(|angle| angle - 0.05).collect();
        let wrapped = |angle: &[f64]| angle.iter().map(|angle| angle.rem_euclid(TAU)).collect::<Vec<_>>();
        let x: Vec<f64> = angle.iter().map(|angle| if *angle > 0.0 { 5.0 } else { 0.0 }).collect();
        let mut columns = vec![x.clone(), wrapped(&angle), x.clone(), wrapped(&late)];
        let found = go_on(&axes, &mut columns).unwrap();
        assert!(found.message.contains(" c "), "{}", found.message);
        assert!(columns[1].iter().zip(&angle).all(|(found, angle)| (found - angle).abs() < 1e-9));
        assert!(columns[3].iter().zip(&late).all(|(found, angle)| (found - angle).abs() < 1e-9));
        assert_eq!(columns[0], x);
        // Positions beyond a turn do not begin anew, whatever they step by.
        let mut steps = vec![vec![0.0, 4.0, 8.0], vec![0.0, 4.0, 8.0]];
        assert!(go_on(&axes, &mut steps).is_none());
    }
}
