//! Differences between written programs and their intended content, found when they are read back.

use motion::{Vec3, Vec6};
use thiserror::Error;

/// A compensated program failed verification. Lines are those of the original program, from 1, unless stated otherwise.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum VerifyError {
    /// A move is missing.
    #[error("the move of line {line} is missing in the output")]
    Missing {
        /// Line.
        line: usize,
    },
    /// A move that is not compensated has another end.
    #[error("the move of line {line} was not to be compensated, but leads to {is:?} instead of {was:?} mm in the output")]
    Changed {
        /// Line.
        line: usize,
        /// Its end in the output, mm.
        is: Vec3,
        /// Its end in the original, mm.
        was: Vec3,
    },
    /// The output ends within a move.
    #[error("the output ends within line {line}")]
    Ends {
        /// Line.
        line: usize,
    },
    /// A point has other coordinates than intended.
    #[error("line {line} of the original leads to {is:?} instead of {wanted:?} in the output")]
    Elsewhere {
        /// Line.
        line: usize,
        /// The point in the output, mm and rad.
        is: Vec6,
        /// Intended point, mm and rad.
        wanted: Vec6,
    },
    /// A point is shifted by more than the bound.
    #[error("a point of line {line} would lie {off_mm:.4} mm off the programmed path")]
    TooFar {
        /// Line.
        line: usize,
        /// Distance, mm.
        off_mm: f64,
    },
    /// A move has another feed than was chosen.
    #[error("the move of line {line} has F{is} instead of F{wanted} in the output")]
    Feed {
        /// Line.
        line: usize,
        /// F in the output.
        is: f64,
        /// Intended F, in the units of the program.
        wanted: f64,
    },
    /// The output has an additional move.
    #[error("line {line} of the output moves where the program does not")]
    Extra {
        /// Line of the output.
        line: usize,
    },
    /// The output cannot be read.
    #[error(transparent)]
    Unreadable(#[from] gcode::GcodeError),
}

/// An excitation program failed its check. Lines are those of the program, from 1.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ProgramFault {
    /// The number of lines differs.
    #[error("it reads back as {read} lines instead of {wanted}")]
    Lines {
        /// Number of lines read.
        read: usize,
        /// Number of lines written.
        wanted: usize,
    },
    /// A line has another end or another path to it.
    #[error("line {line} leads to {read} instead of {wanted}")]
    Elsewhere {
        /// Line.
        line: usize,
        /// Position read, mm or rad.
        read: f64,
        /// Intended position, mm or rad.
        wanted: f64,
    },
    /// A line has no feed, or another one.
    #[error("line {line} has no feed, or another one than intended")]
    NoFeed {
        /// Line.
        line: usize,
    },
    /// The total time of the lines differs from that of the run.
    #[error("its lines take {read_s:.3} s instead of {wanted_s:.3} s")]
    Time {
        /// Time read, s.
        read_s: f64,
        /// Intended time, s.
        wanted_s: f64,
    },
    /// The dwells take longer than the run.
    #[error("it waits for {waited_s:.3} s, longer than the run's {longest_s:.3} s")]
    Waits {
        /// Sum of the dwells, s.
        waited_s: f64,
        /// Largest allowed sum, s.
        longest_s: f64,
    },
    /// A number cannot be written, or the program cannot be read.
    #[error(transparent)]
    Gcode(#[from] gcode::GcodeError),
}
