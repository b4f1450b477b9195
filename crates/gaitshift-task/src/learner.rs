//! What the phases of a curriculum say of the learner. The task only keeps these numbers; the learner gives them their
//! meaning.

use crate::overrides::keyed_numbers;

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
    }
}

impl LearnerSettings {
    /// Whether a value is one for the key `name`, and what is.
    fn range(name: &str, value: f64) -> (bool, &'static str) {
        match name {
            "learning_rate" => (value > 0.0, "greater than 0"),
            "horizon" => (value >= 1.0, "1 control period or greater"),
            _ => (value >= 0.0, "0 or greater"),
        }
    }
}
