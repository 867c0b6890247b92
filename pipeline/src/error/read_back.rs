//! How our own output differs from what was meant when it is read again.

use motion::{Vec3, Vec6};
use thiserror::Error;

/// A compensated program that does not lead where it should. Lines are those of the original, from 1, unless said otherwise.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum VerifyError {
    /// A move is not there.
    #[error("the move of line {line} is missing in the output")]
    Missing {
        /// Line.
        line: usize,
    },
    /// A move that was to stay leads elsewhere.
    #[error("the move of line {line} was not to be compensated, but leads to {is:?} instead of {was:?} mm in the output")]
    Changed {
        /// Line.
        line: usize,
        /// Its end in the output, mm.
        is: Vec3,
        /// Its end in the original, mm.
        was: Vec3,
    },
    /// The output ends too early.
    #[error("the output ends within line {line}")]
    Ends {
        /// Line.
        line: usize,
    },
    /// A point is not the one that was meant.
    #[error("line {line} of the original leads to {is:?} instead of {wanted:?} in the output")]
    Elsewhere {
        /// Line.
        line: usize,
        /// The point in the output, mm and rad.
        is: Vec6,
        /// The point that was meant, mm and rad.
        wanted: Vec6,
    },
    /// A point is shifted too far.
    #[error("a point of line {line} would lie {off_mm:.4} mm off the programmed path")]
    TooFar {
        /// Line.
        line: usize,
        /// Distance, mm.
        off_mm: f64,
    },
    /// The output moves once more.
    #[error("line {line} of the output moves where the program does not")]
    Extra {
        /// Line of the output.
        line: usize,
    },
    /// The output cannot be read.
    #[error(transparent)]
    Unreadable(#[from] gcode::GcodeError),
}

/// An excitation program that does not lead where it should. Lines are those of the program, from 1.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ProgramFault {
    /// Lines are missing or too many.
    #[error("it reads back as {read} lines instead of {wanted}")]
    Lines {
        /// Lines read.
        read: usize,
        /// Lines written.
        wanted: usize,
    },
    /// A line leads elsewhere.
    #[error("line {line} leads to {read} instead of {wanted}")]
    Elsewhere {
        /// Line.
        line: usize,
        /// Position read, mm or rad.
        read: f64,
        /// Position meant, mm or rad.
        wanted: f64,
    },
    /// A line has no feed.
    #[error("line {line} has no feed")]
    NoFeed {
        /// Line.
        line: usize,
    },
    /// The lines take another time than the run.
    #[error("its lines take {read_s:.3} s instead of {wanted_s:.3} s")]
    Time {
        /// Time read, s.
        read_s: f64,
        /// Time meant, s.
        wanted_s: f64,
    },
    /// It waits longer than the run takes.
    #[error("it waits for {waited_s:.3} s, longer than the run's {longest_s:.3} s")]
    Waits {
        /// Time read, s.
        waited_s: f64,
        /// Longest that it may, s.
        longest_s: f64,
    },
    /// A number cannot be written, or the program not be read.
    #[error(transparent)]
    Gcode(#[from] gcode::GcodeError),
}
