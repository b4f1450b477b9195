//! `gaitshift train`: a run from recipe to controller.

use crate::arguments::TrainArguments;
use crate::failure::Failure;
use crate::output;
use crate::progress::{Watcher, count, duration};
use crate::view;
use gaitshift_experiment::{Experiment, RunReport, Training, folder_name, portable_command};
use gaitshift_figures::episode_returns_figure;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The report with the files it speaks of.
#[derive(Serialize)]
struct Report<'a> {
    folder: &'a Path,
    controller: &'a Path,
    #[serde(flatten)]
    report: &'a RunReport,
}

/// Runs the command.
pub fn run(arguments: &TrainArguments) -> Result<(), Failure> {
    let interrupted = catch_interrupts()?;
    let (folder, mut training) = prepare(arguments)?;
    output::note(&format!("run in {}", folder.display()));
    if arguments.view {
        view::beside_training(&folder)?;
    }
    let mut watcher = Watcher::new(interrupted, arguments.steps);
    let report = training.run(&mut watcher).map_err(Failure::run)?;
    watcher.finish();
    if let Err(cause) = write_returns(&folder) {
        output::note(&format!("no figure of the returns: {cause}"));
    }

    // The best controller stands there from the first evaluation on, the last one from a checkpoint on.
    let name = if report.best_step > 0 {
        "controller.safetensors"
    } else {
        "controller-last.safetensors"
    };
    let controller = folder.join(name);
    if !report.finished {
        output::note(&format!(
            "stopped with a checkpoint; resume with: gaitshift train --resume {}",
            folder.display()
        ));
    }
    if arguments.json {
        output::json(&Report {
            folder: &folder,
            controller: &controller,
            report: &report,
        })?;
    } else {
        for line in describe(&report, &controller) {
            output::line(&line)?;
        }
    }
    if watcher.interrupted() && !report.finished {
        Err(Failure::Interrupted)
    } else {
        Ok(())
    }
}

/// A new run, or one to go on with, and its folder.
fn prepare(arguments: &TrainArguments) -> Result<(PathBuf, Training), Failure> {
    if let Some(folder) = &arguments.resume {
        let mut training = Training::resume(folder).map_err(Failure::input)?;
        if let Some(threads) = arguments.threads {
            let set = training.set_threads(usize::from(threads));
            set.map_err(Failure::input)?;
        }
        return Ok((folder.clone(), training));
    }
    let origin = &arguments.experiment;
    let mut experiment = Experiment::load(origin).map_err(Failure::input)?;
    if let Some(seed) = arguments.seed {
        experiment.seed = seed;
    }
    if let Some(threads) = arguments.threads {
        experiment.learner.threads = usize::from(threads);
    }
    experiment.training.stop_when_accepted |= arguments.stop_when_accepted;
    let folder = arguments.out.clone().unwrap_or_else(|| {
        let name = format!("{}-{}", folder_name(&experiment.name), experiment.seed);
        Path::new("runs").join(name)
    });
    let training = Training::new(
        experiment,
        &folder,
        &portable_command(std::env::args_os().skip(1)),
    )
    .map_err(Failure::input)?;
    Ok((folder, training))
}

/// The first Ctrl-C asks for a checkpoint, the second ends the program at once.
pub fn catch_interrupts() -> Result<Arc<AtomicBool>, Failure> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&interrupted);
    ctrlc::set_handler(move || {
        if seen.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
        output::note("stopping after a checkpoint; press Ctrl-C again to stop at once");
    })
    .map_err(Failure::run)?;
    Ok(interrupted)
}

/// A report in a few lines.
fn describe(r: &RunReport, controller: &Path) -> Vec<String> {
    let mut lines = vec![format!(
        "{} steps and {} updates in {}",
        count(r.step),
        count(r.updates),
        duration(r.elapsed_s)
    )];
    let shares = r.parts.named().map(|(name, part_s)| {
        let share = 100.0 * part_s / r.elapsed_s.max(f64::MIN_POSITIVE);
        format!("{name} {share:.1} %")
    });
    lines.push(format!("of that {}", shares.join(", ")));
    if r.diverged > 0 {
        lines.push(format!(
            "{} simulations diverged and were not learned from",
            count(r.diverged)
        ));
    }
    if r.best_step > 0 {
        lines.push(format!(
            "best evaluation at step {}: {} of {} criteria",
            count(r.best_step),
            r.best_met,
            r.criteria
        ));
    }
    if let Some((step, after_s)) = r.accepted_at_step.zip(r.accepted_after_s) {
        lines.push(format!(
            "every criterion first met at step {}, after {}",
            count(step),
            duration(after_s)
        ));
    }
    lines.push(format!("controller: {}", controller.display()));
    lines.push(format!(
        "look at it: gaitshift demo --controller {}",
        controller.display()
    ));
    lines
}

/// Draws the return of every episode into the run's folder, in the manner of the paper's Fig. 4.
fn write_returns(folder: &Path) -> Result<(), String> {
    let path = folder.join("episodes.csv");
    let text = |e: csv::Error| format!("{}: {e}", path.display());
    let mut reader = csv::Reader::from_path(&path).map_err(text)?;
    let (mut steps, mut returns, mut commands) = (Vec::new(), Vec::new(), Vec::new());
    for record in reader.deserialize() {
        let episode: Episode = record.map_err(text)?;
        steps.push(episode.step);
        returns.push(episode.total_reward);
        commands.push(episode.omega_v);
    }
    if steps.is_empty() {
        return Ok(());
    }
    episode_returns_figure(&steps, &returns, &commands)
        .and_then(|figure| figure.write(folder.join("returns")))
        .map(|_| ())
        .map_err(|e| e.to_string())
}

/// What the figure needs of a line of `episodes.csv`.
#[derive(serde::Deserialize)]
struct Episode {
    step: f64,
    omega_v: f64,
    total_reward: f64,
}
