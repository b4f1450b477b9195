//! Energy and momentum of the body, and the account of where energy came from and went.

use crate::{Body, BodyState};
use serde::{Deserialize, Serialize};

/// Mechanical energy of the body at one instant, in J.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MechanicalEnergy {
    /// Kinetic energy of all bodies.
    pub kinetic: f64,
    /// Gravitational energy, zero with every mass at z = 0, where flat ground is.
    pub gravitational: f64,
    /// Both hip springs.
    pub hip_springs: f64,
    /// Springs `k1` of both legs.
    pub k1: f64,
    /// Springs `k2` of both legs.
    pub k2: f64,
    /// Springs `k3` of both legs.
    pub k3: f64,
    /// Stored in the contact of both feet.
    pub contact: f64,
    /// Stored in the actuators' end stops.
    pub stops: f64,
}

impl MechanicalEnergy {
    /// Elastic energy of the leg springs, in J.
    pub fn leg_springs(&self) -> f64 {
        self.k1 + self.k2 + self.k3
    }
    /// Elastic energy of the body: hip and leg springs, in J.
    pub fn elastic(&self) -> f64 {
        self.hip_springs + self.leg_springs()
    }
    /// The total of (2) of the paper: kinetic, potential and elastic energy, in J.
    pub fn total(&self) -> f64 {
        self.kinetic + self.gravitational + self.elastic()
    }
    /// All that is stored, contact and end stops included, in J. This is what the account balances.
    pub fn stored(&self) -> f64 {
        self.total() + self.contact + self.stops
    }
}

/// Work and dissipation accumulated since the account was opened, in J.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct EnergyAccount {
    /// Net work of the right and left actuator on the body, `∫F ḣ dt`.
    pub actuator_work: [f64; 2],
    /// Their positive work, `∫max(F ḣ, 0) dt`: the integral in (8) of the paper.
    pub actuator_positive_work: [f64; 2],
    /// Dissipated in both hip dampers.
    pub hip_dampers: f64,
    /// Dissipated in the dampers `c1`.
    pub c1: f64,
    /// Dissipated in the dampers `c2`.
    pub c2: f64,
    /// Dissipated in the end stops.
    pub stops: f64,
    /// Dissipated by the normal contact forces.
    pub contact_normal: f64,
    /// Dissipated by friction.
    pub friction: f64,
    /// Work of external forces on the hip, where there were any.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub external_work: f64,
}

/// Nothing pushes a body in training: its checkpoints stay as they were.
fn is_zero(work_j: &f64) -> bool {
    *work_j == 0.0
}

impl EnergyAccount {
    /// Everything dissipated, in J.
    pub fn dissipated(&self) -> f64 {
        self.dampers() + self.stops + self.contact()
    }
    /// Dissipated by the body's own dampers, in J.
    pub fn dampers(&self) -> f64 {
        self.hip_dampers + self.c1 + self.c2
    }
    /// Dissipated at the ground, in J.
    pub fn contact(&self) -> f64 {
        self.contact_normal + self.friction
    }
    /// Net work of both actuators, in J.
    pub fn work(&self) -> f64 {
        self.actuator_work[0] + self.actuator_work[1]
    }
    /// Positive work of both actuators, in J.
    pub fn positive_work(&self) -> f64 {
        self.actuator_positive_work[0] + self.actuator_positive_work[1]
    }
}

/// The centre of mass of the whole body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CentreOfMass {
    /// Forward position, in m.
    pub x: f64,
    /// Height, in m.
    pub z: f64,
    /// Forward velocity, in m/s.
    pub x_dot: f64,
    /// Upward velocity, in m/s.
    pub z_dot: f64,
}

/// Linear and angular momentum.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Momentum {
    /// Forward, in kg m/s.
    pub x: f64,
    /// Upward, in kg m/s.
    pub z: f64,
    /// Angular momentum about the centre of mass, in kg m²/s, in the sense of the leg angles.
    pub angular: f64,
}

impl Body {
    /// Mechanical energy in a state, in J.
    pub fn energy(&self, s: &BodyState) -> MechanicalEnergy {
        let p = self.parameters();
        let half = |k: f64, x: f64| 0.5 * k * x * x;
        let (sin_t, cos_t) = s.theta.sin_cos();
        let offset = p.hip_com_height_m;
        let mut e = MechanicalEnergy::default();
        // Hip segment, its centre of mass `offset` above the axis.
        let vx = s.x_dot - offset * s.theta_dot * cos_t;
        let vz = s.z_dot - offset * s.theta_dot * sin_t;
        let hip_kinetic = half(p.hip_mass_kg, vx)
            + half(p.hip_mass_kg, vz)
            + half(p.hip_inertia_kg_m2, s.theta_dot);
        let weight = p.gravity_m_per_s2;
        let hip_height = s.z + offset * cos_t;
        let mut kinetic = [0.0; 2];
        let mut moment = [0.0; 2];
        for (i, leg) in s.legs.iter().enumerate() {
            let g = self.leg_geometry(leg);
            let (sin_p, cos_p) = leg.psi.sin_cos();
            // v_b = ṗ + ρ̇ e + ρ ψ̇ n, summed over the leg's bodies.
            let along = s.x_dot * sin_p - s.z_dot * cos_p;
            let across = s.x_dot * cos_p + s.z_dot * sin_p;
            kinetic[i] = 0.5
                * (self.leg_mass() * (s.x_dot * s.x_dot + s.z_dot * s.z_dot)
                    + g.second_moment * leg.psi_dot * leg.psi_dot
                    + p.thigh_mass_kg * leg.thigh_dot * leg.thigh_dot
                    + p.tibia_mass_kg * leg.tibia_dot * leg.tibia_dot
                    + p.foot_mass_kg * leg.foot_dot * leg.foot_dot)
                + along * g.radial_momentum
                + across * g.first_moment * leg.psi_dot;
            moment[i] = self.leg_mass() * s.z - g.first_moment * cos_p;
        }
        e.kinetic = hip_kinetic + (kinetic[0] + kinetic[1]);
        e.gravitational = weight * (p.hip_mass_kg * hip_height + (moment[0] + moment[1]));
        let both = |f: &dyn Fn(usize) -> f64| f(0) + f(1);
        e.hip_springs = both(&|i| half(p.hip_stiffness_nm_per_rad, s.phi(i)));
        e.k1 = both(&|i| half(p.k1_n_per_m, s.legs[i].d()));
        e.k2 = both(&|i| half(p.k2_n_per_m, s.legs[i].d() - s.legs[i].w()));
        e.k3 = both(&|i| half(p.k3_n_per_m, s.legs[i].w()));
        e.contact = both(&|i| self.foot_contact(s, i).elastic_j);
        e.stops = both(&|i| {
            half(
                p.stop_stiffness_n_per_m,
                (s.legs[i].thigh.abs() - p.stroke_m).max(0.0),
            )
        });
        e
    }

    /// Place and velocity of the centre of mass.
    pub fn centre_of_mass(&self, s: &BodyState) -> CentreOfMass {
        let centre = centre_of(&self.point_masses(s));
        CentreOfMass {
            x: s.x + centre.x,
            z: s.z + centre.z,
            x_dot: centre.x_dot,
            z_dot: centre.z_dot,
        }
    }

    /// Linear momentum and angular momentum about the centre of mass.
    pub fn momentum(&self, s: &BodyState) -> Momentum {
        let bodies = self.point_masses(s);
        let centre = centre_of(&bodies);
        let spin = self.parameters().hip_inertia_kg_m2 * s.theta_dot
            + self.leg_inertia() * s.legs[0].psi_dot
            + self.leg_inertia() * s.legs[1].psi_dot;
        let PointMass {
            x,
            z,
            x_dot,
            z_dot,
            mass: total,
        } = centre;
        // The sense that turns (v_x, v_z) into (-v_z, v_x) is positive.
        let angular: f64 = bodies
            .iter()
            .map(|b| b.mass * ((b.x - x) * (b.z_dot - z_dot) - (b.z - z) * (b.x_dot - x_dot)))
            .sum();
        Momentum {
            x: total * x_dot,
            z: total * z_dot,
            angular: angular + spin,
        }
    }

    /// Hip segment, then thigh, tibia and foot of each leg.
    fn point_masses(&self, s: &BodyState) -> [PointMass; 7] {
        let p = self.parameters();
        let (sin_t, cos_t) = s.theta.sin_cos();
        let c = p.hip_com_height_m;
        let mut bodies = [PointMass::default(); 7];
        bodies[0] = PointMass {
            mass: p.hip_mass_kg,
            x: -c * sin_t,
            z: c * cos_t,
            x_dot: s.x_dot - c * s.theta_dot * cos_t,
            z_dot: s.z_dot - c * s.theta_dot * sin_t,
        };
        for (i, leg) in s.legs.iter().enumerate() {
            let (sin_p, cos_p) = leg.psi.sin_cos();
            let parts = [
                (
                    p.thigh_mass_kg,
                    p.thigh_distance_m + leg.thigh,
                    leg.thigh_dot,
                ),
                (
                    p.tibia_mass_kg,
                    p.tibia_distance_m + leg.tibia,
                    leg.tibia_dot,
                ),
                (p.foot_mass_kg, p.foot_distance_m + leg.foot, leg.foot_dot),
            ];
            for (b, (mass, rho, rho_dot)) in parts.into_iter().enumerate() {
                bodies[1 + 3 * i + b] = PointMass {
                    mass,
                    x: rho * sin_p,
                    z: -rho * cos_p,
                    x_dot: s.x_dot + rho_dot * sin_p + rho * leg.psi_dot * cos_p,
                    z_dot: s.z_dot - rho_dot * cos_p + rho * leg.psi_dot * sin_p,
                };
            }
        }
        bodies
    }
}

/// All bodies as one point.
fn centre_of(bodies: &[PointMass]) -> PointMass {
    let mass: f64 = bodies.iter().map(|b| b.mass).sum();
    let mean =
        |value: fn(&PointMass) -> f64| bodies.iter().map(|b| b.mass * value(b)).sum::<f64>() / mass;
    PointMass {
        mass,
        x: mean(|b| b.x),
        z: mean(|b| b.z),
        x_dot: mean(|b| b.x_dot),
        z_dot: mean(|b| b.z_dot),
    }
}

/// Centre of mass of one body, its position relative to the hip axis.
#[derive(Clone, Copy, Default)]
struct PointMass {
    mass: f64,
    x: f64,
    z: f64,
    x_dot: f64,
    z_dot: f64,
}
