//! The reward (2)-(7) of the paper, term by term.

use gaitshift_body::{BodyState, LEFT, RIGHT};
use serde::{Deserialize, Serialize};

/// Weights and constants of the reward; defaults are Table 2 of the paper.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RewardParameters {
    /// Weight `ω_E` of the energy change |ΔE|, per J.
    pub omega_e: f64,
    /// Weight `ω_l` of the leg term (6).
    pub omega_l: f64,
    /// Weight `ω_s` of the symmetry term (7).
    pub omega_s: f64,
    /// `C1` of (3): penalty while moving backwards.
    pub c1: f64,
    /// `C2` of (4): reward for not having fallen.
    pub c2: f64,
    /// `C3` of (6): cap of the difference of the hip angles' rates, in rad/s.
    pub c3: f64,
    /// *Open.* |ΔE| is the change over one control period and so grows with it, while the other
    /// terms do not. A value above 0 rescales |ΔE| to a period of that many seconds.
    pub energy_reference_period_s: f64,
    /// *Not in the paper.* `ω_E` itself is divided by `1 + k max(ω_v, 0)`; this is `k`. 0 is the paper.
    /// Above 0, energy is dear at low commands, which makes the walk slow and pendular, and cheap at
    /// high ones, where dear energy keeps the learner from ever trying a flight phase.
    pub energy_command_divisor: f64,
    /// *Not in the paper.* The division above does not take `ω_E` below this, per J.
    pub omega_e_floor: f64,
    /// *Not in the paper.* The energy term of one step does not go below minus this times
    /// `1 + 2 max(ω_v, 0)`; 0 sets no bound, which is the paper. Without one, braking from a run under a
    /// low command costs more than being alive earns, so that falling pays; a bound below `C2` makes
    /// living always worth it.
    pub energy_cap: f64,
    /// *Not in the paper.* Price of the energy lost to friction under the feet, per J; 0 is the paper.
    /// A foot that rolls loses none, one that grazes the ground while it swings does.
    pub omega_f: f64,
    /// *Not in the paper.* Speed above which `ω_v ẋ` pays no more, in m/s; 0 sets no limit, which is the
    /// paper. Without one, a learner free to run faster at `ω_v = 3` does, until it falls.
    pub speed_limit_m_per_s: f64,
    /// *Open in the conference paper.* The whole reward is divided by `1 + k max(ω_v, 0)`; this is
    /// `k`. 0 is the conference paper, 1 the journal version.
    pub command_divisor: f64,
    /// *Open.* The entropy bonus is divided by `1 + k max(ω_v, 0)`; this is `k`. Equal to
    /// `command_divisor` it keeps each command's optimum; smaller, it asks for more exploration at
    /// high commands. 0 is the conference paper, and the journal version as far as it says.
    pub entropy_command_divisor: f64,
    /// *Not in the paper.* The horizon 1 / (1 - γ) of a step is divided by `1 + k max(ω_v, 0)`; this is
    /// `k`. 0 is the paper. Above 0, fast commands look less far ahead, which is what lets the learner
    /// find flight, and slow ones far enough to see a fall coming.
    pub horizon_command_divisor: f64,
    /// *Not in the paper.* The division above leaves at least this share of the horizon.
    pub horizon_share_floor: f64,
    /// Constant factor of the reward. It and the entropy bonus scale together, so the optimum stays.
    pub scale: f64,
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
            energy_reference_period_s: 0.0,
            energy_command_divisor: 0.0,
            omega_e_floor: 0.0,
            energy_cap: 0.0,
            omega_f: 0.0,
            speed_limit_m_per_s: 0.0,
            command_divisor: 0.0,
            entropy_command_divisor: 0.0,
            horizon_command_divisor: 0.0,
            horizon_share_floor: 0.0,
            scale: 1.0,
        }
    }
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
    /// `ω_s f_sym`, (7); zero unless the learner supplies it.
    pub symmetry: f64,
}

impl RewardTerms {
    /// Names in the order of [`RewardTerms::values`].
    pub const NAMES: [&'static str; 7] = [
        "energy", "velocity", "forward", "alive", "leg", "friction", "symmetry",
    ];

    /// The terms in the order of [`RewardTerms::NAMES`].
    pub fn values(&self) -> [f64; 7] {
        [
            self.energy,
            self.velocity,
            self.forward,
            self.alive,
            self.leg,
            self.friction,
            self.symmetry,
        ]
    }

    /// Their sum: (2) of the paper.
    pub fn sum(&self) -> f64 {
        self.values().iter().sum()
    }
}

impl RewardParameters {
    /// The factor of the reward at a command: `scale / (1 + k max(ω_v, 0))`.
    pub fn factor(&self, omega_v: f64) -> f64 {
        self.scale / command_scale(self.command_divisor, omega_v)
    }

    /// The factor of the entropy bonus at a command, likewise.
    pub fn entropy_factor(&self, omega_v: f64) -> f64 {
        self.scale / command_scale(self.entropy_command_divisor, omega_v)
    }

    /// The factor of the horizon at a command, above 0 and at most 1.
    pub fn horizon_factor(&self, omega_v: f64) -> f64 {
        let share = 1.0 / command_scale(self.horizon_command_divisor, omega_v);
        share.max(self.horizon_share_floor.min(1.0))
    }

    /// Terms of the step that ended in `state`, changed the total energy by `energy_change_j` and lost
    /// `friction_loss_j` to friction. The symmetry term is left at zero.
    pub fn terms(
        &self,
        state: &BodyState,
        energy_change_j: f64,
        friction_loss_j: f64,
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
            self.energy_cap * command_scale(2.0, omega_v)
        } else {
            f64::INFINITY
        };
        let paid_speed = if self.speed_limit_m_per_s > 0.0 {
            state.x_dot.min(self.speed_limit_m_per_s)
        } else {
            state.x_dot
        };
        RewardTerms {
            energy: -(omega_e * energy_change_j.abs() * rescale).min(cap),
            velocity: omega_v * paid_speed,
            forward: if state.x_dot >= 0.0 { 0.0 } else { -self.c1 },
            alive: self.c2,
            leg: self.omega_l
                * (state.phi_dot(RIGHT) - state.phi_dot(LEFT))
                    .abs()
                    .min(self.c3),
            friction: -self.omega_f * friction_loss_j * rescale,
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
