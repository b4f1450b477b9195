//! The actor alone: what a controller needs.

use std::iter;

use gaitshift_nn::{Activations, Mlp, MlpShape, NamedTensor};
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::config::CHUNK;
use crate::error::SacError;
use crate::gaussian;
use crate::mirror::{Mirror, reflect};
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
            && !shape.layer_norm
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

    /// The same function in a network whose hidden layers have `units` units each: those that are new count for nothing until
    /// they have learned. Layers that have as many or more are left as they are.
    pub fn widened(&self, units: usize, rng: &mut impl Rng) -> Self {
        let shape = self.shape();
        let wide_shape = MlpShape {
            hidden: shape.hidden.iter().map(|&old| old.max(units)).collect(),
            ..shape.clone()
        };
        let mut network = Mlp::random(wide_shape, rng);
        let tensors: Vec<_> = network
            .tensors()
            .into_iter()
            .zip(&self.tensors())
            .map(|(mut wide, old)| {
                let width = |tensor: &NamedTensor<f32>| tensor.shape.get(1).copied().unwrap_or(1);
                let (columns, kept) = (width(&wide), width(old));
                let rows = wide.values.chunks_mut(columns);
                for (row, old) in rows.zip(old.values.chunks(kept)) {
                    row[..kept].copy_from_slice(old);
                    row[kept..].fill(0.0);
                }
                wide
            })
            .collect();
        network.load_tensors(&tensors);
        Self::new(network)
    }

    /// The mean of this policy and its mirror image, `(f(o) + M f(M o)) / 2` for the outputs `f` before the tanh: a policy
    /// that commutes with the mirror up to rounding. Every hidden layer has twice the units, its halves unconnected.
    pub fn mean_with_mirror_image(&self, mirror: &Mirror) -> Self {
        let shape = self.shape();
        let outputs = mirror.actor_outputs();
        let doubled = |tensor: &NamedTensor<f32>| -> Vec<f32> {
            let values = &tensor.values;
            let columns = tensor.shape.get(1).copied().unwrap_or(1);
            let rows = || values.chunks(columns);
            let nothing = || iter::repeat_n(0.0, columns);
            match tensor.name.as_str() {
                "output.weight" => rows()
                    .zip(&outputs)
                    .flat_map(|(row, &(source, sign))| {
                        let image = &values[source * columns..][..columns];
                        let image = image.iter().map(move |w| 0.5 * sign * w);
                        row.iter().map(|w| 0.5 * w).chain(image)
                    })
                    .collect(),
                "output.bias" => {
                    let mut image = vec![0.0; values.len()];
                    reflect(&outputs, values, &mut image);
                    let pairs = values.iter().zip(&image);
                    pairs.map(|(own, image)| 0.5 * (own + image)).collect()
                }
                "layers.0.weight" => {
                    let mut images = vec![0.0; values.len()];
                    for (row, image) in rows().zip(images.chunks_mut(columns)) {
                        reflect(&mirror.observation, row, image);
                    }
                    [&values[..], &images].concat()
                }
                name if name.ends_with(".bias") => values.repeat(2),
                _ => {
                    let upper = rows().flat_map(|row| row.iter().copied().chain(nothing()));
                    let lower = rows().flat_map(|row| nothing().chain(row.iter().copied()));
                    upper.chain(lower).collect()
                }
            }
        };
        let doubled_shape = MlpShape {
            hidden: shape.hidden.iter().map(|units| 2 * units).collect(),
            ..shape.clone()
        };
        let shapes = doubled_shape.tensors().into_iter();
        let tensors: Vec<_> = shapes
            .zip(&self.tensors())
            .map(|((name, shape), tensor)| NamedTensor {
                name,
                shape,
                values: doubled(tensor),
            })
            .collect();
        let mut network = Mlp::zeros(doubled_shape);
        network.load_tensors(&tensors);
        Self::new(network)
    }

    /// The policy of which this is the mean with its mirror image ([`Policy::mean_with_mirror_image`]), or one that has the same
    /// mean; nothing if it is no such mean.
    pub fn without_mirror_image(&self, mirror: &Mirror) -> Option<Self> {
        let shape = self.shape();
        let halved = |size: usize| size.is_multiple_of(2).then_some(size / 2);
        let halved_shape = MlpShape {
            hidden: shape
                .hidden
                .iter()
                .map(|&units| halved(units))
                .collect::<Option<_>>()?,
            ..shape.clone()
        };
        let tensors: Vec<_> = halved_shape
            .tensors()
            .into_iter()
            .zip(&self.tensors())
            .map(|((name, shape), doubled)| {
                let columns = doubled.shape.get(1).copied().unwrap_or(1);
                let kept = shape.get(1).copied().unwrap_or(1);
                // The outputs are the mean of the halves'.
                let factor = if name == "output.weight" { 2.0 } else { 1.0 };
                let rows = doubled.values.chunks(columns).take(shape[0]);
                let values = rows.flat_map(|row| row[..kept].iter().map(|w| factor * w));
                NamedTensor {
                    values: values.collect(),
                    name,
                    shape,
                }
            })
            .collect();
        let mut network = Mlp::zeros(halved_shape);
        network.load_tensors(&tensors);
        let half = Self::new(network);
        (half.mean_with_mirror_image(mirror).tensors() == self.tensors()).then_some(half)
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

    /// Deterministic actions tanh(mean) in [−1, 1], rows × action size, for rows × observation size.
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
         two outputs per action, and no layer normalisation"
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
