//! The whole product, run by its command line.

mod cli;
mod common;
mod comparison;
mod dwells;
mod feeds;
mod five_axis;
mod measure;
mod modes;
mod recorded;
mod refine;
mod reproduce;
mod rows;
mod story;
