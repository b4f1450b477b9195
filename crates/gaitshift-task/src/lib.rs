//! What is asked of the body: observation and its mirror, the reward of the paper term by term,
//! endings of an episode, the curriculum as data, randomized episodes, a batch of environments for training,
//! and a vector of them with automatic resets for everybody else.

mod curriculum;
mod disturbance;
mod environment;
mod expression;
mod extra;
mod learner;
mod observation;
mod overrides;
mod parameters;
mod randomization;
mod reward;
mod vector;

pub use curriculum::{CommandDraw, Curriculum, Phase, PhaseSettings};
pub use disturbance::{Disturbance, Disturbed, Push, TerrainParameters, TerrainStep, UnevenGround};
pub use environment::{
    BatchState, EndReason, Environment, EnvironmentBatch, FinishedEpisode, Member, StepOutcome,
};
pub use expression::{Expression, QUANTITIES};
pub use extra::{ExtraRule, ExtraRules, ExtraTerm, ExtraTerms, MOST_EXTRA};
pub use learner::LearnerSettings;
pub use observation::{
    ACTION_MIRROR, ACTION_SIZE, OBSERVATION_MIRROR, OBSERVATION_NAMES, OBSERVATION_SCALE,
    OBSERVATION_SIZE, observe, scale_observation,
};
pub use overrides::{Keyed, Overrides};
pub use parameters::{StartParameters, TaskError, TaskParameters, TerminationParameters};
pub use randomization::{
    BodyFactors, PushRanges, Randomization, SensorNoise, StepRanges, TerrainRanges, UnevenRanges,
};
pub use reward::{LegTerm, RewardParameters, RewardTerms, StepEnergies};
pub use vector::{
    AutoReset, INFO_SIZE, INFO_WIDTH, Opening, VectorEnvironment, VectorState, VectorStep,
    info_names,
};
