//! Table 1 of the paper as defaults, and every choice that the paper leaves open, by name.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Parameters of the body, its contact with the ground and the integrator.
///
/// Defaults are Table 1 of the paper where it gives a value. The fields marked *open* are not in the
/// paper; the reason for each default stands beside it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BodyParameters {
    /// Leg length from the hip axis to the sole, `l`, in m.
    pub leg_length_m: f64,
    /// Radius of curvature of the sole, `r`, in m.
    pub foot_arc_radius_m: f64,
    /// Mass of the hip segment, in kg.
    pub hip_mass_kg: f64,
    /// Mass of each thigh, in kg.
    pub thigh_mass_kg: f64,
    /// Mass of each wobbling tibia, in kg.
    pub tibia_mass_kg: f64,
    /// Mass of each foot, in kg.
    pub foot_mass_kg: f64,
    /// Torsion stiffness of each passive hip joint, `k_hip`, in N m/rad.
    pub hip_stiffness_nm_per_rad: f64,
    /// Torsion damping of each passive hip joint, `c_hip`, in N m s/rad.
    pub hip_damping_nms_per_rad: f64,
    /// Stiffness `k1` between foot and thigh, in N/m.
    pub k1_n_per_m: f64,
    /// Stiffness `k2` between tibia and foot, in N/m.
    pub k2_n_per_m: f64,
    /// Stiffness `k3` between tibia and thigh, in N/m.
    pub k3_n_per_m: f64,
    /// Damping `c1` between foot and thigh, in N s/m.
    pub c1_ns_per_m: f64,
    /// Damping `c2` between tibia and foot, in N s/m.
    pub c2_ns_per_m: f64,
    /// Greatest force of each linear actuator, `F`, in N.
    pub actuator_force_n: f64,

    /// *Open.* Moment of inertia of the hip segment about its centre of mass, in kg m².
    /// Default: a uniform box 0.3 m × 0.2 m of 20 kg.
    pub hip_inertia_kg_m2: f64,
    /// *Open.* Height of the hip segment's centre of mass over the hip axis, in m.
    /// Default 0: the paper draws the segment around the axis, and no torque could balance a trunk.
    pub hip_com_height_m: f64,
    /// *Open.* Distance of the thigh's centre of mass from the hip axis at rest, in m.
    /// Default: the middle of the upper half of the leg.
    pub thigh_distance_m: f64,
    /// *Open.* Distance of the tibia's centre of mass from the hip axis at rest, in m.
    /// Default: just above the middle of the lower half, the calf being heavier on top.
    pub tibia_distance_m: f64,
    /// *Open.* Distance of the foot's centre of mass from the hip axis at rest, in m.
    /// Default: within the arc of the sole.
    pub foot_distance_m: f64,
    /// *Open.* Moment of inertia of the thigh about its centre of mass, in kg m².
    /// Default: a slender rod of half the leg's length.
    pub thigh_inertia_kg_m2: f64,
    /// *Open.* Moment of inertia of the tibia about its centre of mass, in kg m².
    /// Default: a slender rod of half the leg's length.
    pub tibia_inertia_kg_m2: f64,
    /// *Open.* Moment of inertia of the foot about its centre of mass, in kg m².
    /// Default: an arc of the sole's size.
    pub foot_inertia_kg_m2: f64,

    /// *Open.* Greatest thigh displacement |h| before the end stop acts, in m.
    /// Default: an eighth of the leg, enough to clear the ground in swing.
    pub stroke_m: f64,
    /// *Open.* Stiffness of the end stops, in N/m. Default: ten times the leg's springs.
    pub stop_stiffness_n_per_m: f64,
    /// *Open.* Hunt-Crossley dissipation of the end stops, in s/m.
    pub stop_dissipation_s_per_m: f64,

    /// Number of small spheres that make up each sole (20 in the paper).
    pub foot_sphere_count: usize,
    /// *Open.* Radius of those spheres, in m. Their envelope has the radius `foot_arc_radius_m`.
    pub foot_sphere_radius_m: f64,
    /// *Open.* The arc spans ± this angle about the leg's line, in rad. Default 45°.
    pub foot_arc_half_angle_rad: f64,
    /// *Open.* Contact stiffness of one sphere, in N/m^`contact_exponent`.
    /// Default: standing sinks the sole by a few millimetres, as a shoe does.
    pub contact_stiffness: f64,
    /// *Open.* Exponent of the elastic contact force (1 linear, 1.5 Hertz's sphere).
    pub contact_exponent: f64,
    /// *Open.* Hunt-Crossley dissipation of the contact, in s/m.
    pub contact_dissipation_s_per_m: f64,
    /// *Open.* Coulomb friction coefficient. Default 1: rubber on a dry floor.
    pub friction: f64,
    /// *Open.* Sliding speed over which Coulomb friction is smoothed, in m/s.
    pub friction_smoothing_m_per_s: f64,

    /// Gravitational acceleration, in m/s².
    pub gravity_m_per_s2: f64,
    /// *Open.* Integration step, in s. Default: see the convergence figures in the documentation.
    pub time_step_s: f64,
    /// *Open.* A speed (m/s or rad/s) beyond which a state counts as diverged.
    pub diverged_speed: f64,
}

impl Default for BodyParameters {
    fn default() -> Self {
        Self {
            leg_length_m: 0.8,
            foot_arc_radius_m: 0.27,
            hip_mass_kg: 20.0,
            thigh_mass_kg: 6.0,
            tibia_mass_kg: 3.0,
            foot_mass_kg: 1.0,
            hip_stiffness_nm_per_rad: 25.0,
            hip_damping_nms_per_rad: 2.0,
            k1_n_per_m: 6000.0,
            k2_n_per_m: 6000.0,
            k3_n_per_m: 10000.0,
            c1_ns_per_m: 300.0,
            c2_ns_per_m: 650.0,
            actuator_force_n: 600.0,
            hip_inertia_kg_m2: 20.0 * (0.3 * 0.3 + 0.2 * 0.2) / 12.0,
            hip_com_height_m: 0.0,
            thigh_distance_m: 0.2,
            tibia_distance_m: 0.55,
            foot_distance_m: 0.75,
            thigh_inertia_kg_m2: 6.0 * 0.4 * 0.4 / 12.0,
            tibia_inertia_kg_m2: 3.0 * 0.4 * 0.4 / 12.0,
            foot_inertia_kg_m2: 0.01,
            stroke_m: 0.1,
            stop_stiffness_n_per_m: 60_000.0,
            stop_dissipation_s_per_m: 1.0,
            foot_sphere_count: 20,
            foot_sphere_radius_m: 0.012,
            foot_arc_half_angle_rad: std::f64::consts::FRAC_PI_4,
            contact_stiffness: 1.0e5,
            contact_exponent: 1.0,
            contact_dissipation_s_per_m: 2.0,
            friction: 1.0,
            friction_smoothing_m_per_s: 0.05,
            gravity_m_per_s2: 9.81,
            time_step_s: 2.0e-4,
            diverged_speed: 200.0,
        }
    }
}

/// A parameter that cannot be simulated: which, its value, and what would be accepted.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterError {
    /// Name of the field, as in TOML.
    pub key: &'static str,
    /// The value that was given.
    pub value: f64,
    /// What is accepted instead.
    pub accepted: &'static str,
}

impl fmt::Display for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "body parameter `{}` is {}, but it must be {}",
            self.key, self.value, self.accepted
        )
    }
}

impl std::error::Error for ParameterError {}

impl BodyParameters {
    /// Total mass, in kg (40 kg by default).
    pub fn total_mass_kg(&self) -> f64 {
        self.hip_mass_kg + 2.0 * (self.thigh_mass_kg + self.tibia_mass_kg + self.foot_mass_kg)
    }

    /// What can be simulated but is probably not meant, a sentence each; none for the default body.
    pub fn warnings(&self) -> Vec<String> {
        let default = Self::default();
        let mut warnings = Vec::new();
        let segments = [
            (
                "thigh_distance_m",
                self.thigh_distance_m,
                default.thigh_distance_m,
            ),
            (
                "tibia_distance_m",
                self.tibia_distance_m,
                default.tibia_distance_m,
            ),
            (
                "foot_distance_m",
                self.foot_distance_m,
                default.foot_distance_m,
            ),
        ];
        let scale = self.leg_length_m / default.leg_length_m;
        if scale != 1.0 && segments.iter().all(|(_, value, usual)| value == usual) {
            let square = scale * scale;
            let sizes = [
                ("stroke_m", self.stroke_m, default.stroke_m, scale),
                (
                    "foot_arc_radius_m",
                    self.foot_arc_radius_m,
                    default.foot_arc_radius_m,
                    scale,
                ),
                (
                    "thigh_inertia_kg_m2",
                    self.thigh_inertia_kg_m2,
                    default.thigh_inertia_kg_m2,
                    square,
                ),
                (
                    "tibia_inertia_kg_m2",
                    self.tibia_inertia_kg_m2,
                    default.tibia_inertia_kg_m2,
                    square,
                ),
            ];
            let sizes = sizes
                .into_iter()
                .filter(|(_, value, usual, _)| value == usual);
            let scaled: Vec<String> = segments
                .into_iter()
                .map(|(name, value, _)| (name, value * scale))
                .chain(sizes.map(|(name, value, _, factor)| (name, value * factor)))
                .map(|(name, value)| format!("`{name}` {value:.3}"))
                .collect();
            warnings.push(format!(
                "`leg_length_m` is {}, but the segments are as far from the hip as in a leg of {} m; in proportion: \
                 {}",
                self.leg_length_m, default.leg_length_m, scaled.join(", ")
            ));
        }
        for (name, value, _) in segments {
            if value > self.leg_length_m {
                warnings.push(format!(
                    "`{name}` is {value}: the segment's centre of mass lies below the sole of a leg of {} m",
                    self.leg_length_m
                ));
            }
        }
        let weight_n = self.total_mass_kg() * self.gravity_m_per_s2;
        if weight_n > 2.0 * self.actuator_force_n {
            warnings.push(format!(
                "the body weighs {weight_n:.0} N, more than both actuators' `actuator_force_n` of {} N can lift",
                self.actuator_force_n
            ));
        }
        let depth_m = self.standing_depth_m(weight_n);
        if depth_m > 0.1 * self.foot_arc_radius_m {
            warnings.push(format!(
                "on one foot the body sinks about {depth_m:.2} m into the ground; increase `contact_stiffness`"
            ));
        }
        warnings
    }

    /// How far one upright foot sinks into flat ground under a weight at rest, in m; infinite if nothing carries it.
    fn standing_depth_m(&self, weight_n: f64) -> f64 {
        let last = self.foot_sphere_count.saturating_sub(1) as f64;
        let of_sphere = |j: usize| match last {
            0.0 => 1.0,
            last => (self.foot_arc_half_angle_rad * (2.0 * j as f64 / last - 1.0)).cos(),
        };
        let lowest = (0..self.foot_sphere_count)
            .map(of_sphere)
            .fold(-1.0, f64::max);
        let arc_m = self.foot_arc_radius_m - self.foot_sphere_radius_m;
        let force_n = |depth_m: f64| -> f64 {
            let of_depth = |j| (depth_m - arc_m * (lowest - of_sphere(j))).max(0.0);
            let spheres = (0..self.foot_sphere_count).map(of_depth);
            spheres
                .map(|d| self.contact_stiffness * d.powf(self.contact_exponent))
                .sum()
        };
        // The lowest sphere alone would sink this far.
        let mut deepest = (weight_n / self.contact_stiffness).powf(1.0 / self.contact_exponent);
        if !deepest.is_finite() {
            return deepest;
        }
        let mut least = 0.0;
        for _ in 0..50 {
            let middle = 0.5 * (least + deepest);
            if force_n(middle) < weight_n {
                least = middle;
            } else {
                deepest = middle;
            }
        }
        deepest
    }

    /// Checks every field.
    ///
    /// # Errors
    /// The first field out of range, with its value and what is accepted.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let check = |key, value: f64, ok: bool, accepted| {
            if ok && value.is_finite() {
                Ok(())
            } else {
                Err(ParameterError {
                    key,
                    value,
                    accepted,
                })
            }
        };
        macro_rules! positive {
            ($($field:ident),+) => {
                $(check(stringify!($field), self.$field, self.$field > 0.0, "greater than 0")?;)+
            };
        }
        macro_rules! not_negative {
            ($($field:ident),+) => {
                $(check(stringify!($field), self.$field, self.$field >= 0.0, "0 or greater")?;)+
            };
        }
        positive!(
            leg_length_m,
            foot_arc_radius_m,
            hip_mass_kg,
            thigh_mass_kg,
            tibia_mass_kg,
            foot_mass_kg,
            hip_inertia_kg_m2,
            thigh_distance_m,
            tibia_distance_m,
            foot_distance_m,
            stroke_m,
            foot_sphere_radius_m,
            foot_arc_half_angle_rad,
            friction_smoothing_m_per_s,
            time_step_s,
            diverged_speed
        );
        not_negative!(
            hip_stiffness_nm_per_rad,
            hip_damping_nms_per_rad,
            k1_n_per_m,
            k2_n_per_m,
            k3_n_per_m,
            c1_ns_per_m,
            c2_ns_per_m,
            actuator_force_n,
            thigh_inertia_kg_m2,
            tibia_inertia_kg_m2,
            foot_inertia_kg_m2,
            stop_stiffness_n_per_m,
            stop_dissipation_s_per_m,
            contact_stiffness,
            contact_dissipation_s_per_m,
            friction,
            gravity_m_per_s2
        );
        macro_rules! at_most {
            ($bound:literal, $accepted:literal, $($field:ident),+) => {
                $(check(stringify!($field), self.$field, self.$field <= $bound, $accepted)?;)+
            };
        }
        // Far beyond any animal or machine that walks; more is a slip of the unit or of the decimal point.
        at_most!(
            1e4,
            "at most 10000",
            hip_mass_kg,
            thigh_mass_kg,
            tibia_mass_kg,
            foot_mass_kg
        );
        at_most!(
            100.0,
            "at most 100",
            leg_length_m,
            thigh_distance_m,
            tibia_distance_m,
            foot_distance_m
        );
        check(
            "hip_com_height_m",
            self.hip_com_height_m,
            self.hip_com_height_m.abs() <= 2.0,
            "between -2 and 2",
        )?;
        check(
            "contact_exponent",
            self.contact_exponent,
            (1.0..=3.0).contains(&self.contact_exponent),
            "between 1 and 3",
        )?;
        check(
            "foot_arc_half_angle_rad",
            self.foot_arc_half_angle_rad,
            self.foot_arc_half_angle_rad <= std::f64::consts::PI,
            "at most pi",
        )?;
        check(
            "foot_sphere_radius_m",
            self.foot_sphere_radius_m,
            self.foot_sphere_radius_m < self.foot_arc_radius_m,
            "smaller than foot_arc_radius_m",
        )?;
        check(
            "foot_arc_radius_m",
            self.foot_arc_radius_m,
            self.foot_arc_radius_m <= self.leg_length_m,
            "at most leg_length_m",
        )?;
        check(
            "foot_sphere_count",
            self.foot_sphere_count as f64,
            (1..=1000).contains(&self.foot_sphere_count),
            "between 1 and 1000",
        )?;
        check(
            "time_step_s",
            self.time_step_s,
            self.time_step_s <= 0.01,
            "at most 0.01 (the springs would not be resolved)",
        )
    }
}
