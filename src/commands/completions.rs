//! `precomp completions` and `precomp man`: what shells and `man` want to know of the command line.

use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, Command};
use clap_complete::{Shell, generate};

use crate::files::Files;
use crate::output::Outputs;

/// Print the completions of a shell
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  precomp completions bash > ~/.local/share/bash-completion/completions/precomp
  precomp completions zsh > ~/.zfunc/_precomp
  precomp completions fish > ~/.config/fish/completions/precomp.fish")]
pub struct Completions {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

impl Completions {
    pub fn run(&self, mut command: Command) {
        let name = command.get_name().to_owned();
        let mut text = Vec::new();
        generate(self.shell, &mut command, name, &mut text);
        // A closed pipe takes nothing more.
        let _ = std::io::Write::write_all(&mut std::io::stdout(), &text);
    }
}

/// Write the manual pages into a folder
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  precomp man ~/.local/share/man/man1 && man precomp-compensate")]
pub struct Man {
    /// The folder; it is made where it is missing
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

impl Man {
    pub fn files(&self) -> Files {
        Files::default().writes_in("DIR", &*self.folder)
    }

    pub fn run(&self, mut command: Command) -> Result<()> {
        command.build();
        let mut outputs = Outputs::default();
        let pages = std::iter::once(&command).chain(command.get_subcommands().filter(|command| command.get_name() != "help"));
        for page in pages {
            let name = page.get_display_name().unwrap_or(page.get_name()).to_owned();
            let mut text = Vec::new();
            clap_mangen::Man::new(page.clone()).render(&mut text)?;
            outputs.add(&self.folder.join(format!("{name}.1")), text);
        }
        outputs.write(None, &serde_json::Value::Null)
    }
}
