//! What a run counts, how it is told, and where its time goes.

use super::{Rank, Training};
use crate::config::Experiment;
use gaitshift_task::{MOST_EXTRA, PhaseSettings, RewardTerms};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::time::Instant;

/// More steps than any curriculum has.
const MOST_STEPS: u64 = 1 << 62;
/// Episodes that means over the last episodes are taken of.
const LATEST_EPISODES: usize = 100;

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
    /// Short verdict of the last evaluation, e.g. `31/39 criteria [0:walking Fr 0.21, 0.5:mixed Fr 0.40, ...]`.
    pub verdict: String,
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

/// Adds the time since `*from` to `part` and begins anew.
pub fn lap(from: &mut Instant, part: &mut f64) {
    let now = Instant::now();
    *part += (now - *from).as_secs_f64();
    *from = now;
}

/// Counters that a checkpoint keeps besides agent, replay and environments.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Counters {
    pub step: u64,
    pub updates: u64,
    pub update_credit: u64,
    pub elapsed_s: f64,
    pub next_evaluation: u64,
    pub next_checkpoint: u64,
    pub next_metrics: u64,
    pub best_rank: Rank,
    pub best_step: u64,
    pub best_met: usize,
    /// How often what controllers are chosen by was edited: disturbances, starts, endings.
    pub disturbance_edits: u32,
    /// Of the best walk so far, which is kept where the walk is going to be rehearsed.
    pub walking_score: f64,
    /// Whether the time to remember the walk has come.
    pub rehearsal_begun: bool,
    pub criteria: usize,
    pub accepted_at_step: Option<u64>,
    pub accepted_after_s: Option<f64>,
    pub diverged: u64,
    pub verdict: String,
    pub recent: Recent,
    pub parts: Parts,
}

impl Counters {
    /// Whether a run of this configuration can have counted so.
    pub fn are_possible(&self, experiment: &Experiment) -> bool {
        let t = &experiment.training;
        let environments = t.environments as u64;
        self.step <= MOST_STEPS
            && self.updates <= self.step
            && self.update_credit < t.steps_per_update + environments
            && self.recent.steps <= self.step
            && self.recent.updates <= self.updates
            && self.recent.episodes.len() <= LATEST_EPISODES
            && self.diverged <= self.step
    }

    /// Whether `next` has come; if so it moves on by whole intervals until it lies ahead.
    pub fn due(step: u64, next: &mut u64, interval: u64) -> bool {
        let due = step >= *next;
        if due {
            *next += interval * (1 + (step - *next) / interval);
        }
        due
    }
}

/// Sums since the last row of metrics, and the latest episodes.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Recent {
    pub steps: u64,
    pub terms: [f64; RewardTerms::NAMES.len()],
    /// Those of one's own.
    pub extra_terms: [f64; MOST_EXTRA],
    pub updates: u64,
    pub critic_loss: f64,
    pub actor_loss: f64,
    pub mean_q: f64,
    pub entropy: f64,
    pub rehearsal_loss: f64,
    /// Return and whether it fell, of up to 100 episodes.
    pub episodes: VecDeque<(f64, bool)>,
}

impl Recent {
    /// Adds an episode, and forgets the oldest of more than 100.
    pub fn add(&mut self, total_reward: f64, fell: bool) {
        self.episodes.push_back((total_reward, fell));
        if self.episodes.len() > LATEST_EPISODES {
            self.episodes.pop_front();
        }
    }
}

/// Columns of `metrics.csv`, without those of the reward's terms.
const METRICS: [&str; 15] = [
    "train/step",
    "train/updates",
    "train/elapsed_s",
    "train/phase",
    "train/omega_v_low",
    "train/omega_v_high",
    "episode/mean_return",
    "episode/fall_share",
    "episode/diverged",
    "learner/critic_loss",
    "learner/actor_loss",
    "learner/mean_q",
    "learner/entropy",
    "learner/rehearsal_loss",
    "learner/alpha",
];

/// All columns of `metrics.csv`, the reward terms of one's own last.
pub(super) fn metrics_names(experiment: &Experiment) -> Vec<String> {
    let terms = RewardTerms::NAMES
        .into_iter()
        .chain(experiment.task.reward.extra.names())
        .map(|name| format!("reward/{name}"));
    METRICS
        .into_iter()
        .map(str::to_owned)
        .chain(terms)
        .collect()
}

impl Training {
    /// Means since the last row, which begins anew.
    pub(super) fn metrics_row(&mut self, settings: &PhaseSettings) -> Vec<(String, f64)> {
        let progress = self.progress();
        let c = &mut self.counters;
        let recent = &mut c.recent;
        let steps = recent.steps.max(1) as f64;
        let updates = recent.updates.max(1) as f64;
        let values = [
            c.step as f64,
            c.updates as f64,
            c.elapsed_s,
            settings.index as f64,
            settings.omega_v[0],
            settings.omega_v[1],
            progress.mean_return,
            progress.fall_share,
            c.diverged as f64,
            recent.critic_loss / updates,
            recent.actor_loss / updates,
            recent.mean_q / updates,
            recent.entropy / updates,
            recent.rehearsal_loss / updates,
            self.agent.alpha(),
        ];
        let terms = recent.terms.iter().chain(&recent.extra_terms);
        let terms = terms.map(|sum| sum / steps);
        let row = metrics_names(&self.experiment)
            .into_iter()
            .zip(values.into_iter().chain(terms))
            .collect();
        *recent = Recent {
            episodes: std::mem::take(&mut recent.episodes),
            ..Recent::default()
        };
        row
    }

    /// How it goes.
    pub(super) fn progress(&self) -> Progress {
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
}
