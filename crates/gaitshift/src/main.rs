//! The program `gaitshift`: train a passive-hipped biped to walk, run and change gait on one command,
//! measure what a controller does, and look at it.
//!
//! `main` parses and dispatches; each command is a module that prepares what its user asked for, calls
//! the libraries and says what came out. Results go to standard output, everything else to standard
//! error. Exit codes: 0 done, 1 failed, 2 bad input, 130 interrupted.

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
mod manual;
mod motion;
mod output;
mod progress;
mod render;
mod spread;
mod stress;
mod sweep;
mod train;
mod transition;
mod view;

use arguments::{Arguments, Command};
use clap::Parser;
use clap::error::{ContextKind, ErrorKind};
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(mut error) => {
            // The usage that clap makes up for an error joins options that exclude each other; --help has the whole one.
            if error.use_stderr()
                && error.kind() != ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
            {
                error.remove(ContextKind::Usage);
            }
            error.exit()
        }
    };
    let result = match arguments.command {
        Command::Demo(arguments) => demo::run(&arguments),
        Command::Train(arguments) if arguments.check => check::run(&arguments),
        Command::Train(arguments) => train::run(&arguments),
        Command::Sweep(arguments) => sweep::run(&arguments),
        Command::Evaluate(arguments) => evaluate::run(&arguments),
        Command::Transition(arguments) => transition::run(&arguments),
        Command::Stress(arguments) => stress::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Render(arguments) => render::run(&arguments),
        Command::View(arguments) => view::run(&arguments),
        Command::Analyse(arguments) => analyse::run(&arguments),
        Command::Export(arguments) => export::run(&arguments),
        Command::Completions(arguments) => completions::run(&arguments),
        Command::Manual(arguments) => manual::run(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
