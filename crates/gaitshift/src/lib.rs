//! The program `gaitshift`: train a passive-hipped biped to walk, run and change gait on one command,
//! measure what a controller does, and look at it.
//!
//! [`run`] parses and dispatches; each command is a module that prepares what its user asked for, calls
//! the libraries and says what came out. Results go to standard output, everything else to standard
//! error. A library, because the Python package brings the program along.

mod analyse;
mod arguments;
mod check;
mod compare;
mod completions;
mod demo;
mod disturb;
mod evaluate;
mod export;
mod failure;
mod gaits;
mod harden;
mod manual;
mod motion;
mod output;
mod progress;
mod render;
mod report;
mod reproduce;
mod spread;
mod stress;
mod sweep;
mod train;
mod transition;
mod unseen;
mod view;

pub use gaitshift_report::set_program_file;

use arguments::{Arguments, Command, HardenArguments, TrainArguments};
use clap::Parser;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use gaitshift_experiment::{Experiment, portable_command, quoted};
use std::ffi::OsString;
use std::path::Path;

/// What was probably meant by an argument that is refused.
fn tip(error: &clap::Error, command_line: &[OsString]) -> Option<String> {
    let Some(ContextValue::String(argument)) = error.get(ContextKind::InvalidArg) else {
        return None;
    };
    let key = argument.trim_start_matches('-').replace('-', "_");
    if Experiment::default()
        .keys()
        .contains(&format!("body.{key}"))
    {
        return Some(format!(
            "tip: a value of the body is changed with --set {key}=VALUE"
        ));
    }
    let is_unknown = error.kind() == ErrorKind::UnknownArgument;
    if is_unknown && Path::new(argument).exists() {
        return Some(format!(
            "tip: a controller or the folder of a run is given with --controller {}",
            quoted(argument)
        ));
    }
    let exports = command_line.get(1).is_some_and(|word| word == "export");
    (exports && ["--push", "--noise"].contains(&argument.as_str())).then(|| {
        "tip: a model holds neither pushes nor noise; the script that steps it applies them"
            .to_owned()
    })
}

/// Runs the program with its command line, the first argument being its own name, and gives the exit code: 0 done, 1 failed,
/// 2 bad input, 130 interrupted. Catches Ctrl-C in commands that can be stopped halfway.
pub fn run(command_line: impl IntoIterator<Item = OsString>) -> u8 {
    let command_line: Vec<OsString> = command_line.into_iter().collect();
    let mut arguments = match Arguments::try_parse_from(&command_line) {
        Ok(arguments) => arguments,
        Err(mut error) => {
            // The usage that clap makes up for an error joins options that exclude each other; --help has the whole one.
            if error.use_stderr()
                && error.kind() != ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
            {
                error.remove(ContextKind::Usage);
            }
            // No command takes an option's name as a value.
            if error.kind() == ErrorKind::UnknownArgument {
                error.remove(ContextKind::Suggested);
            }
            // If the stream is closed, nobody is there to be told.
            let _ = error.print();
            if let Some(tip) = tip(&error, &command_line) {
                output::note(&tip);
            }
            return u8::try_from(error.exit_code()).unwrap_or(2);
        }
    };
    if let Command::Train(TrainArguments { command, .. })
    | Command::Harden(HardenArguments { command, .. }) = &mut arguments.command
    {
        *command = portable_command(command_line.into_iter().skip(1));
    }
    let result = match arguments.command {
        Command::Demo(arguments) => demo::run(&arguments),
        Command::Train(arguments) if arguments.check => check::run(&arguments),
        Command::Train(arguments) => train::run(&arguments),
        Command::Sweep(arguments) => sweep::run(&arguments),
        Command::Harden(arguments) => harden::run(&arguments),
        Command::Evaluate(arguments) => evaluate::run(&arguments),
        Command::Transition(arguments) => transition::run(&arguments),
        Command::Stress(arguments) => stress::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Reproduce(arguments) => reproduce::run(&arguments),
        Command::Report(arguments) => report::run(&arguments),
        Command::Render(arguments) => render::run(&arguments),
        Command::View(arguments) => view::run(&arguments),
        Command::Analyse(arguments) => analyse::run(&arguments),
        Command::Export(arguments) => export::run(&arguments),
        Command::Completions(arguments) => completions::run(&arguments),
        Command::Manual(arguments) => manual::run(&arguments),
    };
    match result {
        Ok(()) => 0,
        Err(failure) => failure.report(),
    }
}
