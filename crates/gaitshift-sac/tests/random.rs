//! Contract: the streams of a seed are the same at every start, differ from each other and from those of the next seed, and a
//! stream that is stored and read back goes on where it was.

use gaitshift_sac::streams;
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;
use std::collections::HashSet;

fn draws(rng: &mut Xoshiro256PlusPlus) -> [u64; 100] {
    std::array::from_fn(|_| rng.next_u64())
}

#[test]
fn streams_depend_on_the_seed_alone_and_share_no_number() {
    let mut seen = HashSet::new();
    for seed in 0..20 {
        let mut first: [_; 4] = streams(seed);
        let mut again: [_; 4] = streams(seed);
        // More streams of the same seed leave the first ones as they are.
        let mut more: [_; 6] = streams(seed);
        for i in 0..4 {
            let numbers = draws(&mut first[i]);
            assert_eq!(numbers, draws(&mut again[i]));
            assert_eq!(numbers, draws(&mut more[i]));
            seen.extend(numbers);
        }
    }
    assert_eq!(seen.len(), 20 * 4 * 100);
}

#[test]
fn a_stored_stream_goes_on_where_it_was() {
    let [mut stream] = streams(3);
    draws(&mut stream);
    let stored = serde_json::to_string(&stream).unwrap();
    let mut restored: Xoshiro256PlusPlus = serde_json::from_str(&stored).unwrap();
    assert_eq!(draws(&mut stream), draws(&mut restored));
}
