//! Values that no motion explains: marks of a logger for "no value", bits that were lost on the way.

use std::borrow::Cow;
use std::f64::consts::TAU;

use motion::{Axis, AxisKind};

use crate::columns::ColumnMap;
use crate::{Check, Finding, Severity, Table};

/// Longest spike, rows.
const LONGEST: usize = 3;
/// Least distance of a spike from the line between its neighbours, mm or rad.
const LEAST: (f64, f64) = (1.0, 0.02);
/// The same as a multiple of what the two rows on either side lie off one line.
const STANDS_OUT: f64 = 50.0;
/// Distance from whole turns, rad, within which a rotary position begins anew instead.
const TURNED: f64 = 0.1;
/// Share of the rows of a column above which they are no spikes.
const MOST: f64 = 0.05;

/// Finds the spikes of a column as its values (mm or rad) come.
#[derive(Debug, Clone)]
pub(crate) struct Spikes {
    kind: AxisKind,
    /// The last values, the newest first.
    last: [f64; LONGEST + 4],
}

impl Spikes {
    pub fn new(axis: &Axis) -> Self {
        Self { kind: axis.kind, last: [f64::NAN; LONGEST + 4] }
    }

    /// Takes the next value. The length of the spike that ended two rows before it, and its distance from the line between its neighbours;
    /// rows on both sides are needed to tell.
    pub fn note(&mut self, value: f64) -> Option<(usize, f64)> {
        self.last.rotate_right(1);
        self.last[0] = value;
        (1..=LONGEST).find_map(|rows| Some((rows, self.distance(rows)?)))
    }

    fn distance(&self, rows: usize) -> Option<f64> {
        let [d, c, b, a] = [self.last[0], self.last[1], self.last[rows + 2], self.last[rows + 3]];
        let spike = &self.last[2..rows + 2];
        let least = if self.kind == AxisKind::Linear { LEAST.0 } else { LEAST.1 };
        let count = rows as f64 + 1.0;
        let line = |row: usize| c + (b - c) * (row as f64 + 1.0) / count;
        let near = spike.iter().enumerate().map(|(row, value)| (value - line(row)).abs()).fold(f64::INFINITY, f64::min);
        if !(near > least && self.last[..rows + 4].iter().all(|value| value.is_finite())) {
            return None;
        }
        if self.kind == AxisKind::Rotary && (near / TAU - (near / TAU).round()).abs() * TAU < TURNED {
            return None;
        }
        // The step over the spike, a row, and those on either side of it.
        let step = (c - b) / count;
        let off = count * (step - (b - a)).abs().max((step - (d - c)).abs());
        (near > STANDS_OUT * off).then_some(near)
    }
}

/// Rows of a column that are spikes, with their distances from the line between their neighbours, mm or rad.
fn rows(column: &[f64], scale: f64, axis: &Axis) -> Vec<(usize, f64)> {
    let mut spikes = Spikes::new(axis);
    // Rows without a value are those of other channels.
    let with: Vec<usize> = (0..column.len()).filter(|row| !column[*row].is_nan()).collect();
    let ends = with.iter().enumerate().filter_map(|(at, row)| Some((at, spikes.note(column[*row] * scale)?)));
    let rows = |(at, (length, distance)): (usize, (usize, f64))| {
        with[at - 1 - length..at - 1].iter().map(move |row| (*row, distance)).collect::<Vec<_>>()
    };
    ends.flat_map(rows).collect()
}

/// Whether a value lies among the others of its column, where a motion may have gone.
fn is_among(column: &[f64], spikes: &[(usize, f64)], row: usize) -> bool {
    let mut next = spikes.iter().map(|(row, _)| *row).peekable();
    let others = column.iter().enumerate().filter(|(row, _)| next.next_if_eq(row).is_none()).map(|(_, value)| *value);
    let (low, high) = others.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    (low..=high).contains(&column[row])
}

/// The table with spikes of the positions as missing values, and findings. Where command and actual position go the same way in a row, within the
/// range of the axis, that is a motion.
pub(crate) fn without<'a>(table: &'a Table, map: &ColumnMap) -> (Cow<'a, Table>, Vec<Finding>) {
    let (mut out, mut findings) = (Cow::Borrowed(table), Vec::new());
    for columns in &map.axes {
        let sources = [columns.reference, columns.actual];
        let column = |side: usize| table.columns.get(sources[side].column).map_or(&[][..], Vec::as_slice);
        let found = [0, 1].map(|side| rows(column(side), sources[side].scale, &columns.axis));
        for (side, source) in sources.into_iter().enumerate() {
            let is_moved = |(row, _): &(usize, f64)| {
                found[1 - side].iter().any(|(other, _)| other == row) && is_among(column(side), &found[side], *row)
            };
            let spikes: Vec<(usize, f64)> = found[side].iter().filter(|spike| !is_moved(spike)).copied().collect();
            let few = spikes.len() as f64 <= MOST * column(side).len() as f64;
            let Some((first, _)) = spikes.first().filter(|_| few) else { continue };
            let most = spikes.iter().map(|(_, distance)| *distance).fold(0.0, f64::max);
            let (name, unit) = (&table.names[source.column], columns.axis.kind.unit());
            let values = if spikes.len() == 1 { "a value stands".to_owned() } else { format!("{} values stand", spikes.len()) };
            let most = if most < 1e6 { format!("{most:.4}") } else { format!("{most:.3e}") };
            let line = table.lines.get(*first).copied().unwrap_or(first + 1);
            let message = format!(
                "`{name}`: {values} out of the motion before and after by up to {most} {unit}, first in line {line}: marks of missing values or \
                 transmission faults, which count as missing"
            );
            findings.push(Finding::new(Severity::Warn, Check::Mended, message));
            let column = &mut out.to_mut().columns[source.column];
            spikes.iter().for_each(|(row, _)| column[*row] = f64::NAN);
        }
    }
    (out, findings)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(axis: &str, values: &[f64]) -> Vec<usize> {
        rows(values, 1.0, &Axis::named(axis)).into_iter().map(|(row, _)| row).collect()
    }

    #[test]
    fn what_both_positions_do_within_their_range_is_a_motion() {
        let motion: Vec<f64> = (0..400).map(|k| 30.0 * (0.02 * f64::from(k)).sin()).collect();
        let with = |value: f64, also: bool| {
            let (mut command, mut actual) = (motion.clone(), motion.clone());
            actual[150] = value;
            command[150] = if also { value } else { motion[150] };
            let table = Table {
                names: ["x_ref", "x_act"].map(str::to_owned).to_vec(),
                columns: vec![command, actual],
                ..Table::default()
            };
            let map = ColumnMap::recognise(std::path::Path::new("log.csv"), &table).unwrap();
            let (table, findings) = without(&table, &map);
            (table.columns.iter().map(|column| column[150].is_nan()).collect::<Vec<_>>(), findings.len())
        };
        assert_eq!(with(-20.0, true), (vec![false, false], 0));
        assert_eq!(with(-20.0, false), (vec![false, true], 1));
        assert_eq!(with(-9999.0, true), (vec![true, true], 2));
    }

    #[test]
    fn spikes_of_up_to_three_rows_are_found_and_motion_is_not() {
        let motion: Vec<f64> = (0..400).map(|k| 30.0 * (0.02 * f64::from(k)).sin() + 1e-3 * f64::from(k * 7919 % 13)).collect();
        assert!(found("x", &motion).is_empty());
        for (rows, value) in [(1, -9999.0), (2, 0.0), (3, 3.4e38), (1, motion[200] + 1.5)] {
            let mut column = motion.clone();
            column[200..200 + rows].fill(value);
            assert_eq!(found("x", &column), (200..200 + rows).collect::<Vec<_>>(), "{rows} {value}");
        }
        // Steps, jumps of speed and single pulses of a few tenths of a millimetre are for the checks.
        let step: Vec<f64> = (0..100).map(|k| if k < 50 { 0.0 } else { 40.0 }).collect();
        let corner: Vec<f64> = (0..100_i32).map(|k| 2.0 * f64::from((k - 50).abs())).collect();
        let mut pulse = vec![0.0; 100];
        pulse[40] = 0.4;
        let pulses: Vec<f64> = (0..100).map(|k| f64::from(k / 4 % 2) * 10.0).collect();
        for column in [step, corner, pulse, pulses] {
            assert!(found("x", &column).is_empty(), "{:?}", found("x", &column));
        }
        // About its zero a rotary axis changes between 0 and a turn.
        let mut about = vec![0.0005; 100];
        (about[40], about[41], about[60]) = (TAU - 0.001, TAU - 0.002, 1.3);
        assert_eq!(found("c", &about), [60]);
    }
}
