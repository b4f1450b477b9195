//! What the controller did before it was hardened: its answers in the states that it meets undisturbed and weakly disturbed, which it
//! is to keep.

use super::case::Pairs;
use crate::controller::{Controller, Deterministic};
use crate::simulation::{Control, Simulation};
use gaitshift_body::Body;
use gaitshift_sac::Policy;
use gaitshift_task::{
    ACTION_SIZE, Disturbance, Environment, OBSERVATION_SIZE, Push, SensorNoise, TerrainStep,
};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

/// Duration of a motion, in s, and what is forgotten before a fall.
const DURATION_S: f64 = 10.0;
const BEFORE_FALL_S: f64 = 1.0;
/// Commands; a third of the motions has those around 0, where the gaits differ most.
const OMEGA_V: [f64; 2] = [-0.5, 3.5];
const AROUND_0: [f64; 2] = [-0.1, 0.2];
/// Changes of command, from above the middle down and from below it up.
const CHANGED: [f64; 2] = [0.0, 3.0];
const MIDDLE: f64 = 1.5;
/// Most noise on the commands.
const NOISE: f64 = 0.25;
/// Greatest impulse of the two pushes of every second motion, in any direction.
const IMPULSE_N_S: f64 = 20.0;
/// What else disturbs it: as in the recipe `robust`, but with up to so many times its sensor noise.
const SENSORS_TIMES: f64 = 10.0;
const LATENCY_S: f64 = 0.02;
const PUSH_S: f64 = 0.1;
const SLOPE_RAD: f64 = 0.06;
const STEP_M: f64 = 0.03;
const SENSORS: SensorNoise = SensorNoise {
    x_velocity_m_per_s: 0.05,
    theta_rad: 0.01,
    theta_velocity_rad_per_s: 0.05,
    h_m: 0.002,
    h_velocity_m_per_s: 0.05,
    phi_rad: 0.01,
    phi_velocity_rad_per_s: 0.05,
    d_velocity_m_per_s: 0.05,
};

/// A motion, and what was to be done in it.
pub(super) struct Motion {
    pub pairs: Pairs,
    pub fell: bool,
}

/// Whether the `index`-th motion is disturbed.
pub(super) fn is_disturbed(index: usize) -> bool {
    index.is_multiple_of(2)
}

/// The `index`-th motion of `policy`, with the answers of `controller` along it.
pub(super) fn motion(
    controller: &Controller,
    policy: &Policy,
    body: &Body,
    index: usize,
    seed: u64,
) -> Motion {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut between = |[from, to]: [f64; 2]| from + (to - from) * rng.random::<f64>();
    let mut omega_v = between(if index.is_multiple_of(3) {
        AROUND_0
    } else {
        OMEGA_V
    });
    let changed_s = index
        .is_multiple_of(5)
        .then(|| between([0.4 * DURATION_S, 0.8 * DURATION_S]));
    let mut disturbance = Disturbance::default();
    let mut noise = 0.0;
    if is_disturbed(index) {
        disturbance.noise = SENSORS.times(between([0.0, SENSORS_TIMES]));
        if index.is_multiple_of(4) {
            disturbance.latency_s = between([0.0, LATENCY_S]);
        }
        disturbance.terrain.slope_rad = between([-SLOPE_RAD, SLOPE_RAD]);
        for step in 0..3 {
            disturbance.terrain.steps.push(TerrainStep {
                height_m: between([-STEP_M, STEP_M]),
                at_m: 2.0 + 3.0 * (f64::from(step) + between([0.0, 1.0])),
            });
        }
        for pushed in [[0.2, 0.5], [0.5, 0.8]] {
            let force_n = between([0.0, IMPULSE_N_S]) / PUSH_S;
            let (up, forward) = between([0.0, TAU]).sin_cos();
            disturbance.pushes.push(Push {
                forward_n: force_n * forward,
                up_n: force_n * up,
                start_s: DURATION_S * between(pushed),
                duration_s: PUSH_S,
                ..Push::default()
            });
        }
    } else if index % 4 == 1 {
        noise = between([0.0, NOISE]);
    }
    let body = disturbance.place(body.clone());
    let start = Environment::random_start(&body, &controller.task, &mut rng);
    let mut simulation = Simulation::new(&body, &controller.task, start, omega_v);
    simulation.disturb(&disturbance, seed);
    let mut pairs = Pairs::default();
    let mut answered = Answered {
        actor: policy.clone(),
        teacher: controller.policy.clone(),
        noise,
        rng,
        pairs: &mut pairs,
    };
    let mut fell = false;
    let mut changed_s = changed_s;
    while simulation.time_s() < DURATION_S && !fell {
        if changed_s.is_some_and(|at_s| simulation.time_s() >= at_s) {
            changed_s = None;
            omega_v = CHANGED[usize::from(omega_v < MIDDLE)];
        }
        fell = simulation.step(omega_v, None, &mut answered).is_some();
    }
    if fell {
        let before = (BEFORE_FALL_S / simulation.control_period_s()).round() as usize;
        let rows = pairs.rows();
        pairs.truncate(rows.saturating_sub(before));
    }
    Motion { pairs, fell }
}

/// Acts with noise, and remembers what the teacher would have done.
struct Answered<'a> {
    actor: Policy,
    teacher: Policy,
    noise: f64,
    rng: Xoshiro256PlusPlus,
    pairs: &'a mut Pairs,
}

impl Control for Answered<'_> {
    fn act(&mut self, observation: &[f32; OBSERVATION_SIZE], action: &mut [f32; ACTION_SIZE]) {
        Deterministic(&mut self.teacher).act(observation, action);
        self.pairs.push(observation, action);
        Deterministic(&mut self.actor).act(observation, action);
        for command in action {
            let normal: f64 = StandardNormal.sample(&mut self.rng);
            *command = (f64::from(*command) + self.noise * normal).clamp(-1.0, 1.0) as f32;
        }
    }
}
