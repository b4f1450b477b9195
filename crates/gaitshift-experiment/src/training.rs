//! The training loop: collect, learn, evaluate, checkpoint, and a folder that holds it all. Here stand the run and its
//! loop; how each of its jobs is done stands in the modules below.
//!
//! A run's folder holds `config.toml` (every value resolved), `metrics.csv` and TensorBoard events,
//! `episodes.csv`, `evaluations.jsonl`, `checkpoint/` (everything that is needed to go on to the same
//! bits), `controllers/` (one per evaluation), `controller.safetensors` (the best of them so far) and
//! `controller-last.safetensors`.

mod checkpointing;
mod collecting;
mod counting;
mod evaluating;

use crate::acceptance::Judgement;
use crate::config::{Experiment, Symmetry};
use crate::controller::Controller;
use crate::logs::{LogLengths, Logs};
use crate::rehearsal::best_walk;
use crate::run_folder::{REPORT, RunFolder};
use crate::training_error::TrainingError;
use collecting::Buffers;
use counting::{Counters, lap};
use gaitshift_body::Body;
use gaitshift_sac::{Agent, Mirror, ReplayBuffer, Temperature, UpdateStats};
use gaitshift_task::{
    ACTION_MIRROR, ACTION_SIZE, EnvironmentBatch, LearnerSettings, OBSERVATION_MIRROR,
    OBSERVATION_SIZE, PhaseSettings,
};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::path::Path;
use std::time::Instant;

pub use counting::{Parts, Progress};
pub(crate) use evaluating::{NONE_YET, Rank, rank};

/// Environment steps between two calls of [`Observer::progress`].
const REPORT_INTERVAL_STEPS: u64 = 2_000;
/// The best walk so far, kept to be rehearsed.
const WALK_FILE: &str = "controller-walk.safetensors";

/// Steps after which a task that has not yet given a single valid transition is taken to be at fault.
const PATIENCE: u64 = 10_000;

/// Is told how training goes, and may stop it.
pub trait Observer {
    /// Called every few thousand steps.
    fn progress(&mut self, progress: &Progress);
    /// Called after each evaluation; `best` if it is the best so far.
    fn evaluated(&mut self, progress: &Progress, judgement: &Judgement, best: bool);
    /// Called with what else a person should know, a sentence or two.
    fn note(&mut self, text: &str);
    /// Asked before every step of the batch; `true` checkpoints and stops.
    fn stop_requested(&self) -> bool;
}

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunReport {
    /// Whether all steps were taken, or the criteria met where that ends the run.
    pub finished: bool,
    /// Environment steps.
    pub step: u64,
    /// Updates.
    pub updates: u64,
    /// Wall-clock, in s.
    pub elapsed_s: f64,
    /// Step of the first evaluation that met every criterion, if any did.
    pub accepted_at_step: Option<u64>,
    /// Wall-clock of it, in s.
    pub accepted_after_s: Option<f64>,
    /// Step of the best evaluation; nothing, as for the next two, if there was none.
    pub best_step: Option<u64>,
    /// Number of criteria the best evaluation met.
    pub best_met: Option<usize>,
    /// Number of criteria.
    pub criteria: Option<usize>,
    /// Diverged simulations met and not learned from.
    pub diverged: u64,
    /// What the wall-clock went into.
    pub parts: Parts,
}

/// A training run.
#[derive(Debug)]
pub struct Training {
    experiment: Experiment,
    folder: RunFolder,
    /// Keeps other processes away.
    _lock: Option<File>,
    command: String,
    edits: Vec<String>,
    /// What `run` tells first.
    notes: Vec<String>,
    mirror: Mirror,
    agent: Agent,
    replay: ReplayBuffer,
    batch: EnvironmentBatch,
    counters: Counters,
    buffers: Buffers,
}

/// The mirror of this task, as the learner takes it.
pub fn task_mirror() -> Mirror {
    Mirror {
        observation: OBSERVATION_MIRROR.iter().map(|&i| (i, 1.0)).collect(),
        action: ACTION_MIRROR.iter().map(|&i| (i, 1.0)).collect(),
    }
}

/// The mirror by which the learner replaces half of every batch, where the experiment asks for that.
fn learner_mirror(experiment: &Experiment) -> Option<Mirror> {
    (experiment.training.symmetry == Symmetry::Replay).then(task_mirror)
}

/// The controller that the experiment names as its start, if it names one.
///
/// # Errors
/// One that cannot be read, or has other layers than the learner's.
pub fn starting_controller(experiment: &Experiment) -> Result<Option<Controller>, TrainingError> {
    let Some(start) = &experiment.training.warm_start else {
        return Ok(None);
    };
    let controller = Controller::read(Path::new(&start.controller))?;
    let (shape, learner) = (controller.policy.shape(), &experiment.learner);
    if shape.hidden != learner.actor_hidden {
        return Err(TrainingError::other(
            Path::new(&start.controller),
            format!(
                "cannot be the start of this training: it has the hidden layers {:?}, the learner {:?}; set \
                 `learner.actor_hidden` to its layers",
                shape.hidden, learner.actor_hidden
            ),
        ));
    }
    Ok(Some(controller))
}

impl Training {
    /// Prepares a run in a new folder. `command` is kept as the provenance of its controllers.
    ///
    /// # Errors
    /// A configuration out of range, or a folder that exists or cannot be written.
    pub fn new(
        experiment: Experiment,
        folder: &Path,
        command: &str,
    ) -> Result<Self, TrainingError> {
        let mut training = Self::prepare(experiment, RunFolder::at(folder), command)?;
        training.warm_start()?;
        training.folder.create()?;
        training._lock = training.folder.lock()?;
        // From here on a kill loses nothing that `resume` would need. Whatever else is written comes after the configuration, by
        // which a folder holds a run.
        training.write_checkpoint(LogLengths::new())?;
        training.folder.write_config(&training.configuration()?)?;
        training.write_last()?;
        // The clock of the run starts with `run`.
        training.counters.parts = Parts::default();
        Ok(training)
    }

    /// Begins with the controller that the experiment names, if any.
    fn warm_start(&mut self) -> Result<(), TrainingError> {
        match starting_controller(&self.experiment)? {
            Some(controller) => Ok(self.agent.start_from(&controller.policy)?),
            None => Ok(()),
        }
    }

    fn prepare(
        experiment: Experiment,
        folder: RunFolder,
        command: &str,
    ) -> Result<Self, TrainingError> {
        experiment.validate(&folder.path().display().to_string())?;
        let e = &experiment;
        let body = Body::new(e.body.clone())
            .map_err(|e| TrainingError::other(folder.path(), e.to_string()))?;
        let agent = Agent::new(
            e.learner.clone(),
            OBSERVATION_SIZE,
            ACTION_SIZE,
            learner_mirror(e),
            e.seed,
        )?;
        if e.curriculum.rehearsal_start().is_some() {
            agent.require_rehearsal_rows(e.training.rehearsal.rows)?;
        }
        let count = e.training.environments;
        let replay = ReplayBuffer::new(
            e.training.replay_capacity,
            count,
            OBSERVATION_SIZE,
            ACTION_SIZE,
        )?;
        let settings = e.curriculum.at(0, &e.task.reward);
        // The environments' stream of random numbers must not repeat the learner's.
        let seed = e.seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x6761_6974;
        let batch = EnvironmentBatch::new(body, e.task.clone(), count, seed, &settings);
        Ok(Self {
            counters: Counters {
                next_evaluation: e.training.evaluation_interval_steps,
                next_checkpoint: e.training.checkpoint_interval_steps,
                next_metrics: e.training.metrics_interval_steps,
                best_rank: NONE_YET,
                verdict: "not evaluated yet".to_owned(),
                ..Counters::default()
            },
            buffers: Buffers::new(count),
            mirror: task_mirror(),
            agent,
            replay,
            batch,
            folder,
            _lock: None,
            command: command.to_owned(),
            edits: Vec::new(),
            notes: Vec::new(),
            experiment,
        })
    }

    /// The configuration.
    pub fn experiment(&self) -> &Experiment {
        &self.experiment
    }

    /// Uses another number of threads than the configuration says; the results stay the same.
    ///
    /// # Errors
    /// When it is not from 1 to 256.
    pub fn set_threads(&mut self, threads: usize) -> Result<(), TrainingError> {
        Ok(self.agent.set_threads(threads)?)
    }

    /// Environment steps taken so far.
    pub fn step(&self) -> u64 {
        self.counters.step
    }

    /// Takes the remaining steps.
    ///
    /// # Errors
    /// The folder cannot be written, or the learner's numbers stopped being finite.
    pub fn run(&mut self, observer: &mut dyn Observer) -> Result<RunReport, TrainingError> {
        let clock = Instant::now();
        let before_s = self.counters.elapsed_s;
        let elapsed_s = || before_s + clock.elapsed().as_secs_f64();
        for note in self.notes.drain(..) {
            observer.note(&note);
        }
        if self.is_finished() {
            let total = self.experiment.curriculum.total_steps();
            observer.note(if self.counters.step < total {
                "the run met every criterion and ended there: nothing is left to do"
            } else {
                "the run has taken all its steps: nothing is left to do; more `steps` for its last phase in its config.toml would \
                 go on with it"
            });
            // It says more than a checkpoint does.
            if let Some(report) = self.report_of_the_end() {
                return Ok(report);
            }
        }
        self.folder.remove_report()?;
        let mut logs = self
            .folder
            .open_logs(&counting::metrics_names(&self.experiment))?;
        self.advance(observer, &mut logs, &elapsed_s)?;
        self.checkpoint(logs.sync()?)?;
        self.counters.elapsed_s = elapsed_s();
        observer.progress(&self.progress());
        let report = self.report();
        self.folder.write_json(&self.folder.file(REPORT), &report)?;
        Ok(report)
    }

    /// Takes steps in a scratch folder until the observer stops it, without a checkpoint before or after them.
    pub(crate) fn try_out(
        experiment: Experiment,
        folder: &Path,
        observer: &mut dyn Observer,
    ) -> Result<(), TrainingError> {
        let mut training = Self::prepare(experiment, RunFolder::at(folder), "")?;
        training.warm_start()?;
        training.folder.create()?;
        let names = counting::metrics_names(&training.experiment);
        let mut logs = training.folder.open_logs(&names)?;
        let clock = Instant::now();
        training.advance(observer, &mut logs, &|| clock.elapsed().as_secs_f64())
    }

    /// Takes steps to the end, or until the observer stops them.
    fn advance(
        &mut self,
        observer: &mut dyn Observer,
        logs: &mut Logs,
        elapsed_s: &dyn Fn() -> f64,
    ) -> Result<(), TrainingError> {
        let mut next_report = self.counters.step;
        while !self.is_finished() && !observer.stop_requested() {
            let (step, e) = (self.counters.step, &self.experiment);
            let settings = e.curriculum.at(step, &e.task.reward);
            let learner = e.learner_at(step);
            self.apply(&learner)?;
            self.begin_rehearsal_if_due(&learner, &settings, observer)?;

            self.collect(&settings, &mut logs.episodes)?;
            self.learn()?;

            let t = &self.experiment.training;
            let intervals = (
                t.metrics_interval_steps,
                t.evaluation_interval_steps,
                t.checkpoint_interval_steps,
            );
            let c = &mut self.counters;
            c.elapsed_s = elapsed_s();
            if Counters::due(c.step, &mut c.next_metrics, intervals.0) {
                logs.metrics(&self.metrics_row(&settings))?;
            }
            let c = &mut self.counters;
            if Counters::due(c.step, &mut c.next_evaluation, intervals.1) {
                self.evaluate(observer, logs)?;
                self.counters.elapsed_s = elapsed_s();
            }
            let c = &mut self.counters;
            if Counters::due(c.step, &mut c.next_checkpoint, intervals.2) {
                self.checkpoint(logs.sync()?)?;
            }
            if self.counters.step >= next_report {
                next_report = self.counters.step + REPORT_INTERVAL_STEPS;
                observer.progress(&self.progress());
            }
        }
        Ok(())
    }

    /// Whether all steps are taken, or the criteria met where that ends the run.
    fn is_finished(&self) -> bool {
        let e = &self.experiment;
        let accepted = self.counters.accepted_at_step.is_some();
        self.counters.step >= e.curriculum.total_steps()
            || (accepted && e.training.stop_when_accepted)
    }

    /// The report that the run wrote when it had taken these steps, if it did; another is that of an earlier part.
    fn report_of_the_end(&self) -> Option<RunReport> {
        let text = std::fs::read_to_string(self.folder.file(REPORT)).ok()?;
        let report: RunReport = serde_json::from_str(&text).ok()?;
        (report.finished && report.step == self.counters.step).then_some(report)
    }

    fn report(&self) -> RunReport {
        let c = &self.counters;
        let evaluated = c.best_step > 0;
        RunReport {
            finished: self.is_finished(),
            step: c.step,
            updates: c.updates,
            elapsed_s: c.elapsed_s,
            accepted_at_step: c.accepted_at_step,
            accepted_after_s: c.accepted_after_s,
            best_step: evaluated.then_some(c.best_step),
            best_met: evaluated.then_some(c.best_met),
            criteria: evaluated.then_some(c.criteria),
            diverged: c.diverged,
            parts: c.parts,
        }
    }

    /// Remembers the best walk, when its time has come.
    fn begin_rehearsal_if_due(
        &mut self,
        learner: &LearnerSettings,
        settings: &PhaseSettings,
        observer: &mut dyn Observer,
    ) -> Result<(), TrainingError> {
        if learner.rehearsal > 0.0 && !self.counters.rehearsal_begun {
            self.counters.rehearsal_begun = true;
            observer.note(&self.begin_rehearsal(settings)?);
        }
        Ok(())
    }

    /// From here on the best walk so far is rehearsed.
    fn begin_rehearsal(&mut self, settings: &PhaseSettings) -> Result<String, TrainingError> {
        let file = self.folder.file(WALK_FILE);
        let walk = if file.exists() {
            Controller::read(&file)?
        } else {
            self.controller()
        };
        let (step, mut policy) = (walk.provenance.environment_steps, walk.policy);
        let (body, e) = (self.batch.body(), &self.experiment);
        let (score, told) = best_walk(&mut policy, body, &e.task, &e.criteria)
            .map_err(|e| TrainingError::other(self.folder.path(), e.to_string()))?;
        let rehearsal =
            e.training
                .rehearsal
                .collect(&mut policy, body, &e.task, settings, told, e.seed)?;
        let Some(rehearsal) = rehearsal else {
            return Ok(format!(
                "no walk to rehearse: the best so far, of step {step}, always falls at once"
            ));
        };
        let states = rehearsal.rows();
        self.agent.rehearse(rehearsal, e.training.rehearsal.rows)?;
        Ok(format!(
            "rehearsing the walk of step {step} from here on: {states} states, as it is at ω_v = {told:.4}, \
             score {score:.2}"
        ))
    }

    /// Moves the learner to the settings of this step.
    fn apply(&mut self, settings: &LearnerSettings) -> Result<(), TrainingError> {
        let e = &self.experiment;
        let warm_start = &e.training.warm_start;
        let held = warm_start
            .as_ref()
            .is_some_and(|start| self.counters.step < start.critic_steps);
        self.agent.hold_actor(held);
        // Where no phase has a horizon, γ keeps the bits that it was given.
        let own = e.own_learner_settings();
        let gamma = if settings.horizon == own.horizon {
            e.learner.gamma
        } else {
            1.0 - 1.0 / settings.horizon
        };
        let fixed = matches!(e.learner.temperature, Temperature::Fixed { .. });
        let agent = &mut self.agent;
        if agent.config().learning_rate != settings.learning_rate {
            agent.set_learning_rate(settings.learning_rate)?;
        }
        if agent.config().gamma != gamma {
            agent.set_gamma(gamma)?;
        }
        if fixed && agent.alpha() != settings.alpha {
            agent.set_alpha(settings.alpha)?;
        }
        if agent.rehearsal_weight() != settings.rehearsal {
            agent.set_rehearsal_weight(settings.rehearsal)?;
        }
        Ok(())
    }

    /// As many updates as the steps since the last ones have earned.
    fn learn(&mut self) -> Result<(), TrainingError> {
        let t = &self.experiment.training;
        // A task may be undefined for the first steps; where nothing comes for long, the update says so.
        let nothing_yet = self.replay.valid_len() == 0
            && self.counters.step < t.learning_starts.saturating_add(PATIENCE);
        if self.counters.step < t.learning_starts || nothing_yet {
            self.counters.update_credit = 0;
            return Ok(());
        }
        let mut from = Instant::now();
        self.counters.update_credit += self.batch.len() as u64;
        while self.counters.update_credit >= t.steps_per_update {
            self.counters.update_credit -= t.steps_per_update;
            let stats: UpdateStats = self.agent.update(&self.replay)?;
            self.counters.updates += 1;
            let recent = &mut self.counters.recent;
            recent.updates += 1;
            recent.critic_loss += 0.5 * (stats.critic_loss[0] + stats.critic_loss[1]);
            recent.actor_loss += stats.actor_loss;
            recent.mean_q += stats.mean_q;
            recent.entropy += stats.entropy;
            recent.rehearsal_loss += stats.rehearsal_loss;
        }
        lap(&mut from, &mut self.counters.parts.learning_s);
        Ok(())
    }
}
