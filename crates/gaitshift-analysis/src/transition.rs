//! A change of gait: what the motion is before the command changes, what it is afterwards, and how many
//! steps lie between.

use serde::{Deserialize, Serialize};

use crate::gait::{GaitClass, GaitRule};
use crate::recording::{Recording, Window, column, ended_by};
use crate::steps::find_steps;
use crate::summary::{GaitSummary, has_fallen, settling_time_s, summarise_window};
use crate::support::Support;

/// How to judge a change of gait.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TransitionOptions {
    /// Time left out at the recording's beginning, s, but at most half of the time before the ramp.
    /// Default 5 s.
    pub settling_before_s: f64,
    /// Time left out after the ramp, s, but at most half of the time after it. Default 5 s.
    pub settling_after_s: f64,
    /// What counts as contact, walking and running.
    pub rule: GaitRule,
}

impl Default for TransitionOptions {
    fn default() -> Self {
        Self {
            settling_before_s: 5.0,
            settling_after_s: 5.0,
            rule: GaitRule::default(),
        }
    }
}

/// A change of gait in figures; `None` (null in JSON) stands for what is undefined.
///
/// `..._before` describes the steady motion before the ramp, `..._after` that after it. The correlations
/// named without a phase are those in which the gait shows: in single support if it is running, over
/// whole strides otherwise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TransitionSummary {
    /// Whether the body stayed up until the recording's end.
    pub survived: bool,
    /// How long the whole recording lasts, s.
    pub survived_s: f64,
    /// Why it ended, as [`GaitSummary::ended_by`].
    pub ended_by: String,
    /// Time at which the command begins to change, s.
    pub ramp_start_s: f64,
    /// Time at which the command has changed, s.
    pub ramp_end_s: f64,
    /// Gait before the ramp; `None` if nothing is recorded before it.
    pub gait_before: Option<GaitClass>,
    /// Gait after the ramp; fallen if the body fell at any time, otherwise `None` if nothing is recorded after it.
    pub gait_after: Option<GaitClass>,
    /// Mean forward speed before, m/s.
    pub speed_before_m_per_s: Option<f64>,
    /// Mean forward speed after, m/s.
    pub speed_after_m_per_s: Option<f64>,
    /// Number of the touchdown, counted from the ramp's start, that begins the first step from which on
    /// every step is one of the new gait. `None` unless one gait (walking, running) changed to the other; of a command that goes up
    /// and down again, [`changes_of_gait`] tells each.
    pub steps_to_change: Option<usize>,
    /// Correlation of kinetic with gravitational energy before, in [-1, 1].
    pub kinetic_potential_correlation_before: Option<f64>,
    /// Correlation of kinetic with gravitational energy after, in [-1, 1].
    pub kinetic_potential_correlation_after: Option<f64>,
    /// Correlation of elastic with kinetic energy in single support before, in [-1, 1].
    pub elastic_kinetic_correlation_before: Option<f64>,
    /// Correlation of elastic with kinetic energy in single support after, in [-1, 1].
    pub elastic_kinetic_correlation_after: Option<f64>,
    /// Correlation of elastic with gravitational energy in single support before, in [-1, 1].
    pub elastic_potential_correlation_before: Option<f64>,
    /// Correlation of elastic with gravitational energy in single support after, in [-1, 1].
    pub elastic_potential_correlation_after: Option<f64>,
    /// Share of time with both feet on the ground before, in [0, 1].
    pub double_support_before: Option<f64>,
    /// Share of time with both feet on the ground after, in [0, 1].
    pub double_support_after: Option<f64>,
    /// Share of time with no foot on the ground before, in [0, 1].
    pub flight_before: Option<f64>,
    /// Share of time with no foot on the ground after, in [0, 1].
    pub flight_after: Option<f64>,
    /// Everything about the steady motion before the ramp; `None` if nothing is recorded before it.
    pub before: Option<GaitSummary>,
    /// Everything about the steady motion after the ramp; `None` if nothing is recorded after it.
    pub after: Option<GaitSummary>,
}

/// Describes a recording in which the command changes between `ramp_start_s` and `ramp_end_s` (in the
/// recording's time, s). Works for every recording, even an empty one.
pub fn summarise_transition(
    recording: &Recording,
    ramp_start_s: f64,
    ramp_end_s: f64,
    options: &TransitionOptions,
) -> TransitionSummary {
    let rule = &options.rule;
    let support = Support::find(recording, &rule.contact);
    let survived = !has_fallen(recording);

    let first_s = recording
        .column(column::TIME_S)
        .first()
        .copied()
        .unwrap_or(0.0);
    let last_s = first_s + recording.duration_s();
    let before_s = first_s + settling_time_s(options.settling_before_s, ramp_start_s - first_s);
    let after_s = ramp_end_s + settling_time_s(options.settling_after_s, last_s - ramp_end_s);
    // Without a stretch of time there is no gait, and none is made up.
    let describe = |from_s: f64, to_s: f64| {
        let window = recording.window(from_s, to_s)?;
        Some(summarise_window(recording, &support, Some(window), rule))
    };
    let before = describe(before_s, ramp_start_s);
    let mut after = describe(after_s, last_s);
    if !survived && let Some(after) = &mut after {
        after.gait = GaitClass::Fallen;
    }
    let gait_before = before.as_ref().map(|before| before.gait);
    let gait_after = if survived {
        after.as_ref().map(|after| after.gait)
    } else {
        Some(GaitClass::Fallen)
    };
    let of_before = |value: fn(&GaitSummary) -> Option<f64>| before.as_ref().and_then(value);
    let of_after = |value: fn(&GaitSummary) -> Option<f64>| after.as_ref().and_then(value);

    let since_ramp = recording.window(ramp_start_s, last_s);
    TransitionSummary {
        survived,
        survived_s: recording.duration_s(),
        ended_by: recording.metadata.ended_by.clone(),
        ramp_start_s,
        ramp_end_s,
        gait_before,
        gait_after,
        speed_before_m_per_s: of_before(|s| s.speed_m_per_s),
        speed_after_m_per_s: of_after(|s| s.speed_m_per_s),
        steps_to_change: since_ramp.zip(gait_before.zip(gait_after)).and_then(
            |(since_ramp, (from, to))| {
                steps_to_change(recording, &support, since_ramp, from, to, rule)
            },
        ),
        kinetic_potential_correlation_before: of_before(kinetic_potential_correlation),
        kinetic_potential_correlation_after: of_after(kinetic_potential_correlation),
        elastic_kinetic_correlation_before: of_before(|s| {
            s.elastic_kinetic_correlation_single_support
        }),
        elastic_kinetic_correlation_after: of_after(|s| {
            s.elastic_kinetic_correlation_single_support
        }),
        elastic_potential_correlation_before: of_before(|s| {
            s.elastic_potential_correlation_single_support
        }),
        elastic_potential_correlation_after: of_after(|s| {
            s.elastic_potential_correlation_single_support
        }),
        double_support_before: of_before(|s| s.double_support),
        double_support_after: of_after(|s| s.double_support),
        flight_before: of_before(|s| s.flight),
        flight_after: of_after(|s| s.flight),
        before,
        after,
    }
}

/// Shortest rest of the command between two changes that are told apart, s: a gait needs some strides to be told.
pub const REST_S: f64 = 4.0;

/// Commands (s/m) and times (s) that differ by less are the same.
const SAME: f64 = 1e-9;

/// The stretches in which the command of a recording changes (begin and end, s), in order; those with less than
/// [`REST_S`] between them count as one.
pub fn command_changes(recording: &Recording) -> Vec<(f64, f64)> {
    let commands = recording.column(column::OMEGA_V);
    let times = recording.column(column::TIME_S);
    // The times of rows are not those of the profile to the last bit, and so a held command is not either.
    let changes = |row: &usize| (commands[*row] - commands[row - 1]).abs() > SAME;
    // A row holds the command that its control period had, which began at the time of the row before.
    let stretch = |row: usize| (times[row.saturating_sub(2)], times[row - 1]);
    join_stretches((1..commands.len()).filter(changes).map(stretch), REST_S)
}

/// Stretches of time (begin and end, s) in order, those less than `rest_s` apart as one.
pub fn join_stretches(
    stretches: impl IntoIterator<Item = (f64, f64)>,
    rest_s: f64,
) -> Vec<(f64, f64)> {
    let mut all: Vec<(f64, f64)> = Vec::new();
    for (start_s, end_s) in stretches {
        match all.last_mut() {
            Some(last) if start_s - last.1 < rest_s - SAME => last.1 = end_s,
            _ => all.push((start_s, end_s)),
        }
    }
    all
}

/// What one of several changes of the command does to the gait.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GaitChange {
    /// Time at which the command begins to change, s.
    pub start_s: f64,
    /// Time at which it has changed, s.
    pub end_s: f64,
    /// Gait before, since the change before it.
    pub gait_before: Option<GaitClass>,
    /// Gait after it, up to the next change; fallen if the body fell before that.
    pub gait_after: Option<GaitClass>,
    /// As [`TransitionSummary::steps_to_change`], up to the next change.
    pub steps_to_change: Option<usize>,
}

/// Describes each change of a command that changes several times, between `ramps` (begin and end in the recording's time, s,
/// in order and apart). Those that the motion does not live to see are left out.
pub fn changes_of_gait(
    recording: &Recording,
    ramps: &[(f64, f64)],
    options: &TransitionOptions,
) -> Vec<GaitChange> {
    let times = recording.column(column::TIME_S);
    let (Some(&first_s), Some(&last_s)) = (times.first(), times.last()) else {
        return Vec::new();
    };
    let seen = ramps.iter().enumerate().filter(|(_, ramp)| ramp.0 < last_s);
    seen.filter_map(|(k, &(start_s, end_s))| {
        let from_s = k.checked_sub(1).map_or(first_s, |before| ramps[before].1);
        let next_s = ramps.get(k + 1).map_or(last_s, |next| next.0);
        let mut part = recording.part(recording.window(from_s, next_s)?);
        if next_s < last_s {
            // What happens later is no part of this change.
            part.metadata.fell = false;
            ended_by::TIME_LIMIT.clone_into(&mut part.metadata.ended_by);
        }
        let summary = summarise_transition(&part, start_s, end_s, options);
        Some(GaitChange {
            start_s,
            end_s,
            gait_before: summary.gait_before,
            gait_after: summary.gait_after,
            steps_to_change: summary.steps_to_change,
        })
    })
    .collect()
}

/// The correlation in which the gait shows.
fn kinetic_potential_correlation(summary: &GaitSummary) -> Option<f64> {
    match summary.gait {
        GaitClass::Running => summary.kinetic_potential_correlation_single_support,
        _ => summary.kinetic_potential_correlation,
    }
}

fn steps_to_change(
    recording: &Recording,
    support: &Support,
    since_ramp: Window,
    before: GaitClass,
    after: GaitClass,
    rule: &GaitRule,
) -> Option<usize> {
    let changes_gait = matches!(
        (before, after),
        (GaitClass::Walking, GaitClass::Running) | (GaitClass::Running, GaitClass::Walking)
    );
    if !changes_gait {
        return None;
    }
    let steps = find_steps(recording, support, since_ramp);
    let unchanged = steps
        .iter()
        .rposition(|step| rule.class_of_step(step) != after);
    let first_changed = unchanged.map_or(0, |last_unchanged| last_unchanged + 1);
    (first_changed < steps.len()).then_some(first_changed + 1)
}
