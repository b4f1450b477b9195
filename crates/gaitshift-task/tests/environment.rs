//! Contract: an episode ends by pitch, by hip height or by the time limit, each with its name, and
//! only the last is a truncation; the energy term is the change of the body's total energy.

use gaitshift_body::{Body, BodyParameters, BodyState};
use gaitshift_task::{EndReason, Environment, TaskParameters};

fn body() -> Body {
    Body::new(BodyParameters::default()).unwrap()
}

fn run(task: &TaskParameters, start: BodyState, command: [f64; 2]) -> (EndReason, u32) {
    let body = body();
    let mut environment = Environment::new(&body, start, 0.0);
    loop {
        let outcome = environment.step(&body, task, &task.reward, command);
        if let Some(ended) = outcome.ended {
            return (ended, environment.periods);
        }
    }
}

#[test]
fn legs_that_give_way_end_by_hip_height() {
    let task = TaskParameters::default();
    let start = Environment::default_start(&body(), &task);
    let (ended, periods) = run(&task, start, [-1.0, -1.0]);
    assert_eq!(ended, EndReason::HipHeight);
    assert!(ended.is_termination() && periods < 200);
}

#[test]
fn the_hip_height_rule_can_be_switched_off_and_pitch_ends_the_fall() {
    let mut task = TaskParameters::default();
    task.termination.min_hip_height_m = 0.0;
    let mut start = Environment::default_start(&body(), &task);
    start.theta = 1.35;
    start.theta_dot = 30.0;
    assert_eq!(run(&task, start, [0.0, 0.0]).0, EndReason::Pitch);
}

#[test]
fn the_time_limit_is_a_truncation() {
    let mut task = TaskParameters::default();
    task.termination.time_limit_s = 0.1;
    let start = Environment::default_start(&body(), &task);
    let (ended, periods) = run(&task, start, [0.4, 0.4]);
    assert_eq!((ended, periods), (EndReason::TimeLimit, 10));
    assert!(!ended.is_termination());
}

#[test]
fn a_diverged_state_ends_the_episode_with_its_flag() {
    let task = TaskParameters::default();
    let mut start = Environment::default_start(&body(), &task);
    start.x_dot = f64::NAN;
    assert_eq!(run(&task, start, [0.0, 0.0]), (EndReason::Diverged, 1));
}

#[test]
fn the_energy_term_is_the_change_of_total_energy() {
    let (body, task) = (body(), TaskParameters::default());
    let start = Environment::default_start(&body, &task);
    let mut environment = Environment::new(&body, start, 1.0);
    let before = body.energy(&start).total();
    let outcome = environment.step(&body, &task, &task.reward, [0.8, 0.1]);
    let change = body.energy(&environment.state).total() - before;
    assert!(change.abs() > 1e-3);
    assert_eq!(outcome.terms.energy, -0.2 * change.abs());
}
