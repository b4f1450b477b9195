//! One environment: a body at its task, and what one control period does.

use crate::conditions::Conditions;
use crate::expression::{Moment, Quantities};
use crate::observation::{OBSERVATION_SIZE, observe};
use crate::{EndReason, RewardParameters, RewardTerms, StepEnergies, StepOutcome, TaskParameters};
use gaitshift_body::{AdvanceReport, Body, BodyState, EnergyAccount, LEFT, Meter, RIGHT};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

/// One biped at its task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Environment {
    /// State of the body.
    pub state: BodyState,
    /// Work and dissipation since the episode began.
    pub account: EnergyAccount,
    /// The command in force.
    pub omega_v: f64,
    /// Control periods since the episode began.
    pub periods: u32,
    energy_j: f64,
    /// The command of the last control period, which an expression of one's own may compare with the next.
    #[serde(default)]
    command: [f64; 2],
    /// What looks at every integration step, where details are recorded.
    #[serde(skip)]
    meter: Option<Box<Meter>>,
}

impl Environment {
    /// An episode that starts from `state` under `omega_v`.
    pub fn new(body: &Body, state: BodyState, omega_v: f64) -> Self {
        Self {
            energy_j: body.energy(&state).total(),
            state,
            account: EnergyAccount::default(),
            omega_v,
            periods: 0,
            command: [0.0; 2],
            meter: None,
        }
    }

    /// From now on a meter looks at every integration step; what it sees changes nothing.
    pub fn attach_meter(&mut self) {
        self.meter = Some(Box::default());
    }

    /// What the meter has seen, if there is one.
    pub fn meter(&self) -> Option<&Meter> {
        self.meter.as_deref()
    }

    /// The default start: the middle of the start's ranges, the right leg in front.
    pub fn default_start(body: &Body, task: &TaskParameters) -> BodyState {
        task.start.middle(body)
    }

    /// Where a motion starts: the default start, or the random one that a seed draws. A seed draws the same one
    /// everywhere in this project.
    pub fn start(body: &Body, task: &TaskParameters, seed: Option<u64>) -> BodyState {
        match seed {
            Some(seed) => {
                let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
                Self::random_start(body, task, &mut rng)
            }
            None => Self::default_start(body, task),
        }
    }

    /// A start drawn from the start's ranges, either leg in front.
    pub fn random_start(
        body: &Body,
        task: &TaskParameters,
        rng: &mut Xoshiro256PlusPlus,
    ) -> BodyState {
        task.start.draw(body, rng)
    }

    /// The observation, in SI units.
    pub fn observation(&self) -> [f64; OBSERVATION_SIZE] {
        observe(&self.state, self.omega_v)
    }

    /// Advances one control period under the commands of the right and left actuator in [-1, 1].
    pub fn step(
        &mut self,
        body: &Body,
        task: &TaskParameters,
        reward: &RewardParameters,
        command: [f64; 2],
    ) -> StepOutcome {
        let steps = task.steps_per_period(body.parameters());
        let part = Part {
            command,
            push_n: None,
            steps,
        };
        self.step_in_parts(body, task, reward, command, &[part])
    }

    /// [`Environment::step`] while an external force, forward and up in N, pushes the hip axis.
    pub fn step_pushed(
        &mut self,
        body: &Body,
        task: &TaskParameters,
        reward: &RewardParameters,
        command: [f64; 2],
        push_n: [f64; 2],
    ) -> StepOutcome {
        let steps = task.steps_per_period(body.parameters());
        let part = Part {
            command,
            push_n: Some(push_n),
            steps,
        };
        self.step_in_parts(body, task, reward, command, &[part])
    }

    /// Goes on with another body in the same state. The account begins anew, and what the change did to the
    /// energy is no part of the next reward.
    pub fn change_body(&mut self, body: &Body) {
        self.energy_j = body.energy(&self.state).total();
        self.account = EnergyAccount::default();
    }

    /// [`Environment::step`] with weakness, delay and pushes of what an episode has drawn; the sensors' error is drawn anew.
    pub(crate) fn step_under(
        &mut self,
        conditions: &mut Conditions,
        rng: &mut Xoshiro256PlusPlus,
        body: &Body,
        task: &TaskParameters,
        reward: &RewardParameters,
        command: [f64; 2],
    ) -> StepOutcome {
        let steps = task.steps_per_period(body.parameters());
        let (late_from, early, late) = conditions.delay(conditions.weaken(command), steps);
        let push = conditions.push(steps, body.parameters().time_step_s, rng);
        conditions.sense(rng);
        let pushed = push.map_or(0, |(_, steps)| steps);
        let cuts = [0, late_from.min(pushed), late_from.max(pushed), steps];
        let parts: [Part; 3] = std::array::from_fn(|k| Part {
            command: if cuts[k] < late_from { early } else { late },
            push_n: push.filter(|_| cuts[k] < pushed).map(|push| push.0),
            steps: cuts[k + 1] - cuts[k],
        });
        self.step_in_parts(body, task, reward, command, &parts)
    }

    /// Advances one control period whose parts follow each other. `command` is what was asked for in it, whatever its
    /// parts carry out.
    pub(crate) fn step_in_parts(
        &mut self,
        body: &Body,
        task: &TaskParameters,
        reward: &RewardParameters,
        command: [f64; 2],
        parts: &[Part],
    ) -> StepOutcome {
        let before = self.account;
        let mut report = AdvanceReport::default();
        let mut done = 0;
        if let Some(meter) = &mut self.meter {
            meter.begin_period();
        }
        for part in parts.iter().filter(|part| part.steps > 0) {
            let &Part { command, steps, .. } = part;
            let (state, account) = (&mut self.state, &mut self.account);
            let next = match (part.push_n, &mut self.meter) {
                (None, None) => body.advance(state, command, steps, account),
                (Some(push_n), None) => body.advance_pushed(state, command, push_n, steps, account),
                (push_n, Some(meter)) => {
                    body.advance_metered(state, command, push_n, steps, account, meter)
                }
            };
            report = if done == 0 {
                next
            } else {
                report.then(done, &next, steps)
            };
            done += steps;
        }
        let command = command.map(|c| c.clamp(-1.0, 1.0));
        // Nothing precedes an episode's first command: it changes nothing.
        let previous = if self.periods == 0 {
            command
        } else {
            self.command
        };
        self.command = command;
        self.periods = self.periods.saturating_add(1);
        let factor = reward.factor(self.omega_v);
        let without_reward = |ended| StepOutcome {
            terms: RewardTerms::default(),
            factor,
            ended: Some(ended),
            report,
        };
        if report.diverged {
            return without_reward(EndReason::Diverged);
        }
        let energy = body.energy(&self.state);
        let energy_j = energy.total();
        // What a push does is none of the controller's doing.
        let pushed_j = self.account.external_work - before.external_work;
        let change = energy_j - self.energy_j - pushed_j;
        self.energy_j = energy_j;
        let energies = StepEnergies {
            change_j: change,
            friction_loss_j: self.account.friction - before.friction,
            positive_work_j: self.account.positive_work() - before.positive_work(),
        };
        let mut terms = reward.terms(&self.state, &energies, self.omega_v);
        let rule = &task.termination;
        let ground_m = body.ground_height(self.state.x);
        let mut own_ending = None;
        if !(reward.extra.is_empty() && rule.extra.is_empty()) {
            let quantities = Quantities::of(&Moment {
                state: &self.state,
                account: &self.account,
                report: &report,
                energies,
                omega_v: self.omega_v,
                time_s: f64::from(self.periods) * task.control_period_s,
                ground_m,
                sole_m: [RIGHT, LEFT].map(|leg| body.sole_height(&self.state, leg)),
                command,
                previous,
                energy,
                centre: body.centre_of_mass(&self.state),
            });
            let ending = rule.extra.ending(&quantities);
            let Some((ending, values)) = ending.zip(reward.extra.values(&quantities)) else {
                return without_reward(EndReason::Undefined);
            };
            (own_ending, terms.extra) = (ending, values);
        }
        let ended = if self.state.theta.abs() > rule.pitch_limit_rad {
            Some(EndReason::Pitch)
        } else if self.state.z - ground_m < rule.min_hip_height_m {
            Some(EndReason::HipHeight)
        } else if own_ending.is_some() {
            own_ending
        } else if self.periods >= task.max_periods() {
            Some(EndReason::TimeLimit)
        } else {
            None
        };
        StepOutcome {
            terms,
            factor,
            ended,
            report,
        }
    }
}

/// A part of a control period: what the actuators carry out, what pushes the hip (N, forward and up), and for
/// how many integration steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Part {
    pub command: [f64; 2],
    pub push_n: Option<[f64; 2]>,
    pub steps: u32,
}
