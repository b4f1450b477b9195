//! The folder of a training run: what is written where, and that nothing is lost on the way.

use crate::acceptance::Judgement;
use crate::config::{ConfigError, Experiment};
use crate::controller::ControllerError;
use crate::tensorboard::EventWriter;
use gaitshift_sac::SacError;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Why training cannot start or go on.
#[derive(Debug, thiserror::Error)]
pub enum TrainingError {
    /// The configuration.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The learner, or its part of a checkpoint.
    #[error(transparent)]
    Learner(#[from] SacError),
    /// A controller file.
    #[error(transparent)]
    Controller(#[from] ControllerError),
    /// A file of the run's folder.
    #[error("{}: {cause}", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong.
        cause: String,
    },
}

impl TrainingError {
    pub(crate) fn other(path: &Path, cause: String) -> Self {
        Self::File {
            path: path.to_owned(),
            cause,
        }
    }
}

fn io_error(path: &Path) -> impl FnOnce(io::Error) -> TrainingError + '_ {
    |e| TrainingError::other(path, e.to_string())
}

/// The folder and its files.
#[derive(Debug, Clone)]
pub(crate) struct RunFolder {
    path: PathBuf,
}

impl RunFolder {
    pub fn at(path: &Path) -> Self {
        Self {
            path: path.to_owned(),
        }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Where the controller evaluated at a step is kept: policies swing, and the one wanted later may
    /// be none of the best.
    pub fn evaluated(&self, step: u64) -> Result<PathBuf, TrainingError> {
        let folder = self.file("controllers");
        fs::create_dir_all(&folder).map_err(io_error(&folder))?;
        Ok(folder.join(format!("step-{step:010}.safetensors")))
    }

    /// A file of the last complete checkpoint.
    pub fn checkpoint(&self, name: &str) -> PathBuf {
        self.path.join("checkpoint").join(name)
    }

    /// A file of the checkpoint being written.
    pub fn pending(&self, name: &str) -> PathBuf {
        self.path.join("checkpoint.new").join(name)
    }

    /// Creates the folder and writes the configuration.
    pub fn create(&self, config: &str) -> Result<(), TrainingError> {
        if self.file("config.toml").exists() {
            return Err(TrainingError::other(
                &self.path,
                "holds a run already; give another --out, or --resume to go on with it".to_owned(),
            ));
        }
        fs::create_dir_all(&self.path).map_err(io_error(&self.path))?;
        let file = self.file("config.toml");
        fs::write(&file, config).map_err(io_error(&file))
    }

    pub fn read_config(&self) -> Result<Experiment, TrainingError> {
        let file = self.file("config.toml");
        if !file.exists() {
            return Err(TrainingError::other(
                &self.path,
                "is no run's folder: it has no config.toml".to_owned(),
            ));
        }
        Ok(Experiment::load(&file.display().to_string())?)
    }

    pub fn read_json<T: DeserializeOwned>(&self, path: &Path) -> Result<T, TrainingError> {
        let text = fs::read_to_string(path).map_err(|e| {
            TrainingError::other(path, format!("no checkpoint to resume from: {e}"))
        })?;
        serde_json::from_str(&text)
            .map_err(|e| TrainingError::other(path, format!("the checkpoint is damaged: {e}")))
    }

    pub fn write_json(&self, name: &str, value: &impl Serialize) -> Result<(), TrainingError> {
        self.write_json_at(&self.file(name), value)
    }

    pub fn write_json_at(&self, path: &Path, value: &impl Serialize) -> Result<(), TrainingError> {
        let text = serde_json::to_string_pretty(value)
            .map_err(|e| TrainingError::other(path, e.to_string()))?;
        fs::write(path, text).map_err(io_error(path))
    }

    /// A checkpoint is written beside the last one and takes its place only when complete.
    pub fn begin_checkpoint(&self) -> Result<(), TrainingError> {
        let new = self.file("checkpoint.new");
        let _ = fs::remove_dir_all(&new);
        fs::create_dir_all(&new).map_err(io_error(&new))
    }

    pub fn commit_checkpoint(&self) -> Result<(), TrainingError> {
        let (old, new) = (self.file("checkpoint"), self.file("checkpoint.new"));
        let aside = self.file("checkpoint.old");
        let _ = fs::remove_dir_all(&aside);
        if old.exists() {
            fs::rename(&old, &aside).map_err(io_error(&old))?;
        }
        fs::rename(&new, &old).map_err(io_error(&new))?;
        let _ = fs::remove_dir_all(&aside);
        Ok(())
    }

    pub fn open_logs(&self) -> Result<Logs, TrainingError> {
        let append = |name: &str| {
            let path = self.file(name);
            let file = OpenOptions::new()
                .create(true)
                .append(true)
                .open(&path)
                .map_err(io_error(&path))?;
            let empty = file.metadata().map_err(io_error(&path))?.len() == 0;
            Ok::<_, TrainingError>((BufWriter::new(file), empty, path))
        };
        let (metrics, metrics_empty, metrics_path) = append("metrics.csv")?;
        let (mut episodes, episodes_empty, episodes_path) = append("episodes.csv")?;
        let (evaluations, _, evaluations_path) = append("evaluations.jsonl")?;
        if episodes_empty {
            writeln!(
                episodes,
                "step,omega_v,total_reward,periods,ended,distance_m"
            )
            .map_err(io_error(&episodes_path))?;
        }
        let events_path = self.file("events.out.tfevents.gaitshift");
        let events = EventWriter::append(&events_path).map_err(io_error(&events_path))?;
        Ok(Logs {
            metrics,
            metrics_header_due: metrics_empty,
            metrics_path,
            episodes: EpisodeLog {
                file: episodes,
                path: episodes_path,
            },
            evaluations,
            evaluations_path,
            events,
            events_path,
        })
    }

    /// After a resume, drops what was logged past the checkpoint, so that nothing stands there twice.
    pub fn cut_logs(&self, step: u64) -> Result<(), TrainingError> {
        for name in ["metrics.csv", "episodes.csv", "evaluations.jsonl"] {
            let path = self.file(name);
            let Ok(text) = fs::read_to_string(&path) else {
                continue;
            };
            let kept: String = text
                .lines()
                .filter(|line| logged_step(line).is_none_or(|s| s <= step))
                .flat_map(|line| [line, "\n"])
                .collect();
            fs::write(&path, kept).map_err(io_error(&path))?;
        }
        Ok(())
    }
}

/// The step that a line of a log begins with.
fn logged_step(line: &str) -> Option<u64> {
    let number = line.strip_prefix("{\"step\":").unwrap_or(line);
    number.split(',').next()?.parse().ok()
}

/// One row per finished episode.
#[derive(Debug)]
pub(crate) struct EpisodeLog {
    file: BufWriter<File>,
    path: PathBuf,
}

impl EpisodeLog {
    pub fn row(&mut self, values: &[String]) -> Result<(), TrainingError> {
        writeln!(self.file, "{}", values.join(",")).map_err(io_error(&self.path))
    }
}

/// The open logs of a run.
#[derive(Debug)]
pub(crate) struct Logs {
    metrics: BufWriter<File>,
    metrics_header_due: bool,
    metrics_path: PathBuf,
    pub episodes: EpisodeLog,
    evaluations: BufWriter<File>,
    evaluations_path: PathBuf,
    events: EventWriter,
    events_path: PathBuf,
}

#[derive(Serialize)]
struct EvaluationLine<'a> {
    step: u64,
    elapsed_s: f64,
    met: usize,
    score: f64,
    accepted: bool,
    averaged_evaluations: usize,
    #[serde(flatten)]
    judgement: &'a Judgement,
}

impl Logs {
    /// Writes a row of metrics; the first column is the step.
    pub fn metrics(&mut self, row: &[(String, f64)]) -> Result<(), TrainingError> {
        let line = |values: Vec<String>| values.join(",");
        if std::mem::take(&mut self.metrics_header_due) {
            let header = line(row.iter().map(|(name, _)| name.clone()).collect());
            writeln!(self.metrics, "{header}").map_err(io_error(&self.metrics_path))?;
        }
        let values = line(row.iter().map(|(_, value)| value.to_string()).collect());
        writeln!(self.metrics, "{values}").map_err(io_error(&self.metrics_path))?;
        self.metrics.flush().map_err(io_error(&self.metrics_path))?;
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
        averaged_evaluations: usize,
        j: &Judgement,
    ) -> Result<(), TrainingError> {
        let line = EvaluationLine {
            step,
            elapsed_s,
            met: j.met(),
            score: j.score(),
            accepted: j.accepted(),
            averaged_evaluations,
            judgement: j,
        };
        let text = serde_json::to_string(&line)
            .map_err(|e| TrainingError::other(&self.evaluations_path, e.to_string()))?;
        writeln!(self.evaluations, "{text}")
            .and_then(|()| self.evaluations.flush())
            .map_err(io_error(&self.evaluations_path))?;
        let mut scalars = vec![
            ("evaluation/criteria_met".to_owned(), j.met() as f64),
            ("evaluation/score".to_owned(), j.score()),
        ];
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

    pub fn flush(&mut self) -> Result<(), TrainingError> {
        self.metrics.flush().map_err(io_error(&self.metrics_path))?;
        let path = &self.episodes.path;
        self.episodes.file.flush().map_err(io_error(path))?;
        self.evaluations
            .flush()
            .map_err(io_error(&self.evaluations_path))
    }
}

fn wall_time_s() -> f64 {
    std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .map_or(0.0, |d| d.as_secs_f64())
}
