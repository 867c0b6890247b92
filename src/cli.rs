//! The command line.

use std::ffi::OsString;

use anyhow::Result;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::commands;
use crate::files::Files;
use crate::output::{REFUSED, Usage, check_printed, text};

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
    Check(commands::check::Check),
    Train(commands::train::Train),
    Predict(commands::predict::Predict),
    Compensate(commands::compensate::Compensate),
    Measure(commands::measure::Measure),
    Diagnose(commands::diagnose::Diagnose),
    Refine(commands::refine::Refine),
    Compare(commands::compare::Compare),
    Reproduce(commands::reproduce::Reproduce),
    #[cfg(feature = "fleet")]
    Fleet(commands::fleet::Fleet),
    Completions(commands::completions::Completions),
    Man(commands::completions::Man),
}

/// Answer to `precomp fleet` in a build without it.
const NO_FLEET: &str =
    "this build is without `precomp fleet`; one with it comes from `cargo install --path . --locked --features fleet`";

impl Command {
    /// What it reads and writes.
    fn files(&self) -> Files {
        match self {
            Self::Demo(command) => command.files(),
            Self::Init(command) => command.files(),
            Self::Excite(command) => command.files(),
            Self::Simulate(command) => command.files(),
            Self::Check(command) => command.files(),
            Self::Train(command) => command.files(),
            Self::Predict(command) => command.files(),
            Self::Compensate(command) => command.files(),
            Self::Measure(command) => command.files(),
            Self::Diagnose(command) => command.files(),
            Self::Refine(command) => command.files(),
            Self::Compare(command) => command.files(),
            Self::Reproduce(command) => command.files(),
            #[cfg(feature = "fleet")]
            Self::Fleet(command) => command.files(),
            Self::Completions(_) => Files::default(),
            Self::Man(command) => command.files(),
        }
    }

    fn run(&self) -> Result<()> {
        match self {
            Self::Demo(command) => command.run(),
            Self::Init(command) => command.run(),
            Self::Excite(command) => command.run(),
            Self::Simulate(command) => command.run(),
            Self::Check(command) => command.run(),
            Self::Train(command) => command.run(),
            Self::Predict(command) => command.run(),
            Self::Compensate(command) => command.run(),
            Self::Measure(command) => command.run(),
            Self::Diagnose(command) => command.run(),
            Self::Refine(command) => command.run(),
            Self::Compare(command) => command.run(),
            Self::Reproduce(command) => command.run(),
            #[cfg(feature = "fleet")]
            Self::Fleet(command) => command.run(),
            Self::Completions(command) => {
                command.run(Cli::command());
                Ok(())
            }
            Self::Man(command) => command.run(Cli::command()),
        }
    }
}

/// Runs the command line `arguments`, of which the first is the name of the program, and returns its exit status: 0 done, 1 refused, 2 error
/// in use.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    models::keep_memory();
    // A value such as `-1` is no option: it is refused with the option's range.
    let command = Cli::command().mut_subcommands(|command| command.allow_negative_numbers(true));
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    if cfg!(not(feature = "fleet")) && arguments.get(1).is_some_and(|name| name == "fleet") {
        eprintln!("error: {NO_FLEET}");
        return MISUSED;
    }
    let cli = match command.try_get_matches_from(arguments).and_then(|matches| Cli::from_arg_matches(&matches)) {
        Ok(cli) => cli,
        Err(error) => {
            // Nothing is left to tell if even this cannot be printed.
            let _ = error.print();
            return if error.use_stderr() { MISUSED } else { 0 };
        }
    };
    let result = cli.command.files().check().and_then(|()| cli.command.run()).and_then(|()| check_printed());
    match result {
        Ok(()) => 0,
        Err(error) => {
            eprintln!("error: {}", text(&error));
            status(&error)
        }
    }
}

/// The exit status after an error in use.
const MISUSED: u8 = 2;

/// The exit status after `error`: 1 where input or model are not fit for the job, 2 after an error in use.
#[must_use]
pub fn status(error: &anyhow::Error) -> u8 {
    let misused = matches!(error.downcast_ref(), Some(pipeline::Error::ToolLengthOfTurningMachine));
    if misused || error.is::<Usage>() { MISUSED } else { REFUSED }
}
