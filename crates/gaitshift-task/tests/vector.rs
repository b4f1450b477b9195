//! Contract: an environment of a vector is the task to the last bit, whatever stands beside it and whatever the threads; a
//! seed gives the start that it gives everywhere; an episode goes on as Gymnasium's modes say; a simulation that
//! diverges leaves numbers behind.

use gaitshift_body::{Body, BodyParameters, LEFT};
use gaitshift_task::{
    AutoReset, Disturbance, Disturbed, Environment, INFO_SIZE, Opening, Push, Randomization,
    RewardParameters, TaskParameters, VectorEnvironment, VectorStep, info_names,
};

fn body() -> Body {
    Body::new(BodyParameters::default()).unwrap()
}

/// A task whose episodes last three periods.
fn short() -> TaskParameters {
    let mut task = TaskParameters::default();
    task.termination.time_limit_s = 3.0 * task.control_period_s;
    task
}

fn vector(task: TaskParameters, count: usize) -> VectorEnvironment {
    let mut vector = VectorEnvironment::new(body(), task, [-0.5, 3.5], count);
    for index in 0..count {
        vector.seed(index, 7 + index as u64);
        vector.reset(index, Opening::default());
    }
    vector
}

fn info(step: &VectorStep, name: &str) -> f64 {
    step.info[info_names(&RewardParameters::default())
        .iter()
        .position(|n| n == name)
        .unwrap()]
}

#[test]
fn a_seed_gives_the_start_that_it_gives_everywhere() {
    let (body, task) = (body(), TaskParameters::default());
    let vector = vector(task.clone(), 3);
    for index in 0..3 {
        let start = Environment::start(&body, &task, Some(7 + index as u64));
        assert_eq!(vector.environment(index).state, start);
    }
    assert_eq!(
        Environment::start(&body, &task, None),
        Environment::default_start(&body, &task)
    );
    assert_ne!(
        Environment::start(&body, &task, Some(1)),
        Environment::start(&body, &task, Some(2))
    );
}

#[test]
fn a_step_is_the_tasks() {
    let (body, task) = (body(), TaskParameters::default());
    let mut vector = vector(task.clone(), 1);
    let omega_v = vector.environment(0).omega_v;
    assert!((-0.5..=3.5).contains(&omega_v));
    let mut alone = Environment::new(&body, Environment::start(&body, &task, Some(7)), omega_v);
    let before = vector.look(0);
    assert_eq!(before.observation, alone.observation());
    for period in 1..=20 {
        let outcome = alone.step(&body, &task, &task.reward, [0.3, -0.2]);
        let step = vector.step(0, [0.3, -0.2]);
        assert_eq!(step.observation, alone.observation());
        assert_eq!(step.reward, outcome.factor * outcome.terms.sum());
        assert_eq!(info(&step, "reward_velocity"), outcome.terms.velocity);
        assert_eq!(
            info(&step, "time_s"),
            f64::from(period) * task.control_period_s
        );
        assert_eq!(
            info(&step, "right_normal_force_n"),
            outcome.report.normal_n[0]
        );
        assert_eq!(info(&step, "diverged"), 0.0);
    }
    assert_eq!(info_names(&RewardParameters::default()).len(), INFO_SIZE);
}

#[test]
fn threads_and_neighbours_change_nothing() {
    let commands: Vec<[f64; 2]> = (0..7).map(|i| [0.1 * f64::from(i), -0.5]).collect();
    let run = |threads: usize, count: usize| -> Vec<Vec<VectorStep>> {
        let mut vector = vector(short(), count);
        (0..10)
            .map(|_| vector.step_all(&commands[..count], AutoReset::SameStep, threads))
            .collect()
    };
    let one = run(1, 7);
    for threads in [2, 3, 16] {
        assert_eq!(run(threads, 7), one);
    }
    for (few, many) in run(1, 2).iter().zip(&one) {
        assert_eq!(few[..], many[..2]);
    }
}

#[test]
fn an_episode_goes_on_as_the_mode_says() {
    let flags = |mode: AutoReset| -> Vec<(bool, bool, f64)> {
        let mut vector = vector(short(), 1);
        (0..5)
            .map(|_| {
                let step = vector.step_all(&[[0.0; 2]], mode, 1)[0];
                (step.truncated, step.last.is_some(), info(&step, "time_s"))
            })
            .collect()
    };
    let time = |periods: f64| periods * TaskParameters::default().control_period_s;
    // The step after the last begins the next episode, and its action is for nothing.
    let next = flags(AutoReset::NextStep);
    let times: Vec<f64> = next.iter().map(|f| f.2).collect();
    assert_eq!(times, [time(1.0), time(2.0), time(3.0), 0.0, time(1.0)]);
    assert!(next[2].0 && !next[3].0 && next.iter().all(|f| !f.1));
    // The last step begins it itself, and tells what the old one ended with.
    let same = flags(AutoReset::SameStep);
    let times: Vec<f64> = same.iter().map(|f| f.2).collect();
    assert_eq!(times, [time(1.0), time(2.0), 0.0, time(1.0), time(2.0)]);
    assert!(same[2].0 && same[2].1 && !same[1].1 && !same[3].1);
    // Nothing begins by itself.
    let disabled = flags(AutoReset::Disabled);
    assert!(disabled[2].0 && disabled[3].0 && disabled.iter().all(|f| !f.1));
    assert_eq!(disabled[4].2, time(5.0));
}

#[test]
fn an_opening_is_what_was_asked_for() {
    let (body, task) = (body(), TaskParameters::default());
    let mut vector = vector(task.clone(), 2);
    let opening = Opening {
        omega_v: Some(1.25),
        default_start: true,
        state: None,
    };
    let step = vector.reset(1, opening);
    assert_eq!(vector.environment(1).omega_v, 1.25);
    assert_eq!(
        vector.environment(1).state,
        Environment::default_start(&body, &task)
    );
    let contact = body.foot_contact(&vector.environment(1).state, LEFT);
    assert_eq!(info(&step, "left_normal_force_n"), contact.normal_n);
    vector.set_command(1, -0.25);
    assert_eq!(vector.look(1).observation[13], -0.25);
}

#[test]
fn it_begins_in_a_state_and_goes_on_from_a_saved_one_to_the_same_bits() {
    let task = TaskParameters::default();
    let randomization: Randomization = toml::from_str(
        "body = { friction = [0.5, 1.5] }\nlatency_s = [0, 0.02]\nnoise = { theta_rad = 0.1 }",
    )
    .unwrap();
    let mut plain = vector(task.clone(), 2);
    let mut vector = vector(task.clone(), 2).randomized(randomization).unwrap();
    for vector in [&mut plain, &mut vector] {
        for index in 0..2 {
            vector.seed(index, 40 + index as u64);
            vector.reset(index, Opening::default());
        }
    }
    // The first start and command after a seed are those without a randomization.
    for index in 0..2 {
        assert_eq!(
            vector.environment(index).state,
            plain.environment(index).state
        );
        assert_eq!(
            vector.environment(index).omega_v,
            plain.environment(index).omega_v
        );
        assert_ne!(
            vector.body_of(index).parameters(),
            plain.body_of(index).parameters()
        );
    }
    // Later ones are not: what was drawn came from the same random numbers.
    let later = [&plain, &vector].map(|vector| {
        let mut vector = vector.clone();
        vector.reset(0, Opening::default());
        (vector.environment(0).state, vector.environment(0).omega_v)
    });
    assert!(later[0].0 != later[1].0 && later[0].1 != later[1].1);
    let mut told = Vec::new();
    let commands = [[0.3, -0.2], [0.1, 0.4]];
    for _ in 0..5 {
        vector.step_all(&commands, AutoReset::SameStep, 1);
    }
    let text = serde_json::to_string(&vector.state()).unwrap();
    let mut other = vector.clone();
    for _ in 0..150 {
        told.push(vector.step_all(&commands, AutoReset::SameStep, 1));
    }
    assert!(other.restore(serde_json::from_str(&text).unwrap()));
    for told in told {
        assert_eq!(other.step_all(&commands, AutoReset::SameStep, 2), told);
    }
    let mut one = self::vector(task, 1);
    assert!(!one.restore(serde_json::from_str(&text).unwrap()));
    let mut state = plain.environment(0).state;
    state.z += 0.3;
    one.reset(
        0,
        Opening {
            state: Some(state),
            ..Opening::default()
        },
    );
    assert_eq!(one.environment(0).state, state);
}

#[test]
fn a_saved_state_of_a_body_that_the_task_cannot_run_on_is_refused() {
    // What went wrong: the body that an episode had drawn was not checked against the task; with a tiny time step one
    // control period takes billions of steps, and an environment read from a damaged text hung.
    let randomization = toml::from_str("body = { friction = [0.5, 1.5] }").unwrap();
    let mut vector = vector(TaskParameters::default(), 1)
        .randomized(randomization)
        .unwrap();
    vector.reset(0, Opening::default());
    let text = serde_json::to_string(&vector.state()).unwrap();
    let (from, to) = ("\"time_step_s\":0.0002", "\"time_step_s\":1e-300");
    assert!(text.contains(from));
    let before = vector.state();
    assert!(!vector.restore(serde_json::from_str(&text.replace(from, to)).unwrap()));
    assert_eq!(vector.state(), before);
}

#[test]
fn a_saved_disturbance_whose_time_cannot_go_on_is_refused() {
    // What went wrong: the next control period overflowed the count of a damaged state's integration steps.
    let disturbance = toml::from_str("latency_s = 0.01").unwrap();
    let mut vector = vector(TaskParameters::default(), 1)
        .disturbed(disturbance)
        .unwrap();
    vector.reset(0, Opening::default());
    let before = vector.state();
    let text = serde_json::to_string(&before).unwrap();
    let (from, to) = ("\"steps\":0", "\"steps\":18446744073709551615");
    assert_eq!(text.matches(from).count(), 1);
    assert!(!vector.restore(serde_json::from_str(&text.replace(from, to)).unwrap()));
    assert_eq!(vector.state(), before);
}

#[test]
fn a_disturbed_episode_is_one_of_the_disturbance() {
    let task = TaskParameters::default();
    let push = Push {
        forward_n: 60.0,
        start_s: 0.05,
        ..Push::default()
    };
    let disturbance = Disturbance {
        pushes: vec![push],
        latency_s: 0.004,
        ..Disturbance::default()
    };
    let mut vector = vector(task.clone(), 1)
        .disturbed(disturbance.clone())
        .unwrap();
    vector.reset(0, Opening::default());
    let body = body();
    let mut alone = vector.environment(0).clone();
    let mut disturbed = Disturbed::new(&disturbance, body.parameters(), 0).unwrap();
    for _ in 0..20 {
        vector.step(0, [0.3, 0.1]);
        disturbed.step(&mut alone, &body, &task, &task.reward, [0.3, 0.1], None);
    }
    assert_eq!(vector.environment(0), &alone);
    // What an environment cannot do is refused.
    let both = vector.randomized(Randomization::default());
    assert!(both.unwrap_err().accepted.contains("alone"));
}

#[test]
fn a_simulation_that_diverges_leaves_numbers_behind() {
    let parameters = BodyParameters {
        diverged_speed: 1e-6,
        ..BodyParameters::default()
    };
    let body = Body::new(parameters).unwrap();
    let mut vector = VectorEnvironment::new(body, TaskParameters::default(), [0.0; 2], 1);
    let first = vector.reset(0, Opening::default());
    let step = vector.step(0, [0.0; 2]);
    assert!(step.terminated && info(&step, "diverged") == 1.0);
    assert_eq!(step.observation, first.observation);
    assert!(step.info.iter().all(|v| v.is_finite()));
}
