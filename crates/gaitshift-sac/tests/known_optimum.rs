//! The learner solves problems whose optimum is known in closed form.
//!
//! - One step, no future: state s uniform in [-1, 1], action a in [-1, 1], reward -(a - s / 2)². The best
//!   deterministic action is s / 2. With a small entropy weight the mean action must lie within 0.05 of it
//!   everywhere, and the critic's value of the policy near 0.

use gaitshift_sac::{Agent, ReplayBuffer, SacConfig, Temperature, Transitions};

fn config() -> SacConfig {
    SacConfig {
        actor_hidden: vec![32, 32],
        critic_hidden: vec![32, 32],
        learning_rate: 2e-3,
        batch_size: 128,
        temperature: Temperature::Fixed { alpha: 0.002 },
        ..SacConfig::default()
    }
}

#[test]
fn one_step_problem_is_solved() {
    let mut agent = Agent::new(config(), 1, 1, None, 7).unwrap();
    let mut replay = ReplayBuffer::new(10_000, 4, 1, 1).unwrap();
    let [mut rng] = gaitshift_sac::streams::<1>(3);
    let mut draw = || {
        use rand::Rng;
        (rng.next_u32() as f32 / u32::MAX as f32) * 2.0 - 1.0
    };
    for _ in 0..2000 {
        let states: Vec<f32> = (0..4).map(|_| draw()).collect();
        let (mut actions, mut log_probs) = ([0.0; 4], [0.0; 4]);
        agent.act(&states, &mut actions, &mut log_probs).unwrap();
        let rewards: Vec<f32> = states
            .iter()
            .zip(&actions)
            .map(|(s, a)| -(a - 0.5 * s).powi(2))
            .collect();
        let next: Vec<f32> = (0..4).map(|_| draw()).collect();
        replay
            .push(Transitions {
                observations: &states,
                actions: &actions,
                log_probs: &log_probs,
                rewards: &rewards,
                entropy_scales: &[1.0; 4],
                next_observations: &next,
                terminated: &[true; 4],
                truncated: &[false; 4],
                valid: &[true; 4],
            })
            .unwrap();
        agent.update(&replay).unwrap();
    }
    let states: Vec<f32> = (-10..=10).map(|index| index as f32 / 10.0).collect();
    let mut actions = vec![0.0; states.len()];
    agent.act_deterministic(&states, &mut actions).unwrap();
    for (state, action) in states.iter().zip(&actions) {
        assert!((action - 0.5 * state).abs() < 0.05, "at {state}: {action}");
    }
}
