//! `gaitshift sweep`: many runs from one file.

use crate::arguments::{SweepArguments, processors};
use crate::failure::Failure;
use crate::output;
use crate::progress::{count, duration};
use crate::train::catch_interrupts;
use gaitshift_experiment::{
    Judgement, Observer, Progress, Sweep, SweepTable, Trial, VariantSummary, folder_name,
    starting_controller, steps_per_second, sweep_command,
};
use gaitshift_figures::{Setting, settings_figure};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// What the figure shows.
const QUANTITY: &str =
    "criteria met (dot: seed, stroke: interquartile mean, bar: its 95 % interval)";
/// Most variants whose pace is measured.
const MOST_PACES: usize = 8;
/// How long the pace is measured for `--dry-run`.
const PACE_DURATION: Duration = Duration::from_secs(3);

/// Runs the command.
pub fn run(arguments: &SweepArguments) -> Result<(), Failure> {
    let sweep = Sweep::load(&arguments.file).map_err(Failure::input)?;
    let folder = arguments
        .out
        .clone()
        .unwrap_or_else(|| default_folder(&sweep));
    let jobs = arguments
        .jobs
        .map_or_else(|| default_jobs(&sweep), usize::from);
    if !arguments.table {
        sweep.require_own(&folder).map_err(Failure::input)?;
    }
    if arguments.dry_run {
        let interrupted = catch_interrupts("stopping")?;
        if arguments.print.json {
            return output::json(&expect(&sweep, jobs, &folder, &interrupted, |_| Ok(()))?);
        }
        return estimate(&sweep, jobs, &folder, &interrupted).map(|_| ());
    }
    if !arguments.table {
        let interrupted = catch_interrupts("stopping after a checkpoint")?;
        let mine = match arguments.part {
            Some(part) => sweep.part(part.number, part.of),
            None => sweep.clone(),
        };
        let command = sweep_command(&arguments.file);
        train(&mine, &folder, jobs, &command, &interrupted)?;
    }
    let table = sweep.table(&folder).map_err(Failure::input)?;
    if table.trials.is_empty() {
        let none = format!("{}: no run has been evaluated yet", folder.display());
        if arguments.table {
            return Err(Failure::input(format!(
                "{none}; run the sweep without --table first"
            )));
        }
        output::note(&format!(
            "{none}, so there is no table: of this part there may be none, or `training.evaluation_interval_steps` is \
             longer than a run"
        ));
        return match arguments.print.json {
            true => output::json(&table),
            false => Ok(()),
        };
    }
    for file in write(&table, &folder)? {
        output::note(&format!("wrote {}", file.display()));
    }
    if arguments.print.json {
        output::json(&table)
    } else {
        output::line(&table.to_markdown())
    }
}

/// Runs what is not finished yet, or goes on with it, until the user stops it.
pub fn train(
    sweep: &Sweep,
    folder: &Path,
    jobs: usize,
    command: &str,
    interrupted: &Arc<AtomicBool>,
) -> Result<(), Failure> {
    output::create_folder(folder)?;
    output::note(&format!(
        "{} trials, {jobs} at a time, in {}",
        sweep.trials.len(),
        folder.display()
    ));
    let observer = |trial: &Trial| TrialWatcher::begin(trial, Arc::clone(interrupted));
    let report = sweep
        .run(folder, jobs, command, observer)
        .map_err(Failure::run)?;
    output::note(&format!(
        "{} runs finished now, {} before",
        report.finished, report.skipped
    ));
    for failed in &report.failed {
        output::note(&format!("failed: {failed}"));
    }
    if interrupted.load(Ordering::SeqCst) {
        output::note("stopped with checkpoints; the same command continues from them");
        return Err(Failure::Interrupted);
    }
    match report.failed.len() {
        0 => Ok(()),
        failed if failed == sweep.trials.len() => {
            Err(Failure::run(format!("all {failed} runs failed, see above")))
        }
        failed => Err(Failure::run(format!(
            "{failed} of {} runs failed, see above; the others are finished, and with --table their table is written",
            sweep.trials.len()
        ))),
    }
}

fn default_folder(sweep: &Sweep) -> PathBuf {
    Path::new("runs").join(folder_name(&sweep.name))
}

/// As many trials as the machine has processors for, given the learner's own threads.
pub fn default_jobs(sweep: &Sweep) -> usize {
    let threads = sweep.trials.iter().map(|t| t.experiment.learner.threads);
    (processors() / threads.max().unwrap_or(1)).max(1)
}

/// The runs of a variant, and how long they would take on this machine.
#[derive(Debug, Serialize)]
struct Expected {
    name: String,
    seeds: usize,
    steps: u64,
    /// None if a run is over before it can be measured.
    steps_per_s: Option<f64>,
    /// Whether the pace was measured, or is that of the variants before.
    measured: bool,
    /// Of one run; none without a pace.
    duration_s: Option<f64>,
}

/// The runs of a sweep, and how long they would take.
#[derive(Debug, Serialize)]
struct Estimate {
    folder: String,
    variants: Vec<Expected>,
    jobs: usize,
    /// Of all runs together.
    training_s: f64,
    /// With `jobs` at a time, if each then runs as fast as one alone.
    duration_s: f64,
}

/// What would be run and how long it would take, from the pace of the variants on this machine now; of many
/// variants that of some tells the others'. Each variant is told as it is known.
fn expect(
    sweep: &Sweep,
    jobs: usize,
    folder: &Path,
    interrupted: &AtomicBool,
    tell: impl Fn(&Expected) -> Result<(), Failure>,
) -> Result<Estimate, Failure> {
    let apart = sweep.variants.len().div_ceil(MOST_PACES);
    let (mut variants, mut rates) = (Vec::new(), Vec::new());
    for (index, variant) in sweep.variants.iter().enumerate() {
        let mut trials = sweep.trials.iter().filter(|t| t.variant == index);
        let Some(trial) = trials.next() else {
            continue;
        };
        let steps = trial.experiment.curriculum.total_steps();
        starting_controller(&trial.experiment)
            .map_err(|cause| Failure::input(format!("variant `{}`: {cause}", variant.name)))?;
        let measured = index % apart == 0;
        let steps_per_s = if measured {
            let stop = || interrupted.load(Ordering::SeqCst);
            let rate = steps_per_second(&trial.experiment, PACE_DURATION, &stop)
                .map_err(|cause| Failure::run(format!("variant `{}`: {cause}", variant.name)))?;
            if stop() {
                return Err(Failure::Interrupted);
            }
            let rate = Some(rate).filter(|&rate| rate > 0.0);
            rates.extend(rate);
            rate
        } else {
            let mean = rates.iter().sum::<f64>() / rates.len() as f64;
            Some(mean).filter(|mean| mean.is_finite())
        };
        let expected = Expected {
            name: variant.name.clone(),
            seeds: 1 + trials.count(),
            steps,
            steps_per_s,
            measured,
            duration_s: steps_per_s.map(|rate| steps as f64 / rate),
        };
        tell(&expected)?;
        variants.push(expected);
    }
    // A run that is over before it can be measured takes no time to speak of.
    let of_variant = |v: &Expected| v.duration_s.unwrap_or(0.0) * v.seeds as f64;
    let training_s: f64 = variants.iter().map(of_variant).sum();
    let runs: usize = variants.iter().map(|v| v.seeds).sum();
    let longest_s = variants
        .iter()
        .filter_map(|v| v.duration_s)
        .fold(0.0, f64::max);
    let at_once = jobs.min(runs).max(1) as f64;
    Ok(Estimate {
        folder: folder.display().to_string(),
        variants,
        jobs,
        training_s,
        duration_s: (training_s / at_once).max(longest_s),
    })
}

/// Says what would be run and how long it would take. Gives that time, in s.
pub fn estimate(
    sweep: &Sweep,
    jobs: usize,
    folder: &Path,
    interrupted: &AtomicBool,
) -> Result<f64, Failure> {
    let estimate = expect(sweep, jobs, folder, interrupted, |v| {
        let pace = match (v.steps_per_s, v.duration_s) {
            (Some(rate), Some(each_s)) => format!(
                "{}{rate:.0} steps/s, {} each",
                if v.measured { "" } else { "about " },
                duration(each_s)
            ),
            _ => "over before their pace can be measured".to_owned(),
        };
        output::line(&format!(
            "{}: {} seed{} of {} steps, {pace}",
            v.name,
            v.seeds,
            if v.seeds == 1 { "" } else { "s" },
            count(v.steps),
        ))
    })?;
    output::line(&format!(
        "in all about {} of training: {} with {jobs} at a time, if each then runs as fast as one alone; in {}",
        duration(estimate.training_s),
        duration(estimate.duration_s),
        folder.display()
    ))?;
    Ok(estimate.duration_s)
}

/// Writes a table as text and JSON, and its figure; gives the files.
pub fn write(table: &SweepTable, folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let json = serde_json::to_string_pretty(table).map_err(Failure::run)?;
    let mut files = Vec::new();
    for (name, text) in [
        ("table.md", table.to_markdown()),
        ("table.json", json + "\n"),
    ] {
        let path = folder.join(name);
        output::file(&path, text.as_bytes())?;
        files.push(path);
    }
    let figure = settings_figure(&settings(table), QUANTITY, criteria(table))
        .and_then(|figure| figure.write(folder.join("table")));
    files.extend(figure.map_err(output::figure_failure)?);
    Ok(files)
}

/// The rows of the figure: of each run what its best controller meets.
fn settings(table: &SweepTable) -> Vec<Setting> {
    let variants = table.variants.iter().filter(|v| v.seeds > 0);
    let setting = |v: &VariantSummary| Setting {
        label: v.variant.clone(),
        values: table
            .trials
            .iter()
            .filter(|t| t.variant == v.variant)
            .map(|t| t.best.met as f64)
            .collect(),
        estimate: v.best_met.map(|e| (e.interval[0], e.value, e.interval[1])),
    };
    variants.map(setting).collect()
}

fn criteria(table: &SweepTable) -> f64 {
    let criteria = table.trials.iter().map(|t| t.best.criteria);
    criteria.max().unwrap_or_default() as f64
}

/// Says in plain lines how one trial of several goes.
struct TrialWatcher {
    name: String,
    interrupted: Arc<AtomicBool>,
}

impl TrialWatcher {
    fn begin(trial: &Trial, interrupted: Arc<AtomicBool>) -> Self {
        let name = trial.folder.display().to_string();
        output::note(&format!("{name}: begins"));
        Self { name, interrupted }
    }
}

impl Observer for TrialWatcher {
    fn progress(&mut self, _: &Progress) {}

    fn evaluated(&mut self, p: &Progress, _: &Judgement, best: bool) {
        output::note(&format!(
            "{}: {} of {} steps, {}, {}{}",
            self.name,
            count(p.step),
            count(p.total_steps),
            duration(p.elapsed_s),
            p.verdict,
            if best { ", the best so far" } else { "" }
        ));
    }

    fn note(&mut self, text: &str) {
        output::note(&format!("{}: {text}", self.name));
    }

    fn stop_requested(&self) -> bool {
        self.interrupted.load(Ordering::SeqCst)
    }
}
