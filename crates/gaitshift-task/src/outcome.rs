//! What comes of a control period: the energies that the reward penalises, its terms, why the episode ended.

use gaitshift_body::AdvanceReport;
use serde::{Deserialize, Serialize};

/// Most reward terms of one's own, and likewise most rules.
pub const MOST_EXTRA: usize = 8;

/// The energies of one step that the reward penalises, in J.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StepEnergies {
    /// Change of the body's total energy, without the work of external forces on it.
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
    /// The penalty on friction, not in the paper.
    pub friction: f64,
    /// The penalty on positive work, not in the paper.
    pub work: f64,
    /// `ω_s f_sym`, (7); zero unless the learner supplies it.
    pub symmetry: f64,
    /// Those of one's own, in their order; the rest is zero.
    pub extra: [f64; MOST_EXTRA],
}

impl RewardTerms {
    /// Names in the order of [`RewardTerms::values`].
    pub const NAMES: [&'static str; 8] = [
        "energy", "velocity", "forward", "alive", "leg", "friction", "work", "symmetry",
    ];

    /// The terms in the order of [`RewardTerms::NAMES`], without those of one's own.
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

    /// Their sum: (2) of the paper, and the terms of one's own.
    pub fn sum(&self) -> f64 {
        self.values().iter().chain(&self.extra).sum()
    }
}

/// Why an episode ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EndReason {
    /// The time limit was reached: a truncation, the value goes on.
    TimeLimit,
    /// |θ| passed its limit.
    Pitch,
    /// The hip sank below its lowest height over the ground.
    HipHeight,
    /// The simulation diverged: the step is not to be learned from.
    Diverged,
    /// An expression of one's own had no finite value: the step is not to be learned from.
    Undefined,
    /// The rule of one's own of this index.
    Rule(u8),
}

impl EndReason {
    /// What [`EndReason::name`] gives; a rule of one's own has none of these.
    pub const NAMES: [&'static str; 6] = [
        Self::TimeLimit.name(),
        Self::Pitch.name(),
        Self::HipHeight.name(),
        Self::Diverged.name(),
        Self::Undefined.name(),
        Self::Rule(0).name(),
    ];

    /// Whether the body fell (as opposed to the time limit).
    pub fn is_termination(self) -> bool {
        self != Self::TimeLimit
    }
    /// Whether the step came to nothing that could be learned from.
    pub fn is_failure(self) -> bool {
        matches!(self, Self::Diverged | Self::Undefined)
    }
    /// Short name; that of a rule of one's own is known to the task ([`TaskParameters::end_name`](crate::TaskParameters::end_name)).
    pub const fn name(self) -> &'static str {
        match self {
            Self::TimeLimit => "time limit",
            Self::Pitch => "pitch",
            Self::HipHeight => "hip height",
            Self::Diverged => "diverged",
            Self::Undefined => "undefined",
            Self::Rule(_) => "rule",
        }
    }
}

/// Result of one control period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepOutcome {
    /// The reward's terms; their sum is (2) of the paper, before the common factor.
    pub terms: RewardTerms,
    /// Factor of this step's reward.
    pub factor: f64,
    /// Set when the episode is over.
    pub ended: Option<EndReason>,
    /// Mean forces over the period.
    pub report: AdvanceReport,
}
