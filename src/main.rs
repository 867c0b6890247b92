//! The `precomp` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    precomp::cli::main()
}
