//! The returns of the training's episodes.

use super::Shown;
use crate::study::{Measured, Study};
use crate::table::{Table, cell};
use crate::{Episodes, ReportError};
use gaitshift_figures::{COLUMN_WIDTH, Chart, Series, charts_figure, episode_returns_figure};
use std::collections::BTreeMap;

/// The experiments that the paper's Fig. 4 compares.
const PHASE_ONE: [(&str, &str); 2] = [
    ("paper", "with phase I"),
    ("paper, without phase I", "without phase I"),
];

/// Environment steps over which the returns of a seed are averaged.
const STEPS_EACH: f64 = 100_000.0;

/// The returns with and without phase I over each other, where the runs of both are there.
pub(super) fn phase_one(runs: &[(&Study, &Episodes)]) -> Result<Option<Shown>, ReportError> {
    let mut table = Table::new(
        "fig4-phase-one",
        &["experiment", "seed", "million_steps", "mean_return"],
    );
    let mut series = Vec::new();
    for (experiment, label) in PHASE_ONE {
        let mut courses = Vec::new();
        for (study, episodes) in runs.iter().filter(|(s, _)| s.group == experiment) {
            let run = mean_returns(episodes);
            for &(steps, value) in &run {
                table.rows.push(vec![
                    experiment.to_owned(),
                    study.seed.to_string(),
                    cell(Some(steps)),
                    cell(Some(value)),
                ]);
            }
            if !run.is_empty() {
                courses.push(run);
            }
        }
        if courses.is_empty() {
            return Ok(None);
        }
        let mut at: BTreeMap<i64, Vec<f64>> = BTreeMap::new();
        for &(steps, value) in courses.iter().flatten() {
            // The middles of the bins are the same in all runs.
            at.entry((steps * 1e6).round() as i64)
                .or_default()
                .push(value);
        }
        let mean = at.into_iter().map(|(steps, values)| {
            (
                steps as f64 / 1e6,
                values.iter().sum::<f64>() / values.len() as f64,
            )
        });
        let name = match courses.len() {
            1 => format!("{label}, one seed"),
            n => format!("{label}, {n} seeds"),
        };
        series.push(Series::line(&name, mean.collect()).of_runs(courses));
    }
    let chart = Chart {
        x_title: "environment steps (millions)".to_owned(),
        y_title: "mean return of episodes".to_owned(),
        series,
        y_shows: vec![0.0],
        ..Chart::default()
    };
    Ok(Some(Shown {
        name: "fig4-phase-one".to_owned(),
        title: "Returns with and without phase I (Fig. 4)",
        caption: format!(
            "Mean return of the episodes that end within {STEPS_EACH} steps: thin of every seed, thick of all. A long episode under a high \
             command has a high return, so the range of the command moves it too."
        ),
        figure: charts_figure(&[chart], 1, COLUMN_WIDTH, 190.0)?,
        table,
        wide: false,
    }))
}

/// Mean returns as (million steps, return), each at the middle of its steps.
fn mean_returns(episodes: &Episodes) -> Vec<(f64, f64)> {
    let mut bins: BTreeMap<i64, Vec<f64>> = BTreeMap::new();
    for (step, value) in episodes.steps.iter().zip(&episodes.returns) {
        let bin = bins.entry((step / STEPS_EACH).floor() as i64);
        bin.or_default().push(*value);
    }
    bins.into_iter()
        .map(|(bin, values)| {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            ((bin as f64 + 0.5) * STEPS_EACH / 1e6, mean)
        })
        .collect()
}

pub(super) fn episodes(m: &Measured) -> Result<Option<Shown>, ReportError> {
    let e = &m.episodes;
    if e.steps.is_empty() {
        return Ok(None);
    }
    let mut table = Table::new("fig4-returns", &["step", "omega_v", "return", "fell"]);
    for k in 0..e.steps.len() {
        table.rows.push(vec![
            cell(Some(e.steps[k])),
            cell(Some(e.omega_v[k])),
            cell(Some(e.returns[k])),
            e.fell[k].to_string(),
        ]);
    }
    Ok(Some(Shown {
        name: "fig4-returns".to_owned(),
        title: "Return of every episode over training (Fig. 4)",
        caption: "Each dot is an episode; its shade is the command.".to_owned(),
        figure: episode_returns_figure(&e.steps, &e.returns, &e.omega_v)?,
        table,
        wide: false,
    }))
}
