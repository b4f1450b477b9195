//! A policy that learns from remembered pairs alone: behaviour cloning. [`crate::Agent::rehearse`] adds the same loss to that of
//! Soft Actor-Critic; here there is nothing else.

use std::ops::Range;

use gaitshift_nn::{Activations, Deltas, Mlp, Optimiser, Step, Trained, Workers};
use rand::Rng;

use crate::config::{CHUNK, check_learning_rate, require};
use crate::error::SacError;
use crate::losses::{Part, rows_of};
use crate::mirror::{Mirror, reflect};
use crate::policy::Policy;
use crate::rehearsal::{Rehearsal, Rehearsed, imitate};
use crate::replay::length;

/// A policy that is being fitted to remembered pairs (s, a) by steps of Adam down Σ w · mean |μ(s) − a|² over sets of pairs with
/// weights w. With a mirror, μ is that of the policy's mean with its mirror image ([`Policy::mean_with_mirror_image`]), which is what
/// acts. Its deviations have no part in that loss; they change with the layers that they share with the means.
#[derive(Debug)]
pub struct Imitation {
    actor: Trained<f32>,
    mirror: Option<Mirror>,
    rehearsed: Rehearsed<f32>,
    /// Observations of a chunk, and after them their mirror images.
    observations: Vec<f32>,
    activations: Activations<f32>,
    deltas: Deltas<f32>,
    /// Outputs of a chunk, those with its mirror images averaged, and derivatives in these and in those.
    out: Vec<f32>,
    d_mean: Vec<f32>,
    d_out: Vec<f32>,
    parts: Vec<Part<f32>>,
    optimiser: Optimiser,
    workers: Workers,
}

impl Imitation {
    /// Begins with `policy`; every step takes `rows` pairs from each set.
    ///
    /// # Errors
    /// When there are no rows, or the mirror is none for this policy.
    pub fn new(policy: &Policy, mirror: Option<Mirror>, rows: usize) -> Result<Self, SacError> {
        require(rows > 0, "imitation rows", &rows, "at least 1")?;
        let (inputs, size) = (policy.observation_size(), policy.action_size());
        if let Some(mirror) = &mirror {
            mirror.validate(inputs, size)?;
        }
        let network: Mlp<f32> = policy.network().clone();
        let images = 1 + usize::from(mirror.is_some());
        let outputs = CHUNK * 2 * size;
        Ok(Self {
            rehearsed: Rehearsed::zeros(rows, inputs, size),
            observations: vec![0.0; images * CHUNK * inputs],
            activations: network.activations(images * CHUNK),
            deltas: network.deltas(images * CHUNK),
            out: vec![0.0; outputs],
            d_mean: vec![0.0; outputs],
            d_out: vec![0.0; images * outputs],
            parts: Vec::new(),
            optimiser: Optimiser::default(),
            workers: Workers::new(1),
            actor: Trained::new(network),
            mirror,
        })
    }

    /// One step. Gives mean |μ(s) − a|² of each set's pairs before it, unweighted.
    ///
    /// # Errors
    /// A set of other sizes, a weight below 0, a learning rate that is not above 0, or a loss that is not finite.
    pub fn step(
        &mut self,
        sets: &[(&Rehearsal, f64)],
        learning_rate: f64,
        rng: &mut impl Rng,
    ) -> Result<Vec<f64>, SacError> {
        check_learning_rate(learning_rate)?;
        require(!sets.is_empty(), "imitation sets", &0, "at least 1")?;
        let shape = self.actor.network.shape();
        let (inputs, size) = (shape.inputs, shape.outputs / 2);
        let rows = self.rehearsed.actions.len() / size;
        let chunks = rows.div_ceil(CHUNK);
        while self.parts.len() < sets.len() * chunks {
            self.parts.push(Part::new(&self.actor.network));
        }
        let mut losses = Vec::with_capacity(sets.len());
        for (index, (set, weight)) in sets.iter().enumerate() {
            let [observation_size, action_size] = set.sizes();
            length("an imitated observation", observation_size, inputs)?;
            length("an imitated action", action_size, size)?;
            let valid = *weight >= 0.0 && weight.is_finite();
            require(valid, "imitation weight", weight, "at least 0")?;
            set.draw(rng, None, &mut self.rehearsed);
            let per_row = (weight / rows as f64) as f32;
            let sums = (0..chunks).map(|chunk| {
                let part = index * chunks + chunk;
                f64::from(self.chunk(rows_of(chunk, rows), per_row, part))
            });
            losses.push(sums.sum::<f64>() / rows as f64);
        }
        let parts = &self.parts[..sets.len() * chunks];
        let step = Step {
            learning_rate,
            followers: [None],
        };
        let [norm] = self
            .optimiser
            .step(&mut self.workers, [&mut self.actor], [parts], step);
        self.actor.refresh();
        let finite = norm.is_finite() && losses.iter().all(|loss| loss.is_finite());
        if !finite {
            return Err(SacError::Diverged {
                update: self.actor.steps,
                what: "the imitation's gradient",
                value: norm,
            });
        }
        Ok(losses)
    }

    /// Gradient of the loss of the chosen pairs into a part; gives Σ |μ(s) − a|².
    fn chunk(&mut self, chosen: Range<usize>, per_row: f32, part: usize) -> f32 {
        let network = &self.actor.network;
        let (inputs, outputs) = (network.shape().inputs, network.shape().outputs);
        let (size, rows) = (outputs / 2, chosen.len());
        let own = &self.rehearsed.observations[chosen.start * inputs..chosen.end * inputs];
        let actions = &self.rehearsed.actions[chosen.start * size..chosen.end * size];
        let (first, images) = self.observations.split_at_mut(rows * inputs);
        first.copy_from_slice(own);
        let of_outputs = self.mirror.as_ref().map(Mirror::actor_outputs);
        if let Some(mirror) = &self.mirror {
            let rows = own
                .chunks_exact(inputs)
                .zip(images.chunks_exact_mut(inputs));
            rows.for_each(|(own, image)| reflect(&mirror.observation, own, image));
        }
        let all = rows * (1 + usize::from(self.mirror.is_some()));
        network.forward(all, &self.observations, inputs, &mut self.activations);
        let (own, images) = self.activations.out.split_at(rows * outputs);
        let out = &mut self.out[..rows * outputs];
        out.copy_from_slice(own);
        if let Some(of_outputs) = &of_outputs {
            let rows = out
                .chunks_exact_mut(outputs)
                .zip(images.chunks_exact(outputs));
            for (out, image) in rows {
                for (out, &(source, sign)) in out.iter_mut().zip(of_outputs) {
                    *out = 0.5 * (*out + sign * image[source]);
                }
            }
        }
        let d_mean = &mut self.d_mean[..rows * outputs];
        let sum = imitate(size, out, actions, per_row, d_mean);
        let (d_own, d_images) = self.d_out.split_at_mut(rows * outputs);
        d_own.copy_from_slice(d_mean);
        if let Some(of_outputs) = &of_outputs {
            d_own.iter_mut().for_each(|d| *d *= 0.5);
            // The mirror undoes itself, so that it is its own transpose.
            let rows = d_own
                .chunks_exact(outputs)
                .zip(d_images.chunks_exact_mut(outputs));
            rows.for_each(|(d_own, d_image)| reflect(of_outputs, d_own, d_image));
        }
        network.backward(
            &self.actor.transposed,
            all,
            &self.observations,
            inputs,
            &self.activations,
            &self.d_out[..all * outputs],
            &mut self.deltas,
            &mut self.parts[part].gradient,
        );
        sum
    }

    /// The policy as it is now, without its mirror image.
    pub fn policy(&self) -> Policy {
        Policy::new(self.actor.network.clone())
    }
}
