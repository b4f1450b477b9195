//! The evaluations of a run as its folder has them: the one reader of `evaluations.jsonl`.

use crate::config::{ConfigError, digest, parse_error, read};
use crate::criteria::Criteria;
use crate::logs::EVALUATIONS;
use crate::provenance::portable_path;
use crate::training::rank;
use crate::training_error::{TrainingError, io_error};
use gaitshift_analysis::GaitClass;
use serde::Deserialize;
use std::borrow::Cow;
use std::ffi::OsStr;
use std::path::Path;

/// What run a folder holds, as far as tables and figures need it: also of a run of another version, whose configuration has
/// other keys.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunName {
    /// Name of the experiment.
    pub name: String,
    /// Its seed.
    pub seed: u64,
    /// [`Experiment::digest`](crate::Experiment::digest) of its settings without [`INTERVALS`].
    digest: String,
}

/// Keys of `[training]` that say when a run is looked at, and change no step of it.
const INTERVALS: [&str; 3] = [
    "metrics_interval_steps",
    "evaluation_interval_steps",
    "checkpoint_interval_steps",
];

/// The keys that must be there.
#[derive(Deserialize)]
struct NameAndSeed {
    name: String,
    seed: u64,
}

impl RunName {
    /// Reads it from the folder's `config.toml`.
    ///
    /// # Errors
    /// A file that cannot be read, or has no name or no seed.
    pub fn read(run: &Path) -> Result<Self, ConfigError> {
        let path = run.join("config.toml");
        let text = read(&path)?;
        let bad = |e: toml::de::Error| parse_error(&path.display().to_string(), &e.to_string());
        let NameAndSeed { name, seed } = toml::from_str(&text).map_err(bad)?;
        let mut settings: toml::Value = toml::from_str(&text).map_err(bad)?;
        if let Some(training) = settings
            .get_mut("training")
            .and_then(toml::Value::as_table_mut)
        {
            training.retain(|key, _| !INTERVALS.contains(&key));
        }
        Ok(Self {
            name,
            seed,
            digest: digest::of(&settings),
        })
    }

    /// Those of several runs whose statistics are taken over the seeds of an experiment. Runs that share a name but not
    /// their settings, or not even differ in their seed, are no seeds of one experiment: the later ones have behind the name
    /// as much of their folder as tells them apart.
    ///
    /// # Errors
    /// As [`RunName::read`].
    pub fn read_all(runs: &[&Path]) -> Result<Vec<Self>, ConfigError> {
        let mut told: Vec<Self> = Vec::new();
        let mut experiments: Vec<(String, Self)> = Vec::new();
        for run in runs {
            let own = Self::read(run)?;
            let known = experiments.iter().find(|(name, e)| {
                (&e.name, &e.digest) == (&own.name, &own.digest)
                    && told.iter().all(|t| (&t.name, t.seed) != (name, own.seed))
            });
            let name = match known {
                Some((name, _)) => name.clone(),
                None => {
                    let free = |name: &String| experiments.iter().all(|(taken, _)| taken != name);
                    let name = std::iter::once(own.name.clone())
                        .chain(distinguished(&own.name, run))
                        .find(free)
                        .unwrap_or_default();
                    experiments.push((name.clone(), own.clone()));
                    name
                }
            };
            told.push(Self { name, ..own });
        }
        Ok(told)
    }
}

/// Without end, names for a run whose own is taken: with its folder behind it, shortly, with ever more of the folder's path,
/// and at last with a number.
fn distinguished(name: &str, run: &Path) -> impl Iterator<Item = String> {
    let whole: Vec<Cow<'_, str>> = run.iter().map(OsStr::to_string_lossy).collect();
    let parts = (2..=whole.len()).map(move |count| whole[whole.len() - count..].join("/"));
    let folders = std::iter::once(portable_path(run)).chain(parts);
    let numbers = (2_u64..).map(|number| number.to_string());
    folders
        .chain(numbers)
        .map(move |told| format!("{name} ({told})"))
}

/// A line of `evaluations.jsonl`: what a run's tables, figures and pages need of it. What else stands there, the whole
/// summary of each motion, is left out, so that a run of another version can still be compared.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "Line")]
pub struct Evaluation {
    /// Environment steps.
    pub step: u64,
    /// Wall-clock of the run so far, in s.
    pub elapsed_s: f64,
    /// Number of criteria met.
    pub met: usize,
    /// Orders controllers: the sum of the criteria's credits.
    pub score: f64,
    /// Share of disturbed motions that stay up, from the first phase with `randomization` on.
    pub disturbed_survival: Option<f64>,
    /// How often a resumed run had edited what its controllers are chosen by: disturbances, starts, endings.
    pub disturbance_edits: u32,
    /// Steady motions, one for each command, in the order of the criteria.
    pub rows: Vec<EvaluatedMotion>,
    /// Changes of gait, one for each that was asked for.
    pub changes: Vec<EvaluatedChanges>,
    /// The criteria.
    pub checks: Vec<EvaluatedCriterion>,
}

/// A line as it stands in the file.
#[derive(Deserialize)]
struct Line {
    step: u64,
    elapsed_s: f64,
    met: usize,
    score: f64,
    disturbed_survival: Option<f64>,
    #[serde(default)]
    disturbance_edits: u32,
    rows: Vec<EvaluatedMotion>,
    changes: Option<Vec<EvaluatedChanges>>,
    /// Before criteria could be chosen, when every evaluation asked for what it asks by default.
    to_running: Option<Vec<EvaluatedChange>>,
    to_walking: Option<Vec<EvaluatedChange>>,
    checks: Vec<EvaluatedCriterion>,
}

impl TryFrom<Line> for Evaluation {
    type Error = &'static str;

    fn try_from(line: Line) -> Result<Self, &'static str> {
        let mut rows = line.rows;
        let changes = match (line.changes, line.to_running, line.to_walking) {
            (Some(changes), _, _) => changes,
            (None, Some(to_running), Some(to_walking)) => {
                let asked = Criteria::default();
                for row in &mut rows {
                    row.asked = asked.gait_at(row.omega_v);
                }
                let tries = asked.changes.iter().zip([to_running, to_walking]);
                tries
                    .filter_map(|(change, tries)| {
                        Some(EvaluatedChanges {
                            gaits: [asked.gait_at(change.from)?, asked.gait_at(change.to)?],
                            tries,
                        })
                    })
                    .collect()
            }
            _ => return Err("missing field `changes`"),
        };
        Ok(Self {
            step: line.step,
            elapsed_s: line.elapsed_s,
            met: line.met,
            score: line.score,
            disturbed_survival: line.disturbed_survival,
            disturbance_edits: line.disturbance_edits,
            rows,
            changes,
            checks: line.checks,
        })
    }
}

/// A steady motion under one command.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct EvaluatedMotion {
    /// The command.
    pub omega_v: f64,
    /// The gait that was asked for under it, if one was.
    #[serde(default)]
    pub asked: Option<GaitClass>,
    /// What the motion is.
    pub gait: GaitClass,
    /// Whether it ended in a fall.
    pub fell: bool,
    /// Its Froude number, where it has one.
    pub froude: Option<f64>,
    /// How much the step times of right and left differ, where both have some.
    pub step_time_asymmetry: Option<f64>,
}

/// A change of gait, tried from several phases of the stride.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct EvaluatedChanges {
    /// The gaits that were asked for before and after.
    pub gaits: [GaitClass; 2],
    /// The motions; none if the one before does not last.
    pub tries: Vec<EvaluatedChange>,
}

impl EvaluatedChanges {
    /// How many of them did not fall and went from the one gait to the other.
    pub fn made(&self) -> usize {
        let [before, after] = self.gaits;
        let made = |t: &&EvaluatedChange| {
            t.survived && t.gait_before == Some(before) && t.gait_after == Some(after)
        };
        self.tries.iter().filter(made).count()
    }
}

/// A change of gait from one phase of the stride.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct EvaluatedChange {
    /// Whether it did not fall.
    pub survived: bool,
    /// The motion before, if it lasted until then.
    pub gait_before: Option<GaitClass>,
    /// The motion after, if anything of it is recorded: with a tiny `steady_s` nothing is.
    pub gait_after: Option<GaitClass>,
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
            Err(e) => return Err(io_error(&path)(e)),
        };
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        whole
            .lines()
            .enumerate()
            .map(|(k, line)| {
                Self::parse(line)
                    .map_err(|e| TrainingError::other(
                        &path,
                        format!(
                            "line {}: {e}; the file is damaged: remove that line, or restore the file from a copy",
                            k + 1
                        ),
                    ))
            })
            .collect()
    }

    /// The best: the run's `controller.safetensors` is its controller. Of equally good ones that with the most even step times,
    /// and of those the first. Those before what they are judged by was edited do not count.
    pub fn best(evaluations: &[Self]) -> Option<&Self> {
        let rank = |e: &Self| {
            let asymmetries = e.rows.iter().filter_map(|row| row.step_time_asymmetry);
            let rank = rank(e.score, e.checks.len(), e.disturbed_survival, asymmetries);
            (e.disturbance_edits, rank)
        };
        evaluations
            .iter()
            .reduce(|best, e| if rank(e) > rank(best) { e } else { best })
    }

    /// The motion under the first command at which a gait was asked for, if one was.
    pub fn motion(&self, asked: GaitClass) -> Option<&EvaluatedMotion> {
        self.rows.iter().find(|row| row.asked == Some(asked))
    }
}
