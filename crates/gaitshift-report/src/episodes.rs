//! The episodes of a training run, read back from its folder.

use crate::ReportError;
use serde::Deserialize;
use std::path::Path;

/// Every episode of a run, in the order of time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Episodes {
    /// Environment steps at the episode's end.
    pub steps: Vec<f64>,
    /// Its return.
    pub returns: Vec<f64>,
    /// Its command.
    pub omega_v: Vec<f64>,
    /// Whether it ended in a fall.
    pub fell: Vec<bool>,
}

/// What is needed of a line of `episodes.csv`.
#[derive(Deserialize)]
struct Line {
    step: f64,
    omega_v: f64,
    total_reward: f64,
    ended: String,
}

/// The last part of training, as a share of its steps, whose episodes tell what came of it.
const LATE: f64 = 0.2;

impl Episodes {
    /// Reads the log of a run; one without a log, or without an episode, has none.
    ///
    /// # Errors
    /// A log that is no log.
    pub fn read(run: &Path) -> Result<Self, ReportError> {
        let path = run.join("episodes.csv");
        if !path.is_file() {
            return Ok(Self::default());
        }
        let bad = |cause: csv::Error| ReportError::Log {
            path: path.clone(),
            cause: cause.to_string(),
        };
        let mut reader = csv::Reader::from_path(&path).map_err(bad)?;
        let mut episodes = Self::default();
        for line in reader.deserialize() {
            let line: Line = line.map_err(bad)?;
            episodes.steps.push(line.step);
            episodes.returns.push(line.total_reward);
            episodes.omega_v.push(line.omega_v);
            episodes.fell.push(line.ended != "time limit");
        }
        Ok(episodes)
    }

    /// Share of the episodes in the last fifth of the steps that ended in a fall, in [0, 1].
    pub fn late_falls(&self) -> Option<f64> {
        let last = *self.steps.last()?;
        let first = self
            .steps
            .partition_point(|&step| step < (1.0 - LATE) * last);
        let late = &self.fell[first..];
        let falls = late.iter().filter(|&&fell| fell).count();
        (!late.is_empty()).then(|| falls as f64 / late.len() as f64)
    }
}
