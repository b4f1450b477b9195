//! How an episode starts: the ranges, and the states of the body in them.

use gaitshift_body::{Body, BodyState, LEFT, RIGHT};
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

/// *Open.* How an episode starts: legs split, one foot on the ground, moving forward. The default
/// start of an evaluation is the middle of these ranges with the right leg in front.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StartParameters {
    /// Angle of the front leg, in rad. A symmetric policy cannot part closed legs.
    pub front_leg_rad: f64,
    /// Angle of the rear leg, in rad.
    pub rear_leg_rad: f64,
    /// Half-range of the uniform variation of both angles, in rad.
    pub leg_variation_rad: f64,
    /// Half-range of the uniform variation of the pitch, in rad.
    pub pitch_variation_rad: f64,
    /// Forward speed, in m/s.
    pub speed_m_per_s: f64,
    /// Half-range of the uniform variation of the speed, in m/s.
    pub speed_variation_m_per_s: f64,
    /// Greatest height of the lower foot above the ground, in m.
    pub drop_variation_m: f64,
}

impl Default for StartParameters {
    fn default() -> Self {
        Self {
            front_leg_rad: 0.25,
            rear_leg_rad: -0.25,
            leg_variation_rad: 0.15,
            pitch_variation_rad: 0.1,
            speed_m_per_s: 0.6,
            speed_variation_m_per_s: 0.4,
            drop_variation_m: 0.02,
        }
    }
}

impl StartParameters {
    /// The middle of the ranges, the right leg in front.
    pub(crate) fn middle(&self, body: &Body) -> BodyState {
        start_state(
            body,
            [self.front_leg_rad, self.rear_leg_rad],
            0.0,
            self.speed_m_per_s,
            0.0,
        )
    }

    /// A start drawn from the ranges, either leg in front.
    pub(crate) fn draw(&self, body: &Body, rng: &mut Xoshiro256PlusPlus) -> BodyState {
        let mut vary = |middle: f64, half: f64| middle + half * (2.0 * rng.random::<f64>() - 1.0);
        let front = vary(self.front_leg_rad, self.leg_variation_rad);
        let rear = vary(self.rear_leg_rad, self.leg_variation_rad);
        let pitch = vary(0.0, self.pitch_variation_rad);
        let speed = vary(self.speed_m_per_s, self.speed_variation_m_per_s);
        let drop = 0.5 * vary(self.drop_variation_m, self.drop_variation_m);
        let state = start_state(body, [front, rear], pitch, speed, drop);
        if rng.random::<bool>() {
            state.mirrored()
        } else {
            state
        }
    }
}

/// Front and rear leg at the given angles, the lower foot `drop` above the ground, the hip moving
/// forward at `speed`, the front foot at rest on the ground and the rear leg swinging forward.
fn start_state(body: &Body, psi: [f64; 2], theta: f64, speed: f64, drop: f64) -> BodyState {
    let mut s = BodyState::with_leg_angles(body, psi);
    s.theta = theta;
    s.z += drop;
    s.x_dot = speed;
    let rate = speed / body.parameters().leg_length_m;
    s.legs[RIGHT].psi_dot = -rate;
    s.legs[LEFT].psi_dot = rate;
    s
}
