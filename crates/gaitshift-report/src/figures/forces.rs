//! Forces over a stance: the ground's on the body, and along the leg against its length.

use super::Shown;
use super::panels::NEITHER;
use crate::study::{Measured, Plan};
use crate::table::{Table, cell};
use crate::trace::Trace;
use crate::{ReportError, Subject};
use gaitshift_analysis::GaitClass;
use gaitshift_figures::{Chart, PAGE_WIDTH, Series, charts_figure};

pub(super) fn ground_reaction(
    subject: &Subject,
    m: &Measured,
) -> Result<Option<Shown>, ReportError> {
    let weight = subject.weight_n();
    let mut table = Table::new(
        "ground-reaction",
        &["omega_v", "share_of_stance", "vertical_body_weights"],
    );
    let mut charts: Vec<Chart> = [
        (
            GaitClass::Walking,
            "walking",
            Some((1.2, "people walking, greatest")),
        ),
        // Between the others, so that the legend lists commands in their order.
        (GaitClass::Mixed, NEITHER, None),
        (
            GaitClass::Running,
            "running",
            Some((2.5, "people running, greatest")),
        ),
    ]
    .into_iter()
    .map(|(gait, title, people)| {
        let of_gait = m.traces.iter().filter(|(omega_v, _)| {
            m.study
                .at(*omega_v)
                .is_some_and(|summary| summary.gait == gait)
        });
        let series = of_gait.map(|(omega_v, trace)| {
            Series::line(&format!("ω\u{1d65} = {omega_v}"), mean_force(trace, weight))
        });
        Chart {
            title: title.to_owned(),
            x_title: "share of stance".to_owned(),
            y_title: "force (body weights)".to_owned(),
            series: series.collect(),
            levels: people
                .into_iter()
                .map(|(force, word)| (force, word.to_owned()))
                .collect(),
            y_shows: vec![0.0],
            x_range: Some((0.0, 1.0)),
            ..Chart::default()
        }
    })
    .collect();
    charts.retain(|chart| chart.series.iter().any(|s| !s.points.is_empty()));
    for (omega_v, trace) in &m.traces {
        for (x, y) in mean_force(trace, weight) {
            table
                .rows
                .push(vec![cell(Some(*omega_v)), cell(Some(x)), cell(Some(y))]);
        }
    }
    if charts.is_empty() {
        return Ok(None);
    }
    Ok(Some(Shown {
        name: "ground-reaction".to_owned(),
        title: "Vertical ground reaction over stance",
        caption: "Mean over the stances of both legs, from forces at the integration step; the peak at touchdown lasts a few \
                  milliseconds and is higher in each stance than in their mean. Human curves have two humps in walking and one in \
                  running, after a small impact; the greatest force is 1.2 body weights walking at 1.5 m/s and about 2.5 running at \
                  6 m/s (Keller and others, Clin. Biomech. 11, 1996)."
            .to_owned(),
        figure: charts_figure(&charts, charts.len(), PAGE_WIDTH, 150.0)?,
        table,
        wide: true,
    }))
}

/// Bins of a stance in the mean course of a force.
const BINS: usize = 200;

/// The vertical force over stance in body weights, mean over the stances of both legs, as (share of stance, force).
fn mean_force(trace: &Trace, weight: f64) -> Vec<(f64, f64)> {
    let mut sums = vec![0.0; BINS];
    let mut count = 0.0;
    for leg in 0..2 {
        for stance in trace.stances(leg, weight) {
            count += 1.0;
            for (bin, sum) in sums.iter_mut().enumerate() {
                let from = stance.start + stance.len() * bin / BINS;
                let to = (stance.start + stance.len() * (bin + 1) / BINS).max(from + 1);
                let rows = &trace.rows[from..to.min(trace.rows.len())];
                let force: f64 = rows.iter().map(|row| row.normal_n[leg]).sum();
                *sum += force / rows.len().max(1) as f64 / weight;
            }
        }
    }
    if count == 0.0 {
        return Vec::new();
    }
    sums.iter()
        .enumerate()
        .map(|(bin, sum)| ((bin as f64 + 0.5) / BINS as f64, sum / count))
        .collect()
}

/// Force along the leg against leg length in the run.
pub(super) fn leg_springs(
    subject: &Subject,
    m: &Measured,
    plan: &Plan,
) -> Result<Option<Shown>, ReportError> {
    let weight = subject.weight_n();
    let mut table = Table::new(
        "leg-force-length",
        &["omega_v", "leg", "time_s", "length_m", "force_body_weights"],
    );
    let mut charts = Vec::new();
    for (omega_v, gait) in plan.gaits.into_iter().zip(["walking", "running"]) {
        let Some((_, trace)) = m.traces.iter().find(|(w, _)| *w == omega_v) else {
            continue;
        };
        let (mut series, mut touchdowns) = (Vec::new(), Vec::new());
        // Left first: it is blue everywhere, and right vermilion.
        for (leg, name) in [(1, "left leg"), (0, "right leg")] {
            let Some(stance) = trace.stances(leg, weight).into_iter().nth(1) else {
                continue;
            };
            let line: Vec<(f64, f64)> = trace
                .thinned(&stance)
                .map(|(_, row)| (row.length_m[leg], row.axial_n[leg] / weight))
                .collect();
            for (_, row) in trace.thinned(&stance) {
                table.rows.push(vec![
                    cell(Some(omega_v)),
                    name.to_owned(),
                    cell(Some(row.time_s)),
                    cell(Some(row.length_m[leg])),
                    cell(Some(row.axial_n[leg] / weight)),
                ]);
            }
            touchdowns.extend(line.first());
            series.push(Series::line(name, line));
        }
        if !touchdowns.is_empty() {
            series.push(Series::marks("touchdown", touchdowns));
        }
        charts.push(Chart {
            title: format!("{gait}, ω\u{1d65} = {omega_v}"),
            x_title: "leg length (m)".to_owned(),
            y_title: "force (body weights)".to_owned(),
            series,
            y_shows: vec![0.0],
            ..Chart::default()
        });
    }
    if charts.iter().all(|c| c.series.is_empty()) {
        return Ok(None);
    }
    let explained = m.study.landings.iter().filter_map(|l| {
        let share = l.spring_like?;
        Some(format!("{share:.2} at ω_v = {}", l.omega_v))
    });
    let explained: Vec<String> = explained.collect();
    Ok(Some(Shown {
        name: "leg-force-length".to_owned(),
        title: "Leg force against leg length",
        caption: format!(
            "Ground reaction along the leg; one stance of each leg, from touchdown; where both do the same, the right one covers the \
             left. A spring-mass leg would follow a single line up and down. Share of the variance that a straight line explains, over all stances: {}.",
            explained.join(", ")
        ),
        figure: charts_figure(&charts, 2, PAGE_WIDTH, 150.0)?,
        table,
        wide: true,
    }))
}
