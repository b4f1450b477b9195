//! How many environment steps a second the simulator makes, for `benchmarks/compare.py`.
//!
//! `cargo run --release -p gaitshift-task --example step_rate [-- --time-step-s 0.0002]`
//!
//! A step is one control period of the default body with a uniformly random action, observation and reward included,
//! and a new episode after each fall, counted as `benchmarks/protocol.rs` says.

#[path = "../../../benchmarks/protocol.rs"]
mod protocol;

use std::convert::Infallible;
use std::hint::black_box;

use gaitshift_body::{Body, BodyParameters};
use gaitshift_task::{Curriculum, EnvironmentBatch, TaskParameters};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Steps between two looks at the clock.
const BLOCK: u32 = 100;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut body = BodyParameters::default();
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match &arguments[..] {
        [] => {}
        [name, value] if name == "--time-step-s" => {
            body.time_step_s = value
                .parse()
                .map_err(|error| format!("{name} {value}: {error}"))?;
        }
        _ => return Err(format!("{arguments:?}: unknown; see the head of this file").into()),
    }
    let task = TaskParameters::default();
    let curriculum = Curriculum::default();
    let settings = curriculum.at(curriculum.total_steps() - 1, &task.reward);
    let mut batch = EnvironmentBatch::new(Body::new(body)?, task, 1, 1, &settings);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut steps = |count: u32| {
        for _ in 0..count {
            let command = [rng.random_range(-1.0..=1.0), rng.random_range(-1.0..=1.0)];
            let (outcome, finished) = batch.step(0, command, 0.0, &settings);
            black_box(outcome.terms.sum() + batch.environment(0).observation()[0]);
            if finished.is_some() {
                batch.reset(0, &settings);
            }
        }
    };
    steps(10 * BLOCK);
    protocol::serve(|| {
        steps(BLOCK);
        Ok::<_, Infallible>(BLOCK)
    })
}
