//! Parameters of the task: control period, reward, endings, starts.

use crate::error::require;
use crate::expression::{Moment, Quantities};
use crate::{
    EndReason, Expression, ExtraRules, Keyed, RewardParameters, StartParameters, TaskError,
};
use gaitshift_body::{AdvanceReport, Body, BodyParameters, LEFT, RIGHT};
use serde::{Deserialize, Serialize};

/// What ends an episode besides the time limit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TerminationParameters {
    /// Greatest |θ| in rad (1.4 in the paper).
    pub pitch_limit_rad: f64,
    /// *Open.* Lowest height of the hip axis over the ground in m; at 0 only a hip below the ground ends an episode. Without it the body
    /// learns to crouch on the retracted end stops, which carry its weight free of charge.
    pub min_hip_height_m: f64,
    /// *Open.* Time limit of an episode in s: a truncation, not a termination.
    pub time_limit_s: f64,
    /// *Not in the paper.* Rules of one's own.
    #[serde(skip_serializing_if = "ExtraRules::is_empty")]
    pub extra: ExtraRules,
}

impl Default for TerminationParameters {
    fn default() -> Self {
        Self {
            pitch_limit_rad: 1.4,
            min_hip_height_m: 0.68,
            time_limit_s: 10.0,
            extra: ExtraRules::default(),
        }
    }
}

/// Parameters of the task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TaskParameters {
    /// *Open.* Period of the controller, in s; a whole number of integration steps.
    pub control_period_s: f64,
    /// The reward.
    pub reward: RewardParameters,
    /// Endings.
    pub termination: TerminationParameters,
    /// Starts.
    pub start: StartParameters,
}

impl Default for TaskParameters {
    fn default() -> Self {
        Self {
            control_period_s: 0.01,
            reward: RewardParameters::default(),
            termination: TerminationParameters::default(),
            start: StartParameters::default(),
        }
    }
}

impl TaskParameters {
    /// Integration steps per control period for a body.
    pub fn steps_per_period(&self, body: &BodyParameters) -> u32 {
        (self.control_period_s / body.time_step_s).round().max(1.0) as u32
    }

    /// Control periods until the time limit.
    pub fn max_periods(&self) -> u32 {
        (self.termination.time_limit_s / self.control_period_s).round() as u32
    }

    /// Checks every field.
    ///
    /// # Errors
    /// The first field out of range.
    pub fn validate(&self, body: &BodyParameters) -> Result<(), TaskError> {
        let (t, s, r) = (&self.termination, &self.start, &self.reward);
        let positive = |v: f64| v.is_finite() && v > 0.0;
        let not_negative = |v: f64| v.is_finite() && v >= 0.0;
        let period = self.control_period_s;
        require(
            positive(period),
            "task.control_period_s",
            period,
            "greater than 0",
        )?;
        let ratio = period / body.time_step_s;
        require(
            ratio >= 0.999 && (ratio - ratio.round()).abs() < 1e-6 * ratio,
            "task.control_period_s",
            period,
            "a whole multiple of the body's time_step_s",
        )?;
        require(
            ratio <= 10_000.0,
            "task.control_period_s",
            period,
            "at most 10000 of the body's time_step_s",
        )?;
        let limit = t.time_limit_s;
        require(
            limit.is_finite() && limit >= period && limit <= 1e6,
            "task.termination.time_limit_s",
            limit,
            "between one control period and 1e6",
        )?;
        let not_negatives = [
            ("task.termination.min_hip_height_m", t.min_hip_height_m),
            ("task.start.leg_variation_rad", s.leg_variation_rad),
            ("task.start.pitch_variation_rad", s.pitch_variation_rad),
            (
                "task.start.speed_variation_m_per_s",
                s.speed_variation_m_per_s,
            ),
            ("task.start.drop_variation_m", s.drop_variation_m),
        ];
        for (key, value) in not_negatives {
            require(not_negative(value), key, value, "0 or greater")?;
        }
        for (key, value) in RewardParameters::KEYS.iter().zip(r.values()) {
            RewardParameters::check(&format!("task.reward.{key}"), key, value)?;
        }
        require(
            positive(t.pitch_limit_rad),
            "task.termination.pitch_limit_rad",
            t.pitch_limit_rad,
            "greater than 0",
        )?;
        for (key, value) in [
            ("task.start.front_leg_rad", s.front_leg_rad),
            ("task.start.rear_leg_rad", s.rear_leg_rad),
        ] {
            require(value.abs() <= 1.2, key, value, "between -1.2 and 1.2")?;
        }
        require(
            s.speed_m_per_s.is_finite(),
            "task.start.speed_m_per_s",
            s.speed_m_per_s,
            "finite",
        )?;
        self.check_expressions(body)
    }

    /// Every expression with the path of its table.
    fn expressions(&self) -> impl Iterator<Item = (String, &Expression)> {
        let terms = self.reward.extra.terms().iter().map(|t| &t.expression);
        let rules = self.termination.extra.rules().iter().map(|r| &r.expression);
        let name = |table: &'static str| move |(k, e)| (format!("task.{table}.extra[{k}]"), e);
        let terms = terms.enumerate().map(name("reward"));
        terms.chain(rules.enumerate().map(name("termination")))
    }

    /// Evaluates every expression at the default start under the command 0: one without a finite value there is a mistake
    /// that a run should not begin with.
    fn check_expressions(&self, body: &BodyParameters) -> Result<(), TaskError> {
        if self.reward.extra.is_empty() && self.termination.extra.is_empty() {
            return Ok(());
        }
        // A body that cannot be is told elsewhere.
        let Ok(body) = Body::new(body.clone()) else {
            return Ok(());
        };
        let start = self.start.middle(&body);
        let contact = [RIGHT, LEFT].map(|leg| body.foot_contact(&start, leg));
        let report = AdvanceReport {
            normal_n: contact.map(|c| c.normal_n),
            tangential_n: contact.map(|c| c.tangential_n),
            ..AdvanceReport::default()
        };
        let quantities = Quantities::of(&Moment::at_start(&body, &start, &report));
        for (key, expression) in self.expressions() {
            if let Err(reason) = expression.evaluate(&quantities) {
                require(
                    false,
                    &format!("{key}.expression"),
                    format_args!("\"{}\" ({reason})", expression.text()),
                    "finite at the default start under the command 0",
                )?;
            }
        }
        Ok(())
    }

    /// Tables of the expressions that differ between a state and its mirror image, with their texts.
    pub fn asymmetric_expressions(&self) -> Vec<(String, String)> {
        self.expressions()
            .filter(|(_, expression)| !expression.is_symmetric())
            .map(|(key, expression)| (key, expression.text().to_owned()))
            .collect()
    }

    /// Why an episode ended, in the words of logs and recordings.
    pub fn end_name(&self, ended: EndReason) -> &str {
        match ended {
            EndReason::Rule(k) => match self.termination.extra.rules().get(usize::from(k)) {
                Some(rule) => &rule.name,
                None => ended.name(),
            },
            _ => ended.name(),
        }
    }
}
