//! `gaitshift evaluate`: steady motions, one row each.

use crate::arguments::{EvaluateArguments, distinct, distinct_commands};
use crate::failure::Failure;
use crate::gaits::{Row, describe, print_gaits, print_rows, print_too_short_of};
use crate::motion::{Subject, read_profile, start_words, write_recording};
use crate::output;
use crate::spread::{self, Spread};
use crate::unseen;
use gaitshift_experiment::{Check, CommandProfile, Controller, Criteria, Judgement, judge_from};
use gaitshift_figures::{SweepPoint, SweepSeries, sweep_figure};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Shortest motion without --duration-s, and what follows a profile's last point, in s.
const DURATION_S: f64 = 20.0;
const BEYOND_PROFILE_S: f64 = 5.0;
/// Characters of what a figure's legend says beside the controller's name.
const LEGEND: usize = 60;

#[derive(Serialize)]
struct Rows<'a> {
    rows: &'a [Row],
    #[serde(skip_serializing_if = "Option::is_none")]
    spread: Option<Vec<Spread>>,
}

#[derive(Serialize)]
struct Verdict<'a> {
    /// The seed that drew the start, where one was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    seed: Option<u64>,
    accepted: bool,
    met: usize,
    #[serde(flatten)]
    judgement: &'a Judgement,
}

/// Judgements from several starts.
#[derive(Serialize)]
struct Verdicts<'a> {
    /// Number of starts from which every criterion is met.
    accepted: usize,
    starts: Vec<Verdict<'a>>,
}

/// Runs the command.
pub fn run(arguments: &EvaluateArguments) -> Result<(), Failure> {
    let mut subject = Subject::load(&arguments.subject)?;
    let seeds = distinct(&arguments.seed).map_err(Failure::input)?;
    let disturbance = arguments.disturbances.read()?;
    if arguments.criteria.is_some() && disturbance.is_some() {
        return Err(Failure::input(
            "--criteria measures undisturbed motions; leave out the disturbances, or use `gaitshift stress`",
        ));
    }
    subject.disturb(disturbance);
    if let Some(file) = &arguments.criteria {
        let (criteria, origin) = criteria(
            file.as_deref(),
            arguments.subject.which.controller.as_deref(),
        )?;
        return run_criteria(
            &mut subject,
            &criteria,
            &origin,
            &seeds,
            arguments.print.json,
        );
    }
    let (rows, files) = measure(&mut subject, arguments, &seeds)?;
    unseen::note(rows.iter(), subject.disturbance());
    let spread = (seeds.len() > 1).then(|| match &arguments.command_profile {
        Some(_) => spread::of_one(&rows),
        None => spread::of(&rows),
    });
    if arguments.print.json {
        return output::json(&Rows {
            rows: &rows,
            spread,
        });
    }
    let start = start_words(&seeds);
    output::line(&format!(
        "{}, {start}{}, {}",
        subject.name,
        subject.circumstances(),
        described(&rows, arguments.settling_s)
    ))?;
    match spread {
        Some(spread) => {
            spread::table(&[], spread.iter().map(|s| (vec![], s)))
                .iter()
                .try_for_each(|line| output::line(line))?;
            print_too_short_of(rows.iter())?;
        }
        None => print_rows(&rows)?,
    }
    output::written(&files)
}

/// Which part of the motions the figures describe. Of a short motion that is its second half, whatever was asked for.
fn described(rows: &[Row], settling_s: f64) -> String {
    let starts = || rows.iter().filter_map(|row| row.summary.window_start_s);
    let least = starts().fold(f64::INFINITY, f64::min);
    let greatest = starts().fold(f64::NEG_INFINITY, f64::max);
    let seconds = |value: f64| (value * 100.0).round() / 100.0;
    if least == f64::INFINITY {
        return "nothing measured".to_owned();
    }
    if starts().all(|start_s| (start_s - settling_s).abs() < 0.005) {
        format!("measured from {settling_s} s on")
    } else if greatest - least < 0.005 {
        format!(
            "measured from {} s on, the middle of the motion",
            seconds(greatest)
        )
    } else if (greatest - settling_s).abs() < 0.005 {
        format!(
            "measured from {settling_s} s on; of motions that ended before {} s, the second half",
            seconds(2.0 * settling_s)
        )
    } else {
        "measured in the second half of each motion".to_owned()
    }
}

/// The starts of the motions: those that seeds draw, without any the default start.
pub fn starts(seeds: &[u64]) -> Vec<Option<u64>> {
    match seeds {
        [] => vec![None],
        seeds => seeds.iter().copied().map(Some).collect(),
    }
}

/// Moves, describes, and writes what was asked for.
fn measure(
    subject: &mut Subject,
    arguments: &EvaluateArguments,
    seeds: &[u64],
) -> Result<(Vec<Row>, Vec<PathBuf>), Failure> {
    let motions: Vec<(String, CommandProfile)> = match &arguments.command_profile {
        Some(path) => vec![("profile".to_owned(), read_profile(path)?)],
        None => distinct_commands(&arguments.omega_v)
            .map_err(Failure::input)?
            .into_iter()
            .map(|omega_v| {
                let name = format!("omega_v_{omega_v}");
                (name, CommandProfile::constant(omega_v))
            })
            .collect(),
    };
    let starts = starts(seeds);
    let file_name = |name: &str, seed: Option<u64>| match seed.filter(|_| starts.len() > 1) {
        Some(seed) => format!("{name}_seed_{seed}.csv"),
        None => format!("{name}.csv"),
    };
    if let Some(folder) = &arguments.out {
        output::create_folder(folder)?;
        if let Some(profile) = &arguments.command_profile {
            for (name, _) in &motions {
                for &seed in &starts {
                    output::not_over(profile, &folder.join(file_name(name, seed)))?;
                }
            }
        }
    }
    if let (Some(path), Some(duration_s)) = (&arguments.command_profile, arguments.duration_s) {
        let end_s = motions.iter().map(|(_, p)| p.end_s()).fold(0.0, f64::max);
        if duration_s < end_s {
            output::note(&format!(
                "the command of {} changes up to {end_s} s, the motion lasts {duration_s} s; give a longer --duration-s to \
                 see all of it",
                path.display()
            ));
        }
    }
    let mut rows = Vec::new();
    let mut files = Vec::new();
    for (name, profile) in &motions {
        for &seed in &starts {
            subject.start_at(seed);
            let duration_s = arguments
                .duration_s
                .unwrap_or_else(|| DURATION_S.max(profile.end_s() + BEYOND_PROFILE_S));
            let recording = subject.record(profile, duration_s)?;
            rows.push(Row {
                seed,
                ..describe(&recording, arguments.settling_s)
            });
            if let Some(folder) = &arguments.out {
                files.push(write_recording(&recording, folder, &file_name(name, seed))?);
            }
        }
    }
    if let Some(folder) = &arguments.out {
        let label = match subject.circumstances() {
            // More than a legend holds.
            long if long.chars().count() > LEGEND => format!("{}, disturbed", subject.name),
            short => format!("{}{short}", subject.name),
        };
        // Of a command that changes there is nothing to draw.
        let drawn = match &arguments.command_profile {
            Some(_) => Vec::new(),
            None => points(&rows),
        };
        let written = write_sweep(&[(&label, drawn)], folder)?;
        if written.is_empty() {
            output::remove_picture(&folder.join("sweep"))?;
        }
        files.extend(written);
    }
    Ok((rows, files))
}

/// The points of a figure of all commands: of several starts their means.
pub fn points(rows: &[Row]) -> Vec<SweepPoint> {
    if rows.iter().any(|row| row.seed != rows[0].seed) {
        return spread::of(rows).iter().filter_map(Spread::point).collect();
    }
    rows.iter()
        .filter_map(|row| Some(SweepPoint::new(row.omega_v?, &row.summary)))
        .collect()
}

/// Writes the figure of all commands of one or more controllers, if there is a command to draw.
pub fn write_sweep(
    controllers: &[(&str, Vec<SweepPoint>)],
    folder: &Path,
) -> Result<Vec<PathBuf>, Failure> {
    let series: Vec<SweepSeries> = controllers
        .iter()
        .filter(|(_, points)| !points.is_empty())
        .map(|(label, points)| SweepSeries {
            label: (*label).to_owned(),
            points: points.clone(),
        })
        .collect();
    if series.is_empty() {
        return Ok(Vec::new());
    }
    sweep_figure(&series)
        .and_then(|figure| figure.write(folder.join("sweep")))
        .map_err(output::figure_failure)
}

/// The criteria of a file; without one those of the run whose folder stands for its controller, otherwise the paper's.
/// And where they come from.
pub fn criteria(
    file: Option<&Path>,
    controller: Option<&Path>,
) -> Result<(Criteria, String), Failure> {
    let run = controller.and_then(Controller::run_of);
    let (criteria, origin) = match (file, run) {
        (Some(file), _) => (Criteria::load(file), file.display().to_string()),
        (None, Some(run)) => (Criteria::of_run(run), format!("of {}", run.display())),
        (None, None) => (
            Ok(Criteria::default()),
            "the default ones, after the paper".to_owned(),
        ),
    };
    Ok((criteria.map_err(Failure::input)?, origin))
}

/// Judges by the criteria of a finished controller, from the default start or from those that seeds draw.
fn run_criteria(
    subject: &mut Subject,
    criteria: &Criteria,
    origin: &str,
    seeds: &[u64],
    json: bool,
) -> Result<(), Failure> {
    let starts = starts(seeds);
    let heading = |start: &str, subject: &Subject| {
        format!(
            "{}, {start}{}; {criteria} ({origin})",
            subject.name,
            subject.circumstances()
        )
    };
    let mut judgements = Vec::new();
    for &seed in &starts {
        subject.start_at(seed);
        let (body, task, mut policy) = subject.parts();
        judgements.push(judge_from(body, task, criteria, seed, &mut policy).map_err(Failure::run)?);
    }
    let verdicts: Vec<Verdict<'_>> = starts
        .iter()
        .zip(&judgements)
        .map(|(&seed, judgement)| Verdict {
            seed,
            accepted: judgement.accepted(),
            met: judgement.met(),
            judgement,
        })
        .collect();
    let accepted = verdicts.iter().filter(|verdict| verdict.accepted).count();
    let all = accepted == verdicts.len();
    match &verdicts[..] {
        [verdict] if json => output::json(verdict)?,
        _ if json => output::json(&Verdicts {
            accepted,
            starts: verdicts,
        })?,
        [verdict] => {
            output::line(&heading(&subject.start_name(), subject))?;
            print_verdict(verdict)?;
        }
        several => {
            let start = format!("{} random starts", several.len());
            output::line(&heading(&start, subject))?;
            print_shares(&judgements)?;
            output::line(&format!(
                "every criterion is met from {accepted} of {} starts",
                several.len()
            ))?;
        }
    }
    if all { Ok(()) } else { Err(Failure::Unmet) }
}

/// The motions and every criterion.
fn print_verdict(verdict: &Verdict<'_>) -> Result<(), Failure> {
    let judgement = verdict.judgement;
    let rows = judgement.rows.iter();
    print_gaits(rows.map(|row| (Some(row.omega_v), &row.summary)), "")?;
    for check in &judgement.checks {
        let met = if check.met { "met    " } else { "not met" };
        let value = output::number(check.value, 3);
        output::line(&format!("{met}  {value:>7}  {}", check.name))?;
        if let Some(reason) = &check.reason {
            output::line(&format!("{:18}{reason}", ""))?;
        }
    }
    let count = judgement.checks.len();
    output::line(&format!("{} of {count} criteria met", verdict.met))
}

/// From how many starts each criterion is met, and between which values what it measures lies.
fn print_shares(judgements: &[Judgement]) -> Result<(), Failure> {
    let names = judgements.first().map_or(&[][..], |first| &first.checks);
    let mut cells = vec![
        ["met", "least", "greatest", "criterion"]
            .map(str::to_owned)
            .to_vec(),
    ];
    for (k, Check { name, .. }) in names.iter().enumerate() {
        let each = || {
            judgements
                .iter()
                .filter_map(|judgement| judgement.checks.get(k))
        };
        let values = || each().filter_map(|check| check.value);
        cells.push(vec![
            format!(
                "{} of {}",
                each().filter(|check| check.met).count(),
                judgements.len()
            ),
            output::number(values().reduce(f64::min), 3),
            output::number(values().reduce(f64::max), 3),
            name.clone(),
        ]);
    }
    output::table(&cells, &[3])
        .iter()
        .try_for_each(|line| output::line(line))
}
