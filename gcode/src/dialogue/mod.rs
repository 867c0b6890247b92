//! Heidenhain dialogue (Klartext, `.h`): split without loss, read into the same moves as RS-274.
//!
//! Straight lines and circles are interpreted. Other blocks either cannot change where or how the tool moves, or open a section in which every
//! move is left alone. Source: HEIDENHAIN TNC 640, User's Manual for Conversational Programming.

mod block;
mod circle;
mod contour;
mod cycles;
mod flow;
mod functions;
pub(crate) mod lexer;
mod parameters;
mod path;
mod renumber;
mod rotations;
mod sections;
mod state;
mod statements;
mod target;
mod words;

use block::{Block, continues};
use flow::first_uncertain;
use sections::Cause;
use state::Interpreter;

pub use renumber::renumber;

use crate::dialect::Options;
use crate::error::GcodeError;
use crate::program::Program;
use crate::toolpath::Toolpath;

/// Reads a dialogue program into moves.
pub(crate) fn interpret(program: &Program, options: &Options) -> Result<Toolpath, GcodeError> {
    let mut state = Interpreter::new(program, options);
    let uncertain = first_uncertain(program);
    for index in 0..program.blocks().len() {
        state.block = index;
        if let Some(uncertain) = uncertain.filter(|uncertain| uncertain.from == index) {
            let what = "blocks may run again or in another order through this call or jump";
            let help = "write the program without calls, repeats and jumps, as CAM systems do on request";
            state.open(Cause::Lasting, uncertain.cause, what, Some(help));
            state.lose_place();
        }
        let block = Block::of(program, index);
        let is_skipped = block.is_optional && options.block_delete == Some(true);
        if !block.words.is_empty() && !is_skipped {
            state.note_optional(&block);
            state.execute(&block, continues(program, index));
            state.pair_turned();
        }
        if state.ended || state.report.is_full() {
            break;
        }
    }
    let (refused, diagnostics) = (state.report.has_errors(), state.report.into_diagnostics());
    if refused {
        return Err(GcodeError::Refused { diagnostics });
    }
    Ok(Toolpath { moves: state.moves, modals: state.modals, warnings: diagnostics })
}
