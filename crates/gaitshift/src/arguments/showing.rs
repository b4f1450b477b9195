//! Arguments of the commands that draw, show, analyse and export.

use super::values::{host_name, number, port, recorded_s, seed, time_s};
use super::{ChangeArguments, ControllerArguments, PrintArguments};
use crate::disturb::ModelArguments;
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// Draws a recording: an animation (GIF, MP4, WebM or frames) and a stride at a glance (SVG, PNG).
///
/// Pictures are drawn in software from the body's geometry in the recording; no display is needed. The right
/// leg is vermilion, the left leg pale blue; arrows are the ground's forces on the feet. MP4 and WebM need
/// the program `ffmpeg`.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  gaitshift transition && gaitshift render out/transition/recording.csv --from-s 7 --to-s 15
  gaitshift render out/transition/recording.csv --out run.gif --from-s 12 --to-s 14 --slow-motion 4
  gaitshift render out/transition/recording.csv --out film.mp4 --width 1280
  gaitshift render out/transition/recording.csv --out frames --frames --transparent
  gaitshift render out/transition/recording.csv --out stride.svg --stride-at-s 18
  gaitshift render out/transition/recording.csv --out change.svg --from-s 9.5 --to-s 11.5 --poses 20")]
pub struct RenderArguments {
    /// Recording (CSV), as `gaitshift evaluate --out` and `gaitshift transition` write it
    #[arg(value_name = "RECORDING.csv")]
    pub recording: PathBuf,

    /// Folder for both pictures, or one file: FILE.gif, FILE.mp4 or FILE.webm for the animation, FILE.svg or FILE.png for
    /// the stride, or, with --from-s and --to-s, for the time between them [default: the recording's folder]
    #[arg(long, value_name = "DIR|FILE")]
    pub out: Option<PathBuf>,

    /// Draw only the stride, or, with --from-s and --to-s, the time between them
    #[arg(long)]
    pub strobe: bool,

    /// Write every frame of the animation into the folder of --out, as frame-00000.png and so on
    #[arg(long, requires = "out", conflicts_with_all = ["strobe", "stride_at_s", "poses"])]
    pub frames: bool,

    /// Leave out the background (frames and WebM)
    #[arg(long)]
    pub transparent: bool,

    /// Begin at this time of the recording in s [default: its start]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = recorded_s)]
    pub from_s: Option<f64>,

    /// End at this time of the recording in s [default: its end]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = recorded_s)]
    pub to_s: Option<f64>,

    /// Frames of the animation per second: 1 to 50 for a GIF, 1 to 240 for films and frames [default: 25
    /// for a GIF, otherwise 60]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number)]
    pub fps: Option<f64>,

    /// How many times slower than real time the animation plays, 0.1 to 100 [default: 1]
    #[arg(long, value_name = "TIMES", allow_negative_numbers = true, value_parser = number)]
    pub slow_motion: Option<f64>,

    /// Width of the animation in pixels: 160 to 1920 for a GIF, 160 to 3840 for films and frames, there rounded to a
    /// multiple of 16; the height is five eighths of it [default: 640]
    #[arg(long, value_name = "PX", allow_negative_numbers = true)]
    pub width: Option<u32>,

    /// Draw the stride of the right leg around this time in s [default: the middle of the time range]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = recorded_s)]
    pub stride_at_s: Option<f64>,

    /// Poses of the stride or the time drawn, 2 to 60 [default: 12]
    ///
    /// Many are drawn further apart than they are, each on the ground around it: to see a step or a slope, draw
    /// few poses of a short time.
    #[arg(
        long,
        value_name = "N",
        allow_negative_numbers = true,
        value_parser = clap::value_parser!(u16).range(2..=60)
    )]
    pub poses: Option<u16>,
}

/// Shows a controller, a training run or a recording in the browser.
///
/// Without an argument the biped moves in real time, with a slider for ω_v; you can push it and change its
/// body while it moves. With the folder of a run, the page also shows the learning curve and the evaluations,
/// and a click on one runs its controller. With a recording, the page plays it, like the page of `gaitshift
/// export html`.
///
/// The page comes from this program and fetches nothing. It is served until the program is stopped (Ctrl-C).
/// Unless --listen says otherwise, only programs on this machine can reach it.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  gaitshift view
  gaitshift view --controller runs/fast-1/controller.safetensors --body ice.toml
  gaitshift view --body heavy.toml --body light.toml        two bodies side by side, one slider
  gaitshift view runs/fast-1
  gaitshift view out/transition/recording.csv")]
pub struct ViewArguments {
    /// Folder of a training run, or recording (CSV) [default: a controller, simulated live]
    #[arg(value_name = "RUN|RECORDING.csv", conflicts_with_all = ["controller", "body", "seed"])]
    pub what: Option<PathBuf>,

    /// Controller file, a run's folder (its best controller), or `shipped` or `robust`, which come with the program
    /// [default: shipped]; given twice, two bipeds side by side
    #[arg(long, value_name = "FILE|DIR|NAME")]
    pub controller: Vec<PathBuf>,

    /// TOML file that changes the body, as for `gaitshift transition`; given twice, two bipeds side by side
    #[arg(long, value_name = "FILE.toml")]
    pub body: Vec<PathBuf>,

    /// Random start, drawn with this seed [default: the default start]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = seed)]
    pub seed: Option<u64>,

    /// Port to listen on [default: 8420, or a free one if that is taken]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = port)]
    pub port: Option<u16>,

    /// Address to listen on; with one that is not 127.0.0.1 or ::1, other machines can see and move the biped
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1")]
    pub listen: std::net::IpAddr,

    /// Host name, besides addresses, under which other machines may open the page; may be given several times
    #[arg(long, value_name = "NAME", value_parser = host_name)]
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
    /// Recordings (CSV, in the format of docs/formats.md), one row each
    #[arg(value_name = "RECORDING.csv", required = true)]
    pub recordings: Vec<PathBuf>,

    /// Compare the motion before the change of the command with that after it
    #[arg(long, conflicts_with = "settling_s")]
    pub transition: bool,

    /// Settling time in s at the start, not measured; at most half of the motion
    #[arg(long, value_name = "S", default_value = "5", allow_negative_numbers = true, value_parser = time_s)]
    pub settling_s: f64,

    /// What is printed.
    #[command(flatten)]
    pub print: PrintArguments,
}

/// Writes a body, controller or recording for other programs.
#[derive(Debug, Args)]
#[command(subcommand_value_name = "FORMAT", subcommand_help_heading = "Formats")]
#[command(after_long_help = "\
Examples:
  gaitshift export mjcf --out biped.xml
  gaitshift export mjcf --controller robust --slope 3deg@2 --step-up 0.03 --out hill.xml
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
    /// The body that a controller was trained on, as MJCF, for MuJoCo
    ///
    /// It has the same masses, springs, dampers, actuators and joints; comments in the file say how the
    /// contact differs. Ground that is not flat becomes a tilted plane or boxes, a weak actuator one of less force,
    /// a latency the actuators' delay, which older versions of MuJoCo do not know. Export the policy of the same
    /// controller with `export onnx`.
    Mjcf {
        /// Whose body and task.
        #[command(flatten)]
        which: ControllerArguments,
        /// What differs from the controller's body and task.
        #[command(flatten)]
        changes: ChangeArguments,
        /// File to write [default: standard output]
        #[arg(short, long, value_name = "FILE.xml")]
        out: Option<PathBuf>,
        /// What disturbs it.
        #[command(flatten)]
        disturbances: ModelArguments,
    },
    /// A controller's deterministic policy as ONNX
    ///
    /// In: `observation`, batch x 14 32-bit floats in SI units, not scaled. Out: `action`, batch x 2 in [-1, 1].
    /// Names, units, control period, body and task are in the file's metadata.
    Onnx {
        /// Which controller.
        #[command(flatten)]
        which: ControllerArguments,
        /// File to write [default: standard output]
        #[arg(short, long, value_name = "FILE.onnx")]
        out: Option<PathBuf>,
    },
    /// A folder for a model hub: a controller, its model card (README.md), its ONNX file and its MJCF body
    ///
    /// The card describes the gaits, measured now by the criteria of the controller's run (or the default 39),
    /// how the controller was trained, and its body.
    Hub {
        /// Which controller.
        #[command(flatten)]
        which: ControllerArguments,
        /// Licence to be shown, e.g. mit, apache-2.0 or cc-by-4.0 [default: none is named]
        #[arg(long, value_name = "ID")]
        license: Option<String>,
        /// Folder to write; files of the same names are replaced
        #[arg(short, long, value_name = "DIR")]
        out: PathBuf,
    },
    /// A recording as CSV
    ///
    /// It is checked and written with exactly the documented columns, in their order.
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
    /// The biped with a play button and a time slider, and plots of support phases, energies, speed, cost and
    /// reward. The page is self-contained: it can be mailed, put on a web site, or opened from disk.
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
