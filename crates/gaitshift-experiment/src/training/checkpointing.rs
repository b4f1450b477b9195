//! Checkpoints: what they hold, and how a run goes on from one.

use super::counting::{Counters, lap};
use super::{NONE_YET, Training, learner_mirror};
use crate::config::Experiment;
use crate::durable;
use crate::edits::{Edit, edits, is_decided};
use crate::logs::LogLengths;
use crate::run_folder::{LAST_CONTROLLER, RunFolder, STATE};
use crate::training_error::{TrainingError, io_error};
use gaitshift_sac::{Agent, ReplayBuffer};
use gaitshift_task::{
    BatchState, CommandDraw, Randomization, StartParameters, TerminationParameters,
};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::time::Instant;

/// Version of [`CheckpointState`].
const FORMAT: &str = "gaitshift-run 5";

/// The part of a state that is read before the rest.
#[derive(Deserialize)]
struct Version {
    #[serde(default)]
    format: String,
}

/// Everything but learner, replay buffer and configuration, which have files of their own.
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

/// What to do where a checkpoint cannot be used.
const RESTORE: &str = "copy checkpoint/config.toml over it, or begin a new run";
const DAMAGED: &str =
    "so the checkpoint is damaged: begin a new run; controllers and logs can be used as they are";

impl Training {
    /// Goes on with a run from the last checkpoint in its folder. What was edited in its `config.toml` since is applied
    /// from there on, and told by [`Training::run`].
    ///
    /// # Errors
    /// No run or no checkpoint there, one that is damaged or of another version, or an edit of what the checkpoint
    /// decides: the learner, the seed, the body, the control period, the number of environments, the size of the replay
    /// buffer, the criteria, the controller of a warm start, the names of own reward terms, whether batches are mirrored, and
    /// the rehearsal once the walk is remembered.
    pub fn resume(folder: &Path) -> Result<Self, TrainingError> {
        let folder = RunFolder::at(folder);
        folder.require_config()?;
        let lock = folder.lock()?;
        folder.recover_checkpoint()?;
        let path = folder.checkpoint(STATE);
        // First, since the keys of a configuration belong to a version.
        let state = read_state(&path)?;
        let experiment = folder.read_config()?;
        let before = Experiment::read(&folder.checkpoint("config.toml"))?;
        if !state.counters.are_possible(&before) {
            return Err(TrainingError::other(
                &path,
                format!("its counters contradict each other, {DAMAGED}"),
            ));
        }
        let edits = edits(&before, &experiment)?;
        let mirrored = learner_mirror(&before) != learner_mirror(&experiment);
        let rehearsing = state.counters.rehearsal_begun;
        let refused = |edit: &&Edit| is_decided(&edit.key, mirrored, rehearsing);
        if let Some(edit) = edits.iter().find(refused) {
            return Err(TrainingError::other(
                &folder.file("config.toml"),
                format!(
                    "changes {edit}, which the checkpoint at step {} fixes; restore it to resume, or begin a new run with \
                     the edited file",
                    state.counters.step
                ),
            ));
        }
        let mut training = Self::prepare(experiment, folder, &state.command)?;
        training._lock = lock;
        training.restore_learner()?;
        if !training.batch.restore(state.batch) {
            return Err(TrainingError::other(
                &path,
                format!("its environments are not those of config.toml; {RESTORE}"),
            ));
        }
        training.counters = state.counters;
        // Edited to fewer steps per update, what was saved up would be more than can be.
        training.counters.update_credit %= training.experiment.training.steps_per_update;
        training.edits = state.edits;
        training.report_edits(&edits);
        training.choose_anew_if_judged_otherwise(&before);
        training.folder.restore_best()?;
        training.folder.cut_logs(&state.logs)?;
        training.folder.cut_evaluated(training.counters.step)?;
        Ok(training)
    }

    /// Takes agent and replay buffer from the checkpoint. What phases move of the learner follows with the next step.
    fn restore_learner(&mut self) -> Result<(), TrainingError> {
        let folder = &self.folder;
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
        if !same_network(&agent, &self.agent) || sizes(&replay) != sizes(&self.replay) {
            return Err(TrainingError::other(
                folder.path(),
                format!(
                    "its checkpoint is of another configuration than its config.toml; {RESTORE}"
                ),
            ));
        }
        (self.agent, self.replay) = (agent, replay);
        Ok(self.agent.set_threads(self.experiment.learner.threads)?)
    }

    /// Notes what was edited, for the user and for the controllers to come.
    fn report_edits(&mut self, edits: &[Edit]) {
        let (c, t) = (&mut self.counters, &self.experiment.training);
        if !edits.is_empty() {
            let list: Vec<String> = edits.iter().map(Edit::to_string).collect();
            let (step, list) = (c.step, list.join(", "));
            self.notes.push(format!(
                "edited in config.toml, in force from step {step} on: {list}"
            ));
            self.edits.push(format!("at step {step}: {list}"));
        }
        // A shorter interval begins to count at once.
        for (next, interval) in [
            (&mut c.next_evaluation, t.evaluation_interval_steps),
            (&mut c.next_checkpoint, t.checkpoint_interval_steps),
            (&mut c.next_metrics, t.metrics_interval_steps),
        ] {
            *next = (*next).min(c.step.saturating_add(interval));
        }
    }

    /// Where what controllers are judged by was edited, those chosen before are no longer comparable.
    fn choose_anew_if_judged_otherwise(&mut self, before: &Experiment) {
        let after = &self.experiment;
        let c = &mut self.counters;
        if Undisturbed::of(before) != Undisturbed::of(after) {
            c.walking_score = 0.0;
        }
        if c.best_step == 0 {
            return;
        }
        let chosen_by_them = before.curriculum.randomizes_by(c.step.saturating_sub(1));
        let disturbed_otherwise = chosen_by_them && Disturbed::of(before) != Disturbed::of(after);
        if !disturbed_otherwise && Undisturbed::of(before) == Undisturbed::of(after) {
            return;
        }
        c.best_rank = NONE_YET;
        c.disturbance_edits += 1;
        self.notes.push(format!(
            "what the best controller is chosen by was edited: the choice begins anew with the next evaluation, and the \
             best so far stays as controllers/{}",
            RunFolder::evaluated_name(c.best_step)
        ));
    }

    /// Writes a checkpoint, the logs having these lengths, and the controller as it is.
    pub(super) fn checkpoint(&mut self, logs: LogLengths) -> Result<(), TrainingError> {
        self.write_checkpoint(logs)?;
        self.write_last()
    }

    /// Writes the controller as it is.
    pub(super) fn write_last(&mut self) -> Result<(), TrainingError> {
        let mut from = Instant::now();
        self.controller()
            .write(&self.folder.file(LAST_CONTROLLER))?;
        lap(&mut from, &mut self.counters.parts.checkpointing_s);
        Ok(())
    }

    /// Writes the checkpoint alone.
    pub(super) fn write_checkpoint(&mut self, logs: LogLengths) -> Result<(), TrainingError> {
        let mut from = Instant::now();
        let folder = &self.folder;
        folder.begin_checkpoint()?;
        self.agent.save(&folder.pending("agent.safetensors"))?;
        self.replay.save(&folder.pending("replay.safetensors"))?;
        let config = folder.pending("config.toml");
        durable::write(&config, self.configuration()?.as_bytes()).map_err(io_error(&config))?;
        folder.keep_best()?;
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
        lap(&mut from, &mut self.counters.parts.checkpointing_s);
        Ok(())
    }

    /// The configuration as a text, every value written out.
    pub(super) fn configuration(&self) -> Result<String, TrainingError> {
        let text = self.experiment.to_toml();
        text.map_err(|e| TrainingError::other(self.folder.path(), e.to_string()))
    }
}

/// What of the task the criteria are judged by: a motion of theirs begins in the middle of the starts and has its own limit.
#[derive(PartialEq)]
struct Undisturbed {
    start: StartParameters,
    termination: TerminationParameters,
}

impl Undisturbed {
    fn of(e: &Experiment) -> Self {
        Self {
            start: StartParameters {
                leg_variation_rad: 0.0,
                pitch_variation_rad: 0.0,
                speed_variation_m_per_s: 0.0,
                drop_variation_m: 0.0,
                ..e.task.start.clone()
            },
            termination: TerminationParameters {
                time_limit_s: 0.0,
                ..e.task.termination.clone()
            },
        }
    }
}

/// What decides the disturbed motions by which controllers are judged.
#[derive(PartialEq)]
struct Disturbed {
    drawn: Randomization,
    omega_v: [f64; 2],
    command: CommandDraw,
    start: StartParameters,
    termination: TerminationParameters,
}

impl Disturbed {
    fn of(e: &Experiment) -> Option<Self> {
        let mut phases = e.curriculum.phases.iter().rev();
        let (phase, mut drawn) = phases.find_map(|p| Some((p, p.randomization.clone()?)))?;
        // All of them are disturbed, and no command ends one.
        drawn.share = 1.0;
        let mut termination = e.task.termination.clone();
        termination.time_limit_s = termination.time_limit_s.min(e.criteria.duration_s);
        Some(Self {
            drawn,
            // Where the phase ends: more steps for it change nothing.
            omega_v: phase.omega_v_end.unwrap_or(phase.omega_v),
            command: CommandDraw {
                hold_periods: 0,
                ..e.curriculum.command.clone()
            },
            start: e.task.start.clone(),
            termination,
        })
    }
}

/// Reads the state of a checkpoint.
fn read_state(path: &Path) -> Result<CheckpointState, TrainingError> {
    let error = |cause: String| TrainingError::other(path, cause);
    let text = std::fs::read_to_string(path).map_err(|e| error(format!("{e}, {DAMAGED}")))?;
    let damaged = |e: serde_json::Error| error(format!("{e}, {DAMAGED}"));
    let version: Version = serde_json::from_str(&text).map_err(damaged)?;
    if version.format != FORMAT {
        return Err(error(format!(
            "its format is `{}`, this program reads `{FORMAT}`; go on with the version of the program that wrote it, or \
             begin a new run",
            version.format
        )));
    }
    serde_json::from_str(&text).map_err(damaged)
}

/// Whether two agents have the same networks and the same mirror; phases move the rest of their settings.
fn same_network(a: &Agent, b: &Agent) -> bool {
    let shape = |agent: &Agent| {
        let c = agent.config();
        let hidden = (c.actor_hidden.clone(), c.critic_hidden.clone());
        (
            hidden,
            c.critic_layer_norm,
            c.n_step,
            c.batch_size,
            agent.mirror().cloned(),
        )
    };
    shape(a) == shape(b)
}
