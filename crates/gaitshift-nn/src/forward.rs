//! Networks forward.

use crate::buffer::Buffer;
use crate::layer_norm::{Norm, normalise};
use crate::mlp::Mlp;
use crate::output_layer::project;
use crate::pattern::Pattern;
use crate::product::{Epilogue, Left, Product};
use crate::simd::Scalar;
use crate::{dense, sparse};

/// What a forward pass leaves behind for the backward pass, for up to a fixed number of rows.
#[derive(Clone, Debug)]
pub struct Activations<T> {
    pub(crate) layers: Vec<LayerActivations<T>>,
    /// Which values are not 0, of each layer but the last.
    pub(crate) patterns: Vec<Pattern>,
    /// Outputs, rows × outputs.
    pub out: Vec<T>,
}

#[derive(Clone, Debug)]
pub(crate) struct LayerActivations<T> {
    /// After the ReLU.
    pub value: Buffer<T>,
    /// Before gain and shift; only with layer normalisation.
    pub normalised: Buffer<T>,
    /// 1 / standard deviation of each row; only with layer normalisation.
    pub inverse_deviation: Vec<T>,
}

impl<T: Scalar> Mlp<T> {
    /// Scratch of the forward pass for up to `rows` rows.
    pub fn activations(&self, rows: usize) -> Activations<T> {
        let hidden = &self.layout.hidden;
        let layers = hidden
            .iter()
            .map(|layer| LayerActivations {
                value: Buffer::zeros(rows * layer.stride),
                normalised: Buffer::zeros(if self.shape.layer_norm {
                    rows * layer.stride
                } else {
                    0
                }),
                inverse_deviation: vec![T::ZERO; if self.shape.layer_norm { rows } else { 0 }],
            })
            .collect();
        Activations {
            layers,
            patterns: hidden[1..]
                .iter()
                .map(|layer| Pattern::new(rows, layer.inputs))
                .collect(),
            out: vec![T::ZERO; rows * self.shape.outputs],
        }
    }

    /// Outputs for `rows` rows of `x` (row stride `x_stride`), left in `activations.out` together with what
    /// the backward pass needs.
    pub fn forward(&self, rows: usize, x: &[T], x_stride: usize, activations: &mut Activations<T>) {
        let Activations {
            layers,
            patterns,
            out,
        } = activations;
        let (mut x, mut x_stride) = (x, x_stride);
        for (index, (layer, scratch)) in self.layout.hidden.iter().zip(layers).enumerate() {
            let bias = &self.parameters[layer.bias..][..layer.padded];
            let product = Product {
                rows,
                shared: layer.inputs,
                columns: layer.padded,
                a: Left::Rows(x, x_stride),
                b: &self.parameters[layer.weight_range()],
                b_stride: layer.stride,
                c: &mut scratch.value,
                c_stride: layer.stride,
                epilogue: if self.shape.layer_norm {
                    Epilogue::Bias(bias)
                } else {
                    Epilogue::BiasRelu(bias)
                },
            };
            match index.checked_sub(1) {
                Some(below) => sparse::multiply(product, &patterns[below]),
                None => dense::multiply(product),
            }
            if self.shape.layer_norm {
                normalise(
                    rows,
                    Norm {
                        units: layer.units,
                        stride: layer.stride,
                        gain: &self.parameters[layer.gain..][..layer.padded],
                        shift: &self.parameters[layer.shift..][..layer.padded],
                    },
                    &mut scratch.value,
                    &mut scratch.normalised,
                    &mut scratch.inverse_deviation,
                );
            }
            (x, x_stride) = (&scratch.value, layer.stride);
            if let Some(pattern) = patterns.get_mut(index) {
                pattern.read(rows, layer.units, x, x_stride);
            }
        }
        let last = &self.layout.hidden[self.layout.hidden.len() - 1];
        project(
            rows,
            last.padded,
            x,
            x_stride,
            &self.parameters[self.layout.weight..][..self.shape.outputs * last.padded],
            &self.parameters[self.layout.bias..][..self.shape.outputs],
            out,
        );
    }
}
