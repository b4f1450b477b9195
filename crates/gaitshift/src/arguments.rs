//! The command line: every option with its unit, default and range.

use crate::disturb::DisturbanceArguments;
use clap::builder::styling::{AnsiColor, Styles};
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Largest |ω_v|: far beyond what any controller was trained for, far below where numbers overflow.
pub const OMEGA_V_MAX: f64 = 100.0;
/// Longest motion or part of one, in s: an hour, whose recording takes some 300 MB of memory.
const LONGEST_S: f64 = 3600.0;
/// Shortest motion, in s.
const SHORTEST_S: f64 = 0.1;

const STYLES: Styles = Styles::styled()
    .header(AnsiColor::Green.on_default().bold())
    .usage(AnsiColor::Green.on_default().bold())
    .literal(AnsiColor::Cyan.on_default().bold())
    .placeholder(AnsiColor::Cyan.on_default());

/// A biped with passive hips that walks, runs and changes gait on one command.
///
/// One neural controller drives two linear actuators, one along each leg; the hips are passive. Its only
/// command is ω_v, the weight of forward speed in the reward it was trained with: at 0 the body walks, at
/// 3 it runs, and in between it changes gait.
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
  gaitshift reproduce --quick       the papers' claims beside what it does, on one page

Units are SI, angles in radians. Results go to standard output, progress and errors to standard error.
Exit codes: 0 done, 1 failed, 2 bad input, 130 interrupted."
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

/// What moves.
#[derive(Debug, Default, Args)]
pub struct SubjectArguments {
    /// Controller file, or a run's folder for the best controller in it [default: the shipped controller]
    #[arg(long, value_name = "FILE|DIR")]
    pub controller: Option<PathBuf>,

    /// What differs from what the controller was trained on.
    #[command(flatten)]
    pub changes: ChangeArguments,
}

/// What differs from the body and the task that a controller was trained on.
#[derive(Debug, Default, Args)]
pub struct ChangeArguments {
    /// TOML file that changes the body, e.g. with the line `friction = 0.6`
    ///
    /// Keys are those of the table `[body]` in a run's config.toml, by themselves or in such a table. What the
    /// file leaves out stays as in the controller's training.
    #[arg(long, value_name = "FILE.toml")]
    pub body: Option<PathBuf>,

    /// Change one value, e.g. --set friction=0.6; may be given several times
    ///
    /// Keys are those of `[body]` in a run's config.toml; with `task.` before it a key of `[task]`, e.g.
    /// --set task.termination.pitch_limit_rad=1.0.
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// Shows a controller walk, run and change gait: a table, an animation and figures.
///
/// Writes into the folder given by --out:
///   walk-run-walk.gif        the body on its way from walking to running and back
///   walk-to-run.svg, .png    energies and speed over the change of gait, support phases shaded
///   run-to-walk.svg, .png    the same for the way back
///   walking.svg, .png        a stride of the walk
///   running.svg, .png        a stride of the run
///   sweep.svg, .png          speed, cost of transport and support against the command
/// and prints what the controller does over the range of its command.
#[derive(Debug, Args)]
#[command(verbatim_doc_comment)]
pub struct DemoArguments {
    /// Controller file, or a run's folder for the best controller in it [default: the shipped controller]
    #[arg(long, value_name = "FILE|DIR")]
    pub controller: Option<PathBuf>,

    /// Folder for the pictures; files of the same names are replaced
    #[arg(long, value_name = "DIR", default_value = "out/demo")]
    pub out: PathBuf,
}

/// Trains a controller from scratch with Soft Actor-Critic.
///
/// A run is described by one TOML file: body, task, curriculum, learner. Recipes that come with the
/// program: `fast` (the default), `paper` (schedule and settings of the paper, 10 million steps) and
/// `journal` (those of its journal version). A file of your own needs only what differs from the recipe
/// that its key `base` names; an unknown key is an error.
///
/// Every few hundred thousand steps the controller is evaluated without noise at all commands and changes
/// of gait, so that you see when it first walks and runs. Ctrl-C writes a checkpoint and stops; so do SIGTERM and
/// SIGUSR1, with which batch systems end a job.
#[derive(Debug, Args)]
#[command(after_long_help = "\
The folder of a run:
  config.toml               every setting of the run
  controller.safetensors    the best controller so far; needs no other file
  controller-accepted.safetensors  the first that met every criterion, if there is one
  controller-last.safetensors      the one at the last checkpoint
  metrics.csv, events.out.tfevents.*   progress of training, also for `tensorboard --logdir runs`
  episodes.csv, returns.svg, .png      every episode, and their returns as a figure
  evaluations.jsonl         every evaluation in full, one JSON object per line
  checkpoint/               everything needed to resume, to the same bits
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

    /// Recipe (`fast`, `paper`, `journal`) or TOML file
    #[arg(value_name = "RECIPE|FILE.toml", default_value = "fast")]
    pub experiment: String,

    /// Seed of everything random [default: the recipe's]; the same seed gives the same run
    #[arg(
        long,
        value_name = "N",
        allow_negative_numbers = true,
        conflicts_with = "resume"
    )]
    pub seed: Option<u64>,

    /// One run after the other with each of these seeds, e.g. 1-5 or 1,2,7
    ///
    /// Folders are runs/NAME-SEED, with --out DIR the folders DIR/NAME-SEED. Ctrl-C stops the run under way and begins no
    /// other. In the end a table says what came of each, with mean and standard deviation.
    #[arg(long, value_name = "LIST", conflicts_with_all = ["seed", "resume"],
          value_delimiter = ',', value_parser = seeds)]
    pub seeds: Vec<Seeds>,

    /// Folder of the run; must not contain a run yet [default: runs/NAME-SEED]
    #[arg(long, value_name = "DIR", conflicts_with = "resume")]
    pub out: Option<PathBuf>,

    /// Change one value of the experiment, e.g. --set body.friction=0.6; may be given several times
    #[arg(long, value_name = "KEY=VALUE", conflicts_with = "resume")]
    pub set: Vec<String>,

    /// Say what would be trained, for how long, and what looks like a mistake; train nothing
    ///
    /// The phases in steps and minutes (a few seconds of training tell the pace), every value that differs from the recipe
    /// or file that it is based on, and warnings. Nothing is written.
    #[arg(long, conflicts_with_all = ["resume", "seeds", "out", "steps"])]
    pub check: bool,

    /// Resume the run in this folder from its last checkpoint
    ///
    /// It ends with the same controller as if it had not been stopped.
    #[arg(long, value_name = "DIR", conflicts_with = "experiment")]
    pub resume: Option<PathBuf>,

    /// Threads of the learner, 1 to 256 [default: the recipe's, or the run's]; the result does not depend on them
    #[arg(long, value_name = "N", allow_negative_numbers = true,
          value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads: Option<u16>,

    /// Stop at about this environment step, with a checkpoint to resume from [default: the curriculum's end]
    ///
    /// The curriculum stays as it is. Checked every 2000 steps.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(1..))]
    pub steps: Option<u64>,

    /// Show the run in the browser while it trains, as `gaitshift view RUN` does
    #[arg(long)]
    pub view: bool,

    /// Stop at the first evaluation that meets every criterion (`gaitshift evaluate --criteria`)
    #[arg(long, conflicts_with = "resume")]
    pub stop_when_accepted: bool,

    /// Print the report as one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// Trains many runs from one file: an experiment, what varies, the seeds.
///
/// What varies is a list of variants, the values of some keys in every combination, or settings drawn at random from
/// ranges. Each is trained with each seed, a run in its own folder. Ctrl-C writes checkpoints and stops; the same command
/// goes on from them, and what is finished is not run again. In the end, and with --table at any time, the table says for
/// each variant what its seeds reached, with intervals, and how far the first variant's result moved: table.md, table.json
/// and a figure of all runs, table.svg and .png, in the sweep's folder.
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

In place of [[variants]], keys with their values, in every combination:
  [vary]
  learner.learning_rate = [3e-4, 1e-3]
  body.friction = [0.3, 0.6, 1.0]

or, with a line above the first table, so many settings drawn at random:
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
    #[arg(long, value_name = "N", allow_negative_numbers = true,
          value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: Option<u16>,

    /// Run only every N-th trial, the K-th first: several machines that share the folder run a sweep together
    ///
    /// With --table the table has all trials.
    #[arg(long, value_name = "K/N", value_parser = part, conflicts_with = "dry_run")]
    pub part: Option<Part>,

    /// Only say what would be run and how long it takes on this machine
    #[arg(long, conflicts_with_all = ["table", "json"])]
    pub dry_run: bool,

    /// Only write and print the table of what there is so far
    #[arg(long)]
    pub table: bool,

    /// Print the table as one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// Prints what a shell needs to complete commands and options.
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

/// Prints the manual page, or writes those of all commands.
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

/// Measures what a controller does under constant commands.
///
/// One motion per command, one row per motion. After the settling time each motion is described by its
/// gait (standing, walking, running, mixed or fallen), speed, Froude number v/√(g l), shares of time in
/// double support, single support and flight, cost of transport, step frequency and step length. In a walk
/// steps alternate and have double support and no flight; in a run they have flight and no double
/// support. A step lasts from one touchdown to the next.
///
/// With --json, standard output is {"rows": [{"omega_v", "survived_s", "fell", "gait", "speed_m_per_s",
/// "froude", "double_support", "single_support", "flight", "cost_of_transport", "step_frequency_hz",
/// "step_length_m", ...}]}; what is undefined for a motion is null. A disturbed motion has "disturbance" in its row: what was
/// applied, as the TOML file of --disturbance has it, pushes with their times.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  gaitshift evaluate
  gaitshift evaluate --controller runs/fast-1 --omega-v 0,3
  gaitshift evaluate --seed 7 --out out/seed-7
  gaitshift evaluate --seed 1..12 --omega-v 0:3.5:0.25
  gaitshift evaluate --set friction=0.6 --set hip_mass_kg=25
  gaitshift evaluate --push 150@5 --latency 10ms --noise theta_velocity=0.1
  gaitshift evaluate --omega-v 0,3 --seed 1..12 --slope 2deg@2 --step-up 0.01
  gaitshift evaluate --criteria --json
  gaitshift evaluate --controller runs/mine-1 --criteria
  gaitshift evaluate --criteria slow.toml")]
pub struct EvaluateArguments {
    /// What moves.
    #[command(flatten)]
    pub subject: SubjectArguments,

    /// Random start, drawn with this seed, or one with each of several seeds, e.g. 1..12 or 1,4,7
    /// [default: the default start, always the same]
    ///
    /// Leg angles, pitch, speed and height are drawn from the ranges in which training episodes start;
    /// the default start is the middle of these ranges with the right leg in front. Nothing else is
    /// random: the controller acts without noise. Of several starts the table has, for each command, the
    /// gaits, the falls, and mean and standard deviation of the motions that did not fall.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true, value_delimiter = ',', value_parser = seeds)]
    pub seed: Vec<Seeds>,

    /// Commands ω_v, separated by commas, each from -100 to 100; FIRST:LAST:STEP is a range; training uses -0.5 to 3.5
    #[arg(long, value_name = "LIST", value_delimiter = ',', allow_hyphen_values = true,
          default_value = "0:3.5:0.5", value_parser = commands)]
    pub omega_v: Vec<Commands>,

    /// One motion under a command that changes: a CSV file with the columns `time_s,omega_v`
    ///
    /// Piecewise linear, constant before the first and after the last line. In the row `omega_v` is the
    /// command if it is constant over the part described, otherwise null.
    #[arg(long, value_name = "FILE.csv", conflicts_with = "omega_v")]
    pub command_profile: Option<PathBuf>,

    /// Duration of each motion in s, 0.1 to 3600 [default: 20; 5 s beyond the end of a longer profile]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = duration_s)]
    pub duration_s: Option<f64>,

    /// Settling time in s at the start, not measured; at most half of the motion
    #[arg(long, value_name = "S", default_value = "5", allow_negative_numbers = true, value_parser = time_s)]
    pub settling_s: f64,

    /// Check all criteria of a finished controller; exit code 1 if one is not met
    ///
    /// Those of a TOML file: its table `[criteria]`, or the keys of that table by themselves. Without a file,
    /// those that the run of --controller DIR asks for, otherwise the paper's 39: 20 s without a fall at each
    /// ω_v from 0 to 3.5, a walk at 0 and a run at 3, speeds, costs of transport, energy correlations, and
    /// changes of gait from ten phases of the stride both ways.
    #[arg(long, value_name = "FILE.toml", num_args = 0..=1, conflicts_with_all = ["omega_v", "command_profile", "duration_s", "settling_s", "seed", "out"])]
    pub criteria: Option<Option<PathBuf>>,

    /// Folder for the recordings (CSV) and a figure of all commands (SVG, PNG) [default: none written]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Print the rows as one JSON object on standard output
    #[arg(long)]
    pub json: bool,

    /// What disturbs the motions.
    #[command(flatten)]
    pub disturbances: DisturbanceArguments,
}

/// Changes the command during a motion and shows how the gait changes.
///
/// By default ω_v rises from 0 (walking) to 3 (running) in 0.4 s. The steady motion before the ramp is
/// compared with that after it, each without its first 5 s (at most half of it). `steps_to_change` counts
/// the touchdowns from the start of the ramp up to the one that begins the first step from which on every
/// step is of the new gait.
///
/// Writes a figure like the paper's Fig. 3 (energies and speed against time, support
/// phases shaded, the ramp hatched) and the recording. With --json, standard output is one JSON object,
/// and files are written only into a folder given by --out.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  gaitshift transition
  gaitshift transition --from 3 --to 0 --out out/run-to-walk
  gaitshift transition --from 0 --to 3 --ramp-s 0.4 --start-s 10.2 --json
  gaitshift transition --command-profile profile.csv --body ice.toml
  gaitshift transition --push -100@10.2,0.2

where profile.csv is, for instance:
  time_s,omega_v
  8,0
  12,3
  20,3
  20.4,0")]
pub struct TransitionArguments {
    /// What moves.
    #[command(flatten)]
    pub subject: SubjectArguments,

    /// Random start, drawn with this seed [default: the default start, always the same]
    ///
    /// Leg angles, pitch, speed and height are drawn from the ranges in which training episodes start;
    /// the default start is the middle of these ranges with the right leg in front. Nothing else is
    /// random: the controller acts without noise.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub seed: Option<u64>,

    /// Command ω_v before the ramp, -100 to 100
    #[arg(long, value_name = "OMEGA_V", default_value = "0", allow_negative_numbers = true, value_parser = omega_v)]
    pub from: f64,

    /// Command ω_v after the ramp, -100 to 100
    #[arg(long, value_name = "OMEGA_V", default_value = "3", allow_negative_numbers = true, value_parser = omega_v)]
    pub to: f64,

    /// Duration of the ramp in s; 0 for a jump
    #[arg(long, value_name = "S", default_value = "0.4", allow_negative_numbers = true, value_parser = time_s)]
    pub ramp_s: f64,

    /// Time in s at which the ramp begins
    #[arg(long, value_name = "S", default_value = "10", allow_negative_numbers = true, value_parser = time_s)]
    pub start_s: f64,

    /// Duration in s of the motion after the ramp, or after the last line of a profile
    #[arg(long, value_name = "S", default_value = "10", allow_negative_numbers = true, value_parser = duration_s)]
    pub after_s: f64,

    /// The command over time instead of a ramp: a CSV file with the columns `time_s,omega_v`
    ///
    /// Piecewise linear, constant before the first and after the last line. Everything from the first
    /// change of the command to its last counts as the ramp.
    #[arg(long, value_name = "FILE.csv", conflicts_with_all = ["from", "to", "ramp_s", "start_s"])]
    pub command_profile: Option<PathBuf>,

    /// Folder for figure and recording; files of the same names are replaced
    /// [default: out/transition, none with --json]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Print the values as one JSON object on standard output
    #[arg(long)]
    pub json: bool,

    /// What disturbs the motion.
    #[command(flatten)]
    pub disturbances: DisturbanceArguments,
}

/// Finds how much a controller bears: pushes, steps, slopes, noise, latency.
///
/// From several random starts, each settled under the command first: the largest push forward, backward, up and down at each
/// phase of the stride, the highest step up and down, the steepest slope up and down, the largest noise of each observation and
/// the longest latency without a fall. Sizes grow by a quarter until one is not borne, then the gap is halved twice. One table gives
/// for each command median, least and greatest over the starts; sizes are in N s (force times 0.1 s), m, rad, m/s, rad/s, s.
///
/// Writes the table (stress.json) and a figure of it (SVG, PNG). With --json, standard output is one JSON object, {"limits":
/// [{"omega_v", "disturbance", "which", "phase", "unit", "limits", "least", "median", "greatest", "greatest_tried"}], "plan",
/// "controller"}, and files are written only into a folder given by --out. The same starts give the same limits on any number
/// of threads.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  gaitshift stress --quick
  gaitshift stress --controller runs/fast-1 --omega-v 0,3 --out out/stress-fast-1
  gaitshift stress --seed 1..20 --set friction=0.6 --json")]
pub struct StressArguments {
    /// What moves.
    #[command(flatten)]
    pub subject: SubjectArguments,

    /// Commands ω_v, separated by commas; FIRST:LAST:STEP is a range [default: 0,1,2,3; 0,3 with --quick]
    #[arg(long, value_name = "LIST", value_delimiter = ',', allow_hyphen_values = true, value_parser = commands)]
    pub omega_v: Vec<Commands>,

    /// Seeds of the starts, e.g. 1..12 or 1,4,7 [default: 1..8; 1..3 with --quick]
    #[arg(long, value_name = "LIST", allow_hyphen_values = true, value_delimiter = ',', value_parser = seeds)]
    pub seed: Vec<Seeds>,

    /// A first look: three starts, two commands, pushes forward and backward at four phases, coarser limits
    #[arg(long)]
    pub quick: bool,

    /// Threads, 1 to 256 [default: the processors]; the result does not depend on them
    #[arg(long, value_name = "N", allow_negative_numbers = true,
          value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads: Option<u16>,

    /// Folder for table and figure; files of the same names are replaced [default: out/stress, none with --json]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Print the limits as one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// Puts controllers, runs and recordings beside each other.
///
/// Each is a controller file, a run's folder (its best controller, and its course), a recording (CSV), or the word
/// `shipped`. Controllers are tried on every command; recordings are described as they are. One table has a row for each
/// command and name. Into the folder of --out go a figure of all controllers over the range of their command (sweep), and
/// of runs the criteria met over the course of training (learning) and by the best controllers (table): runs of one
/// experiment with different seeds are one curve, and one row with an interval over the seeds.
///
/// With --json, standard output is {"rows": [{"name", "omega_v", ...}], "runs": [{"name", "experiment", "seed", ...}],
/// "experiments": [{"variant", "seeds", "best_met", ...}]}, and with several seeds "spread" as in `evaluate`; files are
/// written only into a folder given by --out.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  gaitshift compare shipped runs/fast-1
  gaitshift compare runs/fast-1 runs/fast-2 runs/fast-3 --omega-v 0,3
  gaitshift compare shipped runs/fast-1 --seed 1..12 --set friction=0.6
  gaitshift compare out/a/omega_v_3.csv out/b/omega_v_3.csv")]
pub struct CompareArguments {
    /// Controller files, runs' folders, recordings, or `shipped`
    #[arg(value_name = "FILE|DIR|shipped", required = true)]
    pub items: Vec<PathBuf>,

    /// What differs from what the controllers were trained on.
    #[command(flatten)]
    pub changes: ChangeArguments,

    /// Commands ω_v, separated by commas, each from -100 to 100; FIRST:LAST:STEP is a range
    #[arg(long, value_name = "LIST", value_delimiter = ',', allow_hyphen_values = true,
          default_value = "0:3.5:0.5", value_parser = commands)]
    pub omega_v: Vec<Commands>,

    /// Draw the starts at random with these seeds, e.g. 1..12 [default: the default start]
    #[arg(long, value_name = "LIST", allow_hyphen_values = true, value_delimiter = ',', value_parser = seeds)]
    pub seed: Vec<Seeds>,

    /// Duration of each motion in s, 0.1 to 3600
    #[arg(long, value_name = "S", default_value = "20", allow_negative_numbers = true, value_parser = duration_s)]
    pub duration_s: f64,

    /// Time in s at the beginning that is left out of the figures, at most half of the motion
    #[arg(long, value_name = "S", default_value = "5", allow_negative_numbers = true, value_parser = time_s)]
    pub settling_s: f64,

    /// Folder for the figures; files of the same names are replaced [default: out/compare, none with --json]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Print everything as one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// Redoes the study: every claim and figure of the paper and its journal version beside what is found here.
///
/// With --quick the page is made from the shipped controller, in about a minute. Without it the study's experiments are
/// trained first: the paper's method with and without phase I and the recipe `fast` with five seeds, without the energy term
/// and the variants of the journal version with three. That takes days; the time is said before it begins. Ctrl-C writes
/// checkpoints, and the same command goes on from them; what is finished is not run again.
///
/// Into the folder of --out: report.html (one file, which fetches nothing; it prints), figures/ (each as SVG and PNG, its
/// numbers as CSV and JSON), claims.csv, numbers.csv, report.json, and runs/. The same controllers give the same bytes.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  gaitshift reproduce --quick
  gaitshift reproduce --dry-run
  gaitshift reproduce --jobs 2 --out out/study")]
pub struct ReproduceArguments {
    /// Train nothing: the page of the shipped controller, with coarser steps
    #[arg(long, conflicts_with_all = ["dry_run", "jobs"])]
    pub quick: bool,

    /// Only say what would be trained and how long it takes on this machine
    #[arg(long)]
    pub dry_run: bool,

    /// Training runs at a time, 1 to 256 [default: the processors]
    #[arg(long, value_name = "N", allow_negative_numbers = true,
          value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: Option<u16>,

    /// Folder of the page and of the runs; files of the same names are replaced
    #[arg(long, value_name = "DIR", default_value = "out/reproduce")]
    pub out: PathBuf,
}

/// Makes the page of `gaitshift reproduce` of any controllers.
///
/// Claims with verdicts, numbers beside those of people, and figures: changes of gait (Fig. 3), returns over training (Fig. 4)
/// where a run's folder has them, energies and poses over a stride, everything against the command, the change of gait as a
/// bifurcation, where energy goes, ground reaction forces, steps in the ground, sensor noise. Runs of one experiment are its
/// seeds and stand together, with intervals.
///
/// Into the folder of --out: report.html (one file, which fetches nothing; it prints), figures/ (each as SVG and PNG, its
/// numbers as CSV and JSON), claims.csv, numbers.csv and report.json. The same controllers give the same bytes.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  gaitshift report runs/fast-1
  gaitshift report runs/fast-1 runs/fast-2 runs/fast-3 shipped
  gaitshift report --quick my.safetensors --out out/mine")]
pub struct ReportArguments {
    /// Runs' folders (their best controllers), controller files, or `shipped`
    #[arg(value_name = "RUN|FILE|shipped", required = true)]
    pub items: Vec<PathBuf>,

    /// Coarser steps of the command, fewer starts
    #[arg(long)]
    pub quick: bool,

    /// Folder of the page; files of the same names are replaced
    #[arg(long, value_name = "DIR", default_value = "out/report")]
    pub out: PathBuf,
}

/// Draws a recording: an animation (GIF, MP4, WebM or frames) and a stride at a glance (SVG, PNG).
///
/// Pictures are drawn in software from the body's geometry in the recording; no display is needed. Right
/// is vermilion, left is blue, arrows are the ground's forces on the feet. MP4 and WebM need the program `ffmpeg`.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  gaitshift transition && gaitshift render out/transition/recording.csv --from-s 7 --to-s 15
  gaitshift render out/transition/recording.csv --out run.gif --from-s 12 --to-s 14 --slow-motion 4
  gaitshift render out/transition/recording.csv --out film.mp4 --width 1280
  gaitshift render out/transition/recording.csv --out frames --frames --transparent
  gaitshift render out/transition/recording.csv --out stride.svg --stride-at-s 18")]
pub struct RenderArguments {
    /// Recording (CSV), as `gaitshift evaluate --out` and `gaitshift transition` write it
    #[arg(value_name = "RECORDING.csv")]
    pub recording: PathBuf,

    /// Folder for both pictures, or one file: FILE.gif, FILE.mp4 or FILE.webm for the animation, FILE.svg or FILE.png for
    /// the stride [default: the recording's folder]
    #[arg(long, value_name = "DIR|FILE")]
    pub out: Option<PathBuf>,

    /// Draw only the stride
    #[arg(long)]
    pub strobe: bool,

    /// Write every frame of the animation into the folder --out, as frame-00000.png and so on
    #[arg(long, requires = "out", conflicts_with_all = ["strobe", "stride_at_s"])]
    pub frames: bool,

    /// Leave out the background: with --frames, or of a WebM
    #[arg(long)]
    pub transparent: bool,

    /// Begin at this time of the recording in s [default: its start]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = time_s)]
    pub from_s: Option<f64>,

    /// End at this time of the recording in s [default: its end]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = time_s)]
    pub to_s: Option<f64>,

    /// Frames of the animation per second: 1 to 50 for a GIF, 1 to 240 for films and frames [default: 25, and 60]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number)]
    pub fps: Option<f64>,

    /// How many times slower than real time the animation plays, 0.1 to 100
    #[arg(long, value_name = "TIMES", default_value = "1", allow_negative_numbers = true, value_parser = number)]
    pub slow_motion: f64,

    /// Width of the animation in pixels, 160 to 1920; for films and frames up to 3840, a multiple of 16; the height is five eighths
    #[arg(
        long,
        value_name = "PX",
        allow_negative_numbers = true,
        default_value = "640"
    )]
    pub width: u32,

    /// Draw the stride of the right leg around this time in s [default: the middle of the time range]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = time_s)]
    pub stride_at_s: Option<f64>,

    /// Poses of the stride, 2 to 60
    #[arg(
        long,
        value_name = "N",
        allow_negative_numbers = true,
        default_value = "12",
        value_parser = clap::value_parser!(u16).range(2..=60)
    )]
    pub poses: u16,
}

/// Shows a controller, a training run or a recording in the browser.
///
/// Without an argument the biped moves in real time under a slider for ω_v; it can be pushed, and its body changed while
/// it moves. With the folder of a run its learning curve and evaluations stand beside it, and a click puts the controller
/// of an evaluation on the stage. With a recording it is played, as `gaitshift export html` writes it.
///
/// The page comes from this program and fetches nothing. It is served until the program is stopped (Ctrl-C), on the
/// loopback address: nobody else can reach it.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  gaitshift view
  gaitshift view --controller runs/fast-1/controller.safetensors --body ice.toml
  gaitshift view --body heavy.toml --body light.toml        two bodies side by side on one slider
  gaitshift view runs/fast-1
  gaitshift view out/transition/recording.csv")]
pub struct ViewArguments {
    /// Folder of a training run, or recording (CSV) [default: a controller on a live stage]
    #[arg(value_name = "RUN|RECORDING.csv", conflicts_with_all = ["controller", "body", "seed"])]
    pub what: Option<PathBuf>,

    /// Controller file [default: the shipped controller]; given twice, two bipeds side by side
    #[arg(long, value_name = "FILE")]
    pub controller: Vec<PathBuf>,

    /// TOML file that changes the body, as for `gaitshift transition`; given twice, two bipeds side by side
    #[arg(long, value_name = "FILE.toml")]
    pub body: Vec<PathBuf>,

    /// Random start, drawn with this seed [default: the default start]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub seed: Option<u64>,

    /// Port to listen on [default: 8420, or a free one if that is taken]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub port: Option<u16>,

    /// Address to listen on; with another one than the default, other machines can see and move the biped
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1")]
    pub listen: std::net::IpAddr,

    /// Host name under which other machines may open the page, besides addresses; may be given again
    #[arg(long, value_name = "NAME")]
    pub name: Vec<String>,

    /// Do not open the browser
    #[arg(long)]
    pub no_open: bool,
}

/// Analyses recordings from any simulator, by the rules of `evaluate` and `transition`.
///
/// With --json, standard output is {"rows": [{"recording", "controller", "omega_v", "survived_s", ...}]} as
/// in `evaluate`, or with --transition {"transitions": [{"recording", "controller", "ramp_start_s",
/// "ramp_end_s", "gait_before", "gait_after", ...}]} as in `transition`.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  gaitshift analyse out/seed-7/omega_v_3.csv
  gaitshift analyse --transition --json out/transition/recording.csv")]
pub struct AnalyseArguments {
    /// Recordings (CSV), one row each
    #[arg(value_name = "RECORDING.csv", required = true)]
    pub recordings: Vec<PathBuf>,

    /// Compare the motion before the change of the command with that after it
    #[arg(long, conflicts_with = "settling_s")]
    pub transition: bool,

    /// Settling time in s at the start, not measured; at most half of the motion
    #[arg(long, value_name = "S", default_value = "5", allow_negative_numbers = true, value_parser = time_s)]
    pub settling_s: f64,

    /// Print the result as one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// Writes a body, controller or recording for other programs.
#[derive(Debug, Args)]
#[command(subcommand_value_name = "FORMAT", subcommand_help_heading = "Formats")]
#[command(after_long_help = "\
Examples:
  gaitshift export mjcf --out biped.xml
  gaitshift export onnx --controller runs/fast-1/controller.safetensors --out policy.onnx
  gaitshift export npz out/transition/recording.csv --out motion.npz")]
pub struct ExportArguments {
    /// What to write.
    #[command(subcommand)]
    pub format: ExportFormat,
}

/// What is exported, and as what.
#[derive(Debug, Subcommand)]
pub enum ExportFormat {
    /// The body as MJCF, for MuJoCo
    ///
    /// The same masses, springs, dampers, actuators and joints; comments in the file say how contact differs.
    Mjcf {
        /// What differs from the controller's or default body and task.
        #[command(flatten)]
        changes: ChangeArguments,
        /// Take the body that this controller, or the best one of a run's folder, was trained on [default: the default body]
        #[arg(long, value_name = "FILE|DIR")]
        controller: Option<PathBuf>,
        /// File to write [default: standard output]
        #[arg(short, long, value_name = "FILE.xml")]
        out: Option<PathBuf>,
    },
    /// A controller's deterministic policy as ONNX
    ///
    /// In: `observation`, batch x 14 32-bit floats in SI units, not scaled. Out: `action`, batch x 2 in [-1, 1].
    /// Names, units, control period, body and task are in the file's metadata.
    Onnx {
        /// Controller file, or a run's folder for the best controller in it [default: the shipped controller]
        #[arg(long, value_name = "FILE|DIR")]
        controller: Option<PathBuf>,
        /// File to write [default: standard output]
        #[arg(short, long, value_name = "FILE.onnx")]
        out: Option<PathBuf>,
    },
    /// A folder for a model hub: a controller, its model card (README.md), its ONNX file and its MJCF body
    ///
    /// The card has the gaits, measured now by the criteria of the controller's run (or the paper's), the training that
    /// made it, and its body.
    Hub {
        /// Controller file, or a run's folder for the best controller in it [default: the shipped controller]
        #[arg(long, value_name = "FILE|DIR")]
        controller: Option<PathBuf>,
        /// Licence to be shown, e.g. mit, apache-2.0 or cc-by-4.0 [default: none is named]
        #[arg(long, value_name = "ID")]
        license: Option<String>,
        /// Folder to write; files of the same names are replaced
        #[arg(short, long, value_name = "DIR")]
        out: PathBuf,
    },
    /// A recording as CSV
    ///
    /// Read, checked, and written with exactly the documented columns in their order.
    Csv {
        /// Recording (CSV)
        #[arg(value_name = "RECORDING.csv")]
        recording: PathBuf,
        /// File to write [default: standard output]
        #[arg(short, long, value_name = "FILE.csv")]
        out: Option<PathBuf>,
    },
    /// A recording as one HTML page that plays it
    ///
    /// The biped with play and scrub, and support phases, energies, speed, cost and reward beside it. The page needs
    /// nothing but itself: it can be mailed, put on a web site, or opened from disk.
    Html {
        /// Recording (CSV)
        #[arg(value_name = "RECORDING.csv")]
        recording: PathBuf,
        /// File to write [default: standard output]
        #[arg(short, long, value_name = "FILE.html")]
        out: Option<PathBuf>,
    },
    /// A recording as NPZ, for `numpy.load`
    ///
    /// One array for each column, and `metadata`, the JSON of the recording's first line, as a string.
    Npz {
        /// Recording (CSV)
        #[arg(value_name = "RECORDING.csv")]
        recording: PathBuf,
        /// File to write [default: standard output]
        #[arg(short, long, value_name = "FILE.npz")]
        out: Option<PathBuf>,
    },
}

fn number(text: &str) -> Result<f64, String> {
    in_range(text, f64::MIN, f64::MAX, "")
}

fn omega_v(text: &str) -> Result<f64, String> {
    in_range(text, -OMEGA_V_MAX, OMEGA_V_MAX, "")
}

/// Most commands, and most seeds, of one range.
const MOST_IN_RANGE: f64 = 1000.0;

/// Commands that an element of a list stands for.
#[derive(Debug, Clone, PartialEq)]
pub struct Commands(pub Vec<f64>);

/// Seeds that an element of a list stands for.
#[derive(Debug, Clone, PartialEq)]
pub struct Seeds(pub Vec<u64>);

/// `1.5`, or `FIRST:LAST:STEP`, both ends included.
fn commands(text: &str) -> Result<Commands, String> {
    let parts: Vec<&str> = text.split(':').collect();
    let [first, last, step] = parts[..] else {
        return match parts.len() {
            1 => Ok(Commands(vec![omega_v(text)?])),
            _ => Err(format!(
                "`{text}` is neither a number nor FIRST:LAST:STEP, such as 0:3.5:0.5"
            )),
        };
    };
    let (first, last, step) = (omega_v(first)?, omega_v(last)?, number(step)?);
    let steps = (last - first) / step;
    if !(0.0..MOST_IN_RANGE).contains(&steps) {
        return Err(format!(
            "STEP must lead from FIRST to LAST in at most {MOST_IN_RANGE} commands"
        ));
    }
    // A step such as 0.1 does not meet its end exactly, and a product of it has a long tail of digits.
    let tidy = |value: f64| (value * 1e9).round() / 1e9;
    let count = (steps + 1e-6).floor() as usize;
    Ok(Commands(
        (0..=count).map(|k| tidy(first + k as f64 * step)).collect(),
    ))
}

/// `7`, `1..12` or `1-12`, both ends included.
fn seeds(text: &str) -> Result<Seeds, String> {
    let whole = |text: &str| {
        let number = text.trim().parse::<u64>();
        number.map_err(|_| {
            format!("`{text}` is not a whole number from 0 on, nor a range such as 1..12")
        })
    };
    let Some((first, last)) = text.split_once("..").or_else(|| text.split_once('-')) else {
        return Ok(Seeds(vec![whole(text)?]));
    };
    let (first, last) = (whole(first)?, whole(last.trim_start_matches('='))?);
    if first > last || (last - first) as f64 >= MOST_IN_RANGE {
        return Err(format!(
            "`{text}` must be from a lower to a higher seed, at most {MOST_IN_RANGE} of them"
        ));
    }
    Ok(Seeds((first..=last).collect()))
}

/// The K-th of N parts.
#[derive(Debug, Clone, Copy)]
pub struct Part {
    /// From 1 on.
    pub number: usize,
    /// Number of parts.
    pub of: usize,
}

fn part(text: &str) -> Result<Part, String> {
    let parts = text.split_once('/');
    let numbers = parts.and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
    match numbers {
        Some((number, of)) if (1..=of).contains(&number) => Ok(Part { number, of }),
        _ => Err("expected K/N with K from 1 to N, such as 2/4".to_owned()),
    }
}

fn duration_s(text: &str) -> Result<f64, String> {
    in_range(text, SHORTEST_S, LONGEST_S, " s")
}

fn time_s(text: &str) -> Result<f64, String> {
    in_range(text, 0.0, LONGEST_S, " s")
}

fn in_range(text: &str, low: f64, high: f64, unit: &str) -> Result<f64, String> {
    let value: f64 = text
        .trim()
        .parse()
        .map_err(|_| format!("`{text}` is not a number"))?;
    if (low..=high).contains(&value) {
        Ok(value)
    } else if low == f64::MIN {
        Err(format!("`{text}` is not a finite number"))
    } else {
        Err(format!("it must be from {low} to {high}{unit}"))
    }
}
