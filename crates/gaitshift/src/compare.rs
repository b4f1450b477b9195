//! `gaitshift compare`: controllers, runs and recordings beside each other.

use crate::arguments::{CompareArguments, distinct, distinct_commands, distinct_paths};
use crate::evaluate::{self, starts};
use crate::failure::Failure;
use crate::gaits::{self, Row, print_named_gaits, print_too_short_of, read_recording};
use crate::motion::{Subject, load_controller, start_words};
use crate::output;
use crate::progress::{count, duration};
use crate::spread::{self, Spread};
use crate::sweep;
use crate::unseen;
use gaitshift_analysis::Recording;
use gaitshift_experiment::{
    CommandProfile, Controller, Estimate, Evaluation, RunName, SweepTable, VariantSummary,
};
use gaitshift_figures::{LearningCurves, learning_curves_figure};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Something to compare.
enum Item {
    Controller(Box<Subject>),
    Recording(Box<Recording>),
}

/// A row with the name of what it is of.
#[derive(Serialize)]
struct Named<'a, T> {
    name: &'a str,
    #[serde(flatten)]
    row: &'a T,
}

/// The course of a run.
#[derive(Serialize)]
struct Run {
    name: String,
    experiment: String,
    seed: u64,
    evaluations: usize,
    best_step: Option<u64>,
    best_met: Option<usize>,
    criteria: Option<usize>,
    elapsed_s: Option<f64>,
    #[serde(skip)]
    course: Vec<(f64, f64)>,
}

#[derive(Serialize)]
struct Comparison<'a> {
    rows: Vec<Named<'a, Row>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    spread: Option<Vec<Named<'a, Spread>>>,
    runs: &'a [Run],
    /// Runs of one experiment together.
    experiments: &'a [VariantSummary],
}

/// Runs the command.
pub fn run(arguments: &CompareArguments) -> Result<(), Failure> {
    let a = arguments;
    distinct_paths(&a.items).map_err(Failure::input)?;
    let folders: Vec<&Path> = a
        .items
        .iter()
        .map(PathBuf::as_path)
        .filter(|path| Controller::run_of(path).is_some())
        .collect();
    let names = RunName::read_all(&folders).map_err(Failure::input)?;
    let runs: Vec<Run> = folders
        .iter()
        .zip(names)
        .map(|(folder, of)| Run::read(folder, of))
        .collect::<Result<_, _>>()?;
    let items: Vec<(String, Item)> = a
        .items
        .iter()
        .map(|path| Ok((name_of(path), load(path, a)?)))
        .collect::<Result<_, Failure>>()?;
    let commands = distinct_commands(&a.omega_v).map_err(Failure::input)?;
    let seeds = distinct(&a.seed).map_err(Failure::input)?;
    // The same for all controllers; recordings have their own.
    let circumstances = items.iter().find_map(|(_, item)| match item {
        Item::Controller(subject) => Some(format!(
            "{}{}",
            start_words(&seeds),
            subject.circumstances()
        )),
        Item::Recording(_) => None,
    });
    let folder = a.print.folder(a.out.as_deref(), "out/compare");
    if let Some(folder) = &folder {
        output::create_folder(folder)?;
    }
    let measured: Vec<(String, Vec<Row>)> = items
        .into_iter()
        .map(|(name, item)| Ok((name, measure(item, a, &commands, &seeds)?)))
        .collect::<Result<_, Failure>>()?;
    unseen::note(measured.iter().flat_map(|(_, rows)| rows), None);
    let spreads: Option<Vec<Vec<Spread>>> =
        (seeds.len() > 1).then(|| measured.iter().map(|(_, rows)| spread::of(rows)).collect());

    let table = SweepTable::of_runs("of the runs", &folders).map_err(Failure::input)?;
    let mut files = Vec::new();
    if let Some(folder) = folder {
        // What a comparison of other runs left there, where the folder is this command's own.
        if a.out.is_none() {
            for name in ["learning", "table", "sweep"] {
                output::remove_picture(&folder.join(name))?;
            }
            for name in ["table.md", "table.json"] {
                output::remove(&folder.join(name))?;
            }
        }
        let sweep: Vec<_> = measured
            .iter()
            .map(|(name, rows)| (name.as_str(), evaluate::points(rows)))
            .collect();
        files.extend(evaluate::write_sweep(&sweep, &folder)?);
        files.extend(write_learning(&runs, &folder)?);
        if !table.trials.is_empty() {
            files.extend(sweep::write(&table, &folder)?);
        }
    }
    if a.print.json {
        let rows = measured
            .iter()
            .flat_map(|(name, rows)| rows.iter().map(move |row| Named { name, row }))
            .collect();
        let spread = spreads.as_ref().map(|spreads| {
            measured
                .iter()
                .zip(spreads)
                .flat_map(|((name, _), rows)| rows.iter().map(move |row| Named { name, row }))
                .collect()
        });
        return output::json(&Comparison {
            rows,
            spread,
            runs: &runs,
            experiments: &table.variants,
        });
    }
    if let Some(circumstances) = circumstances {
        output::line(&circumstances)?;
    }
    match &spreads {
        Some(spreads) => print_spreads(&measured, spreads)?,
        None => print_rows(&measured)?,
    }
    print_too_short_of(measured.iter().flat_map(|(_, rows)| rows))?;
    if !runs.is_empty() {
        output::line("")?;
        for line in runs_table(&runs) {
            output::line(&line)?;
        }
    }
    if runs.len() > 1 {
        output::line("")?;
        for line in experiments_table(&table.variants) {
            output::line(&line)?;
        }
    }
    output::written(&files)
}

/// An item by the name it was given, without what is the same in all of them.
fn name_of(path: &Path) -> String {
    path.display().to_string().trim_end_matches('/').to_owned()
}

fn load(path: &Path, a: &CompareArguments) -> Result<Item, Failure> {
    if path
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("csv"))
    {
        let recording = read_recording(path)?;
        if a.changes.body.is_some() || !a.changes.set.is_empty() {
            output::note(&format!(
                "{} is a recording: it stays as it is, whatever --body and --set change of the others",
                path.display()
            ));
        }
        return Ok(Item::Recording(Box::new(recording)));
    }
    let subject = Subject::new(load_controller(Some(path))?, name_of(path), &a.changes)?;
    Ok(Item::Controller(Box::new(subject)))
}

fn measure(
    item: Item,
    a: &CompareArguments,
    commands: &[f64],
    seeds: &[u64],
) -> Result<Vec<Row>, Failure> {
    let mut subject = match item {
        Item::Controller(subject) => subject,
        Item::Recording(recording) => {
            return Ok(vec![gaits::describe(&recording, a.settling_s)]);
        }
    };
    let starts = starts(seeds);
    let mut rows = Vec::new();
    for &omega_v in commands {
        for &seed in &starts {
            subject.start_at(seed);
            let recording = subject.record(&CommandProfile::constant(omega_v), a.duration_s)?;
            rows.push(Row {
                seed,
                ..gaits::describe(&recording, a.settling_s)
            });
        }
    }
    Ok(rows)
}

/// Rows under the same command stand beside each other; those without a single command come last.
fn in_order<'a, T>(
    rows: impl Iterator<Item = (&'a str, &'a T)>,
    of: fn(&T) -> Option<f64>,
) -> Vec<(&'a str, &'a T)> {
    let mut rows: Vec<_> = rows.collect();
    let key = |row: &T| of(row).unwrap_or(f64::INFINITY);
    rows.sort_by(|a, b| key(a.1).total_cmp(&key(b.1)));
    rows
}

fn print_rows(measured: &[(String, Vec<Row>)]) -> Result<(), Failure> {
    let all = measured
        .iter()
        .flat_map(|(name, rows)| rows.iter().map(move |row| (name.as_str(), row)));
    let rows = in_order(all, |row: &Row| row.omega_v);
    let rows = rows.iter();
    print_named_gaits(
        "name",
        rows.map(|(name, row)| (row.omega_v, (*name).to_owned(), &row.summary)),
    )
}

fn print_spreads(measured: &[(String, Vec<Row>)], spreads: &[Vec<Spread>]) -> Result<(), Failure> {
    let all = measured
        .iter()
        .zip(spreads)
        .flat_map(|((name, _), rows)| rows.iter().map(move |row| (name.as_str(), row)));
    let rows = in_order(all, |row: &Spread| row.omega_v);
    let cells = rows
        .iter()
        .map(|(name, row)| (vec![(*name).to_owned()], *row));
    spread::table(&["name"], cells)
        .iter()
        .try_for_each(|line| output::line(line))
}

impl Run {
    fn read(folder: &Path, of: RunName) -> Result<Self, Failure> {
        let evaluations = Evaluation::read_all(folder).map_err(Failure::input)?;
        let best = Evaluation::best(&evaluations);
        Ok(Self {
            name: name_of(folder),
            experiment: of.name,
            seed: of.seed,
            evaluations: evaluations.len(),
            best_step: best.map(|e| e.step),
            best_met: best.map(|e| e.met),
            criteria: best.map(|e| e.checks.len()),
            elapsed_s: evaluations.last().map(|e| e.elapsed_s),
            course: evaluations
                .iter()
                .map(|e| (e.step as f64, e.met as f64))
                .collect(),
        })
    }
}

fn runs_table(runs: &[Run]) -> Vec<String> {
    let titles = [
        "run",
        "experiment",
        "seed",
        "criteria, best",
        "at step",
        "trained",
    ];
    let mut cells = vec![titles.map(str::to_owned).to_vec()];
    for run in runs {
        // Evaluations tell how long a run has been trained.
        let shown = |text: Option<String>| text.unwrap_or("-".to_owned());
        let met = run.best_met.zip(run.criteria);
        let met = shown(met.map(|(met, criteria)| format!("{met} of {criteria}")));
        let at = shown(run.best_step.map(count));
        let trained = shown(run.elapsed_s.map(duration));
        cells.push(vec![
            run.name.clone(),
            run.experiment.clone(),
            run.seed.to_string(),
            met,
            at,
            trained,
        ]);
    }
    output::table(&cells, &[0, 1])
}

/// Runs of one experiment together: their seeds are the unit.
fn experiments_table(experiments: &[VariantSummary]) -> Vec<String> {
    let titles = [
        "experiment",
        "runs",
        "best, 95 %",
        "effect, 95 %",
        "walk",
        "run",
        "change",
        "all",
    ];
    let mut cells = vec![titles.map(str::to_owned).to_vec()];
    for e in experiments {
        let shown = |estimate: &Option<Estimate>| {
            estimate.map_or("-".to_owned(), |estimate| estimate.to_string())
        };
        cells.push(vec![
            e.variant.clone(),
            e.seeds.to_string(),
            shown(&e.best_met),
            shown(&e.effect),
            e.walk.to_string(),
            e.run.to_string(),
            e.change.to_string(),
            e.all.to_string(),
        ]);
    }
    output::table(&cells, &[0])
}

/// The criteria met over the course of training: runs of one experiment together.
fn write_learning(runs: &[Run], folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut curves: Vec<LearningCurves> = Vec::new();
    for run in runs.iter().filter(|run| !run.course.is_empty()) {
        match curves.iter_mut().find(|c| c.label == run.experiment) {
            Some(curves) => curves.runs.push(run.course.clone()),
            None => curves.push(LearningCurves {
                label: run.experiment.clone(),
                runs: vec![run.course.clone()],
            }),
        }
    }
    if curves.is_empty() {
        return Ok(Vec::new());
    }
    learning_curves_figure(&curves, "criteria met")
        .and_then(|figure| figure.write(folder.join("learning")))
        .map_err(output::figure_failure)
}
