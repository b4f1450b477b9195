//! Could a push or a step be withstood at all? Where a controller falls, a search with full knowledge of what comes:
//! offsets to the controller's commands over the next two seconds, found by the cross-entropy method, after which the
//! controller goes on alone.
//!
//! What is found the body's motors can do, so that a controller might learn it. What is not found may still be possible.
//! Tried as in `gaitshift stress`, from one start: a push is a force on the hip for 0.1 s, at eight phases of the stride,
//! and is withstood if the body is up 8 s later; a step has its face 0.4 to 0.9 m in front of the hip, at eight places, and is
//! withstood if the body gets 3 m beyond it. With `touched` the offsets begin when a foot first touches the step: a controller
//! that does not see it can do no more.
//!
//! `cargo run --release -p gaitshift-experiment --example survivable -- CONTROLLER push|step|touched SIZE [OMEGA_V...]`, SIZE
//! in N s (forward, less than 0: backward) or m, commands 0, 1, 2 and 3 by default; one line of JSON per command and phase or
//! place.

use gaitshift_body::{Body, RIGHT};
use gaitshift_experiment::{Control, Controller, Deterministic, Simulation};
use gaitshift_task::{ACTION_SIZE, Disturbance, Environment, OBSERVATION_SIZE, TerrainStep};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Phases of the stride, or places of a face.
const TRIALS: usize = 8;
const SETTLING_S: f64 = 8.0;
const PUSH_S: f64 = 0.1;
const AFTER_S: f64 = 8.0;
/// The first place of a face before the hip, the way over which the others are spread, how far beyond it the body has to get,
/// and the time it has for this.
const AHEAD_M: f64 = 0.4;
const FACES_M: f64 = 0.5;
const BEYOND_M: f64 = 3.0;
const STEP_S: f64 = 30.0;
/// Out of reach of any motion here.
const FAR_M: f64 = 1000.0;
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

/// A motion that is about to be disturbed.
struct Trial {
    settled: Simulation,
    omega_v: f64,
    index: usize,
    /// Impulse of the push, 0 before a step.
    impulse_n_s: f64,
    /// Where the hip has to get.
    goal_m: Option<f64>,
}

impl Trial {
    /// How far it gets, and whether it gets there: the time for which it is up, in s, or the way of the hip, in m.
    fn outcome(&self, controller: &mut Controller, offsets: &Offsets) -> (f64, bool) {
        let mut simulation = self.settled.clone();
        let (begin_s, begin_m) = (simulation.time_s(), simulation.state().x);
        let period_s = simulation.control_period_s();
        let mut planned = Planned {
            controller: Deterministic(&mut controller.policy),
            offsets,
            time_s: 0.0,
            period_s,
        };
        let duration_s = self.goal_m.map_or(PUSH_S + AFTER_S, |_| STEP_S);
        let pushed = (PUSH_S / period_s).round() as usize;
        let mut up = true;
        for k in 0..(duration_s / period_s).round() as usize {
            let push =
                (self.goal_m.is_none() && k < pushed).then_some([self.impulse_n_s / PUSH_S, 0.0]);
            if simulation.step(self.omega_v, push, &mut planned).is_some() {
                up = false;
                break;
            }
            if self
                .goal_m
                .is_some_and(|goal_m| simulation.state().x >= goal_m)
            {
                break;
            }
        }
        match self.goal_m {
            None => (simulation.time_s() - begin_s, up),
            Some(goal_m) => (
                simulation.state().x - begin_m,
                up && simulation.state().x >= goal_m,
            ),
        }
    }

    /// The search, as a line of the output.
    fn line(&self, controller: &mut Controller) -> serde_json::Value {
        let mut mean: Offsets = [[0.0; ACTION_SIZE]; KNOTS];
        let mut deviation = [[DEVIATION; ACTION_SIZE]; KNOTS];
        let (alone, withstands) = self.outcome(controller, &mean);
        let (mut best, mut found, mut tried) = (alone, withstands, 0);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(self.index as u64);
        'search: for _ in 0..GENERATIONS {
            if found {
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
                let (reached, there) = self.outcome(controller, &offsets);
                tried += 1;
                best = best.max(reached);
                if there {
                    found = true;
                    break 'search;
                }
                generation.push((reached, offsets));
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
            "omega_v": self.omega_v,
            "trial": self.index,
            "controller_withstands": withstands,
            "found": found,
            "controller_reaches": alone,
            "best_reaches": best,
            "begins_s": self.settled.time_s(),
            "tried": tried,
        })
    }
}

fn normal(rng: &mut Xoshiro256PlusPlus) -> f64 {
    let (a, b): (f64, f64) = (rng.random(), rng.random());
    (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}

/// The settled motion at equally many moments of its first whole stride after settling; nothing if it takes none.
fn stride(controller: &mut Controller, body: &Body, omega_v: f64) -> Option<Vec<Simulation>> {
    let start = Environment::start(body, &controller.task, Some(1));
    let mut simulation = Simulation::new(body, &controller.task, start, omega_v);
    let mut policy = Deterministic(&mut controller.policy);
    let mut course = Vec::new();
    let mut touchdowns = Vec::new();
    // Control periods since the right foot last bore weight.
    let mut lifted = 0;
    while touchdowns.len() < 2 {
        if simulation.time_s() > SETTLING_S {
            let contact = simulation.body().foot_contact(simulation.state(), RIGHT);
            let bears = contact.normal_n > 0.0;
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
    let at = |k: usize| course[from + k * (to - from) / TRIALS].clone();
    Some((0..TRIALS).map(at).collect())
}

/// The motion after the first control period in which a step changes it, if that comes: the next command is the first that can
/// know. `far` is the same motion with the step out of reach.
fn touched(
    controller: &mut Controller,
    mut simulation: Simulation,
    mut far: Simulation,
    omega_v: f64,
) -> Simulation {
    let mut policy = Deterministic(&mut controller.policy);
    let until_s = simulation.time_s() + STEP_S;
    while simulation.state() == far.state() && simulation.time_s() < until_s {
        let over = simulation.step(omega_v, None, &mut policy).is_some();
        far.step(omega_v, None, &mut policy);
        if over {
            break;
        }
    }
    simulation
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    const USAGE: &str = "usage: survivable CONTROLLER push|step|touched SIZE [OMEGA_V...]";
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, kind, size, commands @ ..] = arguments.as_slice() else {
        return Err(USAGE.into());
    };
    let mut controller = Controller::read(Path::new(name))?;
    let size: f64 = size.parse()?;
    let pushed = match kind.as_str() {
        "push" => true,
        "step" | "touched" => false,
        _ => return Err(USAGE.into()),
    };
    let mut commands: Vec<f64> = commands
        .iter()
        .map(|text| text.parse())
        .collect::<Result<_, _>>()?;
    if commands.is_empty() {
        commands = vec![0.0, 1.0, 2.0, 3.0];
    }
    let body = Body::new(controller.body.clone())?;
    let mut trials = Vec::new();
    for omega_v in commands {
        let stride = stride(&mut controller, &body, omega_v)
            .ok_or_else(|| format!("at ω_v = {omega_v} it takes no strides"))?;
        for index in 0..TRIALS {
            let mut settled = stride[if pushed { index } else { 0 }].clone();
            let mut goal_m = None;
            if !pushed {
                let at_m = settled.state().x + AHEAD_M + FACES_M * index as f64 / TRIALS as f64;
                let stepped = |at_m| {
                    let mut disturbance = Disturbance::default();
                    let height_m = size;
                    disturbance
                        .terrain
                        .steps
                        .push(TerrainStep { height_m, at_m });
                    disturbance.place(body.clone())
                };
                let mut far = settled.clone();
                settled.change_body(stepped(at_m));
                if kind == "touched" {
                    // Not the body on flat ground, which rounds otherwise.
                    far.change_body(stepped(at_m + FAR_M));
                    settled = touched(&mut controller, settled, far, omega_v);
                }
                goal_m = Some(at_m + BEYOND_M);
            }
            trials.push(Trial {
                settled,
                omega_v,
                index,
                impulse_n_s: size,
                goal_m,
            });
        }
    }
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        for _ in 0..threads {
            scope.spawn(|| {
                let mut controller = controller.clone();
                while let Some(trial) = trials.get(next.fetch_add(1, Ordering::Relaxed)) {
                    println!("{}", trial.line(&mut controller));
                }
            });
        }
    });
    Ok(())
}
