//! What the commands print: tables for people, JSON for programs, and files they wrote.

use crate::failure::Failure;
use gaitshift_analysis::GaitSummary;
use gaitshift_figures::FigureError;
use serde::Serialize;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Prints a line on standard output.
pub fn line(text: &str) -> Result<(), Failure> {
    Ok(writeln!(io::stdout(), "{text}")?)
}

/// Prints a value as JSON on standard output.
pub fn json(value: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string(value).map_err(Failure::run)?;
    line(&text)
}

/// Prints a line on standard error. If that is closed, nobody is there to be told.
pub fn note(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// Says which files were written.
pub fn written(paths: &[PathBuf]) -> Result<(), Failure> {
    paths
        .iter()
        .try_for_each(|path| line(&format!("wrote {}", path.display())))
}

/// Creates a folder for what a command writes.
pub fn create_folder(path: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(path).map_err(|cause| Failure::write(path, &cause))
}

/// Creates the folder that a file is written into.
pub fn create_folder_of(path: &Path) -> Result<(), Failure> {
    match path
        .parent()
        .filter(|parent| !parent.as_os_str().is_empty())
    {
        Some(parent) => create_folder(parent),
        None => Ok(()),
    }
}

/// A picture fails because of what was asked for, or because it cannot be written.
pub fn figure_failure(error: FigureError) -> Failure {
    match error {
        FigureError::Write { .. } | FigureError::Raster { .. } | FigureError::Encode { .. } => {
            Failure::run(error)
        }
        _ => Failure::input(error),
    }
}

/// A value to `decimals`, or a dash where it is undefined.
pub fn number(value: Option<f64>, decimals: usize) -> String {
    // Adding 0 turns -0 into 0.
    value.map_or_else(
        || "-".to_owned(),
        |value| format!("{:.decimals$}", value + 0.0),
    )
}

/// The lines of a table of motions: heading, units, and one line per (command, motion).
pub fn gait_table<'a>(rows: impl IntoIterator<Item = (String, &'a GaitSummary)>) -> Vec<String> {
    let titles = [
        "ω_v", "gait", "upright", "speed", "Froude", "double", "single", "flight", "CoT", "steps",
        "step",
    ];
    let units = ["", "", "s", "m/s", "", "", "", "", "", "Hz", "m"];
    let mut cells = vec![titles.map(str::to_owned), units.map(str::to_owned)];
    for (command, s) in rows {
        cells.push([
            command,
            s.gait.to_string(),
            number(Some(s.survived_s), 2),
            number(s.speed_m_per_s, 2),
            number(s.froude, 2),
            number(s.double_support, 2),
            number(s.single_support, 2),
            number(s.flight, 2),
            number(s.cost_of_transport, 3),
            number(s.step_frequency_hz, 2),
            number(s.step_length_m, 2),
        ]);
    }
    let mut widths = [0; 11];
    for row in &cells {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let join = |row: &[String; 11]| {
        let padded = row
            .iter()
            .zip(widths)
            .enumerate()
            .map(|(k, (cell, width))| {
                // The gait is the only column of words.
                if k == 1 {
                    format!("{cell:<width$}")
                } else {
                    format!("{cell:>width$}")
                }
            });
        let joined: Vec<String> = padded.collect();
        joined.join("  ").trim_end().to_owned()
    };
    cells.iter().map(join).collect()
}
