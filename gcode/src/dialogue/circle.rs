//! Kinds of feed moves: lines, and the circles C, CP, CR, CT.

use std::f64::consts::TAU;

use super::path::{Function, Step};
use super::state::Interpreter;
use crate::arc::{Arc, ArcEnds, ArcFault, Tangential, tangential};
use crate::toolpath::MoveKind;

/// Angles that differ by less, rad, are the same: a tenth of the control's increment.
const SAME_ANGLE: f64 = 1e-7;

impl Interpreter<'_> {
    /// Moves that a move depends on beside its start: that before a tangent or a polar coordinate that is not stated whole, and that whose end
    /// the pole is measured from.
    pub fn needs_of(&self, step: &Step) -> [Option<usize>; 2] {
        let words = &step.words;
        let measured = [words.polar_radius, words.polar_angle].iter().any(|word| word.is_none_or(|word| word.incremental));
        let (before, pole) = match step.function {
            Function::Line { polar } => (polar && measured, polar),
            Function::Circle { .. } => (false, true),
            Function::Radius => (false, false),
            Function::Tangent { polar } => (true, polar),
        };
        let last = self.last_feed_move().filter(|_| before);
        [last, self.pole.filter(|_| pole).and_then(|pole| pole.from_move)]
    }

    /// Kind of a feed move, if the geometry is determined.
    pub fn kind_of(&mut self, step: &Step) -> Option<MoveKind> {
        let is_sound = step.words.is_known() && step.words.stray.is_none();
        let (Some(start), Some(stop), true) = (self.in_plane(&self.position), self.in_plane(&step.end), is_sound) else {
            return None;
        };
        let plane = self.modal.plane;
        let tolerance = self.options.arc_tolerance_in(self.modal.units);
        let ends = |counter_clockwise: bool| ArcEnds { plane, start, end: stop, counter_clockwise, turns: 1, tolerance };
        let turn = step.words.direction.map(|direction| direction > 0.0);
        // A circle lies in the plane, CP may be a helix.
        let normal = step.words.axes[plane.axes()[2]].is_some();
        let flat = !normal && step.words.axes[3..].iter().all(Option::is_none);
        match step.function {
            Function::Line { .. } => Some(MoveKind::Line),
            Function::Circle { polar: false } => {
                let arc = self.pole.zip(turn).filter(|_| flat).map(|(pole, turn)| ends(turn).about(pole.centre_mm));
                self.sound(arc)
            }
            Function::Circle { polar: true } => {
                let arc = self.sweep_of(step, turn).map(|sweep| helix(self, start, sweep));
                match arc.flatten() {
                    Some(arc) => Some(MoveKind::Arc(arc)),
                    None => self.sound(None),
                }
            }
            Function::Radius => {
                let radius = step.words.radius.and_then(|radius| radius.value).map(|radius| radius * self.modal.units.mm());
                let arc = radius.zip(turn).filter(|_| flat).map(|(radius, turn)| ends(turn).with_radius(radius));
                self.sound(arc)
            }
            Function::Tangent { .. } => match self.tangent.filter(|_| flat).and_then(|along| tangential(along, start, stop)) {
                Some(Tangential::Line) => Some(MoveKind::Line),
                Some(Tangential::Circle { centre, turn }) => self.sound(Some(ends(turn).about(centre))),
                None => self.sound(None),
            },
        }
    }

    /// The arc, or the report of why there is none.
    fn sound(&mut self, arc: Option<Result<Arc, ArcFault>>) -> Option<MoveKind> {
        let what = match arc {
            Some(Ok(arc)) => return Some(MoveKind::Arc(arc)),
            None => "the circle of this block is not determined; the block is left alone".to_owned(),
            Some(Err(ArcFault::RadiiDiffer { start_mm, end_mm })) => {
                format!(
                    "no circle: its radius is {start_mm:.4} mm at the start and {end_mm:.4} mm at the end; the block is left alone"
                )
            }
            Some(Err(ArcFault::RadiusTooSmall { radius_mm, half_chord_mm })) => {
                format!(
                    "no circle: its radius is {radius_mm:.4} mm, half its chord {half_chord_mm:.4} mm; the block is left alone"
                )
            }
            Some(Err(ArcFault::ZeroRadius | ArcFault::RadiusWithoutChord)) => {
                "no circle: its radius or its chord is zero; the block is left alone".to_owned()
            }
        };
        self.report.warning(
            self.span_of_block(),
            what,
            Some("check CC, R and DR; the control would stop here or move elsewhere"),
        );
        None
    }

    /// Angle of CP, rad. IPA and DR have the same sign.
    fn sweep_of(&mut self, step: &Step, turn: Option<bool>) -> Option<f64> {
        let (Some(turn), Some(angle), None) = (turn, step.words.polar_angle, step.words.polar_radius) else { return None };
        let value = angle.value?.to_radians();
        if angle.incremental {
            return ((value > 0.0) == turn && value.abs() > SAME_ANGLE).then_some(value);
        }
        let pole = self.pole?.centre_mm;
        let at = self.in_plane(&self.position)?;
        let turned = (value - (at[1] - pole[1]).atan2(at[0] - pole[0])).rem_euclid(TAU);
        // Whether an end at the start's own angle means a full circle or none is not stated.
        let distinct = turned > SAME_ANGLE && turned < TAU - SAME_ANGLE;
        distinct.then_some(if turn { turned } else { turned - TAU })
    }
}

/// The arc about the pole that sweeps this angle from `start`.
fn helix(state: &Interpreter<'_>, start: [f64; 2], sweep: f64) -> Option<Arc> {
    let centre_mm = state.pole?.centre_mm;
    let from = [start[0] - centre_mm[0], start[1] - centre_mm[1]];
    let radius = from[0].hypot(from[1]);
    let start_angle = from[1].atan2(from[0]);
    let plane = state.modal.plane;
    (radius > 1e-6).then_some(Arc { plane, centre_mm, radius_start_mm: radius, radius_end_mm: radius, start_angle, sweep })
}
