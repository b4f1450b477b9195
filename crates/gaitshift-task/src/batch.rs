//! A batch of environments for training, stepped together: their episodes, commands, random numbers and checkpoint.

use crate::conditions::Conditions;
use crate::observation::{OBSERVATION_SIZE, observe};
use crate::ranges::uniform;
use crate::{EndReason, Environment, PhaseSettings, Randomization, StepOutcome, TaskParameters};
use gaitshift_body::{Body, BodyState, ParameterError};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

/// A finished episode of a batch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FinishedEpisode {
    /// The command at its start.
    pub omega_v: f64,
    /// Sum of the reward (2), without the common factor.
    pub total_reward: f64,
    /// Length in control periods.
    pub periods: u32,
    /// Why it ended.
    pub ended: EndReason,
    /// Distance covered, in m.
    pub distance_m: f64,
}

/// A ramp of the command within an episode.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
struct Ramp {
    target: f64,
    periods_left: u32,
}

/// Several environments stepped together, each with its own random numbers, so that results do not
/// depend on how they are grouped.
#[derive(Debug, Clone)]
pub struct EnvironmentBatch {
    body: Body,
    task: TaskParameters,
    members: Vec<Member>,
}

/// One environment of a batch, with its running episode and its random numbers.
#[derive(Debug, Clone)]
pub struct Member {
    environment: Environment,
    episode: Episode,
    /// The episode's own body, where it has one; follows from its conditions.
    body: Option<Body>,
}

/// What a batch keeps about the running episode of an environment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Episode {
    ramp: Ramp,
    first_command: f64,
    /// Control periods since its command was drawn, in earlier episodes too where commands are held.
    #[serde(default)]
    held_periods: u32,
    total_reward: f64,
    start_x: f64,
    rng: Xoshiro256PlusPlus,
    /// What it drew, where the phase randomizes.
    #[serde(default)]
    conditions: Option<Conditions>,
}

/// Everything about a batch that a checkpoint keeps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BatchState {
    environments: Vec<Environment>,
    episodes: Vec<Episode>,
}

impl EnvironmentBatch {
    /// `count` environments at random starts.
    pub fn new(
        body: Body,
        task: TaskParameters,
        count: usize,
        seed: u64,
        settings: &PhaseSettings,
    ) -> Self {
        let mut seeds = Xoshiro256PlusPlus::seed_from_u64(seed);
        let blank = Environment::new(&body, BodyState::standing(&body), 0.0);
        let member = |_| Member {
            environment: blank.clone(),
            episode: Episode {
                ramp: Ramp::default(),
                first_command: 0.0,
                held_periods: 0,
                total_reward: 0.0,
                start_x: 0.0,
                rng: Xoshiro256PlusPlus::seed_from_u64(seeds.random()),
                conditions: None,
            },
            body: None,
        };
        let members = (0..count).map(member).collect();
        let mut batch = Self {
            body,
            task,
            members,
        };
        for i in 0..count {
            batch.reset(i, settings);
        }
        batch
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
        &self.body
    }

    /// The body of environment `i` in its running episode: [`EnvironmentBatch::body`] unless the phase randomizes.
    pub fn body_of(&self, i: usize) -> &Body {
        self.members[i].body.as_ref().unwrap_or(&self.body)
    }

    /// Environment `i`.
    pub fn environment(&self, i: usize) -> &Environment {
        &self.members[i].environment
    }

    /// The environments.
    pub fn environments(&self) -> impl Iterator<Item = &Environment> {
        self.members.iter().map(|member| &member.environment)
    }

    /// What the controller of environment `i` is told of its state under `omega_v`, in SI units: the observation with
    /// its sensors' error.
    pub fn observation(&self, i: usize, omega_v: f64) -> [f64; OBSERVATION_SIZE] {
        let member = &self.members[i];
        let observation = observe(&member.environment.state, omega_v);
        match &member.episode.conditions {
            Some(conditions) => conditions.sensed(observation),
            None => observation,
        }
    }

    /// Body, task and the environments one by one, for threads that step them side by side ([`Member::step`]).
    pub fn split(&mut self) -> (&Body, &TaskParameters, &mut [Member]) {
        (&self.body, &self.task, &mut self.members)
    }

    /// A copy of everything that changes, for a checkpoint.
    pub fn state(&self) -> BatchState {
        BatchState {
            environments: self.environments().cloned().collect(),
            episodes: self
                .members
                .iter()
                .map(|member| member.episode.clone())
                .collect(),
        }
    }

    /// Goes back to a saved state. Returns whether it is one of this batch: of as many environments, and of bodies
    /// that can be. Nothing changes otherwise.
    pub fn restore(&mut self, state: BatchState) -> bool {
        // A body of its own must be one that this task can be simulated on.
        let possible = |episode: &Episode| {
            let own = episode.conditions.as_ref();
            own.is_none_or(|c| self.task.validate(&c.body).is_ok() && c.has_possible_ground())
        };
        let fits = state.environments.len() == self.len()
            && state.episodes.len() == self.len()
            && state.episodes.iter().all(possible);
        if !fits {
            return false;
        }
        let saved = state.environments.into_iter().zip(state.episodes);
        let members: Result<Vec<_>, _> = saved
            .map(|(environment, episode)| {
                Ok::<_, ParameterError>(Member {
                    body: episode.body()?,
                    environment,
                    episode,
                })
            })
            .collect();
        match members {
            Ok(members) => {
                self.members = members;
                true
            }
            Err(_) => false,
        }
    }

    /// Starts a new episode in environment `i`.
    pub fn reset(&mut self, i: usize, settings: &PhaseSettings) {
        let Member {
            environment,
            episode,
            body: own,
        } = &mut self.members[i];
        // A command that is held goes on after a fall, until its time is over.
        let held = 1..settings.command.hold_periods;
        let omega_v = if held.contains(&episode.held_periods) {
            episode.first_command
        } else {
            episode.held_periods = 0;
            uniform(settings.omega_v, &mut episode.rng)
        };
        let base = self.body.parameters();
        let drawn = |r: &Randomization| r.draw(base, &mut episode.rng);
        episode.conditions = settings.randomization.as_ref().and_then(drawn);
        // A curriculum that was checked draws only bodies that can be; of any other the body itself remains.
        *own = episode.body().ok().flatten();
        let body = own.as_ref().unwrap_or(&self.body);
        let start = Environment::random_start(body, &self.task, &mut episode.rng);
        *environment = Environment::new(body, start, omega_v);
        episode.ramp = Ramp::default();
        episode.first_command = omega_v;
        episode.total_reward = 0.0;
        episode.start_x = start.x;
    }

    /// Advances environment `i` by one control period. Does not reset: the caller reads the last
    /// observation first. `symmetry` is the weighted term (7), where the learner supplies it.
    pub fn step(
        &mut self,
        i: usize,
        command: [f64; 2],
        symmetry: f64,
        settings: &PhaseSettings,
    ) -> (StepOutcome, Option<FinishedEpisode>) {
        self.members[i].step(&self.body, &self.task, command, symmetry, settings)
    }
}

impl Episode {
    /// The body that it drew.
    fn body(&self) -> Result<Option<Body>, ParameterError> {
        self.conditions.as_ref().map(Conditions::place).transpose()
    }
}

impl Member {
    /// [`EnvironmentBatch::step`] with the body and the task of its batch.
    pub fn step(
        &mut self,
        body: &Body,
        task: &TaskParameters,
        command: [f64; 2],
        symmetry: f64,
        settings: &PhaseSettings,
    ) -> (StepOutcome, Option<FinishedEpisode>) {
        let Self {
            environment,
            episode,
            body: own,
        } = self;
        let body = own.as_ref().unwrap_or(body);
        let mut outcome = match &mut episode.conditions {
            None => environment.step(body, task, &settings.reward, command),
            Some(conditions) => environment.step_under(
                conditions,
                &mut episode.rng,
                body,
                task,
                &settings.reward,
                command,
            ),
        };
        outcome.terms.symmetry = symmetry;
        episode.held_periods = episode.held_periods.saturating_add(1);
        let hold = settings.command.hold_periods;
        if hold > 0 && episode.held_periods >= hold {
            outcome.ended.get_or_insert(EndReason::TimeLimit);
        }
        // So that what is kept of it stays a number.
        episode.total_reward =
            (episode.total_reward + outcome.terms.sum()).clamp(f64::MIN, f64::MAX);
        let finished = outcome.ended.map(|ended| FinishedEpisode {
            omega_v: episode.first_command,
            total_reward: episode.total_reward,
            periods: environment.periods,
            ended,
            distance_m: environment.state.x - episode.start_x,
        });
        self.move_command(task, settings);
        (outcome, finished)
    }

    /// Changes the command within the episode, where the curriculum asks for it.
    fn move_command(&mut self, task: &TaskParameters, settings: &PhaseSettings) {
        let draw = &settings.command;
        if draw.redraw_interval_s <= 0.0 {
            return;
        }
        let Episode { rng, ramp, .. } = &mut self.episode;
        let environment = &mut self.environment;
        if ramp.periods_left > 0 {
            environment.omega_v +=
                (ramp.target - environment.omega_v) / f64::from(ramp.periods_left);
            ramp.periods_left -= 1;
        } else if rng.random::<f64>() < task.control_period_s / draw.redraw_interval_s {
            let longest = draw.redraw_ramp_s / task.control_period_s;
            *ramp = Ramp {
                target: uniform(settings.omega_v, rng),
                periods_left: ((longest * rng.random::<f64>()) as u32).saturating_add(1),
            };
        }
    }
}
