//! One update of Soft Actor-Critic (Haarnoja et al. 2018, "Soft Actor-Critic Algorithms and Applications", algorithm 1), in
//! its order: batch, targets y, critics, actor, temperature. The target networks follow already in the critics' step, not at
//! the end: nothing in between reads them.
//!
//! Its golden reference is `tools/golden/sac_update.py`, the same update in PyTorch; `tests/update.rs` compares the two,
//! gradients included. The losses themselves are in [`crate::losses`].
//!
//! The batch is cut into chunks of [`CHUNK`] rows, each with its own gradient of each network; gradients are then summed in
//! the order of the chunks. Neither the cut nor the order depends on the number of threads, so neither do the bits of
//! the result.

use std::mem::take;
use std::ops::Range;
use std::slice::from_mut;

use gaitshift_nn::adam::{self, AdamStep};
use gaitshift_nn::{Scalar, Step, Trained};

use crate::config::{CHUNK, Temperature};
use crate::error::SacError;
use crate::learner::{Learner, Noise, UpdateStats};
use crate::losses::{Sums, rows_of};
use crate::replay::{Batch, length};

/// Fills the rows of a chunk, given which rows of the whole batch they are.
pub(crate) type Fill<'a, T> = dyn Fn(Range<usize>, &mut Batch<T>) + Sync + 'a;

impl<T: Scalar> Learner<T> {
    /// One whole update with a given batch and noise.
    ///
    /// # Errors
    /// When a slice has the wrong length, or a loss or gradient is not finite (learning diverged). After the
    /// latter the networks are no longer usable.
    pub fn update(
        &mut self,
        batch: &Batch<T>,
        noise: Noise<'_, T>,
    ) -> Result<UpdateStats, SacError> {
        self.check(batch)?;
        self.update_from(&|chosen, rows| rows.copy_rows(batch, chosen), noise)
    }

    /// One whole update with a batch that the threads fill themselves, each the chunks that it works on.
    ///
    /// # Errors
    /// As [`Learner::update`].
    pub(crate) fn update_from(
        &mut self,
        fill: &Fill<'_, T>,
        noise: Noise<'_, T>,
    ) -> Result<UpdateStats, SacError> {
        let numbers = self.config.batch_size * self.action_size;
        length("noise.next", noise.next.len(), numbers)?;
        length("noise.current", noise.current.len(), numbers)?;
        self.updates += 1;
        self.stats.alpha = self.temperature.alpha;

        self.critic_losses(fill, noise.next);
        self.step_critics();
        if !self.actor_held {
            self.actor_losses(noise.current);
            self.step_actor();
            self.step_temperature();
        }
        self.check_finite()?;
        Ok(self.stats)
    }

    /// Batch, targets y = R + Γ (min Q'(s', a') − α ln π(a'|s')), and the gradient of mean (Q − y)² / 2 of each critic, chunk
    /// by chunk; a critic begins with a chunk as soon as its targets are known.
    fn critic_losses(&mut self, fill: &Fill<'_, T>, noise: &[T]) {
        let (rows, action_size) = (self.config.batch_size, self.action_size);
        let chunks = self.examples.len();
        let alpha = T::from_f64(self.temperature.alpha);
        let per_row = T::ONE / T::from_f64(rows as f64);
        let Trained {
            network: actor,
            transposed,
            ..
        } = &mut self.actor;
        let (actor, critics, targets) = (&*actor, &self.critics, &self.targets);
        // The actor's backward pass comes later in the update, so a thread may bring its copies up to date now.
        let stale = if take(&mut self.actor_stale) {
            from_mut(transposed)
        } else {
            &mut []
        };
        self.workers.two_stages(
            &mut self.scratches,
            (&mut self.examples, |scratch, chunk, examples| {
                let chosen = rows_of(chunk, rows);
                fill(chosen.clone(), &mut examples.batch);
                let noise = &noise[numbers(chosen, action_size)];
                scratch.target_pass(actor, targets, noise, alpha, examples);
            }),
            (stale, |_, _, transposed| actor.refresh(transposed)),
            (&mut self.critic_parts, |scratch, task, part, examples| {
                let (index, chunk) = (task / chunks, task % chunks);
                let examples = examples.wait_for(chunk);
                scratch.critic_pass(index, &critics[index], per_row, examples, part);
            }),
        );
        let sums = Sums::total(self.critic_parts.iter().map(|part| &part.sums));
        let per_row = 1.0 / rows as f64;
        self.stats.critic_loss = sums.critic_loss.map(|loss| loss * per_row);
        self.stats.mean_q = 0.5 * sums.q * per_row;
    }

    /// One step of Adam for each critic; in the same pass over memory its target follows by the share τ.
    fn step_critics(&mut self) {
        let rate = T::from_f64(self.config.tau);
        let [target_1, target_2] = &mut self.targets;
        let (parts_1, parts_2) = self.critic_parts.split_at(self.examples.len());
        self.stats.critic_gradient_norm = self.optimiser.step(
            &mut self.workers,
            self.critics.each_mut(),
            [parts_1, parts_2],
            Step {
                learning_rate: self.config.learning_rate,
                followers: [Some((rate, target_1)), Some((rate, target_2))],
            },
        );
        self.workers
            .for_each(&mut self.critics, |_, critic| critic.refresh());
    }

    /// The gradient of mean(α ln π(a|s) − min Q(s, a)) with a drawn anew, and of the rehearsal loss, chunk by chunk; the batch is that of the critics.
    fn actor_losses(&mut self, noise: &[T]) {
        if take(&mut self.actor_stale) {
            self.actor.refresh();
        }
        let (actor, critics) = (&self.actor, &self.critics);
        let (rows, action_size) = (self.config.batch_size, self.action_size);
        let alpha = T::from_f64(self.temperature.alpha);
        let per_row = T::ONE / T::from_f64(rows as f64);
        let rehearsed = &self.rehearsed;
        let rehearsed_rows = self.rows_to_rehearse();
        let weight = T::from_f64(self.rehearsal_weight / rehearsed_rows.max(1) as f64);
        let examples = &self.examples;
        let (parts, rehearsed_parts) = self.actor_parts.split_at_mut(examples.len());
        let rehearsed_parts = &mut rehearsed_parts[..rehearsed_rows.div_ceil(CHUNK)];
        self.workers.two_stages(
            &mut self.scratches,
            (&mut self.actor_losses, |scratch, chunk, loss| {
                let noise = &noise[numbers(rows_of(chunk, rows), action_size)];
                let (actor, batch) = (&actor.network, &examples[chunk].batch);
                scratch.actor_loss(actor, critics, batch, noise, alpha, per_row, loss);
            }),
            (&mut *rehearsed_parts, |scratch, chunk, part| {
                let chosen = rows_of(chunk, rehearsed_rows);
                scratch.rehearsal_pass(actor, rehearsed, action_size, chosen, weight, part);
            }),
            (parts, |scratch, chunk, part, losses| {
                let (batch, loss) = (&examples[chunk].batch, losses.wait_for(chunk));
                scratch.actor_back(actor, batch, loss, part);
            }),
        );
        let sums = Sums::total(
            self.actor_losses
                .iter()
                .map(|loss| &loss.sums)
                .chain(rehearsed_parts.iter().map(|part| &part.sums)),
        );
        let per_row = 1.0 / rows as f64;
        self.stats.actor_loss = sums.actor_loss * per_row;
        self.stats.rehearsal_loss = sums.rehearsal_loss / rehearsed_rows.max(1) as f64;
        self.stats.entropy = -sums.log_prob * per_row;
    }

    /// One step of Adam for the actor.
    fn step_actor(&mut self) {
        let parts = self.examples.len() + self.rehearsed_chunks();
        [self.stats.actor_gradient_norm] = self.optimiser.step(
            &mut self.workers,
            [&mut self.actor],
            [&self.actor_parts[..parts]],
            Step {
                learning_rate: self.config.learning_rate,
                followers: [None],
            },
        );
        self.actor_stale = true;
    }

    /// Pairs that this update rehearses.
    fn rows_to_rehearse(&self) -> usize {
        if self.rehearsal_weight > 0.0 {
            self.rehearsed_rows()
        } else {
            0
        }
    }

    /// Their chunks.
    fn rehearsed_chunks(&self) -> usize {
        self.rows_to_rehearse().div_ceil(CHUNK)
    }

    /// Gradient of −ln α · mean(ln π + target entropy) in ln α, from the last actor pass.
    pub fn temperature_gradient(&self) -> Option<f64> {
        match self.config.temperature {
            Temperature::Fixed { .. } => None,
            Temperature::Auto { target_entropy, .. } => {
                Some(self.stats.entropy - target_entropy.unwrap_or(-(self.action_size as f64)))
            }
        }
    }

    fn step_temperature(&mut self) {
        let Temperature::Auto { learning_rate, .. } = self.config.temperature else {
            return;
        };
        let Some(gradient) = self.temperature_gradient() else {
            return;
        };
        let state = &mut self.temperature;
        state.steps += 1;
        let (mut log_alpha, mut first, mut second) = (
            [state.log_alpha],
            [state.first_moment],
            [state.second_moment],
        );
        let step = AdamStep::new(state.steps, learning_rate);
        adam::descend(step, &[gradient], &mut log_alpha, &mut first, &mut second);
        // Beyond that α would be 0, from which nothing comes back.
        [state.log_alpha] = log_alpha.map(|log_alpha| log_alpha.max(f64::MIN_POSITIVE.ln()));
        [state.first_moment] = first;
        [state.second_moment] = second;
        state.alpha = state.log_alpha.exp();
    }

    /// Losses of the critics and their gradients, at the current parameters, for a batch that [`Learner::update`] would
    /// take.
    // For the tests, which compare gradients with finite differences.
    #[doc(hidden)]
    pub fn critic_gradients(&mut self, batch: &Batch<T>, noise: &[T]) {
        self.critic_losses(&|chosen, rows| rows.copy_rows(batch, chosen), noise);
        let parts = self.critic_parts.split_at(self.examples.len());
        self.stats.critic_gradient_norm = self.optimiser.sum(
            &mut self.workers,
            self.critics.each_mut(),
            [parts.0, parts.1],
        );
    }

    /// Loss of the actor and its gradient, at the current parameters, for a batch that [`Learner::update`] would take.
    // For the tests, which compare gradients with finite differences.
    #[doc(hidden)]
    pub fn actor_gradient(&mut self, batch: &Batch<T>, noise: &[T]) {
        for (chunk, examples) in self.examples.iter_mut().enumerate() {
            let chosen = rows_of(chunk, self.config.batch_size);
            examples.batch.copy_rows(batch, chosen);
        }
        self.actor_losses(noise);
        let parts = self.examples.len() + self.rehearsed_chunks();
        [self.stats.actor_gradient_norm] = self.optimiser.sum(
            &mut self.workers,
            [&mut self.actor],
            [&self.actor_parts[..parts]],
        );
    }

    fn check(&self, batch: &Batch<T>) -> Result<(), SacError> {
        let rows = batch.rows();
        length("batch.rewards", rows, self.config.batch_size)?;
        length(
            "batch.observations",
            batch.observations.len(),
            rows * self.observation_size,
        )?;
        length(
            "batch.next_observations",
            batch.next_observations.len(),
            rows * self.observation_size,
        )?;
        length(
            "batch.actions",
            batch.actions.len(),
            rows * self.action_size,
        )?;
        length("batch.discounts", batch.discounts.len(), rows)
    }

    pub(crate) fn check_finite(&self) -> Result<(), SacError> {
        let stats = &self.stats;
        for (what, value) in [
            ("the loss of critic 1", stats.critic_loss[0]),
            ("the loss of critic 2", stats.critic_loss[1]),
            ("the gradient of critic 1", stats.critic_gradient_norm[0]),
            ("the gradient of critic 2", stats.critic_gradient_norm[1]),
            ("the actor's loss", stats.actor_loss),
            ("the actor's gradient", stats.actor_gradient_norm),
            ("the temperature", self.temperature.alpha),
        ] {
            if !value.is_finite() {
                return Err(SacError::Diverged {
                    update: self.updates,
                    what,
                    value,
                });
            }
        }
        Ok(())
    }
}

/// Where the actions of some rows lie.
fn numbers(rows: Range<usize>, action_size: usize) -> Range<usize> {
    rows.start * action_size..rows.end * action_size
}
