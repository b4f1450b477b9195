//! What the phases of a curriculum say of the learner. The task only keeps these numbers; the learner gives them their
//! meaning.

use crate::overrides::keyed_numbers;
use crate::reward::command_scale;

keyed_numbers! {
    /// Settings of the learner that a phase can replace or move.
    #[derive(Debug, Clone, Copy, PartialEq)]
    struct LearnerSettings of "the learner in a phase" {
        /// Learning rate of actor and critics.
        learning_rate,
        /// Weight α of the entropy, where it is fixed.
        alpha,
        /// Horizon 1 / (1 - γ), in control periods: a short one finds fast gaits, a long one learns not to fall.
        horizon,
        /// Weight w of the rehearsal loss w · mean |μ(s) − a|²; 0: none.
        rehearsal,
        /// *Open.* The entropy bonus is divided by `1 + k max(ω_v, 0)`; this is `k`. Equal to the reward's
        /// `command_divisor` it keeps each command's optimum; smaller, it asks for more exploration at high commands. 0 is
        /// the conference paper, and the journal version as far as it says.
        entropy_command_divisor,
        /// *Not in the paper.* Share of the entropy bonus that is left at `ω_v = 0` and below; it grows linearly to the
        /// whole at `ω_v = 0.5`. 1 is the paper. Terms that tell a clean walk from a shuffle are small beside the bonus
        /// that a run needs to stay upright.
        entropy_share_at_zero,
    }
}

impl LearnerSettings {
    /// Whether a value is one for the key `name`, and what is.
    fn range(name: &str, value: f64) -> (bool, &'static str) {
        match name {
            "learning_rate" => (value > 0.0, "greater than 0"),
            "horizon" => (value >= 1.0, "1 control period or greater"),
            "entropy_share_at_zero" => ((0.0..=1.0).contains(&value), "between 0 and 1"),
            _ => (value >= 0.0, "0 or greater"),
        }
    }

    /// The factor of the entropy bonus at a command, given the reward's own factor `scale`.
    pub fn entropy_factor(&self, scale: f64, omega_v: f64) -> f64 {
        let at_zero = self.entropy_share_at_zero;
        let share = at_zero + (1.0 - at_zero) * (omega_v / 0.5).clamp(0.0, 1.0);
        scale * share / command_scale(self.entropy_command_divisor, omega_v)
    }
}
