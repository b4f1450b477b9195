//! The reward (2)-(7) of the paper, term by term.

use crate::overrides::keyed_numbers;
use crate::{ExtraTerms, MOST_EXTRA, RewardTerms, StepEnergies};
use gaitshift_body::{BodyState, LEFT, RIGHT};
use serde::{Deserialize, Serialize};

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

keyed_numbers! {
    /// Weights and constants of the reward; defaults are Table 2 of the paper.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    struct RewardParameters of "the reward" {
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
        /// `C3` of (6): cap of the difference of the hip angles' rates, in rad/s (in rad with
        /// [`LegTerm::Angles`]).
        c3,
        /// *Not in the paper.* Price of the actuators' positive work, the integral in (8), per J and unit of
        /// `max(ω_v, 0)`: a run that covers the same way with less work is worth more. |ΔE| does not see work
        /// that dampers take up at once.
        omega_w,
        /// *Not in the paper.* The energy term of one step, and likewise the penalty on friction, does not go
        /// below minus this times `1 + 4 max(ω_v, 0)`; 0 sets no bound, which is the paper. Without one, braking from a run under a
        /// low command costs more than being alive earns, so that falling pays; a bound below `C2` makes
        /// living always worth it.
        energy_cap,
        /// *Not in the paper.* Price of the energy lost to friction under the feet, per J; 0 is the paper.
        /// A foot that rolls loses none, one that grazes the ground while it swings does.
        omega_f,
        /// *Not in the paper.* `ω_f` is divided by `1 + k max(ω_v, 0)`; this is `k`. A run loses more to
        /// friction than a walk, and at the walk's penalty it would not be found.
        friction_command_divisor,
        /// *Open in the conference paper.* The whole reward is divided by `1 + k max(ω_v, 0)`; this is
        /// `k`. 0 is the conference paper, 1 the journal version.
        command_divisor,
    }
    also {
        /// *Open.* Which reading of (6) the leg term follows.
        pub leg_term: LegTerm,
        /// *Not in the paper.* Terms of one's own.
        #[serde(skip_serializing_if = "ExtraTerms::is_empty")]
        pub extra: ExtraTerms,
    }
}

impl Default for RewardParameters {
    fn default() -> Self {
        Self {
            omega_e: 0.2,
            omega_l: 0.2,
            omega_s: 0.15,
            c1: 1.0,
            c2: 1.0,
            c3: 0.5,
            omega_w: 0.0,
            energy_cap: 0.0,
            omega_f: 0.0,
            friction_command_divisor: 0.0,
            command_divisor: 0.0,
            leg_term: LegTerm::default(),
            extra: ExtraTerms::default(),
        }
    }
}

impl RewardParameters {
    /// Whether a value is one for the key `name`, and what is.
    fn range(_name: &str, value: f64) -> (bool, &'static str) {
        (value >= 0.0, "0 or greater")
    }

    /// The factor of the reward at a command: `1 / (1 + k max(ω_v, 0))`.
    pub fn factor(&self, omega_v: f64) -> f64 {
        1.0 / command_scale(self.command_divisor, omega_v)
    }

    /// Terms of the step that ended in `state`. The symmetry term and those of one's own are left at zero.
    pub fn terms(&self, state: &BodyState, energies: &StepEnergies, omega_v: f64) -> RewardTerms {
        let cap = if self.energy_cap > 0.0 {
            self.energy_cap * command_scale(4.0, omega_v)
        } else {
            f64::INFINITY
        };
        let energy = (self.omega_e * energies.change_j.abs()).min(cap);
        let omega_f = self.omega_f / command_scale(self.friction_command_divisor, omega_v);
        let friction = omega_f * energies.friction_loss_j;
        let legs_apart = match self.leg_term {
            LegTerm::Rates => state.phi_dot(RIGHT) - state.phi_dot(LEFT),
            LegTerm::Angles => state.phi(RIGHT) - state.phi(LEFT),
        };
        RewardTerms {
            energy: -energy,
            velocity: omega_v * state.x_dot,
            forward: if state.x_dot >= 0.0 { 0.0 } else { -self.c1 },
            alive: self.c2,
            leg: self.omega_l * legs_apart.abs().min(self.c3),
            friction: -friction.min(cap),
            work: -self.omega_w * omega_v.max(0.0) * energies.positive_work_j,
            symmetry: 0.0,
            extra: [0.0; MOST_EXTRA],
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
