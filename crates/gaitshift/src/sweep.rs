//! `gaitshift sweep`: many runs from one file.

use crate::arguments::SweepArguments;
use crate::failure::Failure;
use crate::output;
use crate::progress::{count, duration};
use crate::train::catch_interrupts;
use gaitshift_experiment::{
    Judgement, Observer, Progress, Sweep, SweepTable, Trial, folder_name, portable_command,
    steps_per_second,
};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

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
    if arguments.dry_run {
        return foretell(&sweep, jobs, &folder);
    }
    if !arguments.table {
        let interrupted = catch_interrupts()?;
        output::note(&format!(
            "{} trials, {jobs} at a time, in {}",
            sweep.trials.len(),
            folder.display()
        ));
        let command = portable_command(std::env::args_os().skip(1));
        let observer = |trial: &Trial| TrialWatcher::begin(trial, Arc::clone(&interrupted));
        let report = sweep
            .run(&folder, jobs, &command, observer)
            .map_err(Failure::run)?;
        output::note(&format!(
            "{} trials finished now, {} before",
            report.finished, report.skipped
        ));
        if interrupted.load(Ordering::SeqCst) {
            output::note("stopped with checkpoints; the same command goes on from them");
            return Err(Failure::Interrupted);
        }
    }
    let table = sweep.table(&folder).map_err(Failure::run)?;
    if table.trials.is_empty() {
        return Err(Failure::input(format!(
            "{}: no trial has been evaluated yet; run the sweep without --table first",
            folder.display()
        )));
    }
    write(&table, &folder)?;
    if arguments.json {
        output::json(&table)
    } else {
        output::line(&table.to_markdown())
    }
}

fn default_folder(sweep: &Sweep) -> PathBuf {
    Path::new("runs").join(folder_name(&sweep.name))
}

/// As many trials as the machine has processors for, given the learner's own threads.
fn default_jobs(sweep: &Sweep) -> usize {
    let threads = sweep.trials.iter().map(|t| t.experiment.learner.threads);
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    (processors / threads.max().unwrap_or(1)).max(1)
}

/// Says what would be run and how long it would take, from the pace of each variant on this machine now.
fn foretell(sweep: &Sweep, jobs: usize, folder: &Path) -> Result<(), Failure> {
    let mut all_s = 0.0;
    for (index, variant) in sweep.variants.iter().enumerate() {
        let mut trials = sweep.trials.iter().filter(|t| t.variant == index);
        let Some(trial) = trials.next() else {
            continue;
        };
        let steps = trial.experiment.curriculum.total_steps();
        let rate = steps_per_second(&trial.experiment, PACE_DURATION).map_err(Failure::run)?;
        let (trial_s, seeds) = (steps as f64 / rate, 1 + trials.count());
        all_s += trial_s * seeds as f64;
        output::line(&format!(
            "{}: {seeds} seed{} of {} steps, {rate:.0} steps/s, {} each",
            variant.name,
            if seeds == 1 { "" } else { "s" },
            count(steps),
            duration(trial_s)
        ))?;
    }
    output::line(&format!(
        "in all about {} of training: {} with {jobs} at a time, if {jobs} run as fast as one; in {}",
        duration(all_s),
        duration(all_s / jobs as f64),
        folder.display()
    ))
}

fn write(table: &SweepTable, folder: &Path) -> Result<(), Failure> {
    let json = serde_json::to_string_pretty(table).map_err(Failure::run)?;
    for (name, text) in [
        ("table.md", table.to_markdown()),
        ("table.json", json + "\n"),
    ] {
        let path = folder.join(name);
        std::fs::write(&path, text)
            .map_err(|e| Failure::run(format!("{}: {e}", path.display())))?;
        output::note(&format!("wrote {}", path.display()));
    }
    Ok(())
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
