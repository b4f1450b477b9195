//! Networks backward: gradients of the parameters and of the last inputs.

use crate::buffer::Buffer;
use crate::forward::Activations;
use crate::layer_norm::{normalise_back, normalise_back_selected, normalise_weight_gradient};
use crate::mlp::Mlp;
use crate::output_layer::output_back;
use crate::pattern::Pattern;
use crate::product::{Epilogue, Left, Product, row_stride};
use crate::simd::{LANES, Scalar, Simd8, Vector, Vector8, vectorised};
use crate::sums::column_sums;
use crate::{dense, sparse};

/// Two matrices in which the derivative travels backwards through the layers.
#[derive(Clone, Debug)]
pub struct Deltas<T> {
    front: Buffer<T>,
    back: Buffer<T>,
    pattern: Pattern,
}

/// Copies of the weights in the order in which the backward pass reads them.
#[derive(Clone, Debug)]
pub struct Transposed<T> {
    /// For each hidden layer but the first: the weights in the order units × inputs.
    weights: Vec<Buffer<T>>,
}

impl<T: Scalar> Mlp<T> {
    /// Scratch of the backward pass for up to `rows` rows.
    pub fn deltas(&self, rows: usize) -> Deltas<T> {
        let most = self.shape.hidden.iter().copied().max().unwrap_or(0);
        Deltas {
            front: Buffer::zeros(rows * row_stride(most)),
            back: Buffer::zeros(rows * row_stride(most)),
            pattern: Pattern::new(rows, most),
        }
    }

    /// Transposed copies of the weights.
    pub fn transposed(&self) -> Transposed<T> {
        let mut transposed = Transposed {
            weights: self.layout.hidden[1..]
                .iter()
                .map(|layer| Buffer::zeros(layer.units * row_stride(layer.inputs)))
                .collect(),
        };
        self.refresh(&mut transposed);
        transposed
    }

    /// Brings the transposed copies up to date with the parameters.
    pub fn refresh(&self, transposed: &mut Transposed<T>) {
        for (layer, out) in self.layout.hidden[1..].iter().zip(&mut transposed.weights) {
            transpose(
                layer.inputs,
                layer.units,
                &self.parameters[layer.weight_range()],
                layer.stride,
                out,
                row_stride(layer.inputs),
            );
        }
    }

    /// Gradient of a loss in all parameters, from `d_out`, its derivative in the outputs (rows × outputs), at
    /// the point of the last forward pass. Overwrites `gradient`.
    #[allow(clippy::too_many_arguments)]
    pub fn backward(
        &self,
        transposed: &Transposed<T>,
        rows: usize,
        x: &[T],
        x_stride: usize,
        activations: &Activations<T>,
        d_out: &[T],
        deltas: &mut Deltas<T>,
        gradient: &mut [T],
    ) {
        let hidden = &self.layout.hidden;
        let outputs = self.shape.outputs;
        let depth = hidden.len();
        let last = &hidden[depth - 1];
        let value = &activations.layers[depth - 1].value;
        let (before, bias) = gradient.split_at_mut(self.layout.bias);
        let (hidden_gradient, weight_gradient) = before.split_at_mut(self.layout.weight);
        output_back(
            rows,
            last.padded,
            last.stride,
            d_out,
            &self.parameters[self.layout.weight..][..outputs * last.padded],
            value,
            &mut deltas.front,
            &mut weight_gradient[..outputs * last.padded],
            &mut bias[..outputs],
            &mut hidden_gradient[last.bias..][..last.padded],
        );
        for index in (0..depth).rev() {
            let layer = &hidden[index];
            let scratch = &activations.layers[index];
            if self.shape.layer_norm {
                let (gain, shift) = gradient[layer.gain..].split_at_mut(layer.shift - layer.gain);
                normalise_weight_gradient(
                    rows,
                    layer.stride,
                    &deltas.front,
                    &scratch.normalised,
                    &mut gain[..layer.padded],
                    &mut shift[..layer.padded],
                );
                normalise_back(
                    rows,
                    layer.units,
                    layer.stride,
                    &self.parameters[layer.gain..][..layer.padded],
                    &scratch.normalised,
                    &scratch.inverse_deviation,
                    &mut deltas.front,
                );
            }
            // Without normalisation the pass through the output layer has summed the last layer's already.
            if self.shape.layer_norm || index + 1 < depth {
                column_sums(
                    rows,
                    layer.stride,
                    &deltas.front,
                    &mut gradient[layer.bias..][..layer.padded],
                );
            }
            let below = index.checked_sub(1).map(|below| {
                let values = &activations.layers[below].value[..];
                (values, hidden[below].stride, &activations.patterns[below])
            });
            let (x, x_stride) = below.map_or((x, x_stride), |(x, stride, _)| (x, stride));
            let product = Product {
                rows: layer.inputs,
                shared: rows,
                columns: layer.padded,
                a: Left::Transposed(x, x_stride),
                b: &deltas.front,
                b_stride: layer.stride,
                c: &mut gradient[layer.weight_range()],
                c_stride: layer.stride,
                epilogue: Epilogue::None,
            };
            match below {
                Some((x, x_stride, pattern)) => {
                    deltas.pattern.transpose(pattern);
                    sparse::multiply(product, &deltas.pattern);
                    let mask = Epilogue::Mask(x, x_stride);
                    self.layer_back(index, rows, &transposed.weights[index - 1], mask, deltas);
                }
                None => dense::multiply(product),
            }
        }
    }

    /// The derivative in a hidden layer's inputs, from that in the layer before its ReLU and normalisation; both are at the
    /// front of `deltas`.
    fn layer_back(
        &self,
        index: usize,
        rows: usize,
        transposed: &[T],
        epilogue: Epilogue<'_, T>,
        deltas: &mut Deltas<T>,
    ) {
        let (layer, below) = (&self.layout.hidden[index], &self.layout.hidden[index - 1]);
        let product = Product {
            rows,
            shared: layer.units,
            columns: below.padded,
            a: Left::Rows(&deltas.front, layer.stride),
            b: transposed,
            b_stride: row_stride(layer.inputs),
            c: &mut deltas.back,
            c_stride: below.stride,
            epilogue,
        };
        if self.shape.layer_norm {
            // The normalisation has mixed all units.
            dense::multiply(product);
        } else {
            deltas
                .pattern
                .read(rows, layer.units, &deltas.front, layer.stride);
            sparse::multiply(product, &deltas.pattern);
        }
        std::mem::swap(&mut deltas.front, &mut deltas.back);
    }

    /// Derivative of the single output in the last `tail` inputs, for the rows
    /// listed in `selected`, at the point of the last forward pass; written to the same rows of `d_tail`
    /// (rows × tail).
    pub fn input_gradient(
        &self,
        transposed: &Transposed<T>,
        selected: &[usize],
        tail: usize,
        activations: &Activations<T>,
        deltas: &mut Deltas<T>,
        d_tail: &mut [T],
    ) {
        assert!(self.shape.outputs == 1);
        if selected.is_empty() {
            return;
        }
        let hidden = &self.layout.hidden;
        let depth = hidden.len();
        let last = &hidden[depth - 1];
        let rows = selected.len();
        let weight = &self.parameters[self.layout.weight..][..last.padded];
        seed_selected(
            selected,
            weight,
            last.stride,
            &activations.layers[depth - 1].value,
            &mut deltas.front,
        );
        for index in (0..depth).rev() {
            let layer = &hidden[index];
            let scratch = &activations.layers[index];
            if index + 1 < depth {
                mask_selected(
                    selected,
                    layer.padded,
                    layer.stride,
                    &scratch.value,
                    &mut deltas.front,
                );
            }
            if self.shape.layer_norm {
                normalise_back_selected(
                    selected,
                    layer.units,
                    layer.stride,
                    &self.parameters[layer.gain..][..layer.padded],
                    &scratch.normalised,
                    &scratch.inverse_deviation,
                    &mut deltas.front,
                );
            }
            if index > 0 {
                let transposed = &transposed.weights[index - 1];
                self.layer_back(index, rows, transposed, Epilogue::None, deltas);
            }
        }
        let first = &hidden[0];
        let before = (first.inputs - tail) * first.stride;
        tail_gradient(
            selected,
            first.padded,
            first.stride,
            tail,
            &deltas.front,
            &self.parameters[first.weight_range()][before..],
            d_tail,
        );
    }
}

vectorised! {
    /// `weight` (`inputs` × `units`) to its transpose, in squares that fit the registers; padding is carried along.
    fn transpose<T>(simd, inputs: usize,
        units: usize,
        weight: &[T],
        stride: usize,
        out: &mut [T],
        out_stride: usize,
    ) {
        for row in (0..inputs).step_by(LANES) {
            for column in (0..units).step_by(LANES) {
                let square = Vector8::transpose(std::array::from_fn(|lane| {
                    if row + lane < inputs {
                        simd.load(&weight[(row + lane) * stride + column..])
                    } else {
                        simd.splat(T::ZERO)
                    }
                }));
                for (lane, column_of) in square.into_iter().enumerate().take(units - column) {
                    column_of.store(&mut out[(column + lane) * out_stride + row..]);
                }
            }
        }
    }
}

/// Sum of the products of two rows, a whole number of lanes long.
#[inline(always)]
fn dot<T: Scalar>(simd: impl Simd8<T>, a: &[T], b: &[T]) -> T {
    let mut sum = simd.splat(T::ZERO);
    for (a, b) in a.chunks_exact(LANES).zip(b.chunks_exact(LANES)) {
        sum = simd.load(a).mul_add(simd.load(b), sum);
    }
    sum.sum()
}

vectorised! {
    /// The one row of output weights, where the selected row of `value` is positive.
    fn seed_selected<T>(simd, selected: &[usize], weight: &[T], stride: usize, value: &[T], delta: &mut [T]) {
        for (delta, &row) in delta.chunks_mut(stride).zip(selected) {
            let values = value[row * stride..].chunks_exact(LANES);
            let deltas = delta.chunks_exact_mut(LANES);
            for ((delta, value), weight) in deltas.zip(values).zip(weight.chunks_exact(LANES)) {
                let masked = simd.load(weight).where_positive(simd.load(value));
                masked.store(delta);
            }
        }
    }
}

vectorised! {
    /// Zero where the selected row of `value` is not positive.
    fn mask_selected<T>(simd, selected: &[usize], padded: usize, stride: usize, value: &[T], delta: &mut [T]) {
        for (delta, &row) in delta.chunks_mut(stride).zip(selected) {
            let values = value[row * stride..].chunks_exact(LANES);
            for (delta, value) in delta[..padded].chunks_exact_mut(LANES).zip(values) {
                let masked = simd.load(delta).where_positive(simd.load(value));
                masked.store(delta);
            }
        }
    }
}

vectorised! {
    /// Derivative in the last inputs of the first layer, scattered to the selected rows.
    fn tail_gradient<T>(simd, selected: &[usize],
        padded: usize,
        stride: usize,
        tail: usize,
        delta: &[T],
        weight: &[T],
        d_tail: &mut [T],
    ) {
        for (delta, &row) in delta.chunks(stride).zip(selected) {
            for (out, weight) in d_tail[row * tail..][..tail].iter_mut().zip(weight.chunks(stride)) {
                *out = dot::<T>(simd, &delta[..padded], &weight[..padded]);
            }
        }
    }
}
