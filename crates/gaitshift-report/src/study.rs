//! What is measured of one controller, and what was found.

mod changes;
mod disturbances;
mod landing;
mod motions;
mod plan;

pub use changes::Change;
pub use disturbances::{NoiseTolerance, StepHeight};
pub use landing::Landing;
pub use motions::{StartedMotion, Steady};
pub use plan::Plan;

use crate::trace::Trace;
use crate::{Episodes, ReportError, ReturnMap, Subject};
use changes::{AROUND_S, changes_by_phase, gaits_of_round_trip};
use disturbances::{noise_tolerance, steps_in_the_ground};
use gaitshift_analysis::recording::Recording;
use gaitshift_analysis::{GaitChange, GaitClass, GaitSummary, TransitionOptions, changes_of_gait};
use gaitshift_experiment::CommandProfile;
use motions::{fine_steps, random_starts, record, stairs, steady_motion};
use plan::commands;
use serde::Serialize;

/// What was measured of one subject. Everything in it is a number that goes into the report's JSON.
#[derive(Debug, Clone, Serialize)]
pub struct Study {
    /// Name of the subject.
    pub name: String,
    /// Its experiment.
    pub group: String,
    /// Seed of its training.
    pub seed: u64,
    /// Where the controller comes from.
    pub provenance: gaitshift_experiment::Provenance,
    /// Integration step, in s.
    pub time_step_s: f64,
    /// Steady motions, the lowest command first.
    pub steady: Vec<Steady>,
    /// The motions at 0, 0.5, …, 3.5 with the finer integration step.
    pub fine_step: Vec<Steady>,
    /// The stairs of the command on the way up and down.
    pub stairs_up: Vec<Steady>,
    /// On the way down.
    pub stairs_down: Vec<Steady>,
    /// Motions from random starts.
    pub starts: Vec<StartedMotion>,
    /// Changes from walking to running, one for each phase of the stride.
    pub to_running: Vec<Change>,
    /// Changes from running to walking.
    pub to_walking: Vec<Change>,
    /// The gaits of a walk, run and walk again in one motion; the last is only there if it did not fall.
    pub walk_run_walk: Vec<GaitClass>,
    /// Its changes of gait, each with the steps that it takes.
    pub round_trip: Vec<GaitChange>,
    /// Steps in the ground.
    pub step_heights: Vec<StepHeight>,
    /// Noise.
    pub noise: Vec<NoiseTolerance>,
    /// Return maps, of the commands under which it strides.
    pub return_maps: Vec<ReturnMap>,
    /// How feet come down.
    pub landings: Vec<Landing>,
    /// Share of the late episodes of its training that ended in a fall.
    pub late_falls: Option<f64>,
}

/// A study with the recordings that its figures show.
#[derive(Debug, Clone)]
pub struct Measured {
    /// The numbers.
    pub study: Study,
    /// The walk and the run at the plan's commands.
    pub gaits: [Recording; 2],
    /// The changes up and down, and when the command begins to change, in s.
    pub changes: [(Recording, f64); 2],
    /// The round trip.
    pub round_trip: Recording,
    /// Motions at the integration step, each with its command.
    pub traces: Vec<(f64, Trace)>,
    /// Episodes of the training, empty without a run's folder.
    pub episodes: Episodes,
}

/// The part of a motion that is followed at the integration step, in s.
const TRACED_S: [f64; 2] = [15.0, 19.0];

/// Ways that count as success under noise, walking and running, in m, as in the journal version.
const NOISY_WAYS_M: [f64; 2] = [10.0, 20.0];

impl Measured {
    /// Measures a subject.
    ///
    /// # Errors
    /// A motion that cannot be recorded, or a log of its run that cannot be read.
    pub fn measure(
        subject: &mut Subject,
        plan: &Plan,
        progress: &mut dyn FnMut(&str),
    ) -> Result<Self, ReportError> {
        let [walk, run] = plan.gaits;
        let constant = CommandProfile::constant;

        progress("steady motions");
        let mut steady = Vec::new();
        for omega_v in commands(plan.range) {
            steady.push(steady_motion(subject, omega_v, plan.steady_s)?);
        }
        let gaits = [
            record(subject, &constant(walk), 20.0, None)?,
            record(subject, &constant(run), 20.0, None)?,
        ];
        progress("finer integration step");
        let fine_step = fine_steps(subject, plan)?;

        progress("rising and falling command");
        let (stairs_up, stairs_down) = stairs(subject, plan)?;
        progress("random starts");
        let starts = random_starts(subject, plan)?;

        progress("changes of gait");
        let to_running = changes_by_phase(subject, plan, [walk, run])?;
        let to_walking = changes_by_phase(subject, plan, [run, walk])?;
        let change = |subject: &mut Subject, from: f64, to: f64| {
            let profile = CommandProfile::ramp(from, to, AROUND_S, plan.ramp_s);
            record(subject, &profile, 2.0 * AROUND_S + plan.ramp_s, None)
        };
        let changes = [
            (change(subject, walk, run)?, AROUND_S),
            (change(subject, run, walk)?, AROUND_S),
        ];
        let profile = constant(walk)
            .then_ramp(run, AROUND_S, plan.ramp_s)
            .then_ramp(walk, 2.0 * AROUND_S, plan.ramp_s);
        let round_trip = record(subject, &profile, 3.0 * AROUND_S, None)?;
        let walk_run_walk = gaits_of_round_trip(&round_trip);
        let ramps = [1.0, 2.0].map(|k| (k * AROUND_S, k * AROUND_S + plan.ramp_s));
        let options = TransitionOptions::default();
        let round_trip_changes = changes_of_gait(&round_trip, &ramps, &options);

        progress("steps in the ground");
        let mut step_heights = Vec::new();
        for omega_v in plan.gaits {
            for (sign, by_turns) in [(1.0, false), (-1.0, false), (1.0, true)] {
                let rows = steps_in_the_ground(subject, plan, omega_v, sign, by_turns);
                step_heights.extend(rows);
            }
        }
        progress("sensor noise");
        let mut noise = Vec::new();
        for ((omega_v, way_m), recording) in plan.gaits.into_iter().zip(NOISY_WAYS_M).zip(&gaits) {
            noise.extend(noise_tolerance(subject, plan, omega_v, way_m, recording));
        }

        progress("motions at the integration step");
        let mut traces = Vec::new();
        for &omega_v in &plan.followed {
            traces.push((
                omega_v,
                Trace::follow(subject, omega_v, TRACED_S[0], TRACED_S[1])?,
            ));
        }
        progress("return maps");
        let mut return_maps = Vec::new();
        for &omega_v in &plan.followed {
            return_maps.extend(ReturnMap::find(subject, omega_v)?);
        }
        let weight_n = subject.weight_n();
        let landings = traces
            .iter()
            .filter_map(|(omega_v, trace)| Landing::of(*omega_v, trace, weight_n))
            .collect();
        let episodes = match &subject.run {
            Some(run) => Episodes::read(run)?,
            None => Episodes::default(),
        };
        let study = Study {
            name: subject.name.clone(),
            group: subject.group.clone(),
            seed: subject.seed,
            provenance: subject.controller.provenance.clone(),
            time_step_s: subject.body.parameters().time_step_s,
            steady,
            fine_step,
            stairs_up,
            stairs_down,
            starts,
            to_running,
            to_walking,
            walk_run_walk,
            round_trip: round_trip_changes,
            step_heights,
            noise,
            return_maps,
            landings,
            late_falls: episodes.late_falls(),
        };
        Ok(Self {
            study,
            gaits,
            changes,
            round_trip,
            traces,
            episodes,
        })
    }
}

impl Study {
    /// The steady motion at a command, if it was measured.
    pub fn at(&self, omega_v: f64) -> Option<&GaitSummary> {
        self.steady_at(omega_v).map(|row| &row.summary)
    }

    pub(crate) fn steady_at(&self, omega_v: f64) -> Option<&Steady> {
        let near = |row: &&Steady| (row.omega_v - omega_v).abs() < 1e-9;
        self.steady.iter().find(near)
    }
}
