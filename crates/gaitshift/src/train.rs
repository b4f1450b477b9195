//! `gaitshift train`: a run from recipe to controller.

use crate::arguments::{TrainArguments, distinct};
use crate::failure::Failure;
use crate::output;
use crate::progress::{Watcher, count, duration};
use crate::spread::Moments;
use crate::view;
use gaitshift_experiment::{Experiment, RunReport, Training, folder_name, quoted};
use gaitshift_figures::episode_returns_figure;
use gaitshift_report::Episodes;
use serde::Serialize;
use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The report with the files it speaks of, whose names need not be text: what is not, is replaced.
#[derive(Serialize)]
struct Report<'a> {
    folder: Cow<'a, str>,
    controller: Cow<'a, str>,
    #[serde(flatten)]
    report: &'a RunReport,
}

/// Several runs in one object.
#[derive(Serialize)]
struct Reports<'a> {
    runs: Vec<Report<'a>>,
    spread: Spread,
}

/// Mean and standard deviation over the seeds: of criteria and step those of the runs that were evaluated.
#[derive(Serialize)]
struct Spread {
    best_met: Moments,
    best_step: Moments,
    elapsed_s: Moments,
}

impl Spread {
    fn of(outcomes: &[Outcome]) -> Self {
        let reports = || outcomes.iter().map(|o| &o.report);
        Self {
            best_met: Moments::of(reports().map(|r| r.best_met.map(|met| met as f64))),
            best_step: Moments::of(reports().map(|r| r.best_step.map(|step| step as f64))),
            elapsed_s: Moments::of(reports().map(|r| Some(r.elapsed_s))),
        }
    }
}

/// A finished or stopped run.
struct Outcome {
    folder: PathBuf,
    controller: PathBuf,
    seed: u64,
    report: RunReport,
}

impl Outcome {
    fn report(&self) -> Report<'_> {
        Report {
            folder: self.folder.to_string_lossy(),
            controller: self.controller.to_string_lossy(),
            report: &self.report,
        }
    }
}

/// Runs the command.
pub fn run(arguments: &TrainArguments) -> Result<(), Failure> {
    let interrupted = catch_interrupts("stopping after a checkpoint")?;
    let seeds = seeds(arguments)?;
    if seeds.is_empty() {
        let (folder, training) = prepare(arguments)?;
        let outcome = train(folder, training, arguments, &interrupted)?;
        if arguments.print.json {
            output::json(&outcome.report())?;
        } else {
            describe(&outcome.report, &outcome.controller)?;
        }
        return ended(&interrupted, &outcome.report);
    }
    train_seeds(&seeds, arguments, &interrupted)
}

/// The seeds of --seeds.
pub fn seeds(arguments: &TrainArguments) -> Result<Vec<u64>, Failure> {
    distinct(&arguments.seeds).map_err(Failure::input)
}

/// One run after the other.
fn train_seeds(
    seeds: &[u64],
    arguments: &TrainArguments,
    interrupted: &Arc<AtomicBool>,
) -> Result<(), Failure> {
    let experiment = experiment(arguments)?;
    let within = arguments
        .out
        .clone()
        .unwrap_or_else(|| PathBuf::from("runs"));
    let folder = |seed: u64| within.join(format!("{}-{seed}", folder_name(&experiment.name)));
    // Better now than hours later.
    if let Some(taken) = seeds
        .iter()
        .map(|&seed| folder(seed))
        .find(|folder| !is_free(folder))
    {
        return Err(Failure::input(format!(
            "{} is there already; go on with it by `gaitshift train --resume {}` if it is not finished, and leave its seed \
             out of --seeds, or give another --out",
            taken.display(),
            quoted(&taken.to_string_lossy())
        )));
    }
    output::create_folder(&within)?;
    let mut outcomes: Vec<Outcome> = Vec::new();
    let mut failed = Vec::new();
    for &seed in seeds {
        let experiment = Experiment {
            seed,
            ..experiment.clone()
        };
        let begun = start(experiment, &folder(seed), arguments)
            .and_then(|training| train(folder(seed), training, arguments, interrupted));
        // What stops one seed, such as a learner that diverged, does not stop the next.
        match begun {
            Ok(outcome) => outcomes.push(outcome),
            Err(Failure::Run(cause) | Failure::Input(cause)) => {
                output::note(&format!("seed {seed} failed: {cause}"));
                failed.push(seed.to_string());
            }
            Err(failure) => return Err(failure),
        }
        if interrupted.load(Ordering::SeqCst) {
            break;
        }
    }
    let begun = outcomes.len() + failed.len();
    let left: Vec<String> = seeds[begun..].iter().map(u64::to_string).collect();
    if !left.is_empty() {
        output::note(&format!("not begun: the seeds {}", left.join(", ")));
    }
    if arguments.print.json {
        let runs = outcomes.iter().map(Outcome::report).collect();
        let spread = Spread::of(&outcomes);
        output::json(&Reports { runs, spread })?;
    } else {
        for line in seeds_table(&outcomes) {
            output::line(&line)?;
        }
    }
    if !failed.is_empty() {
        let seeds = failed.join(", ");
        return Err(Failure::run(format!(
            "of the seeds, {seeds} failed, see above"
        )));
    }
    match outcomes.last() {
        _ if !left.is_empty() => Err(Failure::Interrupted),
        Some(last) => ended(interrupted, &last.report),
        None => Ok(()),
    }
}

/// Whether a run can be begun in a folder: it is not there, or empty.
fn is_free(folder: &Path) -> bool {
    match std::fs::read_dir(folder) {
        Ok(mut inside) => inside.next().is_none(),
        Err(_) => !folder.exists(),
    }
}

/// What came of each seed, with mean and standard deviation.
fn seeds_table(outcomes: &[Outcome]) -> Vec<String> {
    let titles = ["seed", "criteria", "at step", "time", "run"];
    let mut cells = vec![titles.map(str::to_owned).to_vec()];
    for outcome in outcomes {
        let r = &outcome.report;
        let met = r.best_met.zip(r.criteria);
        let met = met.map_or("-".to_owned(), |(met, of)| format!("{met} of {of}"));
        let at = r.best_step.map_or("-".to_owned(), count);
        cells.push(vec![
            outcome.seed.to_string(),
            met,
            at,
            duration(r.elapsed_s),
            outcome.folder.display().to_string(),
        ]);
    }
    if outcomes.len() > 1 {
        let spread = Spread::of(outcomes);
        cells.push(vec![
            "mean".to_owned(),
            spread.best_met.text(1),
            spread.best_step.text(0),
            duration(spread.elapsed_s.mean.unwrap_or(0.0)),
        ]);
    }
    output::table(&cells, &[4])
}

/// Trains to the end, or until somebody stops it.
fn train(
    folder: PathBuf,
    mut training: Training,
    arguments: &TrainArguments,
    interrupted: &Arc<AtomicBool>,
) -> Result<Outcome, Failure> {
    output::note(&format!("training in {}", folder.display()));
    if arguments.view {
        view::beside_training(&folder)?;
    }
    let experiment = training.experiment();
    let seed = experiment.seed;
    for warning in experiment.warnings() {
        output::note(&format!("warning: {warning}"));
    }
    let step = training.step();
    let done = arguments.steps.filter(|&asked| asked <= step && step > 0);
    if let Some(asked) = done {
        output::note(&format!(
            "nothing to do: the run is at step {}, --steps asks for {}",
            count(step),
            count(asked)
        ));
    }
    let mut watcher = Watcher::new(Arc::clone(interrupted), step, arguments.steps);
    let report = training.run(&mut watcher).map_err(Failure::run)?;
    watcher.finish();
    if let Err(cause) = write_returns(&folder) {
        output::note(&format!("cannot draw the returns: {cause}"));
    }

    // The best controller stands there from the first evaluation on, the last one from a checkpoint on.
    let name = if report.best_step.is_some() {
        "controller.safetensors"
    } else {
        "controller-last.safetensors"
    };
    let controller = folder.join(name);
    if !report.finished && done.is_none() {
        output::note(&format!(
            "stopped with a checkpoint; resume with: gaitshift train --resume {}",
            quoted(&folder.to_string_lossy())
        ));
    }
    Ok(Outcome {
        folder,
        controller,
        seed,
        report,
    })
}

/// How the program ends after a run.
fn ended(interrupted: &AtomicBool, report: &RunReport) -> Result<(), Failure> {
    if interrupted.load(Ordering::SeqCst) && !report.finished {
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
    let experiment = experiment(arguments)?;
    let folder = arguments.out.clone().unwrap_or_else(|| {
        let name = format!("{}-{}", folder_name(&experiment.name), experiment.seed);
        Path::new("runs").join(name)
    });
    let training = start(experiment, &folder, arguments)?;
    Ok((folder, training))
}

/// The experiment as the user asks for it.
pub fn experiment(arguments: &TrainArguments) -> Result<Experiment, Failure> {
    let experiment = Experiment::load(&arguments.experiment).map_err(Failure::input)?;
    let mut experiment = experiment
        .with_values(&arguments.set)
        .map_err(Failure::input)?;
    if let Some(seed) = arguments.seed {
        experiment.seed = seed;
    }
    if let Some(threads) = arguments.threads {
        experiment.learner.threads = usize::from(threads);
    }
    experiment.training.stop_when_accepted |= arguments.stop_when_accepted;
    let seeds = seeds(arguments)?;
    let sets_seed = |set: &String| {
        set.split('=')
            .next()
            .is_some_and(|key| key.trim() == "seed")
    };
    if !(seeds.is_empty() && arguments.seed.is_none()) && arguments.set.iter().any(sets_seed) {
        return Err(Failure::input(
            "--set seed is also given by --seed or --seeds; give one of them",
        ));
    }
    let greatest = seeds.iter().copied().max().unwrap_or(experiment.seed);
    let seeded = Experiment {
        seed: greatest,
        ..experiment.clone()
    };
    seeded.validate("command line").map_err(Failure::input)?;
    Ok(experiment)
}

fn start(
    experiment: Experiment,
    folder: &Path,
    arguments: &TrainArguments,
) -> Result<Training, Failure> {
    Training::new(experiment, folder, &arguments.command).map_err(Failure::input)
}

/// The first Ctrl-C (or SIGTERM, or SIGHUP unless it is ignored) asks for an orderly end, as with a checkpoint, and is answered by `what`; the second ends
/// the program at once. SIGUSR1, with which a batch system warns of its time limit, asks for such an end however often it comes.
pub fn catch_interrupts(what: &'static str) -> Result<Arc<AtomicBool>, Failure> {
    let interrupted = Arc::new(AtomicBool::new(false));
    #[cfg(unix)]
    signal_hook::flag::register(signal_hook::consts::SIGUSR1, Arc::clone(&interrupted))
        .map_err(Failure::run)?;
    let asked = Arc::clone(&interrupted);
    let pressed = AtomicBool::new(false);
    on_signal(move || {
        asked.store(true, Ordering::SeqCst);
        if pressed.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
        output::note(&format!("{what}; press Ctrl-C again to stop at once"));
    })?;
    Ok(interrupted)
}

/// Calls `answer` at each of these signals, in a thread of its own.
#[cfg(unix)]
fn on_signal(answer: impl Fn() + Send + 'static) -> Result<(), Failure> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let mut asked_by = vec![SIGINT, SIGTERM];
    if !hangup_is_ignored() {
        asked_by.push(SIGHUP);
    }
    let mut signals = signal_hook::iterator::Signals::new(asked_by).map_err(Failure::run)?;
    std::thread::spawn(move || signals.forever().for_each(|_| answer()));
    Ok(())
}

#[cfg(not(unix))]
fn on_signal(answer: impl Fn() + Send + 'static) -> Result<(), Failure> {
    ctrlc::set_handler(answer).map_err(Failure::run)
}

/// Whether the program was begun so that it outlives its terminal, as by `nohup`. Where the system does not say, SIGHUP keeps
/// its effect, whatever that is.
#[cfg(unix)]
fn hangup_is_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_none_or(|mask| mask >> (signal_hook::consts::SIGHUP - 1) & 1 == 1)
}

/// A report in a few lines.
fn describe(r: &RunReport, controller: &Path) -> Result<(), Failure> {
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
            "{} simulations diverged or had an undefined reward or rule; these steps were not learned from",
            count(r.diverged)
        ));
    }
    if let (Some(step), Some(met), Some(of)) = (r.best_step, r.best_met, r.criteria) {
        lines.push(format!(
            "best evaluation at step {}: {met} of {of} criteria",
            count(step)
        ));
    }
    if let Some((step, after_s)) = r.accepted_at_step.zip(r.accepted_after_s) {
        lines.push(format!(
            "every criterion first met at step {}, after {}",
            count(step),
            duration(after_s)
        ));
    }
    lines.iter().try_for_each(|line| output::text(line, 2))?;
    // Paths and commands stay whole, to be copied.
    output::line(&format!("controller: {}", controller.display()))?;
    output::line(&format!(
        "look at it: gaitshift demo --controller {}",
        quoted(&controller.to_string_lossy())
    ))
}

/// Draws the return of every episode into the run's folder, in the manner of the paper's Fig. 4.
fn write_returns(folder: &Path) -> Result<(), String> {
    let episodes = Episodes::read(folder).map_err(|e| e.to_string())?;
    if episodes.steps.is_empty() {
        return Ok(());
    }
    episode_returns_figure(&episodes.steps, &episodes.returns, &episodes.omega_v)
        .and_then(|figure| figure.write(folder.join("returns")))
        .map(|_| ())
        .map_err(|e| e.to_string())
}
