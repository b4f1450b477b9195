//! The walk of the first phases, remembered: states of the best walk found there and what it did in
//! them, for the learner to rehearse while it learns to run.

use crate::acceptance::judge;
use crate::criteria::{AskedGait, Criteria};
use crate::simulation::Control;
use gaitshift_analysis::GaitClass;
use gaitshift_analysis::recording::RowError;
use gaitshift_body::Body;
use gaitshift_sac::{Policy, Rehearsal, SacError};
use gaitshift_task::{
    ACTION_SIZE, EndReason, EnvironmentBatch, OBSERVATION_SCALE, OBSERVATION_SIZE, OMEGA_V_MAX,
    PhaseSettings, TaskParameters, scale_observation,
};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

/// Environments that the walk is collected from.
const ENVIRONMENTS: usize = 32;
/// What is forgotten before a fall, in s: nothing there is worth imitating.
const BEFORE_FALL_S: f64 = 1.0;

/// Commands that are tried on a walk: this many either way of the one at which it is asked for, this far apart.
const TRIED: i32 = 28;
const APART: f64 = 0.0125;
/// What a walk should have to spare of Froude number, on either side, and of correlation: of ten walks that were learned from
/// one, all were within 0.006 of its Froude number and 0.01 of its correlation.
const FROUDE_ROOM: f64 = 0.01;
const CORRELATION_ROOM: f64 = 0.02;
/// How much the commands next to it count, this many in all, beside a walk itself.
const AROUND: usize = 5;
const AROUND_SHARE: f64 = 0.1;
/// Where the command stands in an observation.
const COMMAND: usize = OBSERVATION_SIZE - 1;

/// A policy that is told one command whatever it is given.
struct Told<'a> {
    policy: &'a mut Policy,
    omega_v: f64,
}

impl Control for Told<'_> {
    fn act(&mut self, observation: &[f32; OBSERVATION_SIZE], action: &mut [f32; ACTION_SIZE]) {
        let mut told = *observation;
        told[COMMAND] = scaled(self.omega_v);
        // Sizes are those of every policy of this program.
        if self.policy.mean_action(&told, action).is_err() {
            action.fill(0.0);
        }
    }
}

/// A command as the policy observes it.
fn scaled(omega_v: f64) -> f32 {
    omega_v as f32 * OBSERVATION_SCALE[COMMAND]
}

/// How good the walk of a policy is at its best, and the command that it has to be told for it: a learner left to itself
/// finds the walk that pays best, whose speed differs from seed to seed. The score is that of the walking
/// criteria of `asked` with some room to spare, since a walk is imitated only roughly. Of walks that are as good,
/// the one whose neighbours are: speed can change steeply with the command, and the edge of standing is near. Nothing where no
/// walk is asked for.
///
/// # Errors
/// A recording that refuses a row.
pub fn best_walk(
    policy: &mut Policy,
    body: &Body,
    task: &TaskParameters,
    asked: &Criteria,
) -> Result<(f64, f64), RowError> {
    let mut best = (f64::NEG_INFINITY, 0.0);
    let Some(walk) = asked.first(GaitClass::Walking) else {
        return Ok(best);
    };
    let with_room = |bound: f64, room: f64| {
        // A bound of 0 asks nothing, so one that is left must stay above it.
        if bound > 0.0 {
            (bound + room).max(f64::MIN_POSITIVE)
        } else {
            bound
        }
    };
    let criteria = Criteria {
        omega_v: vec![walk.omega_v],
        duration_s: asked.duration_s,
        slowest_froude_max: with_room(asked.slowest_froude_max, -FROUDE_ROOM),
        fastest_froude_min: 0.0,
        gaits: vec![AskedGait {
            froude_min: with_room(walk.froude_min, FROUDE_ROOM),
            froude_max: with_room(walk.froude_max, -FROUDE_ROOM),
            correlation: with_room(walk.correlation, CORRELATION_ROOM),
            ..walk.clone()
        }],
        changes: Vec::new(),
    };
    let mut walks = Vec::new();
    for k in -TRIED..=TRIED {
        let omega_v = walk.omega_v + APART * f64::from(k);
        let mut control = Told { policy, omega_v };
        let judgement = judge(body, task, &criteria, &mut control)?;
        walks.push((omega_v, judgement.score()));
    }
    for around in walks.windows(AROUND) {
        let (omega_v, own) = around[AROUND / 2];
        let mean = around.iter().map(|(_, score)| score).sum::<f64>() / AROUND as f64;
        let score = (own + AROUND_SHARE * mean) / (1.0 + AROUND_SHARE);
        if score > best.0 {
            best = (score, omega_v);
        }
    }
    Ok(best)
}

/// How the walk is rehearsed in the phases whose `learner` table has a weight `rehearsal` for it. *Not in the paper.*
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RehearsalParameters {
    /// Remembered pairs in an update.
    pub rows: usize,
    /// Pairs remembered.
    pub states: usize,
    /// Commands under which the walk is remembered.
    pub omega_v: [f64; 2],
}

impl Default for RehearsalParameters {
    fn default() -> Self {
        Self {
            rows: 64,
            states: 50_000,
            omega_v: [-0.05, 0.2],
        }
    }
}

impl RehearsalParameters {
    /// Checks every value; the error is a sentence that names the key.
    pub(crate) fn validate(&self) -> Result<(), String> {
        let error = |key: &str, value: String, accepted: &str| {
            Err(format!(
                "`training.rehearsal.{key}` is {value}, but it must be {accepted}"
            ))
        };
        if !(1..=65536).contains(&self.rows) {
            return error("rows", self.rows.to_string(), "between 1 and 65536");
        }
        if !(1000..=10_000_000).contains(&self.states) {
            let accepted = "between 1000 and 10000000";
            return error("states", self.states.to_string(), accepted);
        }
        let [low, high] = self.omega_v;
        if !(-OMEGA_V_MAX <= low && low <= high && high <= OMEGA_V_MAX) {
            let accepted = "[low, high] with -100 <= low <= high <= 100";
            return error("omega_v", format!("{:?}", self.omega_v), accepted);
        }
        Ok(())
    }

    /// Lets `policy` act, with its own exploration, so that its answers to small disturbances are
    /// remembered too; what is remembered of an action is its mean. It is told the command `told`,
    /// and remembered under those of [`omega_v`](Self::omega_v). Nothing if it falls so often that nothing is left.
    ///
    /// # Errors
    /// When the policy is none for this task.
    pub fn collect(
        &self,
        policy: &mut Policy,
        body: &Body,
        task: &TaskParameters,
        settings: &PhaseSettings,
        told: f64,
        seed: u64,
    ) -> Result<Option<Rehearsal>, SacError> {
        let settings = PhaseSettings {
            omega_v: self.omega_v,
            ..settings.clone()
        };
        let count = ENVIRONMENTS;
        let mut batch = EnvironmentBatch::new(body.clone(), task.clone(), count, seed, &settings);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0x7265_6865);
        let mut observations = vec![0.0; count * OBSERVATION_SIZE];
        let mut actions = vec![0.0; count * ACTION_SIZE];
        let mut means = actions.clone();
        let mut log_probs = vec![0.0; count];
        let before_fall = (BEFORE_FALL_S / task.control_period_s).round() as usize;
        // Each environment's states of the running episode, and those of finished ones.
        let mut episodes = vec![(Vec::new(), Vec::new()); count];
        let (mut states, mut answers) = (Vec::new(), Vec::new());
        let mut keep = |(o, a): &mut (Vec<f32>, Vec<f32>), fell: bool| {
            let rows = a.len() / ACTION_SIZE;
            let rows = if fell {
                rows.saturating_sub(before_fall)
            } else {
                rows
            };
            states.extend_from_slice(&o[..rows * OBSERVATION_SIZE]);
            answers.extend_from_slice(&a[..rows * ACTION_SIZE]);
            o.clear();
            a.clear();
        };
        for _ in 0..self.states.div_ceil(count) {
            for (i, out) in observations.chunks_exact_mut(OBSERVATION_SIZE).enumerate() {
                let omega_v = batch.environment(i).omega_v;
                scale_observation(&batch.observation(i, omega_v), out);
                out[COMMAND] = scaled(told);
            }
            policy.sample(&observations, &mut rng, &mut actions, &mut log_probs)?;
            policy.mean_action(&observations, &mut means)?;
            for (i, episode) in episodes.iter_mut().enumerate() {
                let row = i * OBSERVATION_SIZE..(i + 1) * OBSERVATION_SIZE;
                episode.0.extend_from_slice(&observations[row]);
                if let Some(command) = episode.0.last_mut() {
                    *command = scaled(batch.environment(i).omega_v);
                }
                let row = i * ACTION_SIZE..(i + 1) * ACTION_SIZE;
                episode.1.extend_from_slice(&means[row.clone()]);
                let command = [
                    f64::from(actions[row.start]),
                    f64::from(actions[row.start + 1]),
                ];
                let (outcome, _) = batch.step(i, command, 0.0, &settings);
                if let Some(ended) = outcome.ended {
                    keep(episode, ended != EndReason::TimeLimit);
                    batch.reset(i, &settings);
                }
            }
        }
        for episode in &mut episodes {
            keep(episode, false);
        }
        if states.is_empty() {
            return Ok(None);
        }
        Rehearsal::new(OBSERVATION_SIZE, ACTION_SIZE, states, answers).map(Some)
    }
}
