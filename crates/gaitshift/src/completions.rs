//! `gaitshift completions`: what a shell completes.

use crate::arguments::{Arguments, CompletionsArguments};
use crate::failure::Failure;
use clap::CommandFactory;
use std::io::Write;

/// Runs the command.
pub fn run(arguments: &CompletionsArguments) -> Result<(), Failure> {
    let mut command = Arguments::command();
    // Into memory first: the generator panics where its output is closed.
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, "gaitshift", &mut script);
    Ok(std::io::stdout().write_all(&script)?)
}
