//! One control period of every environment, into the replay buffer.

use super::Training;
use super::counting::lap;
use crate::config::Symmetry;
use crate::logs::TextLog;
use crate::training_error::TrainingError;
use gaitshift_sac::{Transitions, reflect};
use gaitshift_task::{
    ACTION_SIZE, EndReason, FinishedEpisode, OBSERVATION_SIZE, PhaseSettings, StepOutcome,
    scale_observation,
};
use std::time::Instant;

/// One control period of all environments, one environment after the other.
#[derive(Debug, Default)]
pub struct Buffers {
    observations: Vec<f32>,
    next_observations: Vec<f32>,
    mirrored: Vec<f32>,
    actions: Vec<f32>,
    /// `π(s_t)` of (7).
    own: Vec<f32>,
    mirrored_means: Vec<f32>,
    log_probs: Vec<f32>,
    rewards: Vec<f32>,
    symmetry: Vec<f64>,
    /// ω_v under which the step is taken.
    commands: Vec<f64>,
    outcomes: Vec<Option<(StepOutcome, Option<FinishedEpisode>)>>,
    terminated: Vec<bool>,
    truncated: Vec<bool>,
    valid: Vec<bool>,
}

impl Buffers {
    pub fn new(count: usize) -> Self {
        let observations = vec![0.0; count * OBSERVATION_SIZE];
        let actions = vec![0.0; count * ACTION_SIZE];
        Self {
            next_observations: observations.clone(),
            mirrored: observations.clone(),
            observations,
            own: actions.clone(),
            mirrored_means: actions.clone(),
            actions,
            log_probs: vec![0.0; count],
            rewards: vec![0.0; count],
            symmetry: vec![0.0; count],
            commands: vec![0.0; count],
            outcomes: vec![None; count],
            terminated: vec![false; count],
            truncated: vec![false; count],
            valid: vec![true; count],
        }
    }
}

impl Training {
    /// One control period of every environment, stored in the replay buffer.
    pub(super) fn collect(
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
        let symmetry = self.experiment.training.symmetry;
        let in_reward = matches!(symmetry, Symmetry::Reward | Symmetry::Action);
        if in_reward && reward.omega_s > 0.0 {
            for i in 0..count {
                let row = row(i, OBSERVATION_SIZE);
                let to = &mut b.mirrored[row.clone()];
                reflect(&self.mirror.observation, &b.observations[row], to);
            }
            if symmetry == Symmetry::Action {
                b.own.copy_from_slice(&b.actions);
            } else {
                self.agent.act_deterministic(&b.observations, &mut b.own)?;
            }
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
                b.symmetry[i] = reward.symmetry_term(&b.own[row], &back);
            }
        } else {
            b.symmetry.fill(0.0);
        }
        lap(&mut from, &mut self.counters.parts.acting_s);
        let (body, task, members) = self.batch.split();
        let (actions, symmetry) = (&b.actions, &b.symmetry);
        // The learner's threads have nothing else to do meanwhile, and no environment knows of another.
        self.agent
            .workers()
            .for_each_pair(members, &mut b.outcomes, |i, member, outcome| {
                let action = &actions[row(i, ACTION_SIZE)];
                let command = [f64::from(action[0]), f64::from(action[1])];
                *outcome = Some(member.step(body, task, command, symmetry[i], settings));
            });
        for i in 0..count {
            let Some((outcome, finished)) = b.outcomes[i].take() else {
                continue;
            };
            let held = b.commands[i];
            let diverged = outcome.ended.is_some_and(EndReason::is_failure);
            let reward = (outcome.terms.sum() * outcome.factor) as f32;
            // More than the learner's 32 bits hold is as little to be learned from as what is undefined.
            let undefined = !diverged && !reward.is_finite();
            b.valid[i] = !(diverged || undefined);
            b.rewards[i] = if undefined { 0.0 } else { reward };
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
            self.counters.diverged += u64::from(!b.valid[i]);
            let recent = &mut self.counters.recent;
            if b.valid[i] {
                for (sum, term) in recent.terms.iter_mut().zip(outcome.terms.values()) {
                    *sum += term;
                }
                for (sum, term) in recent.extra_terms.iter_mut().zip(outcome.terms.extra) {
                    *sum += term;
                }
            }
            if let Some(finished) = finished {
                recent.add(finished.total_reward, finished.ended.is_termination());
                let ended = self.experiment.task.end_name(finished.ended);
                log_episode(episodes, self.counters.step, &finished, ended)?;
                self.batch.reset(i, settings);
            }
        }
        lap(&mut from, &mut self.counters.parts.simulating_s);
        self.replay.push(Transitions {
            observations: &b.observations,
            actions: &b.actions,
            log_probs: &b.log_probs,
            rewards: &b.rewards,
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
}

/// One row of `episodes.csv`.
fn log_episode(
    log: &mut TextLog,
    step: u64,
    e: &FinishedEpisode,
    ended: &str,
) -> Result<(), TrainingError> {
    log.line(&format!(
        "{step},{},{},{},{ended},{}",
        e.omega_v, e.total_reward, e.periods, e.distance_m
    ))
}
