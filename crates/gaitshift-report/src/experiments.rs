//! The experiments of the study: the paper's and its journal version's, with what they leave out.

use gaitshift_experiment::{ConfigError, Sweep};

const FILES: [(&str, &str); 2] = [
    ("study.toml", include_str!("../experiments/study.toml")),
    (
        "ablations.toml",
        include_str!("../experiments/ablations.toml"),
    ),
];
const FAST_LEARNER: &str = include_str!("../experiments/fast_learner.toml");

/// How the experiments of the study learn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StudyLearner {
    /// As the papers have it: one environment, one update per step.
    Papers,
    /// As `fast` does: 32 environments, one update per 16 steps, critics with layer normalisation, 3-step returns, mirrored
    /// batches instead of (7), a learning rate of 3e-4. Reward (2) to (6), α, γ, commands and phases are still the papers'.
    Fast,
}

/// The experiments as sweeps: five seeds of the paper's method with and without phase I and of the recommended recipe, three of
/// the others.
///
/// # Errors
/// Never, unless the program is damaged.
pub fn study_experiments(learner: StudyLearner) -> Result<Vec<Sweep>, ConfigError> {
    let settings = match learner {
        StudyLearner::Papers => "",
        StudyLearner::Fast => FAST_LEARNER,
    };
    FILES
        .iter()
        .map(|(name, text)| Sweep::parse_with(text, settings, name))
        .collect()
}
