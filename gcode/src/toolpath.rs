//! The moves of a program, in mm, rad and mm/s, each with its block.

use crate::arc::Arc;
use crate::cycle::Cycle;
use crate::diagnostic::Diagnostic;
use crate::modal::{Distance, Modal};
use crate::position::Position;
use crate::program::Program;
use crate::rotation::Rotation;

/// Programmed feed of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Feed {
    /// Along the path, mm/s (G94, or G95 times the spindle speed).
    Linear {
        /// Speed, mm/s.
        mm_s: f64,
    },
    /// A move of rotary axes alone under G94 or G95, rad/s.
    Angular {
        /// Speed, rad/s.
        rad_s: f64,
    },
    /// The whole move, s (G93).
    Duration {
        /// Time, s.
        seconds: f64,
    },
}

/// Kind of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MoveKind {
    /// G0. The path between the ends depends on the control.
    Rapid,
    /// G1.
    Line,
    /// G2, G3.
    Arc(Arc),
    /// G33, or a rigid tap that returns to its start.
    Thread,
    /// G31, G38.n: ends where the probe trips.
    Probe,
    /// A canned cycle.
    Cycle(Cycle),
    /// G27 to G30: to a fixed machine position.
    Home,
    /// G4, with its time if it is a number.
    Dwell {
        /// Time, s.
        seconds: Option<f64>,
    },
}

/// Reason why a move must not be changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fixed {
    /// G0.
    Rapid,
    /// A canned cycle.
    Cycle,
    /// G41 or G42 is active, begins or ends in the block: the control computes the path.
    CutterCompensation,
    /// G53: machine coordinates.
    MachineCoordinates,
    /// G27 to G30.
    Home,
    /// The block changes the tool or a tool offset.
    ToolChange,
    /// The start is unknown, both as a position and relative to the last known one.
    UnknownStart,
    /// Synchronised with the spindle.
    Threading,
    /// A probing move.
    Probing,
    /// No motion.
    Dwell,
    /// The block, or one that states its feed or motion code, may be skipped by the block-delete switch.
    OptionalBlock,
    /// Some words of the block act before its motion and some after, or when is not known, it calls a
    /// subprogram, or a jump leads to it, so several lines cannot replace it.
    Unsplittable,
    /// The control computes part of the move, or of the one beside it, from this one's ends: RND, CHF, APPR, DEP, CT, CIP, polar
    /// coordinates of SINUMERIK, a pole measured from here.
    Adjoining,
    /// After a code whose effect on path or frame is unknown.
    NotUnderstood,
    /// Its coordinates, or whether it runs, are known only when the program runs.
    RunTime,
}

/// Whether a compensation may move the points of a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shiftable {
    /// A feed move with known geometry.
    Yes,
    /// Must not be changed, with the reason.
    No(Fixed),
}

/// One move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// Block index, from 0.
    pub block: u32,
    /// Index of its modal state in [`Toolpath::modals`].
    pub modal: u32,
    /// Kind of the move.
    pub kind: MoveKind,
    /// Start position, in the work frame before G52, G92 and known rotations, so that these leave no jump in the
    /// path.
    pub start: Position,
    /// End position, in the same frame.
    pub end: Position,
    /// Feed of a feed move.
    pub feed: Option<Feed>,
    /// The modal F as written, in the program's units.
    pub feed_word: Option<f64>,
    /// The motion code in force in the block, 0 for G0 to 3 for G3; `None` for others and in dialogue.
    pub motion_code: Option<u8>,
    /// Whether the block itself states the motion code.
    pub explicit_motion: bool,
    /// Whether the move may be compensated.
    pub shiftable: Shiftable,
    /// Whether blocks ran since the move before that run several times or perhaps, or stand elsewhere in the file. What is written for one
    /// path must not reach over them.
    pub after_shared: bool,
    /// Whether the program stopped for certain since the move before: M0, M60; SPOS, STOPRE, WAITM and WAITS of SINUMERIK. Of dialogue this is not read.
    pub after_stop: bool,
}

/// Indices into [`Program::words`] of the words of a move that an editor may patch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MoveWords {
    /// X, Y, Z, A, B, C.
    pub axes: [Option<usize>; 6],
    /// I, J, K.
    pub centre: [Option<usize>; 3],
    /// R.
    pub radius: Option<usize>,
    /// F.
    pub feed: Option<usize>,
}

impl Move {
    /// Whether the move is a line or an arc.
    pub fn is_feed(&self) -> bool {
        matches!(self.kind, MoveKind::Line | MoveKind::Arc(_))
    }

    /// The move in the work frame, from turned coordinates. An arc in another plane than they are turned in is taken as the line to its end, and
    /// left alone.
    pub(crate) fn in_work(self, rotation: &Rotation) -> Self {
        let (start, end) = (rotation.in_work(self.start), rotation.in_work(self.end));
        let (kind, shiftable) = match self.kind {
            MoveKind::Arc(arc) => match (arc.in_work(rotation), self.shiftable) {
                (Some(arc), shiftable) => (MoveKind::Arc(arc), shiftable),
                (None, Shiftable::Yes) => (MoveKind::Line, Shiftable::No(Fixed::NotUnderstood)),
                (None, shiftable) => (MoveKind::Line, shiftable),
            },
            kind => (kind, self.shiftable),
        };
        Self { kind, start, end, shiftable, ..self }
    }

    /// Path length of X, Y, Z in mm for lines and arcs (for rapids the distance), otherwise `None`.
    ///
    /// Computed from nominal positions: true if both ends are known or the move is incremental.
    pub fn length_mm(&self) -> Option<f64> {
        let (start, end) = (self.start.nominal_mm(), self.end.nominal_mm());
        match &self.kind {
            MoveKind::Rapid | MoveKind::Line => Some(start.iter().zip(end).map(|(a, b)| (b - a) * (b - a)).sum::<f64>().sqrt()),
            MoveKind::Arc(arc) => {
                let normal = arc.plane.axes()[2];
                Some(arc.length_mm(end[normal] - start[normal]))
            }
            _ => None,
        }
    }

    /// Point in mm at `fraction` (0 to 1) of a line, rapid or arc, from nominal positions. The end
    /// point for other kinds.
    pub fn point_mm(&self, fraction: f64) -> [f64; 3] {
        let (start, end) = (self.start.nominal_mm(), self.end.nominal_mm());
        let between = |axis: usize| start[axis] + (end[axis] - start[axis]) * fraction;
        match &self.kind {
            MoveKind::Rapid | MoveKind::Line => [between(0), between(1), between(2)],
            MoveKind::Arc(arc) => {
                let [first, second, normal] = arc.plane.axes();
                let mut point = [0.0; 3];
                [point[first], point[second]] = arc.plane_point(fraction);
                point[normal] = between(normal);
                point
            }
            _ => end,
        }
    }

    /// The words of its block that an editor may patch.
    pub fn words(&self, program: &Program) -> MoveWords {
        let mut found = MoveWords::default();
        for index in program.word_range(self.block as usize) {
            let word = &program.words()[index];
            if word.number().is_none() {
                continue;
            }
            let slot = match word.letter {
                b'X'..=b'Z' => &mut found.axes[usize::from(word.letter - b'X')],
                b'A'..=b'C' => &mut found.axes[3 + usize::from(word.letter - b'A')],
                b'I'..=b'K' => &mut found.centre[usize::from(word.letter - b'I')],
                b'R' => &mut found.radius,
                b'F' => &mut found.feed,
                _ => continue,
            };
            *slot = Some(index);
        }
        found
    }
}

/// All moves of a program, in order, with modal states and warnings.
#[derive(Clone, Debug)]
pub struct Toolpath {
    /// The moves.
    pub moves: Vec<Move>,
    /// The modal states that moves refer to, one per change.
    pub modals: Vec<Modal>,
    /// Warnings: codes passed through, assumptions made.
    pub warnings: Vec<Diagnostic>,
}

impl Toolpath {
    /// The modal state of a move.
    ///
    /// # Panics
    /// If the move belongs to another toolpath with more states.
    pub fn modal(&self, of: &Move) -> &Modal {
        &self.modals[of.modal as usize]
    }

    /// Values to write for X, Y, Z, A, B, C so that the move ends at `position` (mm, rad): absolute coordinates, or under G91 the distances from
    /// `start`, both in mm or rad.
    ///
    /// # Panics
    /// As [`Toolpath::modal`].
    pub fn programmed(&self, of: &Move, start: [f64; 6], position: [f64; 6]) -> [f64; 6] {
        let Modal { distance, shift, rotation, .. } = self.modal(of);
        let difference = |from: [f64; 6], to: [f64; 6]| std::array::from_fn(|axis| to[axis] - from[axis]);
        match distance {
            Distance::Absolute => difference(*shift, rotation.map_or(position, |rotation| rotation.unturned(position))),
            Distance::Incremental => {
                let distance = difference(start, position);
                rotation.map_or(distance, |rotation| rotation.displacement_unturned(distance))
            }
        }
    }
}
