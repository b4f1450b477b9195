//! Contact of a foot's spheres with the ground.
//!
//! Each sphere is pressed on by a Hunt-Crossley normal force (K. H. Hunt and F. R. E. Crossley,
//! "Coefficient of restitution interpreted as damping in vibroimpact", J. Appl. Mech. 42, 1975):
//!
//! `f_n = max(0, k δⁿ (1 + c δ̇))`, δ the penetration,
//!
//! and by Coulomb friction smoothed over the sliding speed `v_s`, in the manner of the smooth
//! sphere-half-space force of OpenSim (G. Serrancolí et al., IEEE TNSRE 27, 2019):
//!
//! `f_t = -μ f_n v_t / √(v_t² + v_s²)`.
//!
//! Both only take energy away: the elastic part `k δⁿ` stores and returns it, the remainder
//! `(f_n - k δⁿ) δ̇` is never negative, nor is `-f_t v_t`.
//!
//! On ground that is not flat, normal and tangent are those of the place nearest to the sphere's centre
//! ([`Terrain`]).

use crate::{BodyParameters, Terrain};

/// What the ground does to one foot at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FootContact {
    /// Forward force on the foot, in N: on flat ground the tangential one.
    pub tangential_n: f64,
    /// Upward force on the foot, in N: on flat ground the normal one.
    pub normal_n: f64,
    /// Moment of both about the hip axis, in the sense of the leg angle, in N m.
    pub moment_nm: f64,
    /// Elastic energy stored in the contact, in J.
    pub elastic_j: f64,
    /// Power lost in the normal direction, in W (never negative).
    pub normal_loss_w: f64,
    /// Power lost to friction, in W (never negative).
    pub friction_loss_w: f64,
}

/// The sole of a foot: its spheres on an arc, with what does not change precomputed.
#[derive(Debug, Clone)]
pub(crate) struct Sole {
    /// Radius of the circle of sphere centres, in m.
    arc_m: f64,
    sphere_m: f64,
    first_angle: f64,
    spacing: f64,
    /// sin and cos of each sphere's angle about the leg's line.
    directions: Vec<(f64, f64)>,
    stiffness: f64,
    exponent: f64,
    dissipation: f64,
    friction: f64,
    smoothing_squared: f64,
}

/// Where the centre of a foot's arc is and how it moves; inputs of [`Sole::contact`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct ArcMotion {
    /// Height of the arc's centre above the ground, in m.
    pub height: f64,
    /// Position of the arc's centre relative to the hip axis, in m.
    pub from_hip: (f64, f64),
    pub x_dot: f64,
    pub z_dot: f64,
    pub psi: f64,
    pub sin_psi: f64,
    pub cos_psi: f64,
    pub psi_dot: f64,
}

impl Sole {
    pub fn new(p: &BodyParameters) -> Self {
        let count = p.foot_sphere_count;
        let (first_angle, spacing) = arc_layout(p);
        Self {
            arc_m: p.foot_arc_radius_m - p.foot_sphere_radius_m,
            sphere_m: p.foot_sphere_radius_m,
            first_angle,
            spacing,
            directions: (0..count)
                .map(|j| (first_angle + spacing * j as f64).sin_cos())
                .collect(),
            stiffness: p.contact_stiffness,
            exponent: p.contact_exponent,
            dissipation: p.contact_dissipation_s_per_m,
            friction: p.friction,
            smoothing_squared: p.friction_smoothing_m_per_s * p.friction_smoothing_m_per_s,
        }
    }

    /// The spheres that can touch the ground: a sphere at the angle α = ψ + β from the downward
    /// vertical touches when cos α > c, hence |α| < acos c ≤ (π/2) √(1 - c).
    fn candidates(&self, arc: &ArcMotion) -> std::ops::Range<usize> {
        let c = (arc.height - self.sphere_m) / self.arc_m;
        let count = self.directions.len();
        if c >= 1.0 {
            return 0..0;
        }
        if c <= 0.0 || self.spacing <= 0.0 || arc.psi.abs() > 1.5 {
            return 0..count;
        }
        let reach = std::f64::consts::FRAC_PI_2 * (1.0 - c).sqrt();
        let first = (-arc.psi - reach - self.first_angle) / self.spacing;
        let last = (-arc.psi + reach - self.first_angle) / self.spacing;
        // `as` saturates, so a sole rolled off its end gives an empty range.
        (first.ceil() as usize)..((last.floor() + 1.0) as usize).min(count)
    }

    /// Sum of the forces of all spheres.
    pub fn contact(&self, arc: &ArcMotion) -> FootContact {
        let mut sum = FootContact::default();
        for j in self.candidates(arc) {
            let (sin_b, cos_b) = self.directions[j];
            // Sphere centre relative to the arc's centre: R (sin α, -cos α).
            let sin_a = arc.sin_psi * cos_b + arc.cos_psi * sin_b;
            let cos_a = arc.cos_psi * cos_b - arc.sin_psi * sin_b;
            let depth = self.arc_m * cos_a + self.sphere_m - arc.height;
            if depth <= 0.0 {
                continue;
            }
            let x = self.arc_m * sin_a;
            let z = -self.arc_m * cos_a;
            let depth_rate = -(arc.z_dot + arc.psi_dot * x);
            // Material velocity of the lowest point of the sphere.
            let slip = arc.x_dot + arc.psi_dot * (self.sphere_m - z);
            let Pressed {
                elastic,
                normal,
                tangential,
            } = self.press(depth, depth_rate, slip);
            // Lever of the contact point about the hip: (v_x, v_z) turns into (-v_z, v_x).
            let lever_x = arc.from_hip.0 + x;
            let lever_z = arc.from_hip.1 + z - self.sphere_m;
            sum.tangential_n += tangential;
            sum.normal_n += normal;
            sum.moment_nm += normal * lever_x - tangential * lever_z;
            sum.elastic_j += elastic * depth / (self.exponent + 1.0);
            sum.normal_loss_w += (normal - elastic) * depth_rate;
            sum.friction_loss_w -= tangential * slip;
        }
        sum
    }

    /// Forces on a sphere that is `depth` within the ground.
    #[inline(always)]
    fn press(&self, depth: f64, depth_rate: f64, slip: f64) -> Pressed {
        let elastic = if self.exponent == 1.0 {
            self.stiffness * depth
        } else {
            self.stiffness * depth.powf(self.exponent)
        };
        let normal = (elastic * (1.0 + self.dissipation * depth_rate)).max(0.0);
        let tangential =
            -self.friction * normal * slip / (slip * slip + self.smoothing_squared).sqrt();
        Pressed {
            elastic,
            normal,
            tangential,
        }
    }

    /// [`Sole::contact`] on ground that is not flat; the arc's height counts from 0 and `x_m` is its place.
    pub fn contact_on(&self, terrain: &Terrain, arc: &ArcMotion, x_m: f64) -> FootContact {
        let mut sum = FootContact::default();
        let (from, to) = self.reach(x_m);
        let pieces = terrain.between(from, to);
        let highest = terrain.range(pieces.clone(), from, to).1;
        if arc.height - self.arc_m - self.sphere_m >= highest {
            return sum;
        }
        for &(sin_b, cos_b) in &self.directions {
            let x = self.arc_m * (arc.sin_psi * cos_b + arc.cos_psi * sin_b);
            let z = -self.arc_m * (arc.cos_psi * cos_b - arc.sin_psi * sin_b);
            if arc.height + z - self.sphere_m >= highest {
                continue;
            }
            let nearest = terrain.nearest(pieces.clone(), x_m + x, arc.height + z);
            let depth = self.sphere_m - nearest.distance;
            if depth <= 0.0 {
                continue;
            }
            let (nx, nz) = nearest.normal;
            // Velocity of the sphere's centre, and that of its point on the ground.
            let centre = (arc.x_dot - arc.psi_dot * z, arc.z_dot + arc.psi_dot * x);
            let depth_rate = -(centre.0 * nx + centre.1 * nz);
            let slip = centre.0 * nz - centre.1 * nx + arc.psi_dot * self.sphere_m;
            let f = self.press(depth, depth_rate, slip);
            let forward = f.normal * nx + f.tangential * nz;
            let up = f.normal * nz - f.tangential * nx;
            let lever_x = arc.from_hip.0 + x - self.sphere_m * nx;
            let lever_z = arc.from_hip.1 + z - self.sphere_m * nz;
            sum.tangential_n += forward;
            sum.normal_n += up;
            sum.moment_nm += up * lever_x - forward * lever_z;
            sum.elastic_j += f.elastic * depth / (self.exponent + 1.0);
            sum.normal_loss_w += (f.normal - f.elastic) * depth_rate;
            sum.friction_loss_w -= f.tangential * slip;
        }
        sum
    }

    /// How far the ground can touch a sole whose arc's centre is at `x_m`, and as far again as a sphere is wide.
    fn reach(&self, x_m: f64) -> (f64, f64) {
        let half = self.arc_m + 2.0 * self.sphere_m;
        (x_m - half, x_m + half)
    }

    /// Least distance of the spheres from ground that is not flat, in m, negative within it.
    pub fn clearance(&self, terrain: &Terrain, psi: f64, (x_m, z_m): (f64, f64)) -> f64 {
        let (sin_psi, cos_psi) = psi.sin_cos();
        let (from, to) = self.reach(x_m);
        let pieces = terrain.between(from, to);
        let distance = |(sin_b, cos_b): &(f64, f64)| {
            let x = self.arc_m * (sin_psi * cos_b + cos_psi * sin_b);
            let z = -self.arc_m * (cos_psi * cos_b - sin_psi * sin_b);
            terrain.nearest(pieces.clone(), x_m + x, z_m + z).distance - self.sphere_m
        };
        let distances = self.directions.iter().map(distance);
        distances.fold(f64::INFINITY, f64::min)
    }

    /// Height of the arc's centre at which the lowest sphere just touches, for the leg angle ψ.
    pub fn touching_height(&self, psi: f64) -> f64 {
        let (sin_psi, cos_psi) = psi.sin_cos();
        let lowest = self
            .directions
            .iter()
            .map(|(sin_b, cos_b)| cos_psi * cos_b - sin_psi * sin_b)
            .fold(f64::NEG_INFINITY, f64::max);
        self.arc_m * lowest + self.sphere_m
    }
}

/// Forces on one sphere, in N: elastic and whole normal force, and the tangential one.
struct Pressed {
    elastic: f64,
    normal: f64,
    tangential: f64,
}

fn arc_layout(p: &BodyParameters) -> (f64, f64) {
    if p.foot_sphere_count == 1 {
        (0.0, 0.0)
    } else {
        let half = p.foot_arc_half_angle_rad;
        (-half, 2.0 * half / (p.foot_sphere_count - 1) as f64)
    }
}

/// Centre of sphere `index` of a foot relative to the hip axis, `(x, z)` in m, for a leg at the
/// absolute angle `psi` whose foot is displaced by `foot` down the leg. For drawing and export.
pub fn sphere_center(p: &BodyParameters, psi: f64, foot: f64, index: usize) -> (f64, f64) {
    let (first, spacing) = arc_layout(p);
    let angle = psi + first + spacing * index as f64;
    let along = p.leg_length_m - p.foot_arc_radius_m + foot;
    let arc = p.foot_arc_radius_m - p.foot_sphere_radius_m;
    (
        along * psi.sin() + arc * angle.sin(),
        -along * psi.cos() - arc * angle.cos(),
    )
}
