//! Which experiments can be trained, and which are probably not meant.

use super::{ConfigError, Experiment, Symmetry};
use gaitshift_analysis::GaitClass;
use gaitshift_body::Body;
use gaitshift_sac::Temperature;
use gaitshift_task::{EndReason, Environment, Phase};

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
        if i64::try_from(self.seed).is_err() {
            // The greatest number that a TOML file holds: the run's configuration could be written, but not read again.
            return Err(value_error(format!(
                "`seed` is {}, but it must be at most {}",
                self.seed,
                i64::MAX
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
        if t.symmetry == Symmetry::Replay && self.learner.actor_layer_norm {
            return Err(value_error(
                "`training.symmetry` is \"replay\", whose controller is the mean of the actor and its mirror image; that \
                 needs `learner.actor_layer_norm = false`"
                    .to_owned(),
            ));
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
                t.replay_capacity >= t.environments.max(1000),
                "1000 or greater and at least the number of environments",
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
        warnings.extend(ending_at_once(self));
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

/// Random starts with which rules of one's own are tried.
const STARTS: u64 = 64;

/// Rules of one's own that end many episodes in their first control period. A number that is meant to be compared is a rule
/// too, and holds wherever it is not 0.
fn ending_at_once(e: &Experiment) -> Vec<String> {
    let rules = e.task.termination.extra.rules();
    if rules.is_empty() {
        return Vec::new();
    }
    // A body that cannot be is told elsewhere.
    let Ok(body) = Body::new(e.body.clone()) else {
        return Vec::new();
    };
    let mut ended = vec![0; rules.len()];
    for seed in 0..STARTS {
        let phase = &e.curriculum.phases[seed as usize % e.curriculum.phases.len().max(1)];
        let share = (seed as f64 * 0.618).fract();
        let omega_v = phase.omega_v[0] + share * (phase.omega_v[1] - phase.omega_v[0]);
        let state = Environment::start(&body, &e.task, Some(seed));
        let mut environment = Environment::new(&body, state, omega_v);
        let command = [2.0 * share - 1.0, 1.0 - 2.0 * (share * 7.0).fract()];
        let outcome = environment.step(&body, &e.task, &e.task.reward, command);
        if let Some(EndReason::Rule(k)) = outcome.ended {
            ended[usize::from(k)] += 1;
        }
    }
    let often = rules.iter().zip(ended).enumerate();
    often
        .filter(|(_, (_, count))| 4 * count >= STARTS)
        .map(|(k, (rule, count))| {
            format!(
                "the rule `{}` (`task.termination.extra[{k}]`) ends {count} of {STARTS} episodes in their first control period, \
                 as a fall: it holds wherever \"{}\" is not 0; compare what it says with a limit, as in \"abs(theta_rad) > 0.5\"",
                rule.name,
                rule.expression.text()
            )
        })
        .collect()
}
