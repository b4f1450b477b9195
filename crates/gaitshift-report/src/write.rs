//! Writes the page with its figures and numbers.

use crate::claims::{Judged, judge_claims};
use crate::figures::{self, Shown};
use crate::group::Group;
use crate::page::{self, Content, InFull};
use crate::recorded::RecordedExperiment;
use crate::source::Commands;
use crate::study::{Measured, Plan, Saying, Study};
use crate::table::{Table, cell};
use crate::{ReportError, Subject};
use gaitshift_experiment::folder_name;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// Pixels for each unit of a figure, so that PNGs have 300 dots per inch at their own size.
const PNG_SCALE: f64 = 300.0 / 96.0;

const FORMAT: &str = "gaitshift-report ";
const FORMAT_VERSION: &str = "gaitshift-report 2";

/// Everything in `report.json`.
#[derive(Serialize)]
struct Numbers<'a> {
    format: &'static str,
    version: &'static str,
    plan: &'a Plan,
    claims: &'a [Judged],
    experiments: &'a [Group],
    studies: &'a [Study],
}

/// How the measuring goes on.
pub struct Work<'a> {
    /// Controllers that are measured at a time.
    pub threads: usize,
    /// Told what is being measured, of whom.
    pub say: &'a (dyn Fn(&str) + Sync),
    /// Whether to stop; asked now and then.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}

/// What is left of a subject that was measured.
struct Done {
    study: Study,
    /// Of one that is shown in full.
    figures: Option<Vec<Shown>>,
}

/// Measures the subjects and writes `report.html`, `report.json` and a folder of figures and tables into `folder`; gives the
/// files written. Of every experiment the first subject is shown in full, with figures; of the others there are numbers. What
/// is measured of a run is kept in its folder. Experiments without a subject are judged, and shown in the figures over all, by what is
/// recorded of them.
///
/// The same subjects and plan give the same bytes, on any number of threads.
///
/// # Errors
/// Without subjects, for a motion, figure or file that cannot be made, and when it is told to stop.
pub fn write_report(
    subjects: &mut [Subject],
    recorded: &[RecordedExperiment],
    plan: &Plan,
    folder: &Path,
    work: &Work,
) -> Result<Vec<PathBuf>, ReportError> {
    if subjects.is_empty() {
        return Err(ReportError::NoSubject);
    }
    // What cannot be written is said before anything is measured.
    std::fs::create_dir_all(folder).map_err(|cause| ReportError::Write {
        path: folder.to_owned(),
        cause,
    })?;
    // Its figures may be of other controllers.
    let replaces = is_report(folder);
    let commands = Commands::new(subjects, plan);
    let (mut studies, mut each) = (Vec::new(), Vec::new());
    for done in measure_all(subjects, plan, work)? {
        studies.push(done.study);
        each.push(done.figures);
    }
    (work.say)("figures and page");
    let all: Vec<&Study> = studies.iter().collect();
    let groups = Group::all(&all);
    let judged = judge_claims(&all, recorded);
    let recalled = recorded
        .iter()
        .filter(|r| !studies.iter().any(|s| s.group == r.name));
    let shown = studies.iter().chain(recalled.flat_map(|r| &r.studies));
    let repeats = recorded.iter().filter_map(|r| r.repeats.as_deref());
    let common = figures::of_all(&shown.collect::<Vec<_>>(), &repeats.collect::<Vec<_>>())?;

    let mut files = Files {
        root: folder,
        written: Vec::new(),
    };
    for shown in &common {
        files.figure("figures", shown)?;
    }
    let mut full = Vec::new();
    for (index, (study, figures)) in studies.iter().zip(each).enumerate() {
        let Some(figures) = figures else { continue };
        let place = match studies.len() {
            1 => "figures".to_owned(),
            _ => format!("figures/{}-{}", index + 1, folder_name(&study.name)),
        };
        for shown in &figures {
            files.figure(&place, shown)?;
        }
        full.push(InFull {
            study,
            place,
            figures,
        });
    }
    for (name, table) in [
        ("claims", claims_table(&judged, &commands)),
        ("numbers", numbers_table(&groups, &commands)),
    ] {
        files.table("", name, &table)?;
    }
    let numbers = Numbers {
        format: FORMAT_VERSION,
        version: env!("CARGO_PKG_VERSION"),
        plan,
        claims: &judged,
        experiments: &groups,
        studies: &studies,
    };
    let json = serde_json::to_string_pretty(&numbers)
        .map_err(|cause| ReportError::Subject(cause.to_string()))?;
    files.write("report.json", (json + "\n").as_bytes())?;
    let html = page::html(&Content {
        commands: &commands,
        judged: &judged,
        recorded,
        groups: &groups,
        studies: &studies,
        common: &common,
        full: &full,
    });
    files.write("report.html", html.as_bytes())?;
    if replaces {
        files.clear(&folder.join("figures"))?;
    }
    // The page first: it is what to open.
    files.written.reverse();
    Ok(files.written)
}

/// Measures every subject; they come back in their order.
fn measure_all(
    subjects: &mut [Subject],
    plan: &Plan,
    work: &Work,
) -> Result<Vec<Done>, ReportError> {
    let count = subjects.len();
    let names: Vec<String> = subjects.iter().map(|s| s.group.clone()).collect();
    let queue = Mutex::new(subjects.iter_mut().enumerate());
    let failed = AtomicBool::new(false);
    let next = || queue.lock().ok()?.next();
    let worker = || {
        let mut done = Vec::new();
        while let Some((index, subject)) = next() {
            let first = !names[..index].contains(&subject.group);
            let name = subject.name.clone();
            let mut say = |what: &str| {
                if failed.load(Ordering::SeqCst) || (work.stop)() {
                    return Err(ReportError::Stopped);
                }
                (work.say)(&format!("{name}: {what}"));
                Ok(())
            };
            let result = measure_one(subject, plan, first, &mut say);
            failed.fetch_or(result.is_err(), Ordering::SeqCst);
            done.push((index, result));
        }
        done
    };
    let mut results = std::thread::scope(|scope| {
        // Where the system refuses a thread they are fewer.
        let threads: Vec<_> = (1..work.threads.min(count))
            .map_while(|_| std::thread::Builder::new().spawn_scoped(scope, worker).ok())
            .collect();
        let own = worker();
        let join = |thread: std::thread::ScopedJoinHandle<'_, Vec<_>>| match thread.join() {
            Ok(done) => done,
            Err(panic) => std::panic::resume_unwind(panic),
        };
        let others = threads.into_iter().flat_map(join);
        own.into_iter().chain(others).collect::<Vec<_>>()
    });
    // Of several errors the one that stopped the others.
    results.sort_by_key(|(index, result)| (matches!(result, Err(ReportError::Stopped)), *index));
    results.into_iter().map(|(_, result)| result).collect()
}

fn measure_one(
    subject: &mut Subject,
    plan: &Plan,
    in_full: bool,
    say: &mut Saying,
) -> Result<Done, ReportError> {
    if !in_full {
        return Ok(Done {
            study: Study::measure(subject, plan, say)?,
            figures: None,
        });
    }
    let measured = Measured::measure(subject, plan, say)?;
    let figures = figures::of_one(subject, &measured, &plan.of(subject))?;
    Ok(Done {
        study: measured.study,
        figures: Some(figures),
    })
}

/// Endings of what is written into the folder of figures.
const WRITTEN: [&str; 4] = ["svg", "png", "csv", "json"];

/// Whether a folder holds an earlier report.
fn is_report(folder: &Path) -> bool {
    let text = std::fs::read_to_string(folder.join("report.json")).unwrap_or_default();
    let numbers: Option<serde_json::Value> = serde_json::from_str(&text).ok();
    let format = numbers.and_then(|numbers| Some(numbers["format"].as_str()?.to_owned()));
    format.is_some_and(|format| format.starts_with(FORMAT))
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
        gaitshift_analysis::write_whole(&path, bytes).map_err(failed)?;
        self.written.push(path);
        Ok(())
    }

    /// Removes the figures and tables below a folder that are not of this report.
    fn clear(&self, at: &Path) -> Result<(), ReportError> {
        let failed = |cause| ReportError::Write {
            path: at.to_owned(),
            cause,
        };
        for entry in std::fs::read_dir(at).map_err(failed)? {
            let entry = entry.map_err(failed)?;
            let kind = entry.file_type().map_err(failed)?;
            // What a link leads to is not of a report.
            if kind.is_symlink() {
                continue;
            }
            let path = entry.path();
            let ending = path.extension().and_then(|ending| ending.to_str());
            if kind.is_dir() {
                self.clear(&path)?;
                // Of what others keep there it stays.
                let _ = std::fs::remove_dir(&path);
            } else if ending.is_some_and(|ending| WRITTEN.contains(&ending))
                && !self.written.contains(&path)
            {
                std::fs::remove_file(&path).map_err(failed)?;
            }
        }
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

/// One row for each claim and experiment that says something about it.
fn claims_table(judged: &[Judged], commands: &Commands) -> Table {
    let columns = [
        "source",
        "claim",
        "theirs",
        "rule",
        "experiment",
        "ours",
        "low",
        "high",
        "seeds",
        "verdict",
        "recorded",
        "command",
        "value_of_command",
    ];
    let mut table = Table::new("claims", &columns);
    for j in judged {
        let (command, value) = commands.of(j.shown_by);
        for f in j.findings() {
            let [low, high] = f.interval();
            table.rows.push(vec![
                j.source.to_owned(),
                j.claim.to_owned(),
                j.theirs.to_owned(),
                j.rule.clone(),
                f.experiment.clone(),
                cell(f.estimate.map(|e| e.value)),
                cell(low),
                cell(high),
                seeds(&f.seeds),
                f.verdict.name().to_owned(),
                f.recorded.to_string(),
                command.clone(),
                value.to_owned(),
            ]);
        }
    }
    table
}

fn numbers_table(groups: &[Group], commands: &Commands) -> Table {
    let columns = [
        "experiment",
        "number",
        "ours",
        "low",
        "high",
        "seeds",
        "people",
        "command",
        "value_of_command",
    ];
    let mut table = Table::new("numbers", &columns);
    for group in groups {
        for n in &group.numbers {
            let [low, high] = n.interval();
            let (command, value) = commands.of(n.shown_by);
            table.rows.push(vec![
                group.name.clone(),
                n.name.to_owned(),
                cell(n.estimate.map(|e| e.value)),
                cell(low),
                cell(high),
                seeds(&n.seeds),
                n.people.to_owned(),
                command,
                value.to_owned(),
            ]);
        }
    }
    table
}

/// One value per seed, with a space between; `none` where a seed has none.
fn seeds(values: &[Option<f64>]) -> String {
    let word = |value: &Option<f64>| value.map_or_else(|| "none".to_owned(), |v| format!("{v:?}"));
    values.iter().map(word).collect::<Vec<_>>().join(" ")
}
