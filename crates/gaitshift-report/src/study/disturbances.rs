//! What a motion bears: steps in the ground, noise on what the controller observes.

use super::plan::{Plan, commands};
use crate::Subject;
use gaitshift_analysis::recording::{Column, Recording, column};
use gaitshift_analysis::statistics::standard_deviation;
use gaitshift_experiment::{Deterministic, Simulation};
use gaitshift_task::{Disturbance, Environment, SensorNoise, TerrainStep};
use serde::{Deserialize, Serialize};

/// Where the first step in the ground is tried, how far apart the places are, how far beyond it the body must get, and how far
/// apart the steps of a row are, in m.
const STEP_AT_M: f64 = 5.0;
const STEP_APART_M: f64 = 0.05;
const BEYOND_STEP_M: f64 = 4.0;
const ROW_APART_M: f64 = 0.5;

/// Attempts at a step in the ground, or at a row of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NoiseTolerance {
    /// The command.
    pub omega_v: f64,
    /// Name of the observation; one with legs has noise on both.
    pub observation: String,
    /// Standard deviation of the noise over that of the observation itself in the undisturbed motion.
    pub level: f64,
    /// Standard deviation of the noise, in the observation's unit.
    pub deviation: f64,
    /// Attempts that got far enough.
    pub successes: usize,
    /// Attempts.
    pub trials: usize,
}

/// Steps of growing height until one is not passed at a single place; by turns, each is followed by one that leads back.
pub(super) fn steps_in_the_ground(
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
pub(super) fn noise_tolerance(
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
                observation: observation.to_owned(),
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
    let right = format!("right_{observation}");
    let column = Column::named(observation).or_else(|| Column::named(&right))?;
    let from = recording
        .column(column::TIME_S)
        .partition_point(|&time_s| time_s < 5.0);
    standard_deviation(&recording.column(column)[from..])
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
