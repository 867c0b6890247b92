//! The whole product, run by its command line.

mod cli;
mod common;
mod feeds;
mod measure;
mod refine;
mod reproduce;
mod story;
