//! Small dense networks on a CPU: forward, backward and Adam, with the same bits for any number of threads. It knows nothing of
//! what the networks learn.
//!
//! - [`Mlp`] is a multi-layer perceptron; [`Activations`], [`Deltas`] and [`Transposed`] are the memory of its passes.
//! - [`Trained`] is one with its gradient and the moments of Adam; [`Optimiser`] steps it.
//! - [`Workers`] are threads that share out numbered tasks. Gradients of parts of a batch are summed in the order of the
//!   parts, so that threads decide who computes, never what.
//! - [`product`], [`dense`] and [`sparse`] are the products of matrices that all time goes into, [`simd`] the vectors
//!   that they are made of.
//!
//! ```
//! use gaitshift_nn::{Mlp, MlpShape, Optimiser, Step, Trained, Workers};
//! use rand_xoshiro::Xoshiro256PlusPlus;
//! use rand_xoshiro::rand_core::SeedableRng;
//!
//! // y = x² on [-1, 1], learned from 20 rows.
//! let rows = 20;
//! let x: Vec<f32> = (0..rows).map(|row| row as f32 / 10.0 - 1.0).collect();
//! let shape = MlpShape { inputs: 1, hidden: vec![16, 16], outputs: 1, layer_norm: false };
//! let mut trained = Trained::new(Mlp::random(shape, &mut Xoshiro256PlusPlus::seed_from_u64(1)));
//! let (mut activations, mut deltas) = (trained.network.activations(rows), trained.network.deltas(rows));
//! let (mut workers, mut optimiser) = (Workers::new(1), Optimiser::default());
//! let mut gradient = trained.network.zeros_like();
//! let mut loss = 0.0;
//! for _ in 0..500 {
//!     trained.network.forward(rows, &x, 1, &mut activations);
//!     let errors: Vec<f32> = activations.out.iter().zip(&x).map(|(y, x)| y - x * x).collect();
//!     loss = errors.iter().map(|error| error * error).sum::<f32>();
//!     trained.network.backward(
//!         &trained.transposed, rows, &x, 1, &activations, &errors, &mut deltas, &mut gradient,
//!     );
//!     let step = Step { learning_rate: 3e-3, followers: [None] };
//!     optimiser.step(&mut workers, [&mut trained], [&[&gradient[..]]], step);
//!     trained.refresh();
//! }
//! assert!(loss < 0.05, "{loss}");
//! ```
//!
//! # Which file uses which
//! `real` ← `simd` ← `product` ← `dense`, `pattern` ← `sparse`; on them `layout` ← `mlp` ← `forward` ← `backward`, with
//! `layer_norm`, `output_layer` and `sums`; `sync` ← `gate`, `disjoint` ← `workers`; `adam` and all of them ← `optimiser`. No
//! file uses one further on.

pub mod adam;
mod backward;
mod buffer;
pub mod dense;
mod disjoint;
mod forward;
mod gate;
mod layer_norm;
mod layout;
mod mlp;
mod optimiser;
mod output_layer;
mod pattern;
mod prefetch;
pub mod product;
mod real;
pub mod simd;
pub mod sparse;
mod sums;
mod sync;
mod workers;

pub use backward::{Deltas, Transposed};
pub use buffer::{Buffer, LINE};
pub use forward::Activations;
pub use layer_norm::LAYER_NORM_EPSILON;
pub use layout::{MlpShape, NamedTensor};
pub use mlp::Mlp;
pub use optimiser::{Optimiser, Step, Trained};
pub use pattern::Pattern;
pub use prefetch::prefetch;
pub use real::Real;
pub use simd::Scalar;
pub use workers::{Finished, Workers};
