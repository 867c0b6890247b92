//! `precomp` makes a CNC machine cut the path that its program asks for, in the first run.
//!
//! The walk, from bytes to bytes: [`gcode::parse`] reads a program, [`pipeline::Part::read`] interprets and plans it, [`learning::compensate`]
//! learns a reference on the model of the machine, [`pipeline::refit()`] writes it back, [`pipeline::verify()`] reads the output again.

pub mod adaptation;
pub mod cli;
mod commands;
pub mod comparison;
mod control;
pub mod cross_fit;
pub mod evaluate;
mod excitation;
pub mod expectation;
pub mod feeds;
mod files;
pub mod input;
pub mod learning;
mod left_out;
mod limits_from_log;
pub mod measurement;
mod output;
pub mod pipeline;
pub mod programmed;
mod progress;
pub mod recording;
mod report;
pub mod training_run;
mod travel;
pub mod units;
