//! Refuses lists where tables belong: serde would take their entries for the table's keys, in order.

use super::names::parse_error;
use super::{ConfigError, Experiment};
use gaitshift_task::{Disturbance, Push};
use std::sync::LazyLock;
use toml::{Table, Value};

/// An experiment that has every table.
static EXPERIMENT: LazyLock<Table> = LazyLock::new(|| {
    let recipe = toml::from_str::<Experiment>(include_str!("../../recipes/robust.toml"));
    recipe
        .ok()
        .and_then(|recipe| Table::try_from(recipe).ok())
        .unwrap_or_default()
});

/// A disturbance, likewise.
static DISTURBANCE: LazyLock<Table> = LazyLock::new(|| {
    let pushed = Disturbance {
        pushes: vec![Push::default()],
        ..Disturbance::default()
    };
    Table::try_from(pushed).unwrap_or_default()
});

/// That what an experiment has as tables are tables in `own`, too.
///
/// # Errors
/// The first that is not, with its key.
pub(super) fn of_experiment(own: &Table, origin: &str) -> Result<(), ConfigError> {
    compare(own, &EXPERIMENT, "").map_err(|message| parse_error(origin, &message))
}

/// The same for criteria by themselves.
pub(super) fn of_criteria(own: &Table, origin: &str) -> Result<(), ConfigError> {
    match EXPERIMENT.get("criteria").and_then(Value::as_table) {
        Some(like) => compare(own, like, "").map_err(|message| parse_error(origin, &message)),
        None => Ok(()),
    }
}

/// The same for a disturbance.
pub(super) fn of_disturbance(own: &Table, origin: &str) -> Result<(), ConfigError> {
    compare(own, &DISTURBANCE, "").map_err(|message| parse_error(origin, &message))
}

fn compare(own: &Table, like: &Table, within: &str) -> Result<(), String> {
    for (name, value) in own {
        let key = match within {
            "" => name.clone(),
            _ => format!("{within}.{name}"),
        };
        match (like.get(name), value) {
            (Some(Value::Table(like)), Value::Table(value)) => compare(value, like, &key)?,
            (Some(Value::Table(_)), Value::Array(_)) => {
                return Err(format!(
                    "`{key}` must be a table, not a list: write `[{key}]`, or `{name} = {{ ... }}`"
                ));
            }
            (Some(Value::Array(like)), value) => entries(value, like, &key)?,
            _ => {}
        }
    }
    Ok(())
}

/// The entries of a list of tables, or of a table of changes to them by their names.
fn entries(value: &Value, like: &[Value], key: &str) -> Result<(), String> {
    // The one with most tables.
    let most = like
        .iter()
        .filter_map(Value::as_table)
        .max_by_key(|t| t.len());
    let Some(like) = most else {
        return Ok(());
    };
    let values: Vec<&Value> = match value {
        Value::Array(values) => values.iter().collect(),
        Value::Table(changes) => changes.values().collect(),
        _ => return Ok(()),
    };
    for value in values {
        match value {
            Value::Table(value) => compare(value, like, key)?,
            Value::Array(_) => {
                return Err(format!(
                    "each entry of `{key}` must be a table, not a list: write `[[{key}]]`, or `{{ ... }}`"
                ));
            }
            _ => {}
        }
    }
    Ok(())
}
