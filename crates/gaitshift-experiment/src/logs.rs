//! What a run appends to: metrics, episodes, evaluations, and the events of TensorBoard.

use crate::acceptance::Judgement;
use crate::tensorboard::EventWriter;
use crate::training_error::{TrainingError, io_error};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

/// TensorBoard's events, the only log that is no text.
pub(crate) const EVENTS: &str = "events.out.tfevents.gaitshift";
/// One evaluation a line.
pub(crate) const EVALUATIONS: &str = "evaluations.jsonl";
/// Their names.
pub(crate) const LOGS: [&str; 4] = ["metrics.csv", "episodes.csv", EVALUATIONS, EVENTS];

/// The length of each log at a checkpoint, in bytes.
pub(crate) type LogLengths = BTreeMap<String, u64>;

/// A log of lines.
#[derive(Debug)]
pub(crate) struct TextLog {
    file: BufWriter<File>,
    path: PathBuf,
    /// Nothing has been written yet.
    empty: bool,
}

impl TextLog {
    fn append(path: PathBuf) -> Result<Self, TrainingError> {
        let open = || -> io::Result<(File, bool)> {
            let file = OpenOptions::new().create(true).append(true).open(&path)?;
            let empty = file.metadata()?.len() == 0;
            Ok((file, empty))
        };
        let (file, empty) = open().map_err(io_error(&path))?;
        Ok(Self {
            file: BufWriter::new(file),
            path,
            empty,
        })
    }

    pub fn line(&mut self, text: &str) -> Result<(), TrainingError> {
        self.empty = false;
        writeln!(self.file, "{text}").map_err(io_error(&self.path))
    }

    fn flush(&mut self) -> Result<(), TrainingError> {
        self.file.flush().map_err(io_error(&self.path))
    }

    /// Puts everything on the disk and gives the length.
    fn sync(&mut self) -> Result<u64, TrainingError> {
        let file = &mut self.file;
        let mut sync = || {
            file.flush()?;
            file.get_ref().sync_data()?;
            Ok(file.get_ref().metadata()?.len())
        };
        sync().map_err(io_error(&self.path))
    }
}

/// The open logs of a run.
#[derive(Debug)]
pub(crate) struct Logs {
    metrics: TextLog,
    pub episodes: TextLog,
    evaluations: TextLog,
    events: EventWriter,
    events_path: PathBuf,
}

/// What an evaluation says of disturbances.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Disturbed {
    /// Share of disturbed motions that stay up, where any were tried.
    #[serde(rename = "disturbed_survival", skip_serializing_if = "Option::is_none")]
    pub survival: Option<f64>,
    /// How often they, or the starts or endings, had been edited.
    #[serde(rename = "disturbance_edits", skip_serializing_if = "is_zero")]
    pub edits: u32,
}

fn is_zero(count: &u32) -> bool {
    *count == 0
}

#[derive(Serialize)]
struct EvaluationLine<'a> {
    step: u64,
    elapsed_s: f64,
    #[serde(flatten)]
    disturbed: Disturbed,
    met: usize,
    score: f64,
    accepted: bool,
    #[serde(flatten)]
    judgement: &'a Judgement,
}

impl Logs {
    /// Opens those of [`LOGS`] at their paths, each with its header from the start on.
    pub fn open(paths: [PathBuf; 4], metrics_names: &[String]) -> Result<Self, TrainingError> {
        let [metrics, episodes, evaluations, events] = paths;
        let mut logs = Self {
            metrics: TextLog::append(metrics)?,
            episodes: TextLog::append(episodes)?,
            evaluations: TextLog::append(evaluations)?,
            events: EventWriter::append(&events).map_err(io_error(&events))?,
            events_path: events,
        };
        if logs.episodes.empty {
            logs.episodes
                .line("step,omega_v,total_reward,periods,ended,distance_m")?;
        }
        if logs.metrics.empty {
            logs.metrics.line(&metrics_names.join(","))?;
        }
        Ok(logs)
    }

    /// Writes a row of metrics; the first column is the step.
    pub fn metrics(&mut self, row: &[(String, f64)]) -> Result<(), TrainingError> {
        let values: Vec<String> = row.iter().map(|(_, value)| value.to_string()).collect();
        self.metrics.line(&values.join(","))?;
        self.metrics.flush()?;
        let step = row.first().map_or(0, |(_, step)| *step as u64);
        self.events
            .scalars(step, wall_time_s(), &row[1..])
            .map_err(io_error(&self.events_path))
    }

    /// Writes an evaluation as one line of JSON, and its main figures as events.
    pub fn evaluation(
        &mut self,
        step: u64,
        elapsed_s: f64,
        disturbed: Disturbed,
        j: &Judgement,
    ) -> Result<(), TrainingError> {
        let line = EvaluationLine {
            step,
            elapsed_s,
            disturbed,
            met: j.met(),
            score: j.score(),
            accepted: j.accepted(),
            judgement: j,
        };
        let text = serde_json::to_string(&line)
            .map_err(|e| TrainingError::other(&self.evaluations.path, e.to_string()))?;
        self.evaluations.line(&text)?;
        self.evaluations.flush()?;
        let mut scalars = vec![
            ("evaluation/criteria_met".to_owned(), j.met() as f64),
            ("evaluation/score".to_owned(), j.score()),
        ];
        if let Some(share) = disturbed.survival {
            scalars.push(("evaluation/disturbed_survival".to_owned(), share));
        }
        for row in &j.rows {
            let s = &row.summary;
            scalars.push((
                format!("evaluation/survived_s/{}", row.omega_v),
                s.survived_s,
            ));
            if let Some(froude) = s.froude {
                scalars.push((format!("evaluation/froude/{}", row.omega_v), froude));
            }
        }
        self.events
            .scalars(step, wall_time_s(), &scalars)
            .map_err(io_error(&self.events_path))
    }

    /// Puts everything on the disk and gives the lengths, for the checkpoint.
    pub fn sync(&mut self) -> Result<LogLengths, TrainingError> {
        let events = self.events.sync().map_err(io_error(&self.events_path))?;
        let lengths = [
            self.metrics.sync()?,
            self.episodes.sync()?,
            self.evaluations.sync()?,
            events,
        ];
        let named = LOGS.into_iter().map(str::to_owned).zip(lengths);
        Ok(named.collect())
    }
}

fn wall_time_s() -> f64 {
    std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .map_or(0.0, |d| d.as_secs_f64())
}
