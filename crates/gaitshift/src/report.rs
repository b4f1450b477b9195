//! `gaitshift report`: the study's page of any controllers.

use crate::arguments::{ReportArguments, distinct_paths, processors};
use crate::failure::Failure;
use crate::motion::note_if_unevaluated;
use crate::output;
use crate::progress::duration;
use gaitshift_report::{Plan, RecordedExperiment, ReportError, Subject, Work, write_report};
use std::path::Path;
use std::time::Instant;

/// Runs the command.
pub fn run(arguments: &ReportArguments) -> Result<(), Failure> {
    distinct_paths(&arguments.items).map_err(Failure::input)?;
    let mut subjects = Subject::read_all(&arguments.items).map_err(failure)?;
    for path in &arguments.items {
        note_if_unevaluated(path);
    }
    let plan = if arguments.quick {
        Plan::quick()
    } else {
        Plan::full()
    };
    write(
        &mut subjects,
        &[],
        &plan,
        &arguments.out,
        processors(),
        &|| false,
    )
}

/// Measures, `threads` controllers at a time, writes, and says what to open.
pub fn write(
    subjects: &mut [Subject],
    recorded: &[RecordedExperiment],
    plan: &Plan,
    folder: &Path,
    threads: usize,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<(), Failure> {
    require_no_run(folder)?;
    let began = Instant::now();
    let work = Work {
        threads,
        say: &output::note,
        stop,
    };
    let files = write_report(subjects, recorded, plan, folder, &work).map_err(failure)?;
    output::note(&format!("took {}", duration(began.elapsed().as_secs_f64())));
    output::line(&format!(
        "wrote {} and {} files beside it",
        folder.join("report.html").display(),
        files.len() - 1
    ))
}

/// A run's own report.json is not written over.
pub fn require_no_run(folder: &Path) -> Result<(), Failure> {
    if folder.join("config.toml").exists() {
        return Err(Failure::input(format!(
            "{} is a run's folder, whose report.json says how the run ended; give another --out",
            folder.display()
        )));
    }
    Ok(())
}

/// What was given is at fault, or what was to be done.
pub fn failure(error: ReportError) -> Failure {
    match error {
        ReportError::Stopped => {
            output::note(&error.to_string());
            Failure::Interrupted
        }
        ReportError::NoSubject | ReportError::Subject(_) | ReportError::Log { .. } => {
            Failure::input(error)
        }
        ReportError::Write { path, cause } => Failure::write(&path, &cause),
        _ => Failure::run(error),
    }
}
