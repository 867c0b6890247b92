//! What a program does: its moves, in mm, rad and mm/s, each tied to its block.

use crate::arc::Arc;
use crate::cycle::Cycle;
use crate::diagnostic::Diagnostic;
use crate::modal::{Distance, Modal};
use crate::position::Position;
use crate::program::Program;

/// How fast a feed move is programmed.
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

/// The shape of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MoveKind {
    /// G0: the axes' way between the ends is the control's own.
    Rapid,
    /// G1.
    Line,
    /// G2, G3.
    Arc(Arc),
    /// G33, or a rigid tap that comes back to its start.
    Thread,
    /// G31, G38.n: ends where the probe trips.
    Probe,
    /// A canned cycle.
    Cycle(Cycle),
    /// G27 to G30: to a fixed point of the machine.
    Home,
    /// G4, with its time in s where it is a number.
    Dwell {
        /// Time, s.
        seconds: Option<f64>,
    },
}

/// Why a move must stay as it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fixed {
    /// G0.
    Rapid,
    /// A canned cycle.
    Cycle,
    /// G41 or G42 is active, begins or ends in the block: the control computes the path.
    CutterCompensation,
    /// G53: coordinates of the machine.
    MachineCoordinates,
    /// G27 to G30.
    Home,
    /// The block changes the tool.
    ToolChange,
    /// The start is not known, neither as a position nor relative to the last known one.
    UnknownStart,
    /// Synchronised with the spindle.
    Threading,
    /// A probing move.
    Probing,
    /// No motion.
    Dwell,
    /// The block may be skipped by the block-delete switch.
    OptionalBlock,
    /// Some words of the block act before its motion and some after, so that several lines cannot take its place.
    Unsplittable,
    /// After a code that may have changed path or frame in a way that is not known.
    NotUnderstood,
}

/// Whether a compensation may move the points of a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shiftable {
    /// A feed move whose geometry is known.
    Yes,
    /// To be left alone.
    No(Fixed),
}

/// One move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// The block that commands it, from 0.
    pub block: u32,
    /// Index of its modal state in [`Toolpath::modals`].
    pub modal: u32,
    /// The shape.
    pub kind: MoveKind,
    /// Where it starts: in the work frame before G52 and G92, so that those leave no jump in a path.
    pub start: Position,
    /// Where it ends, in the same frame.
    pub end: Position,
    /// The feed of a feed move.
    pub feed: Option<Feed>,
    /// The modal F as written, in the program's units.
    pub feed_word: Option<f64>,
    /// Whether the block itself states the motion code.
    pub explicit_motion: bool,
    /// Whether it may be compensated.
    pub shiftable: Shiftable,
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
    /// Whether it cuts: a line or an arc.
    pub fn is_feed(&self) -> bool {
        matches!(self.kind, MoveKind::Line | MoveKind::Arc(_))
    }

    /// Path length in mm of X, Y, Z for lines and arcs (for rapids the distance), `None` for the rest.
    ///
    /// Reckoned from nominal positions: true where both ends are known or the move is incremental.
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

    /// Point in mm at `fraction` (0 to 1) of a line, rapid or arc, from nominal positions; its end for the rest.
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

/// All moves of a program, in order, with what a reader should know about them.
#[derive(Clone, Debug)]
pub struct Toolpath {
    /// The moves.
    pub moves: Vec<Move>,
    /// The modal states that moves refer to; a new one only where something changed.
    pub modals: Vec<Modal>,
    /// Remarks: codes passed through, assumptions made.
    pub warnings: Vec<Diagnostic>,
}

impl Toolpath {
    /// The modal state of a move.
    ///
    /// # Panics
    /// When the move is of another toolpath with more states.
    pub fn modal(&self, of: &Move) -> &Modal {
        &self.modals[of.modal as usize]
    }

    /// What to write for axis `axis` (0 = X) of a move so that it ends at `position` (mm, rad): the absolute coordinate, or
    /// under G91 the distance from `start`, both in mm or rad.
    pub fn programmed(&self, of: &Move, axis: usize, start: f64, position: f64) -> Option<f64> {
        let modal = self.modals.get(of.modal as usize)?;
        match modal.distance {
            Distance::Absolute => Some(position - modal.shift.get(axis)?),
            Distance::Incremental => Some(position - start),
        }
    }
}
