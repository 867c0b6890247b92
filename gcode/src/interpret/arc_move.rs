//! The arc of a feed move: plane, centre or radius, number of turns.

use super::codes::Motion;
use super::gather::Gathered;
use super::report::Report;
use super::state::Interpreter;
use crate::arc::{Arc, ArcEnds, ArcFault};
use crate::dialect::Dialect;
use crate::execution::Ran;
use crate::modal::Distance;
use crate::position::{AXIS_LETTERS, Position};
use crate::sinumerik::names::Name;
use crate::toolpath::Fixed;

/// Address letters of the distances from start to centre along X, Y, Z.
const CENTRE_LETTERS: [u8; 3] = *b"IJK";

impl Interpreter<'_> {
    /// Whether the arc leads from a point to itself about that point, which a control does not move for or reports: with `I0 J0` on Fanuc
    /// controls, whose centres are distances from the start.
    pub fn is_arc_without_radius(&self, words: &Gathered, end: Position) -> bool {
        let [first, second, _] = self.modal.plane.axes();
        let centre = [first, second].map(|axis| CENTRE_LETTERS[axis]);
        let is_zero = centre.iter().all(|letter| !words.has(*letter) || words.number(self.program, *letter) == Some(0.0));
        let stays = [first, second].iter().all(|axis| self.position.nominal[*axis] == end.nominal[*axis]);
        let is_relative = self.modal.arc_distance == Distance::Incremental && words.any(&centre).is_some() && !words.has(b'R');
        self.options.dialect == Dialect::Fanuc && is_zero && stays && is_relative
    }

    /// Why a feed move is an arc whose circle is not determined, with a warning: it has no radius, or its start is not known.
    pub fn arc_without_path(&mut self, words: &Gathered, motion: Motion, end: Position, at: usize) -> Option<Fixed> {
        let (fixed, message, help) = if motion == Motion::Line {
            return None;
        } else if self.is_arc_without_radius(words, end) {
            (Fixed::NotUnderstood, "an arc of radius zero, which is left alone", None)
        } else if !self.knows_arc_start(words) {
            let help = "give all axes in an absolute move first; G28, a new work offset and G53 leave the place unknown";
            (Fixed::UnknownStart, "the start of this arc is not known: it is left alone", Some(help))
        } else if self.is_in_section() && !self.fits_a_circle(words, motion, end, at) {
            let help = "a code before it may have changed how its words are read";
            (Fixed::NotUnderstood, "this arc fits no circle: it is left alone", Some(help))
        } else {
            return None;
        };
        if self.ran != Ran::Perhaps {
            self.report.warning(self.span(at), message, help);
        }
        Some(fixed)
    }

    /// Whether the present block is an arc as its words read. Nothing is reported: where codes that are not known may have changed what the words mean,
    /// an arc that fits no circle is no fault of the program, and says nothing about how others are stated.
    fn fits_a_circle(&mut self, words: &Gathered, motion: Motion, end: Position, at: usize) -> bool {
        let report = std::mem::replace(&mut self.report, Report::new(self.program));
        let before = (self.arc_faults, self.open_centres);
        let fits = self.arc(words, motion == Motion::ArcCounterClockwise, end, at).is_some();
        (self.arc_faults, self.open_centres) = before;
        self.report = report;
        fits
    }

    /// Builds the arc of the present block. Reports an error if there is none.
    pub fn arc(&mut self, words: &Gathered, counter_clockwise: bool, end: Position, at: usize) -> Option<Arc> {
        let plane = self.modal.plane;
        let [first, second, normal] = plane.axes();
        // Postprocessors for Fanuc controls write a zero for the third axis. LinuxCNC refuses it.
        let is_zero =
            self.options.dialect != Dialect::LinuxCnc && words.number(self.program, CENTRE_LETTERS[normal]) == Some(0.0);
        if let Some(index) = words.index(CENTRE_LETTERS[normal]).filter(|_| !is_zero) {
            self.report.error(self.span(index), "this centre word is not in the plane of the arc", Some("check G17, G18, G19"));
            return None;
        }
        let centre_word = words.any(&[CENTRE_LETTERS[first], CENTRE_LETTERS[second]]);
        let ends = ArcEnds {
            plane,
            start: [self.position.nominal[first], self.position.nominal[second]],
            end: [end.nominal[first], end.nominal[second]],
            counter_clockwise,
            turns: self.turns(words, at)?,
            tolerance: self.options.arc_tolerance_in(self.modal.units),
        };
        match (words.index(b'R'), centre_word) {
            (Some(index), Some(_)) => {
                self.report.error(self.span(index), "an arc with both a radius and a centre", None);
                None
            }
            (Some(index), None) => {
                let radius = self.coordinate(words, b'R').unwrap_or(0.0) * self.modal.units.mm();
                ends.with_radius(radius).map_err(|fault| self.report_arc(fault, index, None)).ok()
            }
            (None, None) => {
                self.report.error(self.span(at), "an arc without centre or radius", Some("give I, J, K or R"));
                None
            }
            (None, Some(index)) => self.arc_about_centre(words, ends, index),
        }
    }

    /// Whether the start coordinates that the arc depends on are known.
    pub fn knows_arc_start(&self, words: &Gathered) -> bool {
        let [first, second, _] = self.modal.plane.axes();
        let has_centre = words.any(&[CENTRE_LETTERS[first], CENTRE_LETTERS[second]]).is_some();
        let absolute_centre = self.modal.arc_distance == Distance::Absolute && has_centre;
        [first, second].iter().all(|&axis| {
            let given = words.has(AXIS_LETTERS[axis]) && self.distance_of(words, axis) == Distance::Absolute;
            self.position.knows(axis) || !(given || absolute_centre)
        })
    }

    /// LinuxCNC's P word of an arc, 1 if absent.
    fn turns(&mut self, words: &Gathered, at: usize) -> Option<u32> {
        if let Some((index, _)) = words.named.iter().find(|(_, name)| *name == Name::Turn) {
            let full = self.program.words()[*index].number().filter(|n| n.fract() == 0.0 && (0.0..1e3).contains(n));
            if full.is_none() {
                self.report.error(self.span(*index), "TURN must be a whole number of circles", None);
            }
            return full.map(|full| full as u32 + 1);
        }
        match words.number(self.program, b'P') {
            Some(p) if self.options.dialect == Dialect::LinuxCnc && words.m.is_empty() => {
                if p.fract() != 0.0 || !(1.0..=1e6).contains(&p) {
                    self.report.error(self.span(at), "P must be a whole number of turns", None);
                    return None;
                }
                Some(p as u32)
            }
            _ => Some(1),
        }
    }

    /// The arc about the centre given by I, J, K. `index` is the first of these words.
    fn arc_about_centre(&mut self, words: &Gathered, ends: ArcEnds, index: usize) -> Option<Arc> {
        let [first, second, _] = ends.plane.axes();
        let unit = self.modal.units.mm();
        let absolute_centre = self.modal.arc_distance == Distance::Absolute;
        let is_absolute = |axis: usize| {
            words.index(CENTRE_LETTERS[axis]).is_some_and(|index| self.program.words()[index].name == Name::Absolute)
        };
        let offset = [first, second].map(|axis| {
            let value = self.coordinate(words, CENTRE_LETTERS[axis])? * unit;
            Some(if is_absolute(axis) { self.modal.shift[axis] + value - self.position.nominal[axis] } else { value })
        });
        let shift = [self.modal.shift[first], self.modal.shift[second]];
        let incremental = [0, 1].map(|k| ends.start[k] + offset[k].unwrap_or(0.0));
        let absolute = [0, 1].map(|k| shift[k] + offset[k].unwrap_or(0.0));
        let complete = offset.iter().all(Option::is_some);
        if absolute_centre && !complete {
            self.arc_faults.note(true);
            self.report.error(self.span(index), "an absolute arc centre needs both its words", None);
            return None;
        }
        if !absolute_centre && !self.is_in_section() {
            let [from_start, as_position] = [incremental, absolute].map(|centre| [0, 1].map(|k| centre[k] - ends.start[k]));
            let fits_both =
                ends.are_closed() || (complete && [incremental, absolute].iter().all(|centre| ends.about(*centre).is_ok()));
            self.open_centres.note(self.span(index), fits_both, from_start, complete.then_some(as_position));
        }
        let (centre, other) = if absolute_centre { (absolute, incremental) } else { (incremental, absolute) };
        let fits_otherwise = complete && ends.about(other).is_ok();
        ends.about(centre).map_err(|fault| self.report_arc(fault, index, fits_otherwise.then_some(absolute_centre))).ok()
    }

    fn report_arc(&mut self, fault: ArcFault, index: usize, fits_other_than_absolute: Option<bool>) {
        let message = match fault {
            ArcFault::RadiiDiffer { start_mm, end_mm } => {
                format!("no circle: its radius is {start_mm:.4} mm at the start and {end_mm:.4} mm at the end")
            }
            ArcFault::ZeroRadius => "an arc of radius zero".to_owned(),
            ArcFault::RadiusTooSmall { radius_mm, half_chord_mm } => {
                format!("no circle: its radius is {radius_mm:.4} mm, half its chord {half_chord_mm:.4} mm")
            }
            ArcFault::RadiusWithoutChord => "a radius makes no circle from a point to itself: give I, J, K".to_owned(),
        };
        let help = match fits_other_than_absolute {
            Some(false) if self.is_sinumerik() => Some("the centre fits if it is absolute: I=AC(...)"),
            Some(false) => {
                Some("the centre fits if it is absolute: state --arc-centres absolute, or G90.1 where the control has it")
            }
            Some(true) => Some(
                "the centre fits if it is a distance from the start: state --arc-centres incremental, or G91.1 where the control has it",
            ),
            None => None,
        };
        match fault {
            // `I0 J0` speaks for no centre that is measured from elsewhere.
            ArcFault::RadiiDiffer { start_mm, .. } => self.arc_faults.note(start_mm > 0.0),
            ArcFault::ZeroRadius => self.arc_faults.note(false),
            ArcFault::RadiusTooSmall { .. } | ArcFault::RadiusWithoutChord => {}
        }
        self.report.error(self.span(index), message, help);
    }
}
