//! `gaitshift analyse`: what recordings show, whichever program wrote them.

use crate::arguments::{AnalyseArguments, distinct_paths};
use crate::failure::Failure;
use crate::gaits::{
    Row, describe, print_gaits, print_named_gaits, print_too_short, read_recording,
};
use crate::output;
use crate::transition;
use gaitshift_analysis::recording::Recording;
use gaitshift_analysis::{
    GaitChange, TransitionOptions, TransitionSummary, changes_of_gait, command_changes,
    summarise_transition,
};
use serde::Serialize;
use std::path::Path;

#[derive(Serialize)]
struct Motion {
    recording: String,
    controller: String,
    #[serde(flatten)]
    row: Row,
}

#[derive(Serialize)]
struct Motions {
    rows: Vec<Motion>,
}

#[derive(Serialize)]
struct Change {
    recording: String,
    controller: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    disturbance: Option<serde_json::Value>,
    #[serde(flatten)]
    summary: TransitionSummary,
    changes: Vec<GaitChange>,
}

#[derive(Serialize)]
struct Changes {
    transitions: Vec<Change>,
}

/// Runs the command.
pub fn run(arguments: &AnalyseArguments) -> Result<(), Failure> {
    distinct_paths(&arguments.recordings).map_err(Failure::input)?;
    let recordings = arguments
        .recordings
        .iter()
        .map(|path| Ok((path.as_path(), read_recording(path)?)))
        .collect::<Result<Vec<_>, Failure>>()?;
    if arguments.transition {
        changes(&recordings, arguments.print.json)
    } else {
        rows(&recordings, arguments)
    }
}

fn rows(recordings: &[(&Path, Recording)], arguments: &AnalyseArguments) -> Result<(), Failure> {
    let rows: Vec<Motion> = recordings
        .iter()
        .map(|(path, recording)| Motion {
            recording: path.display().to_string(),
            controller: recording.metadata.controller.clone(),
            row: describe(recording, arguments.settling_s),
        })
        .collect();
    if arguments.print.json {
        return output::json(&Motions { rows });
    }
    if rows.len() == 1 {
        let rows = rows
            .iter()
            .map(|Motion { row, .. }| (row.omega_v, &row.summary));
        return print_gaits(rows, "varying");
    }
    let named = rows
        .iter()
        .map(|Motion { recording, row, .. }| (recording.clone(), &row.summary));
    print_named_gaits(
        "recording",
        rows.iter()
            .map(|Motion { recording, row, .. }| (row.omega_v, recording.clone(), &row.summary)),
    )?;
    print_too_short(named)
}

fn changes(recordings: &[(&Path, Recording)], json: bool) -> Result<(), Failure> {
    let mut transitions = Vec::new();
    for (path, recording) in recordings {
        let ramps = command_changes(recording);
        let (Some(&(ramp_start_s, _)), Some(&(_, ramp_end_s))) = (ramps.first(), ramps.last())
        else {
            return Err(Failure::input(format!(
                "{}: `omega_v` never changes, so there is no transition; leave --transition out",
                path.display()
            )));
        };
        let options = TransitionOptions::default();
        transitions.push(Change {
            recording: path.display().to_string(),
            controller: recording.metadata.controller.clone(),
            disturbance: recording.metadata.disturbance.clone(),
            summary: summarise_transition(recording, ramp_start_s, ramp_end_s, &options),
            changes: changes_of_gait(recording, &ramps, &options),
        });
    }
    if json {
        return output::json(&Changes { transitions });
    }
    for change in &transitions {
        output::line(&format!(
            "{}: ω_v changes from {} s to {} s",
            change.recording, change.summary.ramp_start_s, change.summary.ramp_end_s
        ))?;
        let one_by_one = transition::describe_changes(&change.changes);
        for line in transition::describe(&change.summary)
            .iter()
            .chain(&one_by_one)
        {
            output::line(line)?;
        }
    }
    Ok(())
}
