//! The learner with its random numbers: acts, learns from a replay buffer, can be saved and resumed.

use gaitshift_nn::{Trained, Workers};
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::config::{
    SIZE_MAX, SacConfig, Temperature, check_alpha, check_gamma, check_learning_rate, fits, require,
};
use crate::error::SacError;
use crate::learner::{Learner, Noise, UpdateStats};
use crate::mirror::Mirror;
use crate::policy::{Policy, PolicyScratch};
use crate::random::{fill_normal, streams};
use crate::rehearsal::{Rehearsal, Rehearsed};
use crate::replay::{ReplayBuffer, Sampling, length};

/// Random streams of a run.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Streams {
    /// Which transitions an update sees.
    pub sampling: Xoshiro256PlusPlus,
    /// Noise of the actions within an update.
    pub noise: Xoshiro256PlusPlus,
    /// Noise of the actions taken.
    pub acting: Xoshiro256PlusPlus,
}

/// A Soft Actor-Critic agent.
///
/// Everything random comes from the seed given at the start; a run is the same bit for bit on one
/// machine whatever the number of threads, and whether or not it was saved and resumed on the way.
#[derive(Debug)]
pub struct Agent {
    pub(crate) learner: Learner<f32>,
    pub(crate) streams: Streams,
    /// Noise of the actions taken.
    acting_noise: Vec<f32>,
    /// What the actor goes on to imitate.
    pub(crate) rehearsal: Option<Rehearsal>,
    slots: Vec<usize>,
    noise: [Vec<f32>; 2],
    scratch: PolicyScratch,
}

impl Agent {
    /// A new agent for observations and actions of the given sizes; actions lie in \[−1, 1\]. With a mirror, half of
    /// every batch is replaced by its mirror image.
    ///
    /// # Errors
    /// When a setting is outside its range, the networks and the batch are too large together, or the mirror is none of
    /// these sizes.
    pub fn new(
        config: SacConfig,
        observation_size: usize,
        action_size: usize,
        mirror: Option<Mirror>,
        seed: u64,
    ) -> Result<Self, SacError> {
        let [mut init, sampling, noise, acting] = streams(seed);
        let learner = Learner::new(config, observation_size, action_size, mirror, &mut init)?;
        let rows = learner.config.batch_size;
        Ok(Self {
            scratch: PolicyScratch::new(&learner.actor.network),
            slots: vec![0; rows],
            noise: [0, 1].map(|_| vec![0.0; rows * action_size]),
            streams: Streams {
                sampling,
                noise,
                acting,
            },
            acting_noise: Vec::new(),
            rehearsal: None,
            learner,
        })
    }

    /// Settings as they are now.
    pub fn config(&self) -> &SacConfig {
        &self.learner.config
    }

    /// Networks, gradients and optimiser, to look at.
    pub fn learner(&self) -> &Learner<f32> {
        &self.learner
    }

    /// Numbers per observation.
    pub fn observation_size(&self) -> usize {
        self.learner.observation_size
    }

    /// Numbers per action.
    pub fn action_size(&self) -> usize {
        self.learner.action_size
    }

    /// The mirror by which half of every batch is replaced, if any.
    pub fn mirror(&self) -> Option<&Mirror> {
        self.learner.mirror.as_deref()
    }

    /// Updates made so far.
    pub fn updates(&self) -> u64 {
        self.learner.updates
    }

    /// α as it is now.
    pub fn alpha(&self) -> f64 {
        self.learner.temperature.alpha
    }

    /// Sets a fixed α.
    ///
    /// # Errors
    /// When it is negative or not finite, or the temperature is learned.
    pub fn set_alpha(&mut self, alpha: f64) -> Result<(), SacError> {
        check_alpha(alpha)?;
        let fixed = matches!(self.learner.config.temperature, Temperature::Fixed { .. });
        require(
            fixed,
            "temperature",
            &self.learner.config.temperature,
            "fixed, to be set from outside",
        )?;
        self.learner.config.temperature = Temperature::Fixed { alpha };
        self.learner.temperature.alpha = alpha;
        self.learner.temperature.log_alpha = alpha.max(f64::MIN_POSITIVE).ln();
        Ok(())
    }

    /// Sets the learning rate of actor and critics.
    ///
    /// # Errors
    /// When it is not above 0.
    pub fn set_learning_rate(&mut self, learning_rate: f64) -> Result<(), SacError> {
        check_learning_rate(learning_rate)?;
        self.learner.config.learning_rate = learning_rate;
        Ok(())
    }

    /// Sets the discount γ.
    ///
    /// # Errors
    /// When it is not from 0 to 1.
    pub fn set_gamma(&mut self, gamma: f64) -> Result<(), SacError> {
        check_gamma(gamma)?;
        self.learner.config.gamma = gamma;
        Ok(())
    }

    /// Uses another number of threads; the results stay the same.
    ///
    /// # Errors
    /// When it is not from 1 to 256.
    pub fn set_threads(&mut self, threads: usize) -> Result<(), SacError> {
        self.learner.set_threads(threads)
    }

    /// Acts and learns from here on as `policy`; the actor's optimiser begins anew.
    ///
    /// # Errors
    /// When its layers are not those of the actor.
    pub fn start_from(&mut self, policy: &Policy) -> Result<(), SacError> {
        let network = policy.network();
        require(
            network.shape() == self.learner.actor.network.shape(),
            "actor_hidden",
            &self.learner.actor.network.shape(),
            "of the layers of the policy to start from",
        )?;
        self.learner.actor = Trained::new(network.clone());
        Ok(())
    }

    /// While held, the actor and the temperature stay as they are, and only the critics learn. Not part of a checkpoint.
    pub fn hold_actor(&mut self, held: bool) {
        self.learner.actor_held = held;
    }

    /// From now on every actor update also imitates `rows` pairs drawn from `rehearsal`, with the weight that
    /// [`Agent::set_rehearsal_weight`] sets; half of them mirrored where batches are mirrored.
    ///
    /// # Errors
    /// When its sizes are others, or the rows not from 1 to 65536 or too many for the actor's size.
    pub fn rehearse(&mut self, rehearsal: Rehearsal, rows: usize) -> Result<(), SacError> {
        let [observation_size, action_size] = rehearsal.sizes();
        length(
            "a rehearsal observation",
            observation_size,
            self.learner.observation_size,
        )?;
        length("a rehearsal action", action_size, self.learner.action_size)?;
        self.require_rehearsal_rows(rows)?;
        let rehearsed = Rehearsed::zeros(rows, observation_size, action_size);
        self.learner.set_rehearsed(rehearsed);
        self.rehearsal = Some(rehearsal);
        Ok(())
    }

    /// Whether so many pairs can be rehearsed in an update.
    ///
    /// # Errors
    /// When they are not from 1 to 65536, or too many for the actor's size.
    pub fn require_rehearsal_rows(&self, rows: usize) -> Result<(), SacError> {
        require(
            (1..=SIZE_MAX).contains(&rows),
            "rehearsal rows",
            &rows,
            "from 1 to 65536",
        )?;
        require(
            fits(self.learner.actor.network.shape(), rows),
            "rehearsal rows",
            &rows,
            "fewer for an actor of this size: the gradients of so many fill the memory",
        )
    }

    /// Sets the weight w of the rehearsal loss w · mean |μ(s) − a|² in the actor's loss; with 0, as at first, nothing is
    /// rehearsed.
    ///
    /// # Errors
    /// When it is negative or not finite.
    pub fn set_rehearsal_weight(&mut self, weight: f64) -> Result<(), SacError> {
        let valid = weight.is_finite() && weight >= 0.0;
        require(valid, "rehearsal weight", &weight, "at least 0")?;
        self.learner.rehearsal_weight = weight;
        Ok(())
    }

    /// The weight of the rehearsal loss.
    pub fn rehearsal_weight(&self) -> f64 {
        self.learner.rehearsal_weight
    }

    /// What is rehearsed, if anything.
    pub fn rehearsal(&self) -> Option<&Rehearsal> {
        self.rehearsal.as_ref()
    }

    /// The threads of the updates, to share out other work between two of them.
    pub fn workers(&mut self) -> &mut Workers {
        &mut self.learner.workers
    }

    /// Random actions (rows × action size) and their ln π (rows) for observations (rows × observation
    /// size), with the agent's own noise.
    ///
    /// # Errors
    /// When the lengths do not match.
    pub fn act(
        &mut self,
        observations: &[f32],
        actions: &mut [f32],
        log_probs: &mut [f32],
    ) -> Result<(), SacError> {
        let network = &self.learner.actor.network;
        let noise = &mut self.acting_noise;
        noise.resize(actions.len(), 0.0);
        fill_normal(&mut self.streams.acting, noise);
        self.scratch
            .sample(network, observations, noise, actions, log_probs)
    }

    /// Deterministic actions tanh(mean) for rows of observations.
    ///
    /// # Errors
    /// When the lengths do not match.
    pub fn act_deterministic(
        &mut self,
        observations: &[f32],
        actions: &mut [f32],
    ) -> Result<(), SacError> {
        self.scratch
            .mean_action(&self.learner.actor.network, observations, actions)
    }

    /// A copy of the actor.
    pub fn policy(&self) -> Policy {
        Policy::new(self.learner.actor.network.clone())
    }

    /// One update from transitions drawn from `replay`.
    ///
    /// # Errors
    /// When the buffer is empty or of other sizes, or learning diverged (see [`SacError::Diverged`]).
    pub fn update(&mut self, replay: &ReplayBuffer) -> Result<UpdateStats, SacError> {
        length(
            "replay observation",
            replay.observation_size(),
            self.learner.observation_size,
        )?;
        length(
            "replay action",
            replay.action_size(),
            self.learner.action_size,
        )?;
        let config = &self.learner.config;
        let mirror = self.learner.mirror.clone();
        let half = config.batch_size.div_ceil(2);
        let sampling = Sampling {
            n_step: config.n_step,
            gamma: config.gamma,
            alpha: self.learner.temperature.alpha,
            mirrored: mirror.as_deref().map(|mirror| (mirror, half)),
        };
        replay.draw(&mut self.streams.sampling, &mut self.slots)?;
        for noise in &mut self.noise {
            fill_normal(&mut self.streams.noise, noise);
        }
        if let Some(rehearsal) = &self.rehearsal
            && self.learner.rehearsal_weight > 0.0
        {
            let half = self.learner.rehearsed_rows() / 2;
            rehearsal.draw(
                &mut self.streams.sampling,
                mirror.as_deref().map(|mirror| (mirror, half)),
                &mut self.learner.rehearsed,
            );
        }
        let ([next, current], slots) = (&self.noise, &self.slots);
        self.learner.update_from(
            &|chosen, batch| replay.gather_part(slots, chosen, &sampling, batch),
            Noise { next, current },
        )
    }
}
