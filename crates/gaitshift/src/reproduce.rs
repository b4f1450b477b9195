//! `gaitshift reproduce`: the study from training to page.

use crate::arguments::ReproduceArguments;
use crate::failure::Failure;
use crate::train::catch_interrupts;
use crate::{output, report, sweep};
use gaitshift_experiment::{Sweep, portable_command};
use gaitshift_report::{Plan, Subject, study_experiments};
use std::path::{Path, PathBuf};

/// Runs the command.
pub fn run(arguments: &ReproduceArguments) -> Result<(), Failure> {
    let out = &arguments.out;
    if arguments.quick {
        let mut subjects = [Subject::shipped().map_err(report::failure)?];
        return report::write(&mut subjects, &Plan::quick(), out);
    }
    let sweeps = study_experiments().map_err(Failure::run)?;
    let jobs = |sweep: &Sweep| match arguments.jobs {
        Some(jobs) => usize::from(jobs),
        None => sweep::default_jobs(sweep),
    };
    for sweep in &sweeps {
        sweep::estimate(sweep, jobs(sweep), &folder(out, sweep))?;
    }
    if arguments.dry_run {
        return Ok(());
    }
    let interrupted = catch_interrupts()?;
    let command = portable_command(["reproduce".into()]);
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
    report::write(&mut subjects, &Plan::full(), out)
}

fn folder(out: &Path, sweep: &Sweep) -> PathBuf {
    out.join("runs").join(&sweep.name)
}
