//! End points of moves: Cartesian and polar coordinates, poles.

use super::block::Block;
use super::state::{Interpreter, Pole};
use super::words::{Coordinate, PathWords};
use crate::position::Position;

impl Interpreter<'_> {
    /// Factor from a word to mm or rad.
    fn unit(&self, axis: usize) -> f64 {
        if axis < 3 { self.modal.units.mm() } else { 1.0_f64.to_radians() }
    }

    /// Position after the Cartesian words.
    pub fn target(&self, words: &PathWords) -> Position {
        let mut end = self.position;
        for (axis, coordinate) in words.axes.iter().enumerate() {
            match coordinate {
                Some(Coordinate { incremental: false, value: Some(value) }) => {
                    end.set(axis, value * self.unit(axis) + self.modal.shift[axis]);
                }
                Some(Coordinate { incremental: true, value: Some(value) }) => end.nominal[axis] += value * self.unit(axis),
                Some(Coordinate { value: None, .. }) => end.forget(axis),
                None => {}
            }
        }
        end
    }

    /// Position in the axes of the plane, mm.
    pub fn in_plane(&self, position: &Position) -> Option<[f64; 2]> {
        let [first, second, _] = self.modal.plane.axes();
        let known = position.knows(first) && position.knows(second);
        known.then(|| [position.nominal[first], position.nominal[second]])
    }

    /// Radius in mm and angle in rad of the position about the pole.
    fn polar_position(&self) -> Option<[f64; 2]> {
        let (pole, at) = (self.pole?.centre_mm, self.in_plane(&self.position)?);
        let from = [at[0] - pole[0], at[1] - pole[1]];
        Some([from[0].hypot(from[1]), from[1].atan2(from[0])])
    }

    /// Radius in mm and angle in rad that the polar words lead to. A circle keeps its radius and starts at the angle of the position.
    pub fn polar_target(&self, words: &PathWords, is_circle: bool) -> Option<[f64; 2]> {
        let before = if is_circle { self.polar_position() } else { self.polar };
        let radius = match words.polar_radius {
            _ if is_circle => before?[0],
            Some(Coordinate { incremental: false, value }) => value? * self.modal.units.mm(),
            Some(Coordinate { incremental: true, value }) => before?[0] + value? * self.modal.units.mm(),
            None => before?[0],
        };
        let angle = match words.polar_angle {
            Some(Coordinate { incremental: false, value }) => value?.to_radians(),
            Some(Coordinate { incremental: true, value }) => before?[1] + value?.to_radians(),
            None => before?[1],
        };
        Some([radius, angle])
    }

    /// `end` with the plane coordinates of polar ones.
    pub fn place_polar(&self, end: &mut Position, polar: Option<[f64; 2]>) {
        let [first, second, _] = self.modal.plane.axes();
        match (self.pole, polar) {
            (Some(pole), Some([radius, angle])) => {
                end.set(first, pole.centre_mm[0] + radius * angle.cos());
                end.set(second, pole.centre_mm[1] + radius * angle.sin());
            }
            _ => {
                end.forget(first);
                end.forget(second);
            }
        }
    }

    /// CC: the pole, or without words the position.
    pub fn set_pole(&mut self, block: &Block<'_>) {
        self.polar = None;
        let words = PathWords::of(block, self, false);
        let [first, second, _] = self.modal.plane.axes();
        let given = [words.axes[first], words.axes[second]];
        let others = (0..6).any(|axis| axis != first && axis != second && words.axes[axis].is_some());
        let complete = given.iter().all(Option::is_some) || given.iter().all(Option::is_none);
        let is_measured = given.iter().any(|word| word.is_none_or(|word| word.incremental));
        self.pole =
            self.in_plane(&self.target(&words)).filter(|_| complete && !others && words.stray.is_none()).map(|centre_mm| {
                // A pole that is measured from the position moves with the end of the move before it.
                Pole { centre_mm, from_move: is_measured.then(|| self.moves.len().checked_sub(1)).flatten() }
            });
        if self.pole.is_none() {
            let help = "state the pole by two absolute coordinates of the working plane";
            self.report.warning(self.span_of_block(), "this pole is not known; moves about it are left alone", Some(help));
        }
    }
}
