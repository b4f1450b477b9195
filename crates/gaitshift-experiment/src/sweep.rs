//! Many training runs from one file: an experiment, what varies, the seeds.
//!
//! A **trial** is one variant with one seed: an ordinary run in its own folder, `VARIANT/seed-N` below the sweep's.
//! Trials know nothing of each other, so a sweep can be stopped at any point and gone on with; finished trials
//! are not run again.

mod table;

pub use table::{SweepTable, TrialSummary, VariantSummary};

use crate::config::{ConfigError, Experiment, overlay};
use crate::run_folder::{RunFolder, TrainingError};
use crate::training::{Observer, RunReport, Training};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use toml::{Table, Value};

/// A sweep's file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct SweepFile {
    /// The sweep's folder is named after it.
    name: String,
    /// The recipe that every trial starts from.
    experiment: String,
    /// Each variant is run with each of these.
    seeds: Vec<u64>,
    /// What differs from the recipe in every trial.
    #[serde(default)]
    set: Table,
    /// The variants; the first is the reference that the others are compared with.
    variants: Vec<VariantEntry>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct VariantEntry {
    name: String,
    /// Why it is tried.
    #[serde(default)]
    reason: String,
    /// Replaces the sweep's recipe.
    experiment: Option<String>,
    /// What differs, on top of the sweep's `set`.
    #[serde(default)]
    set: Table,
}

/// A sweep that can be run.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// Its name.
    pub name: String,
    /// Its variants, the reference first.
    pub variants: Vec<Variant>,
    /// Its trials, seed by seed, so that every variant has its first result early.
    pub trials: Vec<Trial>,
}

/// One setting of a sweep.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Variant {
    /// Its name.
    pub name: String,
    /// Why it is tried.
    pub reason: String,
}

/// One run of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Index of its variant.
    pub variant: usize,
    /// Its experiment, seed included.
    pub experiment: Experiment,
    /// Its folder, below the sweep's.
    pub folder: PathBuf,
}

impl Sweep {
    /// Reads a sweep's file.
    ///
    /// # Errors
    /// A file that cannot be read, or as [`Sweep::parse`].
    pub fn load(path: &Path) -> Result<Self, ConfigError> {
        let text = std::fs::read_to_string(path).map_err(|source| ConfigError::Read {
            path: path.to_owned(),
            source,
        })?;
        Self::parse(&text, &path.display().to_string())
    }

    /// Parses a sweep's file; `origin` names it in errors.
    ///
    /// # Errors
    /// No TOML, an unknown key or recipe, a value out of range, no seeds or variants, or one of them twice.
    pub fn parse(text: &str, origin: &str) -> Result<Self, ConfigError> {
        let file: SweepFile = toml::from_str(text).map_err(|e| ConfigError::Parse {
            origin: origin.to_owned(),
            message: e.to_string().trim_end().to_owned(),
        })?;
        let wrong = |message: String| ConfigError::Value {
            origin: origin.to_owned(),
            message,
        };
        if file.seeds.is_empty() || file.variants.is_empty() {
            return Err(wrong(
                "`seeds` and `variants` must each have at least one entry".to_owned(),
            ));
        }
        if let Some(seed) = repeated(&file.seeds) {
            return Err(wrong(format!("`seeds` holds {seed} twice")));
        }
        let folders: Vec<String> = file.variants.iter().map(|v| folder_name(&v.name)).collect();
        if let Some(name) = repeated(&folders) {
            return Err(wrong(format!("two variants have the folder name `{name}`")));
        }
        let mut trials = Vec::new();
        for &seed in &file.seeds {
            for (variant, entry) in file.variants.iter().enumerate() {
                let base = entry.experiment.as_ref().unwrap_or(&file.experiment);
                let mut table = file.set.clone();
                overlay(&mut table, entry.set.clone());
                for key in ["base", "name", "seed"] {
                    if table.contains_key(key) {
                        return Err(wrong(format!(
                            "`set` may not hold `{key}`: it follows from `experiment`, the variant's `name` and `seeds`"
                        )));
                    }
                }
                table.insert("base".to_owned(), Value::String(base.clone()));
                table.insert("name".to_owned(), Value::String(entry.name.clone()));
                let origin = format!("{origin}: variant `{}`", entry.name);
                let mut experiment = Experiment::parse(&table.to_string(), &origin)?;
                experiment.seed = seed;
                trials.push(Trial {
                    variant,
                    experiment,
                    folder: Path::new(&folders[variant]).join(format!("seed-{seed}")),
                });
            }
        }
        let variants = file.variants.into_iter().map(|v| Variant {
            name: v.name,
            reason: v.reason,
        });
        Ok(Self {
            name: file.name,
            variants: variants.collect(),
            trials,
        })
    }

    /// Runs what is not finished yet, `jobs` trials at a time, each in its folder below `folder`. `observer` makes
    /// one for each trial as it begins.
    ///
    /// A trial that was stopped goes on from its checkpoint. When an observer asks to stop, its trial writes a
    /// checkpoint, and no further trial begins.
    ///
    /// # Errors
    /// The first trial that cannot be run; the others that are running come to their end first.
    pub fn run<O: Observer>(
        &self,
        folder: &Path,
        jobs: usize,
        command: &str,
        observer: impl Fn(&Trial) -> O + Sync,
    ) -> Result<SweepReport, TrainingError> {
        let next = AtomicUsize::new(0);
        let outcome = Mutex::new((SweepReport::default(), None));
        let work = || {
            loop {
                let index = next.fetch_add(1, Ordering::SeqCst);
                let Some(trial) = self.trials.get(index) else {
                    return;
                };
                let at = folder.join(&trial.folder);
                let result = match trial.is_finished(&at) {
                    Ok(true) => Ok(None),
                    Ok(false) => trial.run(&at, command, &mut observer(trial)).map(Some),
                    Err(error) => Err(error),
                };
                let mut outcome = outcome.lock().unwrap_or_else(|e| e.into_inner());
                let end = match result {
                    Ok(None) => {
                        outcome.0.skipped += 1;
                        false
                    }
                    Ok(Some(report)) if report.finished => {
                        outcome.0.finished += 1;
                        false
                    }
                    Ok(Some(_)) => true,
                    Err(error) => {
                        outcome.1.get_or_insert(error);
                        true
                    }
                };
                if end {
                    next.store(self.trials.len(), Ordering::SeqCst);
                }
            }
        };
        std::thread::scope(|scope| {
            for _ in 0..jobs.clamp(1, self.trials.len()) {
                scope.spawn(work);
            }
        });
        match outcome.into_inner().unwrap_or_else(|e| e.into_inner()) {
            (_, Some(error)) => Err(error),
            (report, None) => Ok(report),
        }
    }

    /// What the trials reached, as far as they are.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn table(&self, folder: &Path) -> Result<SweepTable, TrainingError> {
        SweepTable::read(self, folder)
    }
}

/// What became of a sweep's trials.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SweepReport {
    /// Trials that came to their end.
    pub finished: usize,
    /// Trials that had come to their end before.
    pub skipped: usize,
}

impl Trial {
    /// Whether its folder holds its whole run.
    ///
    /// # Errors
    /// The folder holds a run of other settings.
    fn is_finished(&self, folder: &Path) -> Result<bool, TrainingError> {
        let config = folder.join("config.toml");
        if !config.exists() {
            return Ok(false);
        }
        if Experiment::read(&config)? != self.experiment {
            return Err(TrainingError::other(
                folder,
                "holds a run of other settings than the sweep's file asks for now; give another --out, rename \
                 the variant, or remove the folder"
                    .to_owned(),
            ));
        }
        let report = folder.join("report.json");
        let Ok(text) = std::fs::read_to_string(&report) else {
            return Ok(false);
        };
        let report: serde_json::Value = serde_json::from_str(&text)
            .map_err(|e| TrainingError::other(&report, format!("is damaged: {e}")))?;
        Ok(report["finished"] == true)
    }

    fn run(
        &self,
        folder: &Path,
        command: &str,
        observer: &mut impl Observer,
    ) -> Result<RunReport, TrainingError> {
        let mut training = if RunFolder::at(folder).has_checkpoint() {
            Training::resume(folder)?
        } else {
            // Killed before its first checkpoint: nothing to go on from.
            if folder.join("config.toml").exists() {
                std::fs::remove_dir_all(folder)
                    .map_err(|e| TrainingError::other(folder, e.to_string()))?;
            }
            Training::new(self.experiment.clone(), folder, command)?
        };
        training.run(observer)
    }
}

/// The first element that stands in the list before.
fn repeated<T: PartialEq>(list: &[T]) -> Option<&T> {
    list.iter()
        .enumerate()
        .find(|(i, element)| list[..*i].contains(element))
        .map(|(_, element)| element)
}

/// The name of an experiment or variant as the name of a folder, whatever is written in it.
pub fn folder_name(name: &str) -> String {
    let plain = |c: char| {
        if c.is_alphanumeric() || c == '_' {
            c
        } else {
            '-'
        }
    };
    if name.is_empty() {
        "unnamed".to_owned()
    } else {
        name.chars().map(plain).collect()
    }
}
