//! What runs of the study were found to do when they were last measured, so that a page can judge their claims without training.

use crate::ReportError;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Made by `experiments/full_runs/claims.py`.
const FILE: &str = include_str!("../recorded/claims.json");

/// An experiment whose runs are recorded.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordedExperiment {
    /// Its name in the study.
    pub name: String,
    /// Which runs, and how they learned.
    pub runs: String,
    /// Their seeds.
    pub seeds: Vec<u64>,
    /// One value per seed for each claim about it; nothing where a seed lacks what the claim is about.
    pub claims: BTreeMap<String, Vec<Option<f64>>>,
}

/// The recorded experiments.
///
/// # Errors
/// Never, unless the program is damaged.
pub fn recorded_experiments() -> Result<Vec<RecordedExperiment>, ReportError> {
    serde_json::from_str(FILE).map_err(|cause| ReportError::Subject(format!("recorded: {cause}")))
}

/// The values that are recorded for a claim about an experiment.
pub(crate) fn values<'a>(
    recorded: &'a [RecordedExperiment],
    experiment: &str,
    claim: &str,
) -> Option<&'a Vec<Option<f64>>> {
    let own = recorded.iter().find(|r| r.name == experiment)?;
    own.claims.get(claim)
}
