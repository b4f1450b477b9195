//! Evaluations: the controller so far is judged without noise, and the best is kept.

use super::counting::lap;
use super::{Observer, Training, WALK_FILE};
use crate::acceptance::{Judgement, judge};
use crate::controller::{Controller, Deterministic};
use crate::logs::{Disturbed, Logs};
use crate::provenance::Provenance;
use crate::rehearsal::best_walk;
use crate::training_error::TrainingError;
use gaitshift_sac::Policy;
use gaitshift_task::{
    ACTION_SIZE, EndReason, EnvironmentBatch, OBSERVATION_SIZE, scale_observation,
};
use std::time::Instant;

/// Orders the controllers of a run: by the first number, and where it is the same by the second.
pub(crate) type Rank = [f64; 2];

/// Rank of no controller: below that of every one.
pub(crate) const NONE_YET: Rank = [-1.0, 0.0];

/// Motions by which it is judged how many disturbances a controller bears.
const DISTURBED: usize = 256;

/// Rank of a controller. Where a run randomizes, the share of disturbed motions that stay up counts as much as all criteria
/// together, and what has not met the disturbances yet comes after all that has. Of controllers that are equally good, as all are that
/// meet every criterion, the one with the most even step times comes first.
pub(crate) fn rank(
    score: f64,
    criteria: usize,
    disturbed_survival: Option<f64>,
    step_time_asymmetries: impl Iterator<Item = f64>,
) -> Rank {
    let all = criteria as f64;
    let score = disturbed_survival.map_or(score, |share| score + all * (1.0 + share));
    [score, -step_time_asymmetries.fold(0.0, f64::max)]
}

impl Training {
    /// The policy that is judged and kept: where what was learned is mirrored, the mean of the actor and its mirror image.
    fn policy(&self) -> Policy {
        let policy = self.agent.policy();
        match self.agent.mirror() {
            Some(mirror) => policy.mean_with_mirror_image(mirror),
            None => policy,
        }
    }

    /// The controller so far, with where it comes from.
    pub(super) fn controller(&self) -> Controller {
        Controller {
            policy: self.policy(),
            body: self.experiment.body.clone(),
            task: self.experiment.task.clone(),
            provenance: Provenance {
                experiment: self.experiment.name.clone(),
                experiment_digest: self.experiment.digest().ok(),
                command: self.command.clone(),
                seed: self.experiment.seed,
                environment_steps: self.counters.step,
                updates: self.counters.updates,
                version: env!("CARGO_PKG_VERSION").to_owned(),
                edits: self.edits.clone(),
            },
        }
    }

    /// Judges the controller and keeps the best.
    pub(super) fn evaluate(
        &mut self,
        observer: &mut dyn Observer,
        logs: &mut Logs,
    ) -> Result<(), TrainingError> {
        let mut from = Instant::now();
        let mut controller = self.controller();
        let judgement = self.judge(&mut controller.policy)?;
        controller.write(&self.folder.evaluated(self.counters.step)?)?;
        self.keep_best_walk(&mut controller)?;
        let survival = self.disturbed_survival(&mut controller.policy)?;
        let asymmetries = judgement
            .rows
            .iter()
            .filter_map(|row| row.summary.step_time_asymmetry);
        let rank = rank(
            judgement.score(),
            judgement.checks.len(),
            survival,
            asymmetries,
        );
        let randomizes = self
            .experiment
            .curriculum
            .phases
            .iter()
            .any(|phase| phase.randomization.is_some());
        let c = &mut self.counters;
        let best = rank > c.best_rank;
        c.verdict = verdict(&judgement);
        c.criteria = judgement.checks.len();
        if best {
            c.best_rank = rank;
            c.best_step = c.step;
            c.best_met = judgement.met();
            controller.write(&self.folder.file("controller.safetensors"))?;
        }
        if (survival.is_some() || !randomizes)
            && judgement.accepted()
            && c.accepted_at_step.is_none()
        {
            c.accepted_at_step = Some(c.step);
            c.accepted_after_s = Some(c.elapsed_s);
            controller.write(&self.folder.file("controller-accepted.safetensors"))?;
        }
        let disturbed = Disturbed {
            survival,
            edits: c.disturbance_edits,
        };
        logs.evaluation(c.step, c.elapsed_s, disturbed, &judgement)?;
        observer.evaluated(&self.progress(), &judgement, best);
        lap(&mut from, &mut self.counters.parts.evaluating_s);
        Ok(())
    }

    /// The share of disturbed motions that stay up, once a step of a phase that randomizes has been taken: the same motions in every
    /// evaluation, under what the last such phase of the run draws at its end. What is judged undisturbed alone is at its best
    /// before it has met any disturbance.
    fn disturbed_survival(&self, policy: &mut Policy) -> Result<Option<f64>, TrainingError> {
        let e = &self.experiment;
        let taken = self.counters.step.saturating_sub(1);
        let last = e.curriculum.last_randomized(&e.task.reward);
        let Some(mut settings) = last.filter(|_| e.curriculum.randomizes_by(taken)) else {
            return Ok(None);
        };
        if let Some(drawn) = &mut settings.randomization {
            drawn.share = 1.0;
        }
        settings.command.hold_periods = 0;
        let body = self.batch.body().clone();
        let mut task = e.task.clone();
        let limit_s = &mut task.termination.time_limit_s;
        *limit_s = limit_s.min(e.criteria.duration_s);
        let mut motions = EnvironmentBatch::new(body, task, DISTURBED, 0, &settings);
        let mut observations = [0.0; DISTURBED * OBSERVATION_SIZE];
        let mut actions = [0.0; DISTURBED * ACTION_SIZE];
        let mut ended = [None; DISTURBED];
        while ended.iter().any(Option::is_none) {
            for (i, row) in observations.chunks_exact_mut(OBSERVATION_SIZE).enumerate() {
                let omega_v = motions.environment(i).omega_v;
                scale_observation(&motions.observation(i, omega_v), row);
            }
            policy.mean_action(&observations, &mut actions)?;
            for (i, action) in actions.chunks_exact(ACTION_SIZE).enumerate() {
                if ended[i].is_none() {
                    let command = [f64::from(action[0]), f64::from(action[1])];
                    ended[i] = motions.step(i, command, 0.0, &settings).0.ended;
                }
            }
        }
        let up = ended
            .iter()
            .filter(|&&ended| ended == Some(EndReason::TimeLimit));
        Ok(Some(up.count() as f64 / DISTURBED as f64))
    }

    fn judge(&self, policy: &mut Policy) -> Result<Judgement, TrainingError> {
        judge(
            self.batch.body(),
            &self.experiment.task,
            &self.experiment.criteria,
            &mut Deterministic(policy),
        )
        .map_err(|e| TrainingError::other(self.folder.path(), e.to_string()))
    }

    /// Keeps the controller if it is going to be rehearsed and walks best of all so far.
    fn keep_best_walk(&mut self, controller: &mut Controller) -> Result<(), TrainingError> {
        let c = &mut self.counters;
        let start = self.experiment.curriculum.rehearsal_start();
        if start.is_none_or(|start| c.step > start) {
            return Ok(());
        }
        let e = &self.experiment;
        let (score, _) = best_walk(
            &mut controller.policy,
            self.batch.body(),
            &e.task,
            &e.criteria,
        )
        .map_err(|e| TrainingError::other(self.folder.path(), e.to_string()))?;
        // Of two that are as good, the later one has been practised for longer.
        if score >= c.walking_score {
            c.walking_score = score;
            controller.write(&self.folder.file(WALK_FILE))?;
        }
        Ok(())
    }
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
