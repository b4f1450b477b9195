//! The details that a recording may have beside its columns: centre of mass, forces within a control period, work and
//! losses by element and leg.

use std::fmt;

/// A detail of a recording; the constants in [`mod@detail`] are all there are.
///
/// Not every simulator can tell them, and recordings of before have none: [`Recording::detail`](super::Recording::detail) is
/// `None` then, and so is what an analysis makes of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Detail(usize);

impl Detail {
    /// The name in the file's header.
    pub fn name(self) -> &'static str {
        DETAILS[self.0]
    }

    /// Position among the details of a row.
    pub fn index(self) -> usize {
        self.0
    }

    /// The detail of that name, if there is one.
    pub fn named(name: &str) -> Option<Detail> {
        DETAILS.iter().position(|&known| known == name).map(Detail)
    }
}

impl fmt::Display for Detail {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

/// Writes the list of details once: those of the body, then the pairs of right and left.
macro_rules! details {
    ({$($constant:ident $name:literal $doc:literal;)*} $($pair:ident $right:ident $right_name:literal $left:ident $left_name:literal $pair_doc:literal;)*) => {
        /// Names of all details, in the order in which they follow the columns of a row.
        pub const DETAILS: &[&str] = &[$($name,)* $($right_name, $left_name),*];

        #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
        enum Position { $($constant,)* $($right, $left),* }

        /// The details of a recording. Pairs are right and left, indexed by
        /// [`Side::index`](super::super::Side::index).
        ///
        /// Work, releases and losses are sums since the first row, taken at every integration step. A release is
        /// what an elastic element gives back: the sum of the falls of its energy.
        pub mod detail {
            use super::{Detail, Position};
            $(#[doc = $doc] pub const $constant: Detail = Detail(Position::$constant as usize);)*
            $(#[doc = $pair_doc] pub const $pair: [Detail; 2] = [Detail(Position::$right as usize), Detail(Position::$left as usize)];)*
        }
    };
}

details! {
    {
    COM_X_M "com_x_m" "Forward position of the centre of mass, m.";
    COM_Z_M "com_z_m" "Height of the centre of mass, m.";
    COM_X_VELOCITY_M_PER_S "com_x_velocity_m_per_s" "Forward velocity of the centre of mass, m/s.";
    COM_Z_VELOCITY_M_PER_S "com_z_velocity_m_per_s" "Upward velocity of the centre of mass, m/s.";
    FLIGHT_SHARE "flight_share" "Share of the period's integration steps in which no foot touches the ground, in [0, 1].";
    }
    PEAK_NORMAL_FORCE_N RIGHT_PEAK "right_peak_normal_force_n" LEFT_PEAK "left_peak_normal_force_n" "Greatest vertical ground reaction within the period, N.";
    SOLE_HEIGHT_M RIGHT_SOLE "right_sole_height_m" LEFT_SOLE "left_sole_height_m" "Height of the sole's lowest point over the ground, m; negative where it is pressed in.";
    CONTACT_SHARE RIGHT_SHARE "right_contact_share" LEFT_SHARE "left_contact_share" "Share of the period's integration steps in which the foot touches the ground, in [0, 1].";
    ACTUATOR_WORK_J RIGHT_WORK "right_actuator_work_j" LEFT_WORK "left_actuator_work_j" "Work of the actuator, J.";
    ACTUATOR_POSITIVE_WORK_J RIGHT_POSITIVE "right_actuator_positive_work_j" LEFT_POSITIVE "left_actuator_positive_work_j" "Positive work of the actuator, J.";
    ACTUATOR_SQUARED_FORCE_N2_S RIGHT_SQUARED "right_actuator_squared_force_n2_s" LEFT_SQUARED "left_actuator_squared_force_n2_s" "Integral of the squared actuator force, N² s.";
    ACTUATOR_IMPULSE_N_S RIGHT_IMPULSE "right_actuator_impulse_n_s" LEFT_IMPULSE "left_actuator_impulse_n_s" "Integral of the amount of the actuator force, N s.";
    ACTUATOR_IMPULSE_AT_STOP_N_S RIGHT_AT_STOP "right_actuator_impulse_at_stop_n_s" LEFT_AT_STOP "left_actuator_impulse_at_stop_n_s" "The part of that integral in which the actuator presses on an end stop, N s.";
    LEG_SPRING_RELEASE_J RIGHT_LEG_RELEASE "right_leg_spring_release_j" LEFT_LEG_RELEASE "left_leg_spring_release_j" "Released by the springs of the wobbling leg, taken as one, J.";
    HIP_SPRING_RELEASE_J RIGHT_HIP_RELEASE "right_hip_spring_release_j" LEFT_HIP_RELEASE "left_hip_spring_release_j" "Released by the hip spring, J.";
    STOP_RELEASE_J RIGHT_STOP_RELEASE "right_stop_release_j" LEFT_STOP_RELEASE "left_stop_release_j" "Released by the end stops of the actuator, J.";
    CONTACT_RELEASE_J RIGHT_CONTACT_RELEASE "right_contact_release_j" LEFT_CONTACT_RELEASE "left_contact_release_j" "Released by the compressed ground contact, J.";
    HIP_DAMPER_DISSIPATION_J RIGHT_HIP_LOSS "right_hip_damper_dissipation_j" LEFT_HIP_LOSS "left_hip_damper_dissipation_j" "Lost in the hip damper, J.";
    C1_DISSIPATION_J RIGHT_C1_LOSS "right_c1_dissipation_j" LEFT_C1_LOSS "left_c1_dissipation_j" "Lost in the damper `c1`, J.";
    C2_DISSIPATION_J RIGHT_C2_LOSS "right_c2_dissipation_j" LEFT_C2_LOSS "left_c2_dissipation_j" "Lost in the damper `c2`, J.";
    STOP_DISSIPATION_J RIGHT_STOP_LOSS "right_stop_dissipation_j" LEFT_STOP_LOSS "left_stop_dissipation_j" "Lost in the end stops of the actuator, J.";
    NORMAL_CONTACT_DISSIPATION_J RIGHT_NORMAL_LOSS "right_normal_contact_dissipation_j" LEFT_NORMAL_LOSS "left_normal_contact_dissipation_j" "Lost by the normal contact forces, J.";
    FRICTION_DISSIPATION_J RIGHT_FRICTION_LOSS "right_friction_dissipation_j" LEFT_FRICTION_LOSS "left_friction_dissipation_j" "Lost by friction, J.";
}
