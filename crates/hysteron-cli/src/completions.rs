//! `hysteron completions`: completion script for a shell.

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use crate::{Cli, console, failure::Failure};

/// Print a completion script for a shell.
#[derive(Args)]
#[command(
    after_help = "Example: hysteron completions bash > ~/.local/share/bash-completion/completions/hysteron"
)]
pub struct Completions {
    /// The shell
    shell: Shell,
}

impl Completions {
    pub fn run(&self) -> Result<(), Failure> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::command(), "hysteron", &mut script);
        console::result(&String::from_utf8_lossy(&script))
    }
}
