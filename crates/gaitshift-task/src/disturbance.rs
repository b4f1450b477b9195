//! What disturbs one motion: noise, latency, weak actuators, pushes, ground that is not flat. *Not in the paper.*
//!
//! [`Randomization`](crate::Randomization) draws such things for training; here they are given.

use crate::conditions::{Conditions, LONGEST_LATENCY_S};
use crate::environment::Part;
use crate::error::require;
use crate::observation::OBSERVATION_SIZE;
use crate::touchdowns::Touchdowns;
use crate::{
    Environment, RewardParameters, SensorNoise, StepOutcome, TaskError, TaskParameters,
    TerrainParameters, observe,
};
use gaitshift_body::{Body, BodyParameters, RIGHT};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Everything that disturbs a motion. As it stands by default it changes nothing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Disturbance {
    /// Delay from the controller's command to the actuator's force, in s, rounded to whole integration steps; any but 0 is at least one. Until the
    /// first command arrives actuators are without force.
    pub latency_s: f64,
    /// Share of its force that the right and the left actuator still have.
    pub actuator_factor: [f64; 2],
    /// Noise of the observations.
    pub noise: SensorNoise,
    /// Pushes on the hip axis.
    pub pushes: Vec<Push>,
    /// The ground.
    pub terrain: TerrainParameters,
}

impl Default for Disturbance {
    fn default() -> Self {
        Self {
            latency_s: 0.0,
            actuator_factor: [1.0; 2],
            noise: SensorNoise::default(),
            pushes: Vec::new(),
            terrain: TerrainParameters::default(),
        }
    }
}

/// A constant force on the hip axis for a while.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Push {
    /// Forward force, in N.
    pub forward_n: f64,
    /// Upward force, in N.
    pub up_n: f64,
    /// When it begins, in s since the motion began; rounded to whole integration steps.
    pub start_s: f64,
    /// How long it lasts, in s; rounded to whole integration steps, at least one.
    pub duration_s: f64,
    /// Phase of the stride at which it begins, in \[0, 1): then `start_s` says from when on the right foot's next touchdown,
    /// which is phase 0, is waited for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase: Option<f64>,
}

impl Default for Push {
    fn default() -> Self {
        Self {
            forward_n: 0.0,
            up_n: 0.0,
            start_s: 5.0,
            duration_s: 0.1,
            phase: None,
        }
    }
}

impl Push {
    /// When it begins, or begins to wait, and how long it lasts, in integration steps of a body.
    fn steps(&self, body: &BodyParameters) -> (u64, u64) {
        let steps = |time_s: f64| whole_steps(time_s, body.time_step_s);
        (steps(self.start_s), steps(self.duration_s).max(1))
    }
}

impl Disturbance {
    /// The integration steps of a body by which commands are late.
    pub fn latency_steps(&self, time_step_s: f64) -> u32 {
        if self.latency_s == 0.0 {
            return 0;
        }
        whole_steps(self.latency_s, time_step_s).max(1) as u32
    }

    /// Whether it changes nothing.
    pub fn is_none(&self) -> bool {
        self.terrain.is_flat() && !self.acts()
    }

    /// Whether it changes anything but the ground.
    fn acts(&self) -> bool {
        self.latency_s != 0.0
            || self.actuator_factor != [1.0; 2]
            || self.noise != SensorNoise::default()
            || !self.pushes.is_empty()
    }

    /// The body on the ground of this disturbance.
    pub fn place(&self, body: Body) -> Body {
        match self.terrain.terrain() {
            Some(terrain) => body.on(terrain),
            None => body,
        }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// The first field out of range.
    pub fn validate(&self) -> Result<(), TaskError> {
        require(
            (0.0..=LONGEST_LATENCY_S).contains(&self.latency_s),
            "latency_s",
            self.latency_s,
            "between 0 and 1",
        )?;
        require(
            self.actuator_factor.iter().all(|f| (0.0..=1.0).contains(f)),
            "actuator_factor",
            self.actuator_factor,
            "[right, left], each between 0 (no force) and 1",
        )?;
        self.noise.validate("noise")?;
        require(
            self.pushes.len() <= MOST_PUSHES,
            "pushes",
            self.pushes.len(),
            "at most 1000 of them",
        )?;
        for (k, push) in self.pushes.iter().enumerate() {
            let key = |name: &str| format!("pushes[{k}].{name}");
            for (name, force) in [("forward_n", push.forward_n), ("up_n", push.up_n)] {
                require(
                    force.abs() <= 1e6,
                    &key(name),
                    force,
                    "between -1e6 and 1e6",
                )?;
            }
            require(
                (0.0..=1e6).contains(&push.start_s),
                &key("start_s"),
                push.start_s,
                "between 0 and 1e6",
            )?;
            require(
                push.duration_s > 0.0 && push.duration_s <= 1e6,
                &key("duration_s"),
                push.duration_s,
                "above 0, at most 1e6",
            )?;
            require(
                push.phase.is_none_or(|phase| (0.0..1.0).contains(&phase)),
                &key("phase"),
                push.phase.unwrap_or_default(),
                "from 0 to below 1",
            )?;
        }
        self.terrain.validate("terrain")
    }
}

/// Most pushes of a motion: all are looked at in every control period.
const MOST_PUSHES: usize = 1000;

fn whole_steps(time_s: f64, time_step_s: f64) -> u64 {
    (time_s / time_step_s).round() as u64
}

/// Most integration steps of a motion that is read: far more than any has, far less than can be counted.
const MOST_STEPS: u64 = 1 << 52;

/// A disturbance at work on one motion: what its delay and its sensors hold at the moment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Disturbed {
    conditions: Conditions,
    rng: Xoshiro256PlusPlus,
    actuator_factor: [f64; 2],
    /// Force, and the integration steps between which it acts.
    pushes: Vec<([f64; 2], Range<u64>)>,
    /// Pushes that wait for their phase of the stride, and what finds the strides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    waiting: Option<(Vec<Waiting>, Touchdowns)>,
    /// Integration steps since it began.
    steps: u64,
}

/// A push that waits for its phase of the stride. Times are in integration steps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Waiting {
    force_n: [f64; 2],
    lasts: u64,
    /// From when on a touchdown is waited for.
    from: u64,
    phase: f64,
}

impl Waiting {
    /// When it is due in a stride that begins with a touchdown and is expected to last as long as the one before.
    fn due(&self, (touchdown, stride): (u64, u64)) -> Option<u64> {
        (touchdown >= self.from)
            .then(|| touchdown.saturating_add((self.phase * stride as f64).round() as u64))
    }
}

impl Disturbed {
    /// Begins now, with noise drawn by `seed`; `None` if nothing but the ground is disturbed. Pushes at a phase of the
    /// stride are left out: who knows the strides gives their time, or they wait (`with_phases`).
    pub fn new(disturbance: &Disturbance, body: &BodyParameters, seed: u64) -> Option<Self> {
        if !disturbance.acts() {
            return None;
        }
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        // Another stream than that of the start, which the same seed draws.
        rng.jump();
        let timed = disturbance.pushes.iter().filter(|p| p.phase.is_none());
        let pushes = timed.map(|p| {
            let (start, lasts) = p.steps(body);
            ([p.forward_n, p.up_n], start..start + lasts)
        });
        Some(Self {
            conditions: Conditions::new(
                body.clone(),
                disturbance.latency_steps(body.time_step_s),
                disturbance.noise,
                &mut rng,
            ),
            actuator_factor: disturbance.actuator_factor,
            pushes: pushes.collect(),
            waiting: None,
            steps: 0,
            rng,
        })
    }

    /// The same with its pushes at phases of the stride, for motions whose strides nobody knows beforehand: each waits for
    /// the right foot's first touchdown from its `start_s` on, and takes this stride to last as long as the one before.
    pub(crate) fn with_phases(mut self, disturbance: &Disturbance, body: &BodyParameters) -> Self {
        let waiting = disturbance.pushes.iter().filter_map(|push| {
            let (from, lasts) = push.steps(body);
            Some(Waiting {
                force_n: [push.forward_n, push.up_n],
                lasts,
                from,
                phase: push.phase?,
            })
        });
        let waiting: Vec<Waiting> = waiting.collect();
        self.waiting = (!waiting.is_empty()).then(|| (waiting, Touchdowns::new(body)));
        self
    }

    /// Whether its time is one that a motion can have reached.
    pub(crate) fn in_time(&self) -> bool {
        self.steps <= MOST_STEPS
    }

    /// What the controller is told of the state, in SI units.
    pub fn observation(&self, environment: &Environment) -> [f64; OBSERVATION_SIZE] {
        self.conditions
            .sensed(observe(&environment.state, environment.omega_v))
    }

    /// [`Environment::step`] under the disturbance, and under another force on the hip, forward and up in N, if there
    /// is one.
    pub fn step(
        &mut self,
        environment: &mut Environment,
        body: &Body,
        task: &TaskParameters,
        reward: &RewardParameters,
        command: [f64; 2],
        push_n: Option<[f64; 2]>,
    ) -> StepOutcome {
        let period = task.steps_per_period(body.parameters());
        let weak = std::array::from_fn(|i| self.actuator_factor[i] * command[i].clamp(-1.0, 1.0));
        let (late_from, early, late) = self.conditions.delay(weak, period);
        let (begin, end) = (self.steps, self.steps + u64::from(period));
        let mut cuts = vec![begin, begin + u64::from(late_from), end];
        for (_, time) in &self.pushes {
            cuts.extend([time.start.clamp(begin, end), time.end.clamp(begin, end)]);
        }
        cuts.sort_unstable();
        let part = |from: u64, to: u64| {
            let acting = self.pushes.iter().filter(|(_, time)| time.contains(&from));
            let forces = acting.map(|(force, _)| *force).chain(push_n);
            Part {
                command: if from < begin + u64::from(late_from) {
                    early
                } else {
                    late
                },
                push_n: forces.reduce(|a, b| [a[0] + b[0], a[1] + b[1]]),
                steps: (to - from) as u32,
            }
        };
        let parts: Vec<Part> = cuts.windows(2).map(|c| part(c[0], c[1])).collect();
        self.steps = end;
        let outcome = environment.step_in_parts(body, task, reward, command, &parts);
        self.wait(outcome.report.normal_n[RIGHT], begin, period);
        self.conditions.sense(&mut self.rng);
        outcome
    }

    /// Sees the mean force on the right foot in a control period, and times the waiting pushes that are due before the next
    /// one ends.
    fn wait(&mut self, normal_n: f64, begin: u64, period: u32) {
        let Some((waiting, touchdowns)) = &mut self.waiting else {
            return;
        };
        touchdowns.see(normal_n, begin);
        let Some(stride) = touchdowns.stride() else {
            return;
        };
        let (now, pushes) = (self.steps, &mut self.pushes);
        waiting.retain(|push| {
            let due = push.due(stride).map(|due| due.max(now));
            let comes = due.filter(|due| *due < now + u64::from(period));
            if let Some(start) = comes {
                pushes.push((push.force_n, start..start.saturating_add(push.lasts)));
            }
            comes.is_none()
        });
    }
}
