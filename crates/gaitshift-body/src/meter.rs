//! What a motion does at the integration step, leg by leg and element by element: what a sample at the end of
//! a control period cannot show, such as an impact of one millisecond.

use crate::{Accelerations, Body, BodyState};

/// Sums over a motion and the extremes of its latest control period.
///
/// A motion is metered by [`Body::advance_metered`]; training does without.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Meter {
    /// Right and left leg.
    pub legs: [LegMeter; 2],
    /// Share of the period's integration steps in which no foot touches the ground, in [0, 1].
    pub flight_share: f64,
    /// Integration steps of the period so far, and how many of them in flight.
    steps: u32,
    flight_steps: u32,
}

/// What one leg does. Work, losses and releases are sums since the meter was made, in J.
///
/// A release is what an elastic element gives back, the sum of the falls of its energy; stretched and released over
/// a stride it gives as much as it takes, less what is lost beside it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LegMeter {
    /// Greatest normal ground reaction force of the period, in N.
    pub peak_normal_n: f64,
    /// Share of the period's integration steps in which the foot touches the ground, in [0, 1].
    pub contact_share: f64,
    /// Net work of the actuator, `∫F ḣ dt`.
    pub actuator_work: f64,
    /// Its positive work, `∫max(F ḣ, 0) dt`.
    pub actuator_positive_work: f64,
    /// `∫F² dt` of the actuator, in N² s.
    pub squared_force_n2_s: f64,
    /// `∫|F| dt` of the actuator, in N s.
    pub impulse_n_s: f64,
    /// The part of that integral in which the actuator presses on an end stop, in N s.
    pub impulse_at_stop_n_s: f64,
    /// Released by the leg springs `k1`, `k2`, `k3`, taken as one store.
    pub leg_spring_release: f64,
    /// Released by the hip spring.
    pub hip_spring_release: f64,
    /// Released by the end stops.
    pub stop_release: f64,
    /// Released by the compressed ground contact, up to the step before the latest.
    pub contact_release: f64,
    /// Dissipated in the hip damper.
    pub hip_damper: f64,
    /// Dissipated in the damper `c1`.
    pub c1: f64,
    /// Dissipated in the damper `c2`.
    pub c2: f64,
    /// Dissipated in the end stops.
    pub stops: f64,
    /// Dissipated by the normal contact forces.
    pub contact_normal: f64,
    /// Dissipated by friction.
    pub friction: f64,
    contact_steps: u32,
    /// Energy of the contact in the step before.
    contact_energy: Option<f64>,
}

/// Energies of the elastic elements of one leg, in J.
struct Stored {
    leg_springs: f64,
    hip_spring: f64,
    stops: f64,
}

impl Stored {
    fn of(body: &Body, s: &BodyState, leg: usize) -> Self {
        let p = body.parameters();
        let half = |k: f64, x: f64| 0.5 * k * x * x;
        let (d, w) = (s.legs[leg].d(), s.legs[leg].w());
        Self {
            leg_springs: half(p.k1_n_per_m, d) + half(p.k2_n_per_m, d - w) + half(p.k3_n_per_m, w),
            hip_spring: half(p.hip_stiffness_nm_per_rad, s.phi(leg)),
            stops: half(
                p.stop_stiffness_n_per_m,
                (s.legs[leg].thigh.abs() - p.stroke_m).max(0.0),
            ),
        }
    }
}

impl Meter {
    /// Begins a control period: its extremes and shares are those from here on.
    pub fn begin_period(&mut self) {
        (self.steps, self.flight_steps, self.flight_share) = (0, 0, 0.0);
        for leg in &mut self.legs {
            (leg.contact_steps, leg.contact_share, leg.peak_normal_n) = (0, 0.0, 0.0);
        }
    }

    /// One integration step from `old` to `new`. Work and losses are those of the body's account.
    pub(crate) fn step(
        &mut self,
        body: &Body,
        old: &BodyState,
        new: &BodyState,
        a: &Accelerations,
        dt: f64,
    ) {
        let p = body.parameters();
        self.steps += 1;
        let mut touching = false;
        for (i, leg) in self.legs.iter_mut().enumerate() {
            let (o, n) = (&old.legs[i], &new.legs[i]);
            let f = &a.forces[i];
            let contact = &f.contact;
            leg.peak_normal_n = leg.peak_normal_n.max(contact.normal_n);
            // On the face of a step the ground may push sideways alone.
            if contact.normal_n > 0.0 || contact.tangential_n != 0.0 {
                touching = true;
                leg.contact_steps += 1;
            }
            leg.contact_share = f64::from(leg.contact_steps) / f64::from(self.steps);

            let h_dot = 0.5 * (o.thigh_dot + n.thigh_dot);
            let work = f.actuator_n * h_dot * dt;
            leg.actuator_work += work;
            leg.actuator_positive_work += work.max(0.0);
            leg.squared_force_n2_s += f.actuator_n * f.actuator_n * dt;
            leg.impulse_n_s += f.actuator_n.abs() * dt;
            if o.thigh.abs() > p.stroke_m && f.actuator_n * o.thigh > 0.0 {
                leg.impulse_at_stop_n_s += f.actuator_n.abs() * dt;
            }

            let (before, after) = (Stored::of(body, old, i), Stored::of(body, new, i));
            leg.leg_spring_release += (before.leg_springs - after.leg_springs).max(0.0);
            leg.hip_spring_release += (before.hip_spring - after.hip_spring).max(0.0);
            leg.stop_release += (before.stops - after.stops).max(0.0);
            let stored = leg.contact_energy.replace(contact.elastic_j);
            leg.contact_release +=
                (stored.unwrap_or(contact.elastic_j) - contact.elastic_j).max(0.0);

            let mean = |old_rate: f64, new_rate: f64| 0.5 * (old_rate + new_rate);
            leg.hip_damper += p.hip_damping_nms_per_rad
                * old.phi_dot(i)
                * mean(old.phi_dot(i), new.phi_dot(i))
                * dt;
            leg.c1 += p.c1_ns_per_m * o.d_dot() * mean(o.d_dot(), n.d_dot()) * dt;
            let (old_rate, new_rate) = (o.d_dot() - o.w_dot(), n.d_dot() - n.w_dot());
            leg.c2 += p.c2_ns_per_m * old_rate * mean(old_rate, new_rate) * dt;
            leg.stops -= (f.stop_n - f.stop_elastic_n) * h_dot * dt;
            leg.contact_normal += contact.normal_loss_w * dt;
            leg.friction += contact.friction_loss_w * dt;
        }
        self.flight_steps += u32::from(!touching);
        self.flight_share = f64::from(self.flight_steps) / f64::from(self.steps);
    }
}
