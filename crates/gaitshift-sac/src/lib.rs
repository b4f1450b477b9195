//! A small, deterministic Soft Actor-Critic learner for the CPU. It knows nothing of bipeds: observations and actions
//! are rows of numbers, and it is tested on problems whose answers are known.
//!
//! The algorithm is Soft Actor-Critic (Haarnoja et al., 2018) as the paper uses it: twin critics with targets that
//! follow by Polyak averaging, a tanh-squashed Gaussian policy, Adam, a replay buffer, a fixed temperature α or a
//! learned one. One update, in this order:
//!
//! 1. targets y = R + Γ \[min(Q₁', Q₂')(s', a') − α ln π(a'|s')\] with a' drawn anew; R is the sum of up to n
//!    rewards, Γ = γⁿ, or 0 after termination (a time limit is truncation and bootstraps);
//! 2. critics: one Adam step down mean (Q − y)² / 2 each; their targets follow by the share τ;
//! 3. actor: one Adam step down mean(α ln π(a|s) − min(Q₁, Q₂)(s, a)), a reparameterised;
//! 4. temperature, where learned: one Adam step down −ln α mean(ln π + target entropy).
//!
//! Where to look: [`Agent`] acts, learns, is saved and resumed; [`ReplayBuffer`] keeps experience; [`Policy`] is the
//! actor alone, for controllers; [`Imitation`] fits one to given actions; [`SacConfig`] holds the settings; [`Learner`] is the update (`update.rs`, its losses in
//! `losses.rs`), generic in the scalar, which the tests run in `f64`. Its golden reference is `tools/golden/sac_update.py`.
//!
//! ```
//! use gaitshift_sac::{Agent, ReplayBuffer, SacConfig, Transitions};
//!
//! # fn main() -> Result<(), gaitshift_sac::SacError> {
//! let config = SacConfig { actor_hidden: vec![16], critic_hidden: vec![16], batch_size: 32, ..SacConfig::default() };
//! let (observation_size, action_size, seed) = (1, 1, 0);
//! let mut agent = Agent::new(config, observation_size, action_size, None, seed)?;
//! let mut replay = ReplayBuffer::new(1_000, 1, observation_size, action_size)?;
//! let (mut action, mut log_prob) = ([0.0], [0.0]);
//! for step in 0..100 {
//!     let observation = [(step as f32).sin()];
//!     agent.act(&observation, &mut action, &mut log_prob)?;
//!     replay.push(Transitions {
//!         observations: &observation,
//!         actions: &action,
//!         log_probs: &log_prob,
//!         rewards: &[-(action[0] - observation[0]).powi(2)],
//!         next_observations: &[(step as f32 + 1.0).sin()],
//!         terminated: &[false],
//!         truncated: &[step % 20 == 19],
//!         valid: &[true],
//!     })?;
//!     let stats = agent.update(&replay)?;
//!     assert!(stats.mean_q.is_finite());
//! }
//! # Ok(())
//! # }
//! ```
//!
//! # What is promised
//! The same seed gives the same bits on one machine with any number of threads, and whether or not a run was saved and
//! resumed. Between machines rounding may differ: fused multiply-add where the processor has it, and the system's
//! logarithm in rare draws of the normal distribution.
//!
//! # How it is fast
//! By the networks of [`gaitshift_nn`]; a batch is worked on in chunks of [`CHUNK`] rows that stay in a
//! core's cache from observation to gradient; derivatives that nobody needs are not computed (of the critics in the
//! actor's step, only the smaller one's derivative in the actions); nothing is allocated after the start.

#![forbid(unsafe_code)]

mod agent;
mod checkpoint;
mod config;
mod error;
pub mod gaussian;
mod imitation;
mod learner;
mod losses;
mod mirror;
mod policy;
mod random;
mod rehearsal;
mod replay;
mod update;

pub use gaitshift_nn::{MlpShape, NamedTensor};

pub use agent::Agent;
pub use config::{CHUNK, SacConfig, Temperature};
pub use error::SacError;
pub use imitation::Imitation;
pub use learner::{Learner, Noise, TemperatureState, UpdateStats};
pub use mirror::{Mirror, reflect};
pub use policy::{Policy, PolicyError};
pub use random::streams;
pub use rehearsal::{Rehearsal, Rehearsed};
pub use replay::{Batch, ReplayBuffer, Sampling, Transitions};
