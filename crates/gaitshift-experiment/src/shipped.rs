//! The controllers that come with the program.

use crate::{Controller, ControllerError};
use std::path::Path;

/// Their files by name, part of the program so that it needs no other file to run. `shipped` is the one that is meant where
/// none is named.
const FILES: [(&str, &[u8]); 2] = [
    (
        "shipped",
        include_bytes!("../controllers/biped.safetensors"),
    ),
    (
        "robust",
        include_bytes!("../controllers/robust.safetensors"),
    ),
];

impl Controller {
    /// The controller that is meant where none is named: `controllers/biped.safetensors` of this crate.
    ///
    /// # Errors
    /// As [`Controller::from_bytes`], if the program was built with a file that is no controller.
    pub fn shipped() -> Result<Self, ControllerError> {
        let (name, bytes) = FILES[0];
        Self::from_bytes(bytes, Path::new(name))
    }

    /// Names of the controllers that come with the program.
    pub fn names() -> impl Iterator<Item = &'static str> {
        FILES.iter().map(|(name, _)| *name)
    }

    /// Whether a path is the name of a controller that comes with the program, see [`Controller::names`].
    pub fn is_name(path: &Path) -> bool {
        Self::of_name(path).is_some()
    }

    /// The file of a controller that comes with the program, if `path` is the name of one, whatever the working directory
    /// holds: a path looks like one, as `./robust` does.
    pub(crate) fn of_name(path: &Path) -> Option<&'static [u8]> {
        let named = |(name, _): &&(&str, _)| path.as_os_str() == *name;
        FILES.iter().find(named).map(|(_, bytes)| *bytes)
    }
}
