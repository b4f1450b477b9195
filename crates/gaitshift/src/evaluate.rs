//! `gaitshift evaluate`: steady motions, one row each.

use crate::arguments::EvaluateArguments;
use crate::failure::Failure;
use crate::gaits::{Row, describe, print_rows};
use crate::motion::{Subject, read_profile, write_recording};
use crate::output;
use crate::spread::{self, Spread};
use gaitshift_experiment::{CommandProfile, Criteria, Judgement, judge};
use gaitshift_figures::{SweepPoint, SweepSeries, sweep_figure};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Shortest motion without --duration-s, and what follows a profile's last point, in s.
const DURATION_S: f64 = 20.0;
const BEYOND_PROFILE_S: f64 = 5.0;

#[derive(Serialize)]
struct Rows<'a> {
    rows: &'a [Row],
    #[serde(skip_serializing_if = "Option::is_none")]
    spread: Option<Vec<Spread>>,
}

#[derive(Serialize)]
struct Verdict<'a> {
    accepted: bool,
    met: usize,
    #[serde(flatten)]
    judgement: &'a Judgement,
}

/// Runs the command.
pub fn run(arguments: &EvaluateArguments) -> Result<(), Failure> {
    let mut subject = Subject::load(&arguments.subject)?;
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
        return run_criteria(&mut subject, &criteria, &origin, arguments.print.json);
    }
    let seeds: Vec<u64> = arguments.seed.iter().flat_map(|s| s.0.clone()).collect();
    let (rows, files) = measure(&mut subject, arguments, &seeds)?;
    let spread = (seeds.len() > 1).then(|| spread::of(&rows));
    if arguments.print.json {
        return output::json(&Rows {
            rows: &rows,
            spread,
        });
    }
    let start = match &seeds[..] {
        [] | [_] => subject.start_name(),
        several => format!("{} random starts", several.len()),
    };
    output::line(&format!(
        "{}, {start}{}, {}",
        subject.name,
        subject.disturbance_name(),
        described(&rows, arguments.settling_s)
    ))?;
    match spread {
        Some(spread) => spread::table(&[], spread.iter().map(|s| (vec![], s)))
            .iter()
            .try_for_each(|line| output::line(line))?,
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
    if starts().all(|start_s| (start_s - settling_s).abs() < 0.005) {
        format!("measured from {settling_s} s on")
    } else if greatest - least < 0.005 {
        format!(
            "measured from {} s on, the middle of the motion",
            seconds(greatest)
        )
    } else {
        format!(
            "measured from {} s on, shorter motions from their midpoint on",
            seconds(greatest)
        )
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
        None => arguments
            .omega_v
            .iter()
            .flat_map(|commands| &commands.0)
            .map(|&omega_v| {
                let name = format!("omega_v_{omega_v}");
                (name, CommandProfile::constant(omega_v))
            })
            .collect(),
    };
    if let Some(folder) = &arguments.out {
        output::create_folder(folder)?;
    }
    let starts: Vec<Option<u64>> = match seeds {
        [] => vec![None],
        seeds => seeds.iter().copied().map(Some).collect(),
    };
    let mut rows = Vec::new();
    let mut files = Vec::new();
    for (name, profile) in &motions {
        for &seed in &starts {
            subject.start_at(seed);
            let duration_s = arguments
                .duration_s
                .unwrap_or_else(|| DURATION_S.max(profile.end_s() + BEYOND_PROFILE_S));
            let recording = subject.record(profile, duration_s)?;
            let several = seed.filter(|_| starts.len() > 1);
            rows.push(Row {
                seed,
                ..describe(&recording, arguments.settling_s)
            });
            if let Some(folder) = &arguments.out {
                let suffix = several.map_or_else(String::new, |seed| format!("_seed_{seed}"));
                let name = format!("{name}{suffix}.csv");
                files.push(write_recording(&recording, folder, &name)?);
            }
        }
    }
    if let Some(folder) = &arguments.out {
        files.extend(write_sweep(&[(&subject.name, points(&rows))], folder)?);
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
    let run = controller.filter(|path| path.join("config.toml").is_file());
    let (criteria, origin) = match (file, run) {
        (Some(file), _) => (Criteria::load(file), file.display().to_string()),
        (None, Some(run)) => (Criteria::of_run(run), format!("of {}", run.display())),
        (None, None) => (Ok(Criteria::default()), "the paper's".to_owned()),
    };
    Ok((criteria.map_err(Failure::input)?, origin))
}

/// Judges by the criteria of a finished controller.
fn run_criteria(
    subject: &mut Subject,
    criteria: &Criteria,
    origin: &str,
    json: bool,
) -> Result<(), Failure> {
    let name = subject.name.clone();
    let (body, task, mut policy) = subject.parts();
    let judgement = judge(body, task, criteria, &mut policy).map_err(Failure::run)?;
    let verdict = Verdict {
        accepted: judgement.accepted(),
        met: judgement.met(),
        judgement: &judgement,
    };
    if json {
        output::json(&verdict)?;
    } else {
        output::line(&format!("{name}; {criteria} ({origin})"))?;
        let rows = judgement
            .rows
            .iter()
            .map(|row| (row.omega_v.to_string(), &row.summary));
        for line in output::gait_table(rows) {
            output::line(&line)?;
        }
        for check in &judgement.checks {
            let met = if check.met { "met    " } else { "not met" };
            let value = output::number(check.value, 3);
            output::line(&format!("{met}  {value:>7}  {}", check.name))?;
            if let Some(reason) = &check.reason {
                output::line(&format!("{:18}{reason}", ""))?;
            }
        }
        let count = judgement.checks.len();
        output::line(&format!("{} of {count} criteria met", verdict.met))?;
    }
    if verdict.accepted {
        Ok(())
    } else {
        Err(Failure::Unmet)
    }
}
