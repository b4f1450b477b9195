//! What is measured of one controller, and what was found.

use crate::trace::Trace;
use crate::{Episodes, ReportError, ReturnMap, Subject};
use gaitshift_analysis::recording::{Recording, Window, column};
use gaitshift_analysis::{
    AnalysisOptions, GaitChange, GaitClass, GaitSummary, TransitionOptions, TransitionSummary,
    changes_of_gait, summarise, summarise_transition,
};
use gaitshift_body::{Body, BodyParameters};
use gaitshift_experiment::{CommandProfile, Deterministic, Rollout, Simulation};
use gaitshift_task::{Disturbance, Environment, SensorNoise, TerrainStep};
use serde::Serialize;

/// What is measured, and how closely.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plan {
    /// Walking and running command.
    pub gaits: [f64; 2],
    /// Least and greatest command of the steady motions, and the step between them.
    pub range: [f64; 3],
    /// Duration of each steady motion, in s; the first 5 s are not measured.
    pub steady_s: f64,
    /// The stairs of the command lead from 0 to this and back, in these steps, each held for so long (s).
    pub stairs: [f64; 3],
    /// Random starts at each command of the stairs' range.
    pub starts: u64,
    /// Step between those commands.
    pub starts_step: f64,
    /// Trials of each disturbance.
    pub trials: u64,
    /// Heights of steps in the ground that are tried: least, greatest and the step between them, in m.
    pub step_heights_m: [f64; 3],
    /// Levels of noise that are tried, in standard deviations of the observation itself.
    pub noise_levels: Vec<f64>,
    /// Commands whose motion is followed at the integration step, and whose return map is sought.
    pub followed: Vec<f64>,
    /// Finer integration step beside the usual one, in s.
    pub fine_step_s: f64,
    /// Duration of a ramp of the command, in s, and phases of the stride from which it begins.
    pub ramp_s: f64,
    /// Phases of the stride.
    pub phases: usize,
}

impl Plan {
    /// The whole study.
    pub fn full() -> Self {
        Self {
            gaits: [0.0, 3.0],
            range: [-0.5, 3.5, 0.01],
            steady_s: 30.0,
            stairs: [1.0, 0.02, 20.0],
            starts: 13,
            starts_step: 0.05,
            trials: 10,
            step_heights_m: [0.002, 0.04, 0.002],
            noise_levels: vec![0.05, 0.1, 0.2, 0.5, 1.0, 2.0],
            followed: vec![0.0, 0.2, 0.4, 1.0, 3.0],
            fine_step_s: 5e-5,
            ramp_s: 0.4,
            phases: 20,
        }
    }

    /// The same questions with coarser steps and fewer starts.
    pub fn quick() -> Self {
        Self {
            range: [-0.5, 3.5, 0.05],
            steady_s: 20.0,
            starts: 8,
            phases: 10,
            ..Self::full()
        }
    }
}

/// A steady motion under one command, or one stair of the command.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Steady {
    /// The command.
    pub omega_v: f64,
    /// Mean change of the total energy (2) within a control period, as an amount, in J.
    pub energy_change_j: Option<f64>,
    /// What the motion is.
    #[serde(flatten)]
    pub summary: GaitSummary,
}

/// A motion from a random start.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StartedMotion {
    /// The command.
    pub omega_v: f64,
    /// Seed that draws the start.
    pub seed: u64,
    /// What it is in the end.
    pub gait: GaitClass,
    /// Its mean speed, in m/s.
    pub speed_m_per_s: Option<f64>,
    /// Share of the right leg's stride on the ground.
    pub duty_factor: Option<f64>,
}

/// A change of gait on a ramp of the command.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change {
    /// Whether it was survived.
    pub survived: bool,
    /// Gait before.
    pub before: Option<GaitClass>,
    /// Gait after.
    pub after: Option<GaitClass>,
    /// Steps that it takes.
    pub steps: Option<usize>,
}

impl Change {
    fn of(summary: &TransitionSummary) -> Self {
        Self {
            survived: summary.survived,
            before: summary.gait_before,
            after: summary.gait_after,
            steps: summary.steps_to_change,
        }
    }

    /// Whether it led from `from` to `to`.
    pub fn leads(&self, from: GaitClass, to: GaitClass) -> bool {
        self.survived && self.before == Some(from) && self.after == Some(to)
    }
}

/// How feet come down and legs press under one command, from the motion at the integration step; means over its stances.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Landing {
    /// The command.
    pub omega_v: f64,
    /// Stances, both legs.
    pub stances: usize,
    /// Forward speed of the sole at touchdown, in m/s.
    pub sole_forward_m_per_s: f64,
    /// Downward speed of the sole at touchdown, in m/s.
    pub sole_down_m_per_s: f64,
    /// Greatest vertical force of a stance, in body weights.
    pub peak_body_weights: f64,
    /// When it comes, in s after touchdown.
    pub peak_after_s: f64,
    /// Share of the variance of the force along the leg that its length explains in a straight line, in [0, 1].
    pub spring_like: Option<f64>,
}

impl Landing {
    fn of(omega_v: f64, trace: &Trace, weight_n: f64) -> Option<Self> {
        let stances: Vec<(usize, std::ops::Range<usize>)> = (0..2)
            .flat_map(|leg| {
                trace
                    .stances(leg, weight_n)
                    .into_iter()
                    .map(move |s| (leg, s))
            })
            .collect();
        let mean = |of: &dyn Fn(usize, &std::ops::Range<usize>) -> f64| {
            let values: Vec<f64> = stances.iter().map(|(leg, s)| of(*leg, s)).collect();
            gaitshift_analysis::statistics::mean(&values)
        };
        let highest = |leg: usize, stance: &std::ops::Range<usize>| {
            let rows = stance.clone();
            rows.max_by(|&a, &b| {
                let force = |k: usize| trace.rows[k].normal_n[leg];
                force(a).total_cmp(&force(b))
            })
            .unwrap_or(stance.start)
        };
        let before = |leg: usize, stance: &std::ops::Range<usize>| {
            // The step before the force passes its threshold: the sole is about to land.
            trace.rows[stance.start.saturating_sub(1)].sole_m_per_s[leg]
        };
        let (lengths, forces): (Vec<f64>, Vec<f64>) = stances
            .iter()
            .flat_map(|(leg, stance)| trace.rows[stance.clone()].iter().map(move |r| (leg, r)))
            .map(|(&leg, row)| (row.length_m[leg], row.axial_n[leg]))
            .unzip();
        Some(Self {
            omega_v,
            stances: stances.len(),
            sole_forward_m_per_s: mean(&|leg, s| before(leg, s)[0])?,
            sole_down_m_per_s: mean(&|leg, s| -before(leg, s)[1])?,
            peak_body_weights: mean(&|leg, s| {
                trace.rows[highest(leg, s)].normal_n[leg] / weight_n
            })?,
            peak_after_s: mean(&|leg, s| {
                trace.rows[highest(leg, s)].time_s - trace.rows[s.start].time_s
            })?,
            spring_like: gaitshift_analysis::statistics::correlation(&lengths, &forces)
                .map(|correlation| correlation * correlation),
        })
    }
}

/// Attempts at a step in the ground, or at a row of them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StepHeight {
    /// The command.
    pub omega_v: f64,
    /// Height in m; negative leads down.
    pub height_m: f64,
    /// Whether it is not a single step but leads up and down by turns every 50 cm.
    pub by_turns: bool,
    /// Attempts in which it got beyond, the step at another place each time.
    pub successes: usize,
    /// Attempts.
    pub trials: usize,
}

/// Attempts under noise on one observation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NoiseTolerance {
    /// The command.
    pub omega_v: f64,
    /// Name of the observation; one with legs has noise on both.
    pub observation: &'static str,
    /// Standard deviation of the noise over that of the observation itself in the undisturbed motion.
    pub level: f64,
    /// Standard deviation of the noise, in the observation's unit.
    pub deviation: f64,
    /// Attempts that got far enough.
    pub successes: usize,
    /// Attempts.
    pub trials: usize,
}

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

/// Time that a change of gait is recorded before the command changes and after, in s.
const AROUND_S: f64 = 10.0;
/// The part of a motion that is followed at the integration step, in s.
const TRACED_S: [f64; 2] = [15.0, 19.0];
/// Where the first step in the ground is tried, how far apart the places are, how far beyond it the body must get, and how far
/// apart the steps of a row are, in m.
const STEP_AT_M: f64 = 5.0;
const STEP_APART_M: f64 = 0.05;
const BEYOND_STEP_M: f64 = 4.0;
const ROW_APART_M: f64 = 0.5;
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
        let p = subject.body.parameters();
        let weight_n = p.total_mass_kg() * p.gravity_m_per_s2;
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
        let near = |row: &&Steady| (row.omega_v - omega_v).abs() < 1e-9;
        self.steady.iter().find(near).map(|row| &row.summary)
    }
}

/// From the first command to the last in steps; both ends included.
pub(crate) fn commands([from, to, step]: [f64; 3]) -> Vec<f64> {
    let count = ((to - from) / step + 1e-6).floor().max(0.0) as usize;
    // Products of steps such as 0.05 have a long tail of digits.
    let tidy = |value: f64| (value * 1e9).round() / 1e9 + 0.0;
    (0..=count).map(|k| tidy(from + k as f64 * step)).collect()
}

fn record(
    subject: &mut Subject,
    profile: &CommandProfile,
    duration_s: f64,
    seed: Option<u64>,
) -> Result<Recording, ReportError> {
    let Subject {
        controller,
        body,
        name,
        ..
    } = subject;
    let recording = Rollout {
        body,
        task: &controller.task,
        start: Environment::start(body, &controller.task, seed),
        profile,
        duration_s,
        seed: seed.unwrap_or(0),
        disturbance: None,
        controller: name,
    }
    .record(&mut Deterministic(&mut controller.policy))?;
    Ok(recording)
}

fn steady_motion(
    subject: &mut Subject,
    omega_v: f64,
    duration_s: f64,
) -> Result<Steady, ReportError> {
    let recording = record(
        subject,
        &CommandProfile::constant(omega_v),
        duration_s,
        None,
    )?;
    Ok(described(omega_v, &recording, &AnalysisOptions::default()))
}

fn described(omega_v: f64, recording: &Recording, options: &AnalysisOptions) -> Steady {
    let summary = summarise(recording, options);
    let window = summary
        .window_start_s
        .zip(summary.window_end_s)
        .and_then(|(from, to)| recording.window(from, to));
    Steady {
        omega_v,
        energy_change_j: window.and_then(|window| energy_change_j(recording, window)),
        summary,
    }
}

/// Mean |ΔE| of (2) over the periods of a window, in J.
fn energy_change_j(recording: &Recording, window: Window) -> Option<f64> {
    let total = |row: usize| -> f64 {
        [
            column::KINETIC_ENERGY_J,
            column::GRAVITATIONAL_ENERGY_J,
            column::ELASTIC_ENERGY_J,
        ]
        .iter()
        .map(|&column| recording.column(column)[row])
        .sum()
    };
    let changes: Vec<f64> = (window.start_row()..window.end_row())
        .map(|row| (total(row + 1) - total(row)).abs())
        .collect();
    gaitshift_analysis::statistics::mean(&changes)
}

/// The change from one command to another, begun at several phases of the stride. A motion that does not last has no phases from
/// which to change.
fn changes_by_phase(
    subject: &mut Subject,
    plan: &Plan,
    [from, to]: [f64; 2],
) -> Result<Vec<Change>, ReportError> {
    let steady = steady_motion(subject, from, 2.0 * AROUND_S)?.summary;
    if steady.fell {
        return Ok(Vec::new());
    }
    let stride_s = steady.step_frequency_hz.map_or(1.0, |f| 2.0 / f);
    (0..plan.phases)
        .map(|phase| {
            let start_s = AROUND_S + stride_s * phase as f64 / plan.phases as f64;
            let end_s = start_s + plan.ramp_s;
            let profile = CommandProfile::ramp(from, to, start_s, plan.ramp_s);
            let recording = record(subject, &profile, end_s + AROUND_S, None)?;
            let options = TransitionOptions::default();
            let summary = summarise_transition(&recording, start_s, end_s, &options);
            Ok(Change::of(&summary))
        })
        .collect()
}

/// The motions of the tables with another integration step.
fn fine_steps(subject: &mut Subject, plan: &Plan) -> Result<Vec<Steady>, ReportError> {
    let parameters = BodyParameters {
        time_step_s: plan.fine_step_s,
        ..subject.body.parameters().clone()
    };
    let body = Body::new(parameters)
        .map_err(|cause| ReportError::Subject(format!("{}: {cause}", subject.name)))?;
    let usual = std::mem::replace(&mut subject.body, body);
    let rows = commands([0.0, 3.5, 0.5])
        .into_iter()
        .map(|omega_v| steady_motion(subject, omega_v, 20.0))
        .collect();
    subject.body = usual;
    rows
}

/// One motion whose command climbs stairs and comes down again.
fn stairs(subject: &mut Subject, plan: &Plan) -> Result<(Vec<Steady>, Vec<Steady>), ReportError> {
    let [top, step, hold_s] = plan.stairs;
    let mut up = commands([0.0, top, step]);
    let first = up.first().copied().unwrap_or_default();
    let Subject {
        controller, body, ..
    } = subject;
    let task = controller.task.clone();
    let start = Environment::default_start(body, &task);
    let mut simulation = Simulation::new(body, &task, start, first);
    simulation.record_details();
    let options = AnalysisOptions {
        settling_time_s: 0.4 * hold_s,
        ..AnalysisOptions::default()
    };
    let mut stair = |omega_v: f64| -> Result<Option<Steady>, ReportError> {
        let mut recording = Recording::new(simulation.metadata("", 0));
        let mut row = Vec::new();
        for _ in 0..(hold_s / simulation.control_period_s()).round() as u64 {
            if simulation
                .step(omega_v, None, &mut Deterministic(&mut controller.policy))
                .is_some()
            {
                return Ok(None);
            }
            simulation.detailed_row(&mut row);
            recording.push_row(&row)?;
        }
        Ok(Some(described(omega_v, &recording, &options)))
    };
    let mut climb = |commands: &[f64]| -> Result<Vec<Steady>, ReportError> {
        let mut rows = Vec::new();
        for &omega_v in commands {
            match stair(omega_v)? {
                Some(row) => rows.push(row),
                None => break,
            }
        }
        Ok(rows)
    };
    let risen = climb(&up)?;
    if risen.len() < up.len() {
        return Ok((risen, Vec::new()));
    }
    up.reverse();
    let fallen = climb(&up)?;
    Ok((risen, fallen))
}

fn random_starts(subject: &mut Subject, plan: &Plan) -> Result<Vec<StartedMotion>, ReportError> {
    let mut motions = Vec::new();
    for omega_v in commands([0.0, plan.stairs[0], plan.starts_step]) {
        for seed in 1..=plan.starts {
            let profile = CommandProfile::constant(omega_v);
            let recording = record(subject, &profile, 20.0, Some(seed))?;
            let options = AnalysisOptions {
                settling_time_s: 10.0,
                ..AnalysisOptions::default()
            };
            let summary = summarise(&recording, &options);
            motions.push(StartedMotion {
                omega_v,
                seed,
                gait: summary.gait,
                speed_m_per_s: summary.speed_m_per_s,
                duty_factor: summary.duty_factor_right,
            });
        }
    }
    Ok(motions)
}

/// The gait of each part of a walk, run and walk, the settling after each ramp left out.
fn gaits_of_round_trip(recording: &Recording) -> Vec<GaitClass> {
    if recording.metadata.fell {
        return Vec::new();
    }
    [0.0, AROUND_S, 2.0 * AROUND_S]
        .iter()
        .filter_map(|&from_s| gait_between(recording, from_s + 0.5 * AROUND_S, from_s + AROUND_S))
        .collect()
}

/// What a stretch of a recording is.
fn gait_between(recording: &Recording, from_s: f64, to_s: f64) -> Option<GaitClass> {
    let part = recording.part(recording.window(from_s, to_s)?);
    let options = AnalysisOptions {
        settling_time_s: 0.0,
        ..AnalysisOptions::default()
    };
    Some(summarise(&part, &options).gait)
}

/// Steps of growing height until one is not passed at a single place; by turns, each is followed by one that leads back.
fn steps_in_the_ground(
    subject: &mut Subject,
    plan: &Plan,
    omega_v: f64,
    sign: f64,
    by_turns: bool,
) -> Vec<StepHeight> {
    let count = if by_turns {
        (BEYOND_STEP_M / ROW_APART_M) as usize
    } else {
        1
    };
    let mut rows = Vec::new();
    for height_m in commands(plan.step_heights_m) {
        let passed = (0..plan.trials).filter(|&k| {
            let at_m = STEP_AT_M + STEP_APART_M * k as f64;
            let mut disturbance = Disturbance::default();
            disturbance.terrain.steps = (0..count)
                .map(|n| TerrainStep {
                    height_m: if n % 2 == 0 { sign } else { -sign } * height_m,
                    at_m: at_m + ROW_APART_M * n as f64,
                })
                .collect();
            gets_to(subject, &disturbance, omega_v, at_m + BEYOND_STEP_M, 1)
        });
        let successes = passed.count();
        rows.push(StepHeight {
            omega_v,
            height_m: sign * height_m,
            by_turns,
            successes,
            trials: plan.trials as usize,
        });
        if successes == 0 {
            break;
        }
    }
    rows
}

/// Noise on one observation after the other, of growing size until none gets far enough.
fn noise_tolerance(
    subject: &mut Subject,
    plan: &Plan,
    omega_v: f64,
    way_m: f64,
    undisturbed: &Recording,
) -> Vec<NoiseTolerance> {
    let mut rows = Vec::new();
    for observation in SensorNoise::NAMES {
        let Some(own) = own_deviation(undisturbed, observation) else {
            continue;
        };
        for &level in &plan.noise_levels {
            let deviation = level * own;
            let mut disturbance = Disturbance::default();
            if let Some(noise) = disturbance.noise.named_mut(observation) {
                *noise = deviation;
            }
            let successes = (1..=plan.trials)
                .filter(|&seed| gets_to(subject, &disturbance, omega_v, way_m, seed))
                .count();
            rows.push(NoiseTolerance {
                omega_v,
                observation,
                level,
                deviation,
                successes,
                trials: plan.trials as usize,
            });
            if successes == 0 {
                break;
            }
        }
    }
    rows
}

/// Standard deviation of an observation over a recording from its sixth second on; of one with legs, the right leg's.
fn own_deviation(recording: &Recording, observation: &str) -> Option<f64> {
    use gaitshift_analysis::recording::Column;
    let right = format!("right_{observation}");
    let column = Column::named(observation).or_else(|| Column::named(&right))?;
    let from = recording
        .column(column::TIME_S)
        .partition_point(|&time_s| time_s < 5.0);
    gaitshift_analysis::statistics::standard_deviation(&recording.column(column)[from..])
}

/// Whether the body gets to a place under a disturbance, in 60 s and without a fall. The start is the default one.
fn gets_to(
    subject: &mut Subject,
    disturbance: &Disturbance,
    omega_v: f64,
    goal_m: f64,
    seed: u64,
) -> bool {
    let Subject {
        controller, body, ..
    } = subject;
    let task = controller.task.clone();
    let body = disturbance.place(body.clone());
    let start = Environment::default_start(&body, &task);
    let mut simulation = Simulation::new(&body, &task, start, omega_v);
    simulation.disturb(disturbance, seed);
    let mut policy = Deterministic(&mut controller.policy);
    while simulation.time_s() < 60.0 {
        if simulation.step(omega_v, None, &mut policy).is_some() {
            return false;
        }
        if simulation.state().x >= goal_m {
            return true;
        }
    }
    false
}
