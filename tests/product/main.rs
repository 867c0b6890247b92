//! The whole product, run by its command line.

mod adaptation;
mod cli;
mod common;
mod comparison;
mod dialogue;
mod dwells;
mod expand;
mod feeds;
mod files;
mod five_axis;
mod marked;
mod measure;
mod modes;
mod placed;
mod points;
mod real_machine;
mod recorded;
mod refine;
mod reproduce;
mod rows;
mod sinumerik;
mod story;
mod train;
mod travel;
mod units;
mod wrong_input;
