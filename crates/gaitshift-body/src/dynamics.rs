//! Closed-form forward dynamics and their integration.
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
//! The step is semi-implicit Euler: velocities from the accelerations of the old state, positions
//! from the new velocities. Right and left contributions are added to each other before anything
//! else, so that mirrored states give mirrored results to the last bit.

use crate::contact::{ArcMotion, Sole, sphere_center};
use crate::energy::EnergyAccount;
use crate::{BodyParameters, BodyState, FootContact, LegState, Meter, ParameterError, Terrain};

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

/// Outcome of [`Body::advance`]: means over the steps taken.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AdvanceReport {
    /// A number became infinite, undefined or absurdly fast: the state is not to be used.
    pub diverged: bool,
    /// Mean force of each actuator, in N.
    pub actuator_n: [f64; 2],
    /// Mean normal ground reaction force on each foot, in N.
    pub normal_n: [f64; 2],
    /// Mean tangential ground reaction force on each foot, in N.
    pub tangential_n: [f64; 2],
}

impl AdvanceReport {
    /// The report over `steps` steps, which this is of, and `more_steps` steps after them, which `next` is of.
    pub fn then(&self, steps: u32, next: &Self, more_steps: u32) -> Self {
        let (a, b) = (f64::from(steps), f64::from(more_steps));
        let mean = |x: [f64; 2], y: [f64; 2]| {
            std::array::from_fn(|i| (a * x[i] + b * y[i]) / (a + b).max(1.0))
        };
        Self {
            diverged: self.diverged || next.diverged,
            actuator_n: mean(self.actuator_n, next.actuator_n),
            normal_n: mean(self.normal_n, next.normal_n),
            tangential_n: mean(self.tangential_n, next.tangential_n),
        }
    }
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
    fn contact_of<const ON_TERRAIN: bool>(
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

    /// Accelerations in a state under actuator forces in N (not limited here).
    #[inline]
    pub fn accelerations(&self, s: &BodyState, actuator_n: [f64; 2]) -> Accelerations {
        match self.terrain {
            None => self.accelerations_under::<false>(s, actuator_n, None),
            Some(_) => self.accelerations_under::<true>(s, actuator_n, None),
        }
    }

    /// [`Body::accelerations`] with an external force on the hip axis, forward and up, in N.
    ///
    /// It acts at the axis, so that it has no moment about it: it enters the hip's 2×2 system alone.
    #[inline(always)]
    fn accelerations_under<const ON_TERRAIN: bool>(
        &self,
        s: &BodyState,
        actuator_n: [f64; 2],
        push_n: Option<[f64; 2]>,
    ) -> Accelerations {
        let p = &self.parameters;
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
            let mass = self.leg_mass - g.first_moment * ratio;
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
        let p = &self.parameters;
        let beyond = leg.thigh.abs() - p.stroke_m;
        if beyond <= 0.0 {
            return (0.0, 0.0);
        }
        let side = leg.thigh.signum();
        let elastic = p.stop_stiffness_n_per_m * beyond;
        let force = elastic * (1.0 + p.stop_dissipation_s_per_m * side * leg.thigh_dot);
        (-side * force.max(0.0), -side * elastic)
    }

    /// Integrates `steps` steps of `time_step_s` under constant commands in [-1, 1] (limited to that
    /// range; force = command · F), adding work and dissipation to `account`.
    pub fn advance(
        &self,
        s: &mut BodyState,
        command: [f64; 2],
        steps: u32,
        account: &mut EnergyAccount,
    ) -> AdvanceReport {
        self.advance_on_its_ground(s, command, None, steps, account, None)
    }

    /// [`Body::advance`] while an external force, forward and up in N, pushes the hip axis. Its work is booked
    /// as [`EnergyAccount::external_work`].
    pub fn advance_pushed(
        &self,
        s: &mut BodyState,
        command: [f64; 2],
        push_n: [f64; 2],
        steps: u32,
        account: &mut EnergyAccount,
    ) -> AdvanceReport {
        self.advance_on_its_ground(s, command, Some(push_n), steps, account, None)
    }

    /// [`Body::advance`], or with a push [`Body::advance_pushed`], to the same bits, while a meter looks at every
    /// integration step.
    pub fn advance_metered(
        &self,
        s: &mut BodyState,
        command: [f64; 2],
        push_n: Option<[f64; 2]>,
        steps: u32,
        account: &mut EnergyAccount,
        meter: &mut Meter,
    ) -> AdvanceReport {
        self.advance_on_its_ground(s, command, push_n, steps, account, Some(meter))
    }

    /// Inlined like [`Body::advance_under`]: the ground is chosen once for all steps.
    #[inline(always)]
    fn advance_on_its_ground(
        &self,
        s: &mut BodyState,
        command: [f64; 2],
        push_n: Option<[f64; 2]>,
        steps: u32,
        account: &mut EnergyAccount,
        meter: Option<&mut Meter>,
    ) -> AdvanceReport {
        match self.terrain {
            None => self.advance_under::<false>(s, command, push_n, steps, account, meter),
            Some(_) => self.advance_on_terrain(s, command, push_n, steps, account, meter),
        }
    }

    #[inline(never)]
    fn advance_on_terrain(
        &self,
        s: &mut BodyState,
        command: [f64; 2],
        push_n: Option<[f64; 2]>,
        steps: u32,
        account: &mut EnergyAccount,
        meter: Option<&mut Meter>,
    ) -> AdvanceReport {
        self.advance_under::<true>(s, command, push_n, steps, account, meter)
    }

    /// Inlined into its callers, so that a body that nobody pushes or meters, and one on flat ground, computes nothing for it: a look at
    /// the terrain for each foot in each step would cost some 5 % of the time.
    #[inline(always)]
    fn advance_under<const ON_TERRAIN: bool>(
        &self,
        s: &mut BodyState,
        command: [f64; 2],
        push_n: Option<[f64; 2]>,
        steps: u32,
        account: &mut EnergyAccount,
        mut meter: Option<&mut Meter>,
    ) -> AdvanceReport {
        let p = &self.parameters;
        let dt = p.time_step_s;
        let limit = |c: f64| c.clamp(-1.0, 1.0) * p.actuator_force_n;
        let force = [limit(command[0]), limit(command[1])];
        let mut report = AdvanceReport {
            actuator_n: force,
            ..AdvanceReport::default()
        };
        for _ in 0..steps {
            let a = self.accelerations_under::<ON_TERRAIN>(s, force, push_n);
            let old = *s;
            step_semi_implicit(s, &a, dt);
            self.book(&old, s, &a, dt, account);
            if let Some(meter) = meter.as_deref_mut() {
                meter.step(self, &old, s, &a, dt);
            }
            if let Some([forward_n, up_n]) = push_n {
                account.external_work += (forward_n * 0.5 * (old.x_dot + s.x_dot)
                    + up_n * 0.5 * (old.z_dot + s.z_dot))
                    * dt;
            }
            for i in 0..2 {
                report.normal_n[i] += a.forces[i].contact.normal_n;
                report.tangential_n[i] += a.forces[i].contact.tangential_n;
            }
        }
        let count = f64::from(steps.max(1));
        for i in 0..2 {
            report.normal_n[i] /= count;
            report.tangential_n[i] /= count;
        }
        report.diverged = !s.is_sound(p.diverged_speed);
        report
    }

    /// Work and losses of one step, each force times the mean of the old and the new velocity.
    #[inline]
    fn book(
        &self,
        old: &BodyState,
        new: &BodyState,
        a: &Accelerations,
        dt: f64,
        account: &mut EnergyAccount,
    ) {
        let p = &self.parameters;
        let mut hip = [0.0; 2];
        let mut c1 = [0.0; 2];
        let mut c2 = [0.0; 2];
        let mut stops = [0.0; 2];
        let mut normal = [0.0; 2];
        let mut friction = [0.0; 2];
        for i in 0..2 {
            let (o, n) = (&old.legs[i], &new.legs[i]);
            let f = &a.forces[i];
            let h_dot = 0.5 * (o.thigh_dot + n.thigh_dot);
            let work = f.actuator_n * h_dot * dt;
            account.actuator_work[i] += work;
            account.actuator_positive_work[i] += work.max(0.0);
            hip[i] = p.hip_damping_nms_per_rad
                * old.phi_dot(i)
                * 0.5
                * (old.phi_dot(i) + new.phi_dot(i))
                * dt;
            c1[i] = p.c1_ns_per_m * o.d_dot() * 0.5 * (o.d_dot() + n.d_dot()) * dt;
            let old_rate = o.d_dot() - o.w_dot();
            let new_rate = n.d_dot() - n.w_dot();
            c2[i] = p.c2_ns_per_m * old_rate * 0.5 * (old_rate + new_rate) * dt;
            stops[i] = -(f.stop_n - f.stop_elastic_n) * h_dot * dt;
            normal[i] = f.contact.normal_loss_w * dt;
            friction[i] = f.contact.friction_loss_w * dt;
        }
        account.hip_dampers += hip[0] + hip[1];
        account.c1 += c1[0] + c1[1];
        account.c2 += c2[0] + c2[1];
        account.stops += stops[0] + stops[1];
        account.contact_normal += normal[0] + normal[1];
        account.friction += friction[0] + friction[1];
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

#[inline]
fn step_semi_implicit(s: &mut BodyState, a: &Accelerations, dt: f64) {
    s.x_dot += a.x * dt;
    s.z_dot += a.z * dt;
    s.theta_dot += a.theta * dt;
    s.x += s.x_dot * dt;
    s.z += s.z_dot * dt;
    s.theta += s.theta_dot * dt;
    for (leg, a) in s.legs.iter_mut().zip(&a.legs) {
        leg.psi_dot += a[0] * dt;
        leg.thigh_dot += a[1] * dt;
        leg.tibia_dot += a[2] * dt;
        leg.foot_dot += a[3] * dt;
        leg.psi += leg.psi_dot * dt;
        leg.thigh += leg.thigh_dot * dt;
        leg.tibia += leg.tibia_dot * dt;
        leg.foot += leg.foot_dot * dt;
    }
}
