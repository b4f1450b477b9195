//! A run that takes a second, and observers for it; motions of a controller that are disturbed.
#![allow(dead_code)] // Each test file uses some of it.

use gaitshift_analysis::recording::Recording;
use gaitshift_body::Body;
use gaitshift_experiment::{
    CommandProfile, Controller, Deterministic, Experiment, Judgement, Observer, Progress, Rollout,
};
use gaitshift_task::{Disturbance, Environment, Overrides};
use std::path::Path;

/// A run of 6000 steps that passes through three phases, three evaluations and two checkpoints.
pub const TINY: &str = r#"
base = "fast"
name = "tiny"
[learner]
actor_hidden = [16, 16]
critic_hidden = [16, 16]
batch_size = 128
threads = 1
[training]
environments = 4
steps_per_update = 8
learning_starts = 500
metrics_interval_steps = 1000
evaluation_interval_steps = 2000
checkpoint_interval_steps = 3000
replay_capacity = 4000
[training.rehearsal]
states = 1000
[[curriculum.phases]]
name = "one"
steps = 2000
omega_v = [-0.2, 0.2]
[[curriculum.phases]]
name = "two"
steps = 2500
omega_v = [-0.5, 3.5]
learner = { learning_rate = 1e-3, horizon = 100.0 }
learner_end = { learning_rate = 1e-4, alpha = 0.05, horizon = 60.0 }
[curriculum.phases.randomization]
share = 0.8
latency_s = [0.0, 0.015]
body = { friction = [0.6, 1.2], hip_mass_kg = [0.9, 1.1] }
noise = { theta_rad = 0.01, h_velocity_m_per_s = 0.02 }
actuator_factor = [0.7, 1.0]
pushes = { interval_s = 0.5, forward_n = [-80, 80], up_n = [-40, 40], duration_s = [0.05, 0.15] }
terrain = { slope_rad = [-0.05, 0.05], steps = { height_m = [-0.01, 0.01] }, uneven = { height_m = [0.0, 0.005] } }
[[curriculum.phases]]
name = "three"
steps = 1500
omega_v = [-0.5, 3.5]
learner = { rehearsal = 10.0 }
learner_end = { rehearsal = 2.0 }
[curriculum.phases.randomization]
share = 0.8
latency_s = [0.0, 0.015]
body = { friction = [0.6, 1.2], hip_mass_kg = [0.9, 1.1] }
noise = { theta_rad = 0.01, h_velocity_m_per_s = 0.02 }
"#;

/// A line of `evaluations.jsonl`, with line ends to be taken out, as far as its reader needs it.
pub const EVALUATION: &str = r#"{"step":800,"elapsed_s":1.5,"met":2,"score":3.25,"accepted":false,"rows":[{"omega_v":0.0,
"gait":"walking","fell":false,"froude":0.2,"new":1}],"to_running":[{"survived":true,"gait_before":"walking",
"gait_after":"running"}],"to_walking":[],"checks":[{"name":"walks at 0","met":true}]}"#;

/// The run of [`TINY`].
pub fn tiny() -> Experiment {
    Experiment::parse(TINY, "tiny").unwrap()
}

/// The same without evaluations, which take most of its time.
pub fn unevaluated() -> Experiment {
    let mut experiment = tiny();
    experiment.training.evaluation_interval_steps = 1_000_000;
    experiment.curriculum.phases[2].learner = Overrides::default();
    experiment.curriculum.phases[2].learner_end = Overrides::default();
    experiment
}

/// Stops a run at about a step, and keeps what the run says.
#[derive(Default)]
pub struct Until {
    pub stop_at: Option<u64>,
    pub step: u64,
    pub evaluations: usize,
    pub notes: Vec<String>,
}

impl Until {
    pub fn step(step: u64) -> Self {
        Self {
            stop_at: Some(step),
            ..Self::default()
        }
    }
}

impl Observer for Until {
    fn progress(&mut self, progress: &Progress) {
        self.step = progress.step;
    }
    fn evaluated(&mut self, _: &Progress, judgement: &Judgement, _: bool) {
        assert_eq!(judgement.rows.len(), 8);
        self.evaluations += 1;
    }
    fn note(&mut self, text: &str) {
        self.notes.push(text.to_owned());
    }
    fn stop_requested(&self) -> bool {
        self.stop_at.is_some_and(|step| self.step >= step)
    }
}

pub fn file(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).unwrap()
}

pub fn text(folder: &Path, name: &str) -> String {
    String::from_utf8(file(folder, name)).unwrap()
}

/// What a controller does from a start, by its seed or the default one, on what a disturbance makes of its body.
pub fn moved(
    controller: &mut Controller,
    disturbance: &Disturbance,
    start: Option<u64>,
    omega_v: f64,
    duration_s: f64,
) -> Recording {
    let body = disturbance.place(Body::new(controller.body.clone()).unwrap());
    Rollout {
        body: &body,
        task: &controller.task,
        start: Environment::start(&body, &controller.task, start),
        profile: &CommandProfile::constant(omega_v),
        duration_s,
        seed: start.unwrap_or(0),
        disturbance: Some(disturbance),
        controller: "moved",
    }
    .record(&mut Deterministic(&mut controller.policy))
    .unwrap()
}
