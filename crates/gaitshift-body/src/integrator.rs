//! The integrator: semi-implicit Euler and the energy account of the same step.
//!
//! Velocities come from the accelerations of the old state, positions from the new velocities. Right and
//! left contributions are added to each other before anything else, so that mirrored states give mirrored
//! results to the last bit.

use crate::{Accelerations, Body, BodyState, EnergyAccount, Meter};

/// Outcome of [`Body::advance`]: means over the steps taken.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AdvanceReport {
    /// At the end of the steps a number is infinite, undefined or absurdly fast: the state is not to be used.
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
        match self.terrain() {
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
        let p = self.parameters();
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
        let p = self.parameters();
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
