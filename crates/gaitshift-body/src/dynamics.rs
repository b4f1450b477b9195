//! Closed-form forward dynamics.
//!
//! With `p` the hip axis, `ψ` the absolute angle of a leg, `e = (sin ψ, -cos ψ)` down the leg and
//! `n = (cos ψ, sin ψ)` across it, a body at the distance `ρ` from the hip axis has the acceleration
//! `p̈ + (ρ̈ - ρ ψ̇²) e + (ρ ψ̈ + 2 ρ̇ ψ̇) n`. Writing `a = p̈ - g` and
//! `S = Σ m ρ`, `J = Σ (m ρ² + I)`, `P = Σ m ρ̇` over a leg's three bodies:
//!
//! - moment about the hip axis: `J ψ̈ + S a·n = T`, `T = τ + Q - 2 ψ̇ Σ m ρ ρ̇`,
//!   τ the hip joint's torque and Q the moment of the contact force;
//! - along the leg, for each body: `m (ρ̈ - ρ ψ̇² + a·e) = F`;
//! - the hip segment, after eliminating the legs: a 2×2 system in `a`,
//!   `(m_hip I + Σ (m_leg - S²/J) n nᵀ) a = Σ { -u e + n [f·n - 2 ψ̇ P - (S/J) T] }`,
//!   u the force of actuator and end stop on the thigh, f the contact force.
//!
//! If the hip segment's centre of mass lies `c` above the axis, along `m = (-sin θ, cos θ)`, its
//! rotation is eliminated in the same way: with `k = dm/dθ` and `I' = I + m_hip c²`,
//! `θ̈ = (-Στ - m_hip c k·a) / I'`, which adds `-(m_hip c)²/I' k kᵀ` to the matrix and
//! `m_hip c (θ̇² m + k Στ / I')` to the right-hand side.
//!
//! Right and left contributions are added to each other before anything else, so that mirrored states
//! give mirrored results to the last bit.

use crate::body::LegGeometry;
use crate::{Body, BodyState, FootContact, LegState};

/// Forces within and on one leg at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LegForces {
    /// Actuator force on the thigh, down the leg, in N.
    pub actuator_n: f64,
    /// End-stop force on the thigh, down the leg, in N.
    pub stop_n: f64,
    /// Elastic part of the end-stop force, in N.
    pub stop_elastic_n: f64,
    /// Torque of the passive hip joint on the leg, in N m.
    pub hip_torque_nm: f64,
    /// What the ground does to the foot.
    pub contact: FootContact,
}

/// Accelerations of the coordinates of [`BodyState`], and the forces that caused them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Accelerations {
    /// Hip axis, forward, in m/s².
    pub x: f64,
    /// Hip axis, up, in m/s².
    pub z: f64,
    /// Pitch, in rad/s².
    pub theta: f64,
    /// Per leg: absolute angle (rad/s²), thigh, tibia and foot displacement (m/s²).
    pub legs: [[f64; 4]; 2],
    /// Forces of the right and left leg.
    pub forces: [LegForces; 2],
}

impl Accelerations {
    /// Accelerations of the coordinates in the order of [`BodyState::positions`].
    pub fn coordinates(&self) -> [f64; 11] {
        let [
            [psi_r, thigh_r, tibia_r, foot_r],
            [psi_l, thigh_l, tibia_l, foot_l],
        ] = self.legs;
        [
            self.x,
            self.z,
            self.theta,
            psi_r - self.theta,
            thigh_r,
            thigh_r - foot_r,
            thigh_r - tibia_r,
            psi_l - self.theta,
            thigh_l,
            thigh_l - foot_l,
            thigh_l - tibia_l,
        ]
    }
}

impl Body {
    /// Accelerations in a state under actuator forces in N (not limited here).
    #[inline]
    pub fn accelerations(&self, s: &BodyState, actuator_n: [f64; 2]) -> Accelerations {
        match self.terrain() {
            None => self.accelerations_under::<false>(s, actuator_n, None),
            Some(_) => self.accelerations_under::<true>(s, actuator_n, None),
        }
    }

    /// [`Body::accelerations`] with an external force on the hip axis, forward and up, in N.
    ///
    /// It acts at the axis, so that it has no moment about it: it enters the hip's 2×2 system alone.
    #[inline(always)]
    pub(crate) fn accelerations_under<const ON_TERRAIN: bool>(
        &self,
        s: &BodyState,
        actuator_n: [f64; 2],
        push_n: Option<[f64; 2]>,
    ) -> Accelerations {
        let p = self.parameters();
        let mut out = Accelerations::default();
        // Per leg: e, n, moments, and its part of the hip's 2×2 system.
        let mut direction = [(0.0, 0.0); 2];
        let mut geometry = [LegGeometry::default(); 2];
        let mut torque = [0.0; 2];
        let mut matrix = [[0.0; 3]; 2];
        let mut rhs = [[0.0; 2]; 2];
        for i in 0..2 {
            let leg = &s.legs[i];
            let (sin_psi, cos_psi) = leg.psi.sin_cos();
            let contact = self.contact_of::<ON_TERRAIN>(s, leg, sin_psi, cos_psi);
            let g = self.leg_geometry(leg);
            let (stop_n, stop_elastic_n) = self.stop_force(leg);
            let hip_torque = -p.hip_stiffness_nm_per_rad * (leg.psi - s.theta)
                - p.hip_damping_nms_per_rad * (leg.psi_dot - s.theta_dot);
            let u = actuator_n[i] + stop_n;
            let t = hip_torque + contact.moment_nm - 2.0 * leg.psi_dot * g.coriolis;
            let ratio = g.first_moment / g.second_moment;
            let across = contact.tangential_n * cos_psi + contact.normal_n * sin_psi;
            let lateral = across - 2.0 * leg.psi_dot * g.radial_momentum - ratio * t;
            let mass = self.leg_mass() - g.first_moment * ratio;
            matrix[i] = [
                mass * cos_psi * cos_psi,
                mass * cos_psi * sin_psi,
                mass * sin_psi * sin_psi,
            ];
            rhs[i] = [
                lateral * cos_psi - u * sin_psi,
                lateral * sin_psi + u * cos_psi,
            ];
            direction[i] = (sin_psi, cos_psi);
            geometry[i] = g;
            torque[i] = t;
            out.forces[i] = LegForces {
                actuator_n: actuator_n[i],
                stop_n,
                stop_elastic_n,
                hip_torque_nm: hip_torque,
                contact,
            };
        }
        let hip_torque = out.forces[0].hip_torque_nm + out.forces[1].hip_torque_nm;
        let mut m = [0.0; 3];
        for (k, m) in m.iter_mut().enumerate() {
            *m = matrix[0][k] + matrix[1][k];
        }
        m[0] += p.hip_mass_kg;
        m[2] += p.hip_mass_kg;
        let mut b = [rhs[0][0] + rhs[1][0], rhs[0][1] + rhs[1][1]];
        if let Some(push_n) = push_n {
            b[0] += push_n[0];
            b[1] += push_n[1];
        }
        let offset = p.hip_mass_kg * p.hip_com_height_m;
        let mut inertia = p.hip_inertia_kg_m2;
        let mut k = (0.0, 0.0);
        if offset != 0.0 {
            let (sin_t, cos_t) = s.theta.sin_cos();
            inertia += offset * p.hip_com_height_m;
            k = (-cos_t, -sin_t);
            let r = offset * offset / inertia;
            m[0] -= r * k.0 * k.0;
            m[1] -= r * k.0 * k.1;
            m[2] -= r * k.1 * k.1;
            let square = offset * s.theta_dot * s.theta_dot;
            let turn = offset * hip_torque / inertia;
            b[0] += turn * k.0 - square * sin_t;
            b[1] += turn * k.1 + square * cos_t;
        }
        let det = m[0] * m[2] - m[1] * m[1];
        let ax = (b[0] * m[2] - b[1] * m[1]) / det;
        let az = (b[1] * m[0] - b[0] * m[1]) / det;
        out.x = ax;
        out.z = az - p.gravity_m_per_s2;
        out.theta = -(hip_torque + offset * (k.0 * ax + k.1 * az)) / inertia;
        for i in 0..2 {
            let leg = &s.legs[i];
            let (sin_psi, cos_psi) = direction[i];
            let g = &geometry[i];
            let f = &out.forces[i];
            let along = ax * sin_psi - az * cos_psi;
            let across = ax * cos_psi + az * sin_psi;
            let contact_along = f.contact.tangential_n * sin_psi - f.contact.normal_n * cos_psi;
            let (d, w) = (leg.d(), leg.w());
            let (d_dot, w_dot) = (leg.d_dot(), leg.w_dot());
            let foot_thigh = p.k1_n_per_m * d + p.c1_ns_per_m * d_dot;
            let tibia_foot = p.k2_n_per_m * (d - w) + p.c2_ns_per_m * (d_dot - w_dot);
            let tibia_thigh = p.k3_n_per_m * w;
            let square = leg.psi_dot * leg.psi_dot;
            let thigh_n = f.actuator_n + f.stop_n - foot_thigh - tibia_thigh;
            let tibia_n = tibia_thigh - tibia_foot;
            let foot_n = foot_thigh + tibia_foot + contact_along;
            out.legs[i] = [
                (torque[i] - g.first_moment * across) / g.second_moment,
                thigh_n / p.thigh_mass_kg + (p.thigh_distance_m + leg.thigh) * square - along,
                tibia_n / p.tibia_mass_kg + (p.tibia_distance_m + leg.tibia) * square - along,
                foot_n / p.foot_mass_kg + (p.foot_distance_m + leg.foot) * square - along,
            ];
        }
        out
    }

    /// End-stop force on the thigh and its elastic part, in N. A stop pushes, it never pulls.
    fn stop_force(&self, leg: &LegState) -> (f64, f64) {
        let p = self.parameters();
        let beyond = leg.thigh.abs() - p.stroke_m;
        if beyond <= 0.0 {
            return (0.0, 0.0);
        }
        let side = leg.thigh.signum();
        let elastic = p.stop_stiffness_n_per_m * beyond;
        let force = elastic * (1.0 + p.stop_dissipation_s_per_m * side * leg.thigh_dot);
        (-side * force.max(0.0), -side * elastic)
    }
}
