//! Runs a controller on the body and records the motion.

use crate::{CommandProfile, Simulation};
use gaitshift_analysis::recording::{Recording, RowError};
use gaitshift_body::{Body, BodyState};
use gaitshift_task::{ACTION_SIZE, EndReason, OBSERVATION_SIZE, TaskParameters};

/// Anything that turns a scaled observation into two commands in [-1, 1].
pub trait Control {
    /// Reads the 14 scaled observations, writes the commands of the right and the left actuator.
    fn act(&mut self, observation: &[f32; OBSERVATION_SIZE], action: &mut [f32; ACTION_SIZE]);
}

impl<F: FnMut(&[f32; OBSERVATION_SIZE], &mut [f32; ACTION_SIZE])> Control for F {
    fn act(&mut self, observation: &[f32; OBSERVATION_SIZE], action: &mut [f32; ACTION_SIZE]) {
        self(observation, action);
    }
}

/// What a rollout runs on.
#[derive(Debug, Clone, Copy)]
pub struct Rollout<'a> {
    /// The body.
    pub body: &'a Body,
    /// The task: control period, reward, endings. Its time limit is not applied.
    pub task: &'a TaskParameters,
    /// Start of the motion.
    pub start: BodyState,
    /// The command over time.
    pub profile: &'a CommandProfile,
    /// Longest duration, in s.
    pub duration_s: f64,
    /// Seed that drew the start, for the record.
    pub seed: u64,
    /// Name of the controller, for the record.
    pub controller: &'a str,
}

impl Rollout<'_> {
    /// Runs until the duration is over or the body falls, and records every control period.
    ///
    /// # Errors
    /// A row that the recording refuses; a motion that diverges ends the recording instead.
    pub fn record(&self, control: &mut impl Control) -> Result<Recording, RowError> {
        let period = self.task.control_period_s;
        let omega_v = self.profile.at(0.0);
        let mut simulation = Simulation::new(self.body, self.task, self.start, omega_v);
        let mut recording = Recording::new(simulation.metadata(self.controller, self.seed));
        let mut row = Vec::new();
        simulation.row(&mut row);
        recording.push_row(&row)?;
        for _ in 0..(self.duration_s / period).round() as u64 {
            let omega_v = self.profile.at(simulation.time_s());
            let ended = simulation.step(omega_v, None, control);
            if ended != Some(EndReason::Diverged) {
                simulation.row(&mut row);
                recording.push_row(&row)?;
            }
            if let Some(ended) = ended {
                recording.metadata.fell = true;
                recording.metadata.ended_by = ended.name().to_owned();
                break;
            }
        }
        Ok(recording)
    }
}
