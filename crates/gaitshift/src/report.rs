//! `gaitshift report`: the study's page of any controllers.

use crate::arguments::ReportArguments;
use crate::failure::Failure;
use crate::output;
use crate::progress::duration;
use gaitshift_report::{Plan, ReportError, Subject, write_report};
use std::path::Path;
use std::time::Instant;

/// Runs the command.
pub fn run(arguments: &ReportArguments) -> Result<(), Failure> {
    let mut subjects = arguments
        .items
        .iter()
        .map(|path| Subject::read(path))
        .collect::<Result<Vec<_>, _>>()
        .map_err(failure)?;
    let plan = if arguments.quick {
        Plan::quick()
    } else {
        Plan::full()
    };
    write(&mut subjects, &plan, &arguments.out)
}

/// Measures, writes, and says what to open.
pub fn write(subjects: &mut [Subject], plan: &Plan, folder: &Path) -> Result<(), Failure> {
    let began = Instant::now();
    let mut progress = |what: &str| output::note(what);
    let files = write_report(subjects, plan, folder, &mut progress).map_err(failure)?;
    output::note(&format!("took {}", duration(began.elapsed().as_secs_f64())));
    output::line(&format!(
        "wrote {} and {} files beside it",
        folder.join("report.html").display(),
        files.len() - 1
    ))
}

/// What was given is at fault, or what was to be done.
pub fn failure(error: ReportError) -> Failure {
    match error {
        ReportError::NoSubject | ReportError::Subject(_) | ReportError::Log { .. } => {
            Failure::input(error)
        }
        _ => Failure::run(error),
    }
}
