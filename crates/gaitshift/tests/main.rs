//! The tests of this crate as one program, which builds sooner than one program each.

mod analyse;
mod arguments;
mod common;
mod compare;
mod completions;
mod demo;
mod documentation;
mod evaluate;
mod export;
mod harden;
mod output;
mod render;
mod report;
mod snapshots;
mod stress;
mod sweep;
mod train;
mod transition;
mod view;
