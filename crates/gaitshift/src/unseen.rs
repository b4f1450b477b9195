//! What a table of motions does not show: which ended without a fall, pushes that never came, and ground that was not reached.

use crate::gaits::Row;
use crate::output;
use gaitshift_analysis::recording::ended_by;
use gaitshift_task::{Disturbance, EndReason};
use std::collections::BTreeSet;

/// How far before the hip a foot may be, in m.
const FEET_M: f64 = 0.5;
/// Motions named in a line.
const LISTED: usize = 6;
/// A clock that adds up its periods is late by less, in s.
const CLOCK_S: f64 = 1e-6;

/// Says it on standard error.
pub fn note<'a>(rows: impl Iterator<Item = &'a Row> + Clone, disturbance: Option<&Disturbance>) {
    let all = rows.clone().count();
    let ended = |by: &str| rows.clone().filter(|r| r.summary.ended_by == by).count();
    let disturbed = disturbance.is_some_and(|d| *d != Disturbance::default());
    let cause = if disturbed {
        "the disturbance may be too great, or `time_step_s` too large for the body's values"
    } else {
        "`time_step_s` may be too large for the body's values"
    };
    let mut causes = vec![
        (ended_by::DIVERGED, format!("diverged: {cause}")),
        (
            ended_by::UNDEFINED,
            "ended because a reward term or a rule of `extra` had no finite value".to_owned(),
        ),
    ];
    let named: BTreeSet<&str> = rows.clone().map(|r| r.summary.ended_by.as_str()).collect();
    let own = named
        .into_iter()
        .filter(|by| !EndReason::NAMES.contains(by));
    causes.extend(own.map(|by| (by, format!("ended by the rule `{by}`"))));
    for (by, what) in causes {
        match ended(by) {
            0 => {}
            count => output::note(&format!(
                "{count} of {all} {}, counted as {}, {what}",
                if all == 1 { "motion" } else { "motions" },
                if count == 1 { "a fall" } else { "falls" }
            )),
        }
    }
    let mut asked: Vec<f64> = disturbance
        .iter()
        .flat_map(|d| &d.pushes)
        .map(|push| push.start_s)
        .collect();
    asked.sort_by(f64::total_cmp);
    let counted: Vec<(&Row, usize)> = rows.clone().map(|row| (row, pushes(row))).collect();
    for (before, start_s) in asked.iter().enumerate() {
        let without = counted.iter().filter(|(_, came)| *came <= before);
        let without: Vec<&Row> = without.map(|(row, _)| *row).collect();
        if without.len() == all {
            output::note(&format!(
                "the push at {start_s} s never came: no motion lasts until its time, or its phase of the stride"
            ));
        } else if !without.is_empty() {
            output::note(&format!(
                "{} of {all} motions ended before the push at {start_s} s, or before its phase of the stride: {}",
                without.len(),
                listed(&without)
            ));
        }
    }
    for (name, at_m) in disturbance.map(ends_of_flat_ground).unwrap_or_default() {
        let short: Vec<&Row> = rows
            .clone()
            .filter(|row| row.reached_m.is_some_and(|x_m| x_m + FEET_M < at_m))
            .collect();
        if !short.is_empty() {
            output::note(&format!(
                "{} of {all} {} never reached the {name} at {at_m} m: {}",
                short.len(),
                if all == 1 { "motion" } else { "motions" },
                listed(&short)
            ));
        }
    }
}

/// Motions by command and start, as many as a line holds.
fn listed(rows: &[&Row]) -> String {
    let name = |row: &&Row| {
        let command = row.omega_v.map_or_else(
            || "the profile".to_owned(),
            |omega_v| format!("ω_v {omega_v}"),
        );
        let seed = row.seed.map(|seed| format!(" from seed {seed}"));
        let fell = if row.summary.fell {
            ", which fell before"
        } else {
            ""
        };
        format!("{command}{}{fell}", seed.unwrap_or_default())
    };
    let mut names: Vec<String> = rows.iter().take(LISTED).map(name).collect();
    if rows.len() > LISTED {
        names.push("and so on".to_owned());
    }
    names.join("; ")
}

/// Where the ground ceases to be flat: of the steps, the last; the slope; uneven ground.
fn ends_of_flat_ground(disturbance: &Disturbance) -> Vec<(&'static str, f64)> {
    let terrain = &disturbance.terrain;
    let last_step = terrain.steps.iter().map(|step| step.at_m).reduce(f64::max);
    let uneven = (terrain.uneven.height_m != 0.0).then_some(terrain.uneven.from_m);
    let slope = terrain.slope_from_m.filter(|_| terrain.slope_rad != 0.0);
    [
        ("step", last_step),
        ("slope", slope),
        ("uneven ground", uneven),
    ]
    .into_iter()
    .filter_map(|(name, at_m)| Some((name, at_m?)))
    .collect()
}

/// How many pushes a motion got. One that ended it at once came.
fn pushes(row: &Row) -> usize {
    let s = &row.summary;
    let came = |push: &serde_json::Value| {
        let start_s = push["start_s"].as_f64().unwrap_or(0.0);
        start_s < s.survived_s - CLOCK_S
            || start_s <= s.survived_s && s.ended_by != ended_by::TIME_LIMIT
    };
    let disturbance = row.disturbance.as_ref();
    let pushes = disturbance.and_then(|d| d.get("pushes")?.as_array());
    pushes.map_or(0, |pushes| pushes.iter().filter(|push| came(push)).count())
}
