//! The tests of this crate as one program, which builds sooner than one program each. Those that need a process of
//! their own are named in `Cargo.toml`.

mod common;
mod messages;
mod replay;
mod stage;
mod watch;
