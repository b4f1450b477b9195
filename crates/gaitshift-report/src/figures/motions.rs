//! Single motions over time: changes of gait, the round trip, poses through a stride.

use super::Shown;
use crate::ReportError;
use crate::study::{Measured, Plan};
use crate::table::{Table, cell};
use gaitshift_analysis::recording::{Column, column};
use gaitshift_analysis::{GaitClass, Recording};
use gaitshift_figures::{
    COLUMN_WIDTH, Chart, FigureOptions, PAGE_WIDTH, Series, charts_figure, stride_at,
    strobe_within, transition_figure,
};

pub(super) fn change(
    recording: &Recording,
    start_s: f64,
    plan: &Plan,
    name: &str,
    title: &'static str,
) -> Result<Option<Shown>, ReportError> {
    let ramp = (start_s, start_s + plan.ramp_s);
    if recording.duration_s() < ramp.1 {
        return Ok(None);
    }
    let figure = transition_figure(
        recording,
        ramp,
        &FigureOptions {
            width: COLUMN_WIDTH,
            ..FigureOptions::default()
        },
    )?;
    Ok(Some(Shown {
        name: name.to_owned(),
        title,
        caption: format!(
            "Energies and speed; the command changes within {} s (hatched). Potential energy counts from its lowest value.",
            plan.ramp_s
        ),
        figure,
        table: recording_table(name, recording, start_s - 2.5, start_s + plan.ramp_s + 2.5),
        wide: false,
    }))
}

pub(super) fn round_trip(m: &Measured, plan: &Plan) -> Result<Option<Shown>, ReportError> {
    let recording = &m.round_trip;
    if recording.duration_s() < 20.0 + plan.ramp_s {
        return Ok(None);
    }
    let (from_s, to_s) = (6.0, 26.0);
    let time = recording.column(column::TIME_S);
    let window = recording.window(from_s, to_s);
    let series = |of: Column| -> Vec<(f64, f64)> {
        window.map_or_else(Vec::new, |w| {
            (w.start_row()..=w.end_row())
                .map(|row| (time[row], recording.column(of)[row]))
                .collect()
        })
    };
    let charts = [
        ("speed (m/s)", "speed", column::X_VELOCITY_M_PER_S),
        ("ω\u{1d65} (s/m)", "command", column::OMEGA_V),
    ]
    .map(|(y_title, label, of)| Chart {
        x_title: "time (s)".to_owned(),
        y_title: y_title.to_owned(),
        series: vec![Series::line(label, series(of))],
        x_range: Some((from_s, to_s)),
        ..Chart::default()
    });
    let gaits: Vec<String> = m
        .study
        .walk_run_walk
        .iter()
        .map(GaitClass::to_string)
        .collect();
    let took = m.study.round_trip.iter().filter_map(|change| {
        let (from, to) = (change.gait_before?, change.gait_after?);
        let steps = change.steps_to_change?;
        let word = if steps == 1 { "step" } else { "steps" };
        Some(format!(" From {from} to {to} within {steps} {word}."))
    });
    let took: Vec<String> = took.collect();
    let table = recording_table("walk-run-walk", recording, from_s, to_s);
    Ok(Some(Shown {
        name: "walk-run-walk".to_owned(),
        title: "Walk, run and walk again",
        caption: format!(
            "One motion; its gaits: {}.{}",
            gaits.join(", "),
            took.join("")
        ),
        figure: charts_figure(&charts, 1, COLUMN_WIDTH, 100.0)?,
        table,
        wide: false,
    }))
}

pub(super) fn poses(
    recording: &Recording,
    omega_v: f64,
    name: &str,
    title: &'static str,
) -> Result<Option<Shown>, ReportError> {
    let Some((from_s, to_s)) = stride_at(recording, 0.75 * recording.duration_s()) else {
        return Ok(None);
    };
    Ok(Some(Shown {
        name: name.to_owned(),
        title,
        caption: format!("ω_v = {omega_v}. Below, filled: the foot is on the ground."),
        figure: strobe_within(recording, from_s, to_s, 10, PAGE_WIDTH)?,
        table: recording_table(name, recording, from_s, to_s),
        wide: true,
    }))
}

/// A time series of a recording as a table.
fn recording_table(name: &str, recording: &Recording, from_s: f64, to_s: f64) -> Table {
    let mut table = Table::new(name, &[]);
    let columns: Vec<(&str, &[f64])> = recording.every_column().collect();
    table.columns = columns.iter().map(|(name, _)| (*name).to_owned()).collect();
    if let Some(window) = recording.window(from_s, to_s) {
        for row in window.start_row()..=window.end_row() {
            let cells = columns.iter().map(|(_, series)| cell(Some(series[row])));
            table.rows.push(cells.collect());
        }
    }
    table
}
