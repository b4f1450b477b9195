//! The tests of this crate as one program, which builds sooner than one program each.

mod body;
mod contact;
mod dynamics;
mod energy;
mod integrator;
mod meter;
mod parameters;
mod state;
mod terrain;
