//! How much a controller bears: the largest push by phase of the stride and direction, steps, slopes, noise, latency.
//!
//! Every limit is sought from several starts, each settled into its motion under one command first. Sizes grow by a factor
//! until one is not borne; between it and the last that was, bisection follows. A limit is thus the largest size below
//! which nothing that was tried brought the body down: what it bears need not be less of the same, for a greater push
//! can throw it into a stance that a lesser one does not. Nothing is random but the starts and the noise, which their seeds
//! draw, so that the same plan gives the same limits on any number of threads.

use crate::controller::{Controller, Deterministic};
use crate::parallel::in_parallel;
use crate::rollout::strides;
use crate::simulation::Simulation;
use gaitshift_analysis::recording::{Recording, RowError};
use gaitshift_analysis::statistics::median;
use gaitshift_body::Body;
use gaitshift_task::{
    Disturbance, EndReason, Environment, OBSERVATION_NAMES, OBSERVATION_SCALE, Push, SensorNoise,
    TerrainParameters, TerrainStep,
};
use serde::{Serialize, Serializer};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Duration of a push, in s.
const PUSH_S: f64 = 0.1;
/// Where the terrain begins before the hip, in m, over what way more the faces of steps are spread, and how far beyond the body
/// has to get. Where in the stride a foot meets a face decides as much as its height.
const AHEAD_M: f64 = 1.0;
const FACES_M: f64 = 0.5;
const STEP_BEYOND_M: f64 = 3.0;
const SLOPE_BEYOND_M: f64 = 5.0;
/// Time that it has for this, in s.
const TERRAIN_S: f64 = 30.0;
/// The greatest size tried, in first sizes.
const GREATEST: f64 = 128.0;
/// Time recorded of a settled motion to find its stride, in s.
const STRIDE_S: f64 = 4.0;

/// A kind of disturbance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StressKind {
    /// On the hip, for 0.1 s.
    Push,
    /// In the ground.
    Step,
    /// Of the ground.
    Slope,
    /// Of one observation.
    Noise,
    /// Of all observations.
    Latency,
}

impl StressKind {
    /// All of them, in the order of the table.
    pub const ALL: [Self; 5] = [
        Self::Push,
        Self::Step,
        Self::Slope,
        Self::Noise,
        Self::Latency,
    ];

    /// What it is called in tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Push => "push",
            Self::Step => "step",
            Self::Slope => "slope",
            Self::Noise => "noise",
            Self::Latency => "latency",
        }
    }
}

impl Serialize for StressKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// What is tried, and how carefully.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StressPlan {
    /// What is tried; in the order of [`StressKind::ALL`], whatever the order here.
    pub kinds: Vec<StressKind>,
    /// Commands.
    pub omega_v: Vec<f64>,
    /// Seeds that draw the starts.
    pub seeds: Vec<u64>,
    /// Phases of the stride at which pushes begin, and as many places of a step's face: a step is borne that is borne at
    /// each of them.
    pub phases: usize,
    /// Whether pushes up and down are tried too.
    pub vertical_pushes: bool,
    /// Factor from one size to the next; greater than 1.
    pub ratio: f64,
    /// Bisections of each limit after that.
    pub bisections: u32,
    /// Time under the command before anything disturbs, in s.
    pub settling_s: f64,
    /// Time for which the body has to stay up after a push, and under noise or latency, in s.
    pub after_s: f64,
}

impl Default for StressPlan {
    fn default() -> Self {
        Self {
            kinds: StressKind::ALL.to_vec(),
            omega_v: vec![0.0, 1.0, 2.0, 3.0],
            seeds: (1..=8).collect(),
            phases: 8,
            vertical_pushes: true,
            ratio: 1.25,
            bisections: 2,
            settling_s: 8.0,
            after_s: 8.0,
        }
    }
}

impl StressPlan {
    /// A first look: fewer starts, phases and directions, coarser limits.
    pub fn quick() -> Self {
        Self {
            kinds: StressKind::ALL.to_vec(),
            omega_v: vec![0.0, 3.0],
            seeds: (1..=3).collect(),
            phases: 4,
            vertical_pushes: false,
            ratio: 1.6,
            bisections: 2,
            settling_s: 6.0,
            after_s: 5.0,
        }
    }

    /// The questions, in the order of the table.
    fn questions(&self) -> Vec<Question> {
        let mut questions = Vec::new();
        let directions = [
            ("forward", [1.0, 0.0]),
            ("backward", [-1.0, 0.0]),
            ("up", [0.0, 1.0]),
            ("down", [0.0, -1.0]),
        ];
        let tried = if self.vertical_pushes { 4 } else { 2 };
        for (name, direction) in directions.into_iter().take(tried) {
            for phase in 0..self.phases {
                let phase = phase as f64 / self.phases as f64;
                questions.push(Question::new(name, Ask::Push { direction, phase }));
            }
        }
        for (name, sign) in [("up", 1.0), ("down", -1.0)] {
            questions.push(Question::new(name, Ask::Step { sign }));
        }
        for (name, sign) in [("up", 1.0), ("down", -1.0)] {
            questions.push(Question::new(name, Ask::Slope { sign }));
        }
        for name in SensorNoise::NAMES {
            questions.push(Question::new(name, Ask::Noise { name }));
        }
        questions.push(Question::new("", Ask::Latency));
        questions.retain(|question| self.kinds.contains(&question.kind()));
        questions
    }
}

/// Something to find the limit of.
#[derive(Debug, Clone, Copy)]
struct Question {
    which: &'static str,
    ask: Ask,
}

#[derive(Debug, Clone, Copy)]
enum Ask {
    Push { direction: [f64; 2], phase: f64 },
    Step { sign: f64 },
    Slope { sign: f64 },
    Noise { name: &'static str },
    Latency,
}

impl Question {
    fn new(which: &'static str, ask: Ask) -> Self {
        Self { which, ask }
    }

    fn kind(&self) -> StressKind {
        match self.ask {
            Ask::Push { .. } => StressKind::Push,
            Ask::Step { .. } => StressKind::Step,
            Ask::Slope { .. } => StressKind::Slope,
            Ask::Noise { .. } => StressKind::Noise,
            Ask::Latency => StressKind::Latency,
        }
    }

    fn unit(&self) -> &'static str {
        match self.ask {
            Ask::Push { .. } => "N s",
            Ask::Step { .. } => "m",
            Ask::Slope { .. } => "rad",
            Ask::Noise { name } => match name {
                _ if name.ends_with("_rad_per_s") => "rad/s",
                _ if name.ends_with("_m_per_s") => "m/s",
                _ if name.ends_with("_rad") => "rad",
                _ => "m",
            },
            Ask::Latency => "s",
        }
    }

    /// The first size tried.
    fn first(&self) -> f64 {
        match self.ask {
            Ask::Push { .. } => 2.0,
            Ask::Step { .. } => 0.002,
            Ask::Slope { .. } => 0.004,
            // What the controller's network takes as a fiftieth.
            Ask::Noise { name } => {
                let index = OBSERVATION_NAMES.iter().position(|n| n.ends_with(name));
                0.02 / f64::from(OBSERVATION_SCALE[index.unwrap_or(0)])
            }
            Ask::Latency => 0.001,
        }
    }

    /// The greatest size tried.
    fn greatest(&self) -> f64 {
        GREATEST * self.first()
    }
}

/// How much one kind of disturbance may be, under one command.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Limit {
    /// The command.
    pub omega_v: f64,
    /// What disturbs.
    pub disturbance: StressKind,
    /// The direction, or the observation; empty where there is only one.
    pub which: &'static str,
    /// Phase of the stride at which pushes begin, 0 at the right foot's touchdown.
    pub phase: Option<f64>,
    /// Unit of the sizes.
    pub unit: &'static str,
    /// The largest size that was borne, for each start in the order of the seeds: 0 if the smallest was not, `None` (null
    /// in JSON) where the body fell undisturbed.
    pub limits: Vec<Option<f64>>,
    /// Least of them.
    pub least: Option<f64>,
    /// Median of them.
    pub median: Option<f64>,
    /// Greatest of them.
    pub greatest: Option<f64>,
    /// The greatest size tried: a limit as large means at least as much.
    pub greatest_tried: f64,
}

/// What a controller bears.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stress {
    /// What was tried.
    pub plan: StressPlan,
    /// Limits, command by command.
    pub limits: Vec<Limit>,
}

/// Finds the limits of a controller on a body, its starts and commands shared out among threads. `progress` is told, from
/// any thread, how many limits of how many have been found.
///
/// # Errors
/// A recording that refuses a row.
pub fn stress(
    controller: &Controller,
    body: &Body,
    plan: &StressPlan,
    threads: usize,
    progress: &(impl Fn(usize, usize) + Sync),
) -> Result<Stress, RowError> {
    let questions = plan.questions();
    let units: Vec<(f64, u64)> = plan
        .omega_v
        .iter()
        .flat_map(|&omega_v| plan.seeds.iter().map(move |&seed| (omega_v, seed)))
        .collect();
    let done = AtomicUsize::new(0);
    let total = units.len() * questions.len();
    let found = in_parallel(threads, units.len(), |index| {
        let (omega_v, seed) = units[index];
        let mut controller = controller.clone();
        let subject = Settled::new(&mut controller, body, plan, omega_v, seed)?;
        let limits = questions.iter().map(|question| {
            let subject = subject.as_ref();
            let limit = subject.map(|s| s.limit(&mut controller, plan, question));
            progress(done.fetch_add(1, Ordering::SeqCst) + 1, total);
            limit
        });
        Ok(limits.collect())
    });
    let found: Vec<Vec<Option<f64>>> = found.into_iter().collect::<Result<_, RowError>>()?;
    let starts = plan.seeds.len();
    let mut limits = Vec::new();
    for (command, &omega_v) in plan.omega_v.iter().enumerate() {
        for (k, question) in questions.iter().enumerate() {
            let of_starts = &found[command * starts..(command + 1) * starts];
            let sizes: Vec<Option<f64>> = of_starts.iter().map(|limits| limits[k]).collect();
            let defined: Vec<f64> = sizes.iter().flatten().copied().collect();
            limits.push(Limit {
                omega_v,
                disturbance: question.kind(),
                which: question.which,
                phase: match question.ask {
                    Ask::Push { phase, .. } => Some(phase),
                    _ => None,
                },
                unit: question.unit(),
                least: defined.iter().copied().reduce(f64::min),
                median: median(&defined),
                greatest: defined.iter().copied().reduce(f64::max),
                greatest_tried: question.greatest(),
                limits: sizes,
            });
        }
    }
    Ok(Stress {
        plan: plan.clone(),
        limits,
    })
}

/// A motion that has settled, to be disturbed from there again and again.
struct Settled {
    simulation: Simulation,
    omega_v: f64,
    seed: u64,
    /// Begin of the next stride, in s from now, and its duration; both 0 where it takes no strides.
    stride: (f64, f64),
}

impl Settled {
    /// `None` if the body falls undisturbed.
    fn new(
        controller: &mut Controller,
        body: &Body,
        plan: &StressPlan,
        omega_v: f64,
        seed: u64,
    ) -> Result<Option<Self>, RowError> {
        let task = &controller.task;
        let start = Environment::start(body, task, Some(seed));
        let mut simulation = Simulation::new(body, task, start, omega_v);
        let mut policy = Deterministic(&mut controller.policy);
        let until = |simulation: &Simulation, time_s: f64| {
            ((time_s - simulation.time_s()) / simulation.control_period_s()).round() as u64
        };
        for _ in 0..until(&simulation, plan.settling_s) {
            if simulation.step(omega_v, None, &mut policy).is_some() {
                return Ok(None);
            }
        }
        let now_s = simulation.time_s();
        let mut ahead = simulation.clone();
        let mut recording = Recording::new(ahead.metadata("", seed));
        let mut row = Vec::new();
        for _ in 0..until(&simulation, now_s + STRIDE_S.max(plan.after_s)) {
            ahead.row(&mut row);
            recording.push_row(&row)?;
            if ahead.step(omega_v, None, &mut policy).is_some() {
                return Ok(None);
            }
        }
        // A contact that the recording begins with has no touchdown there.
        let mut strides = strides(&recording).into_iter();
        let stride = strides.find(|stride| stride.0 > now_s + 0.5 * simulation.control_period_s());
        Ok(Some(Self {
            simulation,
            omega_v,
            seed,
            stride: stride.map_or((0.0, 0.0), |(from_s, to_s)| (from_s - now_s, to_s - from_s)),
        }))
    }

    /// The largest size that it bears.
    fn limit(&self, controller: &mut Controller, plan: &StressPlan, question: &Question) -> f64 {
        let mut borne = 0.0;
        let mut size = question.first();
        let greatest = question.greatest();
        while self.bears(controller, plan, question.ask, size) {
            borne = size;
            if size >= greatest {
                return borne;
            }
            size = (size * plan.ratio).min(greatest);
        }
        let mut too_much = size;
        for _ in 0..plan.bisections {
            let middle = 0.5 * (borne + too_much);
            if self.bears(controller, plan, question.ask, middle) {
                borne = middle;
            } else {
                too_much = middle;
            }
        }
        borne
    }

    fn bears(&self, controller: &mut Controller, plan: &StressPlan, ask: Ask, size: f64) -> bool {
        let places = match ask {
            Ask::Step { .. } => plan.phases.max(1),
            _ => 1,
        };
        let further_m = |place: usize| FACES_M * place as f64 / places as f64;
        (0..places).all(|place| self.bears_at(controller, plan, ask, size, further_m(place)))
    }

    /// Whether it bears it where terrain begins `further_m` beyond the first place.
    fn bears_at(
        &self,
        controller: &mut Controller,
        plan: &StressPlan,
        ask: Ask,
        size: f64,
        further_m: f64,
    ) -> bool {
        let mut simulation = self.simulation.clone();
        let from_m = simulation.state().x + AHEAD_M + further_m;
        let mut disturbance = Disturbance::default();
        let mut duration_s = plan.after_s;
        // Where it has to get, in m.
        let mut goal_m = f64::NEG_INFINITY;
        match ask {
            Ask::Push { direction, phase } => {
                let start_s = self.stride.0 + phase * self.stride.1;
                let [forward_n, up_n] = direction.map(|d| d * size / PUSH_S);
                disturbance.pushes.push(Push {
                    forward_n,
                    up_n,
                    start_s,
                    duration_s: PUSH_S,
                    phase: None,
                });
                duration_s += start_s + PUSH_S;
            }
            Ask::Step { sign } => {
                let step = TerrainStep {
                    height_m: sign * size,
                    at_m: from_m,
                };
                disturbance.terrain.steps.push(step);
                (duration_s, goal_m) = (TERRAIN_S, from_m + STEP_BEYOND_M);
            }
            Ask::Slope { sign } => {
                disturbance.terrain = TerrainParameters {
                    slope_rad: sign * size,
                    slope_from_m: Some(from_m),
                    ..TerrainParameters::default()
                };
                (duration_s, goal_m) = (TERRAIN_S, from_m + SLOPE_BEYOND_M);
            }
            Ask::Noise { name } => {
                if let Some(deviation) = disturbance.noise.named_mut(name) {
                    *deviation = size;
                }
            }
            Ask::Latency => disturbance.latency_s = size,
        }
        let body = disturbance.place(simulation.body().clone());
        if body.terrain().is_some() {
            simulation.change_body(body);
        }
        simulation.disturb(&disturbance, self.seed);
        let mut policy = Deterministic(&mut controller.policy);
        for _ in 0..(duration_s / simulation.control_period_s()).round() as u64 {
            let ended: Option<EndReason> = simulation.step(self.omega_v, None, &mut policy);
            if ended.is_some() {
                return false;
            }
            if goal_m.is_finite() && simulation.state().x >= goal_m {
                return true;
            }
        }
        goal_m == f64::NEG_INFINITY
    }
}
