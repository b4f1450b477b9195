//! The evaluations of a run as its folder has them: the one reader of `evaluations.jsonl`.

use crate::config::{ConfigError, parse_error, read};
use crate::run_folder::{EVALUATIONS, TrainingError};
use gaitshift_analysis::GaitClass;
use serde::Deserialize;
use std::path::Path;

/// What run a folder holds, as far as tables and figures need it: also of a run of another version, whose configuration has
/// other keys.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct RunName {
    /// Name of the experiment.
    pub name: String,
    /// Its seed.
    pub seed: u64,
}

impl RunName {
    /// Reads it from the folder's `config.toml`.
    ///
    /// # Errors
    /// A file that cannot be read, or has no name or no seed.
    pub fn read(run: &Path) -> Result<Self, ConfigError> {
        let path = run.join("config.toml");
        toml::from_str(&read(&path)?)
            .map_err(|e| parse_error(&path.display().to_string(), &e.to_string()))
    }
}

/// A line of `evaluations.jsonl`: what a run's tables, figures and pages need of it. What else stands there, the whole
/// summary of each motion, is left out, so that a run of another version can still be compared.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Evaluation {
    /// Environment steps.
    pub step: u64,
    /// Wall-clock of the run so far, in s.
    pub elapsed_s: f64,
    /// Number of criteria met.
    pub met: usize,
    /// Orders controllers: the sum of the criteria's credits.
    pub score: f64,
    /// Steady motions, one for each command, the lowest first.
    pub rows: Vec<EvaluatedMotion>,
    /// Changes from walking to running, one for each phase of the stride.
    pub to_running: Vec<EvaluatedChange>,
    /// Changes from running to walking.
    pub to_walking: Vec<EvaluatedChange>,
    /// The criteria.
    pub checks: Vec<EvaluatedCriterion>,
}

/// A steady motion under one command.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct EvaluatedMotion {
    /// The command.
    pub omega_v: f64,
    /// What the motion is.
    pub gait: GaitClass,
    /// Whether it ended in a fall.
    pub fell: bool,
    /// Its Froude number, where it has one.
    pub froude: Option<f64>,
}

/// A change of gait.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct EvaluatedChange {
    /// Whether it did not fall.
    pub survived: bool,
    /// The motion before, if it lasted until then.
    pub gait_before: Option<GaitClass>,
    /// The motion after.
    pub gait_after: GaitClass,
}

/// A criterion.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct EvaluatedCriterion {
    /// What is asked.
    pub name: String,
    /// Whether it holds.
    pub met: bool,
}

impl Evaluation {
    /// Reads one line.
    ///
    /// # Errors
    /// No JSON, or a field that is missing or of another type.
    pub fn parse(line: &str) -> Result<Self, String> {
        serde_json::from_str(line).map_err(|e| e.to_string())
    }

    /// All evaluations of a run so far; none if it has just begun.
    ///
    /// # Errors
    /// A file that cannot be read, or a damaged line, with its number. A last line that is still being written is
    /// left out.
    pub fn read_all(run: &Path) -> Result<Vec<Self>, TrainingError> {
        let path = run.join(EVALUATIONS);
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(e) => return Err(TrainingError::other(&path, e.to_string())),
        };
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        whole
            .lines()
            .enumerate()
            .map(|(k, line)| {
                Self::parse(line)
                    .map_err(|e| TrainingError::other(&path, format!("line {}: {e}", k + 1)))
            })
            .collect()
    }

    /// The one with the highest score, the first of several: the run's `controller.safetensors` is its controller.
    pub fn best(evaluations: &[Self]) -> Option<&Self> {
        evaluations
            .iter()
            .reduce(|best, e| if e.score > best.score { e } else { best })
    }

    /// The motion under a command, if it was tried.
    pub fn motion(&self, omega_v: f64) -> Option<&EvaluatedMotion> {
        self.rows.iter().find(|row| row.omega_v == omega_v)
    }
}
