//! States with the actions taken there, which the actor goes on to imitate while it learns other things.
//!
//! A network that learns a new skill loses an old one that shares its weights. Rehearsal adds
//! w · mean |μ(s) − a|² over remembered pairs (s, a) to the actor's loss; the critics know nothing of it.

use gaitshift_nn::Scalar;
use rand::Rng;

use crate::config::require;
use crate::error::SacError;
use crate::mirror::{Mirror, reflect};
use crate::random::below;
use crate::replay::length;

/// Remembered pairs of observation and action.
#[derive(Clone, Debug, PartialEq)]
pub struct Rehearsal {
    observation_size: usize,
    action_size: usize,
    observations: Vec<f32>,
    actions: Vec<f32>,
}

impl Rehearsal {
    /// From rows × observation size and rows × action size numbers.
    ///
    /// # Errors
    /// When there is no row, the lengths do not match, or a number is not finite or an action outside \[−1, 1\].
    pub fn new(
        observation_size: usize,
        action_size: usize,
        observations: Vec<f32>,
        actions: Vec<f32>,
    ) -> Result<Self, SacError> {
        let rows = actions.len() / action_size.max(1);
        require(rows > 0, "rehearsal rows", &rows, "at least 1")?;
        length("rehearsal actions", actions.len(), rows * action_size)?;
        length(
            "rehearsal observations",
            observations.len(),
            rows * observation_size,
        )?;
        for row in 0..rows {
            let state = &observations[row * observation_size..][..observation_size];
            let action = &actions[row * action_size..][..action_size];
            if !state.iter().all(|value| value.is_finite()) {
                let what = "rehearsal observations";
                return Err(SacError::NotFinite { what, row });
            }
            let inside = action.iter().all(|value| value.abs() <= 1.0);
            require(inside, "rehearsal action", &action, "in [-1, 1]")?;
        }
        Ok(Self {
            observation_size,
            action_size,
            observations,
            actions,
        })
    }

    /// Numbers per observation and per action.
    pub fn sizes(&self) -> [usize; 2] {
        [self.observation_size, self.action_size]
    }

    /// Rows × observation size.
    pub fn observations(&self) -> &[f32] {
        &self.observations
    }

    /// Rows × action size.
    pub fn actions(&self) -> &[f32] {
        &self.actions
    }

    /// Remembered pairs.
    pub fn rows(&self) -> usize {
        self.actions.len() / self.action_size
    }

    /// Draws pairs into `out`; its last `mirrored` rows as their mirror images.
    pub(crate) fn draw(
        &self,
        rng: &mut impl Rng,
        mirrored: Option<(&Mirror, usize)>,
        out: &mut Rehearsed<f32>,
    ) {
        let rows = out.actions.len() / self.action_size;
        for (row, (to_observation, to_action)) in out
            .observations
            .chunks_exact_mut(self.observation_size)
            .zip(out.actions.chunks_exact_mut(self.action_size))
            .enumerate()
        {
            let from = below(rng, self.rows());
            let observation =
                &self.observations[from * self.observation_size..][..self.observation_size];
            let action = &self.actions[from * self.action_size..][..self.action_size];
            match mirrored.filter(|(_, mirrored)| row + mirrored >= rows) {
                Some((mirror, _)) => {
                    reflect(&mirror.observation, observation, to_observation);
                    reflect(&mirror.action, action, to_action);
                }
                None => {
                    to_observation.copy_from_slice(observation);
                    to_action.copy_from_slice(action);
                }
            }
        }
    }
}

/// The pairs of one update; none if empty.
#[derive(Clone, Debug, Default)]
pub struct Rehearsed<T> {
    /// Rows × observation size.
    pub observations: Vec<T>,
    /// Rows × action size.
    pub actions: Vec<T>,
}

impl<T: Scalar> Rehearsed<T> {
    /// Rows of zeros.
    pub fn zeros(rows: usize, observation_size: usize, action_size: usize) -> Self {
        Self {
            observations: vec![T::ZERO; rows * observation_size],
            actions: vec![T::ZERO; rows * action_size],
        }
    }
}

/// Derivative of weight · Σ |μ(s) − a|² in the actor's outputs (means, then deviations, which it leaves
/// alone), and the unweighted sum.
pub(crate) fn imitate<T: Scalar>(
    size: usize,
    out: &[T],
    actions: &[T],
    weight: T,
    d_out: &mut [T],
) -> T {
    let two = T::from_f64(2.0);
    let mut sum = T::ZERO;
    for ((out, action), d_out) in out
        .chunks_exact(2 * size)
        .zip(actions.chunks_exact(size))
        .zip(d_out.chunks_exact_mut(2 * size))
    {
        d_out.fill(T::ZERO);
        for ((out, &action), d_out) in out[..size].iter().zip(action).zip(d_out) {
            let mean = out.tanh();
            let difference = mean - action;
            sum += difference * difference;
            *d_out = two * weight * difference * (T::ONE - mean * mean);
        }
    }
    sum
}
