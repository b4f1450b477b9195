//! Why a command ends early, and the exit code that says so.

use gaitshift_analysis::name_taken;
use std::fmt::Display;
use std::io::{self, Write};
use std::path::Path;

/// Why a command did not do what it was asked for.
#[derive(Debug)]
pub enum Failure {
    /// Something that the user gave cannot be used.
    Input(String),
    /// It began and could not be finished.
    Run(String),
    /// Standard output cannot be written.
    Output(io::Error),
    /// The user stopped it; what there is to say has been said.
    Interrupted,
    /// It was finished and the answer is no; the answer has been printed.
    Unmet,
}

impl Failure {
    /// Something that the user gave cannot be used.
    pub fn input(cause: impl Display) -> Self {
        Self::Input(cause.to_string())
    }

    /// It began and could not be finished.
    pub fn run(cause: impl Display) -> Self {
        Self::Run(cause.to_string())
    }

    /// A file or folder that cannot be written. A name that is taken by something else was given; the rest is the disk's.
    pub fn write(path: &Path, cause: &io::Error) -> Self {
        let path = path.display();
        if let Some(what) = name_taken(cause) {
            return Self::Input(format!("cannot write {path}: {what}"));
        }
        let what = match cause.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
                format!("{cause}; make room, or give another --out")
            }
            _ => format!("{cause}; check the path and its permissions, or give another --out"),
        };
        Self::Run(format!("cannot write {path}: {what}"))
    }

    /// Says what is wrong and gives the exit code.
    pub fn report(self) -> u8 {
        let (message, code) = match self {
            Self::Input(message) => (message, 2),
            Self::Run(message) => (message, 1),
            // Whoever reads the bytes has seen enough; of lines, [`crate::output::line`] says nothing.
            Self::Output(cause) if cause.kind() == io::ErrorKind::BrokenPipe => {
                return 0;
            }
            Self::Output(cause) => (format!("cannot write to standard output: {cause}"), 1),
            Self::Interrupted => return 130,
            Self::Unmet => return 1,
        };
        // If standard error is closed, nobody is there to be told.
        let _ = writeln!(io::stderr(), "error: {message}");
        code
    }
}

impl From<io::Error> for Failure {
    /// Of standard output only; errors of files name the file.
    fn from(cause: io::Error) -> Self {
        Self::Output(cause)
    }
}
