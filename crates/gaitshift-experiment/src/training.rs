//! The training loop: collect, learn, evaluate, checkpoint, and a folder that holds it all.
//!
//! A run's folder holds `config.toml` (every value resolved), `metrics.csv` and TensorBoard events,
//! `episodes.csv`, `evaluations.jsonl`, `checkpoint/` (everything that is needed to go on to the same
//! bits), `controllers/` (one per evaluation), `controller.safetensors` (the best of them so far) and
//! `controller-last.safetensors`.

use crate::acceptance::{Criteria, Judgement, judge};
use crate::config::{Experiment, Symmetry};
use crate::controller::{Controller, Deterministic};
use crate::durable;
use crate::edits::{Edit, edits, is_decided};
use crate::provenance::Provenance;
use crate::rehearsal::best_walk;
use crate::run_folder::{LogLengths, Logs, RunFolder, STATE, TextLog, TrainingError};
use crate::schedule::Course;
use gaitshift_body::Body;
use gaitshift_sac::{
    Agent, Mirror, Policy, ReplayBuffer, SacConfig, Temperature, Transitions, UpdateStats, reflect,
};
use gaitshift_task::{
    ACTION_MIRROR, ACTION_SIZE, BatchState, EndReason, EnvironmentBatch, FinishedEpisode,
    OBSERVATION_MIRROR, OBSERVATION_SIZE, PhaseSettings, RewardTerms, StepOutcome,
    scale_observation,
};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::time::Instant;

/// The best walk so far, kept to be rehearsed.
const WALK_FILE: &str = "controller-walk.safetensors";

/// What a person wants to know while training runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Progress {
    /// Environment steps so far.
    pub step: u64,
    /// Environment steps in all.
    pub total_steps: u64,
    /// Updates of the learner so far.
    pub updates: u64,
    /// Wall-clock so far, resumed runs counted together, in s.
    pub elapsed_s: f64,
    /// Name of the phase of the curriculum.
    pub phase: String,
    /// Mean reward (2) per episode over the last episodes.
    pub mean_return: f64,
    /// Share of the last episodes that ended in a fall.
    pub fall_share: f64,
    /// Short verdict of the last evaluation, e.g. `walks at 0, runs at 3, 31/39 criteria`.
    pub verdict: String,
}

/// Is told how training goes, and may stop it.
pub trait Observer {
    /// Called every few thousand steps.
    fn progress(&mut self, progress: &Progress);
    /// Called after each evaluation; `best` if it is the best so far.
    fn evaluated(&mut self, progress: &Progress, judgement: &Judgement, best: bool);
    /// Called with what else a person should know, a sentence or two.
    fn note(&mut self, text: &str);
    /// Asked after every step of the batch; `true` checkpoints and stops.
    fn stop_requested(&self) -> bool;
}

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
    /// Step of the best evaluation.
    pub best_step: u64,
    /// Number of criteria the best evaluation met.
    pub best_met: usize,
    /// Number of criteria.
    pub criteria: usize,
    /// Diverged simulations met and not learned from.
    pub diverged: u64,
    /// What the wall-clock went into.
    pub parts: Parts,
}

/// Wall-clock of the parts of a run, in s. What is missing to the whole is the bookkeeping between them.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parts {
    /// Actions of the policy, and those that f_sym (7) compares.
    pub acting_s: f64,
    /// Steps of the environments, reward and logs of episodes included.
    pub simulating_s: f64,
    /// Into the replay buffer.
    pub storing_s: f64,
    /// Updates of the networks, drawing their batches included.
    pub learning_s: f64,
    /// Evaluations, and the files they write.
    pub evaluating_s: f64,
    /// Checkpoints.
    pub checkpointing_s: f64,
}

impl Parts {
    /// Name and seconds of each part.
    pub fn named(&self) -> [(&'static str, f64); 6] {
        [
            ("acting", self.acting_s),
            ("simulating", self.simulating_s),
            ("storing", self.storing_s),
            ("learning", self.learning_s),
            ("evaluating", self.evaluating_s),
            ("checkpointing", self.checkpointing_s),
        ]
    }
}

/// Moves `next` on by whole intervals until it lies after `step`.
fn after(next: &mut u64, step: u64, interval: u64) {
    *next += interval * (1 + step.saturating_sub(*next) / interval);
}

/// Adds the time since `*from` to `part` and begins anew.
fn lap(from: &mut Instant, part: &mut f64) {
    let now = Instant::now();
    *part += (now - *from).as_secs_f64();
    *from = now;
}

/// Counters that a checkpoint keeps besides agent, replay and environments.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
struct Counters {
    step: u64,
    updates: u64,
    update_credit: u64,
    elapsed_s: f64,
    next_evaluation: u64,
    next_checkpoint: u64,
    next_metrics: u64,
    best_score: f64,
    best_step: u64,
    best_met: usize,
    /// Of the best walk so far, which is kept where the walk is going to be rehearsed.
    walking_score: f64,
    /// Steps of the latest evaluations, whose controllers' mean the next one tries.
    latest_evaluations: Vec<u64>,
    /// Whether the time to remember the walk has come.
    rehearsal_begun: bool,
    criteria: usize,
    accepted_at_step: Option<u64>,
    accepted_after_s: Option<f64>,
    diverged: u64,
    verdict: String,
    recent: Recent,
    parts: Parts,
}

impl Counters {
    /// Whether a run of this configuration can have counted so.
    fn are_possible(&self, experiment: &Experiment) -> bool {
        let t = &experiment.training;
        let environments = t.environments as u64;
        self.step <= experiment.curriculum.total_steps() + environments
            && self.updates <= self.step
            && self.update_credit < t.steps_per_update + environments
            && self.recent.steps <= self.step
            && self.recent.updates <= self.updates
            && self.recent.episodes.len() <= 100
            && self.diverged <= self.step
    }
}

/// Sums since the last row of metrics, and the latest episodes.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
struct Recent {
    steps: u64,
    terms: [f64; RewardTerms::NAMES.len()],
    updates: u64,
    critic_loss: f64,
    actor_loss: f64,
    mean_q: f64,
    entropy: f64,
    rehearsal_loss: f64,
    /// Return and whether it fell, of up to 100 episodes.
    episodes: std::collections::VecDeque<(f64, bool)>,
}

/// Version of [`CheckpointState`].
const FORMAT: &str = "gaitshift-run 1";

/// The part of a state that is read before the rest.
#[derive(Deserialize)]
struct Version {
    #[serde(default)]
    format: String,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CheckpointState {
    format: String,
    /// The command that began the run, the provenance of its controllers.
    command: String,
    /// Edits of the configuration since then, for the provenance too.
    edits: Vec<String>,
    logs: LogLengths,
    counters: Counters,
    batch: BatchState,
}

/// A training run.
#[derive(Debug)]
pub struct Training {
    experiment: Experiment,
    folder: RunFolder,
    command: String,
    edits: Vec<String>,
    /// What `run` tells first.
    notes: Vec<String>,
    criteria: Criteria,
    mirror: Mirror,
    agent: Agent,
    replay: ReplayBuffer,
    batch: EnvironmentBatch,
    counters: Counters,
    buffers: Buffers,
}

/// One step of all environments, stream after stream.
#[derive(Debug, Default)]
struct Buffers {
    observations: Vec<f32>,
    next_observations: Vec<f32>,
    mirrored: Vec<f32>,
    actions: Vec<f32>,
    means: Vec<f32>,
    mirrored_means: Vec<f32>,
    log_probs: Vec<f32>,
    rewards: Vec<f32>,
    entropy_scales: Vec<f32>,
    horizon_scales: Vec<f32>,
    symmetry: Vec<f64>,
    /// ω_v under which the step is taken.
    commands: Vec<f64>,
    outcomes: Vec<Option<(StepOutcome, Option<FinishedEpisode>)>>,
    terminated: Vec<bool>,
    truncated: Vec<bool>,
    valid: Vec<bool>,
}

impl Buffers {
    fn new(count: usize) -> Self {
        let observations = vec![0.0; count * OBSERVATION_SIZE];
        let actions = vec![0.0; count * ACTION_SIZE];
        Self {
            next_observations: observations.clone(),
            mirrored: observations.clone(),
            observations,
            means: actions.clone(),
            mirrored_means: actions.clone(),
            actions,
            log_probs: vec![0.0; count],
            rewards: vec![0.0; count],
            entropy_scales: vec![0.0; count],
            horizon_scales: vec![1.0; count],
            symmetry: vec![0.0; count],
            commands: vec![0.0; count],
            outcomes: vec![None; count],
            terminated: vec![false; count],
            truncated: vec![false; count],
            valid: vec![true; count],
        }
    }
}

/// The mirror of this task, as the learner takes it.
pub fn task_mirror() -> Mirror {
    Mirror {
        observation: OBSERVATION_MIRROR.iter().map(|&i| (i, 1.0)).collect(),
        action: ACTION_MIRROR.iter().map(|&i| (i, 1.0)).collect(),
    }
}

/// Whether two agents have the same networks; schedules move the rest of their settings.
fn same_network(a: &Agent, b: &Agent) -> bool {
    let shape = |agent: &Agent| {
        let c = agent.config();
        let hidden = (c.actor_hidden.clone(), c.critic_hidden.clone());
        (
            hidden,
            c.actor_layer_norm,
            c.critic_layer_norm,
            c.n_step,
            c.batch_size,
        )
    };
    shape(a) == shape(b)
}

/// What follows for the learner, apart from its threads, which change nothing.
fn learner_settings(experiment: &Experiment) -> SacConfig {
    SacConfig {
        threads: 1,
        ..learner_config(experiment)
    }
}

fn learner_config(experiment: &Experiment) -> SacConfig {
    let mut config = experiment.learner.clone();
    match experiment.training.symmetry {
        Symmetry::None | Symmetry::Reward => {}
        Symmetry::Loss => config.mirror_loss_weight = experiment.task.reward.omega_s,
        Symmetry::Replay => config.mirrored_fraction = 0.5,
    }
    let rehearsal = &experiment.training.rehearsal;
    if rehearsal.enabled() {
        config.rehearsal_weight = rehearsal.weight;
        config.rehearsal_rows = rehearsal.rows;
    }
    config
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
        training.folder.create()?;
        // From here on a kill loses nothing that `resume` would need.
        training.checkpoint(LogLengths::new())?;
        training.folder.write_config(&training.configuration()?)?;
        Ok(training)
    }

    /// Goes on with a run from the last checkpoint in its folder. What was edited in its `config.toml` since is applied
    /// from there on, and told by [`Training::run`].
    ///
    /// # Errors
    /// No run or no checkpoint there, one that is damaged or of another version, or an edit of what the checkpoint
    /// decides: the learner, the seed, the body, the control period, the number of environments and the size of the
    /// replay buffer.
    pub fn resume(folder: &Path) -> Result<Self, TrainingError> {
        let folder = RunFolder::at(folder);
        let experiment = folder.read_config()?;
        folder.recover_checkpoint()?;
        let before = Experiment::read(&folder.checkpoint("config.toml"))?;
        let path = folder.checkpoint(STATE);
        let state = read_state(&path)?;
        if !state.counters.are_possible(&before) {
            return Err(TrainingError::other(
                &path,
                "the checkpoint is damaged: its counters contradict each other".to_owned(),
            ));
        }
        let edits = edits(&before, &experiment)?;
        let learner_differs = learner_settings(&before) != learner_settings(&experiment);
        let rehearsing = state.counters.rehearsal_begun;
        let refused = |edit: &&Edit| is_decided(&edit.key, learner_differs, rehearsing);
        if let Some(edit) = edits.iter().find(refused) {
            return Err(TrainingError::other(
                &folder.file("config.toml"),
                format!(
                    "changes {edit} since the checkpoint at step {}, which decides it; set it back to go on, or begin a \
                     new run with the edited file",
                    state.counters.step
                ),
            ));
        }
        let mut training = Self::prepare(experiment, folder, &state.command)?;
        let folder = &training.folder;
        let agent = Agent::load(&folder.checkpoint("agent.safetensors"))?;
        let replay = ReplayBuffer::load(&folder.checkpoint("replay.safetensors"))?;
        let sizes = |r: &ReplayBuffer| {
            (
                r.capacity(),
                r.environments(),
                r.observation_size(),
                r.action_size(),
            )
        };
        if !same_network(&agent, &training.agent) || sizes(&replay) != sizes(&training.replay) {
            return Err(TrainingError::other(
                folder.path(),
                "its checkpoint is of another configuration than its config.toml".to_owned(),
            ));
        }
        training.agent = agent;
        let e = &training.experiment;
        training.agent.set_threads(e.learner.threads)?;
        // What a schedule moved goes back to where it was, should the schedule be no more.
        let (was, is) = (&before.training.schedule, &e.training.schedule);
        let gone = |was: &Course, is: &Course| !was.0.is_empty() && is.0.is_empty();
        if gone(&was.learning_rate, &is.learning_rate) {
            training.agent.set_learning_rate(e.learner.learning_rate)?;
        }
        if gone(&was.horizon, &is.horizon) {
            training.agent.set_gamma(e.learner.gamma)?;
        }
        if let (true, Temperature::Fixed { alpha }) =
            (gone(&was.alpha, &is.alpha), e.learner.temperature)
        {
            training.agent.set_alpha(alpha)?;
        }
        training.replay = replay;
        if !training.batch.restore(state.batch) {
            return Err(TrainingError::other(
                &path,
                "its environments are not those of config.toml".to_owned(),
            ));
        }
        training.counters = state.counters;
        training.edits = state.edits;
        if !edits.is_empty() {
            let list: Vec<String> = edits.iter().map(Edit::to_string).collect();
            let step = training.counters.step;
            let list = list.join(", ");
            training.notes.push(format!(
                "edited in config.toml, in force from step {step} on: {list}"
            ));
            training.edits.push(format!("at step {step}: {list}"));
        }
        // A shorter interval begins to count at once.
        let (c, t) = (&mut training.counters, &training.experiment.training);
        for (next, interval) in [
            (&mut c.next_evaluation, t.evaluation_interval_steps),
            (&mut c.next_checkpoint, t.checkpoint_interval_steps),
            (&mut c.next_metrics, t.metrics_interval_steps),
        ] {
            *next = (*next).min(c.step.saturating_add(interval));
        }
        training.folder.cut_logs(&state.logs)?;
        Ok(training)
    }

    /// The configuration as a text, every value written out.
    fn configuration(&self) -> Result<String, TrainingError> {
        let text = self.experiment.to_toml();
        text.map_err(|e| TrainingError::other(self.folder.path(), e.to_string()))
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
            learner_config(e),
            OBSERVATION_SIZE,
            ACTION_SIZE,
            Some(task_mirror()),
            e.seed,
        )?;
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
                best_score: -1.0,
                verdict: "not evaluated yet".to_owned(),
                ..Counters::default()
            },
            buffers: Buffers::new(count),
            criteria: Criteria::default(),
            mirror: task_mirror(),
            agent,
            replay,
            batch,
            folder,
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

    /// Takes the remaining steps.
    ///
    /// # Errors
    /// The folder cannot be written, or the learner's numbers stopped being finite.
    pub fn run(&mut self, observer: &mut dyn Observer) -> Result<RunReport, TrainingError> {
        let clock = Instant::now();
        let before_s = self.counters.elapsed_s;
        for note in self.notes.drain(..) {
            observer.note(&note);
        }
        let mut logs = self.folder.open_logs()?;
        let total = self.experiment.curriculum.total_steps();
        let mut finished = false;
        let mut next_report = self.counters.step;
        loop {
            let accepted = self.counters.accepted_at_step.is_some();
            if self.counters.step >= total
                || (accepted && self.experiment.training.stop_when_accepted)
            {
                finished = true;
                break;
            }
            if observer.stop_requested() {
                break;
            }
            let step = self.counters.step;
            let e = &self.experiment;
            let settings = e.curriculum.at(step, &e.task.reward);
            let begin = e.training.rehearsal.after_steps;
            self.apply_schedule(step as f64 / total as f64)?;
            if begin > 0 && step >= begin && !self.counters.rehearsal_begun {
                self.counters.rehearsal_begun = true;
                let note = self.begin_rehearsal(&settings)?;
                observer.note(&note);
            }
            self.collect(&settings, &mut logs.episodes)?;
            self.learn()?;
            self.counters.elapsed_s = before_s + clock.elapsed().as_secs_f64();
            if self.counters.step >= self.counters.next_metrics {
                after(
                    &mut self.counters.next_metrics,
                    self.counters.step,
                    self.experiment.training.metrics_interval_steps,
                );
                let row = self.metrics_row(&settings);
                logs.metrics(&row)?;
            }
            if self.counters.step >= self.counters.next_evaluation {
                after(
                    &mut self.counters.next_evaluation,
                    self.counters.step,
                    self.experiment.training.evaluation_interval_steps,
                );
                let mut from = Instant::now();
                self.evaluate(observer, &mut logs)?;
                lap(&mut from, &mut self.counters.parts.evaluating_s);
                self.counters.elapsed_s = before_s + clock.elapsed().as_secs_f64();
            }
            if self.counters.step >= self.counters.next_checkpoint {
                after(
                    &mut self.counters.next_checkpoint,
                    self.counters.step,
                    self.experiment.training.checkpoint_interval_steps,
                );
                let mut from = Instant::now();
                self.checkpoint(logs.sync()?)?;
                lap(&mut from, &mut self.counters.parts.checkpointing_s);
            }
            if self.counters.step >= next_report {
                next_report = self.counters.step + 2_000;
                observer.progress(&self.progress());
            }
        }
        let mut from = Instant::now();
        self.checkpoint(logs.sync()?)?;
        lap(&mut from, &mut self.counters.parts.checkpointing_s);
        self.counters.elapsed_s = before_s + clock.elapsed().as_secs_f64();
        observer.progress(&self.progress());
        let c = &self.counters;
        let report = RunReport {
            finished,
            step: c.step,
            updates: c.updates,
            elapsed_s: c.elapsed_s,
            accepted_at_step: c.accepted_at_step,
            accepted_after_s: c.accepted_after_s,
            best_step: c.best_step,
            best_met: c.best_met,
            criteria: c.criteria,
            diverged: c.diverged,
            parts: c.parts,
        };
        self.folder
            .write_json(&self.folder.file("report.json"), &report)?;
        Ok(report)
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
        let (score, shift) = best_walk(&mut policy, body, &e.task)
            .map_err(|e| TrainingError::other(self.folder.path(), e.to_string()))?;
        let rehearsal =
            e.training
                .rehearsal
                .collect(&mut policy, body, &e.task, settings, shift, e.seed)?;
        let Some(rehearsal) = rehearsal else {
            return Ok(format!(
                "no walk to rehearse: the best so far, of step {step}, always falls at once"
            ));
        };
        let states = rehearsal.rows();
        self.agent.rehearse(rehearsal)?;
        Ok(format!(
            "rehearsing the walk of step {step} from here on: {states} states, command shifted by {shift:+.3}, \
             score {score:.1} of 10"
        ))
    }

    fn apply_schedule(&mut self, share: f64) -> Result<(), TrainingError> {
        let schedule = &self.experiment.training.schedule;
        if let Some(rate) = schedule.learning_rate.at(share) {
            self.agent.set_learning_rate(rate)?;
        }
        if let Some(alpha) = schedule.alpha.at(share) {
            self.agent.set_alpha(alpha)?;
        }
        if let Some(horizon) = schedule.horizon.at(share) {
            self.agent.set_gamma(1.0 - 1.0 / horizon)?;
        }
        Ok(())
    }

    /// One control period of every environment, stored in the replay buffer.
    fn collect(
        &mut self,
        settings: &PhaseSettings,
        episodes: &mut TextLog,
    ) -> Result<(), TrainingError> {
        let mut from = Instant::now();
        let b = &mut self.buffers;
        let count = self.batch.len();
        let row = |i: usize, size: usize| i * size..(i + 1) * size;
        for (i, environment) in self.batch.environments().enumerate() {
            let out = &mut b.observations[row(i, OBSERVATION_SIZE)];
            b.commands[i] = environment.omega_v;
            scale_observation(&self.batch.observation(i, environment.omega_v), out);
        }
        self.agent
            .act(&b.observations, &mut b.actions, &mut b.log_probs)?;
        let reward = &settings.reward;
        let asks_symmetry =
            self.experiment.training.symmetry == Symmetry::Reward && reward.omega_s > 0.0;
        if asks_symmetry {
            for i in 0..count {
                let row = row(i, OBSERVATION_SIZE);
                let to = &mut b.mirrored[row.clone()];
                reflect(&self.mirror.observation, &b.observations[row], to);
            }
            self.agent
                .act_deterministic(&b.observations, &mut b.means)?;
            self.agent
                .act_deterministic(&b.mirrored, &mut b.mirrored_means)?;
            for i in 0..count {
                let row = row(i, ACTION_SIZE);
                let mut back = [0.0; ACTION_SIZE];
                reflect(
                    &self.mirror.action,
                    &b.mirrored_means[row.clone()],
                    &mut back,
                );
                b.symmetry[i] = reward.symmetry_term(&b.means[row], &back);
            }
        } else {
            b.symmetry.fill(0.0);
        }
        lap(&mut from, &mut self.counters.parts.acting_s);
        let (body, task, lanes) = self.batch.split();
        let (actions, symmetry) = (&b.actions, &b.symmetry);
        // The learner's threads have nothing else to do meanwhile, and no environment knows of another.
        self.agent
            .workers()
            .for_each_pair(lanes, &mut b.outcomes, |i, lane, outcome| {
                let action = &actions[row(i, ACTION_SIZE)];
                let command = [f64::from(action[0]), f64::from(action[1])];
                *outcome = Some(lane.step(body, task, command, symmetry[i], settings));
            });
        for i in 0..count {
            let Some((outcome, finished)) = b.outcomes[i].take() else {
                continue;
            };
            let held = b.commands[i];
            let diverged = outcome.ended == Some(EndReason::Diverged);
            b.valid[i] = !diverged;
            b.rewards[i] = (outcome.terms.sum() * outcome.factor) as f32;
            b.entropy_scales[i] = outcome.entropy_factor as f32;
            b.horizon_scales[i] = outcome.horizon_factor as f32;
            b.terminated[i] = outcome.ended.is_some_and(EndReason::is_termination);
            // A command that changes within the episode cuts the transition off, and its value goes on
            // under the old command: what is learned for a command is what it is worth when held, as in
            // the paper, however often commands change.
            let environment = self.batch.environment(i);
            b.truncated[i] =
                environment.omega_v != held || outcome.ended == Some(EndReason::TimeLimit);
            scale_observation(
                &self.batch.observation(i, held),
                &mut b.next_observations[row(i, OBSERVATION_SIZE)],
            );
            let recent = &mut self.counters.recent;
            for (sum, term) in recent.terms.iter_mut().zip(outcome.terms.values()) {
                *sum += term;
            }
            if let Some(finished) = finished {
                self.counters.diverged += u64::from(diverged);
                recent
                    .episodes
                    .push_back((finished.total_reward, finished.ended.is_termination()));
                if recent.episodes.len() > 100 {
                    recent.episodes.pop_front();
                }
                log_episode(episodes, self.counters.step, &finished)?;
                self.batch.reset(i, settings);
            }
        }
        lap(&mut from, &mut self.counters.parts.simulating_s);
        self.replay.push(Transitions {
            observations: &b.observations,
            actions: &b.actions,
            log_probs: &b.log_probs,
            rewards: &b.rewards,
            entropy_scales: &b.entropy_scales,
            horizon_scales: &b.horizon_scales,
            next_observations: &b.next_observations,
            terminated: &b.terminated,
            truncated: &b.truncated,
            valid: &b.valid,
        })?;
        lap(&mut from, &mut self.counters.parts.storing_s);
        self.counters.step += count as u64;
        self.counters.recent.steps += count as u64;
        Ok(())
    }

    fn learn(&mut self) -> Result<(), TrainingError> {
        let t = &self.experiment.training;
        if self.counters.step < t.learning_starts {
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

    fn metrics_row(&mut self, settings: &PhaseSettings) -> Vec<(String, f64)> {
        let progress = self.progress();
        let c = &mut self.counters;
        let recent = &mut c.recent;
        let steps = recent.steps.max(1) as f64;
        let updates = recent.updates.max(1) as f64;
        let mut row = vec![
            ("train/step".to_owned(), c.step as f64),
            ("train/updates".to_owned(), c.updates as f64),
            ("train/elapsed_s".to_owned(), c.elapsed_s),
            ("train/phase".to_owned(), settings.index as f64),
            ("train/omega_v_low".to_owned(), settings.omega_v[0]),
            ("train/omega_v_high".to_owned(), settings.omega_v[1]),
            ("episode/mean_return".to_owned(), progress.mean_return),
            ("episode/fall_share".to_owned(), progress.fall_share),
            ("episode/diverged".to_owned(), c.diverged as f64),
            (
                "learner/critic_loss".to_owned(),
                recent.critic_loss / updates,
            ),
            ("learner/actor_loss".to_owned(), recent.actor_loss / updates),
            ("learner/mean_q".to_owned(), recent.mean_q / updates),
            ("learner/entropy".to_owned(), recent.entropy / updates),
            (
                "learner/rehearsal_loss".to_owned(),
                recent.rehearsal_loss / updates,
            ),
            ("learner/alpha".to_owned(), self.agent.alpha()),
        ];
        for (name, sum) in RewardTerms::NAMES.iter().zip(recent.terms) {
            row.push((format!("reward/{name}"), sum / steps));
        }
        *recent = Recent {
            episodes: std::mem::take(&mut recent.episodes),
            ..Recent::default()
        };
        row
    }

    fn progress(&self) -> Progress {
        let c = &self.counters;
        let e = &self.experiment;
        let episodes = &c.recent.episodes;
        let count = episodes.len().max(1) as f64;
        let index = e.curriculum.at(c.step, &e.task.reward).index;
        Progress {
            step: c.step,
            total_steps: e.curriculum.total_steps(),
            updates: c.updates,
            elapsed_s: c.elapsed_s,
            phase: e.curriculum.phases[index].name.clone(),
            mean_return: episodes.iter().map(|e| e.0).sum::<f64>() / count,
            fall_share: episodes.iter().filter(|e| e.1).count() as f64 / count,
            verdict: c.verdict.clone(),
        }
    }

    /// The policy that is judged and shipped: the averaged one where there is one.
    fn policy(&self) -> Policy {
        self.agent
            .averaged_policy()
            .unwrap_or_else(|| self.agent.policy())
    }

    fn controller(&self) -> Controller {
        Controller {
            policy: self.policy(),
            body: self.experiment.body.clone(),
            task: self.experiment.task.clone(),
            provenance: Provenance {
                experiment: self.experiment.name.clone(),
                command: self.command.clone(),
                seed: self.experiment.seed,
                environment_steps: self.counters.step,
                updates: self.counters.updates,
                averaged_evaluations: 1,
                version: env!("CARGO_PKG_VERSION").to_owned(),
                edits: self.edits.clone(),
            },
        }
    }

    fn evaluate(
        &mut self,
        observer: &mut dyn Observer,
        logs: &mut Logs,
    ) -> Result<(), TrainingError> {
        let mut controller = self.controller();
        let mut judgement = self.judge(&mut controller.policy)?;
        controller.write(&self.folder.evaluated(self.counters.step)?)?;
        self.keep_best_walk(&mut controller)?;
        let latest = &mut self.counters.latest_evaluations;
        latest.push(self.counters.step);
        let surplus = latest
            .len()
            .saturating_sub(self.experiment.training.average_evaluations);
        latest.drain(..surplus);
        if let Some((_, earlier)) = latest.split_last().filter(|(_, e)| !e.is_empty()) {
            let mut policies = Vec::new();
            for &step in earlier {
                policies.push(Controller::read(&self.folder.evaluated(step)?)?.policy);
            }
            policies.push(controller.policy.clone());
            if let Some(mut mean) = Policy::mean(&policies.iter().collect::<Vec<_>>()) {
                let of_mean = self.judge(&mut mean)?;
                if of_mean.score() > judgement.score() {
                    judgement = of_mean;
                    controller.policy = mean;
                    controller.provenance.averaged_evaluations = policies.len();
                }
            }
        }
        let best = judgement.score() > self.counters.best_score;
        let c = &mut self.counters;
        c.verdict = verdict(&judgement);
        c.criteria = judgement.checks.len();
        if best {
            c.best_score = judgement.score();
            c.best_step = c.step;
            c.best_met = judgement.met();
            controller.write(&self.folder.file("controller.safetensors"))?;
        }
        if judgement.accepted() && c.accepted_at_step.is_none() {
            c.accepted_at_step = Some(c.step);
            c.accepted_after_s = Some(c.elapsed_s);
            controller.write(&self.folder.file("controller-accepted.safetensors"))?;
        }
        let averaged = controller.provenance.averaged_evaluations;
        logs.evaluation(c.step, c.elapsed_s, averaged, &judgement)?;
        observer.evaluated(&self.progress(), &judgement, best);
        Ok(())
    }

    fn judge(&self, policy: &mut Policy) -> Result<Judgement, TrainingError> {
        judge(
            self.batch.body(),
            &self.experiment.task,
            &self.criteria,
            &mut Deterministic(policy),
        )
        .map_err(|e| TrainingError::other(self.folder.path(), e.to_string()))
    }

    /// Keeps the controller if it is going to be rehearsed and walks best of all so far.
    fn keep_best_walk(&mut self, controller: &mut Controller) -> Result<(), TrainingError> {
        let c = &mut self.counters;
        if c.step > self.experiment.training.rehearsal.after_steps {
            return Ok(());
        }
        let task = &self.experiment.task;
        let (score, _) = best_walk(&mut controller.policy, self.batch.body(), task)
            .map_err(|e| TrainingError::other(self.folder.path(), e.to_string()))?;
        // Of two that are as good, the later one has been practised for longer.
        if score >= c.walking_score {
            c.walking_score = score;
            controller.write(&self.folder.file(WALK_FILE))?;
        }
        Ok(())
    }

    fn checkpoint(&mut self, logs: LogLengths) -> Result<(), TrainingError> {
        let folder = &self.folder;
        folder.begin_checkpoint()?;
        self.agent.save(&folder.pending("agent.safetensors"))?;
        self.replay.save(&folder.pending("replay.safetensors"))?;
        let config = folder.pending("config.toml");
        durable::write(&config, self.configuration()?.as_bytes())
            .map_err(|e| TrainingError::other(&config, e.to_string()))?;
        folder.sync_checkpoint()?;
        let state = CheckpointState {
            format: FORMAT.to_owned(),
            command: self.command.clone(),
            edits: self.edits.clone(),
            logs,
            counters: self.counters.clone(),
            batch: self.batch.state(),
        };
        folder.write_json(&folder.pending(STATE), &state)?;
        folder.commit_checkpoint()?;
        self.controller()
            .write(&folder.file("controller-last.safetensors"))?;
        Ok(())
    }
}

/// Reads the state of a checkpoint.
fn read_state(path: &Path) -> Result<CheckpointState, TrainingError> {
    let error = |cause: String| TrainingError::other(path, cause);
    let text = std::fs::read_to_string(path).map_err(|e| error(e.to_string()))?;
    let damaged = |e: serde_json::Error| error(format!("the checkpoint is damaged: {e}"));
    let version: Version = serde_json::from_str(&text).map_err(damaged)?;
    if version.format != FORMAT {
        return Err(error(format!(
            "its format is `{}`, this program reads `{FORMAT}`; go on with the version of the program that wrote it",
            version.format
        )));
    }
    serde_json::from_str(&text).map_err(damaged)
}

/// One row of `episodes.csv`.
fn log_episode(log: &mut TextLog, step: u64, e: &FinishedEpisode) -> Result<(), TrainingError> {
    log.line(&format!(
        "{step},{},{},{},{},{}",
        e.omega_v,
        e.total_reward,
        e.periods,
        e.ended.name(),
        e.distance_m
    ))
}

/// One line about an evaluation.
fn verdict(j: &Judgement) -> String {
    let rows: Vec<String> = j
        .rows
        .iter()
        .map(|r| {
            let s = &r.summary;
            if s.fell {
                format!("{}:fell {:.1}s", r.omega_v, s.survived_s)
            } else {
                format!("{}:{} Fr {:.2}", r.omega_v, s.gait, s.froude.unwrap_or(0.0))
            }
        })
        .collect();
    format!(
        "{}/{} criteria [{}]",
        j.met(),
        j.checks.len(),
        rows.join(", ")
    )
}
