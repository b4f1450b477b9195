//! Settings of the learner.

use gaitshift_nn::MlpShape;
use serde::{Deserialize, Serialize};

use crate::error::SacError;

/// Rows of a batch that are worked on together.
pub const CHUNK: usize = 64;

/// How the weight α of the entropy is found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Temperature {
    /// α stays as given until [`crate::Agent::set_alpha`] changes it.
    Fixed {
        /// α, at least 0.
        alpha: f64,
    },
    /// ln α follows the gradient of −ln α · mean(ln π + target entropy) with its own Adam.
    Auto {
        /// α at the start, above 0.
        initial: f64,
        /// Entropy in nats to hold; by default minus the number of actions.
        #[serde(default)]
        target_entropy: Option<f64>,
        /// Learning rate of ln α.
        #[serde(default = "default_learning_rate")]
        learning_rate: f64,
    },
}

fn default_learning_rate() -> f64 {
    3e-4
}

/// Settings of the learner; every one has a default, an unknown one is an error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SacConfig {
    /// Units of each hidden layer of the actor.
    pub actor_hidden: Vec<usize>,
    /// Units of each hidden layer of each critic.
    pub critic_hidden: Vec<usize>,
    /// Layer normalisation in the critics.
    pub critic_layer_norm: bool,
    /// Learning rate of Adam for actor and critics.
    pub learning_rate: f64,
    /// Discount γ per step.
    pub gamma: f64,
    /// Share of the critics that their targets take over in each update (Polyak averaging).
    pub tau: f64,
    /// Transitions in an update.
    pub batch_size: usize,
    /// Greatest number of rewards summed before bootstrapping.
    pub n_step: usize,
    /// Weight of the entropy.
    pub temperature: Temperature,
    /// Threads of an update, the calling one included; changes the speed and never the result.
    pub threads: usize,
}

impl Default for SacConfig {
    fn default() -> Self {
        Self {
            actor_hidden: vec![128, 128],
            critic_hidden: vec![128, 128],
            critic_layer_norm: false,
            learning_rate: default_learning_rate(),
            gamma: 0.99,
            tau: 0.005,
            batch_size: 256,
            n_step: 1,
            temperature: Temperature::Fixed { alpha: 0.2 },
            threads: 1,
        }
    }
}

/// Greatest number of units in a layer and of transitions in a batch; keeps every size far from overflow.
pub(crate) const SIZE_MAX: usize = 1 << 16;
/// Greatest number of weights of a network: a gigabyte, of which an update needs some twenty.
const WEIGHTS_MAX: usize = 1 << 28;
/// Greatest number of gradients and values that all chunks of a batch keep of a network: four gigabytes.
const NUMBERS_MAX: usize = 4 * WEIGHTS_MAX;

impl SacConfig {
    /// Checks every setting. Whether memory suffices is known only with the numbers per observation and action, of which
    /// there are at least one each; [`crate::Agent::new`] checks it with the true ones.
    ///
    /// # Errors
    /// Names the first setting outside its range.
    pub fn validate(&self) -> Result<(), SacError> {
        for (key, hidden) in [
            ("actor_hidden", &self.actor_hidden),
            ("critic_hidden", &self.critic_hidden),
        ] {
            let sizes = hidden.iter().all(|&units| (1..=SIZE_MAX).contains(&units));
            require(
                !hidden.is_empty() && sizes,
                key,
                hidden,
                "one or more layers of 1 to 65536 units",
            )?;
        }
        check_learning_rate(self.learning_rate)?;
        check_gamma(self.gamma)?;
        require(
            self.tau > 0.0 && self.tau <= 1.0,
            "tau",
            &self.tau,
            "above 0 and at most 1",
        )?;
        require(
            (1..=SIZE_MAX).contains(&self.batch_size),
            "batch_size",
            &self.batch_size,
            "from 1 to 65536",
        )?;
        require(
            (1..=1024).contains(&self.n_step),
            "n_step",
            &self.n_step,
            "from 1 to 1024",
        )?;
        match self.temperature {
            Temperature::Fixed { alpha } => check_alpha(alpha)?,
            Temperature::Auto {
                initial,
                target_entropy,
                learning_rate,
            } => {
                require(
                    initial.is_finite() && initial > 0.0,
                    "temperature.initial",
                    &initial,
                    "above 0",
                )?;
                if let Some(target) = target_entropy {
                    require(
                        target.is_finite(),
                        "temperature.target_entropy",
                        &target,
                        "finite",
                    )?;
                }
                let valid = learning_rate.is_finite() && learning_rate > 0.0;
                require(
                    valid,
                    "temperature.learning_rate",
                    &learning_rate,
                    "above 0",
                )?;
            }
        }
        check_threads(self.threads)?;
        self.check_memory([1, 1])
    }

    /// Refuses networks, and batches for them, that would exhaust memory; taking it would stop the program.
    fn check_memory(&self, sizes: [usize; 2]) -> Result<(), SacError> {
        for (key, shape) in [
            ("actor_hidden", actor_shape(self, sizes)),
            ("critic_hidden", critic_shape(self, sizes)),
        ] {
            require(
                weights(&shape) <= WEIGHTS_MAX,
                key,
                &shape.hidden,
                "layers with at most 268435456 weights, those of inputs and outputs included",
            )?;
            require(
                fits(&shape, self.batch_size),
                "batch_size",
                &self.batch_size,
                "smaller for networks of this size: `batch_size` times each one's units, plus `batch_size` / 64 times its \
                 weights, at most 1073741824",
            )?;
        }
        Ok(())
    }
}

// One setting each, for those that change during a run.

pub(crate) fn check_learning_rate(rate: f64) -> Result<(), SacError> {
    let valid = rate.is_finite() && rate > 0.0;
    require(valid, "learning_rate", &rate, "above 0")
}

pub(crate) fn check_gamma(gamma: f64) -> Result<(), SacError> {
    require((0.0..=1.0).contains(&gamma), "gamma", &gamma, "from 0 to 1")
}

pub(crate) fn check_alpha(alpha: f64) -> Result<(), SacError> {
    let valid = alpha.is_finite() && alpha >= 0.0;
    require(valid, "temperature.alpha", &alpha, "at least 0")
}

pub(crate) fn check_threads(threads: usize) -> Result<(), SacError> {
    require(
        (1..=256).contains(&threads),
        "threads",
        &threads,
        "from 1 to 256",
    )
}

/// Checks the numbers per observation and per action, and the memory that networks for them take.
pub(crate) fn check_sizes(config: &SacConfig, sizes: [usize; 2]) -> Result<(), SacError> {
    let [observation_size, action_size] = sizes;
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
    config.check_memory(sizes)
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
        layer_norm: false,
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

/// Whether memory suffices for a network's gradients and values of so many rows: each chunk of them keeps a gradient of its
/// own and the numbers of every unit for each of its rows.
pub(crate) fn fits(shape: &MlpShape, rows: usize) -> bool {
    let units = shape.inputs + shape.hidden.iter().sum::<usize>() + shape.outputs;
    let numbers = weights(shape).saturating_add(units.saturating_mul(CHUNK));
    numbers.saturating_mul(rows.div_ceil(CHUNK)) <= NUMBERS_MAX
}

/// Parameters of a network.
fn weights(shape: &MlpShape) -> usize {
    let sizes = shape.tensors().into_iter().map(|(_, extents)| extents);
    sizes.map(|extents| extents.iter().product::<usize>()).sum()
}

pub(crate) fn require(
    valid: bool,
    key: &'static str,
    value: &dyn std::fmt::Debug,
    requirement: &'static str,
) -> Result<(), SacError> {
    if valid {
        Ok(())
    } else {
        Err(SacError::Setting {
            key,
            value: format!("{value:?}"),
            requirement,
        })
    }
}
