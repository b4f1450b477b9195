//! State of the body: eleven positions and eleven velocities.

use serde::{Deserialize, Serialize};

/// Index of the right leg.
pub const RIGHT: usize = 0;
/// Index of the left leg.
pub const LEFT: usize = 1;

/// State of one leg in absolute coordinates: in these the radial masses are uncoupled.
///
/// `psi` is the leg's absolute angle `θ + φ`. `thigh`, `tibia` and `foot` are displacements of the
/// three bodies down the leg from their rest distances to the hip axis, so that
/// `h = thigh`, `d = thigh - foot` and `w = thigh - tibia`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct LegState {
    /// Absolute leg angle, in rad; positive swings the foot forward.
    pub psi: f64,
    /// Its rate, in rad/s.
    pub psi_dot: f64,
    /// Thigh displacement down the leg, `h`, in m.
    pub thigh: f64,
    /// Its rate, in m/s.
    pub thigh_dot: f64,
    /// Tibia displacement down the leg, in m.
    pub tibia: f64,
    /// Its rate, in m/s.
    pub tibia_dot: f64,
    /// Foot displacement down the leg, in m.
    pub foot: f64,
    /// Its rate, in m/s.
    pub foot_dot: f64,
}

/// State of the whole body.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct BodyState {
    /// Hip axis, forward, in m.
    pub x: f64,
    /// Hip axis, up from the flat ground, in m.
    pub z: f64,
    /// Pitch of the hip segment, in rad; the same sense as the leg angles.
    pub theta: f64,
    /// Rate of `x`, in m/s.
    pub x_dot: f64,
    /// Rate of `z`, in m/s.
    pub z_dot: f64,
    /// Rate of `theta`, in rad/s.
    pub theta_dot: f64,
    /// Right and left leg.
    pub legs: [LegState; 2],
}

impl LegState {
    /// Leg compression `d` between thigh and foot, in m; positive when compressed.
    pub fn d(&self) -> f64 {
        self.thigh - self.foot
    }
    /// Rate of `d`, in m/s.
    pub fn d_dot(&self) -> f64 {
        self.thigh_dot - self.foot_dot
    }
    /// Compression `w` between thigh and tibia, in m; positive when compressed.
    pub fn w(&self) -> f64 {
        self.thigh - self.tibia
    }
    /// Rate of `w`, in m/s.
    pub fn w_dot(&self) -> f64 {
        self.thigh_dot - self.tibia_dot
    }
}

impl BodyState {
    /// Hip angle `φ` of a leg, in rad.
    pub fn phi(&self, leg: usize) -> f64 {
        self.legs[leg].psi - self.theta
    }

    /// Rate of `φ` of a leg, in rad/s.
    pub fn phi_dot(&self, leg: usize) -> f64 {
        self.legs[leg].psi_dot - self.theta_dot
    }

    /// The same motion with right and left leg exchanged.
    pub fn mirrored(&self) -> Self {
        Self {
            legs: [self.legs[LEFT], self.legs[RIGHT]],
            ..*self
        }
    }

    /// Whether every number is finite and no speed exceeds `limit` (m/s or rad/s).
    pub fn is_sound(&self, limit: f64) -> bool {
        let leg = |l: &LegState| {
            // One sum is enough to carry a NaN or an infinity from any position.
            let rates = [l.psi_dot, l.thigh_dot, l.tibia_dot, l.foot_dot];
            (l.psi + l.thigh + l.tibia + l.foot).is_finite()
                && rates.iter().all(|v| v.abs() <= limit)
        };
        (self.x + self.z + self.theta).is_finite()
            && [self.x_dot, self.z_dot, self.theta_dot]
                .iter()
                .all(|v| v.abs() <= limit)
            && leg(&self.legs[RIGHT])
            && leg(&self.legs[LEFT])
    }

    /// Positions in the order `x, z, θ, (φ, h, d, w)` right, then left.
    pub fn positions(&self) -> [f64; 11] {
        let [r, l] = &self.legs;
        [
            self.x,
            self.z,
            self.theta,
            self.phi(RIGHT),
            r.thigh,
            r.d(),
            r.w(),
            self.phi(LEFT),
            l.thigh,
            l.d(),
            l.w(),
        ]
    }

    /// Velocities in the order of [`BodyState::positions`].
    pub fn velocities(&self) -> [f64; 11] {
        let [r, l] = &self.legs;
        [
            self.x_dot,
            self.z_dot,
            self.theta_dot,
            self.phi_dot(RIGHT),
            r.thigh_dot,
            r.d_dot(),
            r.w_dot(),
            self.phi_dot(LEFT),
            l.thigh_dot,
            l.d_dot(),
            l.w_dot(),
        ]
    }

    /// The state with the given positions and velocities, in the order of [`BodyState::positions`].
    pub fn from_coordinates(positions: &[f64; 11], velocities: &[f64; 11]) -> Self {
        let (q, v) = (positions, velocities);
        let leg = |k: usize| LegState {
            psi: q[2] + q[k],
            psi_dot: v[2] + v[k],
            thigh: q[k + 1],
            thigh_dot: v[k + 1],
            tibia: q[k + 1] - q[k + 3],
            tibia_dot: v[k + 1] - v[k + 3],
            foot: q[k + 1] - q[k + 2],
            foot_dot: v[k + 1] - v[k + 2],
        };
        Self {
            x: q[0],
            z: q[1],
            theta: q[2],
            x_dot: v[0],
            z_dot: v[1],
            theta_dot: v[2],
            legs: [leg(3), leg(7)],
        }
    }
}
