//! `gaitshift train --check`: what would be trained, for how long, and what looks like a mistake.

use crate::arguments::TrainArguments;
use crate::failure::Failure;
use crate::output;
use crate::progress::{count, duration};
use crate::train::{self, catch_interrupts};
use gaitshift_experiment::{
    Earned, Experiment, Review, earned, starting_controller, steps_per_second,
};
use gaitshift_task::Randomization;
use serde::Serialize;
use serde_json::{Map, Value};
use std::sync::atomic::Ordering;
use std::time::Duration;

/// How long the pace is measured.
const MEASURED: Duration = Duration::from_secs(3);

/// Weights of which an update takes about a second.
const LARGE: usize = 10_000_000;

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

/// What the reward's terms earn at one command, by name.
#[derive(Serialize)]
struct Reward {
    omega_v: f64,
    duration_s: f64,
    #[serde(skip)]
    ended: bool,
    terms: Map<String, Value>,
    sum: f64,
}

impl From<Earned> for Reward {
    fn from(earned: Earned) -> Self {
        let sum = earned.terms.iter().map(|(_, value)| value).sum();
        let terms = earned.terms.into_iter();
        Self {
            omega_v: earned.omega_v,
            duration_s: earned.duration_s,
            ended: earned.ended,
            terms: terms.map(|(name, value)| (name, value.into())).collect(),
            sum,
        }
    }
}

#[derive(Serialize)]
struct Report {
    name: String,
    seed: u64,
    /// Those of --seeds, one run after the other.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    seeds: Vec<u64>,
    base: Option<String>,
    steps: u64,
    steps_per_s: Option<f64>,
    phases: Vec<Phase>,
    reward: Vec<Reward>,
    criteria: String,
    differences: Vec<String>,
    warnings: Vec<String>,
}

/// Runs the command.
pub fn run(arguments: &TrainArguments) -> Result<(), Failure> {
    let experiment = train::experiment(arguments)?;
    let seeds = train::seeds(arguments)?;
    starting_controller(&experiment).map_err(Failure::input)?;
    let review = Review::of(&arguments.experiment, &experiment).map_err(Failure::input)?;
    let reward = earned(&experiment).map_err(Failure::input)?;
    let learner = &experiment.learner;
    let weights: usize = [
        &learner.actor_hidden,
        &learner.critic_hidden,
        &learner.critic_hidden,
    ]
    .iter()
    .flat_map(|hidden| hidden.windows(2).map(|pair| pair[0] * pair[1]))
    .sum();
    if weights > LARGE {
        output::note(&format!(
            "networks of {} million weights: measuring the pace of a few updates takes a while",
            weights / 1_000_000
        ));
    }
    // So that its scratch folder is removed.
    let interrupted = catch_interrupts("stopping")?;
    let stop = || interrupted.load(Ordering::SeqCst);
    // What is wrong with the file is to be told all the same.
    let pace = steps_per_second(&experiment, MEASURED, &stop).unwrap_or_else(|cause| {
        output::note(&format!("the pace cannot be measured: {cause}"));
        0.0
    });
    if stop() {
        return Err(Failure::Interrupted);
    }
    // Of a run that is over before it can be measured nothing is known.
    let steps_per_s = (pace > 0.0).then_some(pace);
    let report = Report {
        name: experiment.name.clone(),
        seed: seeds.first().copied().unwrap_or(experiment.seed),
        seeds,
        base: review.base,
        steps: experiment.curriculum.total_steps(),
        steps_per_s,
        phases: phases(&experiment, steps_per_s),
        reward: reward.into_iter().map(Reward::from).collect(),
        criteria: experiment.criteria.to_string(),
        differences: review.differences,
        warnings: review.warnings,
    };
    if arguments.print.json {
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
            " at {} steps/s, measured just now, without evaluations",
            count(rate as u64)
        )
    });
    let (seeds, all) = match &r.seeds[..] {
        [first, .., last] => {
            let runs = r.seeds.len() as u64;
            let all = format!(" each, {} for all {runs}", time(runs * r.steps));
            (format!("{runs} seeds from {first} to {last}"), all)
        }
        _ => (format!("seed {}", r.seed), String::new()),
    };
    let heading = format!(
        "{}, {seeds}: {} steps, {}{all}{pace}",
        r.name,
        count(r.steps),
        time(r.steps)
    );
    output::text(&heading, 2)?;
    output::line("")?;
    let titles = ["phase", "from step", "to step", "until", "ω_v", ""];
    let mut cells = vec![titles.map(str::to_owned).to_vec()];
    for phase in &r.phases {
        let [low, high] = phase.omega_v;
        let range = if phase.omega_v == phase.omega_v_end {
            format!("{low} to {high}")
        } else {
            let [end_low, end_high] = phase.omega_v_end;
            format!("{low} to {high}, at its end {end_low} to {end_high}")
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
            output::list(&format!("    {change}"), 2)?;
        }
    }
    output::line("")?;
    print_reward(&r.reward)?;
    output::list(&format!("Judged by {}.", r.criteria), 2)?;
    let list = |title: &str, lines: &[String]| -> Result<(), Failure> {
        output::line("")?;
        output::line(title)?;
        lines
            .iter()
            .try_for_each(|line| output::text(&format!("  {line}"), 2))
    };
    match &r.base {
        Some(base) if r.differences.is_empty() => list(&format!("As {base}."), &[])?,
        Some(base) => list(&format!("Differences from {base}:"), &r.differences)?,
        None if r.differences.is_empty() => {}
        None => list("Changed:", &r.differences)?,
    }
    if r.warnings.is_empty() {
        list("No likely mistakes found.", &[])
    } else {
        list("Warnings:", &r.warnings)
    }
}

/// How large the reward's terms are beside each other, one in each row.
fn print_reward(motions: &[Reward]) -> Result<(), Failure> {
    let Some(first) = motions.first() else {
        return Ok(());
    };
    let heading = format!(
        "Reward of the last phase in a control period, where the shipped controller moves this body (mean of {} s):",
        Earned::LONG_S
    );
    output::text(&heading, 2)?;
    let row = |name: &str, value: &dyn Fn(&Reward) -> String| {
        let values = motions.iter().map(value);
        std::iter::once(name.to_owned()).chain(values).collect()
    };
    let number = |value: f64| match value.abs() {
        size if size < 1e-4 && size > 0.0 || size >= 1e6 => format!("{value:.1e}"),
        _ => format!("{value:.4}"),
    };
    let mut cells: Vec<Vec<String>> = vec![row("  term", &|r| format!("ω_v = {}", r.omega_v))];
    for name in first.terms.keys() {
        let value = |r: &Reward| {
            r.terms
                .get(name)
                .and_then(Value::as_f64)
                .unwrap_or(f64::NAN)
        };
        cells.push(row(&format!("  {name}"), &|r| number(value(r))));
    }
    cells.push(row("  sum", &|r| number(r.sum)));
    if motions.iter().any(|r| r.ended) {
        let when = |r: &Reward| match r.ended {
            true => format!("{:.1} s", r.duration_s),
            false => "-".to_owned(),
        };
        cells.push(row("  fell, or was ended, after", &when));
    }
    (output::table(&cells, &[0]).iter()).try_for_each(|line| output::line(line))?;
    output::line("")
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
    let Ok(Value::Object(table)) = serde_json::to_value(phase) else {
        return Vec::new();
    };
    let neutral = serde_json::to_value(Randomization::changing_nothing());
    let neutral = neutral.unwrap_or_default();
    let other = table
        .into_iter()
        .filter(|(key, _)| !shown.contains(&key.as_str()));
    other
        .map(|(key, value)| {
            let value = match key.as_str() {
                "randomization" => without(value, &neutral),
                _ => value,
            };
            let mut values = Vec::new();
            flatten("", &value, &mut values);
            format!("{key}: {}", values.join(", "))
        })
        .collect()
}

/// The values of a table, each with the path of its key; of a single value that alone.
fn flatten(path: &str, value: &Value, out: &mut Vec<String>) {
    match value {
        Value::Object(table) => {
            for (key, value) in table {
                let dot = if path.is_empty() { "" } else { "." };
                flatten(&format!("{path}{dot}{key}"), value, out);
            }
        }
        value if path.is_empty() => out.push(value.to_string()),
        value => out.push(format!("{path} {value}")),
    }
}

/// A table without what is as in another: three dozen factors of 1 say nothing.
fn without(value: Value, neutral: &Value) -> Value {
    let Value::Object(table) = value else {
        return value;
    };
    let differing = table.into_iter().filter_map(|(key, value)| {
        let same = neutral.get(&key).unwrap_or(&Value::Null);
        (value != *same).then(|| (key, without(value, same)))
    });
    Value::Object(differing.collect())
}
