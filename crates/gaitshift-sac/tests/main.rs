//! The tests of this crate as one program, which builds sooner than one program each. Those that need a process of
//! their own are named in `Cargo.toml`.

mod checkpoint;
mod common;
mod config;
mod gaussian;
mod imitation;
mod known_optimum;
mod learner;
mod losses;
mod mirror;
mod policy;
mod random;
mod rehearsal;
mod replay;
mod update;
