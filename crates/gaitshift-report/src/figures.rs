//! The figures of a report, each with the numbers it shows.

mod ablations;
mod commands;
mod energies;
mod forces;
mod ground;
mod motions;
mod panels;
mod seeds;
mod stairs;
mod training;

use crate::claims::method_of;
use crate::study::{Measured, Plan, Study};
use crate::table::Table;
use crate::{ReportError, Subject};
use gaitshift_figures::Figure;

/// A figure with its title, what it says, and its numbers.
pub(crate) struct Shown {
    /// Name of its files, without ending.
    pub name: String,
    pub title: &'static str,
    pub caption: String,
    pub figure: Figure,
    pub table: Table,
    /// Whether it needs the width of the page.
    pub wide: bool,
}

/// The figures over all subjects: the methods beside each other, and each method beside what leaves out a part of it. Of the methods
/// those that are `repeated` under another name stand for themselves only beside what leaves out a part.
pub(crate) fn of_all(studies: &[&Study], repeated: &[&str]) -> Result<Vec<Shown>, ReportError> {
    let mut whole: Vec<&Study> = studies.to_vec();
    whole.retain(|s| method_of(&s.group).is_none_or(|method| method == s.group));
    whole.retain(|s| !repeated.contains(&s.group.as_str()));
    if whole.is_empty() {
        whole = studies.to_vec();
    }
    let mut shown = vec![commands::sweep(&whole)?, commands::cost(&whole)?];
    for method in &ablations::METHODS {
        let mut own = studies.to_vec();
        own.retain(|s| method_of(&s.group) == Some(method.name));
        // The method first.
        own.sort_by_key(|s| s.group != method.name);
        shown.extend(method.over_commands(&own)?);
        shown.extend(method.over_steps(&own)?);
    }
    Ok(shown)
}

/// The figures of one subject.
pub(crate) fn of_one(
    subject: &Subject,
    measured: &Measured,
    plan: &Plan,
) -> Result<Vec<Shown>, ReportError> {
    let m = measured;
    let mut shown = Vec::new();
    for ((recording, start_s), (name, title)) in m.changes.iter().zip([
        (
            "fig3-walk-to-run",
            "From walking to running (the paper’s Fig. 3)",
        ),
        (
            "fig3-run-to-walk",
            "From running to walking (the paper’s Fig. 3)",
        ),
    ]) {
        shown.extend(motions::change(recording, *start_s, plan, name, title)?);
    }
    shown.extend(motions::round_trip(m, plan)?);
    shown.extend(training::episodes(m)?);
    shown.extend(stairs::bifurcation(&m.study, plan)?);
    shown.extend(stairs::hip_phase(&m.study)?);
    shown.extend(energies::stride_energies(subject, m, plan)?);
    for (recording, omega_v, name, title) in [
        (
            &m.gaits[0],
            plan.gaits[0],
            "poses-walk",
            "Poses through a stride of the walk",
        ),
        (
            &m.gaits[1],
            plan.gaits[1],
            "poses-run",
            "Poses through a stride of the run",
        ),
    ] {
        shown.extend(motions::poses(recording, omega_v, name, title)?);
    }
    shown.extend(energies::work(&m.study, plan)?);
    shown.extend(forces::ground_reaction(subject, m)?);
    shown.extend(forces::leg_springs(subject, m, plan)?);
    shown.extend(stairs::through_the_change(&m.study)?);
    shown.extend(commands::steps_by_speed(&m.study)?);
    shown.extend(ground::ground_steps(&m.study, plan)?);
    Ok(shown)
}
