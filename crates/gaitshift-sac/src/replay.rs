//! Replay buffer of several environments stepped together.
//!
//! A ring of time rows; each row holds one transition of every environment, so the successor of a
//! transition is one row further in the same environment and an n-step window is a walk along it. The time
//! limit is *truncation*: the window stops and bootstraps. Only termination cuts the future off.

use std::ops::Range;

use gaitshift_nn::{Scalar, prefetch};
use rand::Rng;

use crate::config::{SIZE_MAX, require};
use crate::error::SacError;
use crate::mirror::{Mirror, reflect};
use crate::random::below;

/// Numbers of a transition besides observations and action.
const EXTRAS: usize = 2;
const LOG_PROB: usize = 0;
const REWARD: usize = 1;

/// Flags of a slot.
const TERMINATED: u8 = 1;
const TRUNCATED: u8 = 2;
const INVALID: u8 = 4;

/// One step of all environments, environment after environment.
#[derive(Clone, Copy, Debug)]
pub struct Transitions<'a> {
    /// Environments × observation size: where the action was taken.
    pub observations: &'a [f32],
    /// Environments × action size.
    pub actions: &'a [f32],
    /// ln π of each action under the policy that took it; used for n-step sums only.
    pub log_probs: &'a [f32],
    /// Rewards.
    pub rewards: &'a [f32],
    /// Environments × observation size: where the action led, before any reset.
    pub next_observations: &'a [f32],
    /// The task ended: nothing follows.
    pub terminated: &'a [bool],
    /// The episode was cut off: something would have followed.
    pub truncated: &'a [bool],
    /// False for a step that must not be learned from (a diverged simulation); it is kept in the
    /// ring as a gap, and its numbers are not looked at.
    pub valid: &'a [bool],
}

/// How windows are formed and mirrored.
#[derive(Clone, Copy, Debug)]
pub struct Sampling<'a> {
    /// Greatest number of rewards summed, at least 1.
    pub n_step: usize,
    /// Discount γ per step.
    pub gamma: f64,
    /// Weight of the entropy of the steps within a window.
    pub alpha: f64,
    /// Mirror and how many rows at the end of the batch are replaced by their mirror image.
    pub mirrored: Option<(&'a Mirror, usize)>,
}

/// Transitions to learn from, row by row.
#[derive(Clone, Debug, Default)]
pub struct Batch<T> {
    /// Rows × observation size.
    pub observations: Vec<T>,
    /// Rows × action size.
    pub actions: Vec<T>,
    /// Reward sums R = Σ γ^k r_k − α Σ_{k≥1} γ^k ln π_k.
    pub rewards: Vec<T>,
    /// Factor on the value of the next observation: γ^steps, or 0 after termination.
    pub discounts: Vec<T>,
    /// Rows × observation size: where the window ended.
    pub next_observations: Vec<T>,
}

impl<T: Scalar> Batch<T> {
    /// A batch of zeros.
    pub fn zeros(rows: usize, observation_size: usize, action_size: usize) -> Self {
        let column = || vec![T::ZERO; rows];
        Self {
            observations: vec![T::ZERO; rows * observation_size],
            actions: vec![T::ZERO; rows * action_size],
            rewards: column(),
            discounts: column(),
            next_observations: vec![T::ZERO; rows * observation_size],
        }
    }

    /// Rows.
    pub fn rows(&self) -> usize {
        self.rewards.len()
    }

    /// Takes over the chosen rows of another batch, as many as this one has.
    pub(crate) fn copy_rows(&mut self, from: &Self, chosen: Range<usize>) {
        let copy = |from: &[T], to: &mut [T]| {
            let size = to.len() / chosen.len();
            to.copy_from_slice(&from[chosen.start * size..chosen.end * size]);
        };
        copy(&from.observations, &mut self.observations);
        copy(&from.actions, &mut self.actions);
        copy(&from.rewards, &mut self.rewards);
        copy(&from.discounts, &mut self.discounts);
        copy(&from.next_observations, &mut self.next_observations);
    }
}

/// Ring of transitions; see the module's description.
#[derive(Clone, Debug)]
pub struct ReplayBuffer {
    pub(crate) observation_size: usize,
    pub(crate) action_size: usize,
    pub(crate) environments: usize,
    /// Time rows of the ring.
    pub(crate) rows: usize,
    /// Time rows written so far, at most `rows`.
    pub(crate) filled: usize,
    /// Time row written next.
    pub(crate) head: usize,
    /// Valid transitions held.
    pub(crate) valid: usize,
    /// Slot after slot as far as filled: observation, action, next observation, extras.
    pub(crate) data: Vec<f32>,
    /// Flags of each slot, apart so that drawing valid slots touches little memory.
    pub(crate) flags: Vec<u8>,
}

impl ReplayBuffer {
    /// An empty buffer of at most `capacity` transitions (rounded down to whole time rows) of `environments`
    /// environments.
    ///
    /// # Errors
    /// When a size is 0 or the capacity does not hold one row.
    pub fn new(
        capacity: usize,
        environments: usize,
        observation_size: usize,
        action_size: usize,
    ) -> Result<Self, SacError> {
        let sizes = 1..=SIZE_MAX;
        require(
            sizes.contains(&environments),
            "environments",
            &environments,
            "from 1 to 65536",
        )?;
        require(
            sizes.contains(&observation_size),
            "observation_size",
            &observation_size,
            "from 1 to 65536",
        )?;
        require(
            sizes.contains(&action_size),
            "action_size",
            &action_size,
            "from 1 to 65536",
        )?;
        let width = 2 * observation_size + action_size + EXTRAS;
        require(
            capacity >= environments,
            "replay_capacity",
            &capacity,
            "at least the number of environments",
        )?;
        let rows = capacity / environments;
        // Address space is taken at once, so that a capacity beyond the machine's memory is an error here;
        // memory itself is used as the ring fills.
        let (mut data, mut flags) = (Vec::new(), Vec::new());
        let reserved = (rows * environments)
            .checked_mul(width)
            .is_some_and(|len| data.try_reserve_exact(len).is_ok())
            && flags.try_reserve_exact(rows * environments).is_ok();
        require(
            reserved,
            "replay_capacity",
            &capacity,
            "small enough for this machine's memory",
        )?;
        Ok(Self {
            observation_size,
            action_size,
            environments,
            rows,
            filled: 0,
            head: 0,
            valid: 0,
            data,
            flags,
        })
    }

    /// Transitions held, gaps included.
    pub fn len(&self) -> usize {
        self.filled * self.environments
    }

    /// Whether nothing was stored yet.
    pub fn is_empty(&self) -> bool {
        self.filled == 0
    }

    /// Transitions that can be sampled.
    pub fn valid_len(&self) -> usize {
        self.valid
    }

    /// Greatest number of transitions.
    pub fn capacity(&self) -> usize {
        self.rows * self.environments
    }

    /// Environments.
    pub fn environments(&self) -> usize {
        self.environments
    }

    /// Numbers per observation.
    pub fn observation_size(&self) -> usize {
        self.observation_size
    }

    /// Numbers per action.
    pub fn action_size(&self) -> usize {
        self.action_size
    }

    pub(crate) fn width(&self) -> usize {
        2 * self.observation_size + self.action_size + EXTRAS
    }

    /// Name, offset in a slot and size of each part of a transition.
    pub(crate) fn columns(&self) -> [(&'static str, usize, usize); 5] {
        let (observation, action) = (self.observation_size, self.action_size);
        let extras = self.width() - EXTRAS;
        [
            ("observations", 0, observation),
            ("actions", observation, action),
            ("next_observations", observation + action, observation),
            ("log_probs", extras + LOG_PROB, 1),
            ("rewards", extras + REWARD, 1),
        ]
    }

    /// Brings the count of valid transitions up to date with the flags.
    pub(crate) fn count_valid(&mut self) {
        self.valid = self
            .flags
            .iter()
            .filter(|&flags| flags & INVALID == 0)
            .count();
    }

    fn slot(&self, slot: usize) -> &[f32] {
        let width = self.width();
        &self.data[slot * width..][..width]
    }

    /// Stores one step of every environment, over the oldest where the ring is full.
    ///
    /// # Errors
    /// When a slice has the wrong length, or a valid transition holds a number that is not finite; nothing is
    /// stored then.
    pub fn push(&mut self, step: Transitions<'_>) -> Result<(), SacError> {
        let (environments, observation_size, action_size) =
            (self.environments, self.observation_size, self.action_size);
        let floats = [
            ("observations", step.observations, observation_size),
            ("actions", step.actions, action_size),
            ("log_probs", step.log_probs, 1),
            ("rewards", step.rewards, 1),
            (
                "next_observations",
                step.next_observations,
                observation_size,
            ),
        ];
        let flags = [
            ("terminated", step.terminated),
            ("truncated", step.truncated),
            ("valid", step.valid),
        ];
        for (what, slice) in flags {
            length(what, slice.len(), environments)?;
        }
        for (what, slice, size) in floats {
            length(what, slice.len(), environments * size)?;
            for (environment, values) in slice.chunks_exact(size).enumerate() {
                if step.valid[environment] && !values.iter().all(|value| value.is_finite()) {
                    return Err(SacError::NotFinite {
                        what,
                        row: environment,
                    });
                }
            }
        }

        let width = self.width();
        let filling = self.filled < self.rows;
        if filling {
            // Within the capacity reserved at the start: no allocation.
            self.data
                .resize(self.data.len() + environments * width, 0.0);
            self.flags.resize(self.flags.len() + environments, 0);
        }
        for environment in 0..environments {
            let slot = self.head * environments + environment;
            if !filling && self.flags[slot] & INVALID == 0 {
                self.valid -= 1;
            }
            let row = |size: usize| environment * size..(environment + 1) * size;
            let (observation, rest) =
                self.data[slot * width..][..width].split_at_mut(observation_size);
            let (action, rest) = rest.split_at_mut(action_size);
            let (next_observation, extras) = rest.split_at_mut(observation_size);
            observation.copy_from_slice(&step.observations[row(observation_size)]);
            action.copy_from_slice(&step.actions[row(action_size)]);
            next_observation.copy_from_slice(&step.next_observations[row(observation_size)]);
            extras[LOG_PROB] = step.log_probs[environment];
            extras[REWARD] = step.rewards[environment];
            self.flags[slot] = TERMINATED * u8::from(step.terminated[environment])
                + TRUNCATED * u8::from(step.truncated[environment])
                + INVALID * u8::from(!step.valid[environment]);
            self.valid += usize::from(step.valid[environment]);
        }
        self.head = (self.head + 1) % self.rows;
        self.filled = (self.filled + 1).min(self.rows);
        Ok(())
    }

    /// Draws transitions uniformly from the valid ones, as many as `slots` is long.
    ///
    /// # Errors
    /// When no valid transition is held.
    pub fn draw(&self, rng: &mut impl Rng, slots: &mut [usize]) -> Result<(), SacError> {
        if self.valid == 0 {
            return Err(SacError::EmptyReplay);
        }
        for place in slots {
            *place = loop {
                let slot = below(rng, self.len());
                if self.flags[slot] & INVALID == 0 {
                    break slot;
                }
            };
        }
        Ok(())
    }

    /// Fills `batch` with the windows that start at the given slots (0 to [`ReplayBuffer::len`], as
    /// [`ReplayBuffer::draw`] gives them).
    ///
    /// A window runs until it has `n_step` rewards, a terminated or truncated step, the newest row or a gap,
    /// and bootstraps from the observation it ends in unless it terminated.
    ///
    /// # Errors
    /// When there are not as many slots as the batch has rows, or one is not held.
    // For the tests; an agent's threads each gather a part.
    #[doc(hidden)]
    pub fn gather(
        &self,
        slots: &[usize],
        sampling: &Sampling<'_>,
        batch: &mut Batch<f32>,
    ) -> Result<(), SacError> {
        length("slots", slots.len(), batch.rows())?;
        length(
            "batch.observations",
            batch.observations.len(),
            slots.len() * self.observation_size,
        )?;
        length(
            "batch.actions",
            batch.actions.len(),
            slots.len() * self.action_size,
        )?;
        length(
            "batch.next_observations",
            batch.next_observations.len(),
            slots.len() * self.observation_size,
        )?;
        for &slot in slots {
            require(
                slot < self.len(),
                "slot",
                &slot,
                "below the number of transitions held",
            )?;
        }
        self.gather_part(slots, 0..slots.len(), sampling, batch);
        Ok(())
    }

    /// The part of [`ReplayBuffer::gather`] that belongs to some of its slots, to the first rows of `batch`; what
    /// that checks holds.
    pub(crate) fn gather_part(
        &self,
        slots: &[usize],
        part: Range<usize>,
        sampling: &Sampling<'_>,
        batch: &mut Batch<f32>,
    ) {
        for &slot in &slots[part.clone()] {
            // The transitions of a batch lie far apart, and the waits for them then overlap.
            prefetch(self.slot(slot));
        }
        for (row, place) in part.enumerate() {
            let mirror = sampling
                .mirrored
                .filter(|&(_, mirrored)| place + mirrored >= slots.len())
                .map(|(mirror, _)| mirror);
            self.window(slots[place], sampling, mirror, row, batch);
        }
    }

    /// Writes the window that starts at `slot` to row `row` of `batch`.
    fn window(
        &self,
        slot: usize,
        sampling: &Sampling<'_>,
        mirror: Option<&Mirror>,
        row: usize,
        batch: &mut Batch<f32>,
    ) {
        let (observation_size, action_size) = (self.observation_size, self.action_size);
        let copy = |map: Option<&[(usize, f32)]>, from: &[f32], to: &mut [f32]| match map {
            Some(map) => reflect(map, from, to),
            None => to.copy_from_slice(from),
        };
        let observation_map = mirror.map(|mirror| &mirror.observation[..]);
        let action_map = mirror.map(|mirror| &mirror.action[..]);

        let first = self.slot(slot);
        let observations = &mut batch.observations[row * observation_size..][..observation_size];
        copy(observation_map, &first[..observation_size], observations);
        let actions = &mut batch.actions[row * action_size..][..action_size];
        copy(
            action_map,
            &first[observation_size..][..action_size],
            actions,
        );

        let newest = (self.head + self.rows - 1) % self.rows;
        let mut slot = slot;
        let mut sum = 0.0;
        let mut discount = 1.0;
        let mut steps = 0;
        let (last, terminated) = loop {
            let transition = self.slot(slot);
            let extras = &transition[self.width() - EXTRAS..];
            let mut reward = f64::from(extras[REWARD]);
            if steps > 0 {
                reward -= sampling.alpha * f64::from(extras[LOG_PROB]);
            }
            sum += discount * reward;
            discount *= sampling.gamma;
            steps += 1;
            let flags = self.flags[slot];
            let time = slot / self.environments;
            let ended =
                flags & (TERMINATED | TRUNCATED) != 0 || steps >= sampling.n_step || time == newest;
            let next = (slot + self.environments) % self.capacity();
            if ended || self.flags[next] & INVALID != 0 {
                break (transition, flags & TERMINATED != 0);
            }
            slot = next;
        };
        batch.rewards[row] = sum as f32;
        batch.discounts[row] = if terminated { 0.0 } else { discount as f32 };
        let next_observations =
            &mut batch.next_observations[row * observation_size..][..observation_size];
        copy(
            observation_map,
            &last[observation_size + action_size..][..observation_size],
            next_observations,
        );
    }
}

pub(crate) fn length(what: &'static str, found: usize, expected: usize) -> Result<(), SacError> {
    if found == expected {
        Ok(())
    } else {
        Err(SacError::Length {
            what,
            found,
            expected,
        })
    }
}
