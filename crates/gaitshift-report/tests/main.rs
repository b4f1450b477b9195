//! The tests of this crate as one program, which builds sooner than one program each.

mod claims;
mod common;
mod episodes;
mod experiments;
mod figures;
mod headline;
mod page;
mod return_map;
mod study;
mod subject;
mod trace;
mod write;
