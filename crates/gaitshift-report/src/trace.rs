//! A motion at the integration step: what a row per control period is too coarse for.

use crate::{ReportError, Subject};
use gaitshift_analysis::recording::column;
use gaitshift_analysis::support::ContactRule;
use gaitshift_body::{Body, BodyState, EnergyAccount, sphere_center};
use gaitshift_experiment::{Deterministic, Simulation};
use gaitshift_task::Environment;
use std::ops::Range;

/// One integration step; pairs are right and left leg.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TraceRow {
    /// Time since the motion began, in s.
    pub time_s: f64,
    /// Vertical ground reaction, in N.
    pub normal_n: [f64; 2],
    /// Forward ground reaction, in N.
    pub tangential_n: [f64; 2],
    /// Ground reaction along the leg, in N; positive presses the leg together.
    pub axial_n: [f64; 2],
    /// Leg length from the hip axis to the sole, `l + h - d`, in m.
    pub length_m: [f64; 2],
    /// Velocity of the lowest point of the sole, forward and up, in m/s.
    pub sole_m_per_s: [[f64; 2]; 2],
    /// Height of the centre of mass, in m.
    pub com_z_m: f64,
    /// Kinetic, gravitational, leg springs' and hip springs' energy, in J.
    pub energies_j: [f64; 4],
}

/// A motion at the integration step.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trace {
    /// One per step.
    pub rows: Vec<TraceRow>,
    /// Whether it ended before its time, in a fall.
    pub fell: bool,
}

impl Trace {
    /// Follows a subject's default start under a command, from `from_s` to `to_s`.
    ///
    /// # Errors
    /// None at present; the motion of a body that falls ends early.
    pub fn follow(
        subject: &mut Subject,
        omega_v: f64,
        from_s: f64,
        to_s: f64,
    ) -> Result<Self, ReportError> {
        let Subject {
            controller, body, ..
        } = subject;
        let task = controller.task.clone();
        let start = Environment::default_start(body, &task);
        let mut simulation = Simulation::new(body, &task, start, omega_v);
        let mut policy = Deterministic(&mut controller.policy);
        let force_n = body.parameters().actuator_force_n;
        let steps = task.steps_per_period(body.parameters());
        let dt = body.parameters().time_step_s;
        let mut trace = Self::default();
        let mut row = Vec::new();
        while simulation.time_s() < to_s - 1e-9 {
            let (mut state, time_s) = (*simulation.state(), simulation.time_s());
            if simulation.step(omega_v, None, &mut policy).is_some() {
                trace.fell = true;
                break;
            }
            if time_s < from_s - 1e-9 {
                continue;
            }
            simulation.row(&mut row);
            let command = column::COMMAND.map(|column| row[column.index()]);
            for step in 0..steps {
                trace.rows.push(Self::row(
                    body,
                    &state,
                    command.map(|c| c.clamp(-1.0, 1.0) * force_n),
                    time_s + f64::from(step) * dt,
                ));
                body.advance(&mut state, command, 1, &mut EnergyAccount::default());
            }
        }
        Ok(trace)
    }

    fn row(body: &Body, s: &BodyState, actuator_n: [f64; 2], time_s: f64) -> TraceRow {
        let p = body.parameters();
        let forces = body.accelerations(s, actuator_n).forces;
        let energy = body.energy(s);
        let per_leg = |of: &dyn Fn(usize) -> f64| [of(0), of(1)];
        let sole = |i: usize| {
            let leg = &s.legs[i];
            // The lowest sphere; its centre moves with the leg, and its lowest point lies a radius below.
            let places = (0..p.foot_sphere_count).map(|k| sphere_center(p, leg.psi, leg.foot, k));
            let lowest = places
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .unwrap_or_default();
            let (x, z) = (lowest.0, lowest.1 - p.foot_sphere_radius_m);
            let (sin_psi, cos_psi) = leg.psi.sin_cos();
            [
                s.x_dot + leg.foot_dot * sin_psi - leg.psi_dot * z,
                s.z_dot - leg.foot_dot * cos_psi + leg.psi_dot * x,
            ]
        };
        TraceRow {
            time_s,
            normal_n: per_leg(&|i| forces[i].contact.normal_n),
            tangential_n: per_leg(&|i| forces[i].contact.tangential_n),
            axial_n: per_leg(&|i| {
                let (sin_psi, cos_psi) = s.legs[i].psi.sin_cos();
                forces[i].contact.normal_n * cos_psi - forces[i].contact.tangential_n * sin_psi
            }),
            length_m: per_leg(&|i| p.leg_length_m + s.legs[i].foot),
            sole_m_per_s: [sole(0), sole(1)],
            com_z_m: body.centre_of_mass(s).z,
            energies_j: [
                energy.kinetic,
                energy.gravitational,
                energy.leg_springs(),
                energy.hip_springs,
            ],
        }
    }

    /// At most some 800 rows of a stretch, evenly spaced, which is all that a figure needs; each with its place in the stretch,
    /// from 0 to 1.
    pub(crate) fn thinned(&self, range: &Range<usize>) -> impl Iterator<Item = (f64, &TraceRow)> {
        let length = range.len().max(1);
        let every = (length / 400).max(1);
        self.rows[range.clone()]
            .iter()
            .enumerate()
            .step_by(every)
            .map(move |(k, row)| (k as f64 / length as f64, row))
    }

    /// The stances of one leg in the trace, as ranges of rows, by [`ContactRule`] for a body of `weight_n`. What the trace
    /// begins or ends with is not whole and none of them.
    pub fn stances(&self, leg: usize, weight_n: f64) -> Vec<Range<usize>> {
        let mut contacts = self.contacts(leg, weight_n);
        contacts.retain(|contact| self.is_whole(contact));
        contacts
    }

    /// The same with the contacts that the trace begins or ends with.
    pub fn contacts(&self, leg: usize, weight_n: f64) -> Vec<Range<usize>> {
        let rule = ContactRule::default();
        let mut runs: Vec<Range<usize>> = Vec::new();
        let mut begun = None;
        for (k, row) in self.rows.iter().enumerate() {
            let force = row.normal_n[leg];
            match begun {
                None if force > rule.min_force_fraction * weight_n => begun = Some(k),
                Some(first) if force <= rule.release_force_fraction * weight_n => {
                    runs.push(first..k);
                    begun = None;
                }
                _ => {}
            }
        }
        runs.extend(begun.map(|first| first..self.rows.len()));
        let between = |from: usize, to: usize| self.rows[to].time_s - self.rows[from].time_s;
        let mut contacts: Vec<Range<usize>> = Vec::new();
        for run in runs {
            match contacts.last_mut() {
                Some(last) if between(last.end, run.start) < rule.min_gap_s => last.end = run.end,
                _ => contacts.push(run),
            }
        }
        contacts.retain(|c| !self.is_whole(c) || between(c.start, c.end) >= rule.min_contact_s);
        contacts
    }

    /// Whether a contact both begins and ends in the trace.
    fn is_whole(&self, contact: &Range<usize>) -> bool {
        contact.start > 0 && contact.end < self.rows.len()
    }
}
