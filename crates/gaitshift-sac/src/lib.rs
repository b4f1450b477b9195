//! A small, deterministic Soft Actor-Critic learner for the CPU.
mod adam;
mod agent;
mod checkpoint;
mod config;
pub mod dense;
mod error;
pub mod gaussian;
mod lanes;
mod learner;
mod mirror;
pub mod network;
mod policy;
mod random;
mod real;
mod replay;
mod workers;

pub use agent::Agent;
pub use config::{SacConfig, Temperature};
pub use error::SacError;
pub use learner::{CHUNK, Learner, Noise, TemperatureState, Trained, UpdateStats};
pub use mirror::{Mirror, reflect};
pub use network::{Mlp, MlpShape, NamedTensor};
pub use policy::{Policy, PolicyError};
pub use random::streams;
pub use real::{Buffer, LINE, Real};
pub use replay::{Batch, ReplayBuffer, Sampling, Transitions};
pub use workers::Workers;
