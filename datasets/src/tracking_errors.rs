//! Columns of tracking errors, which stand for a position that was not logged.

use motion::Axis;

use crate::columns::Side;
use crate::formats::Rows;
use crate::{Check, DatasetError, Finding, Severity};

/// Correlation of tracking error and speed of the command below which an axis is ahead of its command.
const AHEAD: f64 = -0.5;
/// Rows by which it has to be ahead: feed-forward may lead by less.
const AHEAD_ROWS: f64 = 0.5;

/// Replaces the errors of the rows from `from` on by positions. `columns` are the commands of the axes, then their actual positions; `sides`
/// tells for every axis which of the two holds its error, command minus actual position.
pub(crate) fn replace(columns: &mut [Vec<f64>], sides: &[Option<Side>], from: usize) {
    let (references, actuals) = columns.split_at_mut(sides.len().min(columns.len()));
    for ((reference, actual), side) in references.iter_mut().zip(actuals).zip(sides) {
        let rows = reference.iter_mut().zip(actual.iter_mut()).skip(from);
        match side {
            Some(Side::Reference) => rows.for_each(|(reference, actual)| *reference += *actual),
            Some(Side::Actual) => rows.for_each(|(reference, actual)| *actual = *reference - *actual),
            None => {}
        }
    }
}

/// Rows with positions in place of errors.
pub(crate) struct Positions {
    pub rows: Box<dyn Rows>,
    pub sides: Vec<Option<Side>>,
}

impl Rows for Positions {
    fn read(&mut self, most: usize, columns: &mut [Vec<f64>], lines: &mut Vec<usize>) -> Result<usize, DatasetError> {
        let from = columns.first().map_or(0, Vec::len);
        let rows = self.rows.read(most, columns, lines)?;
        replace(columns, &self.sides, from);
        Ok(rows)
    }

    fn skip(&mut self, rows: usize) -> Result<(), DatasetError> {
        self.rows.skip(rows)
    }

    fn cut_off(&self) -> Option<&str> {
        self.rows.cut_off()
    }
}

/// Whether tracking errors have the sign that they are taken to have: no axis moves before its command.
pub(crate) struct Signs {
    sides: Vec<Option<Side>>,
    sums: Vec<Sums>,
}

/// Sums over the rows of an axis: of the error e and the step v of its command.
#[derive(Clone, Default)]
struct Sums {
    last: Option<f64>,
    rows: f64,
    e: f64,
    v: f64,
    ee: f64,
    ev: f64,
    vv: f64,
}

impl Signs {
    pub fn new(sides: &[Option<Side>]) -> Self {
        Self { sides: sides.to_vec(), sums: vec![Sums::default(); sides.len()] }
    }

    /// Takes further rows of the positions.
    pub fn note(&mut self, columns: &[Vec<f64>]) {
        if self.sides.iter().all(Option::is_none) {
            return;
        }
        let (references, actuals) = columns.split_at(self.sides.len().min(columns.len()));
        for ((sums, reference), actual) in self.sums.iter_mut().zip(references).zip(actuals) {
            reference.iter().zip(actual).for_each(|(reference, actual)| sums.note(*reference, *actual));
        }
    }

    /// A refusal of the axes that by their errors are ahead of their commands.
    pub fn finding(&self, axes: &[Axis]) -> Option<Finding> {
        let of_errors = axes.iter().zip(&self.sides).zip(&self.sums).filter(|((_, side), _)| side.is_some());
        let ahead = of_errors.filter(|(_, sums)| sums.is_ahead()).map(|((axis, _), _)| axis.name.as_str());
        let names: Vec<&str> = ahead.collect();
        let first = names.first()?;
        let message = format!(
            "by the tracking error the axis moves before its command ({}): the error is actual position minus command; map it with a factor of -1, \
             as in `{first}_err=NAME*-1`",
            names.join(", ")
        );
        Some(Finding::new(Severity::Refuse, Check::Pairing, message))
    }
}

impl Sums {
    fn note(&mut self, reference: f64, actual: f64) {
        let Some(last) = self.last.replace(reference) else { return };
        let (e, v) = (reference - actual, reference - last);
        if e.is_finite() && v.is_finite() {
            self.rows += 1.0;
            (self.e, self.v) = (self.e + e, self.v + v);
            (self.ee, self.ev, self.vv) = (self.ee + e * e, self.ev + e * v, self.vv + v * v);
        }
    }

    /// Whether the axis is ahead of its command.
    fn is_ahead(&self) -> bool {
        let of = |ab: f64, a: f64, b: f64| ab - a * b / self.rows;
        let (ee, ev, vv) = (of(self.ee, self.e, self.e), of(self.ev, self.e, self.v), of(self.vv, self.v, self.v));
        ev < AHEAD * (ee * vv).sqrt() && ev < -AHEAD_ROWS * vv
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_the_other_sign_are_refused() {
        let axes = [Axis::named("x")];
        let command: Vec<f64> = (0..2000).map(|k| 40.0 * (0.01 * f64::from(k)).sin()).collect();
        let late: Vec<f64> = (0..2000).map(|k| 40.0 * (0.01 * f64::from(k) - 0.02).sin()).collect();
        for sign in [1.0, -1.0] {
            let error: Vec<f64> = command.iter().zip(&late).map(|(command, late)| sign * (command - late)).collect();
            for (side, mut columns) in
                [(Side::Actual, vec![command.clone(), error.clone()]), (Side::Reference, vec![error.clone(), late.clone()])]
            {
                let mut signs = Signs::new(&[Some(side)]);
                replace(&mut columns, &[Some(side)], 0);
                let (begin, end): (Vec<_>, Vec<_>) =
                    columns.iter().map(|column| (column[..700].to_vec(), column[700..].to_vec())).unzip();
                signs.note(&begin);
                signs.note(&end);
                assert_eq!(signs.finding(&axes).is_some(), sign < 0.0, "{side:?}");
            }
        }
        // Whole positions may have any lead: that is for the checks of a log.
        let mut signs = Signs::new(&[None]);
        signs.note(&[late, command]);
        assert!(signs.finding(&axes).is_none());
    }
}
