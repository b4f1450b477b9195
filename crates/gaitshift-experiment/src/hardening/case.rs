//! A push on a motion that has settled, and how it goes on under the controller's commands with offsets to them.

use crate::controller::Deterministic;
use crate::simulation::{Control, Simulation};
use gaitshift_body::Body;
use gaitshift_sac::Policy;
use gaitshift_task::{ACTION_SIZE, Environment, OBSERVATION_SIZE, TaskParameters};
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Duration of a push, in s.
const PUSH_S: f64 = 0.1;
/// When offsets begin after the push does, in s. Before that the body's state says little of the push, so that no policy could
/// tell what to do.
const ONSET_S: f64 = 0.06;
/// Offsets are straight lines between this many knots, this far apart in s, then 0.
pub(super) const KNOTS: usize = 20;
const KNOT_S: f64 = 0.1;
/// Time for which the body has to be up after the push begins, in s.
const WITHSTOOD_S: f64 = 8.0;
/// Time under the command before the push, in s: this, and up to as much more as covers any phase of a stride.
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

/// A motion that is about to be pushed.
#[derive(Debug, Clone)]
pub(super) struct Case {
    settled: Simulation,
    omega_v: f64,
    /// Forward; less than 0: backward.
    impulse_n_s: f64,
}

impl Case {
    /// A case that `rng` draws, of these commands and ranges of impulses, each as likely; nothing if the body falls undisturbed.
    pub fn draw(
        policy: &mut Policy,
        body: &Body,
        task: &TaskParameters,
        omega_v: &[f64],
        impulses_n_s: &[[f64; 2]],
        rng: &mut Xoshiro256PlusPlus,
    ) -> Option<Self> {
        let omega_v = omega_v[rng.random_range(0..omega_v.len())];
        let [from, to] = impulses_n_s[rng.random_range(0..impulses_n_s.len())];
        let impulse_n_s = from + (to - from) * rng.random::<f64>();
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
        Some(Self {
            settled,
            omega_v,
            impulse_n_s,
        })
    }

    /// For how long it stays up, in s, `duration_s` at most, and what was done up to `record_s` where that is asked for.
    pub fn up_s(
        &self,
        policy: &mut Policy,
        offsets: &Offsets,
        duration_s: f64,
        recorded: Option<(&mut Pairs, f64)>,
    ) -> f64 {
        let mut simulation = self.settled.clone();
        let period_s = simulation.control_period_s();
        let periods = |time_s: f64| (time_s / period_s).round() as usize;
        let mut pushed = Pushed {
            policy,
            offsets,
            period: 0,
            onset: periods(ONSET_S),
            period_s,
            recorded: recorded.map(|(pairs, until_s)| (pairs, periods(until_s))),
        };
        let push_n = [self.impulse_n_s / PUSH_S, 0.0];
        for k in 0..periods(duration_s) {
            let push = (k < periods(PUSH_S)).then_some(push_n);
            if simulation.step(self.omega_v, push, &mut pushed).is_some() {
                return k as f64 * period_s;
            }
        }
        duration_s
    }

    /// Whether it is up at the end.
    pub fn withstood(&self, policy: &mut Policy, offsets: &Offsets) -> bool {
        self.up_s(policy, offsets, WITHSTOOD_S, None) >= WITHSTOOD_S
    }
}

/// The controller's commands with the offsets.
struct Pushed<'a> {
    policy: &'a mut Policy,
    offsets: &'a Offsets,
    period: usize,
    onset: usize,
    period_s: f64,
    recorded: Option<(&'a mut Pairs, usize)>,
}

impl Control for Pushed<'_> {
    fn act(&mut self, observation: &[f32; OBSERVATION_SIZE], action: &mut [f32; ACTION_SIZE]) {
        Deterministic(self.policy).act(observation, action);
        if let Some(period) = self.period.checked_sub(self.onset) {
            let place = period as f64 * self.period_s / KNOT_S;
            let (knot, share) = (place as usize, place.fract());
            if let [from, to, ..] = self.offsets.get(knot..).unwrap_or_default() {
                for ((command, from), to) in action.iter_mut().zip(from).zip(to) {
                    let offset = from * (1.0 - share) + to * share;
                    *command = (f64::from(*command) + offset).clamp(-1.0, 1.0) as f32;
                }
            }
        }
        if let Some((pairs, until)) = &mut self.recorded
            && self.period < *until
        {
            pairs.push(observation, action);
        }
        self.period += 1;
    }
}
