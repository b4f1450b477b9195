//! Changes of gait on ramps of the command.

use super::motions::{record, steady_motion};
use super::plan::Plan;
use crate::{ReportError, Subject};
use gaitshift_analysis::recording::Recording;
use gaitshift_analysis::{AnalysisOptions, GaitClass, TransitionSummary, summarise};
use gaitshift_experiment::{AskedChange, tries_of_change};
use serde::{Deserialize, Serialize};

/// Time that a change of gait is recorded before the command changes and after, in s.
pub(super) const AROUND_S: f64 = 10.0;

/// A change of gait on a ramp of the command.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// Whether it was survived.
    pub survived: bool,
    /// Gait before.
    pub before: Option<GaitClass>,
    /// Gait after.
    pub after: Option<GaitClass>,
    /// Steps that it takes.
    pub steps: Option<usize>,
}

impl Change {
    fn of(summary: &TransitionSummary) -> Self {
        Self {
            survived: summary.survived,
            before: summary.gait_before,
            after: summary.gait_after,
            steps: summary.steps_to_change,
        }
    }

    /// Whether it led from `from` to `to`.
    pub fn leads(&self, from: GaitClass, to: GaitClass) -> bool {
        self.survived && self.before == Some(from) && self.after == Some(to)
    }
}

/// The change from one command to another, begun at several phases of the stride. A motion that does not last has no phases from
/// which to change.
pub(super) fn changes_by_phase(
    subject: &mut Subject,
    plan: &Plan,
    [from, to]: [f64; 2],
) -> Result<Vec<Change>, ReportError> {
    let steady = steady_motion(subject, from, 2.0 * AROUND_S)?.summary;
    let change = AskedChange {
        from,
        to,
        phases: plan.phases,
        ramp_s: plan.ramp_s,
        steady_s: AROUND_S,
    };
    let tries = tries_of_change(&change, &steady, |profile, duration_s| {
        record(subject, profile, duration_s, None)
    })?;
    Ok(tries.iter().map(Change::of).collect())
}

/// The gait of each part of a walk, run and walk, the settling after each ramp left out.
pub(super) fn gaits_of_round_trip(recording: &Recording) -> Vec<GaitClass> {
    if recording.metadata.fell {
        return Vec::new();
    }
    [0.0, AROUND_S, 2.0 * AROUND_S]
        .iter()
        .filter_map(|&from_s| gait_between(recording, from_s + 0.5 * AROUND_S, from_s + AROUND_S))
        .collect()
}

/// What a stretch of a recording is.
fn gait_between(recording: &Recording, from_s: f64, to_s: f64) -> Option<GaitClass> {
    let part = recording.part(recording.window(from_s, to_s)?);
    let options = AnalysisOptions {
        settling_time_s: 0.0,
        ..AnalysisOptions::default()
    };
    Some(summarise(&part, &options).gait)
}
