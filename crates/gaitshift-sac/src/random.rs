//! Random numbers: xoshiro256++ streams whose state is part of a checkpoint.

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

/// `count` independent streams of one seed: the seed is spread by SplitMix64, and each stream starts 2^128 draws
/// after the one before.
pub fn streams<const COUNT: usize>(seed: u64) -> [Xoshiro256PlusPlus; COUNT] {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    std::array::from_fn(|_| {
        let stream = rng.clone();
        rng.jump();
        stream
    })
}

/// Uniform in `0..bound`, `bound` at least 1; the bias of the multiplication is below 2^-32 for any bound in use.
pub fn below(rng: &mut impl Rng, bound: usize) -> usize {
    ((u128::from(rng.next_u64()) * bound as u128) >> 64) as usize
}

/// Fills `values` with standard normal numbers.
pub fn fill_normal(rng: &mut impl Rng, values: &mut [f32]) {
    for value in values {
        *value = StandardNormal.sample(rng);
    }
}
