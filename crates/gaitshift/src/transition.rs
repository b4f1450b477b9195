//! `gaitshift transition`: the command changes within a motion.

use crate::arguments::TransitionArguments;
use crate::failure::Failure;
use crate::gaits;
use crate::motion::{Subject, read_profile, write_recording};
use crate::output::{self, number};
use crate::unseen;
use gaitshift_analysis::recording::{Recording, column, ended_by};
use gaitshift_analysis::{
    GaitChange, GaitClass, REST_S, TransitionOptions, TransitionSummary, changes_of_gait,
    summarise_transition,
};
use gaitshift_experiment::CommandProfile;
use gaitshift_figures::{FigureOptions, transition_figure};
use gaitshift_task::EndReason;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// What the figure shows before the ramp and after it, in s.
const SHOWN_S: f64 = 2.5;
/// Name of the recording in the folder.
const RECORDING: &str = "recording.csv";

/// A change of the command.
#[derive(Debug)]
pub struct Change {
    /// The command over time.
    pub profile: CommandProfile,
    /// When it changes: begin and end, in s.
    pub ramp: (f64, f64),
    /// Duration of the whole motion, in s.
    pub duration_s: f64,
    /// The change in words.
    pub name: String,
}

impl Change {
    /// From one command to another.
    pub fn ramp(from: f64, to: f64, start_s: f64, ramp_s: f64, after_s: f64) -> Self {
        Self {
            profile: CommandProfile::ramp(from, to, start_s, ramp_s),
            ramp: (start_s, start_s + ramp_s),
            duration_s: start_s + ramp_s + after_s,
            name: format!("ω_v {from} → {to} in {ramp_s} s"),
        }
    }

    /// As a file says.
    fn read(path: &Path, after_s: f64) -> Result<Self, Failure> {
        let profile = read_profile(path)?;
        let ramp = profile.change_s().ok_or_else(|| {
            Failure::input(format!(
                "{}: `omega_v` never changes; for a constant command use `gaitshift evaluate`",
                path.display()
            ))
        })?;
        if ramp.1 <= 0.0 {
            return Err(Failure::input(format!(
                "{}: `omega_v` changes from {} s to {} s only, before the motion begins at 0 s; give the change a later time",
                path.display(),
                ramp.0,
                ramp.1
            )));
        }
        Ok(Self {
            ramp,
            duration_s: profile.end_s().max(0.0) + after_s,
            name: format!("ω_v as in {}", path.display()),
            profile,
        })
    }
}

#[derive(Serialize)]
struct Outcome<'a> {
    /// The seed that drew the start; null at the default start.
    seed: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    disturbance: Option<&'a serde_json::Value>,
    #[serde(flatten)]
    summary: &'a TransitionSummary,
    changes: &'a [GaitChange],
}

/// Runs the command.
pub fn run(arguments: &TransitionArguments) -> Result<(), Failure> {
    let a = arguments;
    let change = match &a.command_profile {
        Some(path) => Change::read(path, a.after_s)?,
        None => Change::ramp(a.from, a.to, a.start_s, a.ramp_s, a.after_s),
    };
    let mut subject = Subject::load(&a.subject)?;
    subject.start_at(a.seed);
    subject.disturb(a.disturbances.read()?);
    let folder = a.print.folder(a.out.as_deref(), "out/transition");
    if let Some(folder) = &folder {
        output::create_folder(folder)?;
        if let Some(profile) = &a.command_profile {
            output::not_over(profile, &folder.join(RECORDING))?;
        }
    }
    let recording = subject.record(&change.profile, change.duration_s)?;
    let (start_s, end_s) = change.ramp;
    let options = TransitionOptions::default();
    let summary = summarise_transition(&recording, start_s, end_s, &options);
    let changes = changes_of_gait(&recording, &change.profile.changes_s(REST_S), &options);

    let mut files = Vec::new();
    unseen::note(
        [gaits::describe(&recording, start_s)].iter(),
        subject.disturbance(),
    );
    if let Some(folder) = folder {
        files.push(write_recording(&recording, &folder, RECORDING)?);
        files.extend(write_figure(
            &recording,
            &change,
            &folder.join("transition"),
        )?);
    }
    if a.print.json {
        return output::json(&Outcome {
            seed: a.seed,
            disturbance: recording.metadata.disturbance.as_ref(),
            summary: &summary,
            changes: &changes,
        });
    }
    output::line(&format!(
        "{}, {}{}, {} from {start_s} s on",
        subject.name,
        subject.start_name(),
        subject.circumstances(),
        change.name
    ))?;
    for line in describe(&summary) {
        output::line(&line)?;
    }
    for line in describe_changes(&changes) {
        output::line(&line)?;
    }
    output::written(&files)
}

/// Writes the figure of a change as SVG and PNG.
pub fn write_figure(
    recording: &Recording,
    change: &Change,
    path: &Path,
) -> Result<Vec<PathBuf>, Failure> {
    let (start_s, end_s) = change.ramp;
    let last_s = recording
        .column(column::TIME_S)
        .last()
        .copied()
        .unwrap_or(0.0);
    // A motion that fell before the ramp is shown up to its fall.
    let options = FigureOptions {
        from_s: Some((start_s - SHOWN_S).min(last_s - 2.0 * SHOWN_S).max(0.0)),
        to_s: Some((end_s + SHOWN_S).min(last_s)),
        // Figures have a subscript, terminals may not.
        title: Some(change.name.replacen("ω_v", "ω\u{1d65}", 1)),
        ..FigureOptions::default()
    };
    transition_figure(recording, change.ramp, &options)
        .and_then(|figure| figure.write(path))
        .map_err(output::figure_failure)
}

/// How long a change of gait takes, in words.
fn within(steps: Option<usize>) -> String {
    match steps {
        Some(1) => ", changed with the first step".to_owned(),
        Some(steps) => format!(", changed within {steps} steps"),
        None => String::new(),
    }
}

/// Changes in a line each, where there are several.
pub fn describe_changes(changes: &[GaitChange]) -> Vec<String> {
    if changes.len() < 2 {
        return Vec::new();
    }
    let line = |change: &GaitChange| {
        format!(
            "{:16}{} → {}{}",
            format!("from {} s on", change.start_s),
            gait_name(change.gait_before),
            gait_name(change.gait_after),
            within(change.steps_to_change)
        )
    };
    changes.iter().map(line).collect()
}

fn gait_name(gait: Option<GaitClass>) -> String {
    gait.map_or_else(|| "-".to_owned(), |gait| gait.to_string())
}

/// A change in a few lines.
pub fn describe(s: &TransitionSummary) -> Vec<String> {
    let both = |before: Option<f64>, after: Option<f64>| {
        format!("{} → {}", number(before, 2), number(after, 2))
    };
    let fate = if s.survived {
        format!("upright to the end ({:.1} s)", s.survived_s)
    } else if s.ended_by == ended_by::DIVERGED {
        format!("diverged at {:.2} s", s.survived_s)
    } else if [EndReason::Pitch, EndReason::HipHeight]
        .map(EndReason::name)
        .contains(&s.ended_by.as_str())
    {
        format!("fell at {:.2} s", s.survived_s)
    } else {
        format!("ended at {:.2} s by `{}`", s.survived_s, s.ended_by)
    };
    let steps = within(s.steps_to_change);
    let mut lines = vec![
        fate,
        format!(
            "gait            {} → {}{steps}",
            gait_name(s.gait_before),
            gait_name(s.gait_after)
        ),
    ];
    let parts = [("before", &s.before), ("after", &s.after)];
    let short = parts.iter().filter_map(|(part, summary)| {
        let why = gaits::too_short(summary.as_ref()?)?;
        Some(format!("{:16}{part}: {why}", ""))
    });
    lines.extend(short);
    lines.extend([
        format!(
            "speed           {} m/s",
            both(s.speed_before_m_per_s, s.speed_after_m_per_s)
        ),
        format!(
            "Froude number   {}",
            both(
                s.before.as_ref().and_then(|s| s.froude),
                s.after.as_ref().and_then(|s| s.froude)
            )
        ),
        format!(
            "double support  {}",
            both(s.double_support_before, s.double_support_after)
        ),
        format!("flight          {}", both(s.flight_before, s.flight_after)),
        format!(
            "correlation of kinetic and potential energy  {}",
            both(
                s.kinetic_potential_correlation_before,
                s.kinetic_potential_correlation_after
            )
        ),
    ]);
    lines
}
