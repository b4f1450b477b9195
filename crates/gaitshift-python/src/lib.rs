//! `gaitshift._native`, the compiled part of the Python package `gaitshift`: thin classes around the
//! libraries. What users see, with shapes and units, is documented in `python/gaitshift`, whose
//! `_native.pyi` gives the types of what is here.
//!
//! Mistakes of the caller raise `ValueError`, `TypeError` or `OSError`; nothing panics. Arrays are NumPy's,
//! 64-bit floats.

mod batch;
mod body;
mod controller;
mod convert;
mod recording;
mod sac;
mod training;

use gaitshift_analysis::recording::{COLUMNS, DETAILS};
use gaitshift_task::{OBSERVATION_NAMES, OBSERVATION_SCALE, RewardParameters, info_names};
use pyo3::prelude::*;
use std::ffi::OsString;

/// Runs the program with a command line, its own name first, and gives its exit code.
#[pyfunction]
fn program(py: Python<'_>, command_line: Vec<OsString>) -> PyResult<u8> {
    let file = py.import("gaitshift._native")?.getattr("__file__")?;
    gaitshift::set_program_file(file.extract()?);
    Ok(py.detach(|| gaitshift::run(command_line)))
}

#[pymodule(name = "_native")]
fn native(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add_class::<batch::Batch>()?;
    m.add_class::<body::Body>()?;
    m.add_class::<controller::Controller>()?;
    m.add_class::<recording::Recording>()?;
    m.add_class::<sac::Sac>()?;
    m.add_function(wrap_pyfunction!(program, m)?)?;
    m.add_function(wrap_pyfunction!(body::reward_terms, m)?)?;
    m.add_function(wrap_pyfunction!(training::train, m)?)?;
    m.add_function(wrap_pyfunction!(training::resume, m)?)?;
    m.add_function(wrap_pyfunction!(training::run_config, m)?)?;
    m.add_function(wrap_pyfunction!(training::motion_names, m)?)?;
    m.add_function(wrap_pyfunction!(training::train_trial, m)?)?;
    m.add_function(wrap_pyfunction!(training::sweep_trials, m)?)?;
    m.add_function(wrap_pyfunction!(training::sweep_table, m)?)?;
    m.add("OBSERVATION_NAMES", OBSERVATION_NAMES.to_vec())?;
    m.add("OBSERVATION_SCALE", OBSERVATION_SCALE.to_vec())?;
    m.add("COLUMNS", COLUMNS.to_vec())?;
    m.add("DETAILS", DETAILS.to_vec())?;
    m.add("INFO_NAMES", info_names(&RewardParameters::default()))?;
    m.add("__version__", env!("CARGO_PKG_VERSION"))
}
