//! Circles of SINUMERIK that follow from points: CIP through an intermediate point, CT from the element before.
//!
//! Source: SINUMERIK ONE, "NC programming" (6FC5398-2EP40-0BA0), "Circular interpolation with intermediate point (CIP)" and "Circular
//! interpolation with tangential transition (CT)". The blocks are left alone. Their ends are known, and their paths where the points determine them.

use super::gather::Gathered;
use super::sinumerik::{has_unread, is_of_every_move};
use super::state::Interpreter;
use crate::arc::{ArcEnds, Tangential, circle_through, direction, tangential};
use crate::execution::Ran;
use crate::modal::{Distance, Plane};
use crate::position::{AXIS_LETTERS, LARGEST_COORDINATE, Position};
use crate::sinumerik::names::Name;
use crate::toolpath::{Fixed, Move, MoveKind, Shiftable};

/// Coordinates that differ by less, mm, lie in one plane: a hundredth of the smallest increment of a control (10⁻⁴ mm).
const SAME_PLANE_MM: f64 = 1e-6;

/// What has no path, as a report states it.
const LEFT_ALONE: &str = "the block is left alone, and its path is taken as a line to its end";

impl Interpreter<'_> {
    /// CIP. The circle lies in space; it is planned where that is a main plane.
    pub fn circle_through_point(&mut self, words: &Gathered, explicit_motion: bool) {
        let is_other = |name: &Name| name.is_coordinate() && !matches!(name, Name::Intermediate(_));
        let is_unread = has_unread(words, is_of_every_move) || words.named.iter().any(|(_, name)| is_other(name));
        if self.sections.is_open() || is_unread {
            return self.curve(words, is_unread, explicit_motion);
        }
        let end = self.target(words, 1);
        let kind = self.arc_through_point(words, end);
        self.push_computed(words, end, kind, explicit_motion);
    }

    /// CT. The direction comes from the move before, which is left alone too.
    pub fn tangential_circle(&mut self, words: &Gathered, explicit_motion: bool) {
        let is_unread = has_unread(words, is_of_every_move) || words.geometry().is_some();
        if self.sections.is_open() || is_unread {
            return self.curve(words, is_unread, explicit_motion);
        }
        self.fix_last_move();
        let end = self.target(words, 1);
        let kind = self.arc_from_tangent(words, end);
        self.push_computed(words, end, kind, explicit_motion);
    }

    /// A move whose path the control computes. `kind`: its path, or why there is none.
    pub fn push_computed(
        &mut self,
        words: &Gathered,
        end: Position,
        kind: Result<MoveKind, &'static str>,
        explicit_motion: bool,
    ) {
        let start = self.position;
        let machine = words.is_in_machine_frame();
        let is_lost = machine || (self.optional_motion && !explicit_motion);
        let is_decided = self.ran != Ran::Perhaps && !self.has_value_at_run_time(words);
        let fixed = match self.shiftable(words, start, machine) {
            _ if !is_decided => Fixed::RunTime,
            Shiftable::No(fixed) => fixed,
            Shiftable::Yes if kind.is_err() => Fixed::NotUnderstood,
            Shiftable::Yes => Fixed::Adjoining,
        };
        if let (Err(why), false) = (kind, matches!(fixed, Fixed::UnknownStart | Fixed::MachineCoordinates)) {
            let what = if is_decided { why } else { "a value is known only when the program runs" };
            self.report.warning(self.span_of_block(), format!("{what}: {LEFT_ALONE}"), None);
        }
        if is_lost {
            self.forget_all();
        } else {
            self.position = end;
        }
        self.keep_code_of_last_arc(words.optional, explicit_motion);
        let kind = kind.ok().filter(|_| is_decided && !is_lost).unwrap_or(MoveKind::Line);
        let feed = self.known_feed(words);
        let step = self.step(kind, start, Shiftable::No(fixed));
        self.moves.push(Move { feed, explicit_motion, ..step });
    }

    /// Whether an axis word or a named coordinate of the block has no value.
    fn has_value_at_run_time(&self, words: &Gathered) -> bool {
        let mut named = words.named.iter().filter(|(_, name)| name.is_coordinate());
        words.unknown_value(self.program, &AXIS_LETTERS).is_some()
            || named.any(|(index, _)| self.program.words()[*index].number().is_none())
    }

    fn arc_through_point(&self, words: &Gathered, end: Position) -> Result<MoveKind, &'static str> {
        let (Some(start), Some(stop)) = (self.position.xyz_mm(), end.xyz_mm()) else {
            return Err("start or end of this circle is not known");
        };
        if words.name(Name::Turn).is_some() {
            return Err("full circles (TURN) through an intermediate point are not interpreted");
        }
        let middle = [0, 1, 2].map(|axis| self.intermediate(words, axis));
        let contains = |plane: &Plane| {
            let [first, second, normal] = plane.axes();
            let is_near = |height: f64| (height - start[normal]).abs() <= SAME_PLANE_MM;
            is_near(stop[normal]) && middle[normal].is_none_or(is_near) && middle[first].is_some() && middle[second].is_some()
        };
        let planes = [self.modal.plane, Plane::Xy, Plane::Zx, Plane::Yz];
        let Some(plane) = planes.into_iter().find(contains) else {
            return Err("the points of this circle lie in no main plane, or its intermediate point is not stated whole");
        };
        let [first, second, _] = plane.axes();
        let in_plane = |point: [f64; 3]| [point[first], point[second]];
        let (from, to) = (in_plane(start), in_plane(stop));
        let through = in_plane(middle.map(Option::unwrap_or_default));
        let Some((centre, turn)) = circle_through(from, through, to) else {
            return Err("start, intermediate point and end make no circle: they lie on a line, or two of them coincide");
        };
        self.arc_in(plane, from, to, turn, centre)
    }

    /// Coordinate of the intermediate point of CIP, mm. One that is not stated is that of the start under G91; under G90 it is not determined.
    fn intermediate(&self, words: &Gathered, axis: u8) -> Option<f64> {
        let slot = usize::from(axis);
        let start = self.position.nominal[slot];
        let Some(index) = words.name(Name::Intermediate(axis)) else {
            return (self.modal.distance == Distance::Incremental).then_some(start);
        };
        let number = self.program.words()[index].number().filter(|number| number.abs() <= LARGEST_COORDINATE)?;
        let value = number * self.modal.units.mm();
        match self.distance_of_name(index)? {
            Distance::Absolute => Some(value + self.modal.shift[slot]),
            Distance::Incremental => (!self.unsettled[slot]).then_some(start + value),
        }
    }

    fn arc_from_tangent(&self, words: &Gathered, end: Position) -> Result<MoveKind, &'static str> {
        let plane = self.modal.plane;
        let [first, second, _] = plane.axes();
        if words.name(Name::Turn).is_some() {
            return Err("full circles (TURN) with a tangential transition are not interpreted");
        }
        let Some(along) = self.direction_before() else {
            return Err("no line or circle before this block gives its tangent");
        };
        if ![first, second].iter().all(|axis| end.knows(*axis)) {
            return Err("the end of this circle is not known");
        }
        let in_plane = |point: Position| [point.nominal[first], point.nominal[second]];
        let (from, to) = (in_plane(self.position), in_plane(end));
        match tangential(along, from, to) {
            Some(Tangential::Line) => Ok(MoveKind::Line),
            Some(Tangential::Circle { centre, turn }) => self.arc_in(plane, from, to, turn, centre),
            None => Err("no circle continues the move before this block to its end"),
        }
    }

    /// Direction in the plane in which the last move ends. `None` where its path, or whether it leads to the present position, is not known.
    fn direction_before(&self) -> Option<[f64; 2]> {
        let plane = self.modal.plane;
        let [first, second, _] = plane.axes();
        let last = self.moves.iter().rfind(|step| !matches!(step.kind, MoveKind::Dwell { .. }))?;
        // Moves are recorded in the work frame.
        if self.modal.rotation.is_some() {
            return None;
        }
        let is_certain = match last.shiftable {
            Shiftable::Yes => true,
            Shiftable::No(fixed) => matches!(fixed, Fixed::Adjoining | Fixed::Unsplittable | Fixed::CutterCompensation),
        };
        let continues = |axis: usize| {
            let knows = [last.start, last.end, self.position].iter().all(|position| position.knows(axis));
            knows && last.end.nominal[axis] == self.position.nominal[axis]
        };
        if !is_certain || !continues(first) || !continues(second) {
            return None;
        }
        let in_plane = |point: Position| [point.nominal[first], point.nominal[second]];
        match last.kind {
            MoveKind::Line => direction(in_plane(last.start), in_plane(last.end)),
            MoveKind::Arc(arc) if arc.plane == plane => Some(arc.end_direction()),
            _ => None,
        }
    }

    /// The arc about a centre.
    pub fn arc_in(
        &self,
        plane: Plane,
        start: [f64; 2],
        end: [f64; 2],
        counter_clockwise: bool,
        centre: [f64; 2],
    ) -> Result<MoveKind, &'static str> {
        let tolerance = self.options.arc_tolerance_in(self.modal.units);
        let ends = ArcEnds { plane, start, end, counter_clockwise, turns: 1, tolerance };
        ends.about(centre).map(MoveKind::Arc).map_err(|_| "no circle about this centre has both ends of the block")
    }
}
