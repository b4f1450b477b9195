//! The episodes of a training run, read back from its folder.

use crate::ReportError;
use gaitshift_analysis::statistics::mean;
use serde::{Deserialize, Serialize};
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

/// A part of a training run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Stretch {
    /// Environment steps at which it begins.
    pub from_step: f64,
    /// Environment steps at which it ends.
    pub to_step: f64,
    /// Mean return of the episodes that end in it.
    pub mean_return: f64,
    /// Share of them that ended in a fall.
    pub falls: f64,
}

/// Environment steps of the stretches in which figures show a training.
const STEPS_EACH: f64 = 100_000.0;

/// The last part of training, as a share of its steps, whose episodes tell what came of it.
const LATE: f64 = 0.2;

impl Episodes {
    /// Reads the log of a run; one without a log, or without an episode, has none. A last line that is still being written,
    /// or was when the run was killed, is left out.
    ///
    /// # Errors
    /// A log that cannot be read, or is no log.
    pub fn read(run: &Path) -> Result<Self, ReportError> {
        let path = run.join("episodes.csv");
        if !path.is_file() {
            return Ok(Self::default());
        }
        let error = |cause: String| ReportError::Log {
            path: path.clone(),
            cause,
        };
        let bad = |cause: csv::Error| error(cause.to_string());
        let text = std::fs::read_to_string(&path).map_err(|cause| error(cause.to_string()))?;
        let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
        let mut reader = csv::Reader::from_reader(whole.as_bytes());
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

    /// The tenths of the training, by its last episode; those without an episode are left out.
    pub fn tenths(&self) -> Vec<Stretch> {
        let last = self.steps.last().copied().unwrap_or_default();
        self.stretches(10, |tenth| last * tenth / 10.0)
    }

    /// The training in stretches of 100 000 steps; those without an episode are left out.
    pub fn course(&self) -> Vec<Stretch> {
        let last = self.steps.last().copied().unwrap_or_default();
        let count = (last / STEPS_EACH).ceil() as u32;
        self.stretches(count, |stretch| stretch * STEPS_EACH)
    }

    /// Stretches, the n-th of which ends at the step `end(n)`; an episode that ends there belongs to it.
    fn stretches(&self, count: u32, end: impl Fn(f64) -> f64) -> Vec<Stretch> {
        let place = |stretch: u32| {
            let step = end(f64::from(stretch));
            (step, self.steps.partition_point(|&s| s <= step))
        };
        (0..count)
            .filter_map(|stretch| {
                let ((from_step, first), (to_step, end)) = (place(stretch), place(stretch + 1));
                let falls = self.fell[first..end].iter().filter(|&&fell| fell).count();
                Some(Stretch {
                    from_step,
                    to_step,
                    mean_return: mean(&self.returns[first..end])?,
                    falls: falls as f64 / (end - first) as f64,
                })
            })
            .collect()
    }
}
