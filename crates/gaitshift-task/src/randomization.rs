//! What else may differ from one training episode to the next: the body, the ground, pushes, the strength and the delay
//! of its actuators, the noise of its sensors. *Not in the paper.*

use crate::error::require;
use crate::observation::OBSERVATION_SIZE;
use crate::terrain::{FARTHEST_M, require_spacing};
use crate::{TaskError, TerrainParameters, TerrainStep, UnevenGround};
use gaitshift_body::{Body, BodyParameters, ParameterError};
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Longest delay of the actuators, in s.
pub(crate) const LONGEST_LATENCY_S: f64 = 1.0;

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

/// Pushes that come at random, as those of a [`Disturbance`](crate::Disturbance) come at given times.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PushRanges {
    /// Mean time from one to the next, in s: each control period without one begins one with the same chance.
    pub interval_s: f64,
    /// Range of the forward force, in N.
    pub forward_n: [f64; 2],
    /// Range of the upward force, in N.
    pub up_n: [f64; 2],
    /// Range of their duration, in s, rounded to whole integration steps.
    pub duration_s: [f64; 2],
}

impl Default for PushRanges {
    fn default() -> Self {
        Self {
            interval_s: 3.0,
            forward_n: [0.0; 2],
            up_n: [0.0; 2],
            duration_s: [0.1; 2],
        }
    }
}

/// Ground that each episode draws, as [`TerrainParameters`] give it. It is flat where episodes begin.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TerrainRanges {
    /// Range of the inclination, in rad; positive rises forward.
    pub slope_rad: [f64; 2],
    /// Range of where it begins, in m.
    pub slope_from_m: [f64; 2],
    /// Steps, one after the other.
    pub steps: StepRanges,
    /// Heights drawn at random.
    pub uneven: UnevenRanges,
}

impl Default for TerrainRanges {
    fn default() -> Self {
        Self {
            slope_rad: [0.0; 2],
            slope_from_m: [1.0; 2],
            steps: StepRanges::default(),
            uneven: UnevenRanges::default(),
        }
    }
}

/// Steps with vertical faces, each drawn by itself.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StepRanges {
    /// Range of their heights, in m; negative leads down.
    pub height_m: [f64; 2],
    /// Range of the distance from one to the next, in m.
    pub spacing_m: [f64; 2],
    /// Where they begin, in m: the first comes one distance later.
    pub from_m: f64,
    /// How far they reach, in m.
    pub length_m: f64,
}

impl Default for StepRanges {
    fn default() -> Self {
        Self {
            height_m: [0.0; 2],
            spacing_m: [1.0, 3.0],
            from_m: 0.5,
            length_m: 40.0,
        }
    }
}

/// As [`UnevenGround`], its height and its seed drawn.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct UnevenRanges {
    /// Range of the height, in m.
    pub height_m: [f64; 2],
    /// Distance between two heights, in m.
    pub spacing_m: f64,
    /// Where the unevenness begins, in m.
    pub from_m: f64,
    /// How far it reaches, in m.
    pub length_m: f64,
}

impl Default for UnevenRanges {
    fn default() -> Self {
        Self {
            height_m: [0.0; 2],
            spacing_m: 0.25,
            from_m: 1.0,
            length_m: 40.0,
        }
    }
}

/// Where the ground may cease to be flat, in m: the feet of every start stand before it.
const FLAT_TO_M: f64 = 0.5;

impl TerrainRanges {
    fn draw(&self, rng: &mut impl Rng) -> TerrainParameters {
        let mut terrain = TerrainParameters::default();
        if self.slope_rad != [0.0; 2] {
            terrain.slope_rad = uniform(self.slope_rad, rng);
            terrain.slope_from_m = Some(uniform(self.slope_from_m, rng));
        }
        let s = &self.steps;
        if s.height_m != [0.0; 2] {
            let mut at_m = s.from_m + uniform(s.spacing_m, rng);
            while at_m < s.from_m + s.length_m {
                let height_m = uniform(s.height_m, rng);
                terrain.steps.push(TerrainStep { height_m, at_m });
                at_m += uniform(s.spacing_m, rng);
            }
        }
        let u = &self.uneven;
        if u.height_m != [0.0; 2] {
            terrain.uneven = UnevenGround {
                height_m: uniform(u.height_m, rng),
                spacing_m: u.spacing_m,
                from_m: u.from_m,
                length_m: u.length_m,
                // A seed that TOML and JSON hold exactly.
                seed: rng.random::<u64>() >> 11,
            };
        }
        terrain
    }

    fn validate(&self, key: &str) -> Result<(), TaskError> {
        let key = |name: &str| format!("{key}.{name}");
        let (s, u) = (&self.steps, &self.uneven);
        for (name, range, low, high, accepted) in [
            (
                "slope_rad",
                self.slope_rad,
                -0.8,
                0.8,
                "[low, high] between -0.8 and 0.8",
            ),
            (
                "slope_from_m",
                self.slope_from_m,
                FLAT_TO_M,
                FARTHEST_M,
                "[low, high] between 0.5 and 10000: episodes begin on flat ground",
            ),
            (
                "steps.height_m",
                s.height_m,
                -1.0,
                1.0,
                "[low, high] between -1 and 1",
            ),
            (
                "steps.spacing_m",
                s.spacing_m,
                0.05,
                FARTHEST_M,
                "[low, high] between 0.05 and 10000",
            ),
            (
                "uneven.height_m",
                u.height_m,
                0.0,
                1.0,
                "[low, high] between 0 and 1",
            ),
        ] {
            require_within(&key(name), range, [low, high], accepted)?;
        }
        for (name, from_m) in [("steps.from_m", s.from_m), ("uneven.from_m", u.from_m)] {
            require(
                (FLAT_TO_M..=FARTHEST_M).contains(&from_m),
                &key(name),
                from_m,
                "between 0.5 and 10000: episodes begin on flat ground",
            )?;
        }
        require(
            (0.0..=1000.0).contains(&s.length_m),
            &key("steps.length_m"),
            s.length_m,
            "between 0 and 1000",
        )?;
        // Every step that is drawn lies before this.
        require(
            s.from_m + s.length_m <= FARTHEST_M,
            &key("steps.from_m"),
            s.from_m,
            "small enough that `from_m` plus `length_m` is at most 10000",
        )?;
        require_spacing(&key("uneven.spacing_m"), u.spacing_m)?;
        require(
            (0.0..=1000.0).contains(&u.length_m),
            &key("uneven.length_m"),
            u.length_m,
            "between 0 and 1000",
        )
    }
}

impl PushRanges {
    fn validate(&self, key: &str) -> Result<(), TaskError> {
        let key = |name: &str| format!("{key}.{name}");
        require(
            (0.01..=1e6).contains(&self.interval_s),
            &key("interval_s"),
            self.interval_s,
            "between 0.01 and 1e6",
        )?;
        for (name, range) in [("forward_n", self.forward_n), ("up_n", self.up_n)] {
            let accepted = "[low, high] between -1e6 and 1e6";
            require_within(&key(name), range, [-1e6, 1e6], accepted)?;
        }
        let accepted = "[low, high] between 0 and 100";
        require_within(&key("duration_s"), self.duration_s, [0.0, 100.0], accepted)
    }
}

/// Checks a range: ordered, and between two bounds.
fn require_within(
    key: &str,
    range: [f64; 2],
    bounds: [f64; 2],
    accepted: &'static str,
) -> Result<(), TaskError> {
    let [low, high] = range;
    let ok = bounds[0] <= low && low <= high && high <= bounds[1];
    require(ok, key, range, accepted)
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
    /// With every range that can be given, none of which changes anything: what others differ from.
    pub fn changing_nothing() -> Self {
        Self {
            actuator_factor: Some([1.0; 2]),
            pushes: Some(PushRanges::default()),
            terrain: Some(TerrainRanges::default()),
            ..Self::default()
        }
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
    actuator_factor: [f64; 2],
    /// The ground, where it is not flat.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    terrain: Option<TerrainParameters>,
    /// What pushes are drawn from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pushes: Option<PushRanges>,
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
