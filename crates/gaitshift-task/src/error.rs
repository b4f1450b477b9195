//! The error of a task or curriculum that cannot be run.

use std::fmt;

/// A task or curriculum that cannot be run: which key, its value, what would be accepted.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskError {
    /// Path of the key, as in TOML.
    pub key: String,
    /// The value that was given.
    pub value: String,
    /// What is accepted instead.
    pub accepted: &'static str,
}

impl fmt::Display for TaskError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "`{}` is {}, but it must be {}",
            self.key, self.value, self.accepted
        )
    }
}

impl std::error::Error for TaskError {}

pub(crate) fn require(
    ok: bool,
    key: &str,
    value: impl fmt::Debug,
    accepted: &'static str,
) -> Result<(), TaskError> {
    if ok {
        return Ok(());
    }
    Err(TaskError {
        key: key.to_owned(),
        value: format!("{value:?}"),
        accepted,
    })
}
