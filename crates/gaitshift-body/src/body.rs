//! The body, ready to simulate: what follows from its parameters, where its feet are, how it stands.

use crate::contact::{ArcMotion, Sole, sphere_center};
use crate::{BodyParameters, BodyState, FootContact, LegState, ParameterError, Terrain};

/// The body, ready to simulate: validated parameters and what follows from them.
#[derive(Debug, Clone)]
pub struct Body {
    parameters: BodyParameters,
    sole: Sole,
    leg_mass: f64,
    leg_inertia: f64,
    /// The ground where it is not flat.
    terrain: Option<Box<Terrain>>,
}

/// Mass moments of one leg about the hip axis.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct LegGeometry {
    /// `S = Σ m ρ`, in kg m.
    pub first_moment: f64,
    /// `J = Σ (m ρ² + I)`, in kg m².
    pub second_moment: f64,
    /// `P = Σ m ρ̇`, in kg m/s.
    pub radial_momentum: f64,
    /// `Σ m ρ ρ̇`, in kg m²/s.
    pub coriolis: f64,
}

impl Body {
    /// Checks the parameters and prepares the body.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn new(parameters: BodyParameters) -> Result<Self, ParameterError> {
        parameters.validate()?;
        Ok(Self {
            sole: Sole::new(&parameters),
            leg_mass: parameters.thigh_mass_kg + parameters.tibia_mass_kg + parameters.foot_mass_kg,
            leg_inertia: parameters.thigh_inertia_kg_m2
                + parameters.tibia_inertia_kg_m2
                + parameters.foot_inertia_kg_m2,
            parameters,
            terrain: None,
        })
    }

    /// The same body on another ground.
    pub fn on(self, terrain: Terrain) -> Self {
        Self {
            terrain: (!terrain.is_flat()).then(|| Box::new(terrain)),
            ..self
        }
    }

    /// The ground, where it is not flat.
    pub fn terrain(&self) -> Option<&Terrain> {
        self.terrain.as_deref()
    }

    /// Height of the ground at `x`, in m.
    pub fn ground_height(&self, x: f64) -> f64 {
        self.terrain.as_ref().map_or(0.0, |t| t.height(x))
    }

    /// Height of the lowest point of a foot's sole over the ground, in m; negative where it is pressed in. On ground that is not
    /// flat, the least height of a sphere over the ground below its centre.
    pub fn sole_height(&self, s: &BodyState, leg: usize) -> f64 {
        let p = &self.parameters;
        let LegState { psi, foot, .. } = s.legs[leg];
        (0..p.foot_sphere_count)
            .map(|k| {
                let (x, z) = sphere_center(p, psi, foot, k);
                s.z + z - p.foot_sphere_radius_m - self.ground_height(s.x + x)
            })
            .fold(f64::INFINITY, f64::min)
    }

    /// The parameters of this body.
    pub fn parameters(&self) -> &BodyParameters {
        &self.parameters
    }

    pub(crate) fn leg_mass(&self) -> f64 {
        self.leg_mass
    }

    pub(crate) fn leg_inertia(&self) -> f64 {
        self.leg_inertia
    }

    pub(crate) fn leg_geometry(&self, leg: &LegState) -> LegGeometry {
        let p = &self.parameters;
        let thigh = p.thigh_mass_kg * (p.thigh_distance_m + leg.thigh);
        let tibia = p.tibia_mass_kg * (p.tibia_distance_m + leg.tibia);
        let foot = p.foot_mass_kg * (p.foot_distance_m + leg.foot);
        LegGeometry {
            first_moment: thigh + tibia + foot,
            second_moment: thigh * (p.thigh_distance_m + leg.thigh)
                + tibia * (p.tibia_distance_m + leg.tibia)
                + foot * (p.foot_distance_m + leg.foot)
                + self.leg_inertia,
            radial_momentum: p.thigh_mass_kg * leg.thigh_dot
                + p.tibia_mass_kg * leg.tibia_dot
                + p.foot_mass_kg * leg.foot_dot,
            coriolis: thigh * leg.thigh_dot + tibia * leg.tibia_dot + foot * leg.foot_dot,
        }
    }

    /// What the ground does to the foot of a leg in a state.
    pub fn foot_contact(&self, s: &BodyState, leg: usize) -> FootContact {
        let (sin_psi, cos_psi) = s.legs[leg].psi.sin_cos();
        self.contact_of::<true>(s, &s.legs[leg], sin_psi, cos_psi)
    }

    #[inline]
    pub(crate) fn contact_of<const ON_TERRAIN: bool>(
        &self,
        s: &BodyState,
        leg: &LegState,
        sin_psi: f64,
        cos_psi: f64,
    ) -> FootContact {
        let p = &self.parameters;
        let along = p.leg_length_m - p.foot_arc_radius_m + leg.foot;
        let height = s.z - along * cos_psi;
        if ON_TERRAIN && let Some(terrain) = &self.terrain {
            let arc = arc_motion(s, leg, sin_psi, cos_psi, along, height);
            return self.sole.contact_on(terrain, &arc, s.x + arc.from_hip.0);
        }
        if height >= p.foot_arc_radius_m {
            return FootContact::default();
        }
        self.sole
            .contact(&arc_motion(s, leg, sin_psi, cos_psi, along, height))
    }

    /// Height of the hip axis, in m, at which the lower sole just touches the ground.
    pub fn lowest_hip_height(&self, s: &BodyState) -> f64 {
        let p = &self.parameters;
        let height = |leg: &LegState| {
            (p.leg_length_m - p.foot_arc_radius_m + leg.foot) * leg.psi.cos()
                + self.sole.touching_height(leg.psi)
        };
        let on_flat = height(&s.legs[0]).max(height(&s.legs[1]));
        match &self.terrain {
            None => on_flat,
            Some(terrain) => self.lowest_hip_height_on(terrain, s, on_flat),
        }
    }

    /// The same on ground that is not flat, by bisection between its lowest and its highest point below the body.
    fn lowest_hip_height_on(&self, terrain: &Terrain, s: &BodyState, on_flat: f64) -> f64 {
        let p = &self.parameters;
        let along = |leg: &LegState| p.leg_length_m - p.foot_arc_radius_m + leg.foot;
        let clears = |z: f64| {
            s.legs.iter().all(|leg| {
                let (sin_psi, cos_psi) = leg.psi.sin_cos();
                let along = along(leg);
                let centre = (s.x + along * sin_psi, z - along * cos_psi);
                self.sole.clearance(terrain, leg.psi, centre) >= 0.0
            })
        };
        let reach = p.foot_arc_radius_m + along(&s.legs[0]).abs().max(along(&s.legs[1]).abs());
        let (from, to) = (s.x - reach, s.x + reach);
        let range = terrain.range(terrain.between(from, to), from, to);
        let (mut low, mut high) = (on_flat + range.0, on_flat + range.1);
        loop {
            let middle = 0.5 * (low + high);
            if !(low < middle && middle < high) {
                return high;
            }
            if clears(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
    }
}

impl BodyState {
    /// The body upright on straight legs at rest, its soles just touching the ground.
    pub fn standing(body: &Body) -> Self {
        Self::with_leg_angles(body, [0.0; 2])
    }

    /// The body at rest with the given leg angles, its lower sole just touching the ground.
    pub fn with_leg_angles(body: &Body, psi: [f64; 2]) -> Self {
        let mut state = Self::default();
        for (leg, psi) in state.legs.iter_mut().zip(psi) {
            leg.psi = psi;
        }
        state.z = body.lowest_hip_height(&state);
        state
    }
}

/// Place and motion of the centre of a foot's arc, `along` down the leg and at `height`.
#[inline(always)]
fn arc_motion(
    s: &BodyState,
    leg: &LegState,
    sin_psi: f64,
    cos_psi: f64,
    along: f64,
    height: f64,
) -> ArcMotion {
    ArcMotion {
        height,
        from_hip: (along * sin_psi, -along * cos_psi),
        x_dot: s.x_dot + leg.foot_dot * sin_psi + along * leg.psi_dot * cos_psi,
        z_dot: s.z_dot - leg.foot_dot * cos_psi + along * leg.psi_dot * sin_psi,
        psi: leg.psi,
        sin_psi,
        cos_psi,
        psi_dot: leg.psi_dot,
    }
}
