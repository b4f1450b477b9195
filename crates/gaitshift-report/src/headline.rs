//! What the papers do not say: the numbers that the field would ask for next, beside those of people.

use crate::claims::Values;
use crate::study::{Steady, Study};
use gaitshift_analysis::{GaitClass, GaitSummary};
use gaitshift_experiment::Estimate;
use serde::Serialize;

/// A number over the seeds of an experiment, with what people do beside it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HeadlineNumber {
    /// What it is, with its unit.
    pub name: &'static str,
    /// What people do, with the source; empty where there is nothing to set beside it.
    pub people: &'static str,
    /// One value per seed.
    pub seeds: Vec<Option<f64>>,
    /// Interquartile mean over seeds with its interval.
    pub estimate: Option<Estimate>,
    /// The command that shows it.
    pub command: &'static str,
}

impl HeadlineNumber {
    /// The interval, where there are several seeds.
    pub fn interval(&self) -> [Option<f64>; 2] {
        interval(self.estimate, &self.seeds)
    }
}

/// Ends of an interval; of a single seed there is none.
pub(crate) fn interval(estimate: Option<Estimate>, seeds: &[Option<f64>]) -> [Option<f64>; 2] {
    let several = seeds.iter().flatten().count() > 1;
    estimate
        .filter(|_| several)
        .map_or([None; 2], |e| e.interval.map(Some))
}

/// A number of a study.
type Of = fn(&Study) -> Option<f64>;

const TRANSITION: &str = "about 0.5 (Kram, Domingo and Ferris, J. Exp. Biol. 200, 1997)";
const RECOVERY_WALK: &str = "0.43 before people begin to run, up to about 0.65 at middling speeds (Segers and others, \
    J. Exp. Biol. 210, 2007; Cavagna, Thys and Zamboni, J. Physiol. 262, 1976)";
const RECOVERY_RUN: &str = "0 to 0.04 (Cavagna, Thys and Zamboni, 1976); 0.05 just after the change (Segers and others, 2007)";
const FLUCTUATIONS: &str = "greater before the change of gait (Diedrich and Warren, 1995)";
const PEAK_WALK: &str = "1.2 at 1.5 m/s (Keller and others, Clin. Biomech. 11, 1996)";
const PEAK_RUN: &str =
    "to about 2.5 at 6 m/s, over 50 % more in slow jogging (Keller and others, 1996)";
const HYSTERESIS: &str = "present (Diedrich and Warren, J. Exp. Psychol. 21, 1995)";
const SPRING_MASS: &str = "near 1 in a spring-mass model (Blickhan, J. Biomech. 22, 1989)";

const NUMBERS: [(&str, &str, Of, &str); 32] = [
    (
        "greatest v²/(g l) of a steady walk",
        TRANSITION,
        |s| greatest(s, GaitClass::Walking).map(|froude| froude * froude),
        "gaitshift report",
    ),
    (
        "least v²/(g l) of a steady run",
        TRANSITION,
        |s| least(s, GaitClass::Running).map(|froude| froude * froude),
        "gaitshift report",
    ),
    (
        "gap in Froude number v/√(g l) between walk and run",
        "",
        |s| Some(least(s, GaitClass::Running)? - greatest(s, GaitClass::Walking)?),
        "gaitshift report",
    ),
    (
        "command at which running begins when the command rises",
        "",
        running_begins,
        "gaitshift report",
    ),
    (
        "command down to which running is kept when the command falls",
        "",
        running_is_kept,
        "gaitshift report",
    ),
    (
        "width of the hysteresis in ω_v",
        HYSTERESIS,
        |s| Some(running_begins(s)? - running_is_kept(s)?),
        "gaitshift report",
    ),
    (
        "number of commands at which random starts end in both gaits",
        "",
        |s| Some(two_gaits(s).len() as f64),
        "gaitshift report",
    ),
    (
        "energy recovery of the centre of mass at ω_v = 0",
        RECOVERY_WALK,
        |s| s.at(0.0)?.energy_recovery,
        "gaitshift evaluate --json",
    ),
    (
        "greatest energy recovery of a steady walk",
        RECOVERY_WALK,
        |s| {
            let walks = s
                .steady
                .iter()
                .filter(|row| row.summary.gait == GaitClass::Walking);
            walks
                .filter_map(|row| row.summary.energy_recovery)
                .reduce(f64::max)
        },
        "gaitshift evaluate --omega-v 0:0.5:0.05 --json",
    ),
    (
        "energy recovery of the centre of mass at ω_v = 3",
        RECOVERY_RUN,
        |s| s.at(3.0)?.energy_recovery,
        "gaitshift evaluate --json",
    ),
    (
        "peak vertical force at ω_v = 0 (body weights)",
        PEAK_WALK,
        |s| peak(s.at(0.0)?),
        "gaitshift evaluate --json",
    ),
    (
        "peak vertical force at ω_v = 3 (body weights)",
        PEAK_RUN,
        |s| peak(s.at(3.0)?),
        "gaitshift evaluate --json",
    ),
    (
        "downward speed of the sole at touchdown, ω_v = 3 (m/s)",
        "",
        |s| Some(landing(s, 3.0)?.sole_down_m_per_s),
        "gaitshift report",
    ),
    (
        "forward speed of the sole at touchdown, ω_v = 3 (m/s)",
        "",
        |s| Some(landing(s, 3.0)?.sole_forward_m_per_s),
        "gaitshift report",
    ),
    (
        "share of the leg force's variance explained by leg length, ω_v = 3",
        SPRING_MASS,
        |s| landing(s, 3.0)?.spring_like,
        "gaitshift report",
    ),
    (
        "cost of transport with negative work, ω_v = 0",
        "",
        |s| s.at(0.0)?.absolute_cost_of_transport,
        "gaitshift evaluate --json",
    ),
    (
        "cost of transport with negative work, ω_v = 3",
        "",
        |s| s.at(3.0)?.absolute_cost_of_transport,
        "gaitshift evaluate --json",
    ),
    (
        "share of ∫|F| dt that presses on an end stop, ω_v = 3",
        "",
        |s| s.at(3.0)?.force_share_at_stops,
        "gaitshift evaluate --json",
    ),
    (
        "losses within 50 ms after touchdown, ω_v = 3",
        "",
        |s| s.at(3.0)?.losses_soon_after_touchdown,
        "gaitshift evaluate --json",
    ),
    (
        "deviation of the phase between the hips from stride to stride, greatest on the stairs (rad)",
        FLUCTUATIONS,
        |s| least_steady_stair(s)?.summary.hip_phase_deviation_rad,
        "gaitshift report",
    ),
    (
        "command on the stairs at which it is greatest",
        FLUCTUATIONS,
        |s| Some(least_steady_stair(s)?.omega_v),
        "gaitshift report",
    ),
    (
        "the same deviation at ω_v = 0 (rad)",
        "",
        |s| s.at(0.0)?.hip_phase_deviation_rad,
        "gaitshift evaluate --json",
    ),
    (
        "clearance of a foot swinging past the other, ω_v = 0 (m)",
        "",
        |s| clearance(s.at(0.0)?),
        "gaitshift evaluate --json",
    ),
    (
        "clearance of a foot swinging past the other, ω_v = 3 (m)",
        "",
        |s| clearance(s.at(3.0)?),
        "gaitshift evaluate --json",
    ),
    (
        "slip: friction of standing feet, ω_v = 0 (J/m)",
        "",
        |s| s.at(0.0)?.slip_work_j_per_m,
        "gaitshift evaluate --json",
    ),
    (
        "slip: friction of standing feet, ω_v = 3 (J/m)",
        "",
        |s| s.at(3.0)?.slip_work_j_per_m,
        "gaitshift evaluate --json",
    ),
    (
        "drag: friction of swinging feet, ω_v = 0 (J/m)",
        "",
        |s| s.at(0.0)?.drag_work_j_per_m,
        "gaitshift evaluate --json",
    ),
    (
        "drag: friction of swinging feet, ω_v = 3 (J/m)",
        "",
        |s| s.at(3.0)?.drag_work_j_per_m,
        "gaitshift evaluate --json",
    ),
    (
        "variation of the step time, ω_v = 0 (deviation over mean)",
        "",
        |s| step_time_variation(s.at(0.0)?),
        "gaitshift evaluate --json",
    ),
    (
        "variation of the step time, ω_v = 3 (deviation over mean)",
        "",
        |s| step_time_variation(s.at(3.0)?),
        "gaitshift evaluate --json",
    ),
    (
        "correlation of leg springs' and kinetic energy, single support, ω_v = 3",
        "",
        |s| s.at(3.0)?.leg_spring_kinetic_correlation_single_support,
        "gaitshift evaluate --json",
    ),
    (
        "correlation of hip springs' and kinetic energy, single support, ω_v = 3",
        "",
        |s| s.at(3.0)?.hip_spring_kinetic_correlation_single_support,
        "gaitshift evaluate --json",
    ),
];

/// The numbers of an experiment's seeds.
pub fn headline_numbers(studies: &[&Study]) -> Vec<HeadlineNumber> {
    NUMBERS
        .iter()
        .map(|&(name, people, of, command)| {
            let values = Values::of(studies, of);
            HeadlineNumber {
                name,
                people,
                estimate: values.estimate(),
                seeds: values.0,
                command,
            }
        })
        .collect()
}

/// All steady motions of a study, however they were reached.
pub(crate) fn motions(study: &Study) -> impl Iterator<Item = &Steady> + Clone {
    let stairs = study.stairs_up.iter().chain(&study.stairs_down);
    study.steady.iter().chain(stairs)
}

fn froudes(study: &Study, gait: GaitClass) -> impl Iterator<Item = f64> {
    motions(study)
        .filter(move |row| row.summary.gait == gait)
        .filter_map(|row| row.summary.froude)
}

pub(crate) fn greatest(study: &Study, gait: GaitClass) -> Option<f64> {
    froudes(study, gait).reduce(f64::max)
}

pub(crate) fn least(study: &Study, gait: GaitClass) -> Option<f64> {
    froudes(study, gait).reduce(f64::min)
}

/// On the way up.
pub(crate) fn running_begins(study: &Study) -> Option<f64> {
    let runs = |row: &&Steady| row.summary.gait == GaitClass::Running;
    study.stairs_up.iter().find(runs).map(|row| row.omega_v)
}

/// On the way down, the last stair of the run without a break.
pub(crate) fn running_is_kept(study: &Study) -> Option<f64> {
    let runs = |row: &&Steady| row.summary.gait == GaitClass::Running;
    study
        .stairs_down
        .iter()
        .skip_while(|row| !runs(row))
        .take_while(runs)
        .last()
        .map(|row| row.omega_v)
}

/// Commands under which some random starts end in a walk and others in a run.
pub(crate) fn two_gaits(study: &Study) -> Vec<f64> {
    let mut commands: Vec<f64> = study.starts.iter().map(|m| m.omega_v).collect();
    commands.dedup();
    let has = |omega_v: f64, gait| {
        study
            .starts
            .iter()
            .any(|m| m.omega_v == omega_v && m.gait == gait)
    };
    commands.retain(|&w| has(w, GaitClass::Walking) && has(w, GaitClass::Running));
    commands
}

fn peak(summary: &GaitSummary) -> Option<f64> {
    let (right, left) = (
        summary.peak_force_right_body_weights?,
        summary.peak_force_left_body_weights?,
    );
    Some(0.5 * (right + left))
}

/// Means of right and left.
pub(crate) fn clearance(summary: &GaitSummary) -> Option<f64> {
    Some(0.5 * (summary.clearance_right_m? + summary.clearance_left_m?))
}

pub(crate) fn step_time_variation(summary: &GaitSummary) -> Option<f64> {
    Some(0.5 * (summary.step_time_variation_right? + summary.step_time_variation_left?))
}

/// The stair, up or down, on which the phase between the hips differs most from stride to stride.
pub(crate) fn least_steady_stair(study: &Study) -> Option<&Steady> {
    let deviation = |row: &Steady| row.summary.hip_phase_deviation_rad.unwrap_or(-1.0);
    let stairs = study.stairs_up.iter().chain(&study.stairs_down);
    stairs
        .filter(|row| row.summary.hip_phase_deviation_rad.is_some())
        .max_by(|a, b| deviation(a).total_cmp(&deviation(b)))
}

fn landing(study: &Study, omega_v: f64) -> Option<&crate::Landing> {
    study.landings.iter().find(|l| l.omega_v == omega_v)
}
