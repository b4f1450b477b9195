//! How many updates a second the learner makes, for `benchmarks/compare.py`.
//!
//! `cargo run --release -p gaitshift-sac --example update_rate -- --hidden 128 --threads 1 [--layer-norm]
//! [--count-zeros] [--avx2] [--transitions 200000] [--updates N]`
//!
//! With `--count-zeros` the zeros of rectified layers are multiplied like other numbers, with `--avx2` AVX-512 is not used.
//! With `--updates N` it makes so many updates and ends: `benchmarks/instructions.py` counts their instructions. Otherwise
//! it counts updates as `benchmarks/protocol.rs` says. At the end of the input it prints the peak of its resident memory
//! and the bytes of the replay buffer.

#[path = "../../../benchmarks/protocol.rs"]
mod protocol;

use gaitshift_nn::simd::{self, Level};
use gaitshift_sac::{Agent, ReplayBuffer, SacConfig, SacError, Transitions};

/// Sizes of the biped's task.
const OBSERVATIONS: usize = 14;
const ACTIONS: usize = 2;
const ENVIRONMENTS: usize = 8;
/// Updates between two looks at the clock.
const BLOCK: u32 = 5;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut hidden, mut threads, mut transitions, mut updates) = (128, 1, 200_000, 0);
    let mut layer_norm = false;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let target = match argument.as_str() {
            "--layer-norm" => {
                layer_norm = true;
                continue;
            }
            "--avx2" => {
                simd::limit(Level::Avx2);
                continue;
            }
            "--count-zeros" => {
                gaitshift_nn::sparse::count_zeros_too();
                continue;
            }
            "--hidden" => &mut hidden,
            "--threads" => &mut threads,
            "--transitions" => &mut transitions,
            "--updates" => &mut updates,
            _ => return Err(format!("{argument}: unknown; see the head of this file").into()),
        };
        let value = arguments.next().unwrap_or_default();
        *target = value
            .parse()
            .map_err(|error| format!("{argument} {value}: {error}"))?;
    }
    let config = SacConfig {
        actor_hidden: vec![hidden; 2],
        critic_hidden: vec![hidden; 2],
        critic_layer_norm: layer_norm,
        threads,
        ..SacConfig::default()
    };
    let mut agent = Agent::new(config, OBSERVATIONS, ACTIONS, None, 1)?;
    let replay = filled_replay(transitions)?;
    if updates > 0 {
        for _ in 0..updates {
            agent.update(&replay)?;
        }
        return Ok(());
    }
    for _ in 0..100 {
        agent.update(&replay)?;
    }
    protocol::serve(|| {
        for _ in 0..BLOCK {
            agent.update(&replay)?;
        }
        Ok::<_, SacError>(BLOCK)
    })?;
    let peak = peak_resident_bytes().map_or("null".to_string(), |bytes| bytes.to_string());
    // Two observations, an action and four numbers more in single precision, and one byte of flags.
    let replay = replay.len() * (4 * (2 * OBSERVATIONS + ACTIONS + 4) + 1);
    println!("{{\"peak_resident_bytes\": {peak}, \"replay_bytes\": {replay}}}");
    Ok(())
}

/// The greatest resident memory of this process so far, where the system tells (Linux).
fn peak_resident_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? * 1024)
}

/// Transitions without meaning but with plausible magnitudes.
fn filled_replay(transitions: usize) -> Result<ReplayBuffer, SacError> {
    let mut replay = ReplayBuffer::new(transitions, ENVIRONMENTS, OBSERVATIONS, ACTIONS)?;
    let numbers = |count: usize, step: usize, scale: f32| -> Vec<f32> {
        (0..count)
            .map(|index| scale * ((index * 37 + step * 101) as f32).sin())
            .collect()
    };
    for step in 0..transitions / ENVIRONMENTS {
        let terminated: Vec<bool> = (0..ENVIRONMENTS)
            .map(|environment| (step * 3 + environment) % 500 == 0)
            .collect();
        replay.push(Transitions {
            observations: &numbers(ENVIRONMENTS * OBSERVATIONS, step, 1.0),
            actions: &numbers(ENVIRONMENTS * ACTIONS, step, 0.9),
            log_probs: &[-1.0; ENVIRONMENTS],
            rewards: &numbers(ENVIRONMENTS, step, 0.5),
            next_observations: &numbers(ENVIRONMENTS * OBSERVATIONS, step + 1, 1.0),
            terminated: &terminated,
            truncated: &[false; ENVIRONMENTS],
            valid: &[true; ENVIRONMENTS],
        })?;
    }
    Ok(replay)
}
