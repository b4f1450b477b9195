//! A controller on a body, moved one control period at a time: what rollouts record and what is shown live.

use gaitshift_analysis::recording::RecordingMetadata;
use gaitshift_body::{AdvanceReport, Body, BodyState, LEFT, LegMeter, RIGHT, Terrain};
use gaitshift_task::{
    ACTION_SIZE, Disturbance, Disturbed, EndReason, Environment, OBSERVATION_SIZE, RewardTerms,
    TaskParameters, scale_observation,
};

/// Anything that turns a scaled observation into two commands in [-1, 1].
pub trait Control {
    /// Reads the 14 scaled observations, writes the commands of the right and the left actuator.
    fn act(&mut self, observation: &[f32; OBSERVATION_SIZE], action: &mut [f32; ACTION_SIZE]);
}

impl<F: FnMut(&[f32; OBSERVATION_SIZE], &mut [f32; ACTION_SIZE])> Control for F {
    fn act(&mut self, observation: &[f32; OBSERVATION_SIZE], action: &mut [f32; ACTION_SIZE]) {
        self(observation, action);
    }
}

/// A motion under way. Its time limit is not applied: it goes on until the body falls.
#[derive(Debug, Clone)]
pub struct Simulation {
    body: Body,
    task: TaskParameters,
    environment: Environment,
    periods: u64,
    action: [f32; ACTION_SIZE],
    report: AdvanceReport,
    terms: RewardTerms,
    disturbed: Option<Disturbed>,
}

impl Simulation {
    /// A motion that begins in `start` under the command `omega_v`.
    pub fn new(body: &Body, task: &TaskParameters, start: BodyState, omega_v: f64) -> Self {
        let mut task = task.clone();
        task.termination.time_limit_s = f64::INFINITY;
        let contact = [RIGHT, LEFT].map(|i| body.foot_contact(&start, i));
        Self {
            environment: Environment::new(body, start, omega_v),
            body: body.clone(),
            task,
            periods: 0,
            action: [0.0; ACTION_SIZE],
            report: AdvanceReport {
                normal_n: contact.map(|c| c.normal_n),
                tangential_n: contact.map(|c| c.tangential_n),
                ..AdvanceReport::default()
            },
            terms: RewardTerms::default(),
            disturbed: None,
        }
    }

    /// From now on, times counting from here, it is disturbed by noise that `seed` draws, latency, weak actuators and
    /// pushes that are not at a phase of the stride. The ground is the body's ([`Disturbance::place`]).
    pub fn disturb(&mut self, disturbance: &Disturbance, seed: u64) {
        self.disturbed = Disturbed::new(disturbance, self.body.parameters(), seed);
    }

    /// From now on rows have details ([`Simulation::detailed_row`]): what happens between them is looked at, too.
    pub fn record_details(&mut self) {
        self.environment.attach_meter();
    }

    /// What a recording of this motion says about itself, as long as the body is up.
    pub fn metadata(&self, controller: &str, seed: u64) -> RecordingMetadata {
        let p = self.body.parameters();
        RecordingMetadata {
            control_period_s: self.task.control_period_s,
            total_mass_kg: p.total_mass_kg(),
            gravity_m_per_s2: p.gravity_m_per_s2,
            leg_length_m: p.leg_length_m,
            body: serde_json::to_value(p).unwrap_or_default(),
            controller: controller.to_owned(),
            seed,
            fell: false,
            ended_by: EndReason::TimeLimit.name().to_owned(),
            disturbance: None,
            ground: self.body.terrain().map(Terrain::outline),
        }
    }

    /// The body that moves.
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// The reward's terms of the last control period, before the common factor.
    pub fn terms(&self) -> &RewardTerms {
        &self.terms
    }

    /// Its state.
    pub fn state(&self) -> &BodyState {
        &self.environment.state
    }

    /// Time since the start, in s: when the next control period begins.
    pub fn time_s(&self) -> f64 {
        self.periods as f64 * self.task.control_period_s
    }

    /// Length of a control period, in s.
    pub fn control_period_s(&self) -> f64 {
        self.task.control_period_s
    }

    /// Moves one control period under the command `omega_v`, while a force, forward and up in N, pushes the hip.
    /// Gives the reason if the body fell; after a failure ([`EndReason::is_failure`]) there is no row to be had.
    pub fn step(
        &mut self,
        omega_v: f64,
        push_n: Option<[f64; 2]>,
        control: &mut impl Control,
    ) -> Option<EndReason> {
        let environment = &mut self.environment;
        environment.omega_v = omega_v;
        let mut scaled = [0.0; OBSERVATION_SIZE];
        let observation = match &self.disturbed {
            None => environment.observation(),
            Some(disturbed) => disturbed.observation(environment),
        };
        scale_observation(&observation, &mut scaled);
        control.act(&scaled, &mut self.action);
        let command = self.action.map(f64::from);
        let (body, task) = (&self.body, &self.task);
        let outcome = match (&mut self.disturbed, push_n) {
            (Some(disturbed), push_n) => {
                disturbed.step(environment, body, task, &task.reward, command, push_n)
            }
            (None, None) => environment.step(body, task, &task.reward, command),
            (None, Some(push_n)) => {
                environment.step_pushed(body, task, &task.reward, command, push_n)
            }
        };
        self.periods += 1;
        self.report = outcome.report;
        self.terms = outcome.terms;
        outcome.ended
    }

    /// Goes on with another body in the same state; works and losses are counted anew.
    pub fn change_body(&mut self, body: Body) {
        self.environment.change_body(&body);
        self.body = body;
    }

    /// The row of the present time, in the order of `gaitshift_analysis::recording::COLUMNS`.
    pub fn row(&self, row: &mut Vec<f64>) {
        recording_row(
            &self.body,
            &self.environment,
            self.time_s(),
            self.action.map(f64::from),
            &self.report,
            &self.terms,
            row,
        );
    }

    /// The same with the details after it, if they are recorded.
    pub fn detailed_row(&self, row: &mut Vec<f64>) {
        self.row(row);
        push_details(&self.body, &self.environment, row);
    }
}

/// What follows the columns of a row in a recording with details, in the order of
/// `gaitshift_analysis::recording::DETAILS`; nothing without a meter.
fn push_details(body: &Body, environment: &Environment, row: &mut Vec<f64>) {
    let Some(meter) = environment.meter() else {
        return;
    };
    let centre = body.centre_of_mass(&environment.state);
    row.extend([centre.x, centre.z, centre.x_dot, centre.z_dot]);
    row.push(meter.flight_share);
    let mut pair = |of: fn(&LegMeter) -> f64| row.extend(meter.legs.each_ref().map(of));
    pair(|leg| leg.peak_normal_n);
    row.extend([RIGHT, LEFT].map(|leg| body.sole_height(&environment.state, leg)));
    let mut pair = |of: fn(&LegMeter) -> f64| row.extend(meter.legs.each_ref().map(of));
    pair(|leg| leg.contact_share);
    pair(|leg| leg.actuator_work);
    pair(|leg| leg.actuator_positive_work);
    pair(|leg| leg.squared_force_n2_s);
    pair(|leg| leg.impulse_n_s);
    pair(|leg| leg.impulse_at_stop_n_s);
    pair(|leg| leg.leg_spring_release);
    pair(|leg| leg.hip_spring_release);
    pair(|leg| leg.stop_release);
    pair(|leg| leg.contact_release);
    pair(|leg| leg.hip_damper);
    pair(|leg| leg.c1);
    pair(|leg| leg.c2);
    pair(|leg| leg.stops);
    pair(|leg| leg.contact_normal);
    pair(|leg| leg.friction);
}

/// The row of an environment at `time_s` after a control period under `command` with this report and these terms of the
/// reward, in the order of `gaitshift_analysis::recording::COLUMNS`.
pub fn recording_row(
    body: &Body,
    environment: &Environment,
    time_s: f64,
    command: [f64; ACTION_SIZE],
    report: &AdvanceReport,
    terms: &RewardTerms,
    row: &mut Vec<f64>,
) {
    let s = &environment.state;
    let (energy, account) = (body.energy(s), &environment.account);
    row.clear();
    row.extend([time_s, environment.omega_v, s.x, s.z, s.theta]);
    row.extend([s.x_dot, s.z_dot, s.theta_dot]);
    for i in [RIGHT, LEFT] {
        let leg = &s.legs[i];
        row.extend([s.phi(i), leg.thigh, leg.d(), leg.w()]);
        row.extend([s.phi_dot(i), leg.thigh_dot, leg.d_dot(), leg.w_dot()]);
    }
    row.extend(command);
    for i in [RIGHT, LEFT] {
        row.extend([
            report.actuator_n[i],
            report.normal_n[i],
            report.tangential_n[i],
        ]);
    }
    row.extend([energy.kinetic, energy.gravitational]);
    row.extend([energy.hip_springs, energy.leg_springs(), energy.elastic()]);
    row.extend([energy.contact, energy.stops]);
    row.extend([account.work(), account.positive_work()]);
    row.extend([account.dampers(), account.contact(), account.stops]);
    row.extend([
        terms.sum(),
        terms.energy,
        terms.velocity,
        terms.forward,
        terms.alive,
        terms.leg,
        terms.friction,
        terms.work,
    ]);
}
