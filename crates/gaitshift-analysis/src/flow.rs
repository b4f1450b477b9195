//! Where the energy of a motion comes from and where it goes, element by element and leg by leg.

use serde::{Deserialize, Serialize};

use crate::ratio;
use crate::recording::{Detail, Recording, Side, Window, column, detail};
use crate::support::{FootEventKind, Support};

/// Energy per step in J, right and left leg.
pub type PerLeg = [f64; 2];

/// What gives and takes energy over a window of whole strides, mean over its steps, in J per step.
///
/// A step lasts from a touchdown to the next of either foot, so two make a stride of a walk or a run. Steps are counted rather
/// than strides because a limp may land one foot more often than the other, and then its strides depend on which foot is asked.
///
/// `None` where the recording lacks the details. Sums are those of the integration steps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EnergyFlow {
    /// Steps in the window, of either foot.
    pub steps: usize,
    /// Positive work of the actuators: the integral of (8).
    pub actuators: PerLeg,
    /// Negative work of the actuators, as an amount.
    pub actuators_negative: PerLeg,
    /// Released by the springs of the wobbling legs.
    pub leg_springs: PerLeg,
    /// Released by the hip springs.
    pub hip_springs: PerLeg,
    /// Released by the actuators' end stops.
    pub stops: PerLeg,
    /// Released by the compressed ground contacts.
    pub contact: PerLeg,
    /// Lost in the hip dampers.
    pub hip_damper_loss: PerLeg,
    /// Lost in the dampers `c1`.
    pub c1_loss: PerLeg,
    /// Lost in the dampers `c2`.
    pub c2_loss: PerLeg,
    /// Lost in the end stops.
    pub stop_loss: PerLeg,
    /// Lost by the normal contact forces.
    pub normal_contact_loss: PerLeg,
    /// Lost by friction.
    pub friction_loss: PerLeg,
}

impl EnergyFlow {
    /// The flow over a window of whole strides ([`crate::steps::whole_strides`]).
    pub fn find(recording: &Recording, support: &Support, strides: Window) -> Option<Self> {
        // The touchdown at the end begins the next step, that of the other foot in the same row too.
        let steps = support
            .touchdowns(strides)
            .filter(|touchdown| touchdown.row < strides.end_row())
            .count();
        if steps == 0 {
            return None;
        }
        let per_step = |pair: [Detail; 2]| -> Option<PerLeg> {
            let [right, left] =
                pair.map(|detail| ratio(strides.detail_change(recording, detail)?, steps as f64));
            Some([right?, left?])
        };
        let actuators = per_step(detail::ACTUATOR_POSITIVE_WORK_J)?;
        let net = per_step(detail::ACTUATOR_WORK_J)?;
        Some(Self {
            steps,
            actuators,
            actuators_negative: [actuators[0] - net[0], actuators[1] - net[1]],
            leg_springs: per_step(detail::LEG_SPRING_RELEASE_J)?,
            hip_springs: per_step(detail::HIP_SPRING_RELEASE_J)?,
            stops: per_step(detail::STOP_RELEASE_J)?,
            contact: per_step(detail::CONTACT_RELEASE_J)?,
            hip_damper_loss: per_step(detail::HIP_DAMPER_DISSIPATION_J)?,
            c1_loss: per_step(detail::C1_DISSIPATION_J)?,
            c2_loss: per_step(detail::C2_DISSIPATION_J)?,
            stop_loss: per_step(detail::STOP_DISSIPATION_J)?,
            normal_contact_loss: per_step(detail::NORMAL_CONTACT_DISSIPATION_J)?,
            friction_loss: per_step(detail::FRICTION_DISSIPATION_J)?,
        })
    }

    /// What puts energy into the motion, by name, both legs.
    pub fn given(&self) -> [(&'static str, PerLeg); 1] {
        [("actuators", self.actuators)]
    }

    /// What takes energy out of it, by name, both legs: as much as is given, but for what the body and its springs hold more at
    /// the end of the window than at its beginning.
    pub fn taken(&self) -> [(&'static str, PerLeg); 7] {
        [
            ("braking actuators", self.actuators_negative),
            ("damper c1", self.c1_loss),
            ("damper c2", self.c2_loss),
            ("hip dampers", self.hip_damper_loss),
            ("end stops", self.stop_loss),
            ("ground contact", self.normal_contact_loss),
            ("friction", self.friction_loss),
        ]
    }

    /// What elastic elements took up before and give back, by name, both legs.
    pub fn returned(&self) -> [(&'static str, PerLeg); 4] {
        [
            ("leg springs", self.leg_springs),
            ("hip springs", self.hip_springs),
            ("end stops", self.stops),
            ("ground contact", self.contact),
        ]
    }
}

/// Mean over the whole stances of one leg in a window of the greatest vertical ground reaction within each, in body weights.
///
/// The greatest over integration steps, which means over a control period hide. `None` without the detail or a stance.
pub fn peak_force_body_weights(
    recording: &Recording,
    support: &Support,
    side: Side,
    window: Window,
) -> Option<f64> {
    let peaks = recording.detail(detail::PEAK_NORMAL_FORCE_N[side.index()])?;
    let weight_n = recording.metadata.total_mass_kg * recording.metadata.gravity_m_per_s2;
    let stances = support.contacts(side).iter().filter(|stance| {
        // Those that begin and end within it, and not with the recording.
        window.contains(stance.start_row())
            && window.contains(stance.end_row())
            && stance.start_row() > 0
            && stance.end_row() + 1 < recording.len()
    });
    let of_stances: Vec<f64> = stances
        .map(|stance| {
            // A row holds what happened in the period that ends there.
            let rows = stance.start_row() + 1..=stance.end_row();
            peaks[rows].iter().copied().fold(0.0, f64::max) / weight_n
        })
        .collect();
    crate::statistics::mean(&of_stances)
}

/// Share of an actuator's `∫|F| dt` over a window, both legs, in which it presses on an end stop, in [0, 1].
pub fn share_at_stop(recording: &Recording, window: Window) -> Option<f64> {
    let both = |pair: [Detail; 2]| -> Option<f64> {
        Some(window.detail_change(recording, pair[0])? + window.detail_change(recording, pair[1])?)
    };
    ratio(
        both(detail::ACTUATOR_IMPULSE_AT_STOP_N_S)?,
        both(detail::ACTUATOR_IMPULSE_N_S)?,
    )
}

/// Shares of a window's integration steps in which both feet touch the ground and in which none does, each in [0, 1].
///
/// Touching is any force at all, so that scuffs count; [`Support::fractions`] tells phases apart by the rule.
pub fn touching_shares(recording: &Recording, window: Window) -> Option<(f64, f64)> {
    let [right, left] = detail::CONTACT_SHARE.map(|detail| recording.detail(detail));
    let (right, left) = (right?, left?);
    let flight = recording.detail(detail::FLIGHT_SHARE)?;
    let rows = window.start_row() + 1..=window.end_row();
    let count = rows.clone().count() as f64;
    let sum = |series: &[f64]| series[rows.clone()].iter().sum::<f64>() / count;
    let (none, one_and_two) = (sum(flight), sum(right) + sum(left));
    // Of the steps with a foot down, right and left together count those with both twice.
    Some(((one_and_two - (1.0 - none)).max(0.0), none))
}

/// Share of the losses over a window of whole strides that falls within `within_s` after a touchdown of either foot, in [0, 1].
///
/// Impacts are over soon: how much of the losses is theirs shows here.
pub fn losses_after_touchdown(
    recording: &Recording,
    support: &Support,
    strides: Window,
    within_s: f64,
) -> Option<f64> {
    let losses = |row: usize| -> f64 {
        [
            column::DAMPER_DISSIPATION_J,
            column::CONTACT_DISSIPATION_J,
            column::STOP_DISSIPATION_J,
        ]
        .iter()
        .map(|&column| recording.column(column)[row])
        .sum()
    };
    let times = recording.column(column::TIME_S);
    let touchdowns: Vec<f64> = support
        .events()
        .iter()
        .filter(|event| event.kind == FootEventKind::Touchdown)
        .map(|event| event.time_s)
        .collect();
    let (mut soon_j, mut all_j) = (0.0, 0.0);
    let rows = strides.start_row()..strides.end_row();
    for (row, &time_s) in rows.clone().zip(&times[rows]) {
        let lost_j = losses(row + 1) - losses(row);
        all_j += lost_j;
        let next = touchdowns.partition_point(|&t| t <= time_s + 1e-9);
        let since_s = next.checked_sub(1).map(|last| time_s - touchdowns[last]);
        if since_s.is_some_and(|since_s| since_s < within_s - 1e-9) {
            soon_j += lost_j;
        }
    }
    ratio(soon_j, all_j)
}
