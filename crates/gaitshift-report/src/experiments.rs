//! The experiments of the study: the paper's and its journal version's, with what they leave out.

use gaitshift_experiment::{ConfigError, Sweep};
use toml::{Table, Value};

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
    /// As the papers have it: one environment, an update for every step.
    Papers,
    /// As `fast` does: 32 environments, an update for 16 steps, critics with layer normalisation, returns of three steps, mirrored
    /// batches instead of (7). Reward (2) to (6), α, γ, commands and phases are still the papers'.
    Fast,
}

/// The experiments as sweeps: five seeds of the paper's method with and without phase I and of the recommended recipe, three of
/// the others.
///
/// # Errors
/// Never, unless the program is damaged.
pub fn study_experiments(learner: StudyLearner) -> Result<Vec<Sweep>, ConfigError> {
    let sweep = |(name, text): &(&str, &str)| match learner {
        StudyLearner::Papers => Sweep::parse(text, name),
        StudyLearner::Fast => Sweep::parse(&with_fast_learner(text), name),
    };
    FILES.iter().map(sweep).collect()
}

/// A sweep's file with the learner of `fast` in every variant. What is no TOML stays as it is, for the error that it gives.
fn with_fast_learner(text: &str) -> String {
    let (Ok(mut file), Ok(learner)) = (text.parse::<Table>(), FAST_LEARNER.parse::<Table>()) else {
        return text.to_owned();
    };
    let set = file
        .entry("set")
        .or_insert_with(|| Value::Table(Table::new()));
    for (section, settings) in learner {
        let own = set.as_table_mut().map(|set| {
            set.entry(section)
                .or_insert_with(|| Value::Table(Table::new()))
        });
        if let (Some(Value::Table(own)), Value::Table(settings)) = (own, settings) {
            own.extend(settings);
        }
    }
    file.to_string()
}
