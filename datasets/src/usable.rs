//! Which axes of a log can be used.

use std::path::{Path, PathBuf};

use motion::Axis;

use crate::quality::is_stuck;
use crate::recorded::FARTHEST;
use crate::{Check, DatasetError, Finding, Severity, Source, Table};

/// Judges the axes of a log by their columns, all at once or a batch of rows at a time.
///
/// An axis is bad where a value is missing or out of range, or where its command moves and its actual position does not. An axis whose
/// command never moves is kept: it may move in another run of the machine.
pub(crate) struct Usable {
    path: PathBuf,
    axes: Vec<Axis>,
    /// Names of the columns: commands, then actual positions.
    names: Vec<String>,
    /// What is wrong with an axis.
    faults: Vec<Option<DatasetError>>,
    /// Least and largest value of every column.
    ranges: Vec<(f64, f64)>,
}

impl Usable {
    /// `sources` are the commands of the axes, then their actual positions, or commands only.
    pub fn new(path: &Path, table: &Table, axes: &[Axis], sources: &[Source]) -> Self {
        let name = |source: &Source| table.names.get(source.column).cloned().unwrap_or_default();
        Self {
            path: path.to_owned(),
            axes: axes.to_vec(),
            names: sources.iter().map(name).collect(),
            faults: axes.iter().map(|_| None).collect(),
            ranges: vec![(f64::INFINITY, f64::NEG_INFINITY); sources.len()],
        }
    }

    /// Judges further rows of the columns.
    pub fn note(&mut self, columns: &[Vec<f64>], lines: &[usize]) {
        for ((low, high), column) in self.ranges.iter_mut().zip(columns) {
            (*low, *high) = column.iter().fold((*low, *high), |(low, high), value| (low.min(*value), high.max(*value)));
        }
        for axis in 0..self.axes.len() {
            if self.faults[axis].is_none() {
                self.faults[axis] = self.first_bad(axis, columns, lines);
            }
        }
    }

    /// The first bad value of an axis in these rows.
    fn first_bad(&self, axis: usize, columns: &[Vec<f64>], lines: &[usize]) -> Option<DatasetError> {
        let slots = (axis..self.names.len()).step_by(self.axes.len());
        let bad = |slot: usize| columns[slot].iter().position(|value| !(-FARTHEST..=FARTHEST).contains(value));
        let (row, slot) = slots.filter_map(|slot| Some((bad(slot)?, slot))).min()?;
        let (path, line, column) = (self.path.clone(), lines.get(row).copied().unwrap_or(row + 1), self.names[slot].clone());
        let value = columns[slot][row];
        Some(if value.is_finite() {
            DatasetError::Absurd { path, line, column, value, most: FARTHEST, unit: self.axes[axis].kind.unit() }
        } else {
            DatasetError::Missing { path, line, column }
        })
    }

    /// The fault of the first bad axis, for what needs all of them.
    ///
    /// # Errors
    /// That fault.
    pub fn check_all(&mut self) -> Result<(), DatasetError> {
        self.faults.iter_mut().find_map(Option::take).map_or(Ok(()), Err)
    }

    /// Indices of the axes that can be used, and a finding for each of the others.
    ///
    /// # Errors
    /// When there is none; the error is the fault of the first axis.
    pub fn finish(mut self) -> Result<(Vec<usize>, Vec<Finding>), DatasetError> {
        for axis in 0..self.axes.len() {
            if self.faults[axis].is_none() {
                self.faults[axis] = self.stuck(axis);
            }
        }
        let usable: Vec<usize> = (0..self.axes.len()).filter(|axis| self.faults[*axis].is_none()).collect();
        if usable.is_empty() {
            self.check_all()?;
        }
        let place = format!("{}: ", self.path.display());
        let faulty = self.axes.iter().zip(&self.faults).filter_map(|(axis, fault)| Some((axis, fault.as_ref()?)));
        let finding = |(axis, fault): (&Axis, &DatasetError)| {
            let text = fault.to_string();
            let why = text.strip_prefix(&place).unwrap_or(&text);
            Finding::new(Severity::Warn, Check::Mended, format!("axis {axis} is left out: {why}"))
        };
        Ok((usable, faulty.map(finding).collect()))
    }

    /// Whether the command of an axis moves and its actual position does not.
    fn stuck(&self, axis: usize) -> Option<DatasetError> {
        let kind = self.axes[axis].kind;
        let travel = |slot: usize| self.ranges.get(slot).map(|(low, high)| (high - low).max(0.0));
        let (command, actual) = (travel(axis)?, travel(axis + self.axes.len())?);
        let column = self.names[axis + self.axes.len()].clone();
        let path = self.path.clone();
        is_stuck(kind, command, actual).then(|| DatasetError::Stuck { path, column, travel: command, unit: kind.unit() })
    }
}
