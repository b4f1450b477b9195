//! Training runs, without the interpreter's lock.

use crate::batch::recording_metadata;
use crate::convert::{to_python, value_error, warn};
use gaitshift_analysis::{AnalysisOptions, Recording, summarise};
use gaitshift_body::{Body, BodyParameters};
use gaitshift_experiment::{
    Experiment, Judgement, Observer, Progress, SteadyMotion, Sweep, Training, TrainingError,
    TrialSettings, begin_trial, folder_name, portable_command, sweep_command,
};
use gaitshift_task::TaskParameters;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Between two looks for Ctrl-C, for which the interpreter's lock is needed.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(100);

/// See `_native.pyi`.
#[pyfunction]
#[pyo3(signature = (experiment, callback, *, set, seed, out, threads, steps, stop_when_accepted))]
#[allow(clippy::too_many_arguments)]
pub fn train(
    py: Python<'_>,
    experiment: &str,
    callback: Py<PyAny>,
    set: Vec<String>,
    seed: Option<u64>,
    out: Option<PathBuf>,
    threads: Option<usize>,
    steps: Option<u64>,
    stop_when_accepted: bool,
) -> PyResult<PathBuf> {
    let loaded = Experiment::load(experiment).map_err(value_error)?;
    let mut resolved = loaded.with_values(&set).map_err(value_error)?;
    warn(py, &resolved.warnings(), 2)?;
    // What the program would be told: it makes the same controller.
    let mut words = vec!["train".to_owned(), experiment.to_owned()];
    for assignment in set {
        words.extend(["--set".to_owned(), assignment]);
    }
    if let Some(seed) = seed {
        resolved.seed = seed;
        words.extend(["--seed".to_owned(), seed.to_string()]);
    }
    if let Some(threads) = threads {
        resolved.learner.threads = threads;
        words.extend(["--threads".to_owned(), threads.to_string()]);
    }
    if stop_when_accepted {
        resolved.training.stop_when_accepted = true;
        words.push("--stop-when-accepted".to_owned());
    }
    let folder = out.unwrap_or_else(|| {
        let name = format!("{}-{}", folder_name(&resolved.name), resolved.seed);
        Path::new("runs").join(name)
    });
    let command = portable_command(words.into_iter().map(Into::into));
    let begin = || Training::new(resolved, &folder, &command);
    run(py, begin, Caller::new(callback, steps))?;
    Ok(folder)
}

/// See `_native.pyi`.
#[pyfunction]
#[pyo3(signature = (folder, callback, *, threads, steps))]
pub fn resume(
    py: Python<'_>,
    folder: PathBuf,
    callback: Py<PyAny>,
    threads: Option<usize>,
    steps: Option<u64>,
) -> PyResult<()> {
    let begin = || {
        let mut training = Training::resume(&folder)?;
        if let Some(threads) = threads {
            training.set_threads(threads)?;
        }
        Ok(training)
    };
    run(py, begin, Caller::new(callback, steps))
}

/// See `_native.pyi`.
#[pyfunction]
pub fn train_trial(
    py: Python<'_>,
    config: &str,
    command: &str,
    settings: &str,
    out: PathBuf,
    callback: Py<PyAny>,
) -> PyResult<()> {
    let experiment = Experiment::parse(config, "the trial's configuration").map_err(value_error)?;
    let settings: TrialSettings = serde_json::from_str(settings).map_err(value_error)?;
    let begin = || begin_trial(experiment, &out, command, &settings);
    run(py, begin, Caller::new(callback, None))
}

/// See `_native.pyi`.
#[pyfunction]
pub fn sweep_trials(py: Python<'_>, file: PathBuf) -> PyResult<Bound<'_, PyAny>> {
    let sweep = Sweep::load(&file).map_err(value_error)?;
    let mut trials = Vec::new();
    for trial in &sweep.trials {
        let config = trial.experiment.to_toml().map_err(value_error)?;
        let settings = serde_json::to_string(&sweep.settings(trial)).map_err(value_error)?;
        trials.push(serde_json::json!({
            "folder": trial.folder,
            "config": config,
            "settings": settings,
            "threads": trial.experiment.learner.threads,
        }));
    }
    let told = serde_json::json!({
        "name": sweep.name,
        "folder": folder_name(&sweep.name),
        "command": sweep_command(&file),
        "trials": trials,
    });
    to_python(py, &told)
}

/// See `_native.pyi`.
#[pyfunction]
pub fn sweep_table(file: PathBuf, folder: PathBuf) -> PyResult<(String, String)> {
    let sweep = Sweep::load(&file).map_err(value_error)?;
    let table = sweep.table(&folder).map_err(value_error)?;
    let json = serde_json::to_string_pretty(&table).map_err(value_error)?;
    Ok((table.to_markdown(), json))
}

/// See `_native.pyi`.
#[pyfunction]
pub fn run_config(py: Python<'_>, folder: PathBuf) -> PyResult<Bound<'_, PyAny>> {
    let experiment = Experiment::read(&folder.join("config.toml")).map_err(value_error)?;
    to_python(py, &experiment)
}

/// See `_native.pyi`.
#[pyfunction]
pub fn motion_names(py: Python<'_>) -> PyResult<Vec<String>> {
    let body = Body::new(BodyParameters::default()).map_err(value_error)?;
    let metadata = recording_metadata(&body, &TaskParameters::default(), "");
    let summary = summarise(&Recording::new(metadata), &AnalysisOptions::default());
    let motion = SteadyMotion {
        omega_v: 0.0,
        asked: None,
        summary,
    };
    to_python(py, &motion)?
        .try_iter()?
        .map(|name| name?.extract())
        .collect()
}

fn run(
    py: Python<'_>,
    begin: impl FnOnce() -> Result<Training, TrainingError> + Send,
    mut caller: Caller,
) -> PyResult<()> {
    py.detach(|| {
        let mut training = begin().map_err(value_error)?;
        let outcome = training.run(&mut caller);
        // What stopped the run says more than what may have failed since.
        match caller.stop.into_inner().error {
            Some(error) => Err(error),
            None => outcome
                .map(|_| ())
                .map_err(|e| PyRuntimeError::new_err(e.to_string())),
        }
    })
}

/// Tells a Python function how training goes. The run stops with a checkpoint when the function returns what counts as
/// false, but for None, or raises, on Ctrl-C, and at a step that was given.
struct Caller {
    callback: Py<PyAny>,
    stop_at_step: Option<u64>,
    step: u64,
    stop: RefCell<Stop>,
}

struct Stop {
    requested: bool,
    error: Option<PyErr>,
    next_look: Instant,
}

impl Caller {
    fn new(callback: Py<PyAny>, stop_at_step: Option<u64>) -> Self {
        Self {
            callback,
            stop_at_step,
            step: 0,
            stop: RefCell::new(Stop {
                requested: false,
                error: None,
                next_look: Instant::now(),
            }),
        }
    }

    fn call<'py>(
        &self,
        py: Python<'py>,
        what: &str,
        value: Bound<'py, PyAny>,
        evaluation: Option<Bound<'py, PyDict>>,
    ) -> PyResult<()> {
        let answer = self.callback.call1(py, (what, value, evaluation))?;
        // NumPy's False is not Python's; None is what a function without `return` gives.
        let no = !answer.is_none(py) && !answer.is_truthy(py)?;
        self.stop.borrow_mut().requested |= no;
        Ok(())
    }

    fn tell(&self, what: &str, progress: &Progress, evaluation: Option<(&Judgement, bool)>) {
        // One that failed is not called again.
        if self.stop.borrow().error.is_some() {
            return;
        }
        let told = Python::attach(|py| {
            let evaluation = evaluation.map(|(judgement, best)| {
                let dict = PyDict::new(py);
                dict.set_item("met", judgement.met())?;
                dict.set_item("criteria", judgement.checks.len())?;
                dict.set_item("score", judgement.score())?;
                dict.set_item("accepted", judgement.accepted())?;
                dict.set_item("best", best)?;
                PyResult::Ok(dict)
            });
            self.call(py, what, to_python(py, progress)?, evaluation.transpose()?)
        });
        self.keep(told);
    }

    fn keep(&self, outcome: PyResult<()>) {
        if let Err(error) = outcome {
            self.stop.borrow_mut().error.get_or_insert(error);
        }
    }
}

impl Observer for Caller {
    fn progress(&mut self, progress: &Progress) {
        self.step = progress.step;
        self.tell("progress", progress, None);
    }

    fn evaluated(&mut self, progress: &Progress, judgement: &Judgement, best: bool) {
        self.tell("evaluation", progress, Some((judgement, best)));
    }

    fn note(&mut self, text: &str) {
        let told = Python::attach(|py| {
            let text = text.into_pyobject(py)?.into_any();
            self.call(py, "note", text, None)
        });
        self.keep(told);
    }

    fn stop_requested(&self) -> bool {
        let now = Instant::now();
        if now >= self.stop.borrow().next_look {
            self.stop.borrow_mut().next_look = now + SIGNAL_INTERVAL;
            self.keep(Python::attach(|py| py.check_signals()));
        }
        let stop = self.stop.borrow();
        stop.requested
            || stop.error.is_some()
            || self.stop_at_step.is_some_and(|step| self.step >= step)
    }
}
