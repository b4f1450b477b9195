//! The learner: networks, targets, optimiser and temperature, and the memory of an update.

use std::sync::Arc;

use gaitshift_nn::{Mlp, Optimiser, Scalar, Trained, Workers};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

use crate::config::{
    CHUNK, SacConfig, Temperature, actor_shape, check_sizes, check_threads, critic_shape,
};
use crate::error::SacError;
use crate::losses::{ActorLoss, Examples, Part, Scratch, rows_of, scratches};
use crate::mirror::Mirror;
use crate::rehearsal::Rehearsed;

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
    /// mean (α ln π − min Q), of the last update in which the actor learned, as all below.
    pub actor_loss: f64,
    /// mean |μ(s) − a|² over the rehearsed pairs, unweighted; 0 when none are rehearsed.
    pub rehearsal_loss: f64,
    /// −mean ln π, in nats.
    pub entropy: f64,
    /// α that this update used.
    pub alpha: f64,
    /// Norm of each critic's gradient.
    pub critic_gradient_norm: [f64; 2],
    /// Norm of the actor's gradient.
    pub actor_gradient_norm: f64,
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
    pub(crate) temperature: TemperatureState,
    pub(crate) updates: u64,
    pub(crate) stats: UpdateStats,
    /// For each chunk of the batch.
    pub(crate) examples: Vec<Examples<T>>,
    pub(crate) actor_losses: Vec<ActorLoss<T>>,
    /// For each chunk of the batch those of the first critic, then of the second.
    pub(crate) critic_parts: Vec<Part<T>>,
    /// For each chunk of the batch, behind them those of the rehearsed pairs.
    pub(crate) actor_parts: Vec<Part<T>>,
    /// One for each thread.
    pub(crate) scratches: Vec<Scratch<T>>,
    /// The actor and the temperature stay as they are while the critics learn.
    pub(crate) actor_held: bool,
    /// The actor moved since its copies for the backward pass were made.
    pub(crate) actor_stale: bool,
    /// Pairs that the next update rehearses; [`crate::Agent`] draws them.
    pub rehearsed: Rehearsed<T>,
    /// Weight w of the rehearsal loss w · mean |μ(s) − a|² over them; 0 for none.
    pub rehearsal_weight: f64,
    pub(crate) optimiser: Optimiser,
    pub(crate) workers: Workers,
}

impl<T: Scalar> Learner<T> {
    /// A learner with the given networks; targets start as copies.
    ///
    /// # Errors
    /// When a setting is outside its range, the networks and the batch are too large together, or the mirror is none of
    /// these sizes.
    pub fn new(
        config: SacConfig,
        observation_size: usize,
        action_size: usize,
        mirror: Option<Mirror>,
        rng: &mut Xoshiro256PlusPlus,
    ) -> Result<Self, SacError> {
        config.validate()?;
        let sizes = [observation_size, action_size];
        check_sizes(&config, sizes)?;
        if let Some(mirror) = &mirror {
            mirror.validate(observation_size, action_size)?;
        }
        let actor = Trained::new(Mlp::random(actor_shape(&config, sizes), rng));
        let critics = [0, 1].map(|_| Trained::new(Mlp::random(critic_shape(&config, sizes), rng)));
        let targets = [critics[0].network.clone(), critics[1].network.clone()];
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
        let chunks = config.batch_size.div_ceil(CHUNK);
        let parts =
            |count: usize, network: &Mlp<T>| (0..count).map(|_| Part::new(network)).collect();
        let critic_parts = parts(2 * chunks, &critics[0].network);
        let actor_parts = parts(chunks, &actor.network);
        let examples = (0..chunks)
            .map(|chunk| {
                let rows = rows_of(chunk, config.batch_size).len();
                Examples::new(rows, observation_size, action_size)
            })
            .collect();
        let actor_losses = (0..chunks)
            .map(|_| ActorLoss::new(&actor.network))
            .collect();
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
            temperature,
            updates: 0,
            stats: UpdateStats::default(),
            rehearsed: Rehearsed::default(),
            rehearsal_weight: 0.0,
            examples,
            actor_losses,
            critic_parts,
            actor_parts,
            scratches,
            actor_held: false,
            actor_stale: false,
            optimiser: Optimiser::default(),
            workers,
        })
    }

    /// The temperature.
    // For the tests, which look at the moments too; `Agent::alpha` is for others.
    #[doc(hidden)]
    pub fn temperature(&self) -> TemperatureState {
        self.temperature
    }

    /// Settings.
    pub fn config(&self) -> &SacConfig {
        &self.config
    }

    /// What the last update saw.
    // For the tests of single losses; `Learner::update` returns it.
    #[doc(hidden)]
    pub fn stats(&self) -> UpdateStats {
        self.stats
    }

    /// Uses another number of threads; the results stay the same.
    ///
    /// # Errors
    /// When it is not from 1 to 256.
    pub fn set_threads(&mut self, threads: usize) -> Result<(), SacError> {
        check_threads(threads)?;
        self.config.threads = threads;
        self.workers = Workers::new(threads);
        let (actor, critic) = (&self.actor.network, &self.critics[0].network);
        self.scratches = scratches(&self.workers, actor, critic);
        Ok(())
    }

    /// Takes the memory of the pairs that updates rehearse, and sets aside what their gradients need.
    pub fn set_rehearsed(&mut self, rehearsed: Rehearsed<T>) {
        let chunks =
            self.examples.len() + (rehearsed.actions.len() / self.action_size).div_ceil(CHUNK);
        let network = &self.actor.network;
        self.actor_parts.resize_with(chunks, || Part::new(network));
        self.rehearsed = rehearsed;
    }

    /// Pairs that an update rehearses.
    pub(crate) fn rehearsed_rows(&self) -> usize {
        self.rehearsed.actions.len() / self.action_size
    }

    /// Updates made.
    pub fn updates(&self) -> u64 {
        self.updates
    }
}
