//! The table of gaits: a row for each motion.

use crate::failure::Failure;
use crate::output;
use gaitshift_analysis::recording::{Recording, column};
use gaitshift_analysis::{AnalysisOptions, GaitClass, GaitRule, GaitSummary, summarise};
use serde::Serialize;
use std::path::Path;

/// A row of the table: a command and the motion it makes.
#[derive(Debug, Serialize)]
pub struct Row {
    /// The command, if it is constant over the part described.
    pub omega_v: Option<f64>,
    /// The seed that drew the start; `None` (null in JSON) at the default start.
    pub seed: Option<u64>,
    /// How far forward the hip got, in m; `None` of an empty recording.
    pub reached_m: Option<f64>,
    /// What disturbed it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub disturbance: Option<serde_json::Value>,
    /// The motion.
    #[serde(flatten)]
    pub summary: GaitSummary,
}

/// One row from a recording.
pub fn describe(recording: &Recording, settling_time_s: f64) -> Row {
    let options = AnalysisOptions {
        settling_time_s,
        ..AnalysisOptions::default()
    };
    let summary = summarise(recording, &options);
    let (from_s, to_s) = (summary.window_start_s, summary.window_end_s);
    let window = from_s
        .zip(to_s)
        .and_then(|(from_s, to_s)| recording.window(from_s, to_s))
        .or_else(|| recording.whole());
    let commands = recording.column(column::OMEGA_V);
    let described = match window {
        Some(window) => &commands[window.start_row()..=window.end_row()],
        None => commands,
    };
    let first = described.first().copied();
    Row {
        omega_v: first.filter(|&first| described.iter().all(|&command| command == first)),
        seed: None,
        reached_m: recording
            .column(column::X_M)
            .iter()
            .copied()
            .reduce(f64::max),
        disturbance: recording.metadata.disturbance.clone(),
        summary,
    }
}

/// Prints rows as a table.
pub fn print_rows(rows: &[Row]) -> Result<(), Failure> {
    let rows = rows.iter().map(|row| (row.omega_v, &row.summary));
    print_gaits(rows, "profile")
}

/// Prints gaits as a table, each with the command that was held, or what to call one that was not.
pub fn print_gaits<'a>(
    rows: impl Iterator<Item = (Option<f64>, &'a GaitSummary)>,
    not_held: &str,
) -> Result<(), Failure> {
    let named = rows.map(|(omega_v, summary)| {
        let command = omega_v.map_or_else(|| not_held.to_owned(), |omega_v| omega_v.to_string());
        (command, summary)
    });
    let named: Vec<_> = named.collect();
    for line in output::gait_table(named.iter().map(|(command, s)| (command.clone(), *s))) {
        output::line(&line)?;
    }
    print_too_short(
        named
            .iter()
            .map(|(command, s)| (format!("ω_v {command}"), *s)),
    )
}

/// The same where motions have names, in a column of this title, and without saying which are too short.
pub fn print_named_gaits<'a>(
    title: &str,
    rows: impl Iterator<Item = (Option<f64>, String, &'a GaitSummary)>,
) -> Result<(), Failure> {
    let cells = rows.map(|(omega_v, name, summary)| {
        let command = omega_v.map_or_else(|| "varying".to_owned(), |omega_v| omega_v.to_string());
        (vec![command, name], summary)
    });
    output::named_gait_table(&["ω_v", title], cells)
        .iter()
        .try_for_each(|line| output::line(line))
}

/// Says which motions are too short to have a gait.
pub fn print_too_short<'a>(
    rows: impl Iterator<Item = (String, &'a GaitSummary)>,
) -> Result<(), Failure> {
    for (name, summary) in rows {
        if let Some(why) = too_short(summary) {
            output::text(&format!("{name}: {why}"), 2)?;
        }
    }
    Ok(())
}

/// Of several motions that a table sums up, says how many are too short to have a gait.
pub fn print_too_short_of<'a>(rows: impl Iterator<Item = &'a Row> + Clone) -> Result<(), Failure> {
    let mut short = rows.clone().filter_map(|row| too_short(&row.summary));
    let Some(first) = short.next() else {
        return Ok(());
    };
    let (short, all) = (1 + short.count(), rows.count());
    output::text(
        &format!("{short} of {all} motions tell no gait; the first: {first}"),
        2,
    )
}

/// Why a motion has no gait if what is missing is steps: a walk of three steps is "mixed" like a stumble.
pub fn too_short(s: &GaitSummary) -> Option<String> {
    let needed = GaitRule::default().min_steps;
    let Some((from_s, to_s)) = s.window_start_s.zip(s.window_end_s) else {
        let why = "nothing is left to measure; a longer motion would tell";
        return (s.gait == GaitClass::Mixed).then(|| why.to_owned());
    };
    let steps = match s.steps {
        0 => "no step".to_owned(),
        1 => "1 step".to_owned(),
        steps => format!("{steps} steps"),
    };
    (s.gait == GaitClass::Mixed && s.steps < needed).then(|| {
        format!(
            "{steps} from {from_s:.2} to {to_s:.2} s, too few to tell a gait, which takes {needed}; a longer motion would tell"
        )
    })
}

/// Reads a recording whose rows are one control period apart, as every analysis takes for granted.
pub fn read_recording(path: &Path) -> Result<Recording, Failure> {
    let recording = Recording::read_csv(path).map_err(Failure::input)?;
    match recording.off_period() {
        None => Ok(recording),
        Some((row, apart_s)) => Err(Failure::input(format!(
            "{}, line {}: {apart_s} s after the row before, where the first line says `control_period_s` = {}; rows are missing \
             or the period is another: record the motion again, or correct the first line",
            path.display(),
            // After the first line and the header.
            row + 3,
            recording.metadata.control_period_s
        ))),
    }
}
