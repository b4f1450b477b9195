//! Arguments of the commands that measure what controllers do.

use super::values::{Commands, Seeds, commands, duration_s, omega_v, seed, seeds, time_s};
use super::{
    ChangeArguments, ControllerArguments, PrintArguments, SubjectArguments, ThreadArguments,
};
use crate::disturb::DisturbanceArguments;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Shows a controller walk, run and change gait: a table, an animation and figures
///
/// Writes into the folder given by --out:
///   walk-run-walk.gif        the body walks, runs and walks again
///   walk-to-run.svg, .png    energies and speed over the change of gait, support phases shaded
///   run-to-walk.svg, .png    the same for the way back
///   walking.svg, .png        a stride of the walk
///   running.svg, .png        a stride of the run
///   sweep.svg, .png          speed, cost of transport and support against the command
/// and prints what the controller does over the range of its command.
#[derive(Debug, Args)]
#[command(verbatim_doc_comment)]
pub struct DemoArguments {
    /// Which controller.
    #[command(flatten)]
    pub which: ControllerArguments,

    /// Folder for the pictures; files of the same names are replaced
    #[arg(long, value_name = "DIR", default_value = "out/demo")]
    pub out: PathBuf,
}

/// Measures what a controller does under constant commands.
///
/// One motion per command, one row per motion. After the settling time each motion is described by its
/// gait (standing, walking, running, mixed or fallen), speed, Froude number v/√(g l) with the leg length l, shares of
/// time in double support, single support and flight, cost of transport (positive work of both actuators over weight
/// times distance), steps per second and step length (distance the hip travels per step). In a walk steps alternate and have double
/// support and no flight; in a run they have flight and no double support. A step lasts from one touchdown to the next.
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
  gaitshift evaluate --push 80@5 --latency 5ms --noise theta_velocity=0.1
  gaitshift evaluate --omega-v 0,3 --seed 1..12 --slope 2deg@2 --step-up 0.01
  gaitshift evaluate --criteria --json
  gaitshift evaluate --criteria --seed 1..12
  gaitshift evaluate --controller runs/mine-1 --criteria
  gaitshift evaluate --criteria slow.toml")]
pub struct EvaluateArguments {
    /// What moves.
    #[command(flatten)]
    pub subject: SubjectArguments,

    /// Random starts, one drawn with each of these seeds, e.g. 7, 1,4,7 or 1..12
    /// [default: the default start, always the same]
    ///
    /// Leg angles, pitch, speed and height are drawn from the ranges in which training episodes start;
    /// the default start is the middle of these ranges with the right leg in front. The noise of --noise
    /// is drawn with it, too; the ground of --uneven is not. Nothing else is random. Of several starts the table has, for each command, the
    /// gaits, the falls, and mean and standard deviation of the motions that did not fall.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true, value_delimiter = ',', value_parser = seeds)]
    pub seed: Vec<Seeds>,

    /// Commands ω_v in s/m, separated by commas, each from -100 to 100; FIRST:LAST:STEP is a range; training uses -0.5 to 3.5
    #[arg(long, value_name = "LIST", value_delimiter = ',', allow_hyphen_values = true,
          default_value = "0:3.5:0.5", value_parser = commands)]
    pub omega_v: Vec<Commands>,

    /// One motion under a command that changes: a CSV file with the columns `time_s,omega_v`
    ///
    /// Piecewise linear, constant before the first and after the last line. In the row `omega_v` is the
    /// command if it is constant over the part described, otherwise null.
    #[arg(long, value_name = "FILE.csv", conflicts_with = "omega_v")]
    pub command_profile: Option<PathBuf>,

    /// Duration of each motion in s, 0.1 to 3600 [default: 20, or 5 s beyond the end of a profile if that is later]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = duration_s)]
    pub duration_s: Option<f64>,

    /// Settling time in s at the start, not measured; at most half of the motion
    #[arg(long, value_name = "S", default_value = "5", allow_negative_numbers = true, value_parser = time_s)]
    pub settling_s: f64,

    /// Check all criteria of a finished controller; exit code 1 if one is not met
    ///
    /// FILE has a table `[criteria]`, or the keys of that table alone. Without it the criteria are those of
    /// the run of --controller DIR, otherwise the default 39, this project's reading of what the paper reports (docs/deviations.md has each bound's reason): 20 s without a fall at each ω_v from 0 to 3.5,
    /// a walk at 0 and a run at 3, speeds, costs of transport, energy correlations, and changes of gait from
    /// ten phases of the stride both ways. All of it is measured from random starts where --seed asks for
    /// them. The criteria determine the motions: this option cannot be combined with those that choose motions, or disturbances.
    #[arg(long, value_name = "FILE.toml", num_args = 0..=1, conflicts_with_all = ["omega_v", "command_profile", "duration_s", "settling_s", "out"])]
    pub criteria: Option<Option<PathBuf>>,

    /// Folder for the recordings (omega_v_3.csv and so on) and a figure of all commands (sweep.svg, .png); files of the
    /// same names are replaced [default: none written]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// What is printed.
    #[command(flatten)]
    pub print: PrintArguments,

    /// What disturbs the motions.
    #[command(flatten)]
    pub disturbances: DisturbanceArguments,
}

/// Changes the command during a motion and shows how the gait changes.
///
/// By default ω_v rises from 0 (walking) to 3 (running) in 0.4 s. The steady motion before the ramp is
/// compared with that after it, each without its first 5 s (at most half of it). `steps_to_change` is the
/// number of the touchdown, counted from the start of the ramp, after which every step is of the new gait; null
/// unless a walk became a run or a run a walk. For a profile with several changes, `changes` has this for each;
/// those less than 4 s apart count as one.
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
    /// the default start is the middle of these ranges with the right leg in front. The noise of --noise
    /// is drawn with it, too; the ground of --uneven is not. Nothing else is random.
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = seed)]
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

    /// What is printed.
    #[command(flatten)]
    pub print: PrintArguments,

    /// What disturbs the motion.
    #[command(flatten)]
    pub disturbances: DisturbanceArguments,
}

/// Measures what a controller withstands: pushes, steps, slopes, noise, latency.
///
/// Finds, from several random starts after settling under the command, the largest push forward, backward, up
/// and down at each of eight phases of the stride, the highest step up and down (the body has to get 3 m beyond it), the
/// steepest slope up and down (5 m along it), the largest noise of each observation and the longest latency without a
/// fall. Each disturbance grows by a quarter (with --quick by 60 %), at most to 128 times its first size, until one is
/// not withstood, then the gap is halved twice. One table gives the median, least and greatest over the starts for each
/// command; sizes are in N s (force times 0.1 s), m, rad, m/s, rad/s, s.
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
  gaitshift stress --only push --omega-v 1 --seed 1..20
  gaitshift stress --seed 1..20 --set friction=0.6 --json")]
pub struct StressArguments {
    /// What moves.
    #[command(flatten)]
    pub subject: SubjectArguments,

    /// Commands ω_v in s/m, separated by commas, each from -100 to 100; FIRST:LAST:STEP is a range
    /// [default: 0,1,2,3; 0,3 with --quick]
    #[arg(long, value_name = "LIST", value_delimiter = ',', allow_hyphen_values = true, value_parser = commands)]
    pub omega_v: Vec<Commands>,

    /// Random starts, one drawn with each of these seeds, e.g. 1..12 or 1,4,7 [default: 1..8; 1..3 with --quick]
    #[arg(long, value_name = "LIST", allow_hyphen_values = true, value_delimiter = ',', value_parser = seeds)]
    pub seed: Vec<Seeds>,

    /// Try only these, separated by commas [default: all]
    #[arg(long, value_enum, value_name = "LIST", value_delimiter = ',')]
    pub only: Vec<DisturbanceName>,

    /// A first look: three starts, two commands, pushes forward and backward at four phases, coarser limits
    #[arg(long)]
    pub quick: bool,

    /// On how many threads.
    #[command(flatten)]
    pub threads: ThreadArguments,

    /// Folder for table and figure; files of the same names are replaced [default: out/stress, none with --json]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// What is printed.
    #[command(flatten)]
    pub print: PrintArguments,
}

/// What `stress` may try alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DisturbanceName {
    /// Forward, backward, up and down, at phases of the stride
    Push,
    /// Up and down
    Step,
    /// Up and down
    Slope,
    /// Of each observation
    Noise,
    /// Of all observations
    Latency,
}

/// Compares controllers, runs and recordings.
///
/// Each is a controller file, a run's folder (its best controller and its training curve), a recording (CSV),
/// or `shipped` or `robust`, which come with the program. Controllers are measured at every command; recordings are analysed as they are. One
/// table has a row for each command and name. The folder of --out gets a figure of all controllers over the
/// range of their command (sweep.svg, .png) and, for runs, the criteria met during training (learning.svg, .png) and by
/// the best controllers (table.svg, .png, .md, .json). Runs of one experiment with different seeds share one curve, and one row with an
/// interval over the seeds.
///
/// With --json, standard output is {"rows": [{"name", "omega_v", ...}], "runs": [{"name", "experiment", "seed", ...}],
/// "experiments": [{"variant", "seeds", "best_met", ...}]}, and with several seeds "spread" as in `evaluate`; files are
/// written only into a folder given by --out.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  gaitshift compare shipped robust
  gaitshift compare shipped runs/fast-1
  gaitshift compare runs/fast-1 runs/fast-2 runs/fast-3 --omega-v 0,3
  gaitshift compare shipped runs/fast-1 --seed 1..12 --set friction=0.6
  gaitshift compare out/a/omega_v_3.csv out/b/omega_v_3.csv")]
pub struct CompareArguments {
    /// Controller files, runs' folders, recordings, `shipped` or `robust`
    #[arg(value_name = "FILE|DIR|NAME", required = true)]
    pub items: Vec<PathBuf>,

    /// What differs from what the controllers were trained on.
    #[command(flatten)]
    pub changes: ChangeArguments,

    /// Commands ω_v in s/m, separated by commas, each from -100 to 100; FIRST:LAST:STEP is a range
    #[arg(long, value_name = "LIST", value_delimiter = ',', allow_hyphen_values = true,
          default_value = "0:3.5:0.5", value_parser = commands)]
    pub omega_v: Vec<Commands>,

    /// Random starts, one drawn with each of these seeds, e.g. 1..12 or 1,4,7 [default: the default start]
    #[arg(long, value_name = "LIST", allow_hyphen_values = true, value_delimiter = ',', value_parser = seeds)]
    pub seed: Vec<Seeds>,

    /// Duration of each motion in s, 0.1 to 3600
    #[arg(long, value_name = "S", default_value = "20", allow_negative_numbers = true, value_parser = duration_s)]
    pub duration_s: f64,

    /// Settling time in s at the start, not measured; at most half of the motion
    #[arg(long, value_name = "S", default_value = "5", allow_negative_numbers = true, value_parser = time_s)]
    pub settling_s: f64,

    /// Folder for the figures; files of the same names are replaced [default: out/compare, none with --json]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// What is printed.
    #[command(flatten)]
    pub print: PrintArguments,
}

/// How the study's experiments learn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LearnerName {
    /// As in the papers
    Papers,
    /// As in the recipe `fast`
    Fast,
}

/// Repeats the study: every claim and figure of the paper and its journal version beside the results here.
///
/// With --quick the page shows the shipped controller beside what recorded runs were found to do, in a minute or two.
/// Without it the study's experiments are trained first: the paper's method with and without phase I and the recipe
/// `fast` with five seeds each, the paper's method without the energy term, the journal version's method and four variants
/// of it with three. That takes days, with --learner fast some hours; an estimate of the training and of the measuring after it is
/// printed first. Ctrl-C writes checkpoints, and the same command continues from them; finished runs are neither trained
/// nor measured again.
///
/// Into the folder of --out: report.html (one self-contained file, also for print), figures/ (each as SVG and PNG, its
/// numbers as CSV and JSON), claims.csv, numbers.csv, report.json, and runs/. The same controllers give the same bytes.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  gaitshift reproduce --quick
  gaitshift reproduce --dry-run
  gaitshift reproduce --learner fast --out out/quick-study
  gaitshift reproduce --jobs 2 --out out/study")]
pub struct ReproduceArguments {
    /// Train nothing: the page for the shipped controller and recorded runs, with coarser steps of the command and fewer
    /// starts
    #[arg(long, conflicts_with_all = ["dry_run", "jobs", "learner"])]
    pub quick: bool,

    /// How the experiments learn: as in the papers (one update per step), or as the recipe `fast` does (32 bodies simulated
    /// together, one update per 16 of their steps in all, mirrored batches); reward, α, γ, commands and phases are the papers' either way
    #[arg(long, value_enum, value_name = "NAME", default_value = "papers")]
    pub learner: LearnerName,

    /// Only report what would be trained and how long it takes on this machine
    #[arg(long)]
    pub dry_run: bool,

    /// Training runs, and then controllers measured, at a time, 1 to 256 [default: the processors]
    #[arg(long, value_name = "N", allow_negative_numbers = true,
          value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: Option<u16>,

    /// Folder of the page and of the runs; files of the same names are replaced
    #[arg(long, value_name = "DIR", default_value = "out/reproduce")]
    pub out: PathBuf,
}

/// Makes the page of `gaitshift reproduce` for any controllers.
///
/// Claims with verdicts, numbers beside human values, and figures: changes of gait (Fig. 3), returns over
/// training (Fig. 4) where a run's folder has them, energies and poses over a stride, everything against the
/// command, the change of gait as a bifurcation, where energy goes, ground reaction forces, steps in the
/// ground, sensor noise. Runs of one experiment with different seeds are shown together, with intervals; only the first of
/// them has figures of its own. What is measured of a run is kept in its folder and used again while controller and program are the same.
///
/// Into the folder of --out: report.html (one self-contained file, also for print), figures/ (each as SVG and PNG, its
/// numbers as CSV and JSON), claims.csv, numbers.csv and report.json. The same controllers give the same bytes.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  gaitshift report runs/fast-1
  gaitshift report runs/fast-1 runs/fast-2 runs/fast-3 shipped
  gaitshift report --quick my.safetensors --out out/mine")]
pub struct ReportArguments {
    /// Runs' folders (their best controllers), controller files, `shipped` or `robust`
    #[arg(value_name = "RUN|FILE|NAME", required = true)]
    pub items: Vec<PathBuf>,

    /// Coarser steps of the command, fewer starts
    #[arg(long)]
    pub quick: bool,

    /// Folder of the page; files of the same names are replaced
    #[arg(long, value_name = "DIR", default_value = "out/report")]
    pub out: PathBuf,
}
