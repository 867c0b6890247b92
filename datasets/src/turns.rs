//! Positions of rotary axes that begin anew at every turn.

use std::borrow::Cow;
use std::f64::consts::{PI, TAU};

use motion::{Axis, AxisKind};

use crate::columns::{ColumnMap, Side};
use crate::{Check, Finding, Severity, Source, Table};

/// Range of a column that begins anew at every turn, turns: a rounded last digit beyond one.
const ONE_TURN: f64 = 1.001;

/// Whether a rotary position steps by more than half a turn from one row to the next.
pub(crate) fn steps_by_a_turn(axis: &Axis, before: f64, after: f64) -> bool {
    axis.kind == AxisKind::Rotary && (after - before).abs() > PI
}

/// Lets the positions of rotary axes go on beyond a turn where they begin anew at every one. Actual positions get the turns of their command,
/// tracking errors stay within half a turn.
pub(crate) fn in_table<'a>(mut table: Cow<'a, Table>, map: &ColumnMap) -> (Cow<'a, Table>, Option<Finding>) {
    let mut names = Vec::new();
    for columns in map.axes.iter().filter(|columns| columns.axis.kind == AxisKind::Rotary) {
        let sources = [(columns.reference, Side::Reference), (columns.actual, Side::Actual)];
        let (error, positions): (Vec<_>, Vec<_>) = sources.into_iter().partition(|(_, side)| columns.error_for == Some(*side));
        let values = |source: Source| table.columns.get(source.column).map_or(Vec::new(), |column| scaled(column, source.scale));
        let mut all: Vec<Vec<f64>> = positions.iter().map(|(source, _)| values(*source)).collect();
        if !turn_all(&columns.axis, &mut all) {
            continue;
        }
        names.push(columns.axis.name.as_str());
        let within = |value: f64| value - (value / TAU).round() * TAU;
        let errors = error.iter().map(|(source, _)| values(*source).into_iter().map(within).collect());
        let turned: Vec<Vec<f64>> = all.into_iter().chain(errors).collect();
        for ((source, _), values) in positions.iter().chain(&error).zip(turned) {
            table.to_mut().columns[source.column] = scaled(&values, 1.0 / source.scale);
        }
    }
    let finding = finding(&names);
    (table, finding)
}

/// The same for the columns of a commanded path, rad.
pub(crate) fn go_on(axes: &[Axis], columns: &mut [Vec<f64>]) -> Option<Finding> {
    let turned = axes.iter().zip(columns).filter_map(|(axis, column)| turn_on(axis, column).then_some(axis.name.as_str()));
    finding(&turned.collect::<Vec<_>>())
}

fn scaled(column: &[f64], scale: f64) -> Vec<f64> {
    column.iter().map(|value| value * scale).collect()
}

fn finding(names: &[&str]) -> Option<Finding> {
    (!names.is_empty()).then(|| {
        let message = format!("the positions of {} begin anew at every turn and were taken as going on", names.join(", "));
        Finding::new(Severity::Note, Check::Mended, message)
    })
}

/// Adds the turns of the columns of one axis; whether there are any. The second one gets those of the first.
fn turn_all(axis: &Axis, columns: &mut [Vec<f64>]) -> bool {
    let turned = columns.iter_mut().filter_map(|column| turn_on(axis, column).then_some(())).count();
    if let [command, actual] = columns {
        let mut apart = command.iter().zip(actual.iter()).map(|(command, actual)| command - actual);
        let turns = apart.find(|apart| apart.is_finite()).map_or(0.0, |apart| (apart / TAU).round());
        if turned > 0 {
            actual.iter_mut().for_each(|value| *value += turns * TAU);
        }
    }
    turned > 0
}

/// Adds the turns of one column; whether there are any. Rows without a value are passed over.
fn turn_on(axis: &Axis, column: &mut [f64]) -> bool {
    let values = || column.iter().copied().filter(|value| !value.is_nan());
    let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    let turns = values().zip(values().skip(1)).any(|(before, after)| steps_by_a_turn(axis, before, after));
    if !turns || high - low > ONE_TURN * TAU {
        return false;
    }
    let (mut before, mut ahead) = (f64::NAN, 0.0);
    for value in column.iter_mut().filter(|value| !value.is_nan()) {
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
        let angle: Vec<f64> = (0..400).map(|k| 8.0 * (f64::from(k) * 0.02).sin()).collect();
        let late: Vec<f64> = angle.iter().map(|angle| angle - 0.05).collect();
        let wrapped = |angle: &[f64]| angle.iter().map(|angle| angle.to_degrees().rem_euclid(360.0)).collect::<Vec<_>>();
        let x: Vec<f64> = angle.iter().map(|angle| if *angle > 0.0 { 5.0 } else { 0.0 }).collect();
        let error: Vec<f64> = wrapped(&angle).iter().zip(wrapped(&late)).map(|(a, b)| a - b).collect();
        for (last, values, is_error) in [("c_act_deg", wrapped(&late), false), ("c_err_deg", error, true)] {
            let names = ["x_ref", "x_act", "c_ref_deg", last].map(str::to_owned).to_vec();
            let mut given = Table { names, columns: vec![x.clone(), x.clone(), wrapped(&angle), values], ..Table::default() };
            // Other channels leave rows without a value.
            given.columns[3][7] = f64::NAN;
            let map = ColumnMap::recognise(std::path::Path::new("log.csv"), &given).unwrap();
            let (table, found) = in_table(Cow::Borrowed(&given), &map);
            assert!(found.unwrap().message.contains(" c "));
            let near = |found: &[f64], wanted: &[f64]| {
                found.iter().zip(wanted).all(|(found, angle)| found.is_nan() || (found.to_radians() - angle).abs() < 1e-9)
            };
            let apart: Vec<f64> = vec![0.05; 400];
            assert!(near(&table.columns[2], &angle) && near(&table.columns[3], if is_error { &apart } else { &late }), "{last}");
            assert_eq!(table.columns[0], x);
        }
        // Positions beyond a turn do not begin anew, whatever they step by.
        assert!(!turn_on(&Axis::named("c"), &mut [0.0, 4.0, 8.0]));
    }
}
