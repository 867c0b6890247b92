//! R parameters, variables, branches, loops and subprograms of SINUMERIK programs.
//!
//! Source: SINUMERIK "NC programming", "Flexible NC programming" (variables, arithmetic, jumps, program section repetition, check structures)
//! and "Subprogram technique". Not evaluated: macros (DEFINE), indirect calls with a variable, arrays of several values in one assignment,
//! strings, frames as values, synchronized actions.

mod arithmetic;
mod blocks;
mod calls;
mod expression;
mod flat;
mod jumps;
mod perhaps;
mod run;
mod source;
mod statement;
mod variables;

pub(super) use run::Run;
