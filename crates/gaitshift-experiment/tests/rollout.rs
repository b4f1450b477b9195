//! Contract: a rollout records every control period of the environment it moves, command by command, to the bit; it ends
//! with its duration or with the fall and says which; the task's time limit does not end it; a motion that diverges
//! ends with its last finite state.

use gaitshift_analysis::recording::{Column, column};
use gaitshift_body::{Body, BodyParameters};
use gaitshift_experiment::{CommandProfile, Rollout};
use gaitshift_task::{ACTION_SIZE, Environment, OBSERVATION_SIZE, TaskParameters};

type Observation = [f32; OBSERVATION_SIZE];
type Action = [f32; ACTION_SIZE];

/// Pushes both legs alike, by what it sees of the pitch.
fn push(observation: &Observation, action: &mut Action) {
    *action = [0.4 - 0.1 * observation[1], 0.3];
}

fn body() -> Body {
    Body::new(BodyParameters::default()).unwrap()
}

fn rollout<'a>(
    body: &'a Body,
    task: &'a TaskParameters,
    profile: &'a CommandProfile,
    duration_s: f64,
) -> Rollout<'a> {
    Rollout {
        body,
        task,
        start: Environment::start(body, task, Some(3)),
        profile,
        duration_s,
        seed: 3,
        disturbance: None,
        controller: "push",
    }
}

#[test]
fn it_is_the_environment_to_the_bit() {
    let (body, task) = (body(), TaskParameters::default());
    let profile = CommandProfile::ramp(0.5, 2.0, 0.05, 0.1);
    let recording = rollout(&body, &task, &profile, 0.2)
        .record(&mut push)
        .unwrap();
    assert_eq!(recording.len(), 1 + 20);
    let values = |name: Column| recording.column(name);
    let mut alone = Environment::new(&body, Environment::start(&body, &task, Some(3)), 0.5);
    for row in 1..recording.len() {
        // The command of a period is the one at its beginning.
        alone.omega_v = profile.at((row - 1) as f64 * task.control_period_s);
        let mut scaled = [0.0; OBSERVATION_SIZE];
        gaitshift_task::scale_observation(&alone.observation(), &mut scaled);
        let mut action = [0.0; ACTION_SIZE];
        push(&scaled, &mut action);
        let outcome = alone.step(&body, &task, &task.reward, action.map(f64::from));
        assert_eq!(values(column::OMEGA_V)[row], alone.omega_v);
        assert_eq!(values(column::X_M)[row], alone.state.x);
        assert_eq!(values(column::Z_M)[row], alone.state.z);
        assert_eq!(values(column::REWARD)[row], outcome.terms.sum());
        assert_eq!(
            values(column::ACTUATOR_POSITIVE_WORK_J)[row],
            alone.account.positive_work()
        );
    }
    let m = &recording.metadata;
    assert_eq!((m.seed, m.controller.as_str()), (3, "push"));
    assert_eq!(m.total_mass_kg, 40.0);
}

#[test]
fn a_fall_ends_it_and_the_time_limit_does_not() {
    let (body, mut task) = (body(), TaskParameters::default());
    task.termination.time_limit_s = 0.05;
    let profile = CommandProfile::constant(0.0);
    let limp = &mut |_: &Observation, action: &mut Action| *action = [-1.0, -1.0];
    let recording = rollout(&body, &task, &profile, 10.0).record(limp).unwrap();
    let m = &recording.metadata;
    assert!(m.fell && m.ended_by == "hip height", "{}", m.ended_by);
    assert!(recording.duration_s() > 0.05 && recording.duration_s() < 5.0);

    let short = rollout(&body, &task, &profile, 0.1)
        .record(&mut push)
        .unwrap();
    assert!(!short.metadata.fell && short.metadata.ended_by == "time limit");
    assert!((short.duration_s() - 0.1).abs() < 1e-9);
}

#[test]
fn a_motion_that_diverges_ends_with_its_last_finite_state() {
    let body = Body::new(BodyParameters {
        diverged_speed: 1e-6,
        ..BodyParameters::default()
    })
    .unwrap();
    let task = TaskParameters::default();
    let profile = CommandProfile::constant(0.0);
    let recording = rollout(&body, &task, &profile, 1.0)
        .record(&mut push)
        .unwrap();
    assert_eq!(recording.len(), 1);
    let m = &recording.metadata;
    assert!(m.fell && m.ended_by == "diverged", "{}", m.ended_by);
}
