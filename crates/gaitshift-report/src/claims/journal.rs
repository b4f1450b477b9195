//! What the journal version claims.

use super::{Claim, MORE, Rule, advances, by_sensitivity, is_gait, led_steps, share, within};
use crate::Stretch;
use crate::headline::{by_command, motions};
use crate::source::Source::{self, Report, Swept};
use crate::study::{Steady, Study};
use gaitshift_analysis::GaitClass;
use gaitshift_analysis::GaitClass::{Mixed, Running, Walking};

/// The journal version's commands: those from 0 up to the greatest that it reports.
const COMMANDS: [f64; 2] = [0.0, 2.93];
const WITHOUT_DIVISOR: &str = "journal, without 1/(1+ω_v)";
const WITHOUT_FIRST_PHASE: &str = "journal, without its first phase";
const FULL_RANGE: &str = "journal, full range from the start";
const HIGH_RANGE: &str = "journal, high range from the start";
/// The commands that these are trained with.
const FULL: [f64; 2] = [0.0, 2.5];
const HIGH: [f64; 2] = [1.5, 2.5];
/// A motion that ends before this time falls at its start, in s.
const START_S: f64 = 5.0;

/// Speeds of the walks and runs that advance under the journal version's commands.
fn speeds(study: &Study) -> impl Iterator<Item = f64> {
    let rows = by_command(&study.steady, COMMANDS).filter(|row| is_gait(row) && advances(row));
    rows.filter_map(|row| row.summary.speed_m_per_s)
}

/// Froude numbers of a gait under the journal version's commands, steady motions and stairs.
fn froudes(study: &Study, gait: GaitClass) -> impl Iterator<Item = f64> {
    by_command(motions(study), COMMANDS)
        .filter(move |row| row.summary.gait == gait)
        .filter_map(|row| row.summary.froude)
}

/// The part of the papers' gap between walk and run, 0.22 to 0.65, that steady motions of neither gait cover, in steps of 0.05.
fn transitional(study: &Study) -> Option<f64> {
    let bins = 9;
    let mut covered = vec![false; bins];
    for row in by_command(&study.steady, COMMANDS) {
        let froude = row.summary.froude.filter(|_| row.summary.gait == Mixed);
        if let Some(froude) = froude {
            let bin = ((froude - 0.22) / 0.05).floor();
            if (0.0..bins as f64).contains(&bin) {
                covered[bin as usize] = true;
            }
        }
    }
    Some(covered.iter().filter(|&&c| c).count() as f64 / bins as f64)
}

/// The greatest command up to which, from 0 on, no motion falls.
fn without_a_fall(study: &Study) -> Option<f64> {
    by_command(&study.steady, [0.0, f64::INFINITY])
        .take_while(|row| !row.summary.fell)
        .last()
        .map(|row| row.omega_v)
}

/// The highest single step up that is passed at every place, in cm; nothing if the motion does not last.
fn highest_step_cm(study: &Study, gait: usize) -> Option<f64> {
    let omega_v = study.gaits[gait];
    let mut passed = 0.0;
    for row in study
        .step_heights
        .iter()
        .filter(|row| row.omega_v == omega_v && row.height_m > 0.0 && !row.by_turns)
    {
        if row.successes < row.trials {
            break;
        }
        passed = row.height_m;
    }
    study
        .at(omega_v)
        .filter(|s| !s.fell)
        .map(|_| 100.0 * passed)
}

/// Of the observations named, the share that is among as many of the most sensitive ones.
fn most_sensitive(study: &Study, gait: usize, named: &[&str]) -> Option<f64> {
    let order = by_sensitivity(study, study.gaits[gait]);
    let top = order.get(..named.len())?;
    Some(named.iter().filter(|name| top.contains(name)).count() as f64 / named.len() as f64)
}

fn walk_run_walk(study: &Study) -> Option<f64> {
    let shown = study.walk_run_walk == [Walking, Running, Walking];
    Some(f64::from(u8::from(shown)))
}

/// Share of the commands trained with at which it is in a gait and advances.
fn only(study: &Study, commands: [f64; 2], gait: GaitClass) -> Option<f64> {
    let is = |row: &Steady| row.summary.gait == gait && advances(row);
    share(&within(study, commands), is)
}

/// Share of the commands trained with at which it falls within the first seconds.
fn falls_at_the_start(study: &Study) -> Option<f64> {
    let falls = |row: &Steady| row.summary.fell && row.summary.survived_s < START_S;
    share(&within(study, FULL), falls)
}

/// A tenth of the training, of one with episodes in all of them.
fn tenth(study: &Study, index: usize) -> Option<&Stretch> {
    study
        .training
        .get(index)
        .filter(|_| study.training.len() == 10)
}

/// Mean return of the episodes after six tenths of the training over that in the tenth before: 10 million steps in all.
fn return_after_6m(study: &Study) -> Option<f64> {
    let before = tenth(study, 5)?;
    let after = &study.training[6..];
    let mean = after.iter().map(|t| t.mean_return).sum::<f64>() / after.len() as f64;
    (before.mean_return > 0.0).then(|| mean / before.mean_return)
}

const RATES: [&str; 3] = [
    "theta_velocity_rad_per_s",
    "phi_rad",
    "phi_velocity_rad_per_s",
];
const FIVE: [&str; 5] = [RATES[0], RATES[1], RATES[2], "theta_rad", "h_m"];

#[rustfmt::skip]
pub(super) const CLAIMS: [Claim; 19] = [
    claim("least speed (m/s), commands from 0 to 2.93", "0.51", Rule::Near(0.51), |s| speeds(s).reduce(f64::min), Swept("least speed_m_per_s of rows from 0 to 2.93 whose gait is walking or running")),
    claim("greatest speed (m/s), commands from 0 to 2.93", "3.02", Rule::Near(3.02), |s| speeds(s).reduce(f64::max), Swept("greatest speed_m_per_s of rows from 0 to 2.93 whose gait is walking or running")),
    claim("walking up to Froude number", "0.22 (0.63 m/s)", Rule::Near(0.225), |s| froudes(s, Walking).reduce(f64::max), Report),
    claim("running from Froude number", "0.65 (1.81 m/s)", Rule::Near(0.646), |s| froudes(s, Running).reduce(f64::min), Report),
    claim("a transitional gait: steady motions that are neither walk nor run cover the Froude numbers between the two (share covered)", "0.63 to 1.81 m/s", Rule::AtLeast(0.5), transitional, Report),
    claim("greatest command up to which, from 0 on, it does not fall", "2.93", Rule::AtLeast(2.93), without_a_fall, Swept("omega_v of the last row before the first from 0 on in which fell is true")),
    claim("steps from walk to run, ramp of 0.6 s (median)", "under 2", Rule::AtMost(2.0), |s| led_steps(&s.journal_changes[0]), Report),
    claim("steps from run to walk, ramp of 0.6 s (median)", "about 4", Rule::Near(4.0), |s| led_steps(&s.journal_changes[1]), Report),
    claim("walk, run and walk again in one motion, ramps of 0.6 s", "shown", Rule::Always, walk_run_walk, Report),
    claim("single step up survived walking (cm)", "1.0", Rule::AtLeast(1.0), |s| highest_step_cm(s, 0), Report),
    claim("single step up survived running (cm)", "0.8", Rule::AtLeast(0.8), |s| highest_step_cm(s, 1), Report),
    claim("most sensitive to noise walking: pitch rate, hip angle and its rate (share of the three)", "these three", Rule::Always, |s| most_sensitive(s, 0, &RATES), Report),
    claim("most sensitive to noise running: the same, pitch and h (share of the five)", "these five", Rule::Always, |s| most_sensitive(s, 1, &FIVE), Report),
    claim("without 1/(1+ω_v) its return falls after 6 million steps (mean return from then on over that of the million before)", "falls", Rule::Less(0.9), return_after_6m, Report).of_ablation(WITHOUT_DIVISOR).of_training(),
    claim("without 1/(1+ω_v) it falls at 8 million steps (share of falls in the million that follows)", "falls", Rule::AtLeast(0.5), |s| tenth(s, 8).map(|t| t.falls), Report).of_ablation(WITHOUT_DIVISOR).of_training(),
    claim("without its first phase it falls at the start: within 5 s of a motion (share of the commands from 0 to 2.5)", "falls at the start", Rule::AtLeast(0.5), falls_at_the_start, Report).of_ablation(WITHOUT_FIRST_PHASE),
    claim("without its first phase it falls at the start: in the first million steps of training (share of falls, ratio to the journal version’s method)", "falls at the start", MORE, |s| tenth(s, 0).map(|t| t.falls), Report).of_ablation(WITHOUT_FIRST_PHASE).of_training().against_the_method(),
    claim("with the full range from the start it only walks (share of its commands, 0 to 2.5, at which it walks forward)", "only walks", Rule::AtLeast(0.9), |s| only(s, FULL, Walking), Report).of_ablation(FULL_RANGE),
    claim("with the high range from the start it only runs (share of its commands, 1.5 to 2.5, at which it runs forward)", "only runs", Rule::AtLeast(0.9), |s| only(s, HIGH, Running), Report).of_ablation(HIGH_RANGE),
];

const fn claim(
    claim: &'static str,
    theirs: &'static str,
    rule: Rule,
    of: fn(&Study) -> Option<f64>,
    shown_by: Source,
) -> Claim {
    Claim::new("journal", claim, theirs, rule, of, shown_by)
}
