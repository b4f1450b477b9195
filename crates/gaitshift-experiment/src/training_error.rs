//! Why training cannot start or go on.

use crate::config::ConfigError;
use crate::controller::ControllerError;
use gaitshift_analysis::name_taken;
use gaitshift_sac::SacError;
use std::io;
use std::path::{Path, PathBuf};

/// Why training cannot start or go on.
#[derive(Debug, thiserror::Error)]
pub enum TrainingError {
    /// The configuration.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The learner, or its part of a checkpoint.
    #[error(transparent)]
    Learner(#[from] SacError),
    /// A controller file.
    #[error(transparent)]
    Controller(#[from] ControllerError),
    /// A file of the run's folder.
    #[error("{}: {cause}", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong.
        cause: String,
    },
}

impl TrainingError {
    pub(crate) fn other(path: &Path, cause: String) -> Self {
        Self::File {
            path: path.to_owned(),
            cause,
        }
    }
}

/// What the file system says of a path, with what to do.
pub(crate) fn io_error(path: &Path) -> impl FnOnce(io::Error) -> TrainingError + '_ {
    |e| {
        if let Some(cause) = name_taken(&e) {
            return TrainingError::other(path, cause.to_owned());
        }
        let remedy = match e.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
                "make room; a run goes on from its last checkpoint with --resume"
            }
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                "check who may read and write there"
            }
            io::ErrorKind::NotFound => "check that the folder is still there",
            _ => "check the path and its disk",
        };
        TrainingError::other(path, format!("{e}; {remedy}"))
    }
}
