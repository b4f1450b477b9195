//! The code for any processor, which no test would reach on a processor with AVX2, gives the same updates: those of
//! PyTorch, in f32, within the tolerance that the code for AVX2 is held to (`update.rs`).

mod common;

use gaitshift_nn::simd::{Level, level, limit};

#[test]
fn portable_code_agrees_too() {
    limit(Level::Portable);
    assert_eq!(level(), Level::Portable);
    common::replay::<f32>("plain", 2e-5);
    common::replay::<f32>("all_options", 2e-5);
}
