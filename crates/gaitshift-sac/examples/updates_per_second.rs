//! Updates per second of the learner on this machine, for several network sizes, with and without layer
//! normalisation, on one thread and on two.
//!
//! `cargo run --release -p gaitshift-sac --example updates_per_second [seconds per measurement] [rounds]`

use std::time::Instant;

use gaitshift_sac::{Agent, ReplayBuffer, SacConfig, SacError, Transitions};

const OBSERVATIONS: usize = 14;
const ACTIONS: usize = 2;
const STREAMS: usize = 8;
const TRANSITIONS: usize = 200_000;

fn main() -> Result<(), SacError> {
    let mut arguments = std::env::args()
        .skip(1)
        .map(|argument| argument.parse::<f64>());
    let seconds = arguments.next().and_then(Result::ok).unwrap_or(1.0);
    let rounds = arguments.next().and_then(Result::ok).unwrap_or(3.0) as usize;
    let replay = filled_replay()?;
    println!(
        "batch 256, {OBSERVATIONS} observations, {ACTIONS} actions; median of {rounds} rounds of {seconds} s"
    );
    println!("hidden  layer norm  threads  updates/s      least       most");
    for hidden in [64, 100, 128, 256] {
        for layer_norm in [false, true] {
            for threads in [1, 2] {
                let config = SacConfig {
                    actor_hidden: vec![hidden; 2],
                    critic_hidden: vec![hidden; 2],
                    actor_layer_norm: layer_norm,
                    critic_layer_norm: layer_norm,
                    threads,
                    ..SacConfig::default()
                };
                let mut agent = Agent::new(config, OBSERVATIONS, ACTIONS, None, 1)?;
                for _ in 0..20 {
                    agent.update(&replay)?;
                }
                let mut rates = Vec::new();
                for _ in 0..rounds {
                    let start = Instant::now();
                    let mut updates = 0;
                    while start.elapsed().as_secs_f64() < seconds {
                        for _ in 0..10 {
                            agent.update(&replay)?;
                        }
                        updates += 10;
                    }
                    rates.push(f64::from(updates) / start.elapsed().as_secs_f64());
                }
                rates.sort_by(f64::total_cmp);
                println!(
                    "{:>6}  {:>10}  {threads:>7}  {:>9.0}  {:>9.0}  {:>9.0}",
                    format!("{hidden}²"),
                    layer_norm,
                    rates[rates.len() / 2],
                    rates[0],
                    rates[rates.len() - 1],
                );
            }
        }
    }
    Ok(())
}

/// Transitions without meaning but with plausible magnitudes.
fn filled_replay() -> Result<ReplayBuffer, SacError> {
    let mut replay = ReplayBuffer::new(TRANSITIONS, STREAMS, OBSERVATIONS, ACTIONS)?;
    let numbers = |count: usize, step: usize, scale: f32| -> Vec<f32> {
        (0..count)
            .map(|index| scale * ((index * 37 + step * 101) as f32).sin())
            .collect()
    };
    for step in 0..TRANSITIONS / STREAMS {
        let terminated: Vec<bool> = (0..STREAMS)
            .map(|stream| (step * 3 + stream) % 500 == 0)
            .collect();
        replay.push(Transitions {
            observations: &numbers(STREAMS * OBSERVATIONS, step, 1.0),
            actions: &numbers(STREAMS * ACTIONS, step, 0.9),
            log_probs: &[-1.0; STREAMS],
            rewards: &numbers(STREAMS, step, 0.5),
            entropy_scales: &[1.0; STREAMS],
            horizon_scales: &[1.0; STREAMS],
            next_observations: &numbers(STREAMS * OBSERVATIONS, step + 1, 1.0),
            terminated: &terminated,
            truncated: &[false; STREAMS],
            valid: &[true; STREAMS],
        })?;
    }
    Ok(replay)
}
