//! What was measured of a run, kept in its folder, so that a page of many runs does not measure them again.

use super::{Plan, Study};
use crate::Subject;
use gaitshift_experiment::write_durably;
use serde::{Deserialize, Serialize};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The file: the measurements, and what they are of.
#[derive(Serialize, Deserialize)]
struct Kept {
    /// Version of the program, and a hash of its file ([`set_program_file`]): a program built anew measures anew.
    program: String,
    /// Hash of the controller's file.
    controller: String,
    /// Hash of the plan.
    plan: String,
    study: Study,
}

/// The measurements of a run's controller by this program and plan, if its folder has them.
pub(super) fn read(subject: &Subject, plan: &Plan) -> Option<Study> {
    let path = file(subject.run.as_deref()?, plan);
    // A file that is missing, damaged or of another version is written anew.
    let kept: Kept = serde_json::from_slice(&std::fs::read(path).ok()?).ok()?;
    let same = Some(kept.program.as_str()) == program()
        && kept.controller == controller(subject)?
        && kept.plan == hash_of_plan(plan);
    same.then_some(kept.study)
}

/// Keeps measurements in the run's folder; a subject without one has none.
pub(super) fn write(subject: &Subject, plan: &Plan, study: &Study) -> Result<(), String> {
    let Some((run, controller)) = subject.run.as_deref().zip(controller(subject)) else {
        return Ok(());
    };
    let Some(program) = program() else {
        return Ok(());
    };
    let kept = Kept {
        program: program.to_owned(),
        controller,
        plan: hash_of_plan(plan),
        study: study.clone(),
    };
    let text = serde_json::to_string(&kept).map_err(|cause| cause.to_string())?;
    let path = file(run, plan);
    write_durably(&path, text.as_bytes()).map_err(|cause| format!("{}: {cause}", path.display()))
}

/// One file for each plan, so that a quick page leaves the whole study's measurements.
fn file(run: &Path, plan: &Plan) -> PathBuf {
    run.join(format!("measured-{}.json", hash_of_plan(plan)))
}

fn hash_of_plan(plan: &Plan) -> String {
    hash(&serde_json::to_vec(plan).unwrap_or_default())
}

fn controller(subject: &Subject) -> Option<String> {
    subject.controller.to_bytes().ok().map(|bytes| hash(&bytes))
}

static PROGRAM_FILE: OnceLock<PathBuf> = OnceLock::new();

/// Says in which file this program is where that is not the one that the process runs: within Python, which runs as `python`, it is a
/// library. By this file is known whether kept measurements were made by the same program. Only the first call counts.
pub fn set_program_file(path: PathBuf) {
    PROGRAM_FILE.get_or_init(|| path);
}

/// Nothing if its file cannot be read: then nothing is kept.
fn program() -> Option<&'static str> {
    static PROGRAM: OnceLock<Option<String>> = OnceLock::new();
    let program = PROGRAM.get_or_init(|| {
        let file = match PROGRAM_FILE.get() {
            Some(path) => path.clone(),
            None => std::env::current_exe().ok()?,
        };
        let bytes = std::fs::read(file).ok()?;
        Some(format!("{} {}", env!("CARGO_PKG_VERSION"), hash(&bytes)))
    });
    program.as_deref()
}

fn hash(bytes: &[u8]) -> String {
    let mut hasher = DefaultHasher::new();
    bytes.hash(&mut hasher);
    format!("{:016x}", hasher.finish())
}
