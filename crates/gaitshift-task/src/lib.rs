//! What is asked of the body: observation and its mirror, the reward of the paper term by term,
//! endings of an episode, the curriculum as data, randomized episodes, and a batch of environments stepped together.

mod curriculum;
mod environment;
mod observation;
mod parameters;
mod randomization;
mod reward;

pub use curriculum::{CommandDraw, Curriculum, Phase, PhaseSettings};
pub use environment::{
    BatchState, EndReason, Environment, EnvironmentBatch, FinishedEpisode, Lane, StepOutcome,
};
pub use observation::{
    ACTION_MIRROR, ACTION_SIZE, OBSERVATION_MIRROR, OBSERVATION_NAMES, OBSERVATION_SCALE,
    OBSERVATION_SIZE, observe, scale_observation,
};
pub use parameters::{StartParameters, TaskError, TaskParameters, TerminationParameters};
pub use randomization::{BodyFactors, Randomization, SensorNoise};
pub use reward::{LegTerm, RewardOverrides, RewardParameters, RewardTerms, StepEnergies};
