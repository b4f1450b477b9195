//! What was edited in a run's configuration since its checkpoint. What the checkpoint decides cannot be edited: the
//! learner and its settings, the seed, the sizes of the replay buffer, the criteria by which its best controller was chosen,
//! the body and control period in which its episodes stand, the controller that it began with, the names of own reward terms,
//! whether batches are mirrored, and the rehearsal once the walk is remembered. Everything else is applied from there on.

use crate::config::{ConfigError, Experiment, leaves};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// One value that differs; a value that is absent is `None`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Edit {
    /// Path of the key, as in TOML.
    pub key: String,
    before: Option<String>,
    after: Option<String>,
}

impl fmt::Display for Edit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = |v: &Option<String>| v.clone().unwrap_or_else(|| "nothing".to_owned());
        let (before, after) = (value(&self.before), value(&self.after));
        write!(f, "`{}` from {before} to {after}", self.key)
    }
}

/// What differs, in the order of the keys.
pub(crate) fn edits(before: &Experiment, after: &Experiment) -> Result<Vec<Edit>, ConfigError> {
    let (before, after) = (values(before)?, values(after)?);
    let keys: BTreeSet<&String> = before.keys().chain(after.keys()).collect();
    Ok(keys
        .into_iter()
        .filter(|&key| before.get(key) != after.get(key))
        .map(|key| Edit {
            key: key.clone(),
            before: before.get(key).cloned(),
            after: after.get(key).cloned(),
        })
        .collect())
}

/// A value as in TOML, but a number far from 1 with its exponent: 1e308 has 309 digits.
fn text(value: &toml::Value) -> String {
    match value {
        toml::Value::Float(number) => format!("{number:?}"),
        toml::Value::Array(list) => {
            let texts: Vec<String> = list.iter().map(text).collect();
            format!("[{}]", texts.join(", "))
        }
        value => value.to_string(),
    }
}

/// Every value of an experiment by the path of its key.
fn values(experiment: &Experiment) -> Result<BTreeMap<String, String>, ConfigError> {
    let table = toml::Value::try_from(experiment).map_err(|e| ConfigError::Value {
        origin: "configuration".to_owned(),
        message: e.to_string(),
    })?;
    let values = leaves(&table).into_iter();
    Ok(values.map(|(key, value)| (key, text(value))).collect())
}

/// Whether the checkpoint decides a key. `mirrored`: batches would be mirrored where they were not, or the other way
/// round; `rehearsing`: the walk has been remembered.
pub(crate) fn is_decided(key: &str, mirrored: bool, rehearsing: bool) -> bool {
    let keys = [
        "seed",
        "task.control_period_s",
        "training.environments",
        "training.replay_capacity",
        "training.warm_start.controller",
    ];
    // The terms of one's own are columns of `metrics.csv`.
    let named = key.starts_with("task.reward.extra[") && key.ends_with(".name");
    named
        || (key.starts_with("learner.") && key != "learner.threads")
        || key.starts_with("body.")
        // By them the best controller so far was chosen.
        || key.starts_with("criteria.")
        || keys.contains(&key)
        || (mirrored && key == "training.symmetry")
        || (rehearsing && key.starts_with("training.rehearsal."))
}
