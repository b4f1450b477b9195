//! A push or a step on a motion that has settled, and how it goes on under the controller's commands with offsets to them.

use super::HardeningPlan;
use crate::controller::Deterministic;
use crate::simulation::{Control, Simulation};
use gaitshift_body::Body;
use gaitshift_sac::Policy;
use gaitshift_task::{
    ACTION_SIZE, Disturbance, Environment, OBSERVATION_SIZE, TaskParameters, TerrainStep,
};
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Duration of a push, in s.
const PUSH_S: f64 = 0.1;
/// Offsets grow from 0 at the begin of the push, or the first touch of a step: what the controller cannot see yet it can only answer
/// by being sharp, and so fall from noise. They are straight lines between this many knots, this far apart in s, then 0.
pub(super) const KNOTS: usize = 20;
const KNOT_S: f64 = 0.1;
/// A push is withstood by a body that is up so long after its begin, in s, and may be by one that is after the time of a sample:
/// most falls take less.
const UP_S: f64 = 8.0;
const SAMPLE_UP_S: f64 = 4.0;
/// A step is withstood by a body whose hip gets so far beyond its face, in m, within this time from the first touch on, in s, and
/// may be by one that gets as far as a sample has to.
const BEYOND_M: f64 = 3.0;
const BEYOND_S: f64 = 12.0;
const SAMPLE_BEYOND_M: f64 = 1.0;
const SAMPLE_BEYOND_S: f64 = 4.0;
/// The least distance of a step's face before the hip of the settled motion, how much further it may be, and out of reach, in m.
const FACE_AHEAD_M: f64 = 0.4;
const FACES_M: f64 = 1.0;
const OUT_OF_REACH_M: f64 = 1000.0;
/// The most that a fall counts for, of 1.
const NEARLY: f64 = 1.0 - f64::EPSILON;
/// Time in which a step has to be touched, in s.
const TOUCHED_S: f64 = 20.0;
/// Time under the command before the disturbance, in s: this, and up to as much more as covers any phase of a stride.
const SETTLING_S: f64 = 6.0;
const PHASES_S: f64 = 2.0;

/// Offsets to the commands of the right and the left actuator, at each knot.
pub(super) type Offsets = [[f64; ACTION_SIZE]; KNOTS];
/// Leaves the controller alone.
pub(super) const NO_OFFSETS: Offsets = [[0.0; ACTION_SIZE]; KNOTS];

/// Rows of observations and of the actions taken there.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Pairs {
    pub observations: Vec<f32>,
    pub actions: Vec<f32>,
}

impl Pairs {
    pub fn rows(&self) -> usize {
        self.actions.len() / ACTION_SIZE
    }

    pub fn push(&mut self, observation: &[f32; OBSERVATION_SIZE], action: &[f32; ACTION_SIZE]) {
        self.observations.extend_from_slice(observation);
        self.actions.extend_from_slice(action);
    }

    pub fn append(&mut self, other: &Self) {
        self.observations.extend_from_slice(&other.observations);
        self.actions.extend_from_slice(&other.actions);
    }

    pub fn truncate(&mut self, rows: usize) {
        self.observations.truncate(rows * OBSERVATION_SIZE);
        self.actions.truncate(rows * ACTION_SIZE);
    }
}

/// What disturbs a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Push,
    StepUp,
}

/// A motion that is about to be pushed, or that has just touched a step.
#[derive(Debug, Clone)]
pub(super) struct Case {
    settled: Simulation,
    omega_v: f64,
    met: Met,
}

#[derive(Debug, Clone, Copy)]
enum Met {
    /// Forward; less than 0: backward.
    Push { impulse_n_s: f64 },
    /// Where the face is.
    Step { at_m: f64 },
}

/// How thoroughly a case is tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Trial {
    Sample,
    Whole,
}

impl Case {
    /// A case of the plan that `rng` draws; nothing if the body falls undisturbed, or never touches the step.
    pub fn draw(
        kind: Kind,
        plan: &HardeningPlan,
        policy: &mut Policy,
        body: &Body,
        task: &TaskParameters,
        rng: &mut Xoshiro256PlusPlus,
    ) -> Option<Self> {
        let (commands, sizes) = match kind {
            Kind::Push => (&plan.omega_v, &plan.impulse_n_s),
            Kind::StepUp => (&plan.step_omega_v, &plan.step_up_m),
        };
        let omega_v = commands[rng.random_range(0..commands.len())];
        let [from, to] = sizes[rng.random_range(0..sizes.len())];
        let size = from + (to - from) * rng.random::<f64>();
        let until_s = SETTLING_S + PHASES_S * rng.random::<f64>();
        let start = Environment::random_start(body, task, rng);
        let mut settled = Simulation::new(body, task, start, omega_v);
        while settled.time_s() < until_s {
            if settled
                .step(omega_v, None, &mut Deterministic(policy))
                .is_some()
            {
                return None;
            }
        }
        let met = match kind {
            Kind::Push => Met::Push { impulse_n_s: size },
            Kind::StepUp => {
                let at_m = settled.state().x + FACE_AHEAD_M + FACES_M * rng.random::<f64>();
                settled = touched(settled, size, at_m, omega_v, policy)?;
                Met::Step { at_m }
            }
        };
        Some(Self {
            settled,
            omega_v,
            met,
        })
    }

    /// How much of the way to withstanding it the body gets, 1 for all of it.
    pub fn share(&self, policy: &mut Policy, offsets: &Offsets, trial: Trial) -> f64 {
        let (goal, within_s) = match (self.met, trial) {
            (Met::Push { .. }, Trial::Sample) => (Goal::Up, SAMPLE_UP_S),
            (Met::Push { .. }, Trial::Whole) => (Goal::Up, UP_S),
            (Met::Step { at_m }, Trial::Sample) => {
                (Goal::At(at_m + SAMPLE_BEYOND_M), SAMPLE_BEYOND_S)
            }
            (Met::Step { at_m }, Trial::Whole) => (Goal::At(at_m + BEYOND_M), BEYOND_S),
        };
        self.go(policy, offsets, within_s, goal, None)
    }

    /// Whether it is withstood.
    pub fn withstood(&self, policy: &mut Policy, offsets: &Offsets) -> bool {
        self.share(policy, offsets, Trial::Whole) >= 1.0
    }

    /// What is to be done in the first `duration_s`: the commands with the offsets `meant`, in the states to which those with
    /// `followed` lead.
    pub fn record(
        &self,
        policy: &mut Policy,
        meant: &Offsets,
        followed: &Offsets,
        duration_s: f64,
    ) -> Pairs {
        let mut pairs = Pairs::default();
        let recorded = Some((meant, &mut pairs));
        self.go(policy, followed, duration_s, Goal::Up, recorded);
        pairs
    }

    /// The share of the goal that is got to in `duration_s`.
    fn go(
        &self,
        policy: &mut Policy,
        offsets: &Offsets,
        duration_s: f64,
        goal: Goal,
        recorded: Option<(&Offsets, &mut Pairs)>,
    ) -> f64 {
        let mut simulation = self.settled.clone();
        let period_s = simulation.control_period_s();
        let periods = |time_s: f64| (time_s / period_s).round() as usize;
        let push_n = match self.met {
            Met::Push { impulse_n_s } => Some([impulse_n_s / PUSH_S, 0.0]),
            Met::Step { .. } => None,
        };
        let mut disturbed = Disturbed {
            policy,
            offsets,
            period: 0,
            period_s,
            recorded,
        };
        let begin_m = simulation.state().x;
        let whole = periods(duration_s);
        let mut reached: f64 = 0.0;
        for k in 0..whole {
            let push_n = push_n.filter(|_| k < periods(PUSH_S));
            let over = simulation.step(self.omega_v, push_n, &mut disturbed);
            reached = match goal {
                Goal::Up => (k + 1) as f64 / whole as f64,
                Goal::At(to_m) => (simulation.state().x - begin_m) / (to_m - begin_m),
            };
            if over.is_some() {
                // Also where it falls at the goal.
                return reached.min(NEARLY);
            }
            if reached >= 1.0 {
                break;
            }
        }
        reached
    }
}

/// What a body has to do: be up at the end, or have its hip get somewhere.
#[derive(Clone, Copy)]
enum Goal {
    Up,
    At(f64),
}

/// The motion after the first control period in which a step of `height_m` with its face at `at_m` changes it: its next command is the first
/// that can know of the step.
fn touched(
    mut settled: Simulation,
    height_m: f64,
    at_m: f64,
    omega_v: f64,
    policy: &mut Policy,
) -> Option<Simulation> {
    let stepped = |at_m| {
        let mut disturbance = Disturbance::default();
        let steps = &mut disturbance.terrain.steps;
        steps.push(TerrainStep { height_m, at_m });
        disturbance.place(settled.body().clone())
    };
    // Compared with the same motion with the step out of reach: flat ground, of which the terrain knows nothing, rounds otherwise.
    let (near, far) = (stepped(at_m), stepped(at_m + OUT_OF_REACH_M));
    let mut undisturbed = settled.clone();
    settled.change_body(near);
    undisturbed.change_body(far);
    let until_s = settled.time_s() + TOUCHED_S;
    while settled.time_s() < until_s {
        let over = settled.step(omega_v, None, &mut Deterministic(policy));
        undisturbed.step(omega_v, None, &mut Deterministic(policy));
        if over.is_some() {
            return None;
        }
        if settled.state() != undisturbed.state() {
            return Some(settled);
        }
    }
    None
}

/// The controller's commands with the offsets.
struct Disturbed<'a> {
    policy: &'a mut Policy,
    offsets: &'a Offsets,
    period: usize,
    period_s: f64,
    /// What is recorded, with these offsets.
    recorded: Option<(&'a Offsets, &'a mut Pairs)>,
}

impl Control for Disturbed<'_> {
    fn act(&mut self, observation: &[f32; OBSERVATION_SIZE], action: &mut [f32; ACTION_SIZE]) {
        Deterministic(self.policy).act(observation, action);
        let place = self.period as f64 * self.period_s / KNOT_S;
        if let Some((meant, pairs)) = &mut self.recorded {
            pairs.push(observation, &with_offsets(*action, meant, place));
        }
        *action = with_offsets(*action, self.offsets, place);
        self.period += 1;
    }
}

/// The commands with the offsets at a place between two knots.
fn with_offsets(
    mut action: [f32; ACTION_SIZE],
    offsets: &Offsets,
    place: f64,
) -> [f32; ACTION_SIZE] {
    let (knot, share) = (place as usize, place.fract());
    let from = knot
        .checked_sub(1)
        .map_or(Some(&[0.0; ACTION_SIZE]), |last| offsets.get(last));
    if let (Some(from), Some(to)) = (from, offsets.get(knot)) {
        for ((command, from), to) in action.iter_mut().zip(from).zip(to) {
            let offset = from * (1.0 - share) + to * share;
            *command = (f64::from(*command) + offset).clamp(-1.0, 1.0) as f32;
        }
    }
    action
}
