//! `gaitshift demo`: everything worth seeing of a controller, at once.

use crate::arguments::{ChangeArguments, DemoArguments};
use crate::failure::Failure;
use crate::gaits;
use crate::motion::Subject;
use crate::output;
use crate::transition::{self, Change};
use crate::{evaluate, render};
use gaitshift_analysis::{Recording, TransitionOptions, summarise_transition};
use gaitshift_experiment::{AskedChange, CommandProfile, Criteria};
use gaitshift_figures::AnimationOptions;
use std::path::{Path, PathBuf};

/// The commands of the paper's walk and run.
const WALK: f64 = 0.0;
const RUN: f64 = 3.0;
/// Duration of steady motions, and the time of each from which a stride is drawn, in s.
const STEADY_S: f64 = 20.0;
const STRIDE_AT_S: f64 = 15.0;
/// Time left out of the figures of steady motions, in s.
const SETTLING_S: f64 = 5.0;
/// The animation: when the command begins to rise and to fall, its end and where it is shown from, in s.
const RUN_AT_S: f64 = 6.5;
const WALK_AT_S: f64 = 11.9;
const ROUND_TRIP_S: f64 = 17.9;
const SHOWN_FROM_S: f64 = 4.0;
/// Poses of a stride.
const POSES: usize = 12;

/// Runs the command.
pub fn run(arguments: &DemoArguments) -> Result<(), Failure> {
    let mut subject = Subject::of(
        arguments.which.controller.as_deref(),
        &ChangeArguments::default(),
    )?;
    let folder = &arguments.out;
    output::create_folder(folder)?;
    let criteria = Criteria::default();
    let change = AskedChange::new(WALK, RUN);
    let (walk, run) = (WALK, RUN);

    output::line(&format!(
        "{}, {STEADY_S} s at each command, measured from {SETTLING_S} s on",
        subject.name
    ))?;
    let mut files = Vec::new();
    let mut rows = Vec::new();
    for &omega_v in &criteria.omega_v {
        let recording = subject.record(&CommandProfile::constant(omega_v), STEADY_S)?;
        rows.push(gaits::describe(&recording, SETTLING_S));
        if omega_v == walk {
            files.extend(stride(&recording, "walking", arguments)?);
        }
        if omega_v == run {
            files.extend(stride(&recording, "running", arguments)?);
        }
    }
    gaits::print_rows(&rows)?;
    let sweep = (subject.name.as_str(), evaluate::points(&rows));
    files.extend(evaluate::write_sweep(&[sweep], folder)?);

    for (from, to, file) in [(walk, run, "walk-to-run"), (run, walk, "run-to-walk")] {
        let steady_s = change.steady_s;
        let change = Change::ramp(from, to, steady_s, change.ramp_s, steady_s);
        let recording = subject.record(&change.profile, change.duration_s)?;
        let (start_s, end_s) = change.ramp;
        let summary =
            summarise_transition(&recording, start_s, end_s, &TransitionOptions::default());
        output::line(&format!("\n{}", change.name))?;
        for line in transition::describe(&summary) {
            output::line(&line)?;
        }
        files.extend(transition::write_figure(
            &recording,
            &change,
            &folder.join(file),
        )?);
    }

    let path = folder.join("walk-run-walk.gif");
    write_round_trip(&mut subject, change.ramp_s, &path)?;
    files.insert(0, path);
    output::line("")?;
    output::written(&files)
}

/// Draws a stride, or says that there is none.
fn stride(
    recording: &Recording,
    name: &str,
    arguments: &DemoArguments,
) -> Result<Vec<PathBuf>, Failure> {
    let path = arguments.out.join(name);
    output::remove_picture(&path)?;
    match render::write_stride(recording, STRIDE_AT_S, POSES, &path) {
        Err(Failure::Input(_)) => {
            output::note(&format!(
                "no picture {name}: the motion has no whole stride"
            ));
            Ok(Vec::new())
        }
        result => result,
    }
}

/// Animates the way from one gait to the other and back.
fn write_round_trip(subject: &mut Subject, ramp_s: f64, path: &Path) -> Result<(), Failure> {
    let profile = CommandProfile::constant(WALK)
        .then_ramp(RUN, RUN_AT_S, ramp_s)
        .then_ramp(WALK, WALK_AT_S, ramp_s);
    let recording = subject.record(&profile, ROUND_TRIP_S)?;
    if recording.metadata.fell {
        output::note(&format!(
            "the animation ends at {:.1} s of {ROUND_TRIP_S} s, in a fall",
            recording.duration_s()
        ));
    }
    let options = AnimationOptions {
        fps: 20.0,
        // The start is left out, unless a fall leaves nothing else to show.
        from_s: (recording.duration_s() > RUN_AT_S).then_some(SHOWN_FROM_S),
        ..AnimationOptions::default()
    };
    render::write_animation(&recording, &options, path)
}
