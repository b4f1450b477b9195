//! How the energies of the body move relative to each other: in walking kinetic and gravitational
//! energy are exchanged as in a pendulum, in running both are exchanged with springs.

use crate::ratio;
use crate::recording::{Column, Recording, Side, Window, detail};
use crate::statistics::correlation;
use crate::support::{Support, SupportPhase};

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
/// not count as stepping. The rows of a contact's two ends are left out, too: a foot lands within the control period after the
/// first of them and lifts off within the period before the last, so that it is off the ground in both. Where the share of
/// contact within the period tells that it touched for all of it, the row counts.
pub fn correlation_in_single_support(
    recording: &Recording,
    support: &Support,
    window: Window,
    first: Column,
    second: Column,
) -> Option<f64> {
    let (mut first_values, mut second_values) = (Vec::new(), Vec::new());
    let whole_single_supports = support.phases().iter().filter_map(|interval| {
        let side = match interval.phase {
            SupportPhase::SingleRight => Side::Right,
            SupportPhase::SingleLeft => Side::Left,
            SupportPhase::Double | SupportPhase::Flight => return None,
        };
        let (start, end) = (interval.window.start_row(), interval.window.end_row());
        let whole = start > 0
            && end + 1 < recording.len()
            && window.contains(start)
            && window.contains(end);
        let contacts = support.contacts(side);
        // The period after a row, and the one before it, end with the rows of their shares.
        let shares = recording.detail(detail::CONTACT_SHARE[side.index()]);
        let in_part = |row: usize| shares.is_none_or(|shares| shares[row] < 1.0);
        let lands =
            contacts.iter().any(|contact| contact.start_row() == start) && in_part(start + 1);
        let lifts = contacts.iter().any(|contact| contact.end_row() == end) && in_part(end);
        whole.then(|| start + usize::from(lands)..=end - usize::from(lifts))
    });
    for rows in whole_single_supports.filter(|rows| !rows.is_empty()) {
        first_values.extend_from_slice(&recording.column(first)[rows.clone()]);
        second_values.extend_from_slice(&recording.column(second)[rows]);
    }
    correlation(&first_values, &second_values)
}

/// Pendular energy recovery, in [0, 1], after Cavagna, Thys and Zamboni (J. Physiol. 262, 1976):
/// `(W_f + W_v - W_ext) / (W_f + W_v)`.
///
/// `W_f`, `W_v` and `W_ext` are the sums over the window of the rises of three energies of the centre of mass: of its forward
/// motion, `½ m ẋ²`; of its height and vertical motion, `m g z + ½ m ż²`; and of both together. 1 is a perfect
/// pendulum, 0 no exchange at all. Rises are those from row to row: what the two trade within a millisecond of a touchdown and
/// trade back does not count, as it does not on a force plate whose signal is smoothed. The window should hold whole strides. `None` if neither energy ever rises, or if the
/// recording does not tell the centre of mass.
pub fn energy_recovery(recording: &Recording, window: Window) -> Option<f64> {
    let (mass, gravity) = (
        recording.metadata.total_mass_kg,
        recording.metadata.gravity_m_per_s2,
    );
    let height = recording.detail(detail::COM_Z_M)?;
    let forward = recording.detail(detail::COM_X_VELOCITY_M_PER_S)?;
    let upward = recording.detail(detail::COM_Z_VELOCITY_M_PER_S)?;
    let energies = |row: usize| {
        (
            0.5 * mass * forward[row] * forward[row],
            mass * (gravity * height[row] + 0.5 * upward[row] * upward[row]),
        )
    };
    let (mut forward_j, mut vertical_j, mut external_j) = (0.0, 0.0, 0.0);
    for row in window.start_row()..window.end_row() {
        let (before, after) = (energies(row), energies(row + 1));
        let (forward_change, vertical_change) = (after.0 - before.0, after.1 - before.1);
        forward_j += forward_change.max(0.0);
        vertical_j += vertical_change.max(0.0);
        external_j += (forward_change + vertical_change).max(0.0);
    }
    let separate_j = forward_j + vertical_j;
    ratio(separate_j - external_j, separate_j).map(|recovery| recovery.clamp(0.0, 1.0))
}
