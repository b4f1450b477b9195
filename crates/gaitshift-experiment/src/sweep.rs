//! Many training runs from one file: an experiment, what varies, the seeds.
//!
//! What varies is a list of variants, the values of some keys in every combination, or settings drawn at random. A
//! **trial** is one variant with one seed: an ordinary run in its own folder, `VARIANT/seed-N` below the sweep's.
//! Trials know nothing of each other, so a sweep can be stopped at any point and gone on with; finished trials
//! are not run again.

mod table;
mod vary;

pub use table::{Estimate, EvaluationSummary, SweepTable, TrialSummary, VariantSummary};

use crate::config::{ConfigError, Experiment, did_you_mean, overlay, read};
use crate::durable;
use crate::parallel::with_team;
use crate::provenance::portable_command;
use crate::run_folder::{RunFolder, is_finished};
use crate::seeds::{GREATEST, listed};
use crate::tensorboard::{Setting, settings_file};
use crate::training::{Observer, Training};
use crate::training_error::{TrainingError, io_error};
use serde::{Deserialize, Serialize};
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
    #[serde(deserialize_with = "listed")]
    seeds: Vec<u64>,
    /// What differs from the recipe in every trial.
    #[serde(default)]
    set: Table,
    /// The variants; the first is the reference that the others are compared with.
    #[serde(default)]
    variants: Vec<VariantEntry>,
    /// In place of variants, keys and their values: every combination, or as many as `random` says.
    vary: Option<Table>,
    /// Settings drawn at random from `vary`.
    random: Option<Random>,
}

/// How many settings are drawn at random.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Random {
    /// Number of settings; each is run with each seed.
    settings: usize,
    /// What decides which.
    #[serde(default = "one")]
    seed: u64,
}

fn one() -> u64 {
    1
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
    /// Of a variant made from `vary`, each key with its value.
    #[serde(skip)]
    values: Vec<(String, String)>,
}

/// A trial's settings for TensorBoard. It reads the files of a folder by name, each to its end before the next, so these come
/// before the scalars, which grow.
const SETTINGS: &str = "events.out.tfevents.a-settings";

/// Most characters in the name of a variant's folder; file systems take 255 bytes.
const LONGEST_NAME: usize = 180;

/// A sweep that can be run.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// Its name.
    pub name: String,
    /// Its variants; where there is a reference, it is the first.
    pub variants: Vec<Variant>,
    /// Whether the others are compared with the first. Settings drawn at random have no reference.
    pub reference: bool,
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
    /// What varies, where keys vary: each key with its value in TOML.
    pub values: Vec<(String, String)>,
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
        let text = read(path)?;
        Self::parse(&text, &path.display().to_string())
    }

    /// Parses a sweep's file; `origin` names it in errors.
    ///
    /// # Errors
    /// No TOML, an unknown key or recipe, a value out of range, no seeds, nothing that varies, or one of them twice.
    pub fn parse(text: &str, origin: &str) -> Result<Self, ConfigError> {
        Self::parse_with(text, "", origin)
    }

    /// The same with more settings, in TOML, in every variant: over the file's `set`, below the variants' own.
    ///
    /// # Errors
    /// As [`Sweep::parse`].
    pub fn parse_with(text: &str, settings: &str, origin: &str) -> Result<Self, ConfigError> {
        let unread = |e: toml::de::Error| ConfigError::Parse {
            origin: origin.to_owned(),
            message: did_you_mean(e.to_string().trim_end()),
        };
        let mut file: SweepFile = toml::from_str(text).map_err(unread)?;
        let settings: Table = toml::from_str(settings).map_err(unread)?;
        let wrong = |message: String| ConfigError::Value {
            origin: origin.to_owned(),
            message,
        };
        overlay(&mut file.set, settings).map_err(wrong)?;
        if file.seeds.is_empty() {
            return Err(wrong("`seeds` must have at least one entry".to_owned()));
        }
        if let Some(seed) = file.seeds.iter().find(|seed| **seed > GREATEST) {
            return Err(wrong(format!(
                "`seeds` holds {seed}, but a seed must be at most {GREATEST}"
            )));
        }
        if let Some(seed) = repeated(&file.seeds) {
            return Err(wrong(format!("`seeds` holds {seed} twice")));
        }
        let entries = match (file.variants.is_empty(), &file.vary) {
            (false, None) if file.random.is_none() => file.variants,
            (true, Some(vary)) => vary::variants(vary, file.random).map_err(wrong)?,
            (false, Some(_)) => {
                return Err(wrong(
                    "has `variants` and `vary`; give one of them, or make two sweeps".to_owned(),
                ));
            }
            (_, None) if file.random.is_some() => {
                return Err(wrong(
                    "`random` draws from `vary`, which is not there; e.g. \
                     vary.learner.learning_rate = { from = 1e-4, to = 1e-3, scale = \"log\" }"
                        .to_owned(),
                ));
            }
            _ => {
                return Err(wrong(
                    "nothing varies: give `[[variants]]`, each with a `name` and `set`, or `[vary]` with keys and \
                     their values, e.g. learner.learning_rate = [3e-4, 1e-3]"
                        .to_owned(),
                ));
            }
        };
        let folders: Vec<String> = entries.iter().map(|v| folder_name(&v.name)).collect();
        // Some file systems take upper and lower case for the same.
        let alike: Vec<String> = folders.iter().map(|name| name.to_lowercase()).collect();
        if let Some(name) = repeated(&alike) {
            return Err(wrong(format!(
                "two variants have the folder name `{name}`, in large or small letters; give `[[variants]]` with different names"
            )));
        }
        if let Some(name) = folders.iter().find(|name| name.len() > LONGEST_NAME) {
            return Err(wrong(format!(
                "the variant `{name}` cannot name a folder: it has {} characters, {LONGEST_NAME} are the most; give \
                 `[[variants]]` with shorter names",
                name.len()
            )));
        }
        let base_of = |name: &str| Experiment::base(name, "experiment", origin, &mut Vec::new());
        let shared = base_of(&file.experiment)?;
        let mut experiments = Vec::new();
        for entry in &entries {
            let own = entry.experiment.as_deref().map(base_of).transpose()?;
            let mut table = file.set.clone();
            overlay(&mut table, entry.set.clone()).map_err(wrong)?;
            for key in ["base", "name", "seed"] {
                if table.contains_key(key) {
                    return Err(wrong(format!(
                        "`set` may not hold `{key}`: it follows from `experiment`, the variant's `name` and `seeds`"
                    )));
                }
            }
            table.insert("name".to_owned(), Value::String(entry.name.clone()));
            let origin = format!("{origin}: variant `{}`", entry.name);
            experiments.push(own.as_ref().unwrap_or(&shared).with_table(table, &origin)?);
        }
        let trial = |seed: u64, variant: usize| Trial {
            variant,
            experiment: Experiment {
                seed,
                ..experiments[variant].clone()
            },
            folder: Path::new(&folders[variant]).join(format!("seed-{seed}")),
        };
        let all = |&seed: &u64| (0..experiments.len()).map(move |variant| (seed, variant));
        let trials = file.seeds.iter().flat_map(all);
        let trials = trials.map(|(seed, variant)| trial(seed, variant)).collect();
        let variants = entries.into_iter().map(|v| Variant {
            name: v.name,
            reason: v.reason,
            values: v.values,
        });
        Ok(Self {
            name: file.name,
            variants: variants.collect(),
            reference: file.random.is_none(),
            trials,
        })
    }

    /// The `number`th, from 1 on, of `of` parts of about the same number of trials.
    pub fn part(&self, number: usize, of: usize) -> Self {
        let own = |(k, _): &(usize, &Trial)| k % of == number - 1;
        let trials = self.trials.iter().enumerate().filter(own);
        Self {
            trials: trials.map(|(_, trial)| trial.clone()).collect(),
            ..self.clone()
        }
    }

    /// Runs what is not finished yet, `jobs` trials at a time, each in its folder below `folder`. `observer` makes
    /// one for each trial as it begins.
    ///
    /// A trial that was stopped goes on from its checkpoint. When an observer asks to stop, its trial writes a
    /// checkpoint, and no further trial begins. A trial that fails does not keep the others from being run.
    ///
    /// # Errors
    /// A folder that holds a run of other settings, before any trial begins.
    pub fn run<O: Observer>(
        &self,
        folder: &Path,
        jobs: usize,
        command: &str,
        observer: impl Fn(&Trial) -> O + Sync,
    ) -> Result<SweepReport, TrainingError> {
        self.require_own(folder)?;
        let next = AtomicUsize::new(0);
        let outcome = Mutex::new((SweepReport::default(), None));
        let work = || {
            loop {
                let index = next.fetch_add(1, Ordering::SeqCst);
                let Some(trial) = self.trials.get(index) else {
                    return;
                };
                let at = folder.join(&trial.folder);
                // Another process may have begun a run there.
                let result = trial.require_own(&at).map(|()| match is_finished(&at) {
                    Ok(true) => None,
                    // To go on with it could lose what it has reached.
                    Err(error) => Some(Err(error)),
                    Ok(false) => Some({
                        let settings = self.settings(trial);
                        let mut observer = observer(trial);
                        begin_trial(trial.experiment.clone(), &at, command, &settings)
                            .and_then(|mut training| training.run(&mut observer))
                    }),
                });
                let mut outcome = outcome.lock().unwrap_or_else(|e| e.into_inner());
                let end = match result {
                    Ok(None) => {
                        outcome.0.skipped += 1;
                        false
                    }
                    Ok(Some(Ok(report))) => {
                        outcome.0.finished += usize::from(report.finished);
                        !report.finished
                    }
                    Ok(Some(Err(error))) => {
                        let failed = format!("{}: {error}", trial.folder.display());
                        outcome.0.failed.push(failed);
                        false
                    }
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
        with_team(jobs.min(self.trials.len()), work);
        match outcome.into_inner().unwrap_or_else(|e| e.into_inner()) {
            (_, Some(error)) => Err(error),
            (report, None) => Ok(report),
        }
    }

    /// That no trial's folder holds a run of other settings.
    ///
    /// # Errors
    /// The first that does.
    pub fn require_own(&self, folder: &Path) -> Result<(), TrainingError> {
        let mut trials = self.trials.iter();
        trials.try_for_each(|trial| trial.require_own(&folder.join(&trial.folder)))
    }

    /// What TensorBoard's table of hyperparameters says of a trial: its variant, what varies where keys vary, its seed.
    pub fn settings(&self, trial: &Trial) -> TrialSettings {
        let variant = &self.variants[trial.variant];
        let mut settings = vec![("variant".to_owned(), Setting::Word(variant.name.clone()))];
        let values = variant.values.iter();
        settings.extend(values.map(|(key, value)| (key.clone(), Setting::parse(value))));
        let seed = Setting::Number(trial.experiment.seed as f64);
        settings.push(("seed".to_owned(), seed));
        TrialSettings(settings)
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
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SweepReport {
    /// Trials that came to their end.
    pub finished: usize,
    /// Trials that had come to their end before.
    pub skipped: usize,
    /// Trials that failed, each with its folder and why.
    pub failed: Vec<String>,
}

impl Trial {
    /// Refuses a folder that holds a run of other settings.
    fn require_own(&self, folder: &Path) -> Result<(), TrainingError> {
        let config = folder.join("config.toml");
        if !config.exists() {
            return Ok(());
        }
        if Experiment::read(&config)? != self.experiment {
            return Err(TrainingError::other(
                folder,
                "holds a run of other settings than the sweep's file asks for now; give another --out, rename \
                 the variant, or remove the folder"
                    .to_owned(),
            ));
        }
        Ok(())
    }
}

/// A trial's settings by name, for TensorBoard.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrialSettings(Vec<(String, Setting)>);

/// Begins a trial in its folder, or goes on with it from its last checkpoint, and writes its settings for TensorBoard where they
/// are missing.
///
/// # Errors
/// As [`Training::new`] and [`Training::resume`], or the settings cannot be written.
pub fn begin_trial(
    experiment: Experiment,
    folder: &Path,
    command: &str,
    settings: &TrialSettings,
) -> Result<Training, TrainingError> {
    // By its configuration a folder holds a run.
    let training = if RunFolder::at(folder).require_config().is_ok() {
        Training::resume(folder)?
    } else {
        Training::new(experiment, folder, command)?
    };
    let file = folder.join(SETTINGS);
    if !file.exists() {
        durable::write(&file, &settings_file(&settings.0)).map_err(io_error(&file))?;
    }
    Ok(training)
}

/// The first element that stands in the list before.
fn repeated<T: PartialEq>(list: &[T]) -> Option<&T> {
    list.iter()
        .enumerate()
        .find(|(i, element)| list[..*i].contains(element))
        .map(|(_, element)| element)
}

/// The command that the controllers of a sweep have as their provenance, wherever and however many at a time they were
/// trained.
pub fn sweep_command(file: &Path) -> String {
    portable_command(["sweep".into(), file.as_os_str().to_owned()])
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
