//! `gaitshift stress`: how much a controller bears.

use crate::arguments::{DisturbanceName, StressArguments, distinct, distinct_commands};
use crate::failure::Failure;
use crate::motion::Subject;
use crate::output::{self, number};
use gaitshift_experiment::{Limit, Stress, StressKind, StressPlan, stress};
use gaitshift_figures::{IntervalPanel, IntervalPoint, intervals_figure};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Serialize)]
struct Outcome<'a> {
    controller: &'a str,
    /// What differs from the body and task that it was trained on, in words.
    #[serde(skip_serializing_if = "str::is_empty")]
    changes: &'a str,
    #[serde(flatten)]
    stress: &'a Stress,
}

/// Runs the command.
pub fn run(arguments: &StressArguments) -> Result<(), Failure> {
    let a = arguments;
    let mut plan = if a.quick {
        StressPlan::quick()
    } else {
        StressPlan::default()
    };
    if !a.omega_v.is_empty() {
        plan.omega_v = distinct_commands(&a.omega_v).map_err(Failure::input)?;
    }
    if !a.seed.is_empty() {
        plan.seeds = distinct(&a.seed).map_err(Failure::input)?;
    }
    if !a.only.is_empty() {
        plan.kinds = StressKind::ALL.to_vec();
        plan.kinds
            .retain(|wanted| a.only.iter().any(|name| kind(*name) == *wanted));
    }
    let subject = Subject::load(&a.subject)?;
    let threads = a.threads.count();
    // Better now than when all is measured.
    let folder = a.print.folder(a.out.as_deref(), "out/stress");
    if let Some(folder) = &folder {
        output::create_folder(folder)?;
    }
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(4));
    if let Ok(style) = ProgressStyle::with_template(
        "{bar:30.cyan/blue} {percent:>3} %  {pos} of {len} limits, {eta} left",
    ) {
        bar.set_style(style);
    }
    let progress = |done: usize, total: usize| {
        bar.set_length(total as u64);
        bar.set_position(done as u64);
    };
    let result = stress(
        subject.controller(),
        subject.body(),
        &plan,
        threads,
        &progress,
    );
    bar.finish_and_clear();
    let result = result.map_err(Failure::run)?;

    let circumstances = subject.circumstances();
    let changes = circumstances.trim_start_matches(", ");
    let mut files = Vec::new();
    if let Some(folder) = folder {
        let path = folder.join("stress.json");
        let json = Outcome {
            controller: &subject.name,
            changes,
            stress: &result,
        };
        let text = serde_json::to_string_pretty(&json).map_err(Failure::run)?;
        output::file(&path, (text + "\n").as_bytes())?;
        files.push(path);
        files.extend(write_figure(&result, &folder.join("stress"))?);
    }
    if a.print.json {
        return output::json(&Outcome {
            controller: &subject.name,
            changes,
            stress: &result,
        });
    }
    let plan = &result.plan;
    output::line(&format!(
        "{}{}, {} random starts: median (least to greatest) of the largest disturbance withstood",
        subject.name,
        circumstances,
        plan.seeds.len()
    ))?;
    for line in table(&result) {
        output::line(&line)?;
    }
    for line in notes(plan) {
        output::line(&line)?;
    }
    output::written(&files)
}

fn kind(name: DisturbanceName) -> StressKind {
    match name {
        DisturbanceName::Push => StressKind::Push,
        DisturbanceName::Step => StressKind::Step,
        DisturbanceName::Slope => StressKind::Slope,
        DisturbanceName::Noise => StressKind::Noise,
        DisturbanceName::Latency => StressKind::Latency,
    }
}

/// What the table's numbers mean, of what was tried.
fn notes(plan: &StressPlan) -> Vec<String> {
    let mut notes =
        vec!["> at least the greatest size tried; - fell undisturbed from every start".to_owned()];
    if plan.kinds.contains(&StressKind::Push) {
        notes.push(format!(
            "Pushes last 0.1 s, so that 1 N s is a force of 10 N; the body has to stay up for {} s after them.",
            plan.after_s
        ));
    }
    if plan.kinds.contains(&StressKind::Step) {
        notes.push(format!(
            "A step's face is tried at {} places from 1 to 1.5 m ahead; it has to get 3 m beyond each.",
            plan.phases
        ));
    }
    if plan.kinds.contains(&StressKind::Slope) {
        notes.push("Slopes begin 1 m ahead, and it has to get 5 m along them.".to_owned());
    }
    if [StressKind::Noise, StressKind::Latency]
        .iter()
        .any(|kind| plan.kinds.contains(kind))
    {
        notes.push(format!(
            "Under noise and latency it has to stay up for {} s.",
            plan.after_s
        ));
    }
    notes
}

/// A limit in a table, with `decimals` that its unit needs.
fn cell(limit: &Limit) -> String {
    let decimals = match limit.unit {
        "N s" => 1,
        "m" | "s" | "rad" => 3,
        _ => 2,
    };
    let value = |value: Option<f64>| {
        let sign = match value {
            Some(value) if value >= limit.greatest_tried => ">",
            _ => "",
        };
        format!("{sign}{}", number(value, decimals))
    };
    if limit.median.is_none() {
        return "-".to_owned();
    }
    format!(
        "{} ({} to {})",
        value(limit.median),
        value(limit.least),
        value(limit.greatest)
    )
}

/// What is disturbed, in words.
fn name(limit: &Limit) -> String {
    let phase = limit
        .phase
        .map_or_else(String::new, |phase| format!(", phase {phase}"));
    let which = limit.which.trim_end_matches("_m_per_s");
    let which = which
        .trim_end_matches("_rad_per_s")
        .trim_end_matches("_rad");
    let which = if limit.disturbance == StressKind::Noise {
        which.trim_end_matches("_m")
    } else {
        which
    };
    format!("{} {which}{phase}", limit.disturbance.name())
        .trim_end()
        .to_owned()
}

/// One row for each disturbance, one column for each command.
fn table(result: &Stress) -> Vec<String> {
    let commands = &result.plan.omega_v;
    let mut heading = vec![String::new(), "unit".to_owned()];
    heading.extend(commands.iter().map(|omega_v| format!("ω_v {omega_v}")));
    let mut cells = vec![heading];
    let rows = result.limits.len() / commands.len().max(1);
    for row in 0..rows {
        let of_commands = result.limits[row..].iter().step_by(rows);
        let first = &result.limits[row];
        let mut line = vec![name(first), first.unit.to_owned()];
        line.extend(of_commands.map(cell));
        cells.push(line);
    }
    output::table(&cells, &[0, 1])
}

/// Pushes against the phase of the stride, everything else against the command.
fn write_figure(result: &Stress, path: &Path) -> Result<Vec<PathBuf>, Failure> {
    let commands = &result.plan.omega_v;
    let series: Vec<String> = commands
        .iter()
        .map(|omega_v| format!("ω\u{1d65} = {omega_v}"))
        .collect();
    let mut panels: Vec<IntervalPanel> = Vec::new();
    for limit in &result.limits {
        let title = match limit.phase {
            Some(_) => format!("push {} ({})", limit.which, limit.unit),
            None => format!("{} ({})", name(limit), limit.unit),
        };
        let x_title = match limit.phase {
            Some(_) => "phase of the stride".to_owned(),
            None => "command ω\u{1d65} (s/m)".to_owned(),
        };
        let index = match panels.iter().position(|panel| panel.title == title) {
            Some(index) => index,
            None => {
                panels.push(IntervalPanel {
                    title,
                    x_title,
                    points: Vec::new(),
                });
                panels.len() - 1
            }
        };
        let command = commands.iter().position(|w| *w == limit.omega_v);
        if let (Some(low), Some(middle), Some(high)) = (limit.least, limit.median, limit.greatest) {
            panels[index].points.push(IntervalPoint {
                series: command.unwrap_or(0),
                x: limit.phase.unwrap_or(limit.omega_v),
                low,
                middle,
                high,
            });
        }
    }
    if panels.iter().all(|panel| panel.points.is_empty()) {
        output::remove_picture(path)?;
        return Ok(Vec::new());
    }
    intervals_figure(&series, &panels)
        .and_then(|figure| figure.write(path))
        .map_err(output::figure_failure)
}
