//! A network computes what its definition says, and its derivatives are those of finite differences, in f64, for every
//! parameter and the last inputs, with and without layer normalisation, one output and several. (The learner's tests compare
//! its whole updates with PyTorch.)
//!
//! Its tensors can be taken out and put back by name; the sizes of those that a shape asks for are known beforehand.

use gaitshift_nn::{LAYER_NORM_EPSILON, Mlp, MlpShape, NamedTensor};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

const ROWS: usize = 9;
const INPUTS: usize = 5;

fn shape(outputs: usize, layer_norm: bool) -> MlpShape {
    MlpShape {
        inputs: INPUTS,
        hidden: vec![11, 6],
        outputs,
        layer_norm,
    }
}

fn network(outputs: usize, layer_norm: bool) -> Mlp<f64> {
    Mlp::random(
        shape(outputs, layer_norm),
        &mut Xoshiro256PlusPlus::seed_from_u64(3),
    )
}

fn numbers(count: usize) -> Vec<f64> {
    (0..count).map(|index| (index as f64 * 1.7).sin()).collect()
}

/// A row by the definition, from the named tensors.
fn by_definition(tensors: &[NamedTensor<f64>], layer_norm: bool, x: &[f64]) -> Vec<f64> {
    let get = |name: String| {
        let tensor = tensors.iter().find(|tensor| tensor.name == name);
        tensor.expect("a tensor of this name").values.clone()
    };
    let linear = |prefix: &str, x: &[f64]| -> Vec<f64> {
        let (weight, bias) = (
            get(format!("{prefix}.weight")),
            get(format!("{prefix}.bias")),
        );
        let rows = weight.chunks(x.len()).zip(bias);
        rows.map(|(w, b)| b + w.iter().zip(x).map(|(w, x)| w * x).sum::<f64>())
            .collect()
    };
    let mut x = x.to_vec();
    for layer in 0..2 {
        x = linear(&format!("layers.{layer}"), &x);
        if layer_norm {
            let mean = x.iter().sum::<f64>() / x.len() as f64;
            let variance = x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / x.len() as f64;
            let gain = get(format!("layers.{layer}.norm.weight"));
            let shift = get(format!("layers.{layer}.norm.bias"));
            for ((x, gain), shift) in x.iter_mut().zip(gain).zip(shift) {
                *x = gain * (*x - mean) / (variance + LAYER_NORM_EPSILON).sqrt() + shift;
            }
        }
        x.iter_mut().for_each(|x| *x = x.max(0.0));
    }
    linear("output", &x)
}

#[test]
fn outputs_follow_the_definition() {
    for (outputs, layer_norm) in [(1, false), (4, false), (3, true)] {
        let network = network(outputs, layer_norm);
        let x = numbers(ROWS * INPUTS);
        let mut activations = network.activations(ROWS);
        network.forward(ROWS, &x, INPUTS, &mut activations);
        for (x, found) in x.chunks(INPUTS).zip(activations.out.chunks(outputs)) {
            let expected = by_definition(&network.tensors(), layer_norm, x);
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-12, "{found} {expected}");
            }
        }
    }
}

#[test]
fn gradients_are_finite_differences() {
    for (outputs, layer_norm) in [(1, false), (1, true), (4, false), (3, true)] {
        let mut network = network(outputs, layer_norm);
        let (x, weights) = (numbers(ROWS * INPUTS), numbers(ROWS * outputs));
        let mut activations = network.activations(ROWS);
        // The loss is the weighted sum of all outputs.
        let mut loss = |network: &Mlp<f64>, x: &[f64]| -> f64 {
            network.forward(ROWS, x, INPUTS, &mut activations);
            activations
                .out
                .iter()
                .zip(&weights)
                .map(|(y, w)| y * w)
                .sum()
        };
        let difference = |mut at: Box<dyn FnMut(f64) -> f64 + '_>| (at(1e-6) - at(-1e-6)) / 2e-6;
        let tensors = network.tensors();
        let mut by_difference = Vec::new();
        for tensor in 0..tensors.len() {
            for element in 0..tensors[tensor].values.len() {
                by_difference.push(difference(Box::new(|offset| {
                    let mut changed = tensors.clone();
                    changed[tensor].values[element] += offset;
                    assert_eq!(network.load_tensors(&changed), tensors.len());
                    loss(&network, &x)
                })));
            }
        }
        network.load_tensors(&tensors);
        let tail: Vec<_> = (0..ROWS * 2)
            .map(|place| {
                difference(Box::new(|offset| {
                    let mut x = x.clone();
                    x[place / 2 * INPUTS + 3 + place % 2] += offset;
                    loss(&network, &x)
                }))
            })
            .collect();

        let (transposed, mut deltas) = (network.transposed(), network.deltas(ROWS));
        network.forward(ROWS, &x, INPUTS, &mut activations);
        let mut gradient = network.zeros_like();
        network.backward(
            &transposed,
            ROWS,
            &x,
            INPUTS,
            &activations,
            &weights,
            &mut deltas,
            &mut gradient,
        );
        let by_hand = network.tensors_of(&gradient);
        let by_hand = by_hand.iter().flat_map(|tensor| &tensor.values);
        for (found, expected) in by_hand.zip(&by_difference) {
            assert!((found - expected).abs() < 1e-7, "{found} {expected}");
        }
        if outputs == 1 {
            let every: Vec<_> = (0..ROWS).collect();
            let mut d_tail = vec![0.0; ROWS * 2];
            network.input_gradient(
                &transposed,
                &every,
                2,
                &activations,
                &mut deltas,
                &mut d_tail,
            );
            for (place, (found, expected)) in d_tail.iter().zip(tail).enumerate() {
                let found = found * weights[place / 2];
                assert!((found - expected).abs() < 1e-7, "{found} {expected}");
            }
        }
    }
}

#[test]
fn tensors_are_those_that_the_shape_names() {
    for layer_norm in [false, true] {
        let network = network(4, layer_norm);
        let tensors = network.tensors();
        let named: Vec<_> = tensors
            .iter()
            .map(|tensor| (tensor.name.clone(), tensor.shape.clone()))
            .collect();
        assert_eq!(network.shape().tensors(), named);
        let count: usize = tensors.iter().map(|tensor| tensor.values.len()).sum();
        assert_eq!(network.parameter_count(), count);
        let mut rebuilt = Mlp::zeros(shape(4, layer_norm));
        assert_eq!(rebuilt.load_tensors(&tensors), tensors.len());
        assert_eq!(rebuilt.tensors(), tensors);
    }
}
