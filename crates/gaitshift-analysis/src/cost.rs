//! What moving costs and how fast it is for the body's size.

use crate::finite;
use crate::ratio;
use crate::recording::{Recording, Window, column, detail};

/// A cost of transport needs at least this way, in leg lengths: per metre of nothing it is meaningless.
pub const MIN_WAY_LEG_LENGTHS: f64 = 0.1;

/// Cost of transport (8) of the paper over a window: positive actuator work of both legs over
/// `m g Δd`, dimensionless.
///
/// `None` unless the hip advances by [`MIN_WAY_LEG_LENGTHS`].
pub fn cost_of_transport(recording: &Recording, window: Window) -> Option<f64> {
    let work_j = window.change(recording, column::ACTUATOR_POSITIVE_WORK_J);
    ratio(work_j, weight_times_way_j(recording, window)?)
}

/// The cost of transport with negative work added as an amount, `Σ ∫|F ḣ| dt / (m g Δd)`, dimensionless: what actuators
/// cost that cannot take work back.
///
/// `None` where [`cost_of_transport`] is.
pub fn absolute_cost_of_transport(recording: &Recording, window: Window) -> Option<f64> {
    let positive_j = window.change(recording, column::ACTUATOR_POSITIVE_WORK_J);
    let net_j = window.change(recording, column::ACTUATOR_WORK_J);
    let negative_j = positive_j - net_j;
    ratio(
        positive_j + negative_j,
        weight_times_way_j(recording, window)?,
    )
}

/// `Σ ∫F² dt / Δd` of both actuators, in N² s/m: what force costs even where nothing moves, as in a motor's windings.
///
/// `None` where [`cost_of_transport`] is, and if the recording lacks the detail.
pub fn squared_force_n2_s_per_m(recording: &Recording, window: Window) -> Option<f64> {
    weight_times_way_j(recording, window)?;
    let [right, left] = detail::ACTUATOR_SQUARED_FORCE_N2_S;
    let both = window.detail_change(recording, right)? + window.detail_change(recording, left)?;
    ratio(both, window.change(recording, column::X_M))
}

/// `m g Δd`, if the hip advances far enough.
fn weight_times_way_j(recording: &Recording, window: Window) -> Option<f64> {
    let metadata = &recording.metadata;
    Some(metadata.total_mass_kg * metadata.gravity_m_per_s2 * way_m(recording, window)?)
}

/// The hip's way forward, m, if it is far enough.
pub(crate) fn way_m(recording: &Recording, window: Window) -> Option<f64> {
    let way_m = window.change(recording, column::X_M);
    (way_m >= MIN_WAY_LEG_LENGTHS * recording.metadata.leg_length_m).then_some(way_m)
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
