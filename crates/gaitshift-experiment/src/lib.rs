//! Training runs from configuration to controller: recipes, the training loop, run folders and
//! checkpoints, controller files, rollouts, and the criteria that a finished controller has to meet.

mod acceptance;
mod config;
mod controller;
mod criteria;
mod durable;
mod earned;
mod edits;
mod evaluations;
mod hardening;
mod logs;
mod pace;
mod parallel;
mod profile;
mod provenance;
mod rehearsal;
mod review;
mod rollout;
mod run_folder;
mod seeds;
mod shipped;
mod simulation;
mod stress;
mod sweep;
mod tensorboard;
mod tensors;
mod training;
mod training_error;

pub use acceptance::{
    Check, Judgement, SteadyMotion, TriedChange, judge, judge_from, tries_of_change,
};
pub use config::{
    ConfigError, Experiment, RECIPES, Symmetry, TrainingParameters, WarmStart, did_you_mean,
    load_body_overrides, load_disturbance, set_body_and_task,
};
pub use controller::{Controller, ControllerError, Deterministic};
pub use criteria::{AskedChange, AskedGait, Criteria};
pub use durable::{sync_files, sync_folder, write as write_durably};
pub use earned::{Earned, earned};
pub use evaluations::{
    EvaluatedChange, EvaluatedChanges, EvaluatedCriterion, EvaluatedMotion, Evaluation, RunName,
};
pub use hardening::{Hardening, HardeningOutcomes, HardeningPlan, HardeningRound, STEP_UP_MAX_M};
pub use pace::steps_per_second;
pub use profile::{CommandProfile, ProfileError};
pub use provenance::{Provenance, portable_command, portable_path, quoted};
pub use rehearsal::{RehearsalParameters, best_walk};
pub use review::Review;
pub use rollout::Rollout;
pub use run_folder::is_finished;
pub use seeds::parse_seeds;
pub use simulation::{Control, Simulation, recording_row};
pub use stress::{Limit, Stress, StressKind, StressPlan, stress};
pub use sweep::{
    Estimate, EvaluationSummary, Sweep, SweepReport, SweepTable, Trial, TrialSettings,
    TrialSummary, Variant, VariantSummary, begin_trial, folder_name, sweep_command,
};
pub use training::{Observer, Parts, Progress, RunReport, Training, starting_controller};
pub use training_error::TrainingError;
