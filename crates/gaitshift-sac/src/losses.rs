//! The losses of Soft Actor-Critic on one chunk of a batch, and their gradients.
//!
//! Each works in the scratch of a thread, which stays in the cache of that core, and leaves its own gradient of a network
//! and its own sums; [`crate::update`] adds them up in the order of the chunks.

use std::cmp::Ordering;
use std::ops::Range;

use gaitshift_nn::{Activations, Buffer, Deltas, Mlp, Scalar, Trained, Workers};

use crate::config::CHUNK;
use crate::gaussian;
use crate::rehearsal::{Rehearsed, imitate};
use crate::replay::Batch;

/// One chunk of the batch and what the critics are to learn from it.
#[derive(Debug)]
pub(crate) struct Examples<T> {
    pub batch: Batch<T>,
    pub targets: Vec<T>,
}

impl<T: Scalar> Examples<T> {
    pub fn new(rows: usize, observation_size: usize, action_size: usize) -> Self {
        Self {
            batch: Batch::zeros(rows, observation_size, action_size),
            targets: vec![T::ZERO; rows],
        }
    }
}

/// What the actor's loss on one chunk leaves for the actor's backward pass.
#[derive(Debug)]
pub(crate) struct ActorLoss<T> {
    pub actor: Activations<T>,
    pub d_actor: Vec<T>,
    pub sums: Sums,
}

/// The gradient of one network's loss on one chunk.
#[derive(Debug)]
pub(crate) struct Part<T> {
    pub gradient: Buffer<T>,
    pub sums: Sums,
}

impl<T> AsRef<[T]> for Part<T> {
    fn as_ref(&self) -> &[T] {
        &self.gradient
    }
}

impl<T: Scalar> Part<T> {
    pub fn new(network: &Mlp<T>) -> Self {
        Self {
            gradient: network.zeros_like(),
            sums: Sums::default(),
        }
    }
}

/// Sums over the rows of a chunk; each task adds up its own and leaves the others 0.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    pub critic_loss: [f64; 2],
    pub q: f64,
    pub actor_loss: f64,
    pub rehearsal_loss: f64,
    pub log_prob: f64,
}

impl Sums {
    /// Those of all chunks, in their order.
    pub fn total<'a>(sums: impl Iterator<Item = &'a Self>) -> Self {
        let mut total = Self::default();
        for sums in sums {
            total.critic_loss[0] += sums.critic_loss[0];
            total.critic_loss[1] += sums.critic_loss[1];
            total.q += sums.q;
            total.actor_loss += sums.actor_loss;
            total.rehearsal_loss += sums.rehearsal_loss;
            total.log_prob += sums.log_prob;
        }
        total
    }
}

/// The rows of so many that belong to a chunk.
pub(crate) fn rows_of(chunk: usize, rows: usize) -> Range<usize> {
    chunk * CHUNK..((chunk + 1) * CHUNK).min(rows)
}

/// Scratch of one thread: the same memory for every chunk it works on, so that its core's cache holds it.
#[derive(Debug)]
pub(crate) struct Scratch<T> {
    pub actor: Activations<T>,
    pub actor_deltas: Deltas<T>,
    pub critics: [Activations<T>; 2],
    pub critic_deltas: Deltas<T>,
    /// Observation, action.
    pub critic_input: Vec<T>,
    pub actions: Vec<T>,
    pub log_probs: Vec<T>,
    pub d_critic: Vec<T>,
    pub d_log_prob: Vec<T>,
    pub d_action: Vec<T>,
    pub d_actor: Vec<T>,
    pub selected: [Vec<usize>; 2],
}

/// Scratch for each of the threads.
pub(crate) fn scratches<T: Scalar>(
    workers: &Workers,
    actor: &Mlp<T>,
    critic: &Mlp<T>,
) -> Vec<Scratch<T>> {
    (0..workers.threads())
        .map(|_| Scratch::new(actor, critic))
        .collect()
}

impl<T: Scalar> ActorLoss<T> {
    pub fn new(actor: &Mlp<T>) -> Self {
        Self {
            actor: actor.activations(CHUNK),
            d_actor: vec![T::ZERO; CHUNK * actor.shape().outputs],
            sums: Sums::default(),
        }
    }
}

impl<T: Scalar> Scratch<T> {
    fn new(actor: &Mlp<T>, critic: &Mlp<T>) -> Self {
        let width = critic.shape().inputs;
        let action_size = width - actor.shape().inputs;
        let zeros = |count: usize| vec![T::ZERO; count];
        Self {
            actor: actor.activations(CHUNK),
            actor_deltas: actor.deltas(CHUNK),
            critics: [critic.activations(CHUNK), critic.activations(CHUNK)],
            critic_deltas: critic.deltas(CHUNK),
            critic_input: zeros(CHUNK * width),
            actions: zeros(CHUNK * action_size),
            log_probs: zeros(CHUNK),
            d_critic: zeros(CHUNK),
            d_log_prob: zeros(CHUNK),
            d_action: zeros(CHUNK * action_size),
            d_actor: zeros(CHUNK * 2 * action_size),
            selected: [Vec::with_capacity(CHUNK), Vec::with_capacity(CHUNK)],
        }
    }

    /// Targets y = R + Γ (min Q'(s', a') − α ln π(a'|s')).
    pub fn target_pass(
        &mut self,
        actor: &Mlp<T>,
        targets: &[Mlp<T>; 2],
        noise: &[T],
        alpha: T,
        examples: &mut Examples<T>,
    ) {
        let batch = &examples.batch;
        let rows = batch.rows();
        let next = &batch.next_observations;
        let (observation_size, action_size) = (next.len() / rows, noise.len() / rows);
        actor.forward(rows, next, observation_size, &mut self.actor);
        gaussian::sample(
            action_size,
            &self.actor.out[..rows * 2 * action_size],
            noise,
            &mut self.actions,
            &mut self.log_probs,
        );
        join(
            observation_size,
            next,
            action_size,
            &self.actions,
            &mut self.critic_input,
        );
        let width = observation_size + action_size;
        for (target, activations) in targets.iter().zip(&mut self.critics) {
            target.forward(rows, &self.critic_input, width, activations);
        }
        for row in 0..rows {
            let value = smaller(self.critics[0].out[row], self.critics[1].out[row])
                - alpha * self.log_probs[row];
            // A terminated row must not see a value that is not finite either.
            let discount = batch.discounts[row];
            let future = if discount == T::ZERO {
                T::ZERO
            } else {
                discount * value
            };
            examples.targets[row] = batch.rewards[row] + future;
        }
    }

    /// Loss (Q − y)² / 2 of one critic, gradient.
    pub fn critic_pass(
        &mut self,
        index: usize,
        critic: &Trained<T>,
        per_row: T,
        examples: &Examples<T>,
        result: &mut Part<T>,
    ) {
        let rows = examples.batch.rows();
        let (observations, actions) = (&examples.batch.observations, &examples.batch.actions);
        let (observation_size, action_size) = (observations.len() / rows, actions.len() / rows);
        join(
            observation_size,
            observations,
            action_size,
            actions,
            &mut self.critic_input,
        );
        let width = observation_size + action_size;
        let network = &critic.network;
        let activations = &mut self.critics[index];
        network.forward(rows, &self.critic_input, width, activations);
        let mut sums = Sums::default();
        for row in 0..rows {
            let error = activations.out[row] - examples.targets[row];
            self.d_critic[row] = error * per_row;
            sums.critic_loss[index] += 0.5 * (error * error).to_f64();
            sums.q += activations.out[row].to_f64();
        }
        network.backward(
            &critic.transposed,
            rows,
            &self.critic_input,
            width,
            activations,
            &self.d_critic,
            &mut self.critic_deltas,
            &mut result.gradient,
        );
        result.sums = sums;
    }

    /// Loss α ln π(a|s) − min Q(s, a) with a drawn anew, and the derivative in the
    /// actor's outputs.
    #[allow(clippy::too_many_arguments)]
    pub fn actor_loss(
        &mut self,
        actor: &Mlp<T>,
        critics: &[Trained<T>; 2],
        batch: &Batch<T>,
        noise: &[T],
        alpha: T,
        per_row: T,
        result: &mut ActorLoss<T>,
    ) {
        let rows = batch.rows();
        let observations = &batch.observations;
        let (observation_size, action_size) = (observations.len() / rows, noise.len() / rows);
        let width = observation_size + action_size;
        let outputs = 2 * action_size;

        actor.forward(rows, observations, observation_size, &mut result.actor);
        let out = &result.actor.out[..rows * outputs];
        gaussian::sample(
            action_size,
            out,
            noise,
            &mut self.actions,
            &mut self.log_probs,
        );
        join(
            observation_size,
            observations,
            action_size,
            &self.actions,
            &mut self.critic_input,
        );
        for (critic, activations) in critics.iter().zip(&mut self.critics) {
            critic
                .network
                .forward(rows, &self.critic_input, width, activations);
        }

        let mut sums = Sums::default();
        for selected in &mut self.selected {
            selected.clear();
        }
        for row in 0..rows {
            let (q_1, q_2) = (self.critics[0].out[row], self.critics[1].out[row]);
            // Only the smaller critic passes a derivative on.
            self.selected[usize::from(q_2 < q_1)].push(row);
            self.d_log_prob[row] = alpha * per_row;
            sums.actor_loss += (alpha * self.log_probs[row] - smaller(q_1, q_2)).to_f64();
            sums.log_prob += self.log_probs[row].to_f64();
        }
        for (index, critic) in critics.iter().enumerate() {
            critic.network.input_gradient(
                &critic.transposed,
                &self.selected[index],
                action_size,
                &self.critics[index],
                &mut self.critic_deltas,
                &mut self.d_action,
            );
        }
        for d_action in &mut self.d_action[..rows * action_size] {
            *d_action = -(*d_action * per_row);
        }
        gaussian::sample_back(
            action_size,
            out,
            noise,
            &self.actions,
            &self.d_log_prob,
            &self.d_action,
            &mut result.d_actor[..rows * outputs],
        );
        result.sums = sums;
    }

    /// The gradient that belongs to [`Scratch::actor_loss`].
    pub fn actor_back(
        &mut self,
        actor: &Trained<T>,
        batch: &Batch<T>,
        loss: &ActorLoss<T>,
        result: &mut Part<T>,
    ) {
        let (rows, observations) = (batch.rows(), &batch.observations);
        actor.network.backward(
            &actor.transposed,
            rows,
            observations,
            observations.len() / rows,
            &loss.actor,
            &loss.d_actor,
            &mut self.actor_deltas,
            &mut result.gradient,
        );
    }

    /// The chosen pairs: loss weight · Σ |μ(s) − a|², gradient.
    pub fn rehearsal_pass(
        &mut self,
        actor: &Trained<T>,
        rehearsed: &Rehearsed<T>,
        action_size: usize,
        chosen: Range<usize>,
        weight: T,
        result: &mut Part<T>,
    ) {
        let rows = chosen.len();
        let observation_size = actor.network.shape().inputs;
        let places = |size: usize| chosen.start * size..chosen.end * size;
        let observations = &rehearsed.observations[places(observation_size)];
        let actions = &rehearsed.actions[places(action_size)];
        let network = &actor.network;
        network.forward(rows, observations, observation_size, &mut self.actor);
        let outputs = rows * 2 * action_size;
        let sum = imitate(
            action_size,
            &self.actor.out[..outputs],
            actions,
            weight,
            &mut self.d_actor[..outputs],
        );
        network.backward(
            &actor.transposed,
            rows,
            observations,
            observation_size,
            &self.actor,
            &self.d_actor,
            &mut self.actor_deltas,
            &mut result.gradient,
        );
        result.sums = Sums {
            rehearsal_loss: sum.to_f64(),
            ..Sums::default()
        };
    }
}

#[inline(always)]
fn smaller<T: Scalar>(a: T, b: T) -> T {
    // NaN in either is passed on, so that it is noticed.
    match a.partial_cmp(&b) {
        Some(Ordering::Greater) => b,
        Some(_) => a,
        None => a + b,
    }
}

/// Rows of observation and action side by side.
fn join<T: Scalar>(
    observation_size: usize,
    observations: &[T],
    action_size: usize,
    actions: &[T],
    out: &mut [T],
) {
    for ((observation, action), out) in observations
        .chunks_exact(observation_size)
        .zip(actions.chunks_exact(action_size))
        .zip(out.chunks_exact_mut(observation_size + action_size))
    {
        let (to_observation, to_action) = out.split_at_mut(observation_size);
        copy_short(observation, to_observation);
        copy_short(action, to_action);
    }
}

/// Copies a few numbers without a call: eight at a time, the last eight overlapping those before.
#[inline(always)]
fn copy_short<T: Scalar>(from: &[T], to: &mut [T]) {
    const EIGHT: usize = 8;
    if let Some(last) = from.len().checked_sub(EIGHT) {
        let mut copy = |place: usize| {
            to[place..][..EIGHT].copy_from_slice(&from[place..][..EIGHT]);
        };
        (0..last).step_by(EIGHT).for_each(&mut copy);
        copy(last);
    } else {
        for (to, &from) in to.iter_mut().zip(from) {
            *to = from;
        }
    }
}
