//! RS-274 part programs, SINUMERIK programs and Heidenhain dialogue, as bytes: split without loss, read modally, changed span by span.
//!
//! ```
//! use gcode::{Dialect, Edits, MoveKind};
//!
//! let program = gcode::parse("G21 G90 (start)\nG0 X0 Y0 Z0\nG1X10.F600 ; cut\nM30\n");
//! let toolpath = gcode::interpret(&program, &Dialect::Fanuc.into())?;
//! let cut = &toolpath.moves[1];
//! assert_eq!(cut.kind, MoveKind::Line);
//! assert_eq!(cut.length_mm(), Some(10.0));
//!
//! let mut edits = Edits::new();
//! if let Some(x) = cut.words(&program).axes[0] {
//!     let units = toolpath.modal(cut).units;
//!     edits.replace(program.words()[x].value_span(), gcode::format_coordinate(10.0125, units, 4)?);
//! }
//! assert_eq!(gcode::edit(&program, &edits)?, b"G21 G90 (start)\nG0 X0 Y0 Z0\nG1X10.0125F600 ; cut\nM30\n");
//! # Ok::<(), gcode::GcodeError>(())
//! ```
//!
//! # Frames and known coordinates
//! Positions are mm and rad in the active work coordinate system before G52, G92 and a known rotation.
//! [`Toolpath::programmed`] converts them to programmed coordinates. A coordinate is *known* after an
//! absolute word. It becomes unknown after G28, G53, a probing move, a subprogram call, a tool or
//! pallet change, a change of the active work offset (G54 to G55, G10 L2), and Z after a change of
//! the tool length. A linear axis that the program never names counts as known, at 0. Moves from
//! an unknown start are read but are never [`Shiftable`].

#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::exit, clippy::disallowed_methods))]

mod acting;
mod arc;
mod block_end;
mod cycle;
mod decimal_point;
mod diagnostic;
mod dialect;
mod dialogue;
mod edit;
mod error;
mod evaluate;
mod execution;
mod foreign;
mod format;
mod interpret;
mod lexer;
mod modal;
mod named_blocks;
mod number;
mod passive;
mod plane;
mod position;
mod program;
mod rotation;
mod sections;
mod signs;
mod sinumerik;
mod split;
mod toolpath;
mod word;

pub use acting::is_motion_word;
pub use arc::{Arc, ArcTolerance};
pub use cycle::Cycle;
pub use decimal_point::{ANGLE_INCREMENT, is_integer_program, length_increment, oversized_point, undecided_point};
pub use diagnostic::{Diagnostic, Severity, render_merged};
pub use dialect::{ArcCentres, DecimalPoint, Dialect, Macros, Options};
pub use dialogue::renumber;
pub use edit::{Edits, edit, edit_blocks};
pub use error::GcodeError;
pub use evaluate::{Files, evaluate, expand};
pub use foreign::{Foreign, recognise};
pub use format::{append_number, format_angle, format_coordinate, format_number};
pub use interpret::{Reader, Resume, interpret, interpret_part};
pub use modal::{CutterCompensation, Distance, FeedMode, Modal, PathMode, ReturnLevel, ToolLength, Units, WorkOffset};
pub use passive::PassiveCodes;
pub use plane::Plane;
pub use position::{Axis, Position};
pub use program::{Block, Language, Program, parse, parse_in};
pub use rotation::Rotation;
pub use toolpath::{Feed, Fixed, Move, MoveKind, MoveWords, Shiftable, Toolpath};
pub use word::{Span, Word, WordKind};
