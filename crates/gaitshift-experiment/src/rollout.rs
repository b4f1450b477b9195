//! Runs a controller on the body and records the motion.

use crate::profile::CommandProfile;
use crate::simulation::{Control, Simulation};
use gaitshift_analysis::recording::{Recording, RowError, Side};
use gaitshift_analysis::support::{ContactRule, FootEventKind, Support};
use gaitshift_body::{Body, BodyState};
use gaitshift_task::{Disturbance, EndReason, Push, TaskParameters};

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
    /// Seed that drew the start, for the record; it draws the noise of a disturbance, too.
    pub seed: u64,
    /// What disturbs the motion, but for the ground, which is the body's ([`Disturbance::place`]).
    pub disturbance: Option<&'a Disturbance>,
    /// Name of the controller, for the record.
    pub controller: &'a str,
}

impl Rollout<'_> {
    /// Runs until the duration is over or the body falls, and records every control period.
    ///
    /// Where a push is to come at a phase of the stride, the motion up to it is run first to find its stride. The
    /// recording says when the push came; one for which there was no stride is left out.
    ///
    /// # Errors
    /// A row that the recording refuses; a motion that diverges ends the recording instead.
    pub fn record(&self, control: &mut impl Control) -> Result<Recording, RowError> {
        let Some(disturbance) = self.disturbance.filter(|d| !d.is_none()) else {
            return self.record_under(None, control);
        };
        let mut timed = disturbance.clone();
        // A push changes the strides after it: of those that are still to be timed on one motion only the first has its time,
        // in whatever order they are given.
        let mut reached_s = f64::NEG_INFINITY;
        while timed.pushes.iter().any(|p| p.phase.is_some()) {
            let strides = strides(&self.record_under(Some(&timed), control)?);
            let time = |push: &Push| {
                let (start_s, end_s) = strides.iter().find(|s| s.0 >= push.start_s)?;
                let at = start_s + push.phase? * (end_s - start_s);
                // The stride that a push has cut short may have been past this phase by then.
                Some(at.max(reached_s))
            };
            let times: Vec<Option<f64>> = timed.pushes.iter().map(time).collect();
            let Some(first) = times.iter().flatten().copied().reduce(f64::min) else {
                timed.pushes.retain(|p| p.phase.is_none());
                break;
            };
            for (push, time) in timed.pushes.iter_mut().zip(times) {
                if time == Some(first) {
                    (push.start_s, push.phase) = (first, None);
                }
            }
            reached_s = first;
        }
        timed.pushes.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
        let mut recording = self.record_under(Some(&timed), control)?;
        recording.metadata.disturbance = serde_json::to_value(&timed).ok();
        Ok(recording)
    }

    fn record_under(
        &self,
        disturbance: Option<&Disturbance>,
        control: &mut impl Control,
    ) -> Result<Recording, RowError> {
        let period = self.task.control_period_s;
        let omega_v = self.profile.at(0.0);
        let mut simulation = Simulation::new(self.body, self.task, self.start, omega_v);
        if let Some(disturbance) = disturbance {
            simulation.disturb(disturbance, self.seed);
        }
        simulation.record_details();
        let mut recording = Recording::new(simulation.metadata(self.controller, self.seed));
        let mut row = Vec::new();
        simulation.detailed_row(&mut row);
        recording.push_row(&row)?;
        let mut own = ExtraColumns::of(self.task);
        own.push(&simulation);
        for _ in 0..(self.duration_s / period).round() as u64 {
            let omega_v = self.profile.at(simulation.time_s());
            let ended = simulation.step(omega_v, None, control);
            if !ended.is_some_and(EndReason::is_failure) {
                simulation.detailed_row(&mut row);
                recording.push_row(&row)?;
                own.push(&simulation);
            }
            if let Some(ended) = ended {
                recording.metadata.fell = true;
                recording.metadata.ended_by = self.task.end_name(ended).to_owned();
                break;
            }
        }
        own.add_to(&mut recording)?;
        Ok(recording)
    }
}

/// Reward terms of one's own as columns of a recording that grows.
struct ExtraColumns(Vec<(String, Vec<f64>)>);

impl ExtraColumns {
    fn of(task: &TaskParameters) -> Self {
        let columns = task.reward.extra.columns();
        Self(columns.map(|column| (column, Vec::new())).collect())
    }

    fn push(&mut self, simulation: &Simulation) {
        for ((_, series), value) in self.0.iter_mut().zip(simulation.terms().extra) {
            series.push(value);
        }
    }

    fn add_to(self, recording: &mut Recording) -> Result<(), RowError> {
        self.0
            .into_iter()
            .try_for_each(|(column, series)| recording.set_extra(&column, series))
    }
}

/// Begins and ends of the strides in a recording, in s: from a touchdown of the right foot to its next.
pub(crate) fn strides(recording: &Recording) -> Vec<(f64, f64)> {
    let support = Support::find(recording, &ContactRule::default());
    let touchdowns = support
        .events()
        .iter()
        .filter(|e| e.side == Side::Right && e.kind == FootEventKind::Touchdown);
    let times: Vec<f64> = touchdowns.map(|e| e.time_s).collect();
    times.windows(2).map(|t| (t[0], t[1])).collect()
}
