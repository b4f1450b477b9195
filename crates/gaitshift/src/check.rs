//! `gaitshift train --check`: what would be trained, for how long, and what looks like a mistake.

use crate::arguments::TrainArguments;
use crate::failure::Failure;
use crate::output;
use crate::progress::{count, duration};
use crate::train;
use gaitshift_experiment::{Experiment, Judgement, Observer, Progress, Review, Training};
use serde::Serialize;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// How long the pace is measured, after learning has begun, and at most in all.
const MEASURED: Duration = Duration::from_secs(3);
const MOST: Duration = Duration::from_secs(20);

/// A phase as it will be.
#[derive(Serialize)]
struct Phase {
    name: String,
    from_step: u64,
    to_step: u64,
    from_s: Option<f64>,
    to_s: Option<f64>,
    omega_v: [f64; 2],
    omega_v_end: [f64; 2],
    changes: Vec<String>,
}

#[derive(Serialize)]
struct Report {
    name: String,
    seed: u64,
    base: Option<String>,
    steps: u64,
    steps_per_s: Option<f64>,
    phases: Vec<Phase>,
    differences: Vec<String>,
    warnings: Vec<String>,
}

/// Runs the command.
pub fn run(arguments: &TrainArguments) -> Result<(), Failure> {
    let experiment = train::experiment(arguments)?;
    let review = Review::of(&arguments.experiment, &experiment).map_err(Failure::input)?;
    let steps_per_s = pace(&experiment)?;
    let report = Report {
        name: experiment.name.clone(),
        seed: experiment.seed,
        base: review.base,
        steps: experiment.curriculum.total_steps(),
        steps_per_s,
        phases: phases(&experiment, steps_per_s),
        differences: review.differences,
        warnings: review.warnings,
    };
    if arguments.json {
        return output::json(&report);
    }
    print(&report)
}

fn print(r: &Report) -> Result<(), Failure> {
    let time = |steps: u64| match r.steps_per_s {
        Some(rate) => format!("about {}", duration(steps as f64 / rate)),
        None => "unknown time".to_owned(),
    };
    let pace = r.steps_per_s.map_or_else(String::new, |rate| {
        format!(
            " at {} steps/s, measured just now; evaluations come on top",
            count(rate as u64)
        )
    });
    output::line(&format!(
        "{}, seed {}: {} steps, {}{pace}",
        r.name,
        r.seed,
        count(r.steps),
        time(r.steps)
    ))?;
    output::line("")?;
    let titles = ["phase", "from step", "to step", "until", "ω_v", ""];
    let mut cells = vec![titles.map(str::to_owned).to_vec()];
    for phase in &r.phases {
        let [low, high] = phase.omega_v;
        let range = if phase.omega_v == phase.omega_v_end {
            format!("{low} to {high}")
        } else {
            let [end_low, end_high] = phase.omega_v_end;
            format!("{low} to {high}, in the end {end_low} to {end_high}")
        };
        cells.push(vec![
            phase.name.clone(),
            count(phase.from_step),
            count(phase.to_step),
            phase.to_s.map_or_else(|| "-".to_owned(), duration),
            range,
        ]);
    }
    for (line, changes) in output::table(&cells, &[0, 4])
        .iter()
        .zip(std::iter::once(&Vec::new()).chain(r.phases.iter().map(|phase| &phase.changes)))
    {
        output::line(line)?;
        for change in changes {
            output::line(&format!("    {change}"))?;
        }
    }
    let list = |title: &str, lines: &[String]| -> Result<(), Failure> {
        output::line("")?;
        output::line(title)?;
        lines
            .iter()
            .try_for_each(|line| output::line(&format!("  {line}")))
    };
    match &r.base {
        Some(base) if r.differences.is_empty() => list(&format!("As {base}."), &[])?,
        Some(base) => list(&format!("Other than in {base}:"), &r.differences)?,
        None if r.differences.is_empty() => {}
        None => list("Changed:", &r.differences)?,
    }
    if r.warnings.is_empty() {
        list("Nothing looks like a mistake.", &[])
    } else {
        list("Warnings:", &r.warnings)
    }
}

fn phases(experiment: &Experiment, steps_per_s: Option<f64>) -> Vec<Phase> {
    let mut from_step = 0;
    let time = |step: u64| steps_per_s.map(|rate| step as f64 / rate);
    let phases = experiment.curriculum.phases.iter();
    phases
        .map(|phase| {
            let to_step = from_step + phase.steps;
            let resolved = Phase {
                name: phase.name.clone(),
                from_step,
                to_step,
                from_s: time(from_step),
                to_s: time(to_step),
                omega_v: phase.omega_v,
                omega_v_end: phase.omega_v_end.unwrap_or(phase.omega_v),
                changes: changes(phase),
            };
            from_step = to_step;
            resolved
        })
        .collect()
}

/// What else a phase changes, by its keys in the file.
fn changes(phase: &gaitshift_task::Phase) -> Vec<String> {
    let shown = ["name", "steps", "omega_v", "omega_v_end"];
    let Ok(serde_json::Value::Object(table)) = serde_json::to_value(phase) else {
        return Vec::new();
    };
    let other = table
        .iter()
        .filter(|(key, _)| !shown.contains(&key.as_str()));
    other
        .map(|(key, value)| format!("{key}: {value}"))
        .collect()
}

/// Environment steps per second once it learns, measured on the experiment itself in a folder that is removed; `None` if
/// learning begins too late to be seen.
fn pace(experiment: &Experiment) -> Result<Option<f64>, Failure> {
    let folder = Scratch::new();
    let training = Training::new(experiment.clone(), &folder.0, "gaitshift train --check");
    let mut watcher = Pace {
        learning_starts: experiment.training.learning_starts,
        begun: Instant::now(),
        first: None,
        last: None,
    };
    training
        .map_err(Failure::input)?
        .run(&mut watcher)
        .map_err(Failure::run)?;
    Ok(watcher.first.zip(watcher.last).and_then(|(first, last)| {
        let seconds = last.0.duration_since(first.0).as_secs_f64();
        (seconds > 0.0 && last.1 > first.1).then(|| (last.1 - first.1) as f64 / seconds)
    }))
}

/// A folder of its own that goes with it.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> Self {
        let name = format!("gaitshift-check-{}", std::process::id());
        Self(std::env::temp_dir().join(name))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

struct Pace {
    learning_starts: u64,
    begun: Instant,
    first: Option<(Instant, u64)>,
    last: Option<(Instant, u64)>,
}

impl Observer for Pace {
    fn progress(&mut self, p: &Progress) {
        let now = (Instant::now(), p.step);
        if p.step > self.learning_starts {
            self.first.get_or_insert(now);
            self.last = Some(now);
        }
    }

    fn evaluated(&mut self, _: &Progress, _: &Judgement, _: bool) {}

    fn note(&mut self, _: &str) {}

    fn stop_requested(&self) -> bool {
        self.first.is_some_and(|first| first.0.elapsed() > MEASURED) || self.begun.elapsed() > MOST
    }
}
