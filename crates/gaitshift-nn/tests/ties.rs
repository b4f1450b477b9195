//! A tied network commutes with the mirrors of its inputs and outputs, signs included, from its random start on and after any
//! steps of the optimiser, whatever the gradients; it keeps the spread of its random weights.

use gaitshift_nn::{Mlp, MlpShape, Optimiser, Step, Trained, Workers};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

/// Two change places, one changes its sign, one stays.
const INPUTS: [(usize, f32); 4] = [(1, 1.0), (0, 1.0), (2, -1.0), (3, 1.0)];
/// Two change places and signs, one changes its sign.
const OUTPUTS: [(usize, f32); 3] = [(1, -1.0), (0, -1.0), (2, -1.0)];

fn image<const N: usize>(map: [(usize, f32); N], of: &[f64]) -> Vec<f64> {
    map.iter()
        .map(|&(source, sign)| f64::from(sign) * of[source])
        .collect()
}

fn output(network: &Mlp<f64>, x: &[f64]) -> Vec<f64> {
    let mut activations = network.activations(1);
    network.forward(1, x, x.len(), &mut activations);
    activations.out.to_vec()
}

/// Greatest |f(M x) - M' f(x)| over some x.
fn error(network: &Mlp<f64>) -> f64 {
    (0..20)
        .flat_map(|row| {
            let x: Vec<f64> = (0..4)
                .map(|i| (f64::from(row * 4 + i) * 1.7).sin())
                .collect();
            let mirrored = output(network, &image(INPUTS, &x));
            let expected = image(OUTPUTS, &output(network, &x));
            let pairs: Vec<_> = mirrored.into_iter().zip(expected).collect();
            pairs.into_iter().map(|(a, b)| (a - b).abs())
        })
        .fold(0.0, f64::max)
}

#[test]
fn a_tied_network_commutes_with_the_mirrors() {
    for (hidden, layer_norm, max_norm) in [
        (vec![12, 8], false, None),
        (vec![13, 7], true, None),
        (vec![9], true, Some(0.3)),
    ] {
        let shape = MlpShape {
            inputs: 4,
            hidden,
            outputs: 3,
            layer_norm,
        };
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
        let mut trained = Trained::new(Mlp::random(shape, &mut rng));
        assert!(error(&trained.network) > 0.1);
        let untied = trained.network.parameters.to_vec();
        trained.tie(trained.network.ties(&INPUTS, &OUTPUTS));
        assert!(error(&trained.network) < 1e-13);
        let (mut workers, mut optimiser) = (Workers::new(2), Optimiser::default());
        for seed in 0..5 {
            let gradient: Vec<f64> = (0..untied.len())
                .map(|i| ((i * 31 + seed) as f64).sin() * f64::from(untied[i] != 0.0))
                .collect();
            optimiser.step(
                &mut workers,
                [&mut trained],
                [&[gradient]],
                Step {
                    learning_rate: 0.01,
                    max_norm,
                    followers: [None],
                },
            );
            assert!(error(&trained.network) < 1e-13);
        }
        assert_ne!(trained.network.parameters.to_vec(), untied);
    }
}

#[test]
fn random_weights_keep_their_spread() {
    let shape = MlpShape {
        inputs: 4,
        hidden: vec![64, 64],
        outputs: 3,
        layer_norm: false,
    };
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    let mut trained = Trained::new(Mlp::<f64>::random(shape, &mut rng));
    let square = |trained: &Trained<f64>| -> f64 {
        let tensors = trained.network.tensors();
        let weight = tensors.iter().find(|t| t.name == "layers.1.weight");
        let values = &weight.expect("a second layer").values;
        values.iter().map(|w| w * w).sum::<f64>() / values.len() as f64
    };
    let before = square(&trained);
    trained.tie(trained.network.ties(&INPUTS, &OUTPUTS));
    assert!((square(&trained) / before - 1.0).abs() < 0.1);
}
