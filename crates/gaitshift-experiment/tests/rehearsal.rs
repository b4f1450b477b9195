//! Contract: what is remembered of a walk are states under the commands asked for, answered with the mean
//! action of the policy, told one of them; nothing of the last second before a fall; the same
//! for the same seed. The best command is one under which the walk meets what it can.

use gaitshift_body::Body;
use gaitshift_experiment::{Controller, Criteria, RehearsalParameters, best_walk};
use gaitshift_sac::{Agent, Rehearsal};
use gaitshift_task::{ACTION_SIZE, Curriculum, OBSERVATION_SCALE, OBSERVATION_SIZE, PhaseSettings};

const COMMAND: usize = OBSERVATION_SIZE - 1;

fn settings(controller: &Controller) -> PhaseSettings {
    Curriculum::default().at(0, &controller.task.reward)
}

fn parameters() -> RehearsalParameters {
    RehearsalParameters {
        states: 6400,
        omega_v: [0.0, 0.1],
        ..RehearsalParameters::default()
    }
}

fn remember(controller: &mut Controller, told: f64, seed: u64) -> Rehearsal {
    let body = Body::new(controller.body.clone()).unwrap();
    let settings = settings(controller);
    parameters()
        .collect(
            &mut controller.policy,
            &body,
            &controller.task,
            &settings,
            told,
            seed,
        )
        .unwrap()
        .unwrap()
}

#[test]
fn states_and_answers_of_the_shipped_walk() {
    let mut controller = Controller::shipped().unwrap();
    let walk = remember(&mut controller, -0.05, 1);
    assert_eq!(walk, remember(&mut controller, -0.05, 1));
    assert_ne!(walk, remember(&mut controller, -0.05, 2));
    let rows = walk.rows();
    assert!((5000..=6400).contains(&rows), "{rows}");
    let mut told = walk.observations().to_vec();
    for observation in told.chunks_exact_mut(OBSERVATION_SIZE) {
        let command = observation[COMMAND] / OBSERVATION_SCALE[COMMAND];
        assert!((-1e-6..=0.1 + 1e-6).contains(&command), "{command}");
        observation[COMMAND] = -0.05 * OBSERVATION_SCALE[COMMAND];
    }
    let mut answers = vec![0.0; rows * ACTION_SIZE];
    controller.policy.mean_action(&told, &mut answers).unwrap();
    for (kept, answer) in walk.actions().iter().zip(&answers) {
        assert!((kept - answer).abs() < 1e-5, "{kept} {answer}");
    }
}

#[test]
fn a_policy_that_only_falls_leaves_little_and_a_poor_walk() {
    let asked = Criteria::default();
    let mut controller = Controller::shipped().unwrap();
    let body = Body::new(controller.body.clone()).unwrap();
    let (score, told) = best_walk(&mut controller.policy, &body, &controller.task, &asked).unwrap();
    // All of survival, gait, both bounds of speed, cost; and the correlation in part.
    assert!(score > 5.0 && told.abs() <= 0.35, "{score} {told}");

    let agent = Agent::new(Default::default(), OBSERVATION_SIZE, ACTION_SIZE, None, 1).unwrap();
    let whole = remember(&mut controller, 0.0, 1).rows();
    controller.policy = agent.policy();
    let (poor, _) = best_walk(&mut controller.policy, &body, &controller.task, &asked).unwrap();
    assert!(poor < 2.0, "{poor}");
    let rows = remember(&mut controller, 0.0, 1).rows();
    assert!(rows < whole / 2, "{rows} of {whole}");
    // Where no walk is asked for none is the best.
    let none = Criteria {
        gaits: Vec::new(),
        changes: Vec::new(),
        ..asked
    };
    let (no_walk, _) = best_walk(&mut controller.policy, &body, &controller.task, &none).unwrap();
    assert_eq!(no_walk, f64::NEG_INFINITY);
}
