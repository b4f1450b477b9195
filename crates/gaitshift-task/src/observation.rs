//! The 14 observations of the paper, in its order, and their mirror image.

use gaitshift_body::{BodyState, LEFT, RIGHT};

/// Number of observations.
pub const OBSERVATION_SIZE: usize = 14;
/// Number of actions: the commands of the right and the left actuator.
pub const ACTION_SIZE: usize = 2;

/// Names of the observations with their units, in order.
pub const OBSERVATION_NAMES: [&str; OBSERVATION_SIZE] = [
    "x_velocity_m_per_s",
    "theta_rad",
    "theta_velocity_rad_per_s",
    "right_h_m",
    "right_h_velocity_m_per_s",
    "left_h_m",
    "left_h_velocity_m_per_s",
    "right_phi_rad",
    "right_phi_velocity_rad_per_s",
    "left_phi_rad",
    "left_phi_velocity_rad_per_s",
    "right_d_velocity_m_per_s",
    "left_d_velocity_m_per_s",
    "omega_v",
];

/// Factors that bring the observations to order one before they enter a network.
pub const OBSERVATION_SCALE: [f32; OBSERVATION_SIZE] = [
    0.5, 2.0, 0.25, 10.0, 1.0, 10.0, 1.0, 2.0, 0.25, 2.0, 0.25, 1.0, 1.0, 0.5,
];

/// `Ψ_o` of (7): element i of the mirror image is element `OBSERVATION_MIRROR[i]` of the original.
/// No sign changes, since the mirror plane is the plane of motion.
pub const OBSERVATION_MIRROR: [usize; OBSERVATION_SIZE] =
    [0, 1, 2, 5, 6, 3, 4, 9, 10, 7, 8, 12, 11, 13];

/// `Ψ_a` of (7), likewise.
pub const ACTION_MIRROR: [usize; ACTION_SIZE] = [1, 0];

/// The observation of a state under the command `omega_v`, in SI units, unscaled.
pub fn observe(s: &BodyState, omega_v: f64) -> [f64; OBSERVATION_SIZE] {
    let [r, l] = &s.legs;
    [
        s.x_dot,
        s.theta,
        s.theta_dot,
        r.thigh,
        r.thigh_dot,
        l.thigh,
        l.thigh_dot,
        s.phi(RIGHT),
        s.phi_dot(RIGHT),
        s.phi(LEFT),
        s.phi_dot(LEFT),
        r.d_dot(),
        l.d_dot(),
        omega_v,
    ]
}

/// Writes the scaled observation that a network reads.
pub fn scale_observation(observation: &[f64; OBSERVATION_SIZE], out: &mut [f32]) {
    for ((out, value), scale) in out.iter_mut().zip(observation).zip(OBSERVATION_SCALE) {
        *out = *value as f32 * scale;
    }
}
