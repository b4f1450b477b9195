//! One update of Soft Actor-Critic: critics, actor, temperature, targets.
//!
//! The batch is cut into chunks of [`CHUNK`] rows. A chunk runs its whole forward and backward pass in the scratch of
//! its thread, which stays in the cache of that core, and leaves its own gradient; gradients are
//! then summed in the order of the chunks. Neither the cut nor the order depends on the number of
//! threads, so neither do the bits of the result.

use std::cmp::Ordering;

use serde::{Deserialize, Serialize};

use crate::adam::{self, AdamStep};
use crate::config::{SacConfig, Temperature};
use crate::error::SacError;
use crate::gaussian;
use crate::lanes::{LANES, Lanes};
use crate::mirror::{Mirror, reflect};
use crate::network::{Activations, Deltas, Mlp, MlpShape, Transposed};
use crate::real::{Buffer, Real, wide};
use crate::rehearsal::{Rehearsed, imitate};
use crate::replay::{Batch, length};
use crate::workers::{Disjoint, Workers};

/// Rows that are worked on together.
pub const CHUNK: usize = 64;
/// Parameters that an element-wise task takes at a time: all its operands fit the first-level cache.
const RANGE: usize = 1024;

/// A network with what Adam remembers of it.
#[derive(Clone, Debug)]
pub struct Trained<T> {
    /// The network.
    pub network: Mlp<T>,
    /// Weights in the order of the backward pass.
    pub(crate) transposed: Transposed<T>,
    /// Gradient of the last update, before clipping.
    pub(crate) gradient: Buffer<T>,
    pub(crate) first_moment: Buffer<T>,
    pub(crate) second_moment: Buffer<T>,
    /// Adam steps made.
    pub(crate) steps: u64,
}

impl<T: Real> Trained<T> {
    fn new(network: Mlp<T>) -> Self {
        Self {
            transposed: network.transposed(),
            gradient: network.zeros_like(),
            first_moment: network.zeros_like(),
            second_moment: network.zeros_like(),
            steps: 0,
            network,
        }
    }

    /// Gradient of the last update, before clipping, as named tensors.
    pub fn gradient(&self) -> Vec<crate::network::NamedTensor<T>> {
        self.network.tensors_of(&self.gradient)
    }

    /// Recomputes the copies that the backward pass reads, after the parameters changed from outside.
    pub fn refresh(&mut self) {
        self.network.refresh(&mut self.transposed);
    }
}

/// The temperature ln α and what its Adam remembers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TemperatureState {
    /// α.
    pub alpha: f64,
    /// ln α; follows `alpha` where the temperature is learned.
    pub log_alpha: f64,
    /// First moment of Adam.
    pub first_moment: f64,
    /// Second moment of Adam.
    pub second_moment: f64,
    /// Adam steps made.
    pub steps: u64,
}

/// What an update saw. Losses are means over the batch before the step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct UpdateStats {
    /// mean (Q − y)² / 2 of each critic.
    pub critic_loss: [f64; 2],
    /// Mean of both critics over the batch.
    pub mean_q: f64,
    /// Mean of the targets y.
    pub mean_target: f64,
    /// mean (α c ln π − min Q), of the last update in which the actor learned, as all below.
    pub actor_loss: f64,
    /// mean |μ(s) − Ψa(μ(Ψo(s)))|², unweighted; 0 when no mirror loss is asked for.
    pub mirror_loss: f64,
    /// mean |μ(s) − a|² over the rehearsed pairs, unweighted; 0 when none are rehearsed.
    #[serde(default)]
    pub rehearsal_loss: f64,
    /// −mean ln π, in nats.
    pub entropy: f64,
    /// α that this update used.
    pub alpha: f64,
    /// Norm of each critic's gradient, before clipping.
    pub critic_gradient_norm: [f64; 2],
    /// Norm of the actor's gradient, before clipping.
    pub actor_gradient_norm: f64,
    /// Whether the actor learned in this update.
    pub actor_updated: bool,
}

/// Scratch of one thread: the same memory for every chunk it works on, so that its core's cache holds it.
#[derive(Debug)]
struct Scratch<T> {
    actor: Activations<T>,
    actor_deltas: Deltas<T>,
    critics: [Activations<T>; 2],
    critic_deltas: Deltas<T>,
    /// Observations and, where the mirror loss needs them, their mirror images below.
    actor_input: Vec<T>,
    /// Observation, action.
    critic_input: Vec<T>,
    actions: Vec<T>,
    log_probs: Vec<T>,
    targets: Vec<T>,
    d_critic: Vec<T>,
    d_log_prob: Vec<T>,
    d_action: Vec<T>,
    d_actor: Vec<T>,
    selected: [Vec<usize>; 2],
}

/// Results of one chunk.
#[derive(Debug)]
struct Chunk<T> {
    critic_gradients: [Buffer<T>; 2],
    actor_gradient: Buffer<T>,
    sums: Sums,
}

/// Sums over the rows of a chunk.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    critic_loss: [f64; 2],
    q: f64,
    target: f64,
    actor_loss: f64,
    mirror_loss: f64,
    rehearsal_loss: f64,
    log_prob: f64,
}

/// Standard normal numbers of an update.
#[derive(Clone, Copy, Debug)]
pub struct Noise<'a, T> {
    /// Rows × action size, for the actions at the next observations.
    pub next: &'a [T],
    /// Rows × action size, for the actions at the observations.
    pub current: &'a [T],
}

/// Networks, targets, optimiser and temperature; [`crate::Agent`] adds random numbers, replay and files.
#[derive(Debug)]
pub struct Learner<T> {
    pub(crate) config: SacConfig,
    pub(crate) observation_size: usize,
    pub(crate) action_size: usize,
    pub(crate) mirror: Option<Mirror>,
    /// The policy network.
    pub actor: Trained<T>,
    /// Both critics.
    pub critics: [Trained<T>; 2],
    /// Their targets.
    pub targets: [Mlp<T>; 2],
    /// Averaged actor, where asked for.
    pub average: Option<Mlp<T>>,
    pub(crate) temperature: TemperatureState,
    pub(crate) updates: u64,
    pub(crate) stats: UpdateStats,
    /// Chunks of the batch, behind them those of the rehearsed pairs.
    chunks: Vec<Chunk<T>>,
    /// One for each thread.
    scratches: Vec<Scratch<T>>,
    /// The actor moved since its copies for the backward pass were made.
    actor_stale: bool,
    /// Pairs that the next update rehearses, at most `rehearsal_rows`; [`crate::Agent`] draws them.
    pub rehearsed: Rehearsed<T>,
    /// Sum of squares of each range of the gradients.
    squares: Vec<f64>,
    workers: Workers,
}

impl<T: Real> Learner<T> {
    /// A learner with the given networks; targets and average start as copies.
    ///
    /// # Errors
    /// When a setting is outside its range, or needs a mirror and none is given, or the mirror is none.
    pub fn new(
        config: SacConfig,
        observation_size: usize,
        action_size: usize,
        mirror: Option<Mirror>,
        rng: &mut rand_xoshiro::Xoshiro256PlusPlus,
    ) -> Result<Self, SacError> {
        config.validate()?;
        let sizes = 1..=1usize << 16;
        crate::config::require(
            sizes.contains(&observation_size),
            "observation_size",
            &observation_size,
            "from 1 to 65536",
        )?;
        crate::config::require(
            sizes.contains(&action_size),
            "action_size",
            &action_size,
            "from 1 to 65536",
        )?;
        match &mirror {
            Some(mirror) => mirror.validate(observation_size, action_size)?,
            None if config.mirror_loss_weight > 0.0 => {
                return Err(SacError::NoMirror {
                    key: "mirror_loss_weight",
                });
            }
            None if config.mirrored_fraction > 0.0 => {
                return Err(SacError::NoMirror {
                    key: "mirrored_fraction",
                });
            }
            None => {}
        }
        let actor = Mlp::random(actor_shape(&config, observation_size, action_size), rng);
        let critic_shape = MlpShape {
            inputs: observation_size + action_size,
            hidden: config.critic_hidden.clone(),
            outputs: 1,
            layer_norm: config.critic_layer_norm,
        };
        let critics = [0, 1].map(|_| Trained::new(Mlp::random(critic_shape.clone(), rng)));
        let targets = [critics[0].network.clone(), critics[1].network.clone()];
        let average = (config.actor_average_decay > 0.0).then(|| actor.clone());
        let actor = Trained::new(actor);
        let alpha = match config.temperature {
            Temperature::Fixed { alpha } => alpha,
            Temperature::Auto { initial, .. } => initial,
        };
        let temperature = TemperatureState {
            alpha,
            log_alpha: alpha.max(f64::MIN_POSITIVE).ln(),
            first_moment: 0.0,
            second_moment: 0.0,
            steps: 0,
        };
        let rehearsal_rows = if config.rehearsal_weight > 0.0 {
            config.rehearsal_rows
        } else {
            0
        };
        let chunks = (0..config.batch_size.div_ceil(CHUNK) + rehearsal_rows.div_ceil(CHUNK))
            .map(|_| Chunk {
                critic_gradients: [
                    critics[0].network.zeros_like(),
                    critics[1].network.zeros_like(),
                ],
                actor_gradient: actor.network.zeros_like(),
                sums: Sums::default(),
            })
            .collect();
        let ranges = (2 * critics[0].gradient.len().div_ceil(RANGE))
            .max(actor.gradient.len().div_ceil(RANGE));
        let workers = Workers::new(config.threads);
        let scratches = scratches(&workers, &actor.network, &critics[0].network, &config);
        Ok(Self {
            config,
            observation_size,
            action_size,
            mirror,
            actor,
            critics,
            targets,
            average,
            temperature,
            updates: 0,
            stats: UpdateStats::default(),
            rehearsed: Rehearsed::default(),
            chunks,
            scratches,
            actor_stale: false,
            squares: vec![0.0; ranges],
            workers,
        })
    }

    /// The temperature.
    pub fn temperature(&self) -> TemperatureState {
        self.temperature
    }

    /// Settings.
    pub fn config(&self) -> &SacConfig {
        &self.config
    }

    /// What the last update saw.
    pub fn stats(&self) -> UpdateStats {
        self.stats
    }

    /// Uses another number of threads; the results stay the same.
    ///
    /// # Errors
    /// When it is not from 1 to 256.
    pub fn set_threads(&mut self, threads: usize) -> Result<(), SacError> {
        let config = SacConfig {
            threads,
            ..self.config.clone()
        };
        config.validate()?;
        self.config = config;
        self.workers = Workers::new(threads);
        let (actor, critic) = (&self.actor.network, &self.critics[0].network);
        self.scratches = scratches(&self.workers, actor, critic, &self.config);
        Ok(())
    }

    pub(crate) fn workers(&mut self) -> &mut Workers {
        &mut self.workers
    }

    /// Updates made.
    pub fn updates(&self) -> u64 {
        self.updates
    }

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
        self.check(batch, noise)?;
        self.updates += 1;
        self.stats.alpha = self.temperature.alpha;
        self.stats.actor_updated = false;
        // Clipping needs the norm of the whole gradient before the first parameter moves; otherwise each range of
        // parameters is summed up and moved while the cache holds it.
        let clipping = self.config.max_grad_norm.is_some();
        let chunks = self.critic_chunks(batch, noise.next);
        if clipping {
            self.finish_critics(Some(chunks), false);
        }
        self.finish_critics((!clipping).then_some(chunks), true);
        if self
            .updates
            .is_multiple_of(u64::from(self.config.actor_every))
        {
            let chunks = self.actor_chunks(batch, noise.current);
            if clipping {
                self.finish_actor(Some(chunks), false);
            }
            self.finish_actor((!clipping).then_some(chunks), true);
            self.step_temperature();
            self.stats.actor_updated = true;
        }
        self.check_finite()?;
        Ok(self.stats)
    }

    fn check(&self, batch: &Batch<T>, noise: Noise<'_, T>) -> Result<(), SacError> {
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
        length("batch.discounts", batch.discounts.len(), rows)?;
        length("batch.entropy_scales", batch.entropy_scales.len(), rows)?;
        length(
            "batch.next_entropy_scales",
            batch.next_entropy_scales.len(),
            rows,
        )?;
        length("noise.next", noise.next.len(), rows * self.action_size)?;
        length(
            "noise.current",
            noise.current.len(),
            rows * self.action_size,
        )
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

    /// Losses of the critics and their gradients, at the current parameters.
    pub fn critic_gradients(&mut self, batch: &Batch<T>, noise: &[T]) {
        let chunks = self.critic_chunks(batch, noise);
        self.finish_critics(Some(chunks), false);
    }

    /// Runs the chunks and gives how many they are.
    fn critic_chunks(&mut self, batch: &Batch<T>, noise: &[T]) -> usize {
        let Trained {
            network: actor,
            transposed,
            ..
        } = &mut self.actor;
        let (actor, critics, targets) = (&*actor, &self.critics, &self.targets);
        let alpha = T::from_f64(self.temperature.alpha);
        let rows = batch.rows();
        let count = rows.div_ceil(CHUNK);
        // The actor's backward pass comes later in the update, so a thread may bring its copies up to date now.
        let stale = std::mem::take(&mut self.actor_stale);
        let transposed = Disjoint::new(std::slice::from_mut(transposed));
        let chunks = Disjoint::new(&mut self.chunks[..count]);
        let scratches = Disjoint::new(&mut self.scratches);
        self.workers
            .run_on(count + usize::from(stale), &|thread, index| {
                if index == count {
                    // SAFETY: one task only does this.
                    actor.refresh(unsafe { &mut transposed.range(0, 1)[0] });
                    return;
                }
                // SAFETY: each chunk is taken once, and a thread does one task at a time.
                let (chunk, scratch) = unsafe {
                    (
                        &mut chunks.range(index, index + 1)[0],
                        &mut scratches.range(thread, thread + 1)[0],
                    )
                };
                let first = index * CHUNK;
                let last = (first + CHUNK).min(rows);
                scratch.critic_pass(
                    actor, critics, targets, batch, noise, first, last, alpha, chunk,
                );
            });
        let sums = sums(&self.chunks[..count]);
        let per_row = 1.0 / rows as f64;
        self.stats.critic_loss = sums.critic_loss.map(|loss| loss * per_row);
        self.stats.mean_q = 0.5 * sums.q * per_row;
        self.stats.mean_target = sums.target * per_row;
        count
    }

    /// Sums the gradients of so many chunks, or steps along the gradient, or both.
    fn finish_critics(&mut self, chunks: Option<usize>, step: bool) {
        let rate = T::from_f64(self.config.tau);
        let [first, second] = &mut self.targets;
        let norms = finish(
            &mut self.workers,
            &mut self.critics,
            &mut self.squares,
            chunks.map(|count| Sum {
                chunks: &self.chunks[..count],
                of: |chunk, network| &chunk.critic_gradients[network],
            }),
            step.then(|| Step {
                scales: self
                    .stats
                    .critic_gradient_norm
                    .map(|norm| clip(self.config.max_grad_norm, norm)),
                learning_rate: self.config.learning_rate,
                followers: [Some((rate, first)), Some((rate, second))],
            }),
        );
        if chunks.is_some() {
            self.stats.critic_gradient_norm = norms;
        }
        if step {
            self.workers
                .for_each(&mut self.critics, |_, critic| critic.refresh());
        }
    }

    /// Loss of the actor and its gradient, at the current parameters.
    pub fn actor_gradient(&mut self, batch: &Batch<T>, noise: &[T]) {
        let chunks = self.actor_chunks(batch, noise);
        self.finish_actor(Some(chunks), false);
    }

    /// Runs the chunks and gives how many they are.
    fn actor_chunks(&mut self, batch: &Batch<T>, noise: &[T]) -> usize {
        if std::mem::take(&mut self.actor_stale) {
            self.actor.refresh();
        }
        let (actor, critics) = (&self.actor, &self.critics);
        let alpha = T::from_f64(self.temperature.alpha);
        let rows = batch.rows();
        let mirror = self
            .mirror
            .as_ref()
            .filter(|_| self.config.mirror_loss_weight > 0.0)
            .map(|mirror| (mirror, T::from_f64(self.config.mirror_loss_weight)));
        let (rehearsed, action_size) = (&self.rehearsed, self.action_size);
        let rehearsed_rows = rehearsed.actions.len() / action_size;
        let weight = T::from_f64(self.config.rehearsal_weight / rehearsed_rows.max(1) as f64);
        let batch_chunks = rows.div_ceil(CHUNK);
        let count = batch_chunks + rehearsed_rows.div_ceil(CHUNK);
        let chunks = Disjoint::new(&mut self.chunks[..count]);
        let scratches = Disjoint::new(&mut self.scratches);
        self.workers.run_on(count, &|thread, index| {
            // SAFETY: each chunk is taken once, and a thread does one task at a time.
            let (chunk, scratch) = unsafe {
                (
                    &mut chunks.range(index, index + 1)[0],
                    &mut scratches.range(thread, thread + 1)[0],
                )
            };
            if let Some(index) = index.checked_sub(batch_chunks) {
                let first = index * CHUNK;
                let last = (first + CHUNK).min(rehearsed_rows);
                scratch.rehearsal_pass(actor, rehearsed, action_size, first, last, weight, chunk);
            } else {
                let first = index * CHUNK;
                let last = (first + CHUNK).min(rows);
                scratch.actor_pass(
                    actor, critics, mirror, batch, noise, first, last, alpha, chunk,
                );
            }
        });
        let sums = sums(&self.chunks[..count]);
        let per_row = 1.0 / rows as f64;
        self.stats.actor_loss = sums.actor_loss * per_row;
        self.stats.mirror_loss = sums.mirror_loss * per_row;
        self.stats.rehearsal_loss = sums.rehearsal_loss / rehearsed_rows.max(1) as f64;
        self.stats.entropy = -sums.log_prob * per_row;
        count
    }

    /// Sums the gradients of so many chunks, or steps along the gradient, or both.
    fn finish_actor(&mut self, chunks: Option<usize>, step: bool) {
        let rate = T::from_f64(1.0 - self.config.actor_average_decay);
        let average = self.average.as_mut().map(|average| (rate, average));
        let scale = clip(self.config.max_grad_norm, self.stats.actor_gradient_norm);
        let norms = finish(
            &mut self.workers,
            std::slice::from_mut(&mut self.actor),
            &mut self.squares,
            chunks.map(|count| Sum {
                chunks: &self.chunks[..count],
                of: |chunk, _| &chunk.actor_gradient,
            }),
            step.then_some(Step {
                scales: [scale; 2],
                learning_rate: self.config.learning_rate,
                followers: [average, None],
            }),
        );
        if chunks.is_some() {
            self.stats.actor_gradient_norm = norms[0];
        }
        self.actor_stale |= step;
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
        adam::descend(
            step,
            1.0,
            &[gradient],
            &mut log_alpha,
            &mut first,
            &mut second,
        );
        [state.log_alpha] = log_alpha;
        [state.first_moment] = first;
        [state.second_moment] = second;
        state.alpha = state.log_alpha.exp();
    }
}

fn sums<T>(chunks: &[Chunk<T>]) -> Sums {
    let mut total = Sums::default();
    for Chunk { sums, .. } in chunks {
        total.critic_loss[0] += sums.critic_loss[0];
        total.critic_loss[1] += sums.critic_loss[1];
        total.q += sums.q;
        total.target += sums.target;
        total.actor_loss += sums.actor_loss;
        total.mirror_loss += sums.mirror_loss;
        total.rehearsal_loss += sums.rehearsal_loss;
        total.log_prob += sums.log_prob;
    }
    total
}

pub(crate) fn actor_shape(
    config: &SacConfig,
    observation_size: usize,
    action_size: usize,
) -> MlpShape {
    MlpShape {
        inputs: observation_size,
        hidden: config.actor_hidden.clone(),
        outputs: 2 * action_size,
        layer_norm: config.actor_layer_norm,
    }
}

/// Factor that brings a gradient of norm `norm` down to `max_norm`, as `torch.nn.utils.clip_grad_norm_`.
fn clip(max_norm: Option<f64>, norm: f64) -> f64 {
    max_norm.map_or(1.0, |max_norm| (max_norm / (norm + 1e-6)).min(1.0))
}

/// Gradients to be summed in the order of the chunks.
struct Sum<'a, T> {
    chunks: &'a [Chunk<T>],
    /// A chunk's gradient of one of the networks.
    of: fn(&Chunk<T>, usize) -> &Buffer<T>,
}

/// A step of Adam.
struct Step<'a, T> {
    /// Factor on the gradient of each network.
    scales: [f64; 2],
    learning_rate: f64,
    /// Networks that follow behind, each with its rate.
    followers: [Option<(T, &'a mut Mlp<T>)>; 2],
}

/// The buffers of one network, handed out in ranges.
struct Ranges<'a, T> {
    gradient: Disjoint<'a, T>,
    parameters: Disjoint<'a, T>,
    first_moment: Disjoint<'a, T>,
    second_moment: Disjoint<'a, T>,
    step: Option<(AdamStep<T>, T)>,
    follower: Option<(T, Disjoint<'a, T>)>,
}

/// For `networks` (one or two, of one size), range by range: sums the gradient, moves the parameters along it, and
/// their followers behind them. Gives the norms of the gradients where they are summed.
fn finish<T: Real>(
    workers: &mut Workers,
    networks: &mut [Trained<T>],
    squares: &mut [f64],
    sum: Option<Sum<'_, T>>,
    step: Option<Step<'_, T>>,
) -> [f64; 2] {
    let count = networks.len();
    let len = networks[0].gradient.len();
    let ranges = len.div_ceil(RANGE);
    {
        let squares = Disjoint::new(squares);
        let (scales, learning_rate, followers) = match step {
            Some(step) => (Some(step.scales), step.learning_rate, step.followers),
            None => (None, 0.0, [None, None]),
        };
        let mut followers = followers.into_iter();
        let mut networks = networks.iter_mut();
        let parts: [Option<Ranges<'_, T>>; 2] = std::array::from_fn(|index| {
            let network = networks.next()?;
            network.steps += u64::from(scales.is_some());
            Some(Ranges {
                step: scales.map(|scales| {
                    let step = AdamStep::new(network.steps, learning_rate);
                    (step, T::from_f64(scales[index]))
                }),
                gradient: Disjoint::new(&mut network.gradient),
                parameters: Disjoint::new(&mut network.network.parameters),
                first_moment: Disjoint::new(&mut network.first_moment),
                second_moment: Disjoint::new(&mut network.second_moment),
                follower: followers
                    .next()
                    .flatten()
                    .map(|(rate, follower)| (rate, Disjoint::new(&mut follower.parameters))),
            })
        });
        workers.run(count * ranges, &|task| {
            let (network, range) = (task / ranges, task % ranges);
            let (from, to) = (range * RANGE, ((range + 1) * RANGE).min(len));
            let Some(part) = &parts[network] else {
                return;
            };
            // SAFETY, here and below: ranges of different tasks do not overlap.
            let gradient = unsafe { part.gradient.range(from, to) };
            if let Some(sum) = &sum {
                add_up(sum, network, from, gradient);
                let square = unsafe { squares.range(task, task + 1) };
                square[0] = adam::sum_of_squares(gradient).to_f64();
            }
            if let Some((step, scale)) = part.step {
                let parameters = unsafe { part.parameters.range(from, to) };
                let first_moment = unsafe { part.first_moment.range(from, to) };
                let second_moment = unsafe { part.second_moment.range(from, to) };
                adam::descend(
                    step,
                    scale,
                    gradient,
                    parameters,
                    first_moment,
                    second_moment,
                );
                if let Some((rate, follower)) = &part.follower {
                    adam::follow(*rate, parameters, unsafe { follower.range(from, to) });
                }
            }
        });
    }
    std::array::from_fn(|network| {
        if network < count {
            squares[network * ranges..(network + 1) * ranges]
                .iter()
                .sum::<f64>()
                .sqrt()
        } else {
            0.0
        }
    })
}

/// gradient ← Σ over the chunks of theirs from `from` on, in the order of the chunks, two of them in one pass.
fn add_up<T: Real>(sum: &Sum<'_, T>, network: usize, from: usize, gradient: &mut [T]) {
    let to = from + gradient.len();
    let part = |chunk| &(sum.of)(chunk, network)[from..to];
    let rest = match sum.chunks {
        [a, b, rest @ ..] => {
            adam::sum_of_two(part(a), part(b), gradient);
            rest
        }
        chunks => {
            gradient.copy_from_slice(part(&chunks[0]));
            &chunks[1..]
        }
    };
    for pair in rest.chunks(2) {
        match pair {
            [a, b] => adam::add_two(part(a), part(b), gradient),
            [a] => adam::add(part(a), gradient),
            _ => {}
        }
    }
}

/// Scratch for each of the threads.
fn scratches<T: Real>(
    workers: &Workers,
    actor: &Mlp<T>,
    critic: &Mlp<T>,
    config: &SacConfig,
) -> Vec<Scratch<T>> {
    let mirrored = config.mirror_loss_weight > 0.0;
    (0..workers.threads())
        .map(|_| Scratch::new(actor, critic, mirrored))
        .collect()
}

impl<T: Real> Scratch<T> {
    fn new(actor: &Mlp<T>, critic: &Mlp<T>, mirrored: bool) -> Self {
        let observation_size = actor.shape().inputs;
        let action_size = critic.shape().inputs - observation_size;
        let actor_rows = if mirrored { 2 * CHUNK } else { CHUNK };
        let zeros = |count: usize| vec![T::ZERO; count];
        Self {
            actor: actor.activations(actor_rows),
            actor_deltas: actor.deltas(actor_rows),
            critics: [critic.activations(CHUNK), critic.activations(CHUNK)],
            critic_deltas: critic.deltas(CHUNK),
            actor_input: zeros(if mirrored {
                actor_rows * observation_size
            } else {
                0
            }),
            critic_input: zeros(CHUNK * (observation_size + action_size)),
            actions: zeros(CHUNK * action_size),
            log_probs: zeros(CHUNK),
            targets: zeros(CHUNK),
            d_critic: zeros(CHUNK),
            d_log_prob: zeros(CHUNK),
            d_action: zeros(CHUNK * action_size),
            d_actor: zeros(actor_rows * 2 * action_size),
            selected: [Vec::with_capacity(CHUNK), Vec::with_capacity(CHUNK)],
        }
    }

    /// Rows `first..last`: targets y = R + Γ (min Q'(s', a') − α c' ln π(a'|s')), losses (Q − y)² / 2, gradients.
    #[allow(clippy::too_many_arguments)]
    fn critic_pass(
        &mut self,
        actor: &Mlp<T>,
        critics: &[Trained<T>; 2],
        targets: &[Mlp<T>; 2],
        batch: &Batch<T>,
        noise: &[T],
        first: usize,
        last: usize,
        alpha: T,
        result: &mut Chunk<T>,
    ) {
        let rows = last - first;
        let observation_size = batch.observations.len() / batch.rows();
        let action_size = batch.actions.len() / batch.rows();
        let width = observation_size + action_size;

        let next = &batch.next_observations[first * observation_size..last * observation_size];
        actor.forward(rows, next, observation_size, &mut self.actor);
        gaussian::sample(
            action_size,
            &self.actor.out[..rows * 2 * action_size],
            &noise[first * action_size..last * action_size],
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
        for (target, activations) in targets.iter().zip(&mut self.critics) {
            target.forward(rows, &self.critic_input, width, activations);
        }
        let mut sums = Sums::default();
        for row in 0..rows {
            let place = first + row;
            let value = smaller(self.critics[0].out[row], self.critics[1].out[row])
                - alpha * batch.next_entropy_scales[place] * self.log_probs[row];
            // A terminated row must not see a value that is not finite either.
            let discount = batch.discounts[place];
            let future = if discount == T::ZERO {
                T::ZERO
            } else {
                discount * value
            };
            self.targets[row] = batch.rewards[place] + future;
            sums.target += self.targets[row].to_f64();
        }

        let observations = &batch.observations[first * observation_size..last * observation_size];
        let actions = &batch.actions[first * action_size..last * action_size];
        join(
            observation_size,
            observations,
            action_size,
            actions,
            &mut self.critic_input,
        );
        let per_row = T::ONE / T::from_f64(batch.rows() as f64);
        for (index, critic) in critics.iter().enumerate() {
            let activations = &mut self.critics[index];
            critic
                .network
                .forward(rows, &self.critic_input, width, activations);
            for row in 0..rows {
                let error = activations.out[row] - self.targets[row];
                self.d_critic[row] = error * per_row;
                sums.critic_loss[index] += 0.5 * (error * error).to_f64();
                sums.q += activations.out[row].to_f64();
            }
            critic.network.backward(
                &critic.transposed,
                rows,
                &self.critic_input,
                width,
                activations,
                &self.d_critic,
                &mut self.critic_deltas,
                &mut result.critic_gradients[index],
            );
        }
        result.sums = sums;
    }

    /// Rows `first..last`: loss α c ln π(a|s) − min Q(s, a) with a drawn anew, mirror loss, gradient.
    #[allow(clippy::too_many_arguments)]
    fn actor_pass(
        &mut self,
        actor: &Trained<T>,
        critics: &[Trained<T>; 2],
        mirror: Option<(&Mirror, T)>,
        batch: &Batch<T>,
        noise: &[T],
        first: usize,
        last: usize,
        alpha: T,
        result: &mut Chunk<T>,
    ) {
        let rows = last - first;
        let observation_size = batch.observations.len() / batch.rows();
        let action_size = batch.actions.len() / batch.rows();
        let width = observation_size + action_size;
        let outputs = 2 * action_size;
        let observations = &batch.observations[first * observation_size..last * observation_size];
        let noise = &noise[first * action_size..last * action_size];

        let actor_rows = match mirror {
            None => {
                actor
                    .network
                    .forward(rows, observations, observation_size, &mut self.actor);
                rows
            }
            Some((mirror, _)) => {
                let (plain, image) = self.actor_input.split_at_mut(rows * observation_size);
                plain.copy_from_slice(observations);
                for (from, to) in observations
                    .chunks_exact(observation_size)
                    .zip(image.chunks_exact_mut(observation_size))
                {
                    reflect(&mirror.observation, from, to);
                }
                actor.network.forward(
                    2 * rows,
                    &self.actor_input,
                    observation_size,
                    &mut self.actor,
                );
                2 * rows
            }
        };
        let out = &self.actor.out[..rows * outputs];
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

        let per_row = T::ONE / T::from_f64(batch.rows() as f64);
        let mut sums = Sums::default();
        for selected in &mut self.selected {
            selected.clear();
        }
        for row in 0..rows {
            let (q_1, q_2) = (self.critics[0].out[row], self.critics[1].out[row]);
            // Only the smaller critic passes a derivative on.
            self.selected[usize::from(q_2 < q_1)].push(row);
            let weight = alpha * batch.entropy_scales[first + row];
            self.d_log_prob[row] = weight * per_row;
            sums.actor_loss += (weight * self.log_probs[row] - smaller(q_1, q_2)).to_f64();
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
            &mut self.d_actor[..rows * outputs],
        );
        if let Some((mirror, weight)) = mirror {
            sums.mirror_loss = mirror_back(
                &mirror.action,
                &self.actor.out[..2 * rows * outputs],
                weight * per_row,
                &mut self.d_actor[..2 * rows * outputs],
            )
            .to_f64();
        }
        let input = if mirror.is_some() {
            &self.actor_input[..]
        } else {
            observations
        };
        actor.network.backward(
            &actor.transposed,
            actor_rows,
            input,
            observation_size,
            &self.actor,
            &self.d_actor,
            &mut self.actor_deltas,
            &mut result.actor_gradient,
        );
        result.sums = sums;
    }

    /// Pairs `first..last`: loss weight · Σ |μ(s) − a|², gradient.
    #[allow(clippy::too_many_arguments)]
    fn rehearsal_pass(
        &mut self,
        actor: &Trained<T>,
        rehearsed: &Rehearsed<T>,
        action_size: usize,
        first: usize,
        last: usize,
        weight: T,
        result: &mut Chunk<T>,
    ) {
        let rows = last - first;
        let observation_size = actor.network.shape().inputs;
        let observations =
            &rehearsed.observations[first * observation_size..last * observation_size];
        let actions = &rehearsed.actions[first * action_size..last * action_size];
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
            &mut result.actor_gradient,
        );
        result.sums = Sums {
            rehearsal_loss: sum.to_f64(),
            ..Sums::default()
        };
    }
}

#[inline(always)]
fn smaller<T: Real>(a: T, b: T) -> T {
    // NaN in either is passed on, so that it is noticed.
    match a.partial_cmp(&b) {
        Some(Ordering::Greater) => b,
        Some(_) => a,
        None => a + b,
    }
}

/// Adds the derivative of weight · Σ |μ(s) − Ψa(μ(Ψo(s)))|² to `d_out` and returns the unweighted sum. The first
/// half of the rows belongs to the observations, the second to their mirror images.
fn mirror_back<T: Real>(map: &[(usize, f32)], out: &[T], weight: T, d_out: &mut [T]) -> T {
    let size = map.len();
    let rows = out.len() / (4 * size);
    let (out, image) = out.split_at(rows * 2 * size);
    let (d_out, d_image) = d_out.split_at_mut(rows * 2 * size);
    d_image.fill(T::ZERO);
    let two = T::from_f64(2.0);
    let mut sum = T::ZERO;
    for row in 0..rows {
        let start = row * 2 * size;
        for (action, &(source, sign)) in map.iter().enumerate() {
            let sign = T::from_f64(f64::from(sign));
            let mean = out[start + action].tanh();
            let image_mean = image[start + source].tanh();
            let difference = mean - sign * image_mean;
            sum += difference * difference;
            let d_mean = two * weight * difference;
            d_out[start + action] += d_mean * (T::ONE - mean * mean);
            d_image[start + source] -= d_mean * sign * (T::ONE - image_mean * image_mean);
        }
    }
    sum
}

wide! {
    /// Rows of observation and action side by side.
    fn join<T, V>(
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
            copy_short::<T, V>(observation, to_observation);
            copy_short::<T, V>(action, to_action);
        }
    }
}

/// Copies a few numbers without a call: eight at a time, the last eight overlapping those before.
#[inline(always)]
fn copy_short<T: Real, V: Lanes<T>>(from: &[T], to: &mut [T]) {
    if let Some(last) = from.len().checked_sub(LANES) {
        for place in (0..last).step_by(LANES) {
            V::load(from, place).store(to, place);
        }
        V::load(from, last).store(to, last);
    } else {
        for (to, &from) in to.iter_mut().zip(from) {
            *to = from;
        }
    }
}
