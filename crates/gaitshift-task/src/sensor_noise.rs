//! The noise of the sensors. *Not in the paper.*

use crate::TaskError;
use crate::error::require;
use crate::observation::OBSERVATION_SIZE;
use serde::{Deserialize, Serialize};

/// Standard deviations of normal noise on the observations, drawn anew every control period; that of a leg's
/// observation holds for both legs. The command is known exactly.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorNoise {
    /// Of the hip's forward speed, in m/s.
    pub x_velocity_m_per_s: f64,
    /// Of the pitch, in rad.
    pub theta_rad: f64,
    /// Of the pitch's rate, in rad/s.
    pub theta_velocity_rad_per_s: f64,
    /// Of the thigh's displacement, in m.
    pub h_m: f64,
    /// Of its rate, in m/s.
    pub h_velocity_m_per_s: f64,
    /// Of the hip joint's angle, in rad.
    pub phi_rad: f64,
    /// Of its rate, in rad/s.
    pub phi_velocity_rad_per_s: f64,
    /// Of the rate of the leg's compression, in m/s.
    pub d_velocity_m_per_s: f64,
}

impl SensorNoise {
    /// In the order of the observations.
    pub(crate) fn deviations(&self) -> [f64; OBSERVATION_SIZE] {
        let (h, h_dot) = (self.h_m, self.h_velocity_m_per_s);
        let (phi, phi_dot) = (self.phi_rad, self.phi_velocity_rad_per_s);
        let d_dot = self.d_velocity_m_per_s;
        let (theta, theta_dot) = (self.theta_rad, self.theta_velocity_rad_per_s);
        let x_dot = self.x_velocity_m_per_s;
        [
            x_dot, theta, theta_dot, h, h_dot, h, h_dot, phi, phi_dot, phi, phi_dot, d_dot, d_dot,
            0.0,
        ]
    }

    /// Names of its fields.
    pub const NAMES: [&'static str; 8] = [
        "x_velocity_m_per_s",
        "theta_rad",
        "theta_velocity_rad_per_s",
        "h_m",
        "h_velocity_m_per_s",
        "phi_rad",
        "phi_velocity_rad_per_s",
        "d_velocity_m_per_s",
    ];

    /// The field of that name, in its unit.
    pub fn named_mut(&mut self, name: &str) -> Option<&mut f64> {
        Some(match name {
            "x_velocity_m_per_s" => &mut self.x_velocity_m_per_s,
            "theta_rad" => &mut self.theta_rad,
            "theta_velocity_rad_per_s" => &mut self.theta_velocity_rad_per_s,
            "h_m" => &mut self.h_m,
            "h_velocity_m_per_s" => &mut self.h_velocity_m_per_s,
            "phi_rad" => &mut self.phi_rad,
            "phi_velocity_rad_per_s" => &mut self.phi_velocity_rad_per_s,
            "d_velocity_m_per_s" => &mut self.d_velocity_m_per_s,
            _ => return None,
        })
    }

    /// With every deviation multiplied.
    #[must_use]
    pub fn times(mut self, factor: f64) -> Self {
        for name in Self::NAMES {
            if let Some(deviation) = self.named_mut(name) {
                *deviation *= factor;
            }
        }
        self
    }

    /// Checks every field; `key` is the path of this table.
    pub(crate) fn validate(&self, key: &str) -> Result<(), TaskError> {
        let mut noise = *self;
        for name in Self::NAMES {
            let deviation = noise.named_mut(name).map_or(0.0, |deviation| *deviation);
            require(
                deviation.is_finite() && deviation >= 0.0,
                &format!("{key}.{name}"),
                deviation,
                "0 or greater",
            )?;
        }
        Ok(())
    }
}
