//! One update of Soft Actor-Critic: critics, actor, temperature, targets.
//!
//! The batch is cut into chunks of [`CHUNK`] rows. Each chunk runs forward and backward in the scratch of a thread, which
//! stays in the cache of that core, and leaves its own gradient of each network; gradients are
//! then summed in the order of the chunks. Neither the cut nor the order depends on the number of
//! threads, so neither do the bits of the result.

use std::cmp::Ordering;
use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::adam::{self, AdamStep};
use crate::config::{SIZE_MAX, SacConfig, Temperature, require};
use crate::error::SacError;
use crate::gaussian;
use crate::lanes::{LANES, Lanes};
use crate::mirror::{Mirror, reflect};
use crate::network::{Activations, Deltas, Mlp, MlpShape, Transposed};
use crate::real::{Buffer, Real, wide};
use crate::rehearsal::{Rehearsed, imitate};
use crate::replay::{Batch, length};
use crate::workers::{Disjoint, Gate, Workers};

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
    /// Observation, action.
    critic_input: Vec<T>,
    actions: Vec<T>,
    log_probs: Vec<T>,
    d_critic: Vec<T>,
    d_log_prob: Vec<T>,
    d_action: Vec<T>,
    d_actor: Vec<T>,
    selected: [Vec<usize>; 2],
}

/// One chunk of the batch and what the critics are to learn from it.
#[derive(Debug)]
struct Examples<T> {
    batch: Batch<T>,
    targets: Vec<T>,
    sums: Sums,
}

/// Fills the rows of a chunk, given which rows of the whole batch they are.
type Fill<'a, T> = dyn Fn(Range<usize>, &mut Batch<T>) + Sync + 'a;

/// What the actor's loss on one chunk leaves for the actor's backward pass.
#[derive(Debug)]
struct ActorLoss<T> {
    actor: Activations<T>,
    /// Observations and, where the mirror loss needs them, their mirror images below.
    input: Vec<T>,
    d_actor: Vec<T>,
    sums: Sums,
}

/// The gradient of one network's loss on one chunk.
#[derive(Debug)]
struct Part<T> {
    gradient: Buffer<T>,
    sums: Sums,
}

/// Sums over the rows of a chunk; each task adds up its own and leaves the others 0.
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
    /// Shared, so that who fills the batch can mirror while the learner learns.
    pub(crate) mirror: Option<Arc<Mirror>>,
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
    /// For each chunk of the batch.
    examples: Vec<Examples<T>>,
    actor_losses: Vec<ActorLoss<T>>,
    /// For each chunk of the batch those of the first critic, then of the second.
    critic_parts: Vec<Part<T>>,
    /// For each chunk of the batch, behind them those of the rehearsed pairs.
    actor_parts: Vec<Part<T>>,
    /// One for each chunk of the batch: opens when its targets, or its actor's loss, are known.
    gates: Vec<Gate>,
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
        let sizes = [observation_size, action_size];
        check_sizes(sizes)?;
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
        let actor = Mlp::random(actor_shape(&config, sizes), rng);
        let critics = [0, 1].map(|_| Trained::new(Mlp::random(critic_shape(&config, sizes), rng)));
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
        let chunks = config.batch_size.div_ceil(CHUNK);
        let parts = |count: usize, network: &Mlp<T>| {
            let part = || Part {
                gradient: network.zeros_like(),
                sums: Sums::default(),
            };
            (0..count).map(|_| part()).collect()
        };
        let critic_parts = parts(2 * chunks, &critics[0].network);
        let actor_parts = parts(chunks + rehearsal_rows.div_ceil(CHUNK), &actor.network);
        let examples = (0..chunks)
            .map(|chunk| {
                let rows = rows_of(chunk, config.batch_size).len();
                Examples {
                    batch: Batch::zeros(rows, observation_size, action_size),
                    targets: vec![T::ZERO; rows],
                    sums: Sums::default(),
                }
            })
            .collect();
        let mirrored = config.mirror_loss_weight > 0.0;
        let actor_losses = (0..chunks)
            .map(|_| ActorLoss::new(&actor.network, mirrored))
            .collect();
        let ranges = (2 * critics[0].gradient.len().div_ceil(RANGE))
            .max(actor.gradient.len().div_ceil(RANGE));
        let workers = Workers::new(config.threads);
        let scratches = scratches(&workers, &actor.network, &critics[0].network);
        Ok(Self {
            config,
            observation_size,
            action_size,
            mirror: mirror.map(Arc::new),
            actor,
            critics,
            targets,
            average,
            temperature,
            updates: 0,
            stats: UpdateStats::default(),
            rehearsed: Rehearsed::default(),
            examples,
            actor_losses,
            critic_parts,
            actor_parts,
            gates: (0..chunks).map(|_| Gate::default()).collect(),
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
        self.scratches = scratches(&self.workers, actor, critic);
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
        self.stats.actor_updated = false;
        // Clipping needs the norm of the whole gradient before the first parameter moves; otherwise each range of
        // parameters is summed up and moved while the cache holds it.
        let clipping = self.config.max_grad_norm.is_some();
        let chunks = self.critic_chunks(fill, noise.next);
        if clipping {
            self.finish_critics(Some(chunks), false);
        }
        self.finish_critics((!clipping).then_some(chunks), true);
        if self
            .updates
            .is_multiple_of(u64::from(self.config.actor_every))
        {
            let chunks = self.actor_chunks(noise.current);
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
        length("batch.discounts", batch.discounts.len(), rows)?;
        length("batch.entropy_scales", batch.entropy_scales.len(), rows)?;
        length(
            "batch.next_entropy_scales",
            batch.next_entropy_scales.len(),
            rows,
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

    /// Losses of the critics and their gradients, at the current parameters, for a batch that [`Learner::update`] would
    /// take.
    pub fn critic_gradients(&mut self, batch: &Batch<T>, noise: &[T]) {
        let chunks = self.critic_chunks(&|chosen, rows| rows.copy_rows(batch, chosen), noise);
        self.finish_critics(Some(chunks), false);
    }

    /// Runs the chunks and gives how many they are.
    fn critic_chunks(&mut self, fill: &Fill<'_, T>, noise: &[T]) -> usize {
        let Trained {
            network: actor,
            transposed,
            ..
        } = &mut self.actor;
        let (actor, critics, targets) = (&*actor, &self.critics, &self.targets);
        let alpha = T::from_f64(self.temperature.alpha);
        let (rows, action_size) = (self.config.batch_size, self.action_size);
        let per_row = T::ONE / T::from_f64(rows as f64);
        let count = rows.div_ceil(CHUNK);
        // The actor's backward pass comes later in the update, so a thread may bring its copies up to date now.
        let stale = std::mem::take(&mut self.actor_stale);
        let transposed = Disjoint::new(std::slice::from_mut(transposed));
        self.gates.iter_mut().for_each(Gate::close);
        let gates = &self.gates;
        let examples = Disjoint::new(&mut self.examples[..]);
        let parts = Disjoint::new(&mut self.critic_parts[..2 * count]);
        let scratches = Disjoint::new(&mut self.scratches);
        let stages = [count, 2 * count + usize::from(stale)];
        self.workers.run_stages(stages, &|thread, stage, task| {
            // SAFETY: a thread does one task at a time.
            let scratch = unsafe { &mut scratches.range(thread, thread + 1)[0] };
            let chunk = task % count;
            if stage == 0 {
                let _open_at_end = gates[chunk].open_at_end();
                // SAFETY: one task for each chunk, and who reads it waits for the gate.
                let examples = unsafe { &mut examples.range(chunk, chunk + 1)[0] };
                let chosen = rows_of(chunk, rows);
                fill(chosen.clone(), &mut examples.batch);
                let noise = &noise[chosen.start * action_size..chosen.end * action_size];
                scratch.target_pass(actor, targets, noise, alpha, examples);
            } else if task == 2 * count {
                // SAFETY: one task only does this.
                actor.refresh(unsafe { &mut transposed.range(0, 1)[0] });
            } else {
                gates[chunk].wait();
                // SAFETY: each part is taken once, and nobody writes the examples any more.
                let (part, examples) =
                    unsafe { (&mut parts.range(task, task + 1)[0], examples.shared(chunk)) };
                let network = task / count;
                scratch.critic_pass(network, &critics[network], per_row, examples, part);
            }
        });
        let sums = total(
            self.examples
                .iter()
                .map(|examples| &examples.sums)
                .chain(self.critic_parts[..2 * count].iter().map(|part| &part.sums)),
        );
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
            chunks.map(|count| {
                let (first, second) = self.critic_parts[..2 * count].split_at(count);
                [first, second]
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

    /// Loss of the actor and its gradient, at the current parameters, for a batch that [`Learner::update`] would take.
    pub fn actor_gradient(&mut self, batch: &Batch<T>, noise: &[T]) {
        for (chunk, examples) in self.examples.iter_mut().enumerate() {
            let chosen = rows_of(chunk, self.config.batch_size);
            examples.batch.copy_rows(batch, chosen);
        }
        let chunks = self.actor_chunks(noise);
        self.finish_actor(Some(chunks), false);
    }

    /// Runs the chunks, which are filled, and gives how many they are.
    fn actor_chunks(&mut self, noise: &[T]) -> usize {
        if std::mem::take(&mut self.actor_stale) {
            self.actor.refresh();
        }
        let (actor, critics) = (&self.actor, &self.critics);
        let alpha = T::from_f64(self.temperature.alpha);
        let rows = self.config.batch_size;
        let mirror = self
            .mirror
            .as_deref()
            .filter(|_| self.config.mirror_loss_weight > 0.0)
            .map(|mirror| (mirror, T::from_f64(self.config.mirror_loss_weight)));
        let (rehearsed, action_size) = (&self.rehearsed, self.action_size);
        let rehearsed_rows = rehearsed.actions.len() / action_size;
        let weight = T::from_f64(self.config.rehearsal_weight / rehearsed_rows.max(1) as f64);
        let per_row = T::ONE / T::from_f64(rows as f64);
        let batch_chunks = rows.div_ceil(CHUNK);
        let examples = &self.examples;
        let count = batch_chunks + rehearsed_rows.div_ceil(CHUNK);
        self.gates.iter_mut().for_each(Gate::close);
        let gates = &self.gates;
        let losses = Disjoint::new(&mut self.actor_losses[..batch_chunks]);
        let parts = Disjoint::new(&mut self.actor_parts[..count]);
        let scratches = Disjoint::new(&mut self.scratches);
        self.workers
            .run_stages([count, batch_chunks], &|thread, stage, task| {
                // SAFETY: a thread does one task at a time.
                let scratch = unsafe { &mut scratches.range(thread, thread + 1)[0] };
                // SAFETY: a part belongs to one task of the first stage where it is rehearsed, and otherwise to one of
                // the second.
                let part = || unsafe { &mut parts.range(task, task + 1)[0] };
                if let Some(chunk) = task.checked_sub(batch_chunks) {
                    let chosen = rows_of(chunk, rehearsed_rows);
                    scratch.rehearsal_pass(actor, rehearsed, action_size, chosen, weight, part());
                    return;
                }
                let batch = &examples[task].batch;
                if stage == 0 {
                    let _open_at_end = gates[task].open_at_end();
                    // SAFETY: one task for each chunk, and who reads it waits for the gate.
                    let loss = unsafe { &mut losses.range(task, task + 1)[0] };
                    let chosen = rows_of(task, rows);
                    let noise = &noise[chosen.start * action_size..chosen.end * action_size];
                    let actor = &actor.network;
                    scratch.actor_loss(actor, critics, mirror, batch, noise, alpha, per_row, loss);
                } else {
                    gates[task].wait();
                    // SAFETY: nobody writes it any more.
                    let loss = unsafe { losses.shared(task) };
                    scratch.actor_back(actor, mirror.is_some(), batch, loss, part());
                }
            });
        let rehearsed_parts = &self.actor_parts[batch_chunks..count];
        let sums = total(
            self.actor_losses[..batch_chunks]
                .iter()
                .map(|loss| &loss.sums)
                .chain(rehearsed_parts.iter().map(|part| &part.sums)),
        );
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
            chunks.map(|count| [&self.actor_parts[..count], &[]]),
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

fn total<'a>(sums: impl Iterator<Item = &'a Sums>) -> Sums {
    let mut total = Sums::default();
    for sums in sums {
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

/// Numbers per observation and per action that a learner takes.
pub(crate) fn check_sizes([observation_size, action_size]: [usize; 2]) -> Result<(), SacError> {
    for (key, size) in [
        ("observation_size", observation_size),
        ("action_size", action_size),
    ] {
        require(
            (1..=SIZE_MAX).contains(&size),
            key,
            &size,
            "from 1 to 65536",
        )?;
    }
    Ok(())
}

/// Sizes of the actor, for so many numbers per observation and per action.
pub(crate) fn actor_shape(
    config: &SacConfig,
    [observation_size, action_size]: [usize; 2],
) -> MlpShape {
    MlpShape {
        inputs: observation_size,
        hidden: config.actor_hidden.clone(),
        outputs: 2 * action_size,
        layer_norm: config.actor_layer_norm,
    }
}

/// Sizes of a critic, likewise.
pub(crate) fn critic_shape(
    config: &SacConfig,
    [observation_size, action_size]: [usize; 2],
) -> MlpShape {
    MlpShape {
        inputs: observation_size + action_size,
        hidden: config.critic_hidden.clone(),
        outputs: 1,
        layer_norm: config.critic_layer_norm,
    }
}

/// Factor that brings a gradient of norm `norm` down to `max_norm`, as `torch.nn.utils.clip_grad_norm_`.
fn clip(max_norm: Option<f64>, norm: f64) -> f64 {
    max_norm.map_or(1.0, |max_norm| (max_norm / (norm + 1e-6)).min(1.0))
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

/// For `networks` (one or two, of one size), range by range: sums the gradient from its parts, in the order of the
/// chunks, moves the parameters along it, and their followers behind them. Gives the norms of the gradients where they are summed.
fn finish<T: Real>(
    workers: &mut Workers,
    networks: &mut [Trained<T>],
    squares: &mut [f64],
    parts: Option<[&[Part<T>]; 2]>,
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
        let buffers: [Option<Ranges<'_, T>>; 2] = std::array::from_fn(|index| {
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
            let Some(buffers) = &buffers[network] else {
                return;
            };
            // SAFETY: ranges of different tasks do not overlap.
            let (gradient, square) = unsafe {
                (
                    buffers.gradient.range(from, to),
                    &mut squares.range(task, task + 1)[0],
                )
            };
            if let Some(parts) = parts {
                add_up(parts[network], from, gradient);
                *square = adam::sum_of_squares(gradient).to_f64();
            }
            if let Some((step, scale)) = buffers.step {
                // SAFETY: as above.
                let (parameters, first_moment, second_moment) = unsafe {
                    (
                        buffers.parameters.range(from, to),
                        buffers.first_moment.range(from, to),
                        buffers.second_moment.range(from, to),
                    )
                };
                adam::descend(
                    step,
                    scale,
                    gradient,
                    parameters,
                    first_moment,
                    second_moment,
                );
                if let Some((rate, follower)) = &buffers.follower {
                    // SAFETY: as above.
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

/// gradient ← Σ of the parts from `from` on, in their order, two of them in one pass.
fn add_up<T: Real>(parts: &[Part<T>], from: usize, gradient: &mut [T]) {
    let range = from..from + gradient.len();
    let rest = match parts {
        [a, b, rest @ ..] => {
            let (a, b) = (&a.gradient[range.clone()], &b.gradient[range.clone()]);
            adam::sum_of_two(a, b, gradient);
            rest
        }
        parts => {
            gradient.copy_from_slice(&parts[0].gradient[range.clone()]);
            &parts[1..]
        }
    };
    for pair in rest.chunks(2) {
        let part = |index: usize| &pair[index].gradient[range.clone()];
        match pair.len() {
            2 => adam::add_two(part(0), part(1), gradient),
            _ => adam::add(part(0), gradient),
        }
    }
}

/// The rows of so many that belong to a chunk.
fn rows_of(chunk: usize, rows: usize) -> Range<usize> {
    chunk * CHUNK..((chunk + 1) * CHUNK).min(rows)
}

/// Scratch for each of the threads.
fn scratches<T: Real>(workers: &Workers, actor: &Mlp<T>, critic: &Mlp<T>) -> Vec<Scratch<T>> {
    (0..workers.threads())
        .map(|_| Scratch::new(actor, critic))
        .collect()
}

impl<T: Real> ActorLoss<T> {
    fn new(actor: &Mlp<T>, mirrored: bool) -> Self {
        let MlpShape {
            inputs, outputs, ..
        } = *actor.shape();
        let rows = if mirrored { 2 * CHUNK } else { CHUNK };
        let zeros = |count: usize| vec![T::ZERO; count];
        Self {
            actor: actor.activations(rows),
            input: zeros(if mirrored { rows * inputs } else { 0 }),
            d_actor: zeros(rows * outputs),
            sums: Sums::default(),
        }
    }
}

impl<T: Real> Scratch<T> {
    fn new(actor: &Mlp<T>, critic: &Mlp<T>) -> Self {
        let width = critic.shape().inputs;
        let action_size = width - actor.shape().inputs;
        let zeros = |count: usize| vec![T::ZERO; count];
        Self {
            actor: actor.activations(CHUNK),
            // The actor's backward pass may have as many mirror images behind its rows.
            actor_deltas: actor.deltas(2 * CHUNK),
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

    /// Targets y = R + Γ (min Q'(s', a') − α c' ln π(a'|s')).
    fn target_pass(
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
        let mut sums = Sums::default();
        for row in 0..rows {
            let value = smaller(self.critics[0].out[row], self.critics[1].out[row])
                - alpha * batch.next_entropy_scales[row] * self.log_probs[row];
            // A terminated row must not see a value that is not finite either.
            let discount = batch.discounts[row];
            let future = if discount == T::ZERO {
                T::ZERO
            } else {
                discount * value
            };
            examples.targets[row] = batch.rewards[row] + future;
            sums.target += examples.targets[row].to_f64();
        }
        examples.sums = sums;
    }

    /// Loss (Q − y)² / 2 of one critic, gradient.
    fn critic_pass(
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

    /// Loss α c ln π(a|s) − min Q(s, a) with a drawn anew, mirror loss, and the derivative in the
    /// actor's outputs.
    #[allow(clippy::too_many_arguments)]
    fn actor_loss(
        &mut self,
        actor: &Mlp<T>,
        critics: &[Trained<T>; 2],
        mirror: Option<(&Mirror, T)>,
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

        match mirror {
            None => actor.forward(rows, observations, observation_size, &mut result.actor),
            Some((mirror, _)) => {
                let (plain, image) = result.input.split_at_mut(rows * observation_size);
                plain.copy_from_slice(observations);
                for (from, to) in observations
                    .chunks_exact(observation_size)
                    .zip(image.chunks_exact_mut(observation_size))
                {
                    reflect(&mirror.observation, from, to);
                }
                let input = &result.input;
                actor.forward(2 * rows, input, observation_size, &mut result.actor);
            }
        }
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
            let weight = alpha * batch.entropy_scales[row];
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
            &mut result.d_actor[..rows * outputs],
        );
        if let Some((mirror, weight)) = mirror {
            sums.mirror_loss = mirror_back(
                &mirror.action,
                &result.actor.out[..2 * rows * outputs],
                weight * per_row,
                &mut result.d_actor[..2 * rows * outputs],
            )
            .to_f64();
        }
        result.sums = sums;
    }

    /// The gradient that belongs to [`Scratch::actor_loss`].
    fn actor_back(
        &mut self,
        actor: &Trained<T>,
        mirrored: bool,
        batch: &Batch<T>,
        loss: &ActorLoss<T>,
        result: &mut Part<T>,
    ) {
        let (rows, observations) = (batch.rows(), &batch.observations);
        let (inputs, input) = if mirrored {
            (2 * rows, &loss.input)
        } else {
            (rows, observations)
        };
        actor.network.backward(
            &actor.transposed,
            inputs,
            input,
            observations.len() / rows,
            &loss.actor,
            &loss.d_actor,
            &mut self.actor_deltas,
            &mut result.gradient,
        );
    }

    /// The chosen pairs: loss weight · Σ |μ(s) − a|², gradient.
    fn rehearsal_pass(
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
