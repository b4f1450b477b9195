//! The tests of this crate as one program, which builds sooner than one program each.

mod animation;
mod charts;
mod common;
mod figure;
mod intervals;
mod learning;
mod settings;
mod strobe;
mod sweep;
mod transition;
