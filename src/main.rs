//! The `precomp` command: arguments, files, printing, progress and the report around the library [`pipeline`].

mod args;
mod cli;
mod commands;
mod files;
mod numbers;
mod output;
mod output_format;
mod print;
mod progress;
mod read;
mod report;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
