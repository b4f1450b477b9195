//! The experiments of the study: the paper's and its journal version's, with what they leave out.

use gaitshift_experiment::{ConfigError, Sweep};

const FILES: [(&str, &str); 2] = [
    ("study.toml", include_str!("../experiments/study.toml")),
    (
        "ablations.toml",
        include_str!("../experiments/ablations.toml"),
    ),
];

/// The experiments as sweeps: five seeds of the paper's method with and without phase I and of the recommended recipe, three of
/// the others.
///
/// # Errors
/// Never, unless the program is damaged.
pub fn study_experiments() -> Result<Vec<Sweep>, ConfigError> {
    FILES
        .iter()
        .map(|(name, text)| Sweep::parse(text, name))
        .collect()
}
