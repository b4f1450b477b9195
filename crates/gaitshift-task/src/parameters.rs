//! Parameters of the task: control period, endings, starts.

use crate::{ExtraRules, Keyed, RewardParameters};
use gaitshift_body::BodyParameters;
use serde::{Deserialize, Serialize};
use std::fmt;

/// What ends an episode besides the time limit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TerminationParameters {
    /// Greatest |θ| in rad (1.4 in the paper).
    pub pitch_limit_rad: f64,
    /// *Open.* Lowest height of the hip axis in m; 0 switches the rule off. Without it the body
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

/// *Open.* How an episode starts: legs split, one foot on the ground, moving forward. The default
/// start of an evaluation is the middle of these ranges with the right leg in front.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StartParameters {
    /// Angle of the front leg, in rad. A symmetric policy cannot part closed legs.
    pub front_leg_rad: f64,
    /// Angle of the rear leg, in rad.
    pub rear_leg_rad: f64,
    /// Half-range of the uniform variation of both angles, in rad.
    pub leg_variation_rad: f64,
    /// Half-range of the uniform variation of the pitch, in rad.
    pub pitch_variation_rad: f64,
    /// Forward speed, in m/s.
    pub speed_m_per_s: f64,
    /// Half-range of the uniform variation of the speed, in m/s.
    pub speed_variation_m_per_s: f64,
    /// Greatest height of the lower foot above the ground, in m.
    pub drop_variation_m: f64,
}

impl Default for StartParameters {
    fn default() -> Self {
        Self {
            front_leg_rad: 0.25,
            rear_leg_rad: -0.25,
            leg_variation_rad: 0.15,
            pitch_variation_rad: 0.1,
            speed_m_per_s: 0.6,
            speed_variation_m_per_s: 0.4,
            drop_variation_m: 0.02,
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

/// A task or curriculum that cannot be run: which key, its value, what would be accepted.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskError {
    /// Path of the key, as in TOML.
    pub key: String,
    /// The value that was given.
    pub value: String,
    /// What is accepted instead.
    pub accepted: &'static str,
}

impl fmt::Display for TaskError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "`{}` is {}, but it must be {}",
            self.key, self.value, self.accepted
        )
    }
}

impl std::error::Error for TaskError {}

pub(crate) fn require(
    ok: bool,
    key: &str,
    value: impl fmt::Debug,
    accepted: &'static str,
) -> Result<(), TaskError> {
    if ok {
        return Ok(());
    }
    Err(TaskError {
        key: key.to_owned(),
        value: format!("{value:?}"),
        accepted,
    })
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
}
