//! The reward (2)-(7) of the paper, term by term.

use crate::TaskError;
use crate::parameters::require;
use gaitshift_body::{BodyState, LEFT, RIGHT};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What the leg term (6) takes from the hip angles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LegTerm {
    /// `min(|φ̇_r - φ̇_l|, C3)`, C3 in rad/s: as the conference paper prints it.
    #[default]
    Rates,
    /// `min(|φ_r - φ_l|, C3)`, C3 in rad: without the dots, as a summary of the journal version has it.
    Angles,
}

/// Declares the reward's parameters and, from the same list, their access by key, which phases of the
/// curriculum use to replace some of them.
macro_rules! reward_parameters {
    ($($(#[$doc:meta])* $name:ident,)*) => {
        /// Weights and constants of the reward; defaults are Table 2 of the paper.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct RewardParameters {
            $($(#[$doc])* pub $name: f64,)*
            /// *Open.* Which reading of (6) the leg term follows.
            pub leg_term: LegTerm,
        }

        impl RewardParameters {
            /// The keys, in the order of the fields.
            pub const KEYS: &'static [&'static str] = &[$(stringify!($name)),*];

            /// The values, in the order of [`RewardParameters::KEYS`].
            pub fn values(&self) -> Vec<f64> {
                vec![$(self.$name),*]
            }

            /// The value of a key, to change it; none if there is no such key.
            pub fn get_mut(&mut self, key: &str) -> Option<&mut f64> {
                match key {
                    $(stringify!($name) => Some(&mut self.$name),)*
                    _ => None,
                }
            }
        }
    };
}

reward_parameters! {
    /// Weight `ω_E` of the energy change |ΔE|, per J.
    omega_e,
    /// Weight `ω_l` of the leg term (6).
    omega_l,
    /// Weight `ω_s` of the symmetry term (7).
    omega_s,
    /// `C1` of (3): penalty while moving backwards.
    c1,
    /// `C2` of (4): reward for not having fallen.
    c2,
    /// *Not in the paper.* `C2` is multiplied by `1 + k max(ω_v, 0)`; this is `k`, and 0 is the paper.
    /// Equal to `command_divisor` it makes a fall cost the same at every command. Otherwise starting to
    /// run, which has its price at once and its reward later, can be worth less than falling.
    alive_command_factor,
    /// `C3` of (6): cap of the difference of the hip angles' rates, in rad/s (in rad with
    /// [`LegTerm::Angles`]).
    c3,
    /// *Open.* |ΔE| is the change over one control period and so grows with it, while the other
    /// terms do not. A value above 0 rescales |ΔE| to a period of that many seconds.
    energy_reference_period_s,
    /// *Not in the paper.* `ω_E` itself is divided by `1 + k max(ω_v, 0)`; this is `k`. 0 is the paper.
    /// Above 0, energy is expensive at low commands, which makes the walk slow and pendular, and cheap at
    /// high ones, where expensive energy keeps the learner from ever trying a flight phase.
    energy_command_divisor,
    /// *Not in the paper.* The division above does not take `ω_E` below this, per J.
    omega_e_floor,
    /// *Not in the paper.* Price of the actuators' positive work, the integral in (8), per J and unit of
    /// `max(ω_v, 0)`: a run that covers the same way with less work is worth more. |ΔE| does not see work
    /// that dampers take up at once.
    omega_w,
    /// *Not in the paper.* The energy term of one step, and likewise the price of friction, does not go
    /// below minus this times `1 + 4 max(ω_v, 0)`; 0 sets no bound, which is the paper. Without one, braking from a run under a
    /// low command costs more than being alive earns, so that falling pays; a bound below `C2` makes
    /// living always worth it.
    energy_cap,
    /// *Not in the paper.* Price of the energy lost to friction under the feet, per J; 0 is the paper.
    /// A foot that rolls loses none, one that grazes the ground while it swings does.
    omega_f,
    /// *Not in the paper.* `ω_f` is divided by `1 + k max(ω_v, 0)`; this is `k`. A run loses more to
    /// friction than a walk, and at the walk's price it would not be found.
    friction_command_divisor,
    /// *Not in the paper.* Speed above which `ω_v ẋ` falls again as it rose below, in m/s; 0 sets no
    /// limit, which is the paper. Without one, a learner free to run faster at `ω_v = 3` does, until it
    /// falls.
    speed_limit_m_per_s,
    /// *Open in the conference paper.* The whole reward is divided by `1 + k max(ω_v, 0)`; this is
    /// `k`. 0 is the conference paper, 1 the journal version.
    command_divisor,
    /// *Open.* The entropy bonus is divided by `1 + k max(ω_v, 0)`; this is `k`. Equal to
    /// `command_divisor` it keeps each command's optimum; smaller, it asks for more exploration at
    /// high commands. 0 is the conference paper, and the journal version as far as it says.
    entropy_command_divisor,
    /// *Not in the paper.* Share of the entropy bonus that is left at `ω_v = 0` and below; it grows
    /// linearly to the whole at `ω_v = 0.5`. 1 is the paper. Terms that tell a clean walk from a
    /// shuffle are small beside the bonus that a run needs to stay upright.
    entropy_share_at_zero,
    /// *Not in the paper.* The horizon 1 / (1 - γ) of a step is divided by `1 + k max(ω_v, 0)`; this is
    /// `k`. 0 is the paper. Above 0, fast commands look less far ahead, which is what lets the learner
    /// find flight, and slow ones far enough to see a fall coming.
    horizon_command_divisor,
    /// *Not in the paper.* The division above leaves at least this share of the horizon.
    horizon_share_floor,
    /// Constant factor of the reward. It and the entropy bonus scale together, so the optimum stays.
    scale,
}

impl Default for RewardParameters {
    fn default() -> Self {
        Self {
            omega_e: 0.2,
            omega_l: 0.2,
            omega_s: 0.15,
            c1: 1.0,
            c2: 1.0,
            alive_command_factor: 0.0,
            c3: 0.5,
            energy_reference_period_s: 0.0,
            energy_command_divisor: 0.0,
            omega_e_floor: 0.0,
            omega_w: 0.0,
            energy_cap: 0.0,
            omega_f: 0.0,
            friction_command_divisor: 0.0,
            speed_limit_m_per_s: 0.0,
            command_divisor: 0.0,
            entropy_command_divisor: 0.0,
            entropy_share_at_zero: 1.0,
            horizon_command_divisor: 0.0,
            horizon_share_floor: 0.0,
            scale: 1.0,
            leg_term: LegTerm::default(),
        }
    }
}

/// Some of the reward's keys with the values that replace the task's, e.g. `{ omega_e = 0.06 }`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(try_from = "BTreeMap<String, f64>")]
pub struct RewardOverrides(BTreeMap<String, f64>);

impl TryFrom<BTreeMap<String, f64>> for RewardOverrides {
    type Error = String;

    fn try_from(values: BTreeMap<String, f64>) -> Result<Self, String> {
        let known = RewardParameters::KEYS;
        match values.keys().find(|key| !known.contains(&key.as_str())) {
            None => Ok(Self(values)),
            Some(key) => Err(format!(
                "the reward has no key `{key}`; its keys are {}",
                known.join(", ")
            )),
        }
    }
}

impl<const N: usize> From<[(&'static str, f64); N]> for RewardOverrides {
    fn from(values: [(&'static str, f64); N]) -> Self {
        Self(values.map(|(key, value)| (key.to_owned(), value)).into())
    }
}

impl RewardOverrides {
    /// No key replaced.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The keys and their values.
    pub fn iter(&self) -> impl Iterator<Item = (&str, f64)> {
        self.0.iter().map(|(key, value)| (key.as_str(), *value))
    }

    /// Moves each of the keys in `reward` a share of the way to its value here: 1 replaces it.
    pub fn blend_into(&self, reward: &mut RewardParameters, share: f64) {
        for (key, value) in self.iter() {
            if let Some(current) = reward.get_mut(key) {
                *current = if share < 1.0 {
                    *current + share * (value - *current)
                } else {
                    value
                };
            }
        }
    }
}

/// The energies of one step that the reward prices, in J.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StepEnergies {
    /// Change of the body's total energy.
    pub change_j: f64,
    /// Lost to friction under the feet.
    pub friction_loss_j: f64,
    /// Positive work of both actuators.
    pub positive_work_j: f64,
}

/// The weighted terms of one step's reward, before the common factor.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct RewardTerms {
    /// `-ω_E |ΔE|` of (2).
    pub energy: f64,
    /// `ω_v ẋ` of (2).
    pub velocity: f64,
    /// `f_forward`, (3).
    pub forward: f64,
    /// `f_alive`, (4).
    pub alive: f64,
    /// `ω_l f_leg`, (6).
    pub leg: f64,
    /// The price of friction, not in the paper.
    pub friction: f64,
    /// The price of positive work, not in the paper.
    pub work: f64,
    /// `ω_s f_sym`, (7); zero unless the learner supplies it.
    pub symmetry: f64,
}

impl RewardTerms {
    /// Names in the order of [`RewardTerms::values`].
    pub const NAMES: [&'static str; 8] = [
        "energy", "velocity", "forward", "alive", "leg", "friction", "work", "symmetry",
    ];

    /// The terms in the order of [`RewardTerms::NAMES`].
    pub fn values(&self) -> [f64; 8] {
        [
            self.energy,
            self.velocity,
            self.forward,
            self.alive,
            self.leg,
            self.friction,
            self.work,
            self.symmetry,
        ]
    }

    /// Their sum: (2) of the paper.
    pub fn sum(&self) -> f64 {
        self.values().iter().sum()
    }
}

impl RewardParameters {
    /// Checks a value of the parameter `name`, which the user knows as `key`.
    pub(crate) fn check(key: &str, name: &str, value: f64) -> Result<(), TaskError> {
        let (ok, accepted) = match name {
            "scale" => (value > 0.0, "greater than 0"),
            _ => (value >= 0.0, "0 or greater"),
        };
        require(ok && value.is_finite(), key, value, accepted)
    }

    /// The factor of the reward at a command: `scale / (1 + k max(ω_v, 0))`.
    pub fn factor(&self, omega_v: f64) -> f64 {
        self.scale / command_scale(self.command_divisor, omega_v)
    }

    /// The factor of the entropy bonus at a command, likewise.
    pub fn entropy_factor(&self, omega_v: f64) -> f64 {
        let at_zero = self.entropy_share_at_zero;
        let share = at_zero + (1.0 - at_zero) * (omega_v / 0.5).clamp(0.0, 1.0);
        self.scale * share / command_scale(self.entropy_command_divisor, omega_v)
    }

    /// The factor of the horizon at a command, above 0 and at most 1.
    pub fn horizon_factor(&self, omega_v: f64) -> f64 {
        let share = 1.0 / command_scale(self.horizon_command_divisor, omega_v);
        share.max(self.horizon_share_floor.min(1.0))
    }

    /// Terms of the step that ended in `state`. The symmetry term is left at zero.
    pub fn terms(
        &self,
        state: &BodyState,
        energies: &StepEnergies,
        omega_v: f64,
        control_period_s: f64,
    ) -> RewardTerms {
        let rescale = if self.energy_reference_period_s > 0.0 {
            self.energy_reference_period_s / control_period_s
        } else {
            1.0
        };
        let divisor = command_scale(self.energy_command_divisor, omega_v);
        let omega_e = (self.omega_e / divisor).max(self.omega_e_floor.min(self.omega_e));
        let cap = if self.energy_cap > 0.0 {
            self.energy_cap * command_scale(4.0, omega_v)
        } else {
            f64::INFINITY
        };
        let paid_speed = if self.speed_limit_m_per_s > 0.0 {
            self.speed_limit_m_per_s - (state.x_dot - self.speed_limit_m_per_s).abs()
        } else {
            state.x_dot
        };
        let energy = (omega_e * energies.change_j.abs() * rescale).min(cap);
        let omega_f = self.omega_f / command_scale(self.friction_command_divisor, omega_v);
        let friction = omega_f * energies.friction_loss_j * rescale;
        let legs_apart = match self.leg_term {
            LegTerm::Rates => state.phi_dot(RIGHT) - state.phi_dot(LEFT),
            LegTerm::Angles => state.phi(RIGHT) - state.phi(LEFT),
        };
        RewardTerms {
            energy: -energy,
            velocity: omega_v * paid_speed,
            forward: if state.x_dot >= 0.0 { 0.0 } else { -self.c1 },
            alive: self.c2 * command_scale(self.alive_command_factor, omega_v),
            leg: self.omega_l * legs_apart.abs().min(self.c3),
            friction: -friction.min(cap),
            work: -self.omega_w * omega_v.max(0.0) * energies.positive_work_j * rescale,
            symmetry: 0.0,
        }
    }

    /// `f_sym` of (7), from the policy's action and the mirror image of its action in the mirrored
    /// state, weighted by `ω_s`.
    pub fn symmetry_term(&self, action: &[f32], mirrored_action: &[f32]) -> f64 {
        let square: f64 = action
            .iter()
            .zip(mirrored_action)
            .map(|(a, b)| f64::from(a - b).powi(2))
            .sum();
        -self.omega_s * square
    }
}

/// How terms grow or shrink with the command: `1 + k max(ω_v, 0)`.
fn command_scale(k: f64, omega_v: f64) -> f64 {
    1.0 + k * omega_v.max(0.0)
}
