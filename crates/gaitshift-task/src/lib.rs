//! What is asked of the body: observation and its mirror, the reward of the paper term by term,
//! endings of an episode, the curriculum as data, randomized episodes, a batch of environments for training,
//! and a vector of them with automatic resets for everybody else.

mod batch;
mod conditions;
mod curriculum;
mod disturbance;
mod environment;
mod error;
mod expression;
mod extra;
mod learner;
mod observation;
mod outcome;
mod overrides;
mod parameters;
mod randomization;
mod ranges;
mod reward;
mod sensor_noise;
mod start;
mod terrain;
mod touchdowns;
mod vector;

pub use batch::{BatchState, EnvironmentBatch, FinishedEpisode, Member};
pub use curriculum::{CommandDraw, Curriculum, OMEGA_V_MAX, Phase, PhaseSettings};
pub use disturbance::{Disturbance, Disturbed, Push};
pub use environment::Environment;
pub use error::TaskError;
pub use expression::{Expression, QUANTITIES};
pub use extra::{ExtraRule, ExtraRules, ExtraTerm, ExtraTerms};
pub use learner::LearnerSettings;
pub use observation::{
    ACTION_MIRROR, ACTION_SIZE, OBSERVATION_MIRROR, OBSERVATION_NAMES, OBSERVATION_SCALE,
    OBSERVATION_SIZE, observe, scale_observation,
};
pub use outcome::{EndReason, MOST_EXTRA, RewardTerms, StepEnergies, StepOutcome};
pub use overrides::{Keyed, Overrides};
pub use parameters::{TaskParameters, TerminationParameters};
pub use randomization::{BodyFactors, Randomization};
pub use ranges::{PushRanges, StepRanges, TerrainRanges, UnevenRanges};
pub use reward::{LegTerm, RewardParameters};
pub use sensor_noise::SensorNoise;
pub use start::StartParameters;
pub use terrain::{TerrainParameters, TerrainStep, UnevenGround};
pub use touchdowns::Touchdowns;
pub use vector::{
    AutoReset, INFO_SIZE, INFO_WIDTH, Opening, VectorEnvironment, VectorState, VectorStep,
    info_names,
};
