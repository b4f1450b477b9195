//! What the papers do not say: the numbers that the field would ask for next, beside those of people.

use crate::seeds::{Values, interval};
use crate::source::Source::{self, Evaluated, Report, Swept};
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
    #[serde(skip)]
    pub(crate) shown_by: Source,
}

impl HeadlineNumber {
    /// The interval, where there are several seeds.
    pub fn interval(&self) -> [Option<f64>; 2] {
        interval(self.estimate, &self.seeds)
    }
}

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

/// What is told of every experiment.
struct Number {
    name: &'static str,
    people: &'static str,
    of: fn(&Study) -> Option<f64>,
    shown_by: Source,
}

#[rustfmt::skip]
const NUMBERS: [Number; 32] = [
    Number { name: "greatest v²/(g l) of a steady walk", people: TRANSITION, of: |s| greatest(s, GaitClass::Walking).map(|froude| froude * froude), shown_by: Report },
    Number { name: "least v²/(g l) of a steady run", people: TRANSITION, of: |s| least(s, GaitClass::Running).map(|froude| froude * froude), shown_by: Report },
    Number { name: "gap in Froude number v/√(g l) between walk and run", people: "", of: |s| Some(least(s, GaitClass::Running)? - greatest(s, GaitClass::Walking)?), shown_by: Report },
    Number { name: "command from which on it runs as the command rises", people: "", of: |s| runs_from(s.stairs_up.iter().rev()), shown_by: Report },
    Number { name: "command down to which it runs as the command falls", people: "", of: |s| runs_from(s.stairs_down.iter()), shown_by: Report },
    Number { name: "width of the hysteresis in ω_v: stairs whose motions up and down differ by more than 0.05 in Froude number", people: HYSTERESIS, of: hysteresis_width, shown_by: Report },
    Number { name: "number of commands at which random starts end in both gaits", people: "", of: |s| Some(two_gaits(s).len() as f64), shown_by: Report },
    Number { name: "energy recovery of the centre of mass at ω_v = 0", people: RECOVERY_WALK, of: |s| s.upright_at(0.0)?.energy_recovery, shown_by: Evaluated(0.0, "energy_recovery") },
    Number { name: "greatest energy recovery of a steady walk", people: RECOVERY_WALK, of: best_recovery_walking, shown_by: Swept("greatest energy_recovery of rows whose gait is walking") },
    Number { name: "energy recovery of the centre of mass at ω_v = 3", people: RECOVERY_RUN, of: |s| s.upright_at(3.0)?.energy_recovery, shown_by: Evaluated(3.0, "energy_recovery") },
    Number { name: "peak vertical force at ω_v = 0 (body weights)", people: PEAK_WALK, of: |s| peak(s.upright_at(0.0)?), shown_by: Evaluated(0.0, "mean of peak_force_right_body_weights and peak_force_left_body_weights") },
    Number { name: "peak vertical force at ω_v = 3 (body weights)", people: PEAK_RUN, of: |s| peak(s.upright_at(3.0)?), shown_by: Evaluated(3.0, "mean of peak_force_right_body_weights and peak_force_left_body_weights") },
    Number { name: "downward speed of the sole at touchdown, ω_v = 3 (m/s)", people: "", of: |s| Some(landing(s, 3.0)?.sole_down_m_per_s), shown_by: Report },
    Number { name: "forward speed of the sole at touchdown, ω_v = 3 (m/s)", people: "", of: |s| Some(landing(s, 3.0)?.sole_forward_m_per_s), shown_by: Report },
    Number { name: "share of the leg force's variance explained by leg length, ω_v = 3", people: SPRING_MASS, of: |s| landing(s, 3.0)?.spring_like, shown_by: Report },
    Number { name: "cost of transport with negative work, ω_v = 0", people: "", of: |s| s.upright_at(0.0)?.absolute_cost_of_transport, shown_by: Evaluated(0.0, "absolute_cost_of_transport") },
    Number { name: "cost of transport with negative work, ω_v = 3", people: "", of: |s| s.upright_at(3.0)?.absolute_cost_of_transport, shown_by: Evaluated(3.0, "absolute_cost_of_transport") },
    Number { name: "share of ∫|F| dt that presses on an end stop, ω_v = 3", people: "", of: |s| s.upright_at(3.0)?.force_share_at_stops, shown_by: Evaluated(3.0, "force_share_at_stops") },
    Number { name: "losses within 50 ms after touchdown, ω_v = 3", people: "", of: |s| s.upright_at(3.0)?.losses_soon_after_touchdown, shown_by: Evaluated(3.0, "losses_soon_after_touchdown") },
    Number { name: "deviation of the phase between the hips from stride to stride, greatest on the stairs (rad)", people: FLUCTUATIONS, of: |s| least_steady_stair(s)?.summary.hip_phase_deviation_rad, shown_by: Report },
    Number { name: "command on the stairs at which it is greatest", people: FLUCTUATIONS, of: |s| Some(least_steady_stair(s)?.omega_v), shown_by: Report },
    Number { name: "the same deviation at ω_v = 0 (rad)", people: "", of: |s| s.upright_at(0.0)?.hip_phase_deviation_rad, shown_by: Evaluated(0.0, "hip_phase_deviation_rad") },
    Number { name: "clearance of a foot swinging past the other, ω_v = 0 (m)", people: "", of: |s| clearance(s.upright_at(0.0)?), shown_by: Evaluated(0.0, "mean of clearance_right_m and clearance_left_m") },
    Number { name: "clearance of a foot swinging past the other, ω_v = 3 (m)", people: "", of: |s| clearance(s.upright_at(3.0)?), shown_by: Evaluated(3.0, "mean of clearance_right_m and clearance_left_m") },
    Number { name: "slip: friction of standing feet, ω_v = 0 (J/m)", people: "", of: |s| s.upright_at(0.0)?.slip_work_j_per_m, shown_by: Evaluated(0.0, "slip_work_j_per_m") },
    Number { name: "slip: friction of standing feet, ω_v = 3 (J/m)", people: "", of: |s| s.upright_at(3.0)?.slip_work_j_per_m, shown_by: Evaluated(3.0, "slip_work_j_per_m") },
    Number { name: "drag: friction of swinging feet, ω_v = 0 (J/m)", people: "", of: |s| s.upright_at(0.0)?.drag_work_j_per_m, shown_by: Evaluated(0.0, "drag_work_j_per_m") },
    Number { name: "drag: friction of swinging feet, ω_v = 3 (J/m)", people: "", of: |s| s.upright_at(3.0)?.drag_work_j_per_m, shown_by: Evaluated(3.0, "drag_work_j_per_m") },
    Number { name: "variation of the step time, ω_v = 0 (deviation over mean)", people: "", of: |s| step_time_variation(s.upright_at(0.0)?), shown_by: Evaluated(0.0, "mean of step_time_variation_right and step_time_variation_left") },
    Number { name: "variation of the step time, ω_v = 3 (deviation over mean)", people: "", of: |s| step_time_variation(s.upright_at(3.0)?), shown_by: Evaluated(3.0, "mean of step_time_variation_right and step_time_variation_left") },
    Number { name: "correlation of leg springs' and kinetic energy, single support, ω_v = 3", people: "", of: |s| s.upright_at(3.0)?.leg_spring_kinetic_correlation_single_support, shown_by: Evaluated(3.0, "leg_spring_kinetic_correlation_single_support") },
    Number { name: "correlation of hip springs' and kinetic energy, single support, ω_v = 3", people: "", of: |s| s.upright_at(3.0)?.hip_spring_kinetic_correlation_single_support, shown_by: Evaluated(3.0, "hip_spring_kinetic_correlation_single_support") },
];

/// The numbers of an experiment's seeds.
pub fn headline_numbers(studies: &[&Study]) -> Vec<HeadlineNumber> {
    NUMBERS
        .iter()
        .map(|number| {
            let values = Values::of(studies, number.of);
            HeadlineNumber {
                name: number.name,
                people: number.people,
                estimate: values.estimate(),
                seeds: values.0,
                shown_by: number.shown_by,
            }
        })
        .collect()
}

/// Motions under commands of a range, both ends included.
pub(crate) fn by_command<'a>(
    rows: impl IntoIterator<Item = &'a Steady>,
    [low, high]: [f64; 2],
) -> impl Iterator<Item = &'a Steady> {
    rows.into_iter()
        .filter(move |row| (low..=high).contains(&row.omega_v))
}

/// All steady motions of a study, however they were reached.
pub(crate) fn motions(study: &Study) -> impl Iterator<Item = &Steady> + Clone {
    let stairs = study.stairs_up.iter().chain(&study.stairs_down);
    study.steady.iter().chain(stairs)
}

fn best_recovery_walking(study: &Study) -> Option<f64> {
    let walks = |row: &&Steady| row.summary.gait == GaitClass::Walking;
    let steady = study.steady.iter().filter(walks);
    steady
        .filter_map(|row| row.summary.energy_recovery)
        .reduce(f64::max)
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

/// On stairs from the greatest command on, the last one of the first run without a break.
pub(crate) fn runs_from<'a>(downwards: impl Iterator<Item = &'a Steady>) -> Option<f64> {
    let runs = |row: &&Steady| row.summary.gait == GaitClass::Running;
    downwards
        .skip_while(|row| !runs(row))
        .take_while(runs)
        .last()
        .map(|row| row.omega_v)
}

/// Froude numbers further apart than this are those of different motions.
const APART: f64 = 0.05;

/// The stairs whose motion depends on the way to them: upwards and downwards it has another speed, or falls only one way.
pub(crate) fn depends_on_the_way(study: &Study) -> Vec<f64> {
    let differ = |up: &Steady, down: &Steady| {
        if up.summary.fell || down.summary.fell {
            return up.summary.fell != down.summary.fell;
        }
        let froudes = up.summary.froude.zip(down.summary.froude);
        froudes.is_some_and(|(a, b)| (a - b).abs() > APART)
    };
    let both = study.stairs_up.iter().filter(|up| {
        let mut same = study
            .stairs_down
            .iter()
            .filter(|down| down.omega_v == up.omega_v);
        same.any(|down| differ(up, down))
    });
    both.map(|up| up.omega_v).collect()
}

/// The stairs that depend on the way, each as wide as the step between stairs.
fn hysteresis_width(study: &Study) -> Option<f64> {
    let [first, second, ..] = &study.stairs_up[..] else {
        return None;
    };
    Some(depends_on_the_way(study).len() as f64 * (second.omega_v - first.omega_v))
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
