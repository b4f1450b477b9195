//! The folder of a training run: what is written where, and that nothing is lost on the way.

use crate::acceptance::Judgement;
use crate::config::{ConfigError, Experiment};
use crate::controller::ControllerError;
use crate::durable;
use crate::tensorboard::EventWriter;
use gaitshift_sac::SacError;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
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

/// The run's configuration.
const CONFIG: &str = "config.toml";
/// Of a checkpoint, the file that is written last.
pub(crate) const STATE: &str = "state.json";
/// The last checkpoint, the one being written, and the one before while the new one takes its place.
const LAST: &str = "checkpoint";
const NEW: &str = "checkpoint.new";
const OLD: &str = "checkpoint.old";
/// Controllers that a later evaluation may replace: a checkpoint keeps those of its step.
const BEST: [&str; 3] = [
    "controller.safetensors",
    "controller-accepted.safetensors",
    "controller-walk.safetensors",
];
/// TensorBoard's events, the only log that is no text.
const EVENTS: &str = "events.out.tfevents.gaitshift";
/// One evaluation a line.
pub(crate) const EVALUATIONS: &str = "evaluations.jsonl";
/// How the run ended.
pub(crate) const REPORT: &str = "report.json";
/// Held by the process that trains the run.
const LOCK: &str = "lock";
/// What a run appends to.
const LOGS: [&str; 4] = ["metrics.csv", "episodes.csv", EVALUATIONS, EVENTS];

/// The length of each log at a checkpoint, in bytes.
pub(crate) type LogLengths = BTreeMap<String, u64>;

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
        Ok(folder.join(Self::evaluated_name(step)))
    }

    /// Its name in the folder `controllers`.
    pub fn evaluated_name(step: u64) -> String {
        format!("step-{step:010}.safetensors")
    }

    /// A file of the last complete checkpoint.
    pub fn checkpoint(&self, name: &str) -> PathBuf {
        self.path.join(LAST).join(name)
    }

    /// A file of the checkpoint being written.
    pub fn pending(&self, name: &str) -> PathBuf {
        self.path.join(NEW).join(name)
    }

    /// Creates the folder, for a new run.
    pub fn create(&self) -> Result<(), TrainingError> {
        for name in LOGS.into_iter().chain([CONFIG]) {
            if self.file(name).exists() {
                return Err(TrainingError::other(
                    &self.path,
                    format!(
                        "already holds a run ({name}); give another --out, or continue that run with --resume"
                    ),
                ));
            }
        }
        // They would be taken for controllers of this run, and the walk be rehearsed.
        for name in BEST.into_iter().chain(["controllers", REPORT]) {
            if self.file(name).exists() {
                return Err(TrainingError::other(
                    &self.path,
                    format!("already holds {name}, which is not of this run; give another --out"),
                ));
            }
        }
        fs::create_dir_all(&self.path).map_err(io_error(&self.path))
    }

    /// Keeps other processes from training the run as long as the file that it gives is open: two would write over each
    /// other's logs. A file system without locks gives nothing.
    pub fn lock(&self) -> Result<Option<File>, TrainingError> {
        let path = self.file(LOCK);
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true).truncate(false);
        let mut file = options.open(&path).map_err(io_error(&path))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut holder = String::new();
                // Who holds it may just be writing its number.
                let _ = file.read_to_string(&mut holder);
                let holder = match holder.trim() {
                    "" => String::new(),
                    number => format!(" (process {number})"),
                };
                return Err(TrainingError::other(
                    &self.path,
                    format!(
                        "is being trained by another process{holder}; wait for its end, or stop it with Ctrl-C"
                    ),
                ));
            }
            Err(TryLockError::Error(_)) => return Ok(None),
        }
        file.set_len(0)
            .and_then(|()| file.write_all(format!("{}\n", std::process::id()).as_bytes()))
            .map_err(io_error(&path))?;
        Ok(Some(file))
    }

    /// Writes the configuration, the last file of a new run: a folder without it holds none.
    pub fn write_config(&self, config: &str) -> Result<(), TrainingError> {
        let file = self.file(CONFIG);
        durable::write(&file, config.as_bytes()).map_err(io_error(&file))
    }

    /// Whether the folder holds a run.
    pub fn require_config(&self) -> Result<(), TrainingError> {
        if self.file(CONFIG).exists() {
            return Ok(());
        }
        Err(TrainingError::other(
            &self.path,
            "is not a run's folder: it has no config.toml; give that of a run that \
             `gaitshift train` began"
                .to_owned(),
        ))
    }

    pub fn read_config(&self) -> Result<Experiment, TrainingError> {
        self.require_config()?;
        Ok(Experiment::read(&self.file(CONFIG))?)
    }

    pub fn write_json(&self, path: &Path, value: &impl Serialize) -> Result<(), TrainingError> {
        let text = serde_json::to_string_pretty(value)
            .map_err(|e| TrainingError::other(path, e.to_string()))?;
        durable::write(path, text.as_bytes()).map_err(io_error(path))
    }

    /// Before the run advances: the report of an earlier part would say of a run that is killed since that it is finished.
    pub fn remove_report(&self) -> Result<(), TrainingError> {
        let file = self.file(REPORT);
        match fs::remove_file(&file) {
            Ok(()) => durable::sync_folder(&self.path).map_err(io_error(&self.path)),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(()),
            Err(e) => Err(io_error(&file)(e)),
        }
    }

    /// A checkpoint is written beside the last one and takes its place only when complete. Its state is its last file.
    pub fn begin_checkpoint(&self) -> Result<(), TrainingError> {
        let new = self.file(NEW);
        remove_folder(&new)?;
        fs::create_dir_all(&new).map_err(io_error(&new))
    }

    /// Copies the best controllers so far into the checkpoint being written.
    pub fn keep_best(&self) -> Result<(), TrainingError> {
        for name in BEST {
            let file = self.file(name);
            if file.exists() {
                fs::copy(&file, self.pending(name)).map_err(io_error(&file))?;
            }
        }
        Ok(())
    }

    /// Goes back to the best controllers of the checkpoint: what came after it may never come again.
    pub fn restore_best(&self) -> Result<(), TrainingError> {
        for name in BEST {
            let (file, kept) = (self.file(name), self.checkpoint(name));
            if kept.exists() {
                let content = fs::read(&kept).map_err(io_error(&kept))?;
                durable::write(&file, &content).map_err(io_error(&file))?;
            } else if file.exists() {
                fs::remove_file(&file).map_err(io_error(&file))?;
            }
        }
        Ok(())
    }

    /// What was written so far is on the disk: the state may follow, which says that the checkpoint is whole.
    pub fn sync_checkpoint(&self) -> Result<(), TrainingError> {
        let new = self.file(NEW);
        durable::sync_files(&new).map_err(io_error(&new))
    }

    /// Puts the new checkpoint into its place.
    pub fn commit_checkpoint(&self) -> Result<(), TrainingError> {
        let (last, new, old) = (self.file(LAST), self.file(NEW), self.file(OLD));
        if last.exists() {
            remove_folder(&old)?;
            fs::rename(&last, &old).map_err(io_error(&last))?;
        }
        fs::rename(&new, &last).map_err(io_error(&new))?;
        durable::sync_folder(&self.path).map_err(io_error(&self.path))?;
        remove_folder(&old)
    }

    /// Finishes what a kill between the renames of [`RunFolder::commit_checkpoint`] left undone.
    pub fn recover_checkpoint(&self) -> Result<(), TrainingError> {
        let whole = |name: &str| self.file(name).join(STATE).exists();
        if whole(NEW) {
            return self.commit_checkpoint();
        }
        let (last, old) = (self.file(LAST), self.file(OLD));
        if last.exists() {
            return Ok(());
        }
        if whole(OLD) {
            return fs::rename(&old, &last).map_err(io_error(&old));
        }
        Err(TrainingError::other(
            &last,
            "there is no checkpoint to resume from; begin a new run with the config.toml beside it"
                .to_owned(),
        ))
    }

    /// Opens the logs, each with its header from the start on.
    pub fn open_logs(&self, metrics_names: &[String]) -> Result<Logs, TrainingError> {
        let [metrics, episodes, evaluations, events] = LOGS.map(|name| self.file(name));
        let mut logs = Logs {
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

    /// After a resume, drops what was logged past the checkpoint, so that nothing stands there twice. A log that is
    /// shorter than it was then stays as it is: somebody took from it.
    pub fn cut_logs(&self, lengths: &LogLengths) -> Result<(), TrainingError> {
        for name in LOGS {
            let path = self.file(name);
            if !path.exists() {
                continue;
            }
            let length = lengths.get(name).copied().unwrap_or(0);
            let cut = || -> io::Result<bool> {
                let mut file = OpenOptions::new().read(true).write(true).open(&path)?;
                if file.metadata()?.len() <= length {
                    return Ok(true);
                }
                if length > 0 && name != EVENTS {
                    let mut end = [0];
                    file.seek(SeekFrom::Start(length - 1))?;
                    file.read_exact(&mut end)?;
                    if end != *b"\n" {
                        return Ok(false);
                    }
                }
                file.set_len(length)?;
                file.sync_all()?;
                Ok(true)
            };
            if !cut().map_err(io_error(&path))? {
                return Err(TrainingError::other(
                    &path,
                    "was edited since the checkpoint, which now ends in the middle of a line; move it away to continue"
                        .to_owned(),
                ));
            }
        }
        Ok(())
    }
}

/// Removes a folder, if it is there.
fn remove_folder(path: &Path) -> Result<(), TrainingError> {
    match fs::remove_dir_all(path) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(io_error(path)(e)),
        _ => Ok(()),
    }
}

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
