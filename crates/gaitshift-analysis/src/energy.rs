//! How the energies of the body move relative to each other: in walking kinetic and gravitational
//! energy are exchanged as in a pendulum, in running both are exchanged with springs.

use crate::ratio;
use crate::recording::{Column, Recording, Window, column};
use crate::statistics::correlation;
use crate::support::Support;

/// Correlation of two columns over all rows of a window, in [-1, 1]; `None` if one does not vary.
pub fn correlation_over(
    recording: &Recording,
    window: Window,
    first: Column,
    second: Column,
) -> Option<f64> {
    let rows = window.start_row()..=window.end_row();
    correlation(
        &recording.column(first)[rows.clone()],
        &recording.column(second)[rows],
    )
}

/// Correlation of two columns over all rows in single support, in [-1, 1]; `None` if one does not vary
/// or no single support begins and ends within the window.
///
/// Phases cut by the window's ends are left out, so that a foot on which the body merely stands does
/// not count as stepping.
pub fn correlation_in_single_support(
    recording: &Recording,
    support: &Support,
    window: Window,
    first: Column,
    second: Column,
) -> Option<f64> {
    let (mut first_values, mut second_values) = (Vec::new(), Vec::new());
    let whole_single_supports = support.phases().iter().filter(|interval| {
        interval.phase.is_single()
            && interval.window.start_row() > 0
            && interval.window.end_row() + 1 < recording.len()
            && window.contains(interval.window.start_row())
            && window.contains(interval.window.end_row())
    });
    for interval in whole_single_supports {
        let rows = interval.window.start_row()..=interval.window.end_row();
        first_values.extend_from_slice(&recording.column(first)[rows.clone()]);
        second_values.extend_from_slice(&recording.column(second)[rows]);
    }
    correlation(&first_values, &second_values)
}

/// Pendular energy recovery, in [0, 1]: `1 - W / (W_k + W_p)`, where `W_k`, `W_p` and `W` are the sums
/// of the increments of kinetic energy, of gravitational energy and of their sum over the window.
///
/// After Cavagna, Thys and Zamboni (1976), who take the kinetic energy of the centre of mass; here it is
/// that of all segments. 1 is a perfect pendulum, 0 no exchange at all. The window should hold whole
/// strides. `None` if neither energy ever rises.
pub fn energy_recovery(recording: &Recording, window: Window) -> Option<f64> {
    let kinetic = recording.column(column::KINETIC_ENERGY_J);
    let gravitational = recording.column(column::GRAVITATIONAL_ENERGY_J);
    let (mut kinetic_j, mut gravitational_j, mut total_j) = (0.0, 0.0, 0.0);
    for row in window.start_row()..window.end_row() {
        let kinetic_change = kinetic[row + 1] - kinetic[row];
        let gravitational_change = gravitational[row + 1] - gravitational[row];
        kinetic_j += kinetic_change.max(0.0);
        gravitational_j += gravitational_change.max(0.0);
        total_j += (kinetic_change + gravitational_change).max(0.0);
    }
    let separate_j = kinetic_j + gravitational_j;
    ratio(separate_j - total_j, separate_j).map(|recovery| recovery.clamp(0.0, 1.0))
}
