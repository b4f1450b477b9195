//! Environments stepped together for other learners than ours: with a seed for each, automatic resets as Gymnasium defines
//! them, and everything there is to tell of a step.

use crate::conditions::Conditions;
use crate::observation::OBSERVATION_SIZE;
use crate::ranges::uniform;
use crate::{
    Disturbance, Disturbed, EndReason, Environment, MOST_EXTRA, Randomization, RewardParameters,
    RewardTerms, TaskError, TaskParameters,
};
use gaitshift_body::{AdvanceReport, Body, BodyState, LEFT, RIGHT};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};
use std::sync::Mutex;

/// Terms of the reward without the symmetry term (7), which only a learner knows.
const TERMS: usize = RewardTerms::NAMES.len() - 1;

/// Numbers in the information on a step without terms of one's own; the last of them is `diverged`.
pub const INFO_SIZE: usize = 4 + TERMS + 16;

/// Numbers in the information on a step: places for as many terms of one's own as there may be follow.
pub const INFO_WIDTH: usize = INFO_SIZE + MOST_EXTRA;

/// Names of the information on a step: those of a recording's columns, `diverged`, and after it the reward terms of one's
/// own.
pub fn info_names(reward: &RewardParameters) -> Vec<String> {
    let terms = RewardTerms::NAMES
        .iter()
        .filter(|name| **name != "symmetry");
    let rest = [
        "kinetic_energy_j",
        "gravitational_energy_j",
        "hip_spring_energy_j",
        "leg_spring_energy_j",
        "contact_energy_j",
        "stop_energy_j",
        "actuator_work_j",
        "actuator_positive_work_j",
        "damper_dissipation_j",
        "contact_dissipation_j",
        "stop_dissipation_j",
        "right_normal_force_n",
        "right_tangential_force_n",
        "left_normal_force_n",
        "left_tangential_force_n",
        "diverged",
    ];
    ["time_s", "omega_v", "x_m", "z_m"]
        .map(str::to_owned)
        .into_iter()
        .chain(terms.map(|name| format!("reward_{name}")))
        .chain(rest.map(str::to_owned))
        .chain(reward.extra.columns())
        .collect()
}

/// How an environment goes on after an episode, as Gymnasium's `AutoresetMode`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AutoReset {
    /// The next step begins another episode, whatever the action.
    NextStep,
    /// The step that ends an episode begins another one too.
    SameStep,
    /// Not by itself: the caller resets.
    Disabled,
}

/// How an episode begins.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Opening {
    /// Its command; drawn from the range if there is none.
    pub omega_v: Option<f64>,
    /// Whether it begins at the default start instead of a random one.
    pub default_start: bool,
    /// The state in which it begins, instead of either.
    pub state: Option<BodyState>,
}

/// What one step of one environment gives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VectorStep {
    /// The observation, in SI units.
    pub observation: [f64; OBSERVATION_SIZE],
    /// The reward (2) with its common factor.
    pub reward: f64,
    /// The body fell, or its simulation diverged.
    pub terminated: bool,
    /// The time limit was reached.
    pub truncated: bool,
    /// Why the episode ended, if it did.
    pub ended: Option<EndReason>,
    /// The information, in the order of [`info_names`]; what is beyond the names is 0.
    pub info: [f64; INFO_WIDTH],
    /// The terms of the reward.
    pub terms: RewardTerms,
    /// Mean forces over the period; at an episode's begin those of its instant.
    pub report: AdvanceReport,
    /// Observation and information of the episode that ended within this step, where another has begun.
    pub last: Option<([f64; OBSERVATION_SIZE], [f64; INFO_WIDTH])>,
}

impl Default for VectorStep {
    fn default() -> Self {
        Self {
            observation: [0.0; OBSERVATION_SIZE],
            reward: 0.0,
            terminated: false,
            truncated: false,
            ended: None,
            info: [0.0; INFO_WIDTH],
            terms: RewardTerms::default(),
            report: AdvanceReport::default(),
            last: None,
        }
    }
}

/// One environment with its own random numbers.
#[derive(Debug, Clone)]
struct Member {
    saved: Saved,
    /// The episode's own body, where it has one; follows from its conditions.
    body: Option<Body>,
}

/// What of an environment changes as it moves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Saved {
    environment: Environment,
    rng: Xoshiro256PlusPlus,
    /// The episode is over.
    over: bool,
    /// What the episode has drawn, where there is a randomization.
    conditions: Option<Conditions>,
    /// What disturbs the episode.
    disturbed: Option<Disturbed>,
}

/// Everything about a vector of environments that changes as it moves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VectorState(Vec<Saved>);

impl VectorState {
    /// Number of environments.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl Saved {
    /// The body that it drew. One that was checked can be.
    fn body(&self) -> Option<Body> {
        let conditions = self.conditions.as_ref()?;
        if !conditions.has_possible_ground() {
            return None;
        }
        conditions.place().ok()
    }

    fn observation(&self) -> [f64; OBSERVATION_SIZE] {
        match (&self.disturbed, &self.conditions) {
            (Some(disturbed), _) => disturbed.observation(&self.environment),
            (None, Some(conditions)) => conditions.sensed(self.environment.observation()),
            (None, None) => self.environment.observation(),
        }
    }
}

impl Member {
    fn body<'a>(&'a self, shared: &'a Body) -> &'a Body {
        self.body.as_ref().unwrap_or(shared)
    }
}

/// What all environments share.
#[derive(Debug, Clone)]
struct Setting {
    body: Body,
    task: TaskParameters,
    omega_v: [f64; 2],
    randomization: Option<Randomization>,
    disturbance: Option<Disturbance>,
}

/// Environments stepped together. What comes out does not depend on how many there are beside, nor on the threads.
#[derive(Debug, Clone)]
pub struct VectorEnvironment {
    setting: Setting,
    members: Vec<Member>,
}

impl VectorEnvironment {
    /// `count` environments whose commands are drawn from a range. Their first episodes begin with
    /// [`VectorEnvironment::reset`]; until then the bodies stand.
    pub fn new(body: Body, task: TaskParameters, omega_v: [f64; 2], count: usize) -> Self {
        let member = Member {
            saved: Saved {
                environment: Environment::new(&body, BodyState::standing(&body), 0.0),
                rng: Xoshiro256PlusPlus::seed_from_u64(0),
                over: false,
                conditions: None,
                disturbed: None,
            },
            body: None,
        };
        Self {
            members: vec![member; count],
            setting: Setting {
                body,
                task,
                omega_v,
                randomization: None,
                disturbance: None,
            },
        }
    }

    /// The same environments, whose episodes draw what differs between them. The first episode after
    /// [`VectorEnvironment::seed`] has the start and the command that it would have without; those of later episodes differ,
    /// since what was drawn comes from the same random numbers.
    ///
    /// # Errors
    /// A value out of range, or a disturbance as well.
    pub fn randomized(mut self, randomization: Randomization) -> Result<Self, TaskError> {
        randomization.validate("randomization", self.body().parameters())?;
        self.setting.randomization = Some(randomization);
        self.checked()
    }

    /// The same environments, each episode disturbed alike but for its noise, which is drawn. A push at a phase of the stride
    /// comes in the first stride from its `start_s` on that has one before it, and takes the one to last as long as the other.
    ///
    /// # Errors
    /// A value out of range, or a randomization as well.
    pub fn disturbed(mut self, disturbance: Disturbance) -> Result<Self, TaskError> {
        disturbance.validate()?;
        self.setting.body = disturbance.place(self.setting.body);
        self.setting.disturbance = Some(disturbance);
        self.checked()
    }

    fn checked(self) -> Result<Self, TaskError> {
        if self.setting.randomization.is_some() && self.setting.disturbance.is_some() {
            return Err(TaskError {
                key: "randomization".to_owned(),
                value: "given beside a disturbance".to_owned(),
                accepted: "given alone; what shall be the same in every episode can be a range of one value, such as latency_s = [0.01, 0.01]",
            });
        }
        Ok(self)
    }

    /// What draws the differences between episodes.
    pub fn randomization(&self) -> Option<&Randomization> {
        self.setting.randomization.as_ref()
    }

    /// What disturbs every episode.
    pub fn disturbance(&self) -> Option<&Disturbance> {
        self.setting.disturbance.as_ref()
    }

    /// The range from which commands are drawn.
    pub fn command_range(&self) -> [f64; 2] {
        self.setting.omega_v
    }

    /// A copy of everything that changes.
    pub fn state(&self) -> VectorState {
        VectorState(self.members.iter().map(|m| m.saved.clone()).collect())
    }

    /// Goes back to a saved state. Returns whether it is one of so many environments, of bodies that this task can be
    /// simulated on, and of disturbances whose time can go on; nothing changes otherwise.
    pub fn restore(&mut self, state: VectorState) -> bool {
        let members: Vec<Member> = state
            .0
            .into_iter()
            .map(|saved| Member {
                body: saved.body(),
                saved,
            })
            .collect();
        let task = &self.setting.task;
        let possible = |m: &Member| match (&m.body, &m.saved.conditions) {
            (Some(body), Some(_)) => task.validate(body.parameters()).is_ok(),
            (body, conditions) => body.is_none() && conditions.is_none(),
        };
        let in_time = |m: &Member| m.saved.disturbed.as_ref().is_none_or(Disturbed::in_time);
        let fits = members.len() == self.len() && members.iter().all(|m| possible(m) && in_time(m));
        if fits {
            self.members = members;
        }
        fits
    }

    /// Number of environments.
    pub fn len(&self) -> usize {
        self.members.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.members.is_empty()
    }

    /// The body.
    pub fn body(&self) -> &Body {
        &self.setting.body
    }

    /// The body of environment `index` in its episode: [`VectorEnvironment::body`] unless it was drawn.
    pub fn body_of(&self, index: usize) -> &Body {
        self.members[index].body(&self.setting.body)
    }

    /// The task.
    pub fn task(&self) -> &TaskParameters {
        &self.setting.task
    }

    /// Environment `index`.
    pub fn environment(&self, index: usize) -> &Environment {
        &self.members[index].saved.environment
    }

    /// Starts the random numbers of environment `index` anew. The next random start is the one that
    /// [`Environment::start`] draws with this seed.
    pub fn seed(&mut self, index: usize, seed: u64) {
        self.members[index].saved.rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    }

    /// Changes the command of environment `index` within its episode.
    pub fn set_command(&mut self, index: usize, omega_v: f64) {
        self.members[index].saved.environment.omega_v = omega_v;
    }

    /// Begins an episode in environment `index`.
    pub fn reset(&mut self, index: usize, opening: Opening) -> VectorStep {
        self.setting.begin(&mut self.members[index], opening)
    }

    /// What there is to tell of environment `index` between two steps, without forces and reward.
    pub fn look(&self, index: usize) -> VectorStep {
        let member = &self.members[index];
        let (terms, report) = (RewardTerms::default(), AdvanceReport::default());
        VectorStep {
            observation: member.saved.observation(),
            info: self.setting.info(member, &terms, &report, false),
            ..VectorStep::default()
        }
    }

    /// Advances environment `index` by one control period, without an automatic reset. What lies beyond \[-1, 1\] in a
    /// command is limited to it.
    pub fn step(&mut self, index: usize, command: [f64; 2]) -> VectorStep {
        self.setting.step(&mut self.members[index], command)
    }

    /// Advances all environments by one control period, or begins their next episodes. The work is shared out among
    /// `threads`.
    pub fn step_all(
        &mut self,
        commands: &[[f64; 2]],
        auto_reset: AutoReset,
        threads: usize,
    ) -> Vec<VectorStep> {
        let Self { setting, members } = self;
        let count = members.len();
        let mut steps = vec![VectorStep::default(); count];
        let work = |members: &mut [Member], commands: &[[f64; 2]], steps: &mut [VectorStep]| {
            for ((member, command), step) in members.iter_mut().zip(commands).zip(steps) {
                *step = setting.step_and_reset(member, *command, auto_reset);
            }
        };
        let share = count.div_ceil(threads.max(1)).max(1);
        if share >= count {
            work(members, commands, &mut steps);
            return steps;
        }
        let parts = members
            .chunks_mut(share)
            .zip(commands.chunks(share))
            .zip(steps.chunks_mut(share));
        let helpers = parts.len() - 1;
        let parts = Mutex::new(parts);
        let work_off = || {
            loop {
                let part = parts.lock().unwrap_or_else(|e| e.into_inner()).next();
                let Some(((members, commands), steps)) = part else {
                    return;
                };
                work(members, commands, steps);
            }
        };
        std::thread::scope(|scope| {
            for _ in 0..helpers {
                // Where the system refuses a thread they are fewer.
                let helper = std::thread::Builder::new().spawn_scoped(scope, work_off);
                if helper.is_err() {
                    break;
                }
            }
            work_off();
        });
        steps
    }
}

impl Setting {
    /// Begins an episode. The start is drawn before the command, so that a seed gives the start that
    /// [`Environment::start`] gives.
    fn begin(&self, member: &mut Member, opening: Opening) -> VectorStep {
        let saved = &mut member.saved;
        let rng = &mut saved.rng;
        let start = match opening.state {
            Some(state) => state,
            None if opening.default_start => Environment::default_start(&self.body, &self.task),
            None => Environment::random_start(&self.body, &self.task, rng),
        };
        let [low, high] = self.omega_v;
        let omega_v = match opening.omega_v {
            Some(omega_v) => omega_v,
            None if low < high => uniform(self.omega_v, rng),
            None => low,
        };
        let parameters = self.body.parameters();
        let drawn = self.randomization.as_ref();
        saved.conditions = drawn.and_then(|r| r.draw(parameters, rng));
        saved.disturbed = self.disturbance.as_ref().and_then(|disturbance| {
            // Only noise is drawn: without any, commands and starts are those of an undisturbed environment.
            let noisy = disturbance.noise != crate::SensorNoise::default();
            let seed = if noisy { rng.random() } else { 0 };
            let disturbed = Disturbed::new(disturbance, parameters, seed)?;
            Some(disturbed.with_phases(disturbance, parameters))
        });
        member.body = saved.body();
        let body = member.body.as_ref().unwrap_or(&self.body);
        saved.environment = Environment::new(body, start, omega_v);
        saved.over = false;
        let contact = [RIGHT, LEFT].map(|leg| body.foot_contact(&start, leg));
        let report = AdvanceReport {
            normal_n: contact.map(|c| c.normal_n),
            tangential_n: contact.map(|c| c.tangential_n),
            ..AdvanceReport::default()
        };
        VectorStep {
            observation: member.saved.observation(),
            info: self.info(member, &RewardTerms::default(), &report, false),
            report,
            ..VectorStep::default()
        }
    }

    fn step(&self, member: &mut Member, command: [f64; 2]) -> VectorStep {
        let body = member.body.as_ref().unwrap_or(&self.body);
        let Saved {
            environment,
            rng,
            over,
            conditions,
            disturbed,
        } = &mut member.saved;
        let before = environment.clone();
        let (task, reward) = (&self.task, &self.task.reward);
        let outcome = match (disturbed, conditions) {
            (Some(disturbed), _) => disturbed.step(environment, body, task, reward, command, None),
            (None, Some(conditions)) => {
                environment.step_under(conditions, rng, body, task, reward, command)
            }
            (None, None) => environment.step(body, task, reward, command),
        };
        let diverged = outcome.ended.is_some_and(EndReason::is_failure);
        if diverged {
            // Numbers that are none must not reach a learner: the last state that had any stays.
            *environment = before;
        }
        let report = if diverged {
            AdvanceReport::default()
        } else {
            outcome.report
        };
        *over = outcome.ended.is_some();
        VectorStep {
            observation: member.saved.observation(),
            reward: outcome.factor * outcome.terms.sum(),
            terminated: outcome.ended.is_some_and(EndReason::is_termination),
            truncated: outcome.ended == Some(EndReason::TimeLimit),
            ended: outcome.ended,
            info: self.info(member, &outcome.terms, &report, diverged),
            terms: outcome.terms,
            report,
            last: None,
        }
    }

    /// One step with Gymnasium's automatic resets.
    fn step_and_reset(
        &self,
        member: &mut Member,
        command: [f64; 2],
        auto_reset: AutoReset,
    ) -> VectorStep {
        if member.saved.over && auto_reset == AutoReset::NextStep {
            return self.begin(member, Opening::default());
        }
        let step = self.step(member, command);
        if !(member.saved.over && auto_reset == AutoReset::SameStep) {
            return step;
        }
        let first = self.begin(member, Opening::default());
        VectorStep {
            observation: first.observation,
            info: first.info,
            last: Some((step.observation, step.info)),
            ..step
        }
    }

    /// The information, in the order of [`info_names`].
    fn info(
        &self,
        member: &Member,
        terms: &RewardTerms,
        report: &AdvanceReport,
        diverged: bool,
    ) -> [f64; INFO_WIDTH] {
        let environment = &member.saved.environment;
        let s: &BodyState = &environment.state;
        let energy = member.body(&self.body).energy(s);
        let account = &environment.account;
        let names = RewardTerms::NAMES.iter().zip(terms.values());
        let place = [
            f64::from(environment.periods) * self.task.control_period_s,
            environment.omega_v,
            s.x,
            s.z,
        ];
        let rest = [
            energy.kinetic,
            energy.gravitational,
            energy.hip_springs,
            energy.leg_springs(),
            energy.contact,
            energy.stops,
            account.work(),
            account.positive_work(),
            account.dampers(),
            account.contact(),
            account.stops,
            report.normal_n[RIGHT],
            report.tangential_n[RIGHT],
            report.normal_n[LEFT],
            report.tangential_n[LEFT],
            f64::from(u8::from(diverged)),
        ];
        let own = names.filter(|(name, _)| **name != "symmetry");
        let fixed = place.into_iter().chain(own.map(|term| term.1)).chain(rest);
        let mut values = fixed.chain(terms.extra);
        std::array::from_fn(|_| values.next().unwrap_or_default())
    }
}
