//! Can a push be survived at all? For pushes that a controller does not bear, a search with full knowledge of what comes:
//! offsets to the controller's commands over the next two seconds, found by the cross-entropy method, after which the
//! controller goes on alone.
//!
//! What is found can be done by the body's motors, so a controller could learn it. What is not found may still be
//! possible. A push is a force on the hip for 0.1 s, at eight phases of the stride, as in `gaitshift stress`, and counts
//! as borne if the body is up 8 s after it.
//!
//! `cargo run --release -p gaitshift-experiment --example survivable_push -- [CONTROLLER [IMPULSE_N_S [OMEGA_V...]]]`, by
//! default `robust`, 30 N s forward (less than 0: backward), at 0, 1, 2 and 3; one line of JSON per command and phase.

use gaitshift_body::{Body, RIGHT};
use gaitshift_experiment::{Control, Controller, Deterministic, Simulation};
use gaitshift_task::{ACTION_SIZE, Environment, OBSERVATION_SIZE};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

const PHASES: usize = 8;
const SETTLING_S: f64 = 8.0;
const PUSH_S: f64 = 0.1;
const AFTER_S: f64 = 8.0;
/// The offsets: straight lines between this many knots, this far apart.
const KNOTS: usize = 20;
const KNOT_S: f64 = 0.1;
/// The search: samples of a generation, those that the next is drawn around, generations, and the first deviation.
const SAMPLES: usize = 192;
const ELITE: usize = 16;
const GENERATIONS: usize = 50;
const DEVIATION: f64 = 0.6;

type Offsets = [[f64; ACTION_SIZE]; KNOTS];

/// The controller's commands and the offsets to them.
struct Planned<'a> {
    controller: Deterministic<'a>,
    offsets: &'a Offsets,
    time_s: f64,
    period_s: f64,
}

impl Control for Planned<'_> {
    fn act(&mut self, observation: &[f32; OBSERVATION_SIZE], action: &mut [f32; ACTION_SIZE]) {
        self.controller.act(observation, action);
        let place = self.time_s / KNOT_S;
        let (knot, share) = (place as usize, place.fract());
        if knot + 1 < KNOTS {
            for (i, command) in action.iter_mut().enumerate() {
                let offset =
                    self.offsets[knot][i] * (1.0 - share) + self.offsets[knot + 1][i] * share;
                *command = (f64::from(*command) + offset).clamp(-1.0, 1.0) as f32;
            }
        }
        self.time_s += self.period_s;
    }
}

/// Time for which the body stays up, in s, at most until [`AFTER_S`] after the push.
fn upright_s(
    settled: &Simulation,
    controller: &mut Controller,
    omega_v: f64,
    impulse_n_s: f64,
    offsets: &Offsets,
) -> f64 {
    let mut simulation = settled.clone();
    let begin_s = simulation.time_s();
    let period_s = simulation.control_period_s();
    let mut planned = Planned {
        controller: Deterministic(&mut controller.policy),
        offsets,
        time_s: 0.0,
        period_s,
    };
    let periods = ((PUSH_S + AFTER_S) / period_s).round() as usize;
    let pushed = (PUSH_S / period_s).round() as usize;
    for k in 0..periods {
        let push = (k < pushed).then_some([impulse_n_s / PUSH_S, 0.0]);
        if simulation.step(omega_v, push, &mut planned).is_some() {
            break;
        }
    }
    simulation.time_s() - begin_s
}

fn normal(rng: &mut Xoshiro256PlusPlus) -> f64 {
    let (a, b): (f64, f64) = (rng.random(), rng.random());
    (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}

/// The states of the settled motion at which pushes begin: phases of the first whole stride after settling.
fn states(controller: &mut Controller, body: &Body, omega_v: f64) -> Option<Vec<Simulation>> {
    let start = Environment::start(body, &controller.task, Some(1));
    let mut simulation = Simulation::new(body, &controller.task, start, omega_v);
    let mut policy = Deterministic(&mut controller.policy);
    let mut course = Vec::new();
    let mut touchdowns = Vec::new();
    // Control periods since the right foot last bore weight.
    let mut lifted = 0;
    while touchdowns.len() < 2 {
        if simulation.time_s() > SETTLING_S {
            let bears = simulation
                .body()
                .foot_contact(simulation.state(), RIGHT)
                .normal_n
                > 0.0;
            if bears && lifted > 5 {
                touchdowns.push(course.len());
            }
            lifted = if bears { 0 } else { lifted + 1 };
            course.push(simulation.clone());
        }
        if simulation.time_s() > 2.0 * SETTLING_S
            || simulation.step(omega_v, None, &mut policy).is_some()
        {
            return None;
        }
    }
    let (from, to) = (touchdowns[0], touchdowns[1]);
    let at = |k: usize| course[from + k * (to - from) / PHASES].clone();
    Some((0..PHASES).map(at).collect())
}

fn line(
    controller: &mut Controller,
    settled: &Simulation,
    omega_v: f64,
    phase: usize,
    impulse_n_s: f64,
) -> serde_json::Value {
    let whole_s = PUSH_S + AFTER_S - 0.5 * settled.control_period_s();
    let mut mean: Offsets = [[0.0; ACTION_SIZE]; KNOTS];
    let mut deviation = [[DEVIATION; ACTION_SIZE]; KNOTS];
    let alone_s = upright_s(settled, controller, omega_v, impulse_n_s, &mean);
    let (mut best_s, mut tried) = (alone_s, 0);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(phase as u64);
    'search: for _ in 0..GENERATIONS {
        if best_s >= whole_s {
            break;
        }
        let mut generation: Vec<(f64, Offsets)> = Vec::with_capacity(SAMPLES);
        for _ in 0..SAMPLES {
            let mut offsets = mean;
            for (knot, spread) in offsets.iter_mut().zip(&deviation) {
                for (offset, spread) in knot.iter_mut().zip(spread) {
                    *offset += spread * normal(&mut rng);
                }
            }
            let time_s = upright_s(settled, controller, omega_v, impulse_n_s, &offsets);
            tried += 1;
            best_s = best_s.max(time_s);
            if time_s >= whole_s {
                break 'search;
            }
            generation.push((time_s, offsets));
        }
        generation.sort_by(|a, b| b.0.total_cmp(&a.0));
        generation.truncate(ELITE);
        for k in 0..KNOTS {
            for i in 0..ACTION_SIZE {
                let values = generation.iter().map(|(_, offsets)| offsets[k][i]);
                let middle = values.clone().sum::<f64>() / ELITE as f64;
                let square = values.map(|v| (v - middle).powi(2)).sum::<f64>() / ELITE as f64;
                // Half of the way, and never without spread: the search should not settle early.
                mean[k][i] += 0.5 * (middle - mean[k][i]);
                deviation[k][i] += 0.5 * (square.sqrt().max(0.1) - deviation[k][i]);
            }
        }
    }
    serde_json::json!({
        "omega_v": omega_v,
        "phase": phase as f64 / PHASES as f64,
        "impulse_n_s": impulse_n_s,
        "controller_alone_s": alone_s,
        "controller_bears": alone_s >= whole_s,
        "found": best_s >= whole_s,
        "best_s": best_s,
        "tried": tried,
    })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or_else(|| "robust".to_owned());
    let mut controller = Controller::read(Path::new(&name))?;
    let impulse_n_s: f64 = arguments.next().map_or(Ok(30.0), |text| text.parse())?;
    let mut commands: Vec<f64> = arguments
        .map(|text| text.parse())
        .collect::<Result<_, _>>()?;
    if commands.is_empty() {
        commands = vec![0.0, 1.0, 2.0, 3.0];
    }
    let body = Body::new(controller.body.clone())?;
    let mut questions = Vec::new();
    for &omega_v in &commands {
        let states = states(&mut controller, &body, omega_v)
            .ok_or_else(|| format!("at ω_v = {omega_v} it takes no strides"))?;
        questions.extend(
            (0..)
                .zip(states)
                .map(|(phase, state)| (omega_v, phase, state)),
        );
    }
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        for _ in 0..threads {
            scope.spawn(|| {
                let mut controller = controller.clone();
                while let Some((omega_v, phase, state)) =
                    questions.get(next.fetch_add(1, Ordering::Relaxed))
                {
                    let found = line(&mut controller, state, *omega_v, *phase, impulse_n_s);
                    println!("{found}");
                }
            });
        }
    });
    Ok(())
}
