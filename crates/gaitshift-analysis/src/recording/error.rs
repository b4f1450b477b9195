//! What can be wrong with a row or with a file.

use std::path::PathBuf;

/// Version of the recording's file format.
pub(super) const FORMAT_VERSION: &str = "1";

/// Why a row cannot become part of a recording.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RowError {
    /// The row does not have one value per column.
    #[error("the row has {found} values, a recording has {expected} columns")]
    Width {
        /// Values in the row.
        found: usize,
        /// Columns of a recording.
        expected: usize,
    },
    /// A value is infinite or not a number.
    #[error(
        "column `{column}` is {value}, which is not a finite number; \
         a motion that diverged is recorded up to its last finite state"
    )]
    NotFinite {
        /// Name of the column.
        column: String,
        /// The value.
        value: f64,
    },
    /// A detail does not have one value per row.
    #[error("`{column}` has {found} values, the recording has {expected} rows")]
    DetailLength {
        /// Name of the detail.
        column: String,
        /// Values given.
        found: usize,
        /// Rows of the recording.
        expected: usize,
    },
    /// The row's time is not later than that of the row before.
    #[error("column `time_s` is {time_s} s, not later than the row before ({previous_s} s)")]
    TimeNotIncreasing {
        /// Time of the refused row, s.
        time_s: f64,
        /// Time of the row before, s.
        previous_s: f64,
    },
}

/// Why a recording could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// A folder was given.
    #[error("{} is a folder, not a recording; give a CSV file in it{such_as}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// A recording in it, after a comma, if there is one.
        such_as: String,
    },
    /// The operating system refused.
    #[error("cannot {action} the recording {}: {source}; {}", path.display(), remedy(action))]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried: "read" or "write".
        action: &'static str,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// The file is something else.
    #[error(
        "{} is not a recording: {reason}; recordings are the CSV files that `gaitshift evaluate` and \
         `gaitshift transition` write; docs/formats.md has the format for other simulators",
        path.display()
    )]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What gave it away.
        reason: String,
    },
    /// The file was written by a version that this one does not know.
    #[error(
        "{}, line 1: recording format {found:?} is unknown, this program reads format {FORMAT_VERSION}; \
         record the motion again or use the program that wrote the file",
        path.display()
    )]
    Version {
        /// The file.
        path: PathBuf,
        /// The format it claims.
        found: String,
    },
    /// The first line's JSON is damaged or its values make no sense.
    #[error("{}, line 1: bad metadata: {reason}; record the motion again", path.display())]
    Metadata {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// The header lacks columns.
    #[error(
        "{}, line 2: missing column(s) {}; add them or record the motion again",
        path.display(),
        columns.join(", ")
    )]
    MissingColumns {
        /// The file.
        path: PathBuf,
        /// Names of the missing columns.
        columns: Vec<&'static str>,
    },
    /// The header names a column twice.
    #[error("{}, line 2: column `{column}` appears twice; remove one", path.display())]
    DuplicateColumn {
        /// The file.
        path: PathBuf,
        /// Name of the column.
        column: String,
    },
    /// A line has more or fewer fields than the header.
    #[error(
        "{}, line {line}: {found} fields where the header has {expected}; \
         the file is damaged or was cut off, record the motion again",
        path.display()
    )]
    FieldCount {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: u64,
        /// Fields on the line.
        found: u64,
        /// Columns in the header.
        expected: u64,
    },
    /// A field is not a number.
    #[error(
        "{}, line {line}, column `{column}`: {text:?} is not a number; correct it or record the motion again",
        path.display()
    )]
    NotANumber {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: u64,
        /// Name of the column.
        column: String,
        /// What stands there.
        text: String,
    },
    /// A row holds numbers that a recording cannot hold.
    #[error("{}, line {line}: {source}", path.display())]
    Row {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: u64,
        /// What is wrong with the row.
        source: RowError,
    },
    /// The file ends too early.
    #[error("{} was cut off: {reason}; record the motion again", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
        /// How it shows.
        reason: String,
    },
}

/// What helps where the operating system refuses to `action` a recording.
fn remedy(action: &str) -> &'static str {
    match action {
        "write" => "check the path, its permissions and the room on its disk",
        _ => "check the path and its permissions",
    }
}
