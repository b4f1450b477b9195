//! Contract: docs/deviations.md explains every key of an experiment. Two keys were added without a line there.

use gaitshift_experiment::Experiment;
use toml::{Table, Value};

const PAGE: &str = include_str!("../../../docs/deviations.md");

/// Paths of the keys that hold a value, e.g. `task.reward.omega_e`.
fn keys(table: &Table, path: &str) -> Vec<String> {
    let below = |(key, value): (&String, &Value)| {
        let path = format!("{path}{key}");
        match value {
            Value::Table(table) => keys(table, &format!("{path}.")),
            Value::Array(values) if values.iter().any(Value::is_table) => values
                .iter()
                .filter_map(Value::as_table)
                .flat_map(|table| keys(table, &format!("{path}.")))
                .collect(),
            _ => vec![path],
        }
    };
    table.iter().flat_map(below).collect()
}

#[test]
fn every_key_has_its_line() {
    let config = Experiment::recipe("fast").unwrap().to_toml().unwrap();
    let keys = keys(&config.parse().unwrap(), "");
    assert!(keys.len() > 100, "{keys:?}");
    for key in keys {
        let name = key.rsplit('.').next().unwrap();
        // The page explains `start.*` as one, and the learner's keys that follow from others are in formats.md.
        let explained = PAGE.contains(&format!("{name}`"))
            || ["name", "seed", "kind"].contains(&name)
            || key.starts_with("task.start.")
            || key.starts_with("learner.mirror")
            || key.starts_with("learner.rehearsal");
        assert!(explained, "docs/deviations.md has no line about `{key}`");
    }
}
