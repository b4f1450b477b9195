//! What moving costs and how fast it is for the body's size.

use crate::finite;
use crate::ratio;
use crate::recording::{Recording, Window, column};

/// A cost of transport needs at least this way, in leg lengths: per metre of nothing it is meaningless.
pub const MIN_WAY_LEG_LENGTHS: f64 = 0.1;

/// Cost of transport (8) of the paper over a window: positive actuator work of both legs over
/// `m g Δd`, dimensionless.
///
/// `None` unless the hip advances by [`MIN_WAY_LEG_LENGTHS`].
pub fn cost_of_transport(recording: &Recording, window: Window) -> Option<f64> {
    let metadata = &recording.metadata;
    let way_m = window.change(recording, column::X_M);
    if way_m < MIN_WAY_LEG_LENGTHS * metadata.leg_length_m {
        return None;
    }
    let work_j = window.change(recording, column::ACTUATOR_POSITIVE_WORK_J);
    ratio(
        work_j,
        metadata.total_mass_kg * metadata.gravity_m_per_s2 * way_m,
    )
}

/// Mean forward speed of the hip over a window, m/s.
pub fn speed_m_per_s(recording: &Recording, window: Window) -> Option<f64> {
    ratio(
        window.change(recording, column::X_M),
        window.duration_s(recording),
    )
}

/// Froude number as the paper uses it, `v / √(g l)`, dimensionless; it has the sign of the speed.
pub fn froude_number(recording: &Recording, speed_m_per_s: f64) -> Option<f64> {
    let metadata = &recording.metadata;
    ratio(
        speed_m_per_s,
        (metadata.gravity_m_per_s2 * metadata.leg_length_m).sqrt(),
    )
}

/// Froude number as Alexander uses it, `v² / (g l)`: the square of [`froude_number`].
pub fn classic_froude_number(recording: &Recording, speed_m_per_s: f64) -> Option<f64> {
    froude_number(recording, speed_m_per_s).and_then(|froude| finite(froude * froude))
}
