//! The tests of this crate as one program, which builds sooner than one program each. Those that need a process of
//! their own are named in `Cargo.toml`.

mod acceptance;
mod common;
mod config;
mod criteria;
mod earned;
mod evaluations;
mod extra;
mod hardening;
mod pace;
mod phases;
mod profile;
mod rehearsal;
mod review;
mod rollout;
mod run_folder;
mod stress;
mod sweep;
mod symmetry;
mod training;
mod warm_start;
