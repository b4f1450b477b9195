//! The folder of a training run: what is written where, and that nothing is lost on the way.

use crate::config::Experiment;
use crate::durable;
use crate::logs::{EVENTS, LOGS, LogLengths, Logs};
use crate::training_error::{TrainingError, io_error};
use serde::Serialize;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

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
/// The other files of a checkpoint.
const CHECKPOINT: [&str; 4] = [CONFIG, STATE, "agent.safetensors", "replay.safetensors"];
/// The controller at the end.
pub(crate) const LAST_CONTROLLER: &str = "controller-last.safetensors";
/// Every controller that was evaluated, by its step.
const EVALUATED: &str = "controllers";
/// How the run ended.
pub(crate) const REPORT: &str = "report.json";
/// Held by the process that trains the run.
const LOCK: &str = "lock";

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
        let folder = self.file(EVALUATED);
        fs::create_dir_all(&folder).map_err(io_error(&folder))?;
        Ok(folder.join(Self::evaluated_name(step)))
    }

    /// Its name in the folder `controllers`.
    pub fn evaluated_name(step: u64) -> String {
        format!("step-{step:010}.safetensors")
    }

    /// The step in such a name.
    fn evaluated_step(name: &str) -> Option<u64> {
        let step = name.strip_prefix("step-")?.strip_suffix(".safetensors")?;
        step.parse().ok()
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
        match fs::metadata(&self.path) {
            Ok(there) if !there.is_dir() => {
                return Err(io_error(&self.path)(io::ErrorKind::NotADirectory.into()));
            }
            Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(io_error(&self.path)(e)),
            _ => {}
        }
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
        let foreign = |name: &str| {
            TrainingError::other(
                &self.path,
                format!("already holds {name}, which is not of this run; give another --out"),
            )
        };
        for name in BEST.into_iter().chain([EVALUATED, REPORT, LAST_CONTROLLER]) {
            if self.file(name).exists() {
                return Err(foreign(name));
            }
        }
        // The first checkpoint replaces these; one that was begun by a run killed before its configuration was
        // written may go.
        for name in [LAST, NEW, OLD] {
            if !self.is_of_no_run(name)? {
                return Err(foreign(name));
            }
        }
        fs::create_dir_all(&self.path).map_err(io_error(&self.path))
    }

    /// Whether nothing is lost if a new run replaces this file or folder.
    fn is_of_no_run(&self, name: &str) -> Result<bool, TrainingError> {
        let path = self.file(name);
        let entries = match fs::read_dir(&path) {
            Ok(entries) => entries,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(true),
            Err(_) => return Ok(false),
        };
        for entry in entries {
            let entry = entry.map_err(io_error(&path))?.file_name();
            let known = |name: &&str| entry == **name;
            if !CHECKPOINT.iter().chain(&BEST).any(known) {
                return Ok(false);
            }
        }
        // Without a state it is no whole checkpoint.
        let Ok(state) = fs::read_to_string(path.join(STATE)) else {
            return Ok(true);
        };
        let state: Result<serde_json::Value, _> = serde_json::from_str(&state);
        Ok(state.is_ok_and(|state| state["counters"]["step"] == 0))
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
        let mut held = Vec::new();
        file.read_to_end(&mut held).map_err(io_error(&path))?;
        if !held.iter().all(|c| c.is_ascii_digit() || *c == b'\n') {
            return Err(TrainingError::other(
                &self.path,
                format!("already holds {LOCK}, which is not of this program; give another --out"),
            ));
        }
        file.set_len(0)
            .and_then(|()| file.rewind())
            .and_then(|()| file.write_all(format!("{}\n", std::process::id()).as_bytes()))
            .map_err(io_error(&path))?;
        Ok(Some(file))
    }

    /// Writes the configuration: a folder without it holds no run.
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
            "not a run's folder: it has no config.toml; give the folder of a run that \
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
                // Not its permissions: one that is protected must not stop the training.
                let content = fs::read(&file).map_err(io_error(&file))?;
                let kept = self.pending(name);
                fs::write(&kept, content).map_err(io_error(&kept))?;
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

    /// Removes the controllers evaluated after the checkpoint, whose evaluations [`RunFolder::cut_logs`] removes.
    pub fn cut_evaluated(&self, step: u64) -> Result<(), TrainingError> {
        let folder = self.file(EVALUATED);
        let entries = match fs::read_dir(&folder) {
            Ok(entries) => entries,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(()),
            Err(e) => return Err(io_error(&folder)(e)),
        };
        for entry in entries {
            let path = entry.map_err(io_error(&folder))?.path();
            let name = path.file_name().and_then(|name| name.to_str());
            if name
                .and_then(Self::evaluated_step)
                .is_some_and(|s| s > step)
            {
                fs::remove_file(&path).map_err(io_error(&path))?;
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
        Logs::open(LOGS.map(|name| self.file(name)), metrics_names)
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
                let now = file.metadata()?.len();
                let kept = now.min(length);
                if kept > 0 && name != EVENTS {
                    let mut end = [0];
                    file.seek(SeekFrom::Start(kept - 1))?;
                    file.read_exact(&mut end)?;
                    if end != *b"\n" {
                        return Ok(false);
                    }
                }
                if now > length {
                    file.set_len(length)?;
                    file.sync_all()?;
                }
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

/// Whether the run in a folder came to its end; one that was only stopped has a report too.
///
/// # Errors
/// Its report is damaged.
pub fn is_finished(folder: &Path) -> Result<bool, TrainingError> {
    let report = folder.join(REPORT);
    let Ok(text) = fs::read_to_string(&report) else {
        return Ok(false);
    };
    let report: serde_json::Value = serde_json::from_str(&text).map_err(|e| {
        let cause = format!(
            "is damaged: {e}; remove it, and the same command goes on with the run from its checkpoint"
        );
        TrainingError::other(&report, cause)
    })?;
    Ok(report["finished"] == true)
}
