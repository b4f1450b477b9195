//! Which experiments can be trained, and which are probably not meant.

use super::{ConfigError, Experiment, Symmetry};
use crate::seeds::GREATEST;
use gaitshift_analysis::GaitClass;
use gaitshift_body::Body;
use gaitshift_sac::{SacConfig, Temperature};
use gaitshift_task::{EndReason, Environment, Phase};
use std::f64::consts::PI;

/// More transitions, of 160 bytes and more each, fill no usual machine's memory.
const REPLAY_CAPACITY_MAX: usize = 1_000_000_000;

impl Experiment {
    /// Checks every value.
    ///
    /// # Errors
    /// The first value out of range.
    pub fn validate(&self, origin: &str) -> Result<(), ConfigError> {
        let origin = || origin.to_owned();
        self.body.validate().map_err(|source| ConfigError::Body {
            origin: origin(),
            source,
        })?;
        self.task
            .validate(&self.body)
            .and_then(|()| self.curriculum.validate(&self.body, &self.task.reward))
            .map_err(|source| ConfigError::Task {
                origin: origin(),
                source,
            })?;
        self.learner.validate().map_err(|e| ConfigError::Value {
            origin: origin(),
            message: e.to_string(),
        })?;
        let t = &self.training;
        let value_error = |message: String| ConfigError::Value {
            origin: origin(),
            message,
        };
        if self.seed > GREATEST {
            return Err(value_error(format!(
                "`seed` is {}, but it must be at most {GREATEST}",
                self.seed
            )));
        }
        let unbounded = |phase: &Phase| {
            self.learner.gamma >= 1.0
                && phase.learner.get("horizon").is_none()
                && phase.learner_end.get("horizon").is_some()
        };
        if let Some(i) = self.curriculum.phases.iter().position(unbounded) {
            return Err(value_error(format!(
                "`curriculum.phases[{i}].learner_end` has a horizon to be reached from that of `learner.gamma` = 1, which is \
                 infinite; give its `learner` a horizon too"
            )));
        }
        t.rehearsal.validate().map_err(value_error)?;
        self.criteria.validate("criteria.").map_err(value_error)?;
        let walk = self.criteria.first(GaitClass::Walking);
        if self.curriculum.rehearsal_start().is_some() && walk.is_none() {
            return Err(value_error(
                "a phase rehearses the walk, but `criteria.gaits` asks for none; ask for one, or rehearse nothing"
                    .to_owned(),
            ));
        }
        let learned = matches!(self.learner.temperature, Temperature::Auto { .. });
        let sets_alpha = |phase: &Phase| {
            let tables = [&phase.learner, &phase.learner_end];
            tables.iter().any(|table| table.get("alpha").is_some())
        };
        if let Some(i) = self.curriculum.phases.iter().position(sets_alpha)
            && learned
        {
            return Err(value_error(format!(
                "`curriculum.phases[{i}]` sets `alpha` of the learner, which needs `learner.temperature` of the kind \
                 \"fixed\""
            )));
        }
        let countable = |steps: u64| (1..=1_000_000_000_000_000).contains(&steps);
        let ranges = [
            (
                "environments",
                t.environments as f64,
                (1..=4096).contains(&t.environments),
                "between 1 and 4096",
            ),
            (
                "steps_per_update",
                t.steps_per_update as f64,
                countable(t.steps_per_update),
                "between 1 and 1e15",
            ),
            (
                "metrics_interval_steps",
                t.metrics_interval_steps as f64,
                countable(t.metrics_interval_steps),
                "between 1 and 1e15",
            ),
            (
                "evaluation_interval_steps",
                t.evaluation_interval_steps as f64,
                countable(t.evaluation_interval_steps),
                "between 1 and 1e15",
            ),
            (
                "checkpoint_interval_steps",
                t.checkpoint_interval_steps as f64,
                countable(t.checkpoint_interval_steps),
                "between 1 and 1e15",
            ),
            (
                "replay_capacity",
                t.replay_capacity as f64,
                (t.environments.max(1000)..=REPLAY_CAPACITY_MAX).contains(&t.replay_capacity),
                "from 1000 to 1e9, and at least the number of environments",
            ),
        ];
        for (key, value, ok, accepted) in ranges {
            if !ok {
                return Err(value_error(format!(
                    "`training.{key}` is {value}, but it must be {accepted}"
                )));
            }
        }
        Ok(())
    }

    /// What can be trained but is probably not meant, a sentence each, as far as body and task show.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = self.body.warnings();
        warnings.extend(mistaken_units(self));
        warnings.extend(without_effect(self));
        warnings.extend(first_period(self));
        if self.training.symmetry == Symmetry::Replay {
            for (key, text) in self.task.asymmetric_expressions() {
                warnings.push(format!(
                    "`{key}` tells left from right: {text}. With `training.symmetry = \"replay\"` half of every batch is \
                     mirrored, but not its reward and its end, so that what is learned is the mean of the expression and of \
                     its mirror image; `training.symmetry = \"none\"` learns it as it stands"
                ));
            }
        }
        warnings
    }
}

/// Random starts whose first control period is tried.
const STARTS: u64 = 64;
/// Values beyond which a unit was probably mistaken: a learning rate thirty times the usual one, commands far beyond any
/// that was trained, changes of the command within a step.
const HIGH_LEARNING_RATE: f64 = 1e-2;
const FAR_COMMAND: f64 = 10.0;
const SHORT_INTERVAL_S: f64 = 0.2;

/// Values in another unit than the key's, as far as their size tells.
fn mistaken_units(e: &Experiment) -> Vec<String> {
    let mut warnings = Vec::new();
    let pitch = e.task.termination.pitch_limit_rad;
    if pitch > PI {
        warnings.push(format!(
            "`task.termination.pitch_limit_rad` is {pitch}: in radians that is never reached, so no fall is seen by pitch; \
             in degrees it would be {:.3} rad",
            pitch.to_radians()
        ));
    }
    let phases = &e.curriculum.phases;
    let of_phases = phases
        .iter()
        .flat_map(|phase| [&phase.learner, &phase.learner_end].map(|set| set.get("learning_rate")));
    let rate = of_phases.flatten().fold(e.learner.learning_rate, f64::max);
    if rate > HIGH_LEARNING_RATE {
        warnings.push(format!(
            "a learning rate of {rate} is far above the usual 3e-4: learning will probably diverge"
        ));
    }
    let ranges = phases.iter().flat_map(|phase| {
        let end = phase.omega_v_end.unwrap_or(phase.omega_v);
        phase.omega_v.into_iter().chain(end)
    });
    let farthest = ranges.fold(0.0_f64, |far, omega_v| far.max(omega_v.abs()));
    if farthest > FAR_COMMAND {
        warnings.push(format!(
            "commands go up to {farthest}: a step's reward there is about {farthest} times the speed in m/s, beside which being alive \
             earns little"
        ));
    }
    let interval_s = e.curriculum.command.redraw_interval_s;
    if interval_s > 0.0 && interval_s < SHORT_INTERVAL_S {
        warnings.push(format!(
            "`curriculum.command.redraw_interval_s` is {interval_s}: the command changes within every step; in s"
        ));
    }
    let (stroke, leg) = (e.body.stroke_m, e.body.leg_length_m);
    if stroke > 0.5 * leg {
        warnings.push(format!(
            "`body.stroke_m` is {stroke}, more than half of a leg of {leg} m"
        ));
    }
    warnings
}

/// Settings of the learner that differ from their defaults and that every phase replaces from its start.
fn without_effect(e: &Experiment) -> Vec<String> {
    let default = SacConfig::default();
    let rate = e.learner.learning_rate;
    let settings = [
        ("gamma", e.learner.gamma, default.gamma, "horizon"),
        (
            "learning_rate",
            rate,
            default.learning_rate,
            "learning_rate",
        ),
    ];
    let phases = &e.curriculum.phases;
    let replaced = |key| phases.iter().all(|phase| phase.learner.get(key).is_some());
    settings
        .into_iter()
        .filter(|(_, own, default, key)| own != default && replaced(key))
        .map(|(name, own, _, key)| {
            format!(
                "`learner.{name}` is {own} and has no effect: every phase sets the learner's `{key}`"
            )
        })
        .collect()
}

/// Rules that end many episodes in their first control period, and rewards with which falling pays there. A number that is
/// meant to be compared is a rule too, and holds wherever it is not 0.
fn first_period(e: &Experiment) -> Vec<String> {
    // A body that cannot be is told elsewhere.
    let Ok(body) = Body::new(e.body.clone()) else {
        return Vec::new();
    };
    let rules = e.task.termination.extra.rules();
    let mut by_rule = vec![0; rules.len()];
    let (mut by_height, mut by_pitch) = (0, 0);
    let (mut heights_m, mut reward) = (0.0, 0.0);
    let mut began = vec![0];
    for phase in &e.curriculum.phases {
        began.push(began[began.len() - 1] + phase.steps);
    }
    for seed in 0..STARTS {
        let index = seed as usize % e.curriculum.phases.len().max(1);
        let settings = e.curriculum.at(began[index], &e.task.reward);
        let phase = &e.curriculum.phases[index];
        let share = (seed as f64 * 0.618).fract();
        let omega_v = phase.omega_v[0] + share * (phase.omega_v[1] - phase.omega_v[0]);
        let state = Environment::start(&body, &e.task, Some(seed));
        heights_m += state.z / STARTS as f64;
        let mut environment = Environment::new(&body, state, omega_v);
        let command = [2.0 * share - 1.0, 1.0 - 2.0 * (share * 7.0).fract()];
        let outcome = environment.step(&body, &e.task, &settings.reward, command);
        reward += outcome.terms.sum() / STARTS as f64;
        match outcome.ended {
            Some(EndReason::Rule(k)) => by_rule[usize::from(k)] += 1,
            Some(EndReason::HipHeight) => by_height += 1,
            Some(EndReason::Pitch) => by_pitch += 1,
            _ => {}
        }
    }
    let often = |count: u64| 4 * count >= STARTS;
    let mut warnings = Vec::new();
    if often(by_height) {
        warnings.push(format!(
            "`task.termination.min_hip_height_m` is {} and ends {by_height} of {STARTS} episodes in their first control period: \
             they begin with the hip at {heights_m:.2} m",
            e.task.termination.min_hip_height_m
        ));
    }
    if often(by_pitch) {
        warnings.push(format!(
            "`task.termination.pitch_limit_rad` is {} and ends {by_pitch} of {STARTS} episodes in their first control period",
            e.task.termination.pitch_limit_rad
        ));
    }
    for (k, (rule, count)) in rules.iter().zip(by_rule).enumerate() {
        if often(count) {
            warnings.push(format!(
                "the rule `{}` (`task.termination.extra[{k}]`) ends {count} of {STARTS} episodes in their first control period, \
                 as a fall: it holds wherever \"{}\" is not 0; compare what it says with a limit, as in \"abs(theta_rad) > 0.5\"",
                rule.name,
                rule.expression.text()
            ));
        }
    }
    if reward < 0.0 {
        let earned = if reward > -1e6 {
            format!("{reward:.3}")
        } else {
            format!("{reward:.1e}")
        };
        warnings.push(format!(
            "the first step of an episode earns {earned} on average, less than 0: falling pays, since nothing comes after it; \
             make what costs smaller, or `c2`, which being alive earns, greater"
        ));
    }
    warnings
}
