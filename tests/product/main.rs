//! The whole product, run by its command line.

mod cli;
mod common;
mod measure;
mod refine;
mod story;
