//! What the paper claims.

use super::{Claim, LESS, MORE, Rule, advances, gait_at, is_gait, led, share, typical, within};
use crate::headline::{clearance, step_time_variation};
use crate::source::Source::{Evaluated, Report, Swept};
use crate::study::{Steady, Study};
use gaitshift_analysis::{GaitClass, GaitSummary};
use std::f64::consts::PI;

const WITHOUT_PHASE_ONE: &str = "paper, without phase I";
const WITHOUT_ENERGY_TERM: &str = "paper, without the energy term";

/// The summary at a command if the motion is that gait.
fn walk_at_0(study: &Study) -> Option<&GaitSummary> {
    study.at(0.0).filter(|s| s.gait == GaitClass::Walking)
}

fn run_at_3(study: &Study) -> Option<&GaitSummary> {
    study.at(3.0).filter(|s| s.gait == GaitClass::Running)
}

/// Froude numbers of all walks and runs, under commands below 0 too.
fn froudes(study: &Study) -> impl Iterator<Item = f64> {
    let gaits = study.steady.iter().filter(|row| is_gait(row));
    gaits.filter_map(|row| row.summary.froude)
}

/// The motions that advance under the commands at which the paper shows gaits.
fn advancing(study: &Study) -> Vec<&Steady> {
    let mut rows = within(study, [0.0, 3.5]);
    rows.retain(|row| advances(row));
    rows
}

/// How far the legs are from alternating evenly, in rad: 0 where they do, π in a hop.
fn from_alternating(summary: &GaitSummary) -> Option<f64> {
    Some((PI - summary.hip_phase_rad?.rem_euclid(2.0 * PI)).abs())
}

#[rustfmt::skip]
pub(super) const CLAIMS: [Claim; 28] = [
    claim("it walks at ω_v = 0", "double support", Rule::Always, |s| gait_at(s, 0.0, GaitClass::Walking), Evaluated(0.0, "gait")),
    claim("it runs at ω_v = 3", "flight", Rule::Always, |s| gait_at(s, 3.0, GaitClass::Running), Evaluated(3.0, "gait")),
    claim("0 → 3 within 0.4 s leads from the walk to the run (phases of the stride)", "yes (Fig. 3)", Rule::Always, |s| led(&s.to_running, GaitClass::Walking, GaitClass::Running), Report),
    claim("3 → 0 within 0.4 s leads from the run to the walk (phases of the stride)", "yes (Fig. 3)", Rule::Always, |s| led(&s.to_walking, GaitClass::Running, GaitClass::Walking), Report),
    claim("Froude number at ω_v = 0", "0.22", Rule::Near(0.22), |s| walk_at_0(s)?.froude, Evaluated(0.0, "froude")),
    claim("Froude number at ω_v = 3", "0.93", Rule::Near(0.93), |s| run_at_3(s)?.froude, Evaluated(3.0, "froude")),
    claim("cost of transport (8) walking, ω_v = 0", "0.342", Rule::Near(0.342), |s| walk_at_0(s)?.cost_of_transport, Evaluated(0.0, "cost_of_transport")),
    claim("cost of transport (8) running, ω_v = 3", "0.347", Rule::Near(0.347), |s| run_at_3(s)?.cost_of_transport, Evaluated(3.0, "cost_of_transport")),
    claim("the cost of walking is a small part of ASIMO’s 3.2 (share of it)", "0.11 (0.342 of 3.2)", Rule::AtMost(0.2), |s| Some(walk_at_0(s)?.cost_of_transport? / 3.2), Evaluated(0.0, "cost_of_transport, divided by 3.2")),
    claim("least Froude number of a walk or run", "0.16", Rule::Near(0.16), |s| froudes(s).reduce(f64::min), Swept("least froude of rows whose gait is walking or running")),
    claim("greatest Froude number of a walk or run", "0.93", Rule::Near(0.93), |s| froudes(s).reduce(f64::max), Swept("greatest froude of rows whose gait is walking or running")),
    claim("walking: kinetic and potential energy in antiphase", "antiphase", Rule::Antiphase, |s| walk_at_0(s)?.kinetic_potential_correlation, Evaluated(0.0, "kinetic_potential_correlation")),
    claim("running, single support: kinetic and potential energy in phase", "in phase", Rule::InPhase, |s| run_at_3(s)?.kinetic_potential_correlation_single_support, Evaluated(3.0, "kinetic_potential_correlation_single_support")),
    claim("running, single support: elastic and kinetic energy in antiphase", "antiphase", Rule::Antiphase, |s| run_at_3(s)?.elastic_kinetic_correlation_single_support, Evaluated(3.0, "elastic_kinetic_correlation_single_support")),
    claim("running, single support: elastic and potential energy in antiphase", "antiphase", Rule::Antiphase, |s| run_at_3(s)?.elastic_potential_correlation_single_support, Evaluated(3.0, "elastic_potential_correlation_single_support")),
    claim("running, single support: leg springs’ and kinetic energy in antiphase", "antiphase (all springs)", Rule::Antiphase, |s| run_at_3(s)?.leg_spring_kinetic_correlation_single_support, Evaluated(3.0, "leg_spring_kinetic_correlation_single_support")),
    claim("running, single support: leg springs’ and potential energy in antiphase", "antiphase (all springs)", Rule::Antiphase, |s| run_at_3(s)?.leg_spring_potential_correlation_single_support, Evaluated(3.0, "leg_spring_potential_correlation_single_support")),
    claim("Fig. 4: with phase I almost no late episode ends in a fall (share of falls, last fifth)", "almost none", Rule::AtMost(0.1), |s| s.late_falls, Report).of_training(),
    claim("Fig. 4: without phase I most late episodes end in a fall (share of falls, last fifth)", "returns near 0", Rule::AtLeast(0.5), |s| s.late_falls, Report).of_ablation(WITHOUT_PHASE_ONE).of_training(),
    without_energy_term("without the energy term it still advances (share of the commands from 0 to 3.5)", "advances", Rule::AtLeast(0.9), |s| share(&within(s, [0.0, 3.5]), advances)),
    without_energy_term("without the energy term there is no steady walk or run (share of the commands at which it advances)", "none appears", Rule::AtLeast(0.9), |s| share(&advancing(s), |row| !is_gait(row))),
    without_energy_term("without the energy term feet drag more in swing (friction per metre, ratio to the paper’s method)", "drags its legs", MORE, |s| typical(&advancing(s), |m| m.drag_work_j_per_m)).against_the_method(),
    without_energy_term("without the energy term feet slip more in stance (friction per metre, ratio to the paper’s method)", "drags its legs", MORE, |s| typical(&advancing(s), |m| m.slip_work_j_per_m)).against_the_method(),
    without_energy_term("without the energy term a swinging foot clears the ground by less (ratio to the paper’s method)", "drags its legs", LESS, |s| typical(&advancing(s), clearance)).against_the_method(),
    without_energy_term("without the energy term the legs are further from alternating (phase between the hips, ratio to the paper’s method)", "hops", MORE, |s| typical(&advancing(s), from_alternating)).against_the_method(),
    without_energy_term("without the energy term fewer steps lead onto the other foot (ratio to the paper’s method)", "hops", LESS, |s| typical(&advancing(s), |m| m.steps_alternating)).against_the_method(),
    without_energy_term("without the energy term the step time varies more (ratio to the paper’s method)", "nothing steady", MORE, |s| typical(&advancing(s), step_time_variation)).against_the_method(),
    without_energy_term("without the energy term the phase between the hips varies more from stride to stride (ratio to the paper’s method)", "nothing steady", MORE, |s| typical(&advancing(s), |m| m.hip_phase_deviation_rad)).against_the_method(),
];

const fn claim(
    claim: &'static str,
    theirs: &'static str,
    rule: Rule,
    of: fn(&Study) -> Option<f64>,
    shown_by: crate::source::Source,
) -> Claim {
    Claim::new("paper", claim, theirs, rule, of, shown_by)
}

const fn without_energy_term(
    text: &'static str,
    theirs: &'static str,
    rule: Rule,
    of: fn(&Study) -> Option<f64>,
) -> Claim {
    claim(text, theirs, rule, of, Report).of_ablation(WITHOUT_ENERGY_TERM)
}
