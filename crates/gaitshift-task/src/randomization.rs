//! What else may differ from one training episode to the next: the body, the ground, pushes, the strength and the delay
//! of its actuators, the noise of its sensors. *Not in the paper.*

use crate::conditions::{Conditions, LONGEST_LATENCY_S};
use crate::error::require;
use crate::ranges::{require_within, uniform};
use crate::{PushRanges, SensorNoise, TaskError, TerrainRanges};
use gaitshift_body::BodyParameters;
use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

/// What differs from episode to episode. As it stands by default it changes nothing.
///
/// Both legs have the same body, so that mirrored transitions remain true ones. The strengths of their actuators are drawn
/// from one range, each by itself: the mirror image of an episode is as likely as the episode.
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
    /// Range of the height of the hip segment's centre of mass over the hip axis, in m; may be negative, so no factor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hip_com_height_m: Option<[f64; 2]>,
    /// Noise of the observations.
    pub noise: SensorNoise,
    /// Range of the share of its force that an actuator still has, drawn for each leg by itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub actuator_factor: Option<[f64; 2]>,
    /// Pushes on the hip axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pushes: Option<PushRanges>,
    /// The ground.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub terrain: Option<TerrainRanges>,
}

impl Default for Randomization {
    fn default() -> Self {
        Self {
            share: 1.0,
            latency_s: [0.0, 0.0],
            body: BodyFactors::default(),
            hip_com_height_m: None,
            noise: SensorNoise::default(),
            actuator_factor: None,
            pushes: None,
            terrain: None,
        }
    }
}

/// Declares the body's parameters that may be drawn, and from the same lists how they are: each of the first in every
/// episode, each of the second, which came later, only where its range asks for it, so that what else is drawn stays as it was.
macro_rules! body_factors {
    ($($name:ident),* $(,)?; $($late:ident),* $(,)?) => {
        /// Ranges of factors on parameters of the body, by their names there; each is drawn uniformly and
        /// independently of the others. The lengths of leg, sole and stroke are not among them: they change the task's start
        /// and falls.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct BodyFactors {
            $(
                #[allow(missing_docs)] // As in `BodyParameters`.
                pub $name: [f64; 2],
            )*
            $(
                #[allow(missing_docs)] // As in `BodyParameters`.
                pub $late: [f64; 2],
            )*
        }

        impl Default for BodyFactors {
            fn default() -> Self {
                Self { $($name: [1.0, 1.0],)* $($late: [1.0, 1.0],)* }
            }
        }

        impl BodyFactors {
            /// A body drawn around `base`.
            fn draw(&self, base: &BodyParameters, rng: &mut impl Rng) -> BodyParameters {
                let mut body = base.clone();
                $(body.$name *= uniform(self.$name, rng);)*
                $(
                    if self.$late != [1.0, 1.0] {
                        body.$late *= uniform(self.$late, rng);
                    }
                )*
                body
            }

            /// The body with every factor at the low (0) or the high (1) end of its range.
            fn at_end(&self, base: &BodyParameters, end: usize) -> BodyParameters {
                let mut body = base.clone();
                $(body.$name *= self.$name[end];)*
                $(body.$late *= self.$late[end];)*
                body
            }

            fn ranges(&self) -> impl Iterator<Item = (&'static str, [f64; 2])> {
                [$((stringify!($name), self.$name),)* $((stringify!($late), self.$late),)*].into_iter()
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
    gravity_m_per_s2;
    thigh_distance_m,
    tibia_distance_m,
    foot_distance_m,
}

impl Randomization {
    /// With every range that can be given, none of which changes anything: what others differ from.
    pub fn changing_nothing() -> Self {
        Self {
            actuator_factor: Some([1.0; 2]),
            pushes: Some(PushRanges::default()),
            terrain: Some(TerrainRanges::default()),
            ..Self::default()
        }
    }

    /// The same with every range that can be given; those that it leaves out change nothing.
    pub fn in_full(self) -> Self {
        let neutral = Self::changing_nothing();
        Self {
            actuator_factor: self.actuator_factor.or(neutral.actuator_factor),
            pushes: self.pushes.or(neutral.pushes),
            terrain: self.terrain.or(neutral.terrain),
            ..self
        }
    }

    /// Whether no episode differs from another: no share of them is drawn, or no range changes anything.
    pub fn changes_nothing(&self) -> bool {
        let neutral = Self::changing_nothing();
        let pushes = (self.pushes).filter(|push| [push.forward_n, push.up_n] != [[0.0; 2]; 2]);
        let given = Self {
            share: neutral.share,
            pushes,
            ..self.clone()
        };
        self.share == 0.0 || given.in_full() == neutral
    }

    /// Draws what holds during one episode; nothing for one that stays as it is.
    pub(crate) fn draw(&self, base: &BodyParameters, rng: &mut impl Rng) -> Option<Conditions> {
        if rng.random::<f64>() >= self.share {
            return None;
        }
        let body = self.body.draw(base, rng);
        let latency_s = uniform(self.latency_s, rng);
        let latency_steps = (latency_s / body.time_step_s).round() as u32;
        let mut conditions = Conditions::new(body, latency_steps, self.noise, rng);
        // Only what is asked for takes random numbers, and these came later, so they are drawn after the rest: body, delay and
        // noise are as without them. What a caller draws after the conditions, as a batch does a start, is another one.
        if let Some(range) = self.hip_com_height_m {
            conditions.body.hip_com_height_m = uniform(range, rng);
        }
        if let Some(range) = self.actuator_factor {
            conditions.actuator_factor = std::array::from_fn(|_| uniform(range, rng));
        }
        let terrain = self.terrain.map(|ranges| ranges.draw(rng));
        conditions.terrain = terrain.filter(|terrain| !terrain.is_flat());
        conditions.pushes = self.pushes;
        Some(conditions)
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
        if let Some(range) = self.hip_com_height_m {
            let accepted = "[low, high] between -2 and 2";
            require_within(&key("hip_com_height_m"), range, [-2.0, 2.0], accepted)?;
        }
        self.noise.validate(&key("noise"))?;
        if let Some(range) = self.actuator_factor {
            let accepted = "[low, high] between 0 (no force) and 1";
            require_within(&key("actuator_factor"), range, [0.0, 1.0], accepted)?;
        }
        if let Some(pushes) = &self.pushes {
            pushes.validate(&key("pushes"))?;
        }
        match &self.terrain {
            Some(terrain) => terrain.validate(&key("terrain")),
            None => Ok(()),
        }
    }
}
