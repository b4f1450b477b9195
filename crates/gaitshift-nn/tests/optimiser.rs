//! Gradients are summed from their parts and parameters moved as Adam's definition says, in f64;
//! followers keep their share; and the bits do not depend on the number of threads.

use gaitshift_nn::{Mlp, MlpShape, Optimiser, Step, Trained, Workers};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

const RATE: f64 = 0.01;

fn trained(seed: u64) -> Trained<f64> {
    let shape = MlpShape {
        inputs: 3,
        hidden: vec![40, 40],
        outputs: 2,
        layer_norm: false,
    };
    Trained::new(Mlp::random(
        shape,
        &mut Xoshiro256PlusPlus::seed_from_u64(seed),
    ))
}

fn parts(count: usize, len: usize, seed: usize) -> Vec<Vec<f64>> {
    (0..count)
        .map(|part| {
            (0..len)
                .map(|index| ((index * 31 + part * 7 + seed) as f64).sin())
                .collect()
        })
        .collect()
}

/// Three steps of two networks, with followers where a share is given.
fn run(threads: usize, count: usize) -> (Vec<Trained<f64>>, Vec<Mlp<f64>>) {
    let (mut a, mut b) = (trained(1), trained(2));
    let (mut follower_a, mut follower_b) = (trained(3).network, trained(4).network);
    let (mut workers, mut optimiser) = (Workers::new(threads), Optimiser::default());
    for seed in 0..3 {
        let [of_a, of_b] = [0, 50].map(|more| parts(count, a.gradient.len(), seed + more));
        let norms = optimiser.step(
            &mut workers,
            [&mut a, &mut b],
            [&of_a, &of_b],
            Step {
                learning_rate: RATE,
                followers: [Some((0.1, &mut follower_a)), Some((0.3, &mut follower_b))],
            },
        );
        for (norm, network) in norms.iter().zip([&a, &b]) {
            let expected = network.gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
            assert!((norm - expected).abs() < 1e-9 * expected);
        }
    }
    (vec![a, b], vec![follower_a, follower_b])
}

#[test]
fn steps_follow_the_definition() {
    for count in [1, 2, 4, 5] {
        let (networks, followers) = run(1, count);
        for (index, (network, follower)) in networks.iter().zip(&followers).enumerate() {
            let mut expected = trained(1 + index as u64).network.parameters.to_vec();
            let mut following = trained(3 + index as u64).network.parameters.to_vec();
            let (mut first, mut second) = (vec![0.0; expected.len()], vec![0.0; expected.len()]);
            for step in 1..=3 {
                let parts = parts(count, expected.len(), step as usize - 1 + 50 * index);
                let gradient: Vec<f64> = (0..expected.len())
                    .map(|place| parts.iter().map(|part| part[place]).sum())
                    .collect();
                for place in 0..expected.len() {
                    let g = gradient[place];
                    first[place] = 0.9 * first[place] + 0.1 * g;
                    second[place] = 0.999 * second[place] + 0.001 * g * g;
                    let mean = first[place] / (1.0 - 0.9f64.powi(step));
                    let square = second[place] / (1.0 - 0.999f64.powi(step));
                    expected[place] -= RATE * mean / (square.sqrt() + 1e-8);
                    let share = [0.1, 0.3][index];
                    following[place] = (1.0 - share) * following[place] + share * expected[place];
                }
            }
            for (found, expected) in network.network.parameters.iter().zip(&expected) {
                assert!((found - expected).abs() < 1e-12, "{found} {expected}");
            }
            for (found, expected) in follower.parameters.iter().zip(&following) {
                assert!((found - expected).abs() < 1e-12, "{found} {expected}");
            }
        }
    }
}

#[test]
fn threads_change_no_bit() {
    let bits = |threads| {
        let (networks, followers) = run(threads, 3);
        let networks = networks.iter().map(|trained| trained.network.tensors());
        networks
            .chain(followers.iter().map(|network| network.tensors()))
            .collect::<Vec<_>>()
    };
    let one = bits(1);
    assert_eq!(one, bits(2));
    assert_eq!(one, bits(4));
}
