//! All figures of a steady motion at once: a row of the tables, a line of the program's JSON.

use serde::{Deserialize, Serialize};

use crate::cost::{
    absolute_cost_of_transport, classic_froude_number, cost_of_transport, froude_number,
    squared_force_n2_s_per_m,
};
use crate::energy::{correlation_in_single_support, correlation_over, energy_recovery};
use crate::feet::{Rubbing, clearance_m};
use crate::flow::{
    EnergyFlow, losses_after_touchdown, peak_force_body_weights, share_at_stop, touching_shares,
};
use crate::gait::{GaitClass, GaitEvidence, GaitRule};
use crate::recording::{Column, Recording, Side, Window, column, ended_by};
use crate::steadiness::{HipPhase, StepVariation};
use crate::steps::{LegTiming, Step, step_frequency_hz, step_length_m, whole_strides};
use crate::support::Support;

/// How to judge a recording.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AnalysisOptions {
    /// Time at the beginning that is left out, s. Default 5 s.
    ///
    /// From a recording shorter than twice this time, its first half is left out instead.
    pub settling_time_s: f64,
    /// What counts as contact, walking and running.
    pub rule: GaitRule,
}

impl Default for AnalysisOptions {
    fn default() -> Self {
        Self {
            settling_time_s: 5.0,
            rule: GaitRule::default(),
        }
    }
}

/// What a motion is, in figures. All but `survived_s`, `fell` and `ended_by` describe the window from
/// `window_start_s` to `window_end_s`; `None` (null in JSON) stands for what is undefined there, which by default is all of it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct GaitSummary {
    /// How long the whole recording lasts, s.
    pub survived_s: f64,
    /// Whether the body fell.
    pub fell: bool,
    /// Why the motion ended, in the recording's words.
    pub ended_by: String,
    /// Time at which the described window begins, s.
    pub window_start_s: Option<f64>,
    /// Time at which the described window ends, s.
    pub window_end_s: Option<f64>,
    /// What the motion is.
    pub gait: GaitClass,
    /// Mean forward speed of the hip, m/s.
    pub speed_m_per_s: Option<f64>,
    /// Froude number of the paper, `v / √(g l)`.
    pub froude: Option<f64>,
    /// Froude number of Alexander, `v² / (g l)`.
    pub classic_froude: Option<f64>,
    /// Share of time with both feet on the ground, in [0, 1].
    pub double_support: Option<f64>,
    /// Share of time with one foot on the ground, in [0, 1].
    pub single_support: Option<f64>,
    /// Share of time with no foot on the ground, in [0, 1].
    pub flight: Option<f64>,
    /// Cost of transport (8).
    pub cost_of_transport: Option<f64>,
    /// Cost of transport with negative work added as an amount.
    pub absolute_cost_of_transport: Option<f64>,
    /// `∫F² dt` of both actuators per metre, N² s/m.
    pub squared_force_n2_s_per_m: Option<f64>,
    /// Share of the actuators' `∫|F| dt` that presses on an end stop, in [0, 1].
    pub force_share_at_stops: Option<f64>,
    /// Steps (not strides) per second, Hz.
    pub step_frequency_hz: Option<f64>,
    /// Way of the hip per step, m.
    pub step_length_m: Option<f64>,
    /// Share of the right leg's stride on the ground, in [0, 1].
    pub duty_factor_right: Option<f64>,
    /// Share of the left leg's stride on the ground, in [0, 1].
    pub duty_factor_left: Option<f64>,
    /// Mean time on the ground per stride of the right leg, s.
    pub stance_time_right_s: Option<f64>,
    /// Mean time on the ground per stride of the left leg, s.
    pub stance_time_left_s: Option<f64>,
    /// Mean time off the ground per stride of the right leg, s.
    pub swing_time_right_s: Option<f64>,
    /// Mean time off the ground per stride of the left leg, s.
    pub swing_time_left_s: Option<f64>,
    /// Limping index: difference of the right and left step times over their mean, in [0, 2].
    pub step_time_asymmetry: Option<f64>,
    /// How far feet on the ground slide, relative to the hip's way.
    pub foot_slide: Option<f64>,
    /// Contacts of a swinging foot too short to count as stances, per step.
    pub scuffs_per_step: Option<f64>,
    /// Height of the right sole's lowest point as the leg swings past the other one, mean, m.
    pub clearance_right_m: Option<f64>,
    /// The same of the left leg.
    pub clearance_left_m: Option<f64>,
    /// Work of friction of feet in stance per metre, J/m.
    pub slip_work_j_per_m: Option<f64>,
    /// Work of friction of feet between stances per metre, J/m.
    pub drag_work_j_per_m: Option<f64>,
    /// Standard deviation of the time of the steps onto the right foot over its mean.
    pub step_time_variation_right: Option<f64>,
    /// The same of the steps onto the left foot.
    pub step_time_variation_left: Option<f64>,
    /// Standard deviation of the length of the steps onto the right foot over its mean.
    pub step_length_variation_right: Option<f64>,
    /// The same of the steps onto the left foot.
    pub step_length_variation_left: Option<f64>,
    /// Phase of the left hip angle relative to the right one, circular mean over strides, rad: π where legs alternate evenly, 0 in
    /// a hop.
    pub hip_phase_rad: Option<f64>,
    /// Circular standard deviation of that phase from stride to stride, rad.
    pub hip_phase_deviation_rad: Option<f64>,
    /// Number of whole steps.
    pub steps: usize,
    /// Share of steps onto the other foot than the one before, in [0, 1].
    pub steps_alternating: Option<f64>,
    /// Share of steps with double support, in [0, 1].
    pub steps_with_double_support: Option<f64>,
    /// Share of steps with flight, in [0, 1].
    pub steps_with_flight: Option<f64>,
    /// Correlation of kinetic with gravitational energy over whole strides, in [-1, 1].
    pub kinetic_potential_correlation: Option<f64>,
    /// Correlation of kinetic with gravitational energy in single support, in [-1, 1].
    pub kinetic_potential_correlation_single_support: Option<f64>,
    /// Correlation of elastic with kinetic energy in single support, in [-1, 1].
    pub elastic_kinetic_correlation_single_support: Option<f64>,
    /// Correlation of elastic with gravitational energy in single support, in [-1, 1].
    pub elastic_potential_correlation_single_support: Option<f64>,
    /// Correlation of the leg springs' energy with kinetic energy in single support, in [-1, 1].
    pub leg_spring_kinetic_correlation_single_support: Option<f64>,
    /// Correlation of the leg springs' energy with gravitational energy in single support, in [-1, 1].
    pub leg_spring_potential_correlation_single_support: Option<f64>,
    /// Correlation of the hip springs' energy with kinetic energy in single support, in [-1, 1].
    pub hip_spring_kinetic_correlation_single_support: Option<f64>,
    /// Correlation of the hip springs' energy with gravitational energy in single support, in [-1, 1].
    pub hip_spring_potential_correlation_single_support: Option<f64>,
    /// Pendular energy recovery of the centre of mass after Cavagna over whole strides, in [0, 1].
    pub energy_recovery: Option<f64>,
    /// Greatest vertical ground reaction of a stance, mean over the right leg's stances, in body weights.
    pub peak_force_right_body_weights: Option<f64>,
    /// The same of the left leg.
    pub peak_force_left_body_weights: Option<f64>,
    /// Share of the integration steps in which both feet touch the ground, however lightly, in [0, 1].
    pub both_feet_touching: Option<f64>,
    /// Share of the integration steps in which no foot touches the ground, in [0, 1].
    pub no_foot_touching: Option<f64>,
    /// Share of the losses within 50 ms after a touchdown, in [0, 1].
    pub losses_soon_after_touchdown: Option<f64>,
    /// Work and losses by element and leg, J per step.
    pub energy_per_step: Option<EnergyFlow>,
}

/// How long after a touchdown a loss counts as the impact's, s.
const SOON_AFTER_TOUCHDOWN_S: f64 = 0.05;

/// Describes a recording after its settling time. Works for every recording, even an empty one.
pub fn summarise(recording: &Recording, options: &AnalysisOptions) -> GaitSummary {
    let support = Support::find(recording, &options.rule.contact);
    let window = recording
        .column(column::TIME_S)
        .first()
        .and_then(|&first_s| {
            let last_s = first_s + recording.duration_s();
            let settled_s =
                first_s + settling_time_s(options.settling_time_s, recording.duration_s());
            recording.window(settled_s, last_s)
        });
    let mut summary = summarise_window(recording, &support, window, &options.rule);
    if has_fallen(recording) {
        summary.gait = GaitClass::Fallen;
    }
    summary
}

/// The wanted settling time, or half of the time there is if that is less.
pub(crate) fn settling_time_s(wanted_s: f64, available_s: f64) -> f64 {
    wanted_s.max(0.0).min(0.5 * available_s)
}

/// Whether the motion ended in a fall or diverged.
pub(crate) fn has_fallen(recording: &Recording) -> bool {
    recording.metadata.fell || recording.metadata.ended_by == ended_by::DIVERGED
}

/// Describes one window, whatever became of the body after it: `gait` is never [`GaitClass::Fallen`].
///
/// `support` must be that of the recording. Without a window, all that describes it is undefined and the
/// gait is [`GaitClass::Mixed`].
pub fn summarise_window(
    recording: &Recording,
    support: &Support,
    window: Option<Window>,
    rule: &GaitRule,
) -> GaitSummary {
    let evidence = window.map(|window| GaitEvidence::gather(recording, support, window));
    let evidence = evidence.as_ref();
    let strides = window.and_then(|window| whole_strides(support, window));
    let times = recording.column(column::TIME_S);

    let speed_m_per_s = evidence.and_then(|evidence| evidence.speed_m_per_s);
    let fractions = evidence.and_then(|evidence| evidence.support);
    let [right, left] = Side::BOTH
        .map(|side| window.and_then(|window| LegTiming::find(recording, support, side, window)));
    let steps: &[Step] = evidence.map_or(&[], |evidence| &evidence.steps);
    let share_of_steps = |wanted: &dyn Fn(&Step) -> bool| {
        evidence.and_then(|evidence| evidence.share_of_steps(wanted))
    };
    let in_single_support = |first: Column, second: Column| {
        window.and_then(|window| {
            correlation_in_single_support(recording, support, window, first, second)
        })
    };
    let (kinetic, potential, elastic) = (
        column::KINETIC_ENERGY_J,
        column::GRAVITATIONAL_ENERGY_J,
        column::ELASTIC_ENERGY_J,
    );
    let (leg_springs, hip_springs) = (column::LEG_SPRING_ENERGY_J, column::HIP_SPRING_ENERGY_J);
    let [peak_right, peak_left] = Side::BOTH.map(|side| {
        window.and_then(|window| peak_force_body_weights(recording, support, side, window))
    });
    let touching = window.and_then(|window| touching_shares(recording, window));
    let [clearance_right, clearance_left] = Side::BOTH
        .map(|side| window.and_then(|window| clearance_m(recording, support, side, window)));
    let rubbing = window.and_then(|window| Rubbing::find(recording, support, window));
    let [variation_right, variation_left] =
        Side::BOTH.map(|side| StepVariation::find(recording, steps, side));
    let hip_phase = window.and_then(|window| HipPhase::find(recording, window));

    GaitSummary {
        survived_s: recording.duration_s(),
        fell: recording.metadata.fell,
        ended_by: recording.metadata.ended_by.clone(),
        window_start_s: window.map(|window| times[window.start_row()]),
        window_end_s: window.map(|window| times[window.end_row()]),
        gait: evidence.map_or(GaitClass::Mixed, |evidence| evidence.classify(rule)),
        speed_m_per_s,
        froude: speed_m_per_s.and_then(|speed| froude_number(recording, speed)),
        classic_froude: speed_m_per_s.and_then(|speed| classic_froude_number(recording, speed)),
        double_support: fractions.map(|fractions| fractions.double_support),
        single_support: fractions.map(|fractions| fractions.single_support),
        flight: fractions.map(|fractions| fractions.flight),
        cost_of_transport: window.and_then(|window| cost_of_transport(recording, window)),
        absolute_cost_of_transport: window
            .and_then(|window| absolute_cost_of_transport(recording, window)),
        squared_force_n2_s_per_m: window
            .and_then(|window| squared_force_n2_s_per_m(recording, window)),
        force_share_at_stops: window.and_then(|window| share_at_stop(recording, window)),
        step_frequency_hz: step_frequency_hz(steps),
        step_length_m: step_length_m(steps),
        duty_factor_right: right.map(|leg| leg.duty_factor),
        duty_factor_left: left.map(|leg| leg.duty_factor),
        stance_time_right_s: right.map(|leg| leg.stance_s),
        stance_time_left_s: left.map(|leg| leg.stance_s),
        swing_time_right_s: right.map(|leg| leg.swing_s),
        swing_time_left_s: left.map(|leg| leg.swing_s),
        step_time_asymmetry: evidence.and_then(|evidence| evidence.step_time_asymmetry),
        foot_slide: evidence.and_then(|evidence| evidence.foot_slide),
        scuffs_per_step: window.and_then(|window| scuffs_per_step(support, window, steps.len())),
        clearance_right_m: clearance_right,
        clearance_left_m: clearance_left,
        slip_work_j_per_m: rubbing.map(|rubbing| rubbing.slip_j_per_m),
        drag_work_j_per_m: rubbing.map(|rubbing| rubbing.drag_j_per_m),
        step_time_variation_right: variation_right.time,
        step_time_variation_left: variation_left.time,
        step_length_variation_right: variation_right.length,
        step_length_variation_left: variation_left.length,
        hip_phase_rad: hip_phase.map(|phase| phase.mean_rad),
        hip_phase_deviation_rad: hip_phase.map(|phase| phase.deviation_rad),
        steps: steps.len(),
        steps_alternating: share_of_steps(&Step::alternates),
        steps_with_double_support: share_of_steps(&|step| rule.has_double_support(step)),
        steps_with_flight: share_of_steps(&|step| rule.has_flight(step)),
        kinetic_potential_correlation: strides
            .and_then(|strides| correlation_over(recording, strides, kinetic, potential)),
        kinetic_potential_correlation_single_support: in_single_support(kinetic, potential),
        elastic_kinetic_correlation_single_support: in_single_support(elastic, kinetic),
        elastic_potential_correlation_single_support: in_single_support(elastic, potential),
        leg_spring_kinetic_correlation_single_support: in_single_support(leg_springs, kinetic),
        leg_spring_potential_correlation_single_support: in_single_support(leg_springs, potential),
        hip_spring_kinetic_correlation_single_support: in_single_support(hip_springs, kinetic),
        hip_spring_potential_correlation_single_support: in_single_support(hip_springs, potential),
        energy_recovery: strides.and_then(|strides| energy_recovery(recording, strides)),
        peak_force_right_body_weights: peak_right,
        peak_force_left_body_weights: peak_left,
        both_feet_touching: touching.map(|(both, _)| both),
        no_foot_touching: touching.map(|(_, none)| none),
        losses_soon_after_touchdown: strides.and_then(|strides| {
            losses_after_touchdown(recording, support, strides, SOON_AFTER_TOUCHDOWN_S)
        }),
        energy_per_step: strides.and_then(|strides| EnergyFlow::find(recording, support, strides)),
    }
}

fn scuffs_per_step(support: &Support, window: Window, steps: usize) -> Option<f64> {
    let scuffs = Side::BOTH
        .iter()
        .flat_map(|&side| support.scuffs(side))
        .filter(|scuff| window.contains(scuff.start_row()))
        .count();
    (steps > 0).then(|| scuffs as f64 / steps as f64)
}
