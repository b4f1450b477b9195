//! The controller that comes with the program.

use crate::{Controller, ControllerError};
use std::path::Path;

/// The shipped controller's file, part of the program so that it needs no other file to run.
const BYTES: &[u8] = include_bytes!("../controllers/biped.safetensors");

impl Controller {
    /// The controller that comes with the program: `controllers/biped.safetensors` of this crate.
    ///
    /// # Errors
    /// As [`Controller::from_bytes`], if the program was built with a file that is no controller.
    pub fn shipped() -> Result<Self, ControllerError> {
        Self::from_bytes(BYTES, Path::new("controllers/biped.safetensors"))
    }
}
