//! Arguments of the commands that train.

use super::values::{Commands, Part, Seeds, commands, impulse, part, seed, seeds, step_height};
use super::{ControllerArguments, PrintArguments, ThreadArguments};
use clap::Args;
use std::path::PathBuf;

/// Trains a controller from scratch with Soft Actor-Critic.
///
/// A run is described by one TOML file: body, task, curriculum, learner. Recipes that come with the program:
/// `fast` (the default), `robust` (the same, then other bodies, ground, pushes and delays), `paper` (schedule
/// and settings of the paper, 10 million steps) and `journal` (those of its journal version). A file of your own needs
/// only the differences from the recipe or file that its key `base` names (`paper` if it has no `base`); an unknown key is
/// an error.
///
/// Every 250,000 steps (`journal`: 50,000) the controller is evaluated without noise at all commands and changes of gait,
/// so that you see when it first walks and runs. Ctrl-C writes a checkpoint and stops; so do SIGTERM and
/// SIGUSR1, with which batch systems end a job.
#[derive(Debug, Args)]
#[command(after_long_help = "\
The folder of a run:
  config.toml               every setting of the run
  controller.safetensors    the best controller so far; needs no other file
  controller-accepted.safetensors  the first that met every criterion, if there is one
  controller-last.safetensors      the one at the last checkpoint
  controller-walk.safetensors      the walk that later phases rehearse so that it is kept, if there are any
  controllers/              every controller that was evaluated, by its step
  metrics.csv, events.out.tfevents.*   progress of training, also for `tensorboard --logdir runs`
  episodes.csv, returns.svg, .png      every episode, and their returns as a figure
  evaluations.jsonl         every evaluation in full, one JSON object per line
  checkpoint/               everything needed to resume; the result is the same to the bit
  report.json               how the run ended

Examples:
  gaitshift train
  gaitshift train paper --seed 3 --out runs/paper-seed-3
  gaitshift train my-body.toml --stop-when-accepted
  gaitshift train --seeds 1-5
  gaitshift train --check my-body.toml
  gaitshift train --set training.environments=16
  gaitshift train --resume runs/fast-1

where my-body.toml is, for instance:
  name = \"heavy feet\"
  base = \"fast\"
  [body]
  foot_mass_kg = 2.0")]
pub struct TrainArguments {
    /// The command line that asks for it, without what belongs to one machine.
    #[arg(skip)]
    pub command: String,

    /// Recipe (`fast`, `robust`, `paper`, `journal`) or TOML file
    #[arg(value_name = "RECIPE|FILE.toml", default_value = "fast")]
    pub experiment: String,

    /// Seed of everything random [default: the recipe's]; the same seed gives the same run
    #[arg(
        long,
        value_name = "N",
        allow_hyphen_values = true,
        value_parser = seed,
        conflicts_with = "resume"
    )]
    pub seed: Option<u64>,

    /// Train with each of these seeds, one run after the other, e.g. 1-5 or 1,2,7
    ///
    /// Folders are runs/NAME-SEED, with --out DIR the folders DIR/NAME-SEED. Ctrl-C stops the current run and
    /// starts no other. At the end a table gives each run's result, with mean and standard deviation.
    #[arg(long, value_name = "LIST", conflicts_with_all = ["seed", "resume"], allow_hyphen_values = true,
          value_delimiter = ',', value_parser = seeds)]
    pub seeds: Vec<Seeds>,

    /// Folder of the run; must not contain a run yet [default: runs/NAME-SEED]
    #[arg(long, value_name = "DIR", conflicts_with = "resume")]
    pub out: Option<PathBuf>,

    /// Change one value of the experiment, e.g. --set body.friction=0.6; may be given several times
    #[arg(long, value_name = "KEY=VALUE", conflicts_with = "resume")]
    pub set: Vec<String>,

    /// Report what would be trained, how long it takes, and likely mistakes; train nothing
    ///
    /// Prints the phases in steps and minutes (measured by a few seconds of training), every value that
    /// differs from the recipe or file of `base`, and warnings. Nothing is written. With --seeds the time is that
    /// of all runs too.
    #[arg(long, conflicts_with_all = ["resume", "out", "steps", "view"])]
    pub check: bool,

    /// Resume the run in this folder from its last checkpoint
    ///
    /// It ends with the same controller as if it had not been stopped. What was edited in its config.toml meanwhile holds
    /// from there on; an edit of what the checkpoint fixes, such as seed, body, learner or criteria, is an error.
    #[arg(long, value_name = "DIR", conflicts_with = "experiment")]
    pub resume: Option<PathBuf>,

    /// Threads of the learner, 1 to 256 [default: the recipe's, or the run's]; they do not change the result
    #[arg(long, value_name = "N", allow_negative_numbers = true,
          value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads: Option<u16>,

    /// Stop after about this many steps, with a checkpoint to resume from [default: the end of the last phase]
    ///
    /// A step is one control period of one simulated body. The phases of the training stay as they are. Checked every 2000
    /// steps.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(1..))]
    pub steps: Option<u64>,

    /// Show the run in the browser while it trains, as `gaitshift view RUN` does
    #[arg(long)]
    pub view: bool,

    /// Stop at the first evaluation that meets every criterion (`gaitshift evaluate --criteria`)
    ///
    /// Where phases randomize, only evaluations from the first such phase on count.
    #[arg(long, conflicts_with = "resume")]
    pub stop_when_accepted: bool,

    /// What is printed.
    #[command(flatten)]
    pub print: PrintArguments,
}

/// Trains many runs from one file: an experiment, what varies, the seeds.
///
/// What varies is a list of variants, the values of some keys in every combination, or settings drawn at
/// random from ranges. Each is trained with each seed, in a folder of its own. Ctrl-C writes checkpoints and
/// stops; the same command continues from them, and finished runs are not repeated. At the end, and with
/// --table at any time, a table gives for each variant the results over its seeds, with intervals, and the
/// difference from the first variant (settings drawn at random have none; the best stand first): table.md,
/// table.json and a figure of all runs, table.svg and .png, in the sweep's folder. For their learning curves
/// give the runs' folders to `gaitshift compare`.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  gaitshift sweep friction.toml --dry-run
  gaitshift sweep friction.toml --jobs 2
  gaitshift sweep friction.toml --table
  gaitshift sweep friction.toml --part 2/4      # a quarter of it, on one of four machines

where friction.toml is, for instance:
  name = \"friction\"
  experiment = \"fast\"         # the recipe of every variant
  seeds = [1, 2, 3]
  [set.learner]               # differs from the recipe in every variant
  threads = 1

  [[variants]]                # the first one is the reference
  name = \"rubber\"

  [[variants]]
  name = \"ice\"
  reason = \"does it still walk where feet slip?\"
  set.body = { friction = 0.3 }

Instead of [[variants]], the values of some keys in every combination:
  [vary]
  learner.learning_rate = [3e-4, 1e-3]
  body.friction = [0.3, 0.6, 1.0]

or, with a line above the first table, settings drawn at random:
  random = { settings = 20, seed = 1 }
  [vary]
  learner.learning_rate = { from = 1e-4, to = 1e-3, scale = \"log\" }
  learner.n_step = { from = 1, to = 5 }         # whole numbers
  body.friction = [0.3, 0.6, 1.0]")]
pub struct SweepArguments {
    /// The sweep: experiment, seeds, what varies
    #[arg(value_name = "FILE.toml")]
    pub file: PathBuf,

    /// Folder of the sweep's runs and table [default: runs/NAME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Runs at a time, 1 to 256 [default: the processors, divided by the threads of a run]
    #[arg(long, value_name = "N", allow_negative_numbers = true, conflicts_with = "table",
          value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: Option<u16>,

    /// Do only every N-th run, starting with the K-th, so that several machines that share the folder do a sweep
    /// together
    ///
    /// With --table the table has all runs.
    #[arg(long, value_name = "K/N", value_parser = part, conflicts_with = "dry_run")]
    pub part: Option<Part>,

    /// Only report what would be run and how long it takes on this machine
    #[arg(long, conflicts_with = "table")]
    pub dry_run: bool,

    /// Only write and print the table of the results so far
    #[arg(long)]
    pub table: bool,

    /// What is printed.
    #[command(flatten)]
    pub print: PrintArguments,
}

/// Teaches a controller to withstand pushes that knock it over, and to get over steps.
///
/// In every round its motions are pushed at random, and with --steps-up others meet a step. Where the body falls, or does not
/// get over the step, a search tries corrections to the actuators' commands until one helps (the cross-entropy method, with
/// 96 simulated variants at a time). The controller is then fitted to the corrected motions, and to what it did
/// before in undisturbed and disturbed motions, so that it keeps its gaits. No reward is used. A round takes half a minute to
/// a few minutes.
///
/// A push is withstood if the body stays up for 8 s, a step if the hip gets 3 m beyond its face. Each round's controller is
/// tried on the same 128 other pushes, on 128 steps if there are any, and in 128 motions that are weakly disturbed (noise,
/// delays, slopes, steps, weak pushes); the best is the one that withstands most of all these and
/// meets at least as many of the default 39 criteria as the controller did at the start. Ctrl-C stops after the round. The same command
/// continues, also with more --rounds; the result is the same as without a stop.
#[derive(Debug, Args)]
#[command(after_long_help = "\
The folder:
  controller.safetensors       the best controller so far; needs no other file
  controller-last.safetensors  that of the last round
  rounds.jsonl                 every round, one JSON object per line
  state.safetensors            everything needed to go on

With --json, standard output is {\"folder\", \"controller\", \"plan\", \"rounds\": [{\"round\", \"pushes\", \"steps_up\",
\"weak_up\", \"weak_compared\", \"met\", \"criteria\", \"best\", ...}]}, with \"pushes\" and \"steps_up\" {\"met\", \"alone\", \"found\", \"withstood\", \"compared\"}; round 0 is the
controller as it was.

Examples:
  gaitshift harden --controller robust
  gaitshift harden --controller runs/fast-1 --omega-v 0,1,2,3 --impulse 9:20,-20:-9 --out out/harden-fast-1
  gaitshift harden --controller robust --steps-up 160
  gaitshift stress --controller out/harden")]
pub struct HardenArguments {
    /// The command line that asks for it, without what belongs to one machine.
    #[arg(skip)]
    pub command: String,

    /// Which controller.
    #[command(flatten)]
    pub which: ControllerArguments,

    /// Commands ω_v in s/m at which it is pushed, separated by commas, each from -100 to 100; FIRST:LAST:STEP is a range
    /// [default: 0]
    #[arg(long, value_name = "LIST", value_delimiter = ',', allow_hyphen_values = true, value_parser = commands)]
    pub omega_v: Vec<Commands>,

    /// Ranges of the push's impulse in N s, -1000 to 1000, FROM:TO separated by commas, all equally likely; negative is
    /// backward
    /// [default: 20:36,-36:-20]
    ///
    /// A push is a force on the hip for 0.1 s, so that 30 N s are 300 N.
    #[arg(long, value_name = "LIST", value_delimiter = ',', allow_hyphen_values = true, value_parser = impulse)]
    pub impulse: Vec<[f64; 2]>,

    /// Rounds in all, those of earlier calls included
    #[arg(
        long,
        value_name = "N",
        default_value_t = 30,
        allow_negative_numbers = true
    )]
    pub rounds: usize,

    /// Pushes in a round, 1 to 10000
    #[arg(
        long,
        value_name = "N",
        default_value_t = 80,
        allow_negative_numbers = true
    )]
    pub pushes: usize,

    /// Steps up in a round, 0 to 10000
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        allow_negative_numbers = true
    )]
    pub steps_up: usize,

    /// Ranges of a step's height in m, 0.001 to 0.2, FROM:TO separated by commas, all equally likely
    /// [default: 0.005:0.035]
    ///
    /// Its face is 0.4 to 1.4 m before the hip. Corrections begin when a foot first touches the step: the controller does not
    /// see it.
    #[arg(long, value_name = "LIST", value_delimiter = ',', allow_hyphen_values = true, value_parser = step_height, requires = "steps_up")]
    pub step_height: Vec<[f64; 2]>,

    /// Commands ω_v in s/m at which it meets steps, as in --omega-v [default: 0]
    #[arg(long, value_name = "LIST", value_delimiter = ',', allow_hyphen_values = true, value_parser = commands, requires = "steps_up")]
    pub step_omega_v: Vec<Commands>,

    /// Units that every hidden layer of the policy is to have at least, 0 to 4096; 0: as many as it has
    ///
    /// More learn more, and take longer. The policy begins as the same function in a network so wide. A controller that is the
    /// mean of a policy and its mirror image, as those of `fast` and `robust` are, then has twice as many.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        allow_negative_numbers = true
    )]
    pub hidden_units: usize,

    /// Seed of everything random
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        allow_negative_numbers = true
    )]
    pub seed: u64,

    /// On how many threads.
    #[command(flatten)]
    pub threads: ThreadArguments,

    /// Folder of the hardening [default: out/harden]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// What is printed.
    #[command(flatten)]
    pub print: PrintArguments,
}
