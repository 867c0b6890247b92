//! The `precomp` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(precomp::main(std::env::args_os()))
}
