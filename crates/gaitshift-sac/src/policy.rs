//! The actor alone: what a controller needs.

use std::iter;

use gaitshift_nn::{Activations, Mlp, MlpShape, NamedTensor};
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::config::require;
use crate::error::SacError;
use crate::gaussian;
use crate::losses::CHUNK;
use crate::mirror::Mirror;
use crate::random::fill_normal;
use crate::replay::length;

/// A policy network with its scratch; light enough to give each thread its own.
#[derive(Clone, Debug)]
pub struct Policy {
    network: Mlp<f32>,
    scratch: PolicyScratch,
    noise: Vec<f32>,
}

/// Scratch of a policy's forward pass.
#[derive(Clone, Debug)]
pub(crate) struct PolicyScratch {
    activations: Activations<f32>,
}

impl PolicyScratch {
    pub fn new(network: &Mlp<f32>) -> Self {
        Self {
            activations: network.activations(CHUNK),
        }
    }

    /// Actions and their log-probabilities for as many rows as `log_probs` has, given their noise.
    pub fn sample(
        &mut self,
        network: &Mlp<f32>,
        observations: &[f32],
        noise: &[f32],
        actions: &mut [f32],
        log_probs: &mut [f32],
    ) -> Result<(), SacError> {
        let (inputs, size) = (network.shape().inputs, network.shape().outputs / 2);
        length("observations", observations.len(), log_probs.len() * inputs)?;
        length("actions", actions.len(), log_probs.len() * size)?;
        for (((observations, noise), actions), log_probs) in observations
            .chunks(CHUNK * inputs)
            .zip(noise.chunks(CHUNK * size))
            .zip(actions.chunks_mut(CHUNK * size))
            .zip(log_probs.chunks_mut(CHUNK))
        {
            let rows = log_probs.len();
            network.forward(rows, observations, inputs, &mut self.activations);
            gaussian::sample(size, &self.activations.out, noise, actions, log_probs);
        }
        Ok(())
    }

    /// Mean actions for as many rows as `actions` has.
    pub fn mean_action(
        &mut self,
        network: &Mlp<f32>,
        observations: &[f32],
        actions: &mut [f32],
    ) -> Result<(), SacError> {
        let (inputs, size) = (network.shape().inputs, network.shape().outputs / 2);
        let rows = actions.len() / size;
        length("actions", actions.len(), rows * size)?;
        length("observations", observations.len(), rows * inputs)?;
        for (observations, actions) in observations
            .chunks(CHUNK * inputs)
            .zip(actions.chunks_mut(CHUNK * size))
        {
            network.forward(
                actions.len() / size,
                observations,
                inputs,
                &mut self.activations,
            );
            gaussian::mean_action(size, &self.activations.out, actions);
        }
        Ok(())
    }
}

impl Policy {
    pub(crate) fn new(network: Mlp<f32>) -> Self {
        Self {
            scratch: PolicyScratch::new(&network),
            network,
            noise: Vec::new(),
        }
    }

    /// Its network.
    pub(crate) fn network(&self) -> &Mlp<f32> {
        &self.network
    }

    /// A policy from its named tensors, in the layout of [`Policy::tensors`].
    ///
    /// # Errors
    /// Names the first tensor that is missing or has the wrong shape, or a size that is not possible.
    pub fn from_tensors(
        shape: MlpShape,
        tensors: &[NamedTensor<f32>],
    ) -> Result<Self, PolicyError> {
        let sizes = |size: usize| (1..=1usize << 16).contains(&size);
        let hidden = !shape.hidden.is_empty() && shape.hidden.iter().all(|&units| sizes(units));
        if !(hidden
            && sizes(shape.inputs)
            && sizes(shape.outputs)
            && shape.outputs.is_multiple_of(2))
        {
            return Err(PolicyError::Shape { shape });
        }
        // Before any memory is taken for a network of those sizes: whoever holds the tensors has room for it.
        for (name, shape) in shape.tensors() {
            let Some(tensor) = tensors.iter().find(|tensor| tensor.name == name) else {
                return Err(PolicyError::Missing { name });
            };
            if tensor.shape != shape || tensor.values.len() != shape.iter().product::<usize>() {
                return Err(PolicyError::TensorShape {
                    name,
                    expected: shape,
                    found: tensor.shape.clone(),
                });
            }
            if !tensor.values.iter().all(|value| value.is_finite()) {
                return Err(PolicyError::NotFinite { name });
            }
        }
        let mut network = Mlp::zeros(shape);
        network.load_tensors(tensors);
        Ok(Self::new(network))
    }

    /// Parameters by name (`layers.0.weight`, …, `output.bias`), weights as outputs × inputs; the outputs are the
    /// means, then the logarithms of the deviations.
    pub fn tensors(&self) -> Vec<NamedTensor<f32>> {
        self.network.tensors()
    }

    /// The mean of this policy and its mirror image, `(f(o) + M f(M o)) / 2` for the outputs `f` before the tanh: a policy
    /// that commutes with the mirror up to rounding. Every hidden layer has twice the units, its halves unconnected.
    ///
    /// # Errors
    /// With layer normalisation, which would be over all units instead of each half.
    pub fn mean_with_mirror_image(&self, mirror: &Mirror) -> Result<Self, SacError> {
        let shape = self.shape();
        require(
            !shape.layer_norm,
            "actor_layer_norm",
            &shape.layer_norm,
            "false for a mean of the actor and its mirror image",
        )?;
        let (inputs, outputs) = (&mirror.observation, mirror.actor_outputs());
        let last = shape.hidden.len();
        let doubled = |(index, tensor): (usize, &NamedTensor<f32>)| {
            // Weights and biases by turns, one pair per layer.
            let (layer, is_bias) = (index / 2, index % 2 == 1);
            let columns = if is_bias { 1 } else { tensor.shape[1] };
            let rows = || tensor.values.chunks(columns);
            let mut values = Vec::with_capacity(4 * tensor.values.len());
            if layer == last {
                for (row, &(source, sign)) in rows().zip(&outputs) {
                    let image = &tensor.values[source * columns..][..columns];
                    if is_bias {
                        values.push(0.5 * (row[0] + sign * image[0]));
                    } else {
                        values.extend(row.iter().map(|w| 0.5 * w));
                        values.extend(image.iter().map(|w| 0.5 * sign * w));
                    }
                }
            } else if is_bias {
                values.extend_from_slice(&tensor.values);
                values.extend_from_slice(&tensor.values);
            } else if layer == 0 {
                values.extend_from_slice(&tensor.values);
                // Each weight goes where its observation's mirror image stands.
                for row in rows() {
                    values.extend(inputs.iter().map(|&(source, sign)| sign * row[source]));
                }
            } else {
                let nothing = || iter::repeat_n(0.0, columns);
                for row in rows() {
                    values.extend(row.iter().copied().chain(nothing()));
                }
                for row in rows() {
                    values.extend(nothing().chain(row.iter().copied()));
                }
            }
            values
        };
        let doubled_shape = MlpShape {
            hidden: shape.hidden.iter().map(|units| 2 * units).collect(),
            ..shape.clone()
        };
        let values = self.tensors();
        let values = values.iter().enumerate().map(doubled);
        let tensors = doubled_shape.tensors().into_iter().zip(values);
        let tensors: Vec<_> = tensors
            .map(|((name, shape), values)| NamedTensor {
                name,
                shape,
                values,
            })
            .collect();
        let mut network = Mlp::zeros(doubled_shape);
        network.load_tensors(&tensors);
        Ok(Self::new(network))
    }

    /// Sizes of the network; it has two outputs per action.
    pub fn shape(&self) -> &MlpShape {
        self.network.shape()
    }

    /// Numbers per observation.
    pub fn observation_size(&self) -> usize {
        self.shape().inputs
    }

    /// Numbers per action.
    pub fn action_size(&self) -> usize {
        self.shape().outputs / 2
    }

    /// Deterministic actions tanh(mean) in (−1, 1), rows × action size, for rows × observation size.
    ///
    /// # Errors
    /// When the lengths do not match.
    pub fn mean_action(
        &mut self,
        observations: &[f32],
        actions: &mut [f32],
    ) -> Result<(), SacError> {
        self.scratch
            .mean_action(&self.network, observations, actions)
    }

    /// Random actions and their ln π, one per row.
    ///
    /// # Errors
    /// When the lengths do not match.
    pub fn sample(
        &mut self,
        observations: &[f32],
        rng: &mut Xoshiro256PlusPlus,
        actions: &mut [f32],
        log_probs: &mut [f32],
    ) -> Result<(), SacError> {
        self.noise.resize(actions.len(), 0.0);
        fill_normal(rng, &mut self.noise);
        self.scratch
            .sample(&self.network, observations, &self.noise, actions, log_probs)
    }
}

/// Why tensors make no policy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PolicyError {
    /// Impossible sizes.
    #[error(
        "a policy cannot have the sizes {shape:?}: every size must be from 1 to 65536, there must be a hidden layer, \
         and two outputs per action"
    )]
    Shape {
        /// The sizes.
        shape: MlpShape,
    },
    /// A tensor is missing.
    #[error(
        "the policy's tensor `{name}` is missing: the file is incomplete or of another program"
    )]
    Missing {
        /// Its name.
        name: String,
    },
    /// A tensor has the wrong shape.
    #[error(
        "the policy's tensor `{name}` has the shape {found:?}, but its sizes ask for {expected:?}"
    )]
    TensorShape {
        /// Its name.
        name: String,
        /// By the sizes.
        expected: Vec<usize>,
        /// In the file.
        found: Vec<usize>,
    },
    /// A parameter is not finite.
    #[error(
        "the policy's tensor `{name}` holds a number that is not finite: it comes from a diverged training"
    )]
    NotFinite {
        /// Its name.
        name: String,
    },
}
