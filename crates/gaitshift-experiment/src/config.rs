//! One experiment as one TOML file: body, task, curriculum, learner and training, every value named.

mod checks;
pub(crate) mod digest;
mod names;
mod parts;
mod reading;
mod shape;
mod tables;

pub use names::did_you_mean;
pub(crate) use names::{nearest, parse_error, question};
pub use parts::{load_body_overrides, load_disturbance, set_body_and_task};
pub use reading::RECIPES;
pub(crate) use tables::{leaves, nested, overlay, read};

use crate::criteria::Criteria;
use crate::rehearsal::RehearsalParameters;
use gaitshift_body::{BodyParameters, ParameterError};
use gaitshift_sac::{SacConfig, Temperature};
use gaitshift_task::{Curriculum, LearnerSettings, TaskError, TaskParameters};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// How mirror symmetry enters learning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Symmetry {
    /// Not at all.
    None,
    /// The reward term (7) with the policy's mean actions: a property of the policy in that state, which no single
    /// action changes.
    Reward,
    /// The reward term (7) with the action taken as `π(s_t)`, against the mirrored policy's mean: the critics see what
    /// an action costs that leaves the mirror image.
    Action,
    /// Half of every batch is replaced by its mirror image, and the controller is the mean of the actor and its mirror
    /// image.
    Replay,
}

/// Everything about training that is neither the task's nor the learner's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrainingParameters {
    /// Environments stepped together.
    pub environments: usize,
    /// Environment steps per update of the learner; 1 is the journal version's.
    pub steps_per_update: u64,
    /// Environment steps before the first update.
    pub learning_starts: u64,
    /// How mirror symmetry enters.
    pub symmetry: Symmetry,
    /// A controller to begin with instead of a random one, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub warm_start: Option<WarmStart>,
    /// How the walk is rehearsed in the phases that ask for it.
    pub rehearsal: RehearsalParameters,
    /// Environment steps between rows of `metrics.csv`.
    pub metrics_interval_steps: u64,
    /// Environment steps between evaluations.
    pub evaluation_interval_steps: u64,
    /// Environment steps between checkpoints.
    pub checkpoint_interval_steps: u64,
    /// Stop at the first evaluation that meets every criterion.
    pub stop_when_accepted: bool,
    /// Transitions in the replay buffer.
    pub replay_capacity: usize,
}

impl Default for TrainingParameters {
    fn default() -> Self {
        Self {
            environments: 1,
            steps_per_update: 1,
            learning_starts: 10_000,
            symmetry: Symmetry::Reward,
            warm_start: None,
            rehearsal: RehearsalParameters::default(),
            metrics_interval_steps: 20_000,
            evaluation_interval_steps: 250_000,
            checkpoint_interval_steps: 1_000_000,
            stop_when_accepted: false,
            replay_capacity: 1_000_000,
        }
    }
}

/// A controller that training begins with: does the learner keep what it does, or leave it?
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WarmStart {
    /// Its file, from the folder in which training begins, or `shipped` or `robust`, which come with the program. Its hidden
    /// layers must be those of `learner.actor_hidden`.
    pub controller: String,
    /// Environment steps at the beginning in which only the critics learn, so that the actor is not led by critics that
    /// know nothing yet.
    #[serde(default)]
    pub critic_steps: u64,
}

/// A whole experiment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Experiment {
    /// The recipe or file that gives everything a file leaves out; `paper` if the file names none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base: Option<String>,
    /// Name of the experiment; a run's folder is named after it.
    pub name: String,
    /// Seed of everything random.
    pub seed: u64,
    /// The body.
    pub body: BodyParameters,
    /// The task.
    pub task: TaskParameters,
    /// The curriculum.
    pub curriculum: Curriculum,
    /// The learner.
    pub learner: SacConfig,
    /// The training loop.
    pub training: TrainingParameters,
    /// What is asked of its controllers.
    pub criteria: Criteria,
}

impl Default for Experiment {
    fn default() -> Self {
        Self {
            base: None,
            name: "unnamed".to_owned(),
            seed: 1,
            body: BodyParameters::default(),
            task: TaskParameters::default(),
            curriculum: Curriculum::default(),
            learner: SacConfig::default(),
            training: TrainingParameters::default(),
            criteria: Criteria::default(),
        }
    }
}

impl Experiment {
    /// The learner's settings where no phase says otherwise. An entropy that is learned has no fixed α; it counts as 0.
    pub fn own_learner_settings(&self) -> LearnerSettings {
        let l = &self.learner;
        LearnerSettings {
            learning_rate: l.learning_rate,
            alpha: match l.temperature {
                Temperature::Fixed { alpha } => alpha,
                Temperature::Auto { .. } => 0.0,
            },
            horizon: 1.0 / (1.0 - l.gamma),
            rehearsal: 0.0,
        }
    }

    /// The learner's settings at environment step `step`.
    pub fn learner_at(&self, step: u64) -> LearnerSettings {
        let own = self.own_learner_settings();
        self.curriculum.learner_at(step, &own)
    }

    /// The resolved configuration as TOML, every value written out.
    ///
    /// # Errors
    /// Never for a valid experiment; a value TOML cannot hold otherwise.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }
}

/// A configuration that cannot be used: the file, what is wrong, what to do.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}; {remedy}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
        /// What to do.
        remedy: &'static str,
    },
    /// The text is not valid TOML, or a key is unknown or of the wrong type.
    #[error("{origin}: {message}")]
    Parse {
        /// The file or recipe.
        origin: String,
        /// What the parser says, with line or key.
        message: String,
    },
    /// A body parameter is out of range.
    #[error("{origin}: {source}")]
    Body {
        /// The file or recipe.
        origin: String,
        /// Which and why.
        source: ParameterError,
    },
    /// A task or curriculum parameter is out of range.
    #[error("{origin}: {source}")]
    Task {
        /// The file or recipe.
        origin: String,
        /// Which and why.
        source: TaskError,
    },
    /// A learner or training parameter is out of range.
    #[error("{origin}: {message}")]
    Value {
        /// The file or recipe.
        origin: String,
        /// Which and why.
        message: String,
    },
    /// No such recipe.
    #[error("{origin}: there is no recipe `{name}`; {known} {remedy}")]
    UnknownRecipe {
        /// Where the name was given.
        origin: String,
        /// What was asked for.
        name: String,
        /// What was probably meant, or what there is.
        known: String,
        /// What else may be given.
        remedy: String,
    },
}
