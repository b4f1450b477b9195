//! The tests of this crate as one program, which builds sooner than one program each.

mod common;
mod cost;
mod energy;
mod feet;
mod files;
mod flow;
mod gait;
mod recent;
mod recording;
mod statistics;
mod steadiness;
mod steps;
mod summary;
mod support;
mod transition;
