//! Whole updates agree with those that PyTorch made from the same networks, batches and noise
//! (`tools/golden/sac_update.py`): losses, every gradient, every parameter of actor, critics,
//! targets after Adam and Polyak, and the temperature, for three updates in a row.
//!
//! Case `plain`: fixed temperature, two hidden layers. Case `all_options`: layer normalisation in the critics, learned
//! temperature, three hidden layers in the critics.
//!
//! In f64 the difference stays below 1e-12 (relative to the largest element of a tensor); in f32, the type in
//! use, below 2e-5.

use crate::common::replay;

#[test]
fn plain_in_f64() {
    replay::<f64>("plain", 1e-12);
}

#[test]
fn all_options_in_f64() {
    replay::<f64>("all_options", 1e-12);
}

#[test]
fn plain_in_f32() {
    replay::<f32>("plain", 2e-5);
}

#[test]
fn all_options_in_f32() {
    replay::<f32>("all_options", 2e-5);
}
