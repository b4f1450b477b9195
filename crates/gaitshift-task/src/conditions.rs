//! What holds during one episode: its body and its ground, and the delay, the strength, the pushes and the sensors' error as
//! they are at the moment.

use crate::observation::OBSERVATION_SIZE;
use crate::ranges::uniform;
use crate::{PushRanges, SensorNoise, TerrainParameters};
use gaitshift_body::{Body, BodyParameters, ParameterError};
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Longest delay of the actuators, in s.
pub(crate) const LONGEST_LATENCY_S: f64 = 1.0;

/// What one episode has drawn, and what its delay and its sensors hold at the moment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Conditions {
    /// The body.
    pub body: BodyParameters,
    latency_steps: u32,
    /// Commands that have not been carried out to their end, the oldest first.
    pending: VecDeque<[f64; 2]>,
    noise: SensorNoise,
    /// What the sensors add to the observation now.
    error: [f64; OBSERVATION_SIZE],
    /// Share of its force that the right and the left actuator still have.
    #[serde(default = "full_force", skip_serializing_if = "is_full_force")]
    pub actuator_factor: [f64; 2],
    /// The ground, where it is not flat.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub terrain: Option<TerrainParameters>,
    /// What pushes are drawn from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pushes: Option<PushRanges>,
    /// The push under way: its force, forward and up in N, and the integration steps that are left of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    push: Option<([f64; 2], u32)>,
}

fn full_force() -> [f64; 2] {
    [1.0; 2]
}

fn is_full_force(factor: &[f64; 2]) -> bool {
    *factor == full_force()
}

impl Conditions {
    /// What holds from now on.
    pub fn new(
        body: BodyParameters,
        latency_steps: u32,
        noise: SensorNoise,
        rng: &mut impl Rng,
    ) -> Self {
        let mut conditions = Self {
            body,
            latency_steps,
            pending: VecDeque::new(),
            noise,
            error: [0.0; OBSERVATION_SIZE],
            actuator_factor: full_force(),
            terrain: None,
            pushes: None,
            push: None,
        };
        conditions.sense(rng);
        conditions
    }

    /// Whether its ground is one that can be drawn; a damaged file may hold any.
    pub fn has_possible_ground(&self) -> bool {
        let terrain = self.terrain.as_ref();
        terrain.is_none_or(|terrain| terrain.validate("terrain").is_ok())
    }

    /// The body that was drawn, on its ground.
    pub fn place(&self) -> Result<Body, ParameterError> {
        let body = Body::new(self.body.clone())?;
        let terrain = self.terrain.as_ref().and_then(TerrainParameters::terrain);
        Ok(match terrain {
            Some(terrain) => body.on(terrain),
            None => body,
        })
    }

    /// What of a command is left with the actuators as strong as they are.
    pub fn weaken(&self, command: [f64; 2]) -> [f64; 2] {
        if is_full_force(&self.actuator_factor) {
            return command;
        }
        std::array::from_fn(|i| self.actuator_factor[i] * command[i].clamp(-1.0, 1.0))
    }

    /// Takes the pushes on by a control period of `steps` integration steps of `step_s`. Returns the force of the one under
    /// way, or of one that begins now, and for how many of these steps it acts.
    pub fn push(&mut self, steps: u32, step_s: f64, rng: &mut impl Rng) -> Option<([f64; 2], u32)> {
        let ranges = self.pushes.as_ref()?;
        let period_s = f64::from(steps) * step_s;
        if self.push.is_none() && rng.random::<f64>() < period_s / ranges.interval_s {
            let force_n = [uniform(ranges.forward_n, rng), uniform(ranges.up_n, rng)];
            let lasts = (uniform(ranges.duration_s, rng) / step_s).round() as u32;
            self.push = Some((force_n, lasts));
        }
        let (force_n, left) = self.push?;
        let now = left.min(steps);
        self.push = (left > now).then(|| (force_n, left - now));
        Some((force_n, now))
    }

    /// An observation with the sensors' error.
    pub fn sensed(&self, mut observation: [f64; OBSERVATION_SIZE]) -> [f64; OBSERVATION_SIZE] {
        for (value, error) in observation.iter_mut().zip(self.error) {
            *value += error;
        }
        observation
    }

    /// Takes the command of a control period of `steps` integration steps. Returns what the actuators carry out
    /// during it: a command for the first so many steps, and one for the rest.
    pub fn delay(&mut self, command: [f64; 2], steps: u32) -> (u32, [f64; 2], [f64; 2]) {
        let (whole, part) = (self.latency_steps / steps, self.latency_steps % steps);
        self.pending.push_back(command);
        // The newest command is carried out after `whole` periods, and `part` steps into that one.
        let newest = self.pending.len() as u32 - 1;
        let given = |periods_ago: u32| match newest.checked_sub(periods_ago) {
            Some(index) => self.pending[index as usize],
            None => [0.0; 2],
        };
        let (early, late) = (given(whole + 1), given(whole));
        if newest > whole {
            self.pending.pop_front();
        }
        (part, early, late)
    }

    /// Draws the sensors' error anew.
    pub fn sense(&mut self, rng: &mut impl Rng) {
        for (error, deviation) in self.error.iter_mut().zip(self.noise.deviations()) {
            if deviation > 0.0 {
                let normal: f64 = StandardNormal.sample(rng);
                *error = deviation * normal;
            }
        }
    }
}
