//! Where a controller comes from, said so that it is true on every machine.

use serde::{Deserialize, Serialize};
use std::ffi::{OsStr, OsString};
use std::path::Path;

/// Where a controller comes from.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Name of the experiment.
    pub experiment: String,
    /// Mark of the whole configuration, by which experiments of one name are told apart, see
    /// [`Experiment::digest`](crate::Experiment::digest); none in files of before there was one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub experiment_digest: Option<String>,
    /// Command that made it, see [`portable_command`].
    pub command: String,
    /// Seed of the run.
    pub seed: u64,
    /// Environment steps of training behind it.
    pub environment_steps: u64,
    /// Updates of the learner behind it.
    pub updates: u64,
    /// Version of the program.
    pub version: String,
    /// Edits of the configuration between parts of the run, one sentence each: with any, the command alone does not
    /// make it again.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub edits: Vec<String>,
}

/// The program's name and `words`, its arguments, quoted for a shell. Of an absolute path only the last name is kept:
/// the rest says nothing on another machine, and may say what is nobody's business.
pub fn portable_command(words: impl IntoIterator<Item = OsString>) -> String {
    words
        .into_iter()
        .fold("gaitshift".to_owned(), |line, word| {
            format!("{line} {}", quoted(&portable_word(&word)))
        })
}

/// A path as a file may name it: of an absolute one only the last name.
pub fn portable_path(path: &Path) -> String {
    let name = path.file_name().filter(|_| path.is_absolute());
    name.unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}

fn portable_word(word: &OsStr) -> String {
    let text = word.to_string_lossy();
    // An option and its value, or a key and its value, or both: `--set=KEY=VALUE`.
    match text.rsplit_once('=') {
        Some((key, value)) if !key.starts_with(['/', '\\']) => {
            format!("{key}={}", portable_path(Path::new(value)))
        }
        _ => portable_path(Path::new(word)),
    }
}

/// A word as it is typed into a shell: in quotes if it has a space or another sign that a shell reads.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}
