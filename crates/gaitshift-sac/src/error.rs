//! What can go wrong, where, why, and what to do.

use std::path::PathBuf;

use thiserror::Error;

/// Errors of the learner.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SacError {
    /// A setting outside its range.
    #[error("learner setting `{key}` is {value}, but must be {requirement}")]
    Setting {
        /// Name of the setting.
        key: &'static str,
        /// Its value.
        value: String,
        /// What it must be.
        requirement: &'static str,
    },
    /// A mirror that is no mirror.
    #[error("the {what} mirror is not a signed permutation that undoes itself: {cause}")]
    Mirror {
        /// Observation or action.
        what: &'static str,
        /// Why.
        cause: String,
    },
    /// Data of the wrong length.
    #[error("`{what}` has {found} numbers, but {expected} are needed")]
    Length {
        /// Which slice.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length it must have.
        expected: usize,
    },
    /// A number that is not finite was about to be stored.
    #[error(
        "row {row} of `{what}` holds a number that is not finite: store a diverged step with `valid` false, or end the run"
    )]
    NotFinite {
        /// Which slice.
        what: &'static str,
        /// Which row, counted from 0: an environment or a remembered pair.
        row: usize,
    },
    /// Nothing to learn from yet.
    #[error(
        "the replay buffer holds no valid transition: collect experience before updating; where that was done, none of its \
         steps had a finite reward and state"
    )]
    EmptyReplay,
    /// Learning diverged.
    #[error(
        "update {update} diverged: {what} is {value}; begin anew with a lower learning rate, smaller rewards or layer \
         normalisation"
    )]
    Diverged {
        /// Number of the update.
        update: u64,
        /// Which quantity.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A file could not be read or written.
    #[error("cannot {action} `{}`: {source}{}", path.display(), file_remedy(action, source.kind()))]
    File {
        /// Read or write.
        action: &'static str,
        /// Which file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file that is not what it should be.
    #[error("`{}` is not a valid {kind}: {cause}; {remedy}", path.display())]
    Format {
        /// What it should be.
        kind: &'static str,
        /// Which file.
        path: PathBuf,
        /// What is wrong, with the tensor's name.
        cause: String,
        /// What to do.
        remedy: &'static str,
    },
}

/// What to do about a file that cannot be read or written.
fn file_remedy(action: &str, kind: std::io::ErrorKind) -> &'static str {
    use std::io::ErrorKind::{
        NotFound, PermissionDenied, QuotaExceeded, ReadOnlyFilesystem, StorageFull,
    };
    match kind {
        StorageFull | QuotaExceeded => "; make room: a run goes on from its last checkpoint",
        PermissionDenied | ReadOnlyFilesystem => "; check who may read and write there",
        NotFound if action == "read" => {
            "; the checkpoint is incomplete: restore it from a copy, or begin a new run"
        }
        _ => "; check the path and its disk",
    }
}
