//! A short mark of an experiment, by which two that share a name are told apart.

use super::Experiment;
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
        let mut lines = Vec::new();
        list("", &Value::try_from(self)?, &mut lines);
        lines.sort_unstable();
        Ok(format!("{:08x}", crc32c::crc32c(lines.concat().as_bytes())))
    }
}

/// A line `key=value` for each value that says something; tables of a list have their place as a key.
fn list(key: &str, value: &Value, lines: &mut Vec<String>) {
    let within = |name: &str| match key {
        "" => name.to_owned(),
        _ => format!("{key}.{name}"),
    };
    match value {
        _ if LEFT_OUT.contains(&key) => {}
        Value::Table(table) => table
            .iter()
            .for_each(|(name, value)| list(&within(name), value, lines)),
        Value::Array(array) if array.is_empty() => {}
        Value::Array(array) if array.iter().all(Value::is_table) => array
            .iter()
            .enumerate()
            .for_each(|(place, value)| list(&within(&place.to_string()), value, lines)),
        Value::Boolean(false) | Value::Integer(0) => {}
        Value::Float(number) if *number == 0.0 => {}
        Value::String(text) if text.is_empty() => {}
        said => lines.push(format!("{key}={said}\n")),
    }
}
