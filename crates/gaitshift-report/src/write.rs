//! Writes the page with its figures and numbers.

use crate::figures::{self, Shown};
use crate::group::Group;
use crate::page;
use crate::study::{Measured, Plan, Study};
use crate::table::{Table, cell};
use crate::{ReportError, Subject};
use gaitshift_experiment::folder_name;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Pixels for each unit of a figure, so that PNGs have 300 dots per inch at their own size.
const PNG_SCALE: f64 = 300.0 / 96.0;

/// Everything in `report.json`.
#[derive(Serialize)]
struct Numbers<'a> {
    format: &'static str,
    version: &'static str,
    plan: &'a Plan,
    experiments: &'a [Group],
    studies: Vec<&'a Study>,
}

/// Measures the subjects and writes `report.html`, `report.json` and a folder of figures and tables into `folder`; gives the
/// files written. `progress` is told what is being measured, of whom.
///
/// The same subjects and plan give the same bytes.
///
/// # Errors
/// Without subjects, and for a motion, figure or file that cannot be made.
pub fn write_report(
    subjects: &mut [Subject],
    plan: &Plan,
    folder: &Path,
    progress: &mut dyn FnMut(&str),
) -> Result<Vec<PathBuf>, ReportError> {
    if subjects.is_empty() {
        return Err(ReportError::NoSubject);
    }
    // What cannot be written is said before anything is measured.
    std::fs::create_dir_all(folder).map_err(|cause| ReportError::Write {
        path: folder.to_owned(),
        cause,
    })?;
    let mut measured = Vec::new();
    for subject in subjects.iter_mut() {
        let name = subject.name.clone();
        let mut of_subject = |what: &str| progress(&format!("{name}: {what}"));
        measured.push(Measured::measure(subject, plan, &mut of_subject)?);
    }
    progress("figures and page");
    let studies: Vec<&Study> = measured.iter().map(|m| &m.study).collect();
    let groups = Group::all(&studies);
    let common = figures::of_all(&measured)?;
    let mut each = Vec::new();
    for (subject, m) in subjects.iter().zip(&measured) {
        each.push(figures::of_one(subject, m, plan)?);
    }

    let mut files = Files {
        root: folder,
        written: Vec::new(),
    };
    let mut places = Vec::new();
    for shown in &common {
        files.figure("figures", shown)?;
    }
    for (index, (subject, own)) in subjects.iter().zip(&each).enumerate() {
        let place = match subjects.len() {
            1 => "figures".to_owned(),
            _ => format!("figures/{}-{}", index + 1, folder_name(&subject.name)),
        };
        for shown in own {
            files.figure(&place, shown)?;
        }
        places.push(place);
    }
    for (name, table) in [
        ("claims", claims_table(&groups)),
        ("numbers", numbers_table(&groups)),
    ] {
        files.table("", name, &table)?;
    }
    let numbers = Numbers {
        format: "gaitshift-report 1",
        version: env!("CARGO_PKG_VERSION"),
        plan,
        experiments: &groups,
        studies,
    };
    let json = serde_json::to_string_pretty(&numbers)
        .map_err(|cause| ReportError::Subject(cause.to_string()))?;
    files.write("report.json", (json + "\n").as_bytes())?;
    let html = page::html(plan, &groups, &measured, &common, &each, &places);
    files.write("report.html", html.as_bytes())?;
    // The page first: it is what to open.
    files.written.reverse();
    Ok(files.written)
}

struct Files<'a> {
    root: &'a Path,
    written: Vec<PathBuf>,
}

impl Files<'_> {
    fn write(&mut self, name: &str, bytes: &[u8]) -> Result<(), ReportError> {
        let path = self.root.join(name);
        let failed = |cause| ReportError::Write {
            path: path.clone(),
            cause,
        };
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(failed)?;
        }
        std::fs::write(&path, bytes).map_err(failed)?;
        self.written.push(path);
        Ok(())
    }

    fn table(&mut self, place: &str, name: &str, table: &Table) -> Result<(), ReportError> {
        let stem = if place.is_empty() {
            name.to_owned()
        } else {
            format!("{place}/{name}")
        };
        self.write(&format!("{stem}.csv"), table.to_csv().as_bytes())?;
        let json = serde_json::to_string(table)
            .map_err(|cause| ReportError::Subject(cause.to_string()))?;
        self.write(&format!("{stem}.json"), (json + "\n").as_bytes())
    }

    fn figure(&mut self, place: &str, shown: &Shown) -> Result<(), ReportError> {
        let stem = format!("{place}/{}", shown.name);
        self.write(&format!("{stem}.svg"), shown.figure.svg.as_bytes())?;
        self.write(&format!("{stem}.png"), &shown.figure.to_png(PNG_SCALE)?)?;
        self.table(place, &shown.name, &shown.table)
    }
}

fn claims_table(groups: &[Group]) -> Table {
    let columns = [
        "experiment",
        "source",
        "claim",
        "theirs",
        "ours",
        "low",
        "high",
        "rule",
        "verdict",
        "command",
    ];
    let mut table = Table::new("claims", &columns);
    for group in groups {
        for f in &group.findings {
            let [low, high] = f.interval();
            table.rows.push(vec![
                group.name.clone(),
                f.source.to_owned(),
                f.claim.to_owned(),
                f.theirs.to_owned(),
                cell(f.estimate.map(|e| e.value)),
                cell(low),
                cell(high),
                f.rule.clone(),
                f.verdict.name().to_owned(),
                f.command.to_owned(),
            ]);
        }
    }
    table
}

fn numbers_table(groups: &[Group]) -> Table {
    let columns = [
        "experiment",
        "number",
        "ours",
        "low",
        "high",
        "people",
        "command",
    ];
    let mut table = Table::new("numbers", &columns);
    for group in groups {
        for n in &group.numbers {
            let [low, high] = n.interval();
            table.rows.push(vec![
                group.name.clone(),
                n.name.to_owned(),
                cell(n.estimate.map(|e| e.value)),
                cell(low),
                cell(high),
                n.people.to_owned(),
                n.command.to_owned(),
            ]);
        }
    }
    table
}
