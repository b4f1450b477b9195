//! What else may differ from one training episode to the next: the body, the delay of its actuators, the
//! noise of its sensors. *Not in the paper.*

use crate::TaskError;
use crate::observation::OBSERVATION_SIZE;
use crate::parameters::require;
use gaitshift_body::BodyParameters;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Longest delay of the actuators, in s.
pub(crate) const LONGEST_LATENCY_S: f64 = 1.0;

/// What differs from episode to episode. As it stands by default it changes nothing.
///
/// Both legs are drawn alike, so that mirrored transitions remain true ones.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Randomization {
    /// Share of the episodes that are drawn; the others are on the body as it is, without delay or noise.
    pub share: f64,
    /// Range of the delay from the controller's command to the actuator's force, in s, rounded to
    /// whole integration steps. Until the first command arrives actuators are without force.
    pub latency_s: [f64; 2],
    /// Factors of the body's parameters.
    pub body: BodyFactors,
    /// Noise of the observations.
    pub noise: SensorNoise,
}

impl Default for Randomization {
    fn default() -> Self {
        Self {
            share: 1.0,
            latency_s: [0.0, 0.0],
            body: BodyFactors::default(),
            noise: SensorNoise::default(),
        }
    }
}

/// Declares the body's parameters that may be drawn, and from the same list how they are.
macro_rules! body_factors {
    ($($name:ident),* $(,)?) => {
        /// Ranges of factors on parameters of the body, by their names there; each is drawn uniformly and
        /// independently of the others. Lengths are not among them: they change the task's start and falls.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct BodyFactors {
            $(
                #[allow(missing_docs)] // As in `BodyParameters`.
                pub $name: [f64; 2],
            )*
        }

        impl Default for BodyFactors {
            fn default() -> Self {
                Self { $($name: [1.0, 1.0]),* }
            }
        }

        impl BodyFactors {
            /// A body drawn around `base`.
            fn draw(&self, base: &BodyParameters, rng: &mut impl Rng) -> BodyParameters {
                let mut body = base.clone();
                $(body.$name *= uniform(self.$name, rng);)*
                body
            }

            /// The body with every factor at the low (0) or the high (1) end of its range.
            fn at_end(&self, base: &BodyParameters, end: usize) -> BodyParameters {
                let mut body = base.clone();
                $(body.$name *= self.$name[end];)*
                body
            }

            fn ranges(&self) -> impl Iterator<Item = (&'static str, [f64; 2])> {
                [$((stringify!($name), self.$name)),*].into_iter()
            }
        }
    };
}

body_factors! {
    hip_mass_kg,
    thigh_mass_kg,
    tibia_mass_kg,
    foot_mass_kg,
    hip_inertia_kg_m2,
    thigh_inertia_kg_m2,
    tibia_inertia_kg_m2,
    foot_inertia_kg_m2,
    hip_stiffness_nm_per_rad,
    hip_damping_nms_per_rad,
    k1_n_per_m,
    k2_n_per_m,
    k3_n_per_m,
    c1_ns_per_m,
    c2_ns_per_m,
    actuator_force_n,
    stop_stiffness_n_per_m,
    stop_dissipation_s_per_m,
    contact_stiffness,
    contact_dissipation_s_per_m,
    friction,
    friction_smoothing_m_per_s,
    gravity_m_per_s2,
}

/// Standard deviations of normal noise on the observations, drawn anew every control period; that of a leg's
/// observation holds for both legs. The command is known exactly.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorNoise {
    /// Of the hip's forward speed, in m/s.
    pub x_velocity_m_per_s: f64,
    /// Of the pitch, in rad.
    pub theta_rad: f64,
    /// Of the pitch's rate, in rad/s.
    pub theta_velocity_rad_per_s: f64,
    /// Of the thigh's displacement, in m.
    pub h_m: f64,
    /// Of its rate, in m/s.
    pub h_velocity_m_per_s: f64,
    /// Of the hip joint's angle, in rad.
    pub phi_rad: f64,
    /// Of its rate, in rad/s.
    pub phi_velocity_rad_per_s: f64,
    /// Of the rate of the leg's compression, in m/s.
    pub d_velocity_m_per_s: f64,
}

impl SensorNoise {
    /// In the order of the observations.
    fn deviations(&self) -> [f64; OBSERVATION_SIZE] {
        let (h, h_dot) = (self.h_m, self.h_velocity_m_per_s);
        let (phi, phi_dot) = (self.phi_rad, self.phi_velocity_rad_per_s);
        let d_dot = self.d_velocity_m_per_s;
        let (theta, theta_dot) = (self.theta_rad, self.theta_velocity_rad_per_s);
        let x_dot = self.x_velocity_m_per_s;
        [
            x_dot, theta, theta_dot, h, h_dot, h, h_dot, phi, phi_dot, phi, phi_dot, d_dot, d_dot,
            0.0,
        ]
    }

    /// Names of its fields.
    pub const NAMES: [&'static str; 8] = [
        "x_velocity_m_per_s",
        "theta_rad",
        "theta_velocity_rad_per_s",
        "h_m",
        "h_velocity_m_per_s",
        "phi_rad",
        "phi_velocity_rad_per_s",
        "d_velocity_m_per_s",
    ];

    /// The field of that name, in its unit.
    pub fn named_mut(&mut self, name: &str) -> Option<&mut f64> {
        Some(match name {
            "x_velocity_m_per_s" => &mut self.x_velocity_m_per_s,
            "theta_rad" => &mut self.theta_rad,
            "theta_velocity_rad_per_s" => &mut self.theta_velocity_rad_per_s,
            "h_m" => &mut self.h_m,
            "h_velocity_m_per_s" => &mut self.h_velocity_m_per_s,
            "phi_rad" => &mut self.phi_rad,
            "phi_velocity_rad_per_s" => &mut self.phi_velocity_rad_per_s,
            "d_velocity_m_per_s" => &mut self.d_velocity_m_per_s,
            _ => return None,
        })
    }

    /// Checks every field; `key` is the path of this table.
    pub(crate) fn validate(&self, key: &str) -> Result<(), TaskError> {
        let mut noise = *self;
        for name in Self::NAMES {
            let deviation = noise.named_mut(name).map_or(0.0, |deviation| *deviation);
            require(
                deviation.is_finite() && deviation >= 0.0,
                &format!("{key}.{name}"),
                deviation,
                "0 or greater",
            )?;
        }
        Ok(())
    }
}

/// A number from a range, uniformly.
pub(crate) fn uniform([low, high]: [f64; 2], rng: &mut impl Rng) -> f64 {
    low + (high - low) * rng.random::<f64>()
}

impl Randomization {
    /// Draws what holds during one episode; nothing for one that stays as it is.
    pub(crate) fn draw(&self, base: &BodyParameters, rng: &mut impl Rng) -> Option<Conditions> {
        if rng.random::<f64>() >= self.share {
            return None;
        }
        let body = self.body.draw(base, rng);
        let latency_s = uniform(self.latency_s, rng);
        let latency_steps = (latency_s / body.time_step_s).round() as u32;
        Some(Conditions::new(body, latency_steps, self.noise, rng))
    }

    /// Checks every field; `key` is the path of this table and `base` the body that factors apply to.
    pub(crate) fn validate(&self, key: &str, base: &BodyParameters) -> Result<(), TaskError> {
        let key = |name: &str| format!("{key}.{name}");
        require(
            (0.0..=1.0).contains(&self.share),
            &key("share"),
            self.share,
            "between 0 and 1",
        )?;
        let [low, high] = self.latency_s;
        require(
            0.0 <= low && low <= high && high <= LONGEST_LATENCY_S,
            &key("latency_s"),
            self.latency_s,
            "[low, high] with 0 <= low <= high <= 1",
        )?;
        for (name, range) in self.body.ranges() {
            let [low, high] = range;
            require(
                0.0 <= low && low <= high && high.is_finite(),
                &key(&format!("body.{name}")),
                range,
                "[low, high] with 0 <= low <= high, factors of the body's value",
            )?;
        }
        // Every limit of these parameters is one of its own, so that what holds at both ends holds between.
        for end in 0..2 {
            if let Err(e) = self.body.at_end(base, end).validate() {
                return Err(TaskError {
                    key: key(&format!("body.{}", e.key)),
                    value: format!("a factor that makes it {:?}", e.value),
                    accepted: e.accepted,
                });
            }
        }
        self.noise.validate(&key("noise"))
    }
}

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
        };
        conditions.sense(rng);
        conditions
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
