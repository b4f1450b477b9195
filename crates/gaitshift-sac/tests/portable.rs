//! The code for any processor, which no test would reach on a processor with AVX2, gives the same updates: those of
//! PyTorch, in f32, within the tolerance that the code for AVX2 is held to (`golden_update.rs`).

mod common;

use gaitshift_sac::dense::{has_avx2_fma, use_portable_kernels};

#[test]
fn portable_code_agrees_too() {
    use_portable_kernels();
    assert!(!has_avx2_fma());
    common::replay::<f32>("plain", 2e-5);
    common::replay::<f32>("all_options", 2e-5);
}
