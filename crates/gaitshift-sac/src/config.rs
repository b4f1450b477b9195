//! Settings of the learner.

use serde::{Deserialize, Serialize};

use crate::error::SacError;

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
/// Greatest number of weights between the hidden layers of a network: a gigabyte, of which an update needs some twenty.
const WEIGHTS_MAX: usize = 1 << 28;

impl SacConfig {
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
            let weights: usize = hidden.windows(2).map(|pair| pair[0] * pair[1]).sum();
            require(
                weights <= WEIGHTS_MAX,
                key,
                hidden,
                "layers with at most 268435456 weights between them",
            )?;
            // Each 64 transitions of a batch have gradients of their own.
            require(
                weights.saturating_mul(self.batch_size.div_ceil(64)) <= 4 * WEIGHTS_MAX,
                "batch_size",
                &self.batch_size,
                "smaller for networks of this size: their weights times `batch_size` / 64 at most 1073741824",
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
        check_threads(self.threads)
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
