//! What the commands print: tables for people, JSON for programs, and files they wrote.

use crate::failure::Failure;
use gaitshift_analysis::GaitSummary;
use gaitshift_figures::FigureError;
use serde::Serialize;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Prints a line on standard output. Once whoever reads has seen enough, as in `gaitshift evaluate | head -3`, nothing is printed, but
/// what was begun goes on: files are written, and the exit code is that of the outcome.
pub fn line(text: &str) -> Result<(), Failure> {
    match writeln!(io::stdout(), "{text}") {
        Err(cause) if cause.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        result => Ok(result?),
    }
}

/// Widest line of text, as wide as a terminal usually is.
const WIDTH: usize = 80;

/// Prints a text in lines of at most 80 characters, broken at spaces; those after the first are indented by `hanging` more than
/// the text itself.
pub fn text(text: &str, hanging: usize) -> Result<(), Failure> {
    wrapped(text, hanging).iter().try_for_each(|l| line(l))
}

/// [`text`] of a list, broken only after its commas and colons.
pub fn list(items: &str, hanging: usize) -> Result<(), Failure> {
    let whole = items.trim_start().replace(' ', "\u{a0}");
    let broken = whole.replace(",\u{a0}", ", ").replace(":\u{a0}", ": ");
    let indent = " ".repeat(items.len() - items.trim_start().len());
    wrapped(&format!("{indent}{broken}"), hanging)
        .iter()
        .try_for_each(|l| line(&l.replace('\u{a0}', " ")))
}

fn wrapped(text: &str, hanging: usize) -> Vec<String> {
    let words = text.trim_start();
    let indent = text.len() - words.len();
    let mut lines = Vec::new();
    let mut line = " ".repeat(indent);
    let mut empty = true;
    for word in words.split(' ') {
        if !empty && line.chars().count() + 1 + word.chars().count() > WIDTH {
            lines.push(std::mem::replace(&mut line, " ".repeat(indent + hanging)));
            empty = true;
        }
        if !empty {
            line.push(' ');
        }
        line.push_str(word);
        empty = false;
    }
    lines.push(line);
    lines
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

/// Refuses to write over what was read.
pub fn not_over(read: &Path, written: &Path) -> Result<(), Failure> {
    let same = |a: &Path, b: &Path| Some(a.canonicalize().ok()? == b.canonicalize().ok()?);
    if same(read, written) == Some(true) {
        return Err(Failure::input(format!(
            "{} would be written over, but it is what is read; give another --out",
            read.display()
        )));
    }
    Ok(())
}

/// Writes a file; if that fails, as on a full disk, what was there before stays.
pub fn file(path: &Path, content: &[u8]) -> Result<(), Failure> {
    gaitshift_analysis::write_whole(path, content).map_err(|cause| Failure::write(path, &cause))
}

/// Removes a picture that an earlier call left, so that nobody takes it for one of this.
pub fn remove_picture(path: &Path) -> Result<(), Failure> {
    ["svg", "png"]
        .iter()
        .try_for_each(|ending| remove(&path.with_extension(ending)))
}

/// Removes a file, if it is there.
pub fn remove(path: &Path) -> Result<(), Failure> {
    match std::fs::remove_file(path) {
        Err(cause) if cause.kind() != io::ErrorKind::NotFound => Err(Failure::write(path, &cause)),
        _ => Ok(()),
    }
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
        FigureError::Write { path, cause } => Failure::write(&path, &cause),
        FigureError::Raster { .. } | FigureError::Encode { .. } => Failure::run(error),
        FigureError::Option {
            name,
            value,
            allowed,
        } => {
            let flag = match name {
                "fps" => "--fps",
                "width_px" => "--width",
                "slow_motion" => "--slow-motion",
                other => other,
            };
            Failure::input(format!("{flag} is {value}, but must be {allowed}"))
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

/// What a figure of a motion is called in a table, its unit, and how it is written.
type GaitColumn = (&'static str, &'static str, fn(&GaitSummary) -> String);

const GAIT_COLUMNS: [GaitColumn; 10] = [
    ("gait", "", |s| s.gait.to_string()),
    ("upright", "s", |s| number(Some(s.survived_s), 2)),
    ("speed", "m/s", |s| number(s.speed_m_per_s, 2)),
    ("Froude", "", |s| number(s.froude, 2)),
    ("double", "", |s| number(s.double_support, 2)),
    ("single", "", |s| number(s.single_support, 2)),
    ("flight", "", |s| number(s.flight, 2)),
    ("CoT", "", |s| number(s.cost_of_transport, 3)),
    ("steps", "Hz", |s| number(s.step_frequency_hz, 2)),
    ("step", "m", |s| number(s.step_length_m, 2)),
];

/// The lines of a table of motions: heading, units, and one line per (command, motion).
pub fn gait_table<'a>(rows: impl IntoIterator<Item = (String, &'a GaitSummary)>) -> Vec<String> {
    named_gait_table(
        &["ω_v"],
        rows.into_iter().map(|(command, s)| (vec![command], s)),
    )
}

/// The same with other columns before those of the motion, named `titles`.
pub fn named_gait_table<'a>(
    titles: &[&str],
    rows: impl IntoIterator<Item = (Vec<String>, &'a GaitSummary)>,
) -> Vec<String> {
    let owned = |texts: &[&str]| -> Vec<String> { texts.iter().map(|&t| t.to_owned()).collect() };
    let mut heading = owned(titles);
    heading.extend(GAIT_COLUMNS.map(|(title, _, _)| title.to_owned()));
    let mut units = vec![String::new(); titles.len()];
    units.extend(GAIT_COLUMNS.map(|(_, unit, _)| unit.to_owned()));
    let mut cells = vec![heading, units];
    for (mut row, summary) in rows {
        // The figures of a motion that ended in a fall describe no gait that could be compared.
        let told = |(k, (_, _, value)): (usize, &GaitColumn)| match summary.fell && k > 1 {
            true => number(None, 0),
            false => value(summary),
        };
        row.extend(GAIT_COLUMNS.iter().enumerate().map(told));
        cells.push(row);
    }
    // Words begin at the left: names and the gait.
    let words: Vec<usize> = (1..=titles.len()).collect();
    table(&cells, &words)
}

/// Cells in columns as wide as they need; those of the columns `words` begin at the left, all others end at the right.
pub fn table(cells: &[Vec<String>], words: &[usize]) -> Vec<String> {
    let columns = cells.iter().map(Vec::len).max().unwrap_or(0);
    let mut widths = vec![0; columns];
    for row in cells {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let line = |row: &Vec<String>| {
        let padded = row
            .iter()
            .zip(&widths)
            .enumerate()
            .map(|(k, (cell, &width))| {
                if words.contains(&k) {
                    format!("{cell:<width$}")
                } else {
                    format!("{cell:>width$}")
                }
            });
        let joined: Vec<String> = padded.collect();
        joined.join("  ").trim_end().to_owned()
    };
    cells.iter().map(line).collect()
}
