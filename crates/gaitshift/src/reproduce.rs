//! `gaitshift reproduce`: the study from training to page.

use crate::arguments::{LearnerName, ReproduceArguments, processors};
use crate::failure::Failure;
use crate::progress::duration;
use crate::train::catch_interrupts;
use crate::{output, report, sweep};
use gaitshift_experiment::{Sweep, portable_command};
use gaitshift_report::{Plan, StudyLearner, Subject, recorded_experiments, study_experiments};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

/// Runs the command.
pub fn run(arguments: &ReproduceArguments) -> Result<(), Failure> {
    let out = &arguments.out;
    report::require_no_run(out)?;
    if arguments.quick {
        let mut subjects = [Subject::shipped().map_err(report::failure)?];
        let recorded = recorded_experiments().map_err(report::failure)?;
        return report::write(&mut subjects, &recorded, &Plan::quick(), out, 1, &|| false);
    }
    let (learner, given) = match arguments.learner {
        LearnerName::Papers => (StudyLearner::Papers, vec!["reproduce".into()]),
        LearnerName::Fast => (
            StudyLearner::Fast,
            ["reproduce", "--learner", "fast"].map(Into::into).to_vec(),
        ),
    };
    let sweeps = study_experiments(learner).map_err(Failure::run)?;
    let jobs = |sweep: &Sweep| match arguments.jobs {
        Some(jobs) => usize::from(jobs),
        None => sweep::default_jobs(sweep),
    };
    let threads = arguments.jobs.map_or_else(processors, usize::from);
    let interrupted = catch_interrupts("stopping after a checkpoint")?;
    let mut training_s = 0.0;
    for sweep in &sweeps {
        training_s += sweep::estimate(sweep, jobs(sweep), &folder(out, sweep), &interrupted)?;
    }
    estimate_measuring(&sweeps, threads, training_s)?;
    if arguments.dry_run {
        return Ok(());
    }
    let command = portable_command(given);
    for sweep in &sweeps {
        let at = folder(out, sweep);
        sweep::train(sweep, &at, jobs(sweep), &command, &interrupted)?;
    }
    let mut subjects = Vec::new();
    for sweep in &sweeps {
        for trial in &sweep.trials {
            let run = folder(out, sweep).join(&trial.folder);
            // A run that never met an evaluation has no controller to report on.
            if run.join("controller.safetensors").is_file() {
                subjects.push(Subject::read(&run).map_err(report::failure)?);
            } else {
                output::note(&format!("{}: no controller; left out", run.display()));
            }
        }
    }
    subjects.push(Subject::shipped().map_err(report::failure)?);
    let stop = || interrupted.load(Ordering::SeqCst);
    report::write(&mut subjects, &[], &Plan::full(), out, threads, &stop)
}

/// Says how long the measuring takes after the training, and both together.
fn estimate_measuring(sweeps: &[Sweep], threads: usize, training_s: f64) -> Result<(), Failure> {
    // The shipped controller is one more.
    let controllers = 1 + sweeps.iter().map(|s| s.trials.len()).sum::<usize>();
    let each_s = Plan::full().duration_s().map_err(report::failure)?;
    let measuring_s = each_s * (controllers.div_ceil(threads)) as f64;
    output::line(&format!(
        "then measuring {controllers} controllers, about {} each: {} with {threads} at a time; everything: about {}",
        duration(each_s),
        duration(measuring_s),
        duration(training_s + measuring_s)
    ))
}

fn folder(out: &Path, sweep: &Sweep) -> PathBuf {
    out.join("runs").join(&sweep.name)
}
