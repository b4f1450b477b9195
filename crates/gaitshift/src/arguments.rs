//! The command line: every option with its unit, default and range.

mod motions;
mod showing;
mod training;
mod values;

pub use motions::{
    CompareArguments, DemoArguments, DisturbanceName, EvaluateArguments, LearnerName,
    ReportArguments, ReproduceArguments, StressArguments, TransitionArguments,
};
pub use showing::{
    AnalyseArguments, ExportArguments, ExportFormat, RenderArguments, ViewArguments,
};
pub use training::{HardenArguments, SweepArguments, TrainArguments};
pub use values::{distinct, distinct_commands, distinct_paths};

use clap::builder::styling::{AnsiColor, Styles};
use clap::{Args, Parser, Subcommand};
use std::path::{Path, PathBuf};

const STYLES: Styles = Styles::styled()
    .header(AnsiColor::Green.on_default().bold())
    .usage(AnsiColor::Green.on_default().bold())
    .literal(AnsiColor::Cyan.on_default().bold())
    .placeholder(AnsiColor::Cyan.on_default());

/// A biped with passive hips that walks, runs and changes gait on one command.
///
/// One neural controller drives two linear actuators, one along each leg; the hips are passive. Its only
/// command is ω_v (in s/m), the weight of forward speed in the reward it was trained with: at 0 the body
/// walks, at 3 it runs, and in between it changes gait.
#[derive(Debug, Parser)]
#[command(
    name = "gaitshift",
    version,
    styles = STYLES,
    arg_required_else_help = true,
    max_term_width = 100,
    after_long_help = "\
Start here:
  gaitshift demo                    see the shipped controller walk, run and change gait
  gaitshift view                    move its slider yourself, in the browser
  gaitshift evaluate                measure it over the whole range of its command
  gaitshift train                   train such a controller from scratch
  gaitshift reproduce --quick       the papers' claims beside its results, on one page

Units are SI, angles in radians. Results go to standard output, progress and errors to standard error.
Exit codes: 0 done, 1 failed or a criterion not met, 2 bad input, 130 interrupted."
)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do. Each command's help stands with its arguments.
#[derive(Debug, Subcommand)]
pub enum Command {
    Demo(DemoArguments),
    Train(TrainArguments),
    Sweep(SweepArguments),
    Harden(HardenArguments),
    Evaluate(EvaluateArguments),
    Transition(TransitionArguments),
    Stress(StressArguments),
    Compare(CompareArguments),
    Reproduce(ReproduceArguments),
    Report(ReportArguments),
    Render(RenderArguments),
    View(ViewArguments),
    Analyse(AnalyseArguments),
    Export(ExportArguments),
    Completions(CompletionsArguments),
    Manual(ManualArguments),
}

/// Which controller.
#[derive(Debug, Default, Args)]
pub struct ControllerArguments {
    /// Controller file, a run's folder (its best controller), or `shipped` or `robust`, which come with the program
    /// [default: shipped]
    #[arg(long, value_name = "FILE|DIR|NAME")]
    pub controller: Option<PathBuf>,
}

/// What moves.
#[derive(Debug, Default, Args)]
pub struct SubjectArguments {
    /// Which controller.
    #[command(flatten)]
    pub which: ControllerArguments,

    /// What differs from what the controller was trained on.
    #[command(flatten)]
    pub changes: ChangeArguments,
}

/// What differs from the body and the task that a controller was trained on.
#[derive(Debug, Default, Args)]
pub struct ChangeArguments {
    /// TOML file that changes the body, e.g. with the line `friction = 0.6`
    ///
    /// Keys are those of the table `[body]` in a run's config.toml, alone or under that table. Keys that the
    /// file leaves out keep the values of the controller's training; its other tables, such as `[task]`, are not used.
    #[arg(long, value_name = "FILE.toml")]
    pub body: Option<PathBuf>,

    /// Change one value, e.g. --set friction=0.6; may be given several times
    ///
    /// Keys are those of `[body]` in a run's config.toml, or, with the prefix `task.`, those of `[task]`,
    /// e.g. --set task.termination.pitch_limit_rad=1.0.
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// On how many threads a command works.
#[derive(Debug, Args)]
pub struct ThreadArguments {
    /// Threads, 1 to 256 [default: the processors]; the result does not depend on them
    #[arg(long, value_name = "N", allow_negative_numbers = true,
          value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads: Option<u16>,
}

/// Processors of this machine: on so many threads a command works, unless said otherwise.
pub fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

impl ThreadArguments {
    /// How many.
    pub fn count(&self) -> usize {
        self.threads.map_or_else(processors, usize::from)
    }
}

/// What goes to standard output.
#[derive(Debug, Args)]
pub struct PrintArguments {
    /// Print the result as one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

impl PrintArguments {
    /// The folder of --out; without that option `default`, but none where JSON is printed.
    pub fn folder(&self, out: Option<&Path>, default: &str) -> Option<PathBuf> {
        match out {
            Some(folder) => Some(folder.to_owned()),
            None => (!self.json).then(|| PathBuf::from(default)),
        }
    }
}

/// Prints a shell completion script
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  gaitshift completions bash > ~/.local/share/bash-completion/completions/gaitshift
  gaitshift completions zsh > ~/.zfunc/_gaitshift     # with `fpath+=~/.zfunc` before `compinit`
  gaitshift completions fish > ~/.config/fish/completions/gaitshift.fish")]
pub struct CompletionsArguments {
    /// The shell
    #[arg(value_name = "SHELL")]
    pub shell: clap_complete::Shell,
}

/// Prints the manual page, or writes one for every command.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  gaitshift manual | man -l -
  gaitshift manual --out ~/.local/share/man/man1      # then: man gaitshift, man gaitshift-train")]
pub struct ManualArguments {
    /// Folder for the pages of the program and of each command
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}
