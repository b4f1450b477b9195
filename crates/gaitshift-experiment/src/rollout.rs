//! Runs a controller on the body and records the motion.

use crate::CommandProfile;
use gaitshift_analysis::recording::{Recording, RecordingMetadata, RowError};
use gaitshift_body::{AdvanceReport, Body, BodyState, LEFT, RIGHT};
use gaitshift_task::{
    ACTION_SIZE, EndReason, Environment, OBSERVATION_SIZE, RewardTerms, TaskParameters,
    scale_observation,
};

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
        let p = self.body.parameters();
        let period = self.task.control_period_s;
        let mut task = self.task.clone();
        task.termination.time_limit_s = f64::INFINITY;
        let mut recording = Recording::new(RecordingMetadata {
            control_period_s: period,
            total_mass_kg: p.total_mass_kg(),
            gravity_m_per_s2: p.gravity_m_per_s2,
            leg_length_m: p.leg_length_m,
            body: serde_json::to_value(p).unwrap_or_default(),
            controller: self.controller.to_owned(),
            seed: self.seed,
            fell: false,
            ended_by: EndReason::TimeLimit.name().to_owned(),
        });
        let mut environment = Environment::new(self.body, self.start, self.profile.at(0.0));
        let contact = [RIGHT, LEFT].map(|i| self.body.foot_contact(&self.start, i));
        let at_start = AdvanceReport {
            normal_n: contact.map(|c| c.normal_n),
            tangential_n: contact.map(|c| c.tangential_n),
            ..AdvanceReport::default()
        };
        let mut row = Vec::new();
        let mut action = [0.0; ACTION_SIZE];
        self.fill(
            &mut row,
            0.0,
            &environment,
            action,
            &at_start,
            &RewardTerms::default(),
        );
        recording.push_row(&row)?;
        let mut scaled = [0.0; OBSERVATION_SIZE];
        for k in 1..=(self.duration_s / period).round() as u64 {
            let before = (k - 1) as f64 * period;
            environment.omega_v = self.profile.at(before);
            scale_observation(&environment.observation(), &mut scaled);
            control.act(&scaled, &mut action);
            let command = action.map(f64::from);
            let outcome = environment.step(self.body, &task, &task.reward, command);
            if outcome.ended != Some(EndReason::Diverged) {
                let time_s = k as f64 * period;
                self.fill(
                    &mut row,
                    time_s,
                    &environment,
                    action,
                    &outcome.report,
                    &outcome.terms,
                );
                recording.push_row(&row)?;
            }
            if let Some(ended) = outcome.ended {
                recording.metadata.fell = true;
                recording.metadata.ended_by = ended.name().to_owned();
                break;
            }
        }
        Ok(recording)
    }

    /// One row, in the order of `gaitshift_analysis::recording::COLUMNS`.
    fn fill(
        &self,
        row: &mut Vec<f64>,
        time_s: f64,
        environment: &Environment,
        action: [f32; ACTION_SIZE],
        report: &AdvanceReport,
        terms: &RewardTerms,
    ) {
        let s = &environment.state;
        let (energy, account) = (self.body.energy(s), &environment.account);
        row.clear();
        row.extend([time_s, environment.omega_v, s.x, s.z, s.theta]);
        row.extend([s.x_dot, s.z_dot, s.theta_dot]);
        for i in [RIGHT, LEFT] {
            let leg = &s.legs[i];
            row.extend([s.phi(i), leg.thigh, leg.d(), leg.w()]);
            row.extend([s.phi_dot(i), leg.thigh_dot, leg.d_dot(), leg.w_dot()]);
        }
        row.extend(action.map(f64::from));
        for i in [RIGHT, LEFT] {
            row.extend([
                report.actuator_n[i],
                report.normal_n[i],
                report.tangential_n[i],
            ]);
        }
        row.extend([energy.kinetic, energy.gravitational]);
        row.extend([energy.hip_springs, energy.leg_springs(), energy.elastic()]);
        row.extend([energy.contact, energy.stops]);
        row.extend([account.work(), account.positive_work()]);
        row.extend([account.dampers(), account.contact(), account.stops]);
        row.extend([
            terms.sum(),
            terms.energy,
            terms.velocity,
            terms.forward,
            terms.alive,
            terms.leg,
            terms.friction,
            terms.work,
        ]);
    }
}
