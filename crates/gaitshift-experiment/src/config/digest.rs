//! A short mark of an experiment, by which two that share a name are told apart.

use super::{Experiment, leaves};
use toml::Value;

/// Keys that do not tell experiments apart: what a run is called, its seed, and the threads, which change no result.
const LEFT_OUT: [&str; 3] = ["name", "seed", "learner.threads"];

impl Experiment {
    /// The CRC-32C of all keys and values, in hexadecimal digits. Keys that are 0, false or empty are left out, so that a
    /// new key that leaves experiments as they were leaves their digest too.
    ///
    /// # Errors
    /// As [`Experiment::to_toml`].
    pub fn digest(&self) -> Result<String, toml::ser::Error> {
        Ok(of(&Value::try_from(self)?))
    }
}

/// That of a resolved configuration, whatever its version.
pub(crate) fn of(table: &Value) -> String {
    let said = leaves(table)
        .into_iter()
        .filter(|(key, value)| !LEFT_OUT.contains(&key.as_str()) && says_something(value));
    let mut lines: Vec<String> = said
        .map(|(key, value)| format!("{key}={value}\n"))
        .collect();
    lines.sort_unstable();
    format!("{:08x}", crc32c::crc32c(lines.concat().as_bytes()))
}

fn says_something(value: &Value) -> bool {
    match value {
        Value::Array(list) => !list.is_empty(),
        Value::Boolean(false) | Value::Integer(0) => false,
        Value::Float(number) => *number != 0.0,
        Value::String(text) => !text.is_empty(),
        _ => true,
    }
}
