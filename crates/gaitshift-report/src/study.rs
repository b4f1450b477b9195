//! What is measured of one controller, and what was found.

mod changes;
mod disturbances;
mod kept;
mod landing;
mod motions;
mod pace;
mod plan;

pub use changes::Change;
pub use disturbances::{NoiseTolerance, StepHeight};
pub use landing::Landing;
pub use motions::{StartedMotion, Steady};
pub use plan::Plan;

pub use kept::set_program_file;

use crate::trace::Trace;
use crate::{Episodes, ReportError, ReturnMap, Stretch, Subject};
use changes::{AROUND_S, changes_by_phase, gaits_of_round_trip};
use disturbances::{noise_tolerance, steps_in_the_ground};
use gaitshift_analysis::recording::Recording;
use gaitshift_analysis::{GaitChange, GaitClass, GaitSummary, TransitionOptions, changes_of_gait};
use gaitshift_body::{Body, BodyParameters};
use gaitshift_experiment::CommandProfile;
use motions::{random_starts, record, stairs, steady_motion};
use plan::commands;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicBool, Ordering};

/// What was measured of one subject. Everything in it is a number that goes into the report's JSON.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// Name of the subject.
    pub name: String,
    /// Its experiment.
    pub group: String,
    /// Seed of its training.
    pub seed: u64,
    /// Where the controller comes from.
    pub provenance: gaitshift_experiment::Provenance,
    /// Walking and running command: the plan's, or the nearest that it was trained with.
    pub gaits: [f64; 2],
    /// Integration step, in s.
    pub time_step_s: f64,
    /// Steady motions, the lowest command first.
    pub steady: Vec<Steady>,
    /// What is measured again with the finer integration step: steady motions at some commands, stairs, starts and landings.
    pub fine_step: Option<Box<Study>>,
    /// The stairs of the command on the way up and down.
    pub stairs_up: Vec<Steady>,
    /// On the way down.
    pub stairs_down: Vec<Steady>,
    /// Motions from random starts.
    pub starts: Vec<StartedMotion>,
    /// Changes from walking to running on the paper's ramp, one for each phase of the stride.
    pub to_running: Vec<Change>,
    /// Changes from running to walking.
    pub to_walking: Vec<Change>,
    /// The same on the journal version's ramp: to running and to walking.
    pub journal_changes: [Vec<Change>; 2],
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
    /// Its training in tenths, empty without a run's folder.
    pub training: Vec<Stretch>,
    /// The same in stretches of 100 000 steps.
    pub course: Vec<Stretch>,
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
/// Duration of the journal version's ramps, in s.
pub(crate) const JOURNAL_RAMP_S: f64 = 0.6;

/// Says what is being measured; an error of its own ends the measuring.
pub type Saying<'a> = dyn FnMut(&str) -> Result<(), ReportError> + 'a;

impl Measured {
    /// Measures a subject. What a run's folder keeps of an earlier measurement is not measured again.
    ///
    /// # Errors
    /// A motion that cannot be recorded, a log of its run that cannot be read, or what `say` returns.
    pub fn measure(
        subject: &mut Subject,
        plan: &Plan,
        say: &mut Saying,
    ) -> Result<Self, ReportError> {
        let plan = &plan.of(subject);
        let kept = kept::read(subject, plan);
        say(if kept.is_some() {
            "measured before; the motions of its figures"
        } else {
            "motions of its figures"
        })?;
        let mut measured = Self::record(subject, plan)?;
        measured.study = match kept {
            Some(study) => study,
            None => {
                let study = measured.numbers(subject, plan, say)?;
                if let Err(cause) = kept::write(subject, plan, &study) {
                    say(&format!("its measurements are not kept: {cause}"))?;
                }
                study
            }
        };
        measured.study.describe(subject, &measured.episodes);
        Ok(measured)
    }

    /// The motions that figures show.
    fn record(subject: &mut Subject, plan: &Plan) -> Result<Self, ReportError> {
        let [walk, run] = plan.gaits;
        let constant = CommandProfile::constant;
        let gaits = [
            record(subject, &constant(walk), 20.0, None)?,
            record(subject, &constant(run), 20.0, None)?,
        ];
        let change = |subject: &mut Subject, from: f64, to: f64| {
            let profile = CommandProfile::ramp(from, to, AROUND_S, plan.ramp_s);
            record(subject, &profile, 2.0 * AROUND_S + plan.ramp_s, None)
        };
        let changes = [
            (change(subject, walk, run)?, AROUND_S),
            (change(subject, run, walk)?, AROUND_S),
        ];
        let profile = constant(walk)
            .then_ramp(run, AROUND_S, JOURNAL_RAMP_S)
            .then_ramp(walk, 2.0 * AROUND_S, JOURNAL_RAMP_S);
        let round_trip = record(subject, &profile, 3.0 * AROUND_S, None)?;
        let mut traces = Vec::new();
        for &omega_v in &plan.followed {
            let [from_s, to_s] = TRACED_S;
            traces.push((omega_v, Trace::follow(subject, omega_v, from_s, to_s)?));
        }
        Ok(Self {
            study: Study::default(),
            gaits,
            changes,
            round_trip,
            traces,
            episodes: episodes(subject)?,
        })
    }

    /// What is measured besides; the finer integration step at the same time as the usual one.
    fn numbers(
        &self,
        subject: &mut Subject,
        plan: &Plan,
        say: &mut Saying,
    ) -> Result<Study, ReportError> {
        let other = subject.clone();
        let stopped = AtomicBool::new(false);
        let measure_finer = || fine_step(other.clone(), plan, &stopped);
        std::thread::scope(|scope| {
            let fine = std::thread::Builder::new().spawn_scoped(scope, measure_finer);
            let usual = self
                .usual_numbers(subject, plan, say)
                .and_then(|study| say("finer integration step").map(|()| study));
            stopped.store(usual.is_err(), Ordering::Relaxed);
            let mut study = usual?;
            let fine = match fine.map(std::thread::ScopedJoinHandle::join) {
                Ok(Ok(fine)) => fine?,
                Ok(Err(panic)) => std::panic::resume_unwind(panic),
                // The system refuses a thread.
                Err(_) => measure_finer()?,
            };
            study.fine_step = Some(Box::new(fine));
            Ok(study)
        })
    }

    fn usual_numbers(
        &self,
        subject: &mut Subject,
        plan: &Plan,
        say: &mut Saying,
    ) -> Result<Study, ReportError> {
        let [walk, run] = plan.gaits;
        say("steady motions")?;
        let mut steady = Vec::new();
        for omega_v in commands(plan.range) {
            steady.push(steady_motion(subject, omega_v, plan.steady_s)?);
        }
        say("rising and falling command")?;
        let (stairs_up, stairs_down) = stairs(subject, plan)?;
        say("random starts")?;
        let starts = random_starts(subject, plan)?;

        say("changes of gait")?;
        let slower = Plan {
            ramp_s: JOURNAL_RAMP_S,
            ..plan.clone()
        };
        let to_running = changes_by_phase(subject, plan, [walk, run])?;
        let to_walking = changes_by_phase(subject, plan, [run, walk])?;
        let journal_changes = [
            changes_by_phase(subject, &slower, [walk, run])?,
            changes_by_phase(subject, &slower, [run, walk])?,
        ];
        let walk_run_walk = gaits_of_round_trip(&self.round_trip);
        let ramps = [1.0, 2.0].map(|k| (k * AROUND_S, k * AROUND_S + JOURNAL_RAMP_S));
        let round_trip = changes_of_gait(&self.round_trip, &ramps, &TransitionOptions::default());

        let mut step_heights = Vec::new();
        for omega_v in plan.gaits {
            say(&format!("steps in the ground at {omega_v}"))?;
            for (sign, by_turns) in [(1.0, false), (-1.0, false), (1.0, true)] {
                let rows = steps_in_the_ground(subject, plan, omega_v, sign, by_turns);
                step_heights.extend(rows);
            }
        }
        let mut noise = Vec::new();
        let motions = plan.gaits.into_iter().zip(NOISY_WAYS_M).zip(&self.gaits);
        for ((omega_v, way_m), recording) in motions {
            say(&format!("sensor noise at {omega_v}"))?;
            noise.extend(noise_tolerance(subject, plan, omega_v, way_m, recording));
        }
        say("return maps")?;
        let mut return_maps = Vec::new();
        for &omega_v in &plan.followed {
            return_maps.extend(ReturnMap::find(subject, omega_v)?);
        }
        Ok(Study {
            gaits: plan.gaits,
            steady,
            stairs_up,
            stairs_down,
            starts,
            to_running,
            to_walking,
            journal_changes,
            walk_run_walk,
            round_trip,
            step_heights,
            noise,
            return_maps,
            landings: landings(&self.traces, subject.weight_n()),
            ..Study::default()
        })
    }
}

/// The episodes of a subject's training.
fn episodes(subject: &Subject) -> Result<Episodes, ReportError> {
    match &subject.run {
        Some(run) => Episodes::read(run),
        None => Ok(Episodes::default()),
    }
}

fn landings(traces: &[(f64, Trace)], weight_n: f64) -> Vec<Landing> {
    let landing = |(omega_v, trace): &(f64, Trace)| Landing::of(*omega_v, trace, weight_n);
    traces.iter().filter_map(landing).collect()
}

/// What the headline numbers need, with the finer integration step: motions as long as the usual ones, the same stairs and starts.
fn fine_step(
    mut subject: Subject,
    plan: &Plan,
    stopped: &AtomicBool,
) -> Result<Study, ReportError> {
    let go_on = || match stopped.load(Ordering::Relaxed) {
        true => Err(ReportError::Stopped),
        false => Ok(()),
    };
    let parameters = BodyParameters {
        time_step_s: plan.fine_step_s,
        ..subject.body.parameters().clone()
    };
    subject.body = Body::new(parameters)
        .map_err(|cause| ReportError::Subject(format!("{}: {cause}", subject.name)))?;
    let subject = &mut subject;
    let mut steady = Vec::new();
    for omega_v in fine_commands(plan) {
        go_on()?;
        steady.push(steady_motion(subject, omega_v, plan.steady_s)?);
    }
    go_on()?;
    let (stairs_up, stairs_down) = stairs(subject, plan)?;
    go_on()?;
    let starts = random_starts(subject, plan)?;
    let [from_s, to_s] = TRACED_S;
    let run = plan.gaits[1];
    let traces = [(run, Trace::follow(subject, run, from_s, to_s)?)];
    Ok(Study {
        gaits: plan.gaits,
        time_step_s: plan.fine_step_s,
        steady,
        stairs_up,
        stairs_down,
        starts,
        landings: landings(&traces, subject.weight_n()),
        ..Study::default()
    })
}

/// Of the plan's commands every tenth of them up to 0.5, where the walk is, and every half beyond.
fn fine_commands(plan: &Plan) -> Vec<f64> {
    let usual = commands(plan.range);
    let mut fine = commands([0.0, 0.45, 0.05]);
    fine.extend(commands([0.5, 3.5, 0.5]));
    let measured = |w: &f64| usual.iter().any(|u| (u - w).abs() < 1e-9);
    fine.retain(measured);
    fine
}

impl Plan {
    /// The same, its walk and run at commands that the subject was trained with.
    pub(crate) fn of(&self, subject: &Subject) -> Self {
        let mut own = self.clone();
        if let Some([low, high]) = subject.trained {
            own.gaits = own.gaits.map(|omega_v| omega_v.max(low).min(high));
            // Their motions are followed in any case.
            if !own.followed.is_empty() {
                own.followed.extend(own.gaits);
                own.followed.sort_by(f64::total_cmp);
                own.followed.dedup();
            }
        }
        own
    }
}

impl Study {
    /// Measures a subject of which no figure is drawn; less than [`Measured::measure`] if its run's folder has the measurements.
    ///
    /// # Errors
    /// As [`Measured::measure`].
    pub fn measure(
        subject: &mut Subject,
        plan: &Plan,
        say: &mut Saying,
    ) -> Result<Self, ReportError> {
        if let Some(mut study) = kept::read(subject, &plan.of(subject)) {
            say("measured before")?;
            study.describe(subject, &episodes(subject)?);
            return Ok(study);
        }
        Ok(Measured::measure(subject, plan, say)?.study)
    }

    /// What is not measured: names, and what the log of the training says.
    fn describe(&mut self, subject: &Subject, episodes: &Episodes) {
        self.name.clone_from(&subject.name);
        self.group.clone_from(&subject.group);
        self.seed = subject.seed;
        self.provenance = subject.controller.provenance.clone();
        self.time_step_s = subject.body.parameters().time_step_s;
        self.late_falls = episodes.late_falls();
        self.training = episodes.tenths();
        self.course = episodes.course();
    }

    /// The part of it that is measured with the finer integration step, too.
    pub(crate) fn beside_fine_step(&self) -> Self {
        let fine = self.fine_step.as_deref();
        let mut part = self.clone();
        part.steady
            .retain(|row| fine.is_some_and(|f| f.at(row.omega_v).is_some()));
        part
    }

    /// The steady motion at a command, if it was measured.
    pub fn at(&self, omega_v: f64) -> Option<&GaitSummary> {
        self.steady_at(omega_v).map(|row| &row.summary)
    }

    /// The same if the body did not fall: what leads to a fall is no steady motion.
    pub(crate) fn upright_at(&self, omega_v: f64) -> Option<&GaitSummary> {
        self.at(omega_v).filter(|summary| !summary.fell)
    }

    pub(crate) fn steady_at(&self, omega_v: f64) -> Option<&Steady> {
        let near = |row: &&Steady| (row.omega_v - omega_v).abs() < 1e-9;
        self.steady.iter().find(near)
    }
}
