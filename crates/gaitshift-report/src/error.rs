//! What can keep a report from being written.

use std::path::PathBuf;

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// There is nothing to report on.
    #[error(
        "there is no controller to report on; give at least one run's folder or controller file, `shipped` or `robust`"
    )]
    NoSubject,
    /// A controller cannot be used.
    #[error("{0}")]
    Subject(String),
    /// A log of a run cannot be read.
    #[error("{}: {cause}; resume the run, whose logs are cut back to its last checkpoint, or leave it out", path.display())]
    Log {
        /// The file.
        path: PathBuf,
        /// What is wrong, with the line where there is one.
        cause: String,
    },
    /// It was asked to stop.
    #[error(
        "stopped; what was measured of runs is kept in their folders, and the same command continues"
    )]
    Stopped,
    /// A motion that cannot be recorded.
    #[error("{0}")]
    Motion(#[from] gaitshift_analysis::recording::RowError),
    /// A figure that cannot be drawn.
    #[error("{0}")]
    Figure(#[from] gaitshift_figures::FigureError),
    /// A file that cannot be written.
    #[error("cannot write {}: {cause}; check the path and its permissions, or give another --out", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The operating system's reason.
        cause: std::io::Error,
    },
}
