//! Leaving out the zeros of rectified layers changes nothing but the speed, nor does AVX-512: after some updates all networks
//! are the same to the bit as without AVX-512, and as when every zero is multiplied, with and without layer normalisation in the critics,
//! with two and three hidden layers.

use gaitshift_nn::simd::{Level, limit};
use gaitshift_nn::sparse::count_zeros_too;
use gaitshift_sac::{Batch, Learner, NamedTensor, Noise, SacConfig, streams};
use rand::Rng;

const OBSERVATIONS: usize = 6;
const ACTIONS: usize = 2;
const ROWS: usize = 150;
const UPDATES: usize = 20;

fn trained(hidden: &[usize], layer_norm: bool) -> Vec<NamedTensor<f32>> {
    let config = SacConfig {
        actor_hidden: hidden.to_vec(),
        critic_hidden: hidden.to_vec(),
        critic_layer_norm: layer_norm,
        batch_size: ROWS,
        learning_rate: 3e-3,
        threads: 2,
        ..SacConfig::default()
    };
    let [mut init, mut draw] = streams(5);
    let mut learner = Learner::new(config, OBSERVATIONS, ACTIONS, None, &mut init).unwrap();
    let mut numbers = |count: usize| -> Vec<f32> {
        (0..count)
            .map(|_| (f64::from(draw.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0) as f32)
            .collect()
    };
    for _ in 0..UPDATES {
        let batch = Batch {
            observations: numbers(ROWS * OBSERVATIONS),
            actions: numbers(ROWS * ACTIONS),
            rewards: numbers(ROWS),
            discounts: vec![0.9; ROWS],
            next_observations: numbers(ROWS * OBSERVATIONS),
        };
        let (next, current) = (numbers(ROWS * ACTIONS), numbers(ROWS * ACTIONS));
        let noise = Noise {
            next: &next,
            current: &current,
        };
        learner.update(&batch, noise).unwrap();
    }
    let [first, second] = &learner.critics;
    [&learner.actor, first, second]
        .iter()
        .flat_map(|trained| trained.network.tensors())
        .collect()
}

#[test]
fn neither_zeros_left_out_nor_wider_vectors_change_a_bit() {
    let cases: [(&[usize], bool); 3] = [
        (&[100, 100], false),
        (&[64, 90], true),
        (&[40, 70, 33], false),
    ];
    let train = || cases.map(|(hidden, layer_norm)| trained(hidden, layer_norm));
    let widest = train();
    limit(Level::Avx2);
    assert_eq!(widest, train());
    count_zeros_too();
    assert_eq!(widest, train());
}
