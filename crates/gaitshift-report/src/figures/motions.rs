//! Single motions over time: changes of gait, the round trip, poses through a stride.

use super::Shown;
use super::panels::OMEGA_V;
use crate::ReportError;
use crate::study::{JOURNAL_RAMP_S, Measured, Plan};
use crate::table::{Table, cell};
use gaitshift_analysis::recording::{Column, column};
use gaitshift_analysis::steps::{Step, find_steps};
use gaitshift_analysis::support::{ContactRule, Support};
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
    // A run needs half a dozen steps to become a walk again.
    let (from_s, to_s) = (ramp.0 - 1.5, ramp.1 + 4.5);
    let figure = transition_figure(
        recording,
        ramp,
        &FigureOptions {
            from_s: Some(from_s),
            to_s: Some(to_s.min(recording.duration_s())),
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
        table: recording_table(name, recording, from_s, to_s),
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
    let line = |label: &str, of: Column| vec![Series::line(label, series(of))];
    let charts = [
        ("speed (m/s)", line("speed", column::X_VELOCITY_M_PER_S)),
        ("share of a step", shares_of_steps(recording, from_s, to_s)),
        (OMEGA_V, line("command", column::OMEGA_V)),
    ]
    .map(|(y_title, series)| Chart {
        x_title: "time (s)".to_owned(),
        y_title: y_title.to_owned(),
        series,
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
            "One motion; its gaits: {}. Of each step the share with both feet on the ground, and with none.{} Steps are counted from \
             where the command begins to change; it does so within {JOURNAL_RAMP_S} s.",
            gaits.join(", "),
            took.join("")
        ),
        figure: charts_figure(&charts, 1, COLUMN_WIDTH, 84.0)?,
        table,
        wide: false,
    }))
}

/// Of each step double support and flight, at the middle of the step.
fn shares_of_steps(recording: &Recording, from_s: f64, to_s: f64) -> Vec<Series> {
    let steps = recording
        .window(from_s, to_s)
        .map_or_else(Vec::new, |window| {
            let support = Support::find(recording, &ContactRule::default());
            find_steps(recording, &support, window)
        });
    let share = |of: fn(&Step) -> usize| {
        let lasting = steps.iter().filter(|step| step.end_row > step.start_row);
        let points = lasting.map(|step| {
            let periods = (step.end_row - step.start_row) as f64;
            (
                step.start_s + 0.5 * step.duration_s,
                of(step) as f64 / periods,
            )
        });
        points.collect()
    };
    vec![
        Series::marks("double support", share(|step| step.double_support_periods)),
        Series::marks("flight", share(|step| step.flight_periods)),
    ]
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
        caption: format!(
            "ω_v = {omega_v}; it moves to the right. The right leg is orange, the left one blue, the black line the way of the hip. \
             Below, filled: the foot is on the ground, from the beginning of the control period in which it lands, when it can still be \
             some millimetres above."
        ),
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
