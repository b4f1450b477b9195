//! Steps: from one touchdown to the next, whichever foot it is.

use serde::Serialize;

use crate::recording::{Recording, Side, Window, column};
use crate::statistics::mean;
use crate::support::{FootEvent, Support, SupportPhase};
use crate::{finite, ratio};

/// One step: the stretch from a touchdown to the next touchdown of either foot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// The foot whose touchdown begins the step.
    pub from: Side,
    /// The foot whose touchdown ends the step.
    pub to: Side,
    /// Row of the first touchdown.
    pub start_row: usize,
    /// Row of the second touchdown; equal to `start_row` if both feet land at once.
    pub end_row: usize,
    /// Time of the first touchdown, s.
    pub start_s: f64,
    /// Time between the touchdowns, s.
    pub duration_s: f64,
    /// Way of the hip between the touchdowns, m.
    pub length_m: f64,
    /// Control periods of the step with both feet on the ground.
    pub double_support_periods: usize,
    /// Control periods of the step with no foot on the ground.
    pub flight_periods: usize,
}

impl Step {
    /// Whether the other foot lands than the one that landed before.
    pub fn alternates(&self) -> bool {
        self.from != self.to
    }
}

/// The steps that begin and end within the window, in the order of time.
pub fn find_steps(recording: &Recording, support: &Support, window: Window) -> Vec<Step> {
    let touchdowns: Vec<&FootEvent> = support.touchdowns(window).collect();
    let x_m = recording.column(column::X_M);
    let periods = |step: Option<Window>, phase| {
        step.map_or(0, |step| {
            support.periods(step, |candidate| candidate == phase)
        })
    };
    touchdowns
        .windows(2)
        .map(|pair| {
            let (first, second) = (pair[0], pair[1]);
            let rows = Window::new(first.row, second.row);
            Step {
                from: first.side,
                to: second.side,
                start_row: first.row,
                end_row: second.row,
                start_s: first.time_s,
                duration_s: second.time_s - first.time_s,
                length_m: x_m[second.row] - x_m[first.row],
                double_support_periods: periods(rows, SupportPhase::Double),
                flight_periods: periods(rows, SupportPhase::Flight),
            }
        })
        .collect()
}

/// The longest run of whole strides in a window: from its first touchdown to the last touchdown of the
/// same foot. `None` without a whole stride.
///
/// Averages over whole strides do not depend on the phase of the stride in which the window begins.
pub fn whole_strides(support: &Support, window: Window) -> Option<Window> {
    let of = |side| {
        let mut own = support.touchdowns(window).filter(|t| t.side == side);
        let first = own.next()?;
        Window::new(first.row, own.last()?.row)
    };
    let first = support.touchdowns(window).next()?.side;
    // Who lands on one foot alone from then on has strides, too.
    of(first).or_else(|| of(first.other()))
}

/// Times of one leg, means over its whole strides (from its first touchdown in a window to its last).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LegTiming {
    /// Time on the ground per stride, s.
    pub stance_s: f64,
    /// Time off the ground per stride, s.
    pub swing_s: f64,
    /// Share of the stride on the ground, in [0, 1].
    pub duty_factor: f64,
}

impl LegTiming {
    /// `None` without a whole stride of this leg in the window.
    pub fn find(
        recording: &Recording,
        support: &Support,
        side: Side,
        window: Window,
    ) -> Option<Self> {
        let mut rows = support
            .touchdowns(window)
            .filter(|touchdown| touchdown.side == side)
            .map(|touchdown| touchdown.row);
        let first = rows.next()?;
        let (strides, last) = rows.fold((0, first), |(strides, _), row| (strides + 1, row));
        let strides_window = Window::new(first, last)?;
        let strides = f64::from(strides);
        let duration_s = strides_window.duration_s(recording);
        let stance_s: f64 = support
            .contacts(side)
            .iter()
            .filter_map(|contact| contact.intersection(strides_window))
            .map(|contact| contact.duration_s(recording))
            .sum();
        Some(Self {
            stance_s: finite(stance_s / strides)?,
            swing_s: finite((duration_s - stance_s) / strides)?,
            duty_factor: ratio(stance_s, duration_s)?,
        })
    }
}

/// Steps per second: the number of steps over the time they take, Hz.
pub fn step_frequency_hz(steps: &[Step]) -> Option<f64> {
    ratio(steps.len() as f64, total_duration_s(steps))
}

/// Mean way of the hip per step, m.
pub fn step_length_m(steps: &[Step]) -> Option<f64> {
    mean(&steps.iter().map(|step| step.length_m).collect::<Vec<_>>())
}

/// Mean duration of the steps that end with the touchdown of that foot, s.
pub fn step_time_s(steps: &[Step], side: Side) -> Option<f64> {
    let times: Vec<f64> = steps
        .iter()
        .filter(|step| step.to == side)
        .map(|step| step.duration_s)
        .collect();
    mean(&times)
}

/// Limping index: `|T_r - T_l| / ((T_r + T_l) / 2)` of the mean step times right and left, in [0, 2].
///
/// The symmetry index of Robinson et al. (1987) as a fraction; 0 is an even gait. `None` unless both
/// feet step.
pub fn step_time_asymmetry(steps: &[Step]) -> Option<f64> {
    let right_s = step_time_s(steps, Side::Right)?;
    let left_s = step_time_s(steps, Side::Left)?;
    ratio((right_s - left_s).abs(), 0.5 * (right_s + left_s))
}

/// How far feet in contact slide, relative to the way of the hip meanwhile: near 0 for feet that stand
/// or roll, 1 for skates.
///
/// The sole's point on the leg's axis, `x + (l + h - d) sin psi`, stays within millimetres while a
/// curved foot rolls without slipping; its way over each contact, summed, is divided by the summed way
/// of the hip. `None` if the hip makes no way.
pub fn foot_slide(recording: &Recording, support: &Support, window: Window) -> Option<f64> {
    let x_m = recording.column(column::X_M);
    let theta = recording.column(column::THETA_RAD);
    let (mut slide_m, mut way_m) = (0.0, 0.0);
    for side in Side::BOTH {
        let phi = recording.column(column::PHI_RAD[side.index()]);
        let h_m = recording.column(column::H_M[side.index()]);
        let d_m = recording.column(column::D_M[side.index()]);
        let sole_m = |row: usize| {
            let length_m = recording.metadata.leg_length_m + h_m[row] - d_m[row];
            x_m[row] + length_m * (theta[row] + phi[row]).sin()
        };
        let contacts = support.contacts(side).iter();
        for contact in contacts.filter_map(|contact| contact.intersection(window)) {
            let (start, end) = (contact.start_row(), contact.end_row());
            slide_m += (sole_m(end) - sole_m(start)).abs();
            way_m += (x_m[end] - x_m[start]).abs();
        }
    }
    ratio(slide_m, way_m)
}

fn total_duration_s(steps: &[Step]) -> f64 {
    steps.iter().map(|step| step.duration_s).sum()
}
