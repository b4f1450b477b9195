//! The columns of a recording: names, order, meaning.

use std::fmt;

/// A column of the recording; the constants in [`mod@column`] are all there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Column(usize);

impl Column {
    /// The column's name in the file's header.
    pub fn name(self) -> &'static str {
        COLUMNS[self.0]
    }

    /// The column's position in a row.
    pub fn index(self) -> usize {
        self.0
    }

    /// The column of that name, if there is one.
    pub fn named(name: &str) -> Option<Column> {
        COLUMNS.iter().position(|&known| known == name).map(Column)
    }
}

impl fmt::Display for Column {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

/// Writes the list of columns once: their constants, names and documentation.
macro_rules! columns {
    ($($constant:ident $name:literal $doc:literal;)*) => {
        /// Names of all columns, in the order in which [`Recording::push_row`](super::Recording::push_row) takes them.
        pub const COLUMNS: &[&str] = &[$($name),*];

        #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
        enum Position { $($constant),* }

        /// The columns of a recording.
        ///
        /// `x` points forward, `z` up; angles are positive in the sense that swings a leg forward.
        /// With `psi = theta + phi`, "down the leg" is `(sin psi, -cos psi)`. Constants that hold two columns
        /// are indexed by [`Side::index`](super::super::Side::index).
        pub mod column {
            use super::{Column, Position};
            $(#[doc = $doc] pub const $constant: Column = Column(Position::$constant as usize);)*

            /// Hip angles, right and left, rad.
            pub const PHI_RAD: [Column; 2] = [RIGHT_PHI_RAD, LEFT_PHI_RAD];
            /// Thigh displacements `h`, right and left, m.
            pub const H_M: [Column; 2] = [RIGHT_H_M, LEFT_H_M];
            /// Leg compressions `d`, right and left, m.
            pub const D_M: [Column; 2] = [RIGHT_D_M, LEFT_D_M];
            /// Tibia compressions `w`, right and left, m.
            pub const W_M: [Column; 2] = [RIGHT_W_M, LEFT_W_M];
            /// Hip angular velocities, right and left, rad/s.
            pub const PHI_VELOCITY_RAD_PER_S: [Column; 2] = [RIGHT_PHI_VELOCITY_RAD_PER_S, LEFT_PHI_VELOCITY_RAD_PER_S];
            /// Rates of `h`, right and left, m/s.
            pub const H_VELOCITY_M_PER_S: [Column; 2] = [RIGHT_H_VELOCITY_M_PER_S, LEFT_H_VELOCITY_M_PER_S];
            /// Rates of `d`, right and left, m/s.
            pub const D_VELOCITY_M_PER_S: [Column; 2] = [RIGHT_D_VELOCITY_M_PER_S, LEFT_D_VELOCITY_M_PER_S];
            /// Rates of `w`, right and left, m/s.
            pub const W_VELOCITY_M_PER_S: [Column; 2] = [RIGHT_W_VELOCITY_M_PER_S, LEFT_W_VELOCITY_M_PER_S];
            /// Actions, right and left.
            pub const COMMAND: [Column; 2] = [RIGHT_COMMAND, LEFT_COMMAND];
            /// Actuator forces, right and left, N.
            pub const ACTUATOR_FORCE_N: [Column; 2] = [RIGHT_ACTUATOR_FORCE_N, LEFT_ACTUATOR_FORCE_N];
            /// Vertical ground reactions, right and left, N.
            pub const NORMAL_FORCE_N: [Column; 2] = [RIGHT_NORMAL_FORCE_N, LEFT_NORMAL_FORCE_N];
            /// Forward ground reactions, right and left, N.
            pub const TANGENTIAL_FORCE_N: [Column; 2] = [RIGHT_TANGENTIAL_FORCE_N, LEFT_TANGENTIAL_FORCE_N];
        }
    };
}

columns! {
    TIME_S "time_s" "Time since the first row, s.";
    OMEGA_V "omega_v" "Command: weight of forward speed in the reward (2), 1/(m/s).";
    X_M "x_m" "Forward position of the hip axis, m.";
    Z_M "z_m" "Height of the hip axis above z = 0, where flat ground is, m.";
    THETA_RAD "theta_rad" "Pitch of the hip segment, rad.";
    X_VELOCITY_M_PER_S "x_velocity_m_per_s" "Forward velocity of the hip axis, m/s.";
    Z_VELOCITY_M_PER_S "z_velocity_m_per_s" "Upward velocity of the hip axis, m/s.";
    THETA_VELOCITY_RAD_PER_S "theta_velocity_rad_per_s" "Pitch velocity, rad/s.";
    RIGHT_PHI_RAD "right_phi_rad" "Right hip angle relative to the hip segment, rad.";
    RIGHT_H_M "right_h_m" "Right thigh displacement down the leg, m; positive lengthens the leg.";
    RIGHT_D_M "right_d_m" "Right leg: compression of the distance thigh-foot, m.";
    RIGHT_W_M "right_w_m" "Right leg: compression of the distance thigh-tibia, m.";
    RIGHT_PHI_VELOCITY_RAD_PER_S "right_phi_velocity_rad_per_s" "Right hip angular velocity, rad/s.";
    RIGHT_H_VELOCITY_M_PER_S "right_h_velocity_m_per_s" "Rate of `h` of the right leg, m/s.";
    RIGHT_D_VELOCITY_M_PER_S "right_d_velocity_m_per_s" "Rate of `d` of the right leg, m/s.";
    RIGHT_W_VELOCITY_M_PER_S "right_w_velocity_m_per_s" "Rate of `w` of the right leg, m/s.";
    LEFT_PHI_RAD "left_phi_rad" "Left hip angle relative to the hip segment, rad.";
    LEFT_H_M "left_h_m" "Left thigh displacement down the leg, m; positive lengthens the leg.";
    LEFT_D_M "left_d_m" "Left leg: compression of the distance thigh-foot, m.";
    LEFT_W_M "left_w_m" "Left leg: compression of the distance thigh-tibia, m.";
    LEFT_PHI_VELOCITY_RAD_PER_S "left_phi_velocity_rad_per_s" "Left hip angular velocity, rad/s.";
    LEFT_H_VELOCITY_M_PER_S "left_h_velocity_m_per_s" "Rate of `h` of the left leg, m/s.";
    LEFT_D_VELOCITY_M_PER_S "left_d_velocity_m_per_s" "Rate of `d` of the left leg, m/s.";
    LEFT_W_VELOCITY_M_PER_S "left_w_velocity_m_per_s" "Rate of `w` of the left leg, m/s.";
    RIGHT_COMMAND "right_command" "Action of the right leg over the period, in [-1, 1].";
    LEFT_COMMAND "left_command" "Action of the left leg over the period, in [-1, 1].";
    RIGHT_ACTUATOR_FORCE_N "right_actuator_force_n" "Right actuator force, mean over the period, N.";
    RIGHT_NORMAL_FORCE_N "right_normal_force_n" "Vertical ground reaction on the right foot, mean over the period, N.";
    RIGHT_TANGENTIAL_FORCE_N "right_tangential_force_n" "Forward ground reaction on the right foot, mean over the period, N.";
    LEFT_ACTUATOR_FORCE_N "left_actuator_force_n" "Left actuator force, mean over the period, N.";
    LEFT_NORMAL_FORCE_N "left_normal_force_n" "Vertical ground reaction on the left foot, mean over the period, N.";
    LEFT_TANGENTIAL_FORCE_N "left_tangential_force_n" "Forward ground reaction on the left foot, mean over the period, N.";
    KINETIC_ENERGY_J "kinetic_energy_j" "Kinetic energy of all segments, J.";
    GRAVITATIONAL_ENERGY_J "gravitational_energy_j" "Gravitational energy of all segments, J.";
    HIP_SPRING_ENERGY_J "hip_spring_energy_j" "Energy of both hip springs, J.";
    LEG_SPRING_ENERGY_J "leg_spring_energy_j" "Energy of the springs of both wobbling legs, J.";
    ELASTIC_ENERGY_J "elastic_energy_j" "Hip and leg spring energy together, J.";
    CONTACT_ENERGY_J "contact_energy_j" "Energy stored in the compressed ground contacts, J.";
    STOP_ENERGY_J "stop_energy_j" "Energy stored in the end stops of the actuators, J.";
    ACTUATOR_WORK_J "actuator_work_j" "Work of both actuators since the first row, J.";
    ACTUATOR_POSITIVE_WORK_J "actuator_positive_work_j" "The integral of (8), both legs, since the first row, J.";
    DAMPER_DISSIPATION_J "damper_dissipation_j" "Energy lost in hip and leg dampers since the first row, J.";
    CONTACT_DISSIPATION_J "contact_dissipation_j" "Energy lost in ground contact and friction since the first row, J.";
    STOP_DISSIPATION_J "stop_dissipation_j" "Energy lost in the end stops since the first row, J.";
    REWARD "reward" "Reward (2) of the period.";
    REWARD_ENERGY "reward_energy" "Weighted energy term of (2).";
    REWARD_VELOCITY "reward_velocity" "Weighted velocity term of (2).";
    REWARD_FORWARD "reward_forward" "The term (3).";
    REWARD_ALIVE "reward_alive" "The term (4).";
    REWARD_LEG "reward_leg" "Weighted leg term (6) of (5).";
    REWARD_FRICTION "reward_friction" "Weighted penalty on friction, not in the paper.";
    REWARD_WORK "reward_work" "Weighted penalty on positive work, not in the paper.";
}
