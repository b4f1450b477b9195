//! The tests of this crate as one program, which builds sooner than one program each. Those that need a process of
//! their own are named in `Cargo.toml`.

mod batch;
mod curriculum;
mod disturbance;
mod environment;
mod expression;
mod extra;
mod learner;
mod observation;
mod randomization;
mod reward;
mod terrain;
mod touchdowns;
mod vector;
