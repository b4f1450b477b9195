//! What runs of the study were found to do when they were last measured, so that a page can judge their claims, and show them in
//! the figures over all controllers, without training.

use crate::study::{Steady, Study};
use crate::{ReportError, Stretch};
use gaitshift_analysis::{GaitClass, GaitSummary};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;

// Made by `experiments/full_runs/recorded.py`.
const CLAIMS: &str = include_str!("../recorded/claims.json");
const MOTIONS: &str = include_str!("../recorded/motions.csv");
const TRAINING: &str = include_str!("../recorded/training.csv");

/// An experiment whose runs are recorded.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordedExperiment {
    /// Its name in the study.
    pub name: String,
    /// The experiment of the study that these runs repeat with another learner, where they do: they answer its claims, in a column of
    /// their own.
    #[serde(default)]
    pub repeats: Option<String>,
    /// What the runs learned with, as the head of a column; the recipe says it otherwise.
    #[serde(default)]
    pub learner: Option<String>,
    /// Which runs, and how they learned.
    pub runs: String,
    /// Their seeds.
    pub seeds: Vec<u64>,
    /// One value per seed for each claim about it, or that it is set beside; nothing where a seed lacks what the claim is about.
    pub claims: BTreeMap<String, Vec<Option<f64>>>,
    /// Of each seed the steady motions, with what the figures over all controllers show of them, and the course of the training.
    /// All else is unknown.
    #[serde(skip)]
    pub studies: Vec<Study>,
}

/// A steady motion of a run.
#[derive(Deserialize)]
struct Motion {
    experiment: String,
    seed: u64,
    omega_v: f64,
    gait: GaitClass,
    froude: Option<f64>,
    double_support: Option<f64>,
    flight: Option<f64>,
    cost_of_transport: Option<f64>,
    energy_change_j: Option<f64>,
    energy_recovery: Option<f64>,
}

/// A stretch of the training of a run.
#[derive(Deserialize)]
struct Part {
    experiment: String,
    seed: u64,
    from_step: f64,
    to_step: f64,
    mean_return: f64,
    falls: f64,
}

/// The recorded experiments.
///
/// # Errors
/// Never, unless the program is damaged.
pub fn recorded_experiments() -> Result<Vec<RecordedExperiment>, ReportError> {
    let mut experiments: Vec<RecordedExperiment> = serde_json::from_str(CLAIMS).map_err(damaged)?;
    let (motions, training): (Vec<Motion>, Vec<Part>) = (rows(MOTIONS)?, rows(TRAINING)?);
    for experiment in &mut experiments {
        let RecordedExperiment { name, seeds, .. } = experiment;
        let study = |&seed: &u64| Study {
            name: format!("{name}, seed {seed}"),
            group: name.clone(),
            seed,
            steady: motions
                .iter()
                .filter(|m| m.experiment == *name && m.seed == seed)
                .map(Motion::steady)
                .collect(),
            course: training
                .iter()
                .filter(|part| part.experiment == *name && part.seed == seed)
                .map(Part::stretch)
                .collect(),
            ..Study::default()
        };
        experiment.studies = seeds.iter().map(study).collect();
    }
    Ok(experiments)
}

fn rows<T: DeserializeOwned>(table: &str) -> Result<Vec<T>, ReportError> {
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    reader
        .deserialize()
        .map(|row| row.map_err(damaged))
        .collect()
}

fn damaged(cause: impl std::fmt::Display) -> ReportError {
    ReportError::Subject(format!("recorded: {cause}"))
}

impl Motion {
    fn steady(&self) -> Steady {
        Steady {
            omega_v: self.omega_v,
            energy_change_j: self.energy_change_j,
            summary: GaitSummary {
                fell: self.gait == GaitClass::Fallen,
                gait: self.gait,
                froude: self.froude,
                double_support: self.double_support,
                flight: self.flight,
                cost_of_transport: self.cost_of_transport,
                energy_recovery: self.energy_recovery,
                ..GaitSummary::default()
            },
        }
    }
}

impl Part {
    fn stretch(&self) -> Stretch {
        Stretch {
            from_step: self.from_step,
            to_step: self.to_step,
            mean_return: self.mean_return,
            falls: self.falls,
        }
    }
}
