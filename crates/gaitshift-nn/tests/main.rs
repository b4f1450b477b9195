//! The tests of this crate as one program, which builds sooner than one program each. Those that need a process of
//! their own are named in `Cargo.toml`.

mod buffer;
mod dense;
mod mlp;
mod optimiser;
mod products;
mod real;
mod sparse;
mod workers;
