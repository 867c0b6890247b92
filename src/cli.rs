//! The command line.

use std::process::ExitCode;

use anyhow::Result;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::commands;
use crate::files::Files;
use crate::output::{REFUSED, Usage};

/// Learns how a CNC machine's axes lag, stick and snap back, and shifts a part program's points the other way before its first run.
#[derive(Debug, Parser)]
#[command(name = "precomp", version, max_term_width = 120, propagate_version = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Demo(commands::demo::Demo),
    Init(commands::init::Init),
    Excite(commands::excite::Excite),
    Simulate(commands::simulate::Simulate),
    Train(commands::train::Train),
    Predict(commands::predict::Predict),
    Compensate(commands::compensate::Compensate),
    Measure(commands::measure::Measure),
    Diagnose(commands::diagnose::Diagnose),
    Refine(commands::refine::Refine),
    Compare(commands::compare::Compare),
    Reproduce(commands::reproduce::Reproduce),
}

impl Command {
    /// What it reads and writes.
    fn files(&self) -> Files {
        match self {
            Self::Demo(command) => command.files(),
            Self::Init(command) => command.files(),
            Self::Excite(command) => command.files(),
            Self::Simulate(command) => command.files(),
            Self::Train(command) => command.files(),
            Self::Predict(command) => command.files(),
            Self::Compensate(command) => command.files(),
            Self::Measure(command) => command.files(),
            Self::Diagnose(command) => command.files(),
            Self::Refine(command) => command.files(),
            Self::Compare(command) => command.files(),
            Self::Reproduce(command) => command.files(),
        }
    }

    fn run(&self) -> Result<()> {
        match self {
            Self::Demo(command) => command.run(),
            Self::Init(command) => command.run(),
            Self::Excite(command) => command.run(),
            Self::Simulate(command) => command.run(),
            Self::Train(command) => command.run(),
            Self::Predict(command) => command.run(),
            Self::Compensate(command) => command.run(),
            Self::Measure(command) => command.run(),
            Self::Diagnose(command) => command.run(),
            Self::Refine(command) => command.run(),
            Self::Compare(command) => command.run(),
            Self::Reproduce(command) => command.run(),
        }
    }
}

/// Runs the command line of this process and returns its exit status: 0 done, 1 refused, 2 error in use.
#[must_use]
pub fn main() -> ExitCode {
    models::keep_memory();
    // A value such as `-1` is no option: it is refused with the option's range.
    let command = Cli::command().mut_subcommands(|command| command.allow_negative_numbers(true));
    let cli = match command.try_get_matches().and_then(|matches| Cli::from_arg_matches(&matches)) {
        Ok(cli) => cli,
        Err(error) => {
            let code = if error.use_stderr() { 2 } else { 0 };
            // Nothing is left to tell if even this cannot be printed.
            let _ = error.print();
            return ExitCode::from(code);
        }
    };
    let result = cli.command.files().check().and_then(|()| cli.command.run());
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let text = format!("{error:#}");
            eprintln!("error: {}", text.strip_prefix("error: ").unwrap_or(&text));
            let misused = matches!(error.downcast_ref(), Some(pipeline::Error::ToolLengthOfTurningMachine));
            ExitCode::from(if misused || error.is::<Usage>() { 2 } else { REFUSED })
        }
    }
}
