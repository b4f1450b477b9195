//! Multi-layer perceptrons with hand-written derivatives: hidden layers `[linear, layer norm?, ReLU]`, then a
//! linear output.
//!
//! All parameters of a network are one flat buffer; hidden weights lie in the order inputs × units (see [`crate::dense`]),
//! the output layer's in the order outputs × units. [`Mlp::tensors`] and [`Mlp::load_tensors`] translate from and to the layout
//! and names of PyTorch (`weight` is outputs × inputs).

use rand_xoshiro::Xoshiro256PlusPlus;

use crate::dense::{self, Epilogue, Left, Product, padded, row_stride};
use crate::lanes::{LANES, Lanes};
use crate::random::uniform;
use crate::real::{Buffer, LINE, Real, wide};
use crate::sparse::{self, Pattern};

/// Added to the variance in layer normalisation, as in PyTorch.
pub const LAYER_NORM_EPSILON: f64 = 1e-5;

/// Sizes of a network.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MlpShape {
    /// Input numbers.
    pub inputs: usize,
    /// Units of each hidden layer, at least one layer.
    pub hidden: Vec<usize>,
    /// Output numbers.
    pub outputs: usize,
    /// Layer normalisation after each hidden linear layer, before the ReLU.
    pub layer_norm: bool,
}

impl MlpShape {
    /// Names and shapes of the parameter tensors, in order. Takes no memory for the parameters themselves, so that a
    /// file can be compared with the sizes that it names before a network of those sizes is made.
    pub fn tensors(&self) -> Vec<(String, Vec<usize>)> {
        let mut tensors = Vec::new();
        let mut inputs = self.inputs;
        for (index, &units) in self.hidden.iter().enumerate() {
            let mut add =
                |name: &str, shape| tensors.push((format!("layers.{index}.{name}"), shape));
            add("weight", vec![units, inputs]);
            add("bias", vec![units]);
            if self.layer_norm {
                add("norm.weight", vec![units]);
                add("norm.bias", vec![units]);
            }
            inputs = units;
        }
        tensors.push(("output.weight".into(), vec![self.outputs, inputs]));
        tensors.push(("output.bias".into(), vec![self.outputs]));
        tensors
    }
}

/// Where a hidden layer lies in the flat parameters.
#[derive(Clone, Debug)]
struct Hidden {
    inputs: usize,
    units: usize,
    /// Columns as stored.
    padded: usize,
    /// Distance between rows of its activations, and between the weights of one input and the next.
    stride: usize,
    weight: usize,
    bias: usize,
    gain: usize,
    shift: usize,
}

impl Hidden {
    fn weight_range(&self) -> std::ops::Range<usize> {
        self.weight..self.weight + self.inputs * self.stride
    }
}

/// Where a tensor lies in the flat parameters.
struct Place {
    start: usize,
    extents: [usize; 2],
    strides: [usize; 2],
}

impl Place {
    /// Where its elements lie, last index fastest.
    fn indices(&self) -> impl Iterator<Item = usize> + use<> {
        let (start, [rows, columns], [row, column]) = (self.start, self.extents, self.strides);
        (0..rows).flat_map(move |r| (0..columns).map(move |c| start + r * row + c * column))
    }
}

#[derive(Clone, Debug)]
struct Layout {
    hidden: Vec<Hidden>,
    /// Output weights, one row of `last.padded` numbers per output.
    weight: usize,
    bias: usize,
    len: usize,
}

impl Layout {
    fn new(shape: &MlpShape) -> Self {
        let mut len = 0;
        let mut reserve = |count: usize| {
            let start = len;
            len += count.next_multiple_of(LINE);
            start
        };
        let mut inputs = shape.inputs;
        let hidden: Vec<_> = shape
            .hidden
            .iter()
            .map(|&units| {
                let padded = padded(units);
                let layer = Hidden {
                    inputs,
                    units,
                    padded,
                    stride: row_stride(units),
                    weight: reserve(inputs * row_stride(units)),
                    bias: reserve(padded),
                    gain: if shape.layer_norm { reserve(padded) } else { 0 },
                    shift: if shape.layer_norm { reserve(padded) } else { 0 },
                };
                inputs = units;
                layer
            })
            .collect();
        let last = hidden.last().map_or(0, |layer| layer.padded);
        let weight = reserve(shape.outputs * last);
        let bias = reserve(shape.outputs);
        Self {
            hidden,
            weight,
            bias,
            len,
        }
    }
}

/// One named parameter tensor in PyTorch's layout.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedTensor<T> {
    /// Such as `layers.0.weight`, `layers.0.norm.weight`, `output.bias`.
    pub name: String,
    /// Extents; weights are outputs × inputs.
    pub shape: Vec<usize>,
    /// Elements, last index fastest.
    pub values: Vec<T>,
}

/// A multi-layer perceptron.
#[derive(Clone, Debug)]
pub struct Mlp<T> {
    shape: MlpShape,
    layout: Layout,
    /// All parameters; padding is zero and stays zero.
    pub(crate) parameters: Buffer<T>,
}

/// What a forward pass leaves behind for the backward pass, for up to a fixed number of rows.
#[derive(Clone, Debug)]
pub struct Activations<T> {
    layers: Vec<LayerActivations<T>>,
    /// Which values are not 0, of each layer but the last.
    patterns: Vec<Pattern>,
    /// Outputs, rows × outputs.
    pub out: Vec<T>,
}

#[derive(Clone, Debug)]
struct LayerActivations<T> {
    /// After the ReLU.
    value: Buffer<T>,
    /// Before gain and shift; only with layer normalisation.
    normalised: Buffer<T>,
    /// 1 / standard deviation of each row; only with layer normalisation.
    inverse_deviation: Vec<T>,
}

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

impl<T: Real> Mlp<T> {
    /// All parameters zero, gains one.
    pub fn zeros(shape: MlpShape) -> Self {
        let layout = Layout::new(&shape);
        let mut parameters = Buffer::zeros(layout.len);
        if shape.layer_norm {
            for layer in &layout.hidden {
                parameters[layer.gain..layer.gain + layer.units].fill(T::ONE);
            }
        }
        Self {
            shape,
            layout,
            parameters,
        }
    }

    /// Weights and biases uniform in ±1/√inputs, as PyTorch's `nn.Linear` draws them; gains 1, shifts 0.
    pub fn random(shape: MlpShape, rng: &mut Xoshiro256PlusPlus) -> Self {
        let mut net = Self::zeros(shape);
        let mut tensors = net.tensors();
        let mut bound = 0.0;
        for tensor in &mut tensors {
            if tensor.name.contains("norm") {
                continue;
            }
            if let [_, inputs] = tensor.shape[..] {
                bound = 1.0 / (inputs as f64).sqrt();
            }
            for value in &mut tensor.values {
                *value = T::from_f64(uniform(rng, -bound, bound));
            }
        }
        net.load_tensors(&tensors);
        net
    }

    /// Sizes.
    pub fn shape(&self) -> &MlpShape {
        &self.shape
    }

    /// For each parameter tensor, in the order of [`MlpShape::tensors`]: where it lies in the flat buffer, as its extents
    /// and the distances between neighbours along them.
    fn places(&self) -> Vec<Place> {
        let mut places = Vec::new();
        let vector = |start, units| Place {
            start,
            extents: [1, units],
            strides: [0, 1],
        };
        for layer in &self.layout.hidden {
            places.push(Place {
                start: layer.weight,
                extents: [layer.units, layer.inputs],
                strides: [1, layer.stride],
            });
            places.push(vector(layer.bias, layer.units));
            if self.shape.layer_norm {
                places.push(vector(layer.gain, layer.units));
                places.push(vector(layer.shift, layer.units));
            }
        }
        let last = &self.layout.hidden[self.layout.hidden.len() - 1];
        places.push(Place {
            start: self.layout.weight,
            extents: [self.shape.outputs, last.units],
            strides: [last.padded, 1],
        });
        places.push(vector(self.layout.bias, self.shape.outputs));
        places
    }

    /// Numbers that `flat` (parameters, a gradient, a moment: anything in this network's layout) holds, as
    /// named tensors.
    pub fn tensors_of(&self, flat: &[T]) -> Vec<NamedTensor<T>> {
        self.shape
            .tensors()
            .into_iter()
            .zip(self.places())
            .map(|((name, shape), place)| NamedTensor {
                name,
                shape,
                values: place.indices().map(|index| flat[index]).collect(),
            })
            .collect()
    }

    /// The parameters as named tensors.
    pub fn tensors(&self) -> Vec<NamedTensor<T>> {
        self.tensors_of(&self.parameters)
    }

    /// Writes named tensors into `flat`; tensors of other names or shapes are left alone. Returns how many
    /// were written.
    pub fn load_tensors_into(&self, tensors: &[NamedTensor<T>], flat: &mut [T]) -> usize {
        let mut loaded = 0;
        for ((name, shape), place) in self.shape.tensors().into_iter().zip(self.places()) {
            if let Some(tensor) = tensors
                .iter()
                .find(|tensor| tensor.name == name && tensor.shape == shape)
            {
                for (index, &value) in place.indices().zip(&tensor.values) {
                    flat[index] = value;
                }
                loaded += 1;
            }
        }
        loaded
    }

    /// Replaces the parameters named in `tensors`. Returns how many tensors were written.
    pub fn load_tensors(&mut self, tensors: &[NamedTensor<T>]) -> usize {
        let mut parameters = std::mem::replace(&mut self.parameters, Buffer::zeros(0));
        let loaded = self.load_tensors_into(tensors, &mut parameters);
        self.parameters = parameters;
        loaded
    }

    /// Real (not padding) parameters.
    pub fn parameter_count(&self) -> usize {
        let places = self.places().into_iter();
        places.map(|place| place.indices().count()).sum()
    }

    /// Zeros in the layout of the parameters.
    pub fn zeros_like(&self) -> Buffer<T> {
        Buffer::zeros(self.layout.len)
    }

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
                a: Left::rows(x, x_stride),
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
                a: Left::transposed(x, x_stride),
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
            a: Left::rows(&deltas.front, layer.stride),
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

wide! {
    /// `weight` (`inputs` × `units`) to its transpose, in squares that fit the registers; padding is carried along.
    fn transpose<T, V>(
        inputs: usize,
        units: usize,
        weight: &[T],
        stride: usize,
        out: &mut [T],
        out_stride: usize,
    ) {
        for row in (0..inputs).step_by(LANES) {
            for column in (0..units).step_by(LANES) {
                let square = V::transpose(std::array::from_fn(|lane| {
                    if row + lane < inputs {
                        V::load(weight, (row + lane) * stride + column)
                    } else {
                        V::splat(T::ZERO)
                    }
                }));
                for (lane, column_of) in square.into_iter().enumerate().take(units - column) {
                    column_of.store(out, (column + lane) * out_stride + row);
                }
            }
        }
    }
}

/// Rows whose products with the same weights are summed side by side: as many sums as the multiply-add units keep in
/// flight.
const PROJECTED: usize = 8;

/// `ROWS` rows of [`project`]; each row's arithmetic does not depend on `ROWS`.
#[inline(always)]
fn project_rows<T: Real, V: Lanes<T>, const ROWS: usize>(
    padded: usize,
    x: &[T],
    stride: usize,
    weight: &[T],
    bias: &[T],
    out: &mut [T],
) {
    let outputs = bias.len();
    // Slices of one length each, so that the loop below needs no check.
    let groups = padded / LANES;
    let x: [_; ROWS] =
        std::array::from_fn(|row| &x[row * stride..].as_chunks::<LANES>().0[..groups]);
    for (output, (weight, &bias)) in weight.chunks_exact(padded).zip(bias).enumerate() {
        let weight = &weight.as_chunks::<LANES>().0[..groups];
        let mut sums = [V::splat(T::ZERO); ROWS];
        for group in 0..groups {
            let weight = V::load(&weight[group], 0);
            for (x, sum) in x.iter().zip(&mut sums) {
                *sum = V::load(&x[group], 0).mul_add(weight, *sum);
            }
        }
        for (row, sum) in sums.into_iter().enumerate() {
            out[row * outputs + output] = bias + sum.sum();
        }
    }
}

/// Sum of the products of two rows, a whole number of lanes long.
#[inline(always)]
fn dot<T: Real, V: Lanes<T>>(a: &[T], b: &[T]) -> T {
    let mut sum = V::splat(T::ZERO);
    for (a, b) in a.chunks_exact(LANES).zip(b.chunks_exact(LANES)) {
        sum = V::load(a, 0).mul_add(V::load(b, 0), sum);
    }
    sum.sum()
}

wide! {
    /// out = X Wᵀ + bias, for the few rows of W that an output layer has.
    fn project<T, V>(
        rows: usize,
        padded: usize,
        x: &[T],
        stride: usize,
        weight: &[T],
        bias: &[T],
        out: &mut [T],
    ) {
        let mut row = 0;
        while row < rows {
            let (x, out) = (&x[row * stride..], &mut out[row * bias.len()..]);
            if rows - row >= PROJECTED {
                project_rows::<T, V, PROJECTED>(padded, x, stride, weight, bias, out);
                row += PROJECTED;
            } else {
                project_rows::<T, V, 1>(padded, x, stride, weight, bias, out);
                row += 1;
            }
        }
    }
}

/// Columns from `column` on, `GROUPS` groups of lanes, of [`output_back`] for `OUTPUTS` outputs.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn output_columns_back<T: Real, V: Lanes<T>, const OUTPUTS: usize, const GROUPS: usize>(
    rows: usize,
    padded: usize,
    stride: usize,
    column: usize,
    d_out: &[T],
    weight: &[T],
    value: &[T],
    delta: &mut [T],
    weight_gradient: &mut [T],
    delta_sums: &mut [T],
) {
    let place = |output: usize, group: usize| output * padded + column + group * LANES;
    let weights: [[V; GROUPS]; OUTPUTS] = std::array::from_fn(|output| {
        std::array::from_fn(|group| V::load(weight, place(output, group)))
    });
    let mut gradients = [[V::splat(T::ZERO); GROUPS]; OUTPUTS];
    let mut sums = [V::splat(T::ZERO); GROUPS];
    for (row, d_out) in d_out.chunks_exact(OUTPUTS).take(rows).enumerate() {
        let d_out: [V; OUTPUTS] = std::array::from_fn(|output| V::splat(d_out[output]));
        for (group, sum) in sums.iter_mut().enumerate() {
            let place = row * stride + column + group * LANES;
            let value = V::load(value, place);
            let mut derivative = V::splat(T::ZERO);
            for output in 0..OUTPUTS {
                derivative = d_out[output].mul_add(weights[output][group], derivative);
                gradients[output][group] = d_out[output].mul_add(value, gradients[output][group]);
            }
            let derivative = derivative.where_positive(value);
            derivative.store(delta, place);
            *sum = sum.add(derivative);
        }
    }
    for (output, gradients) in gradients.into_iter().enumerate() {
        for (group, gradient) in gradients.into_iter().enumerate() {
            gradient.store(weight_gradient, place(output, group));
        }
    }
    for (group, sum) in sums.into_iter().enumerate() {
        sum.store(delta_sums, column + group * LANES);
    }
}

/// [`output_back`] for `OUTPUTS` outputs, as many groups of lanes at a time as the registers hold.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn outputs_back<T: Real, V: Lanes<T>, const OUTPUTS: usize, const GROUPS: usize>(
    rows: usize,
    padded: usize,
    stride: usize,
    d_out: &[T],
    weight: &[T],
    value: &[T],
    delta: &mut [T],
    weight_gradient: &mut [T],
    delta_sums: &mut [T],
) {
    // Called by name each, so that both are inlined and compiled for the processor's vectors.
    let whole = padded - padded % (GROUPS * LANES);
    for column in (0..whole).step_by(GROUPS * LANES) {
        output_columns_back::<T, V, OUTPUTS, GROUPS>(
            rows,
            padded,
            stride,
            column,
            d_out,
            weight,
            value,
            delta,
            weight_gradient,
            delta_sums,
        );
    }
    for column in (whole..padded).step_by(LANES) {
        output_columns_back::<T, V, OUTPUTS, 1>(
            rows,
            padded,
            stride,
            column,
            d_out,
            weight,
            value,
            delta,
            weight_gradient,
            delta_sums,
        );
    }
}

wide! {
    /// One pass back through the output layer: the derivative in the last hidden layer before its ReLU, given the
    /// layer's values after it; that derivative's sum over rows; the gradients of the output layer's weights and biases.
    fn output_back<T, V>(
        rows: usize,
        padded: usize,
        stride: usize,
        d_out: &[T],
        weight: &[T],
        value: &[T],
        delta: &mut [T],
        weight_gradient: &mut [T],
        bias_gradient: &mut [T],
        delta_sums: &mut [T],
    ) {
        let outputs = bias_gradient.len();
        for (output, bias) in bias_gradient.iter_mut().enumerate() {
            *bias = T::ZERO;
            for row in 0..rows {
                *bias += d_out[row * outputs + output];
            }
        }
        // A critic has one output, the actor of the biped four.
        match outputs {
            1 => outputs_back::<T, V, 1, 2>(
                rows, padded, stride, d_out, weight, value, delta, weight_gradient, delta_sums,
            ),
            4 => outputs_back::<T, V, 4, 1>(
                rows, padded, stride, d_out, weight, value, delta, weight_gradient, delta_sums,
            ),
            _ => {
                for (output, weight) in weight_gradient.chunks_exact_mut(padded).enumerate() {
                    sum_all_rows::<T, V>(rows, weight, |row, column, sum| {
                        let d_out = V::splat(d_out[row * outputs + output]);
                        d_out.mul_add(V::load(value, row * stride + column), sum)
                    });
                }
                for row in 0..rows {
                    for column in (0..padded).step_by(LANES) {
                        let mut sum = V::splat(T::ZERO);
                        for output in 0..outputs {
                            let d_out = V::splat(d_out[row * outputs + output]);
                            sum = d_out.mul_add(V::load(weight, output * padded + column), sum);
                        }
                        let place = row * stride + column;
                        sum.where_positive(V::load(value, place)).store(delta, place);
                    }
                }
                column_sums(rows, stride, delta, delta_sums);
            }
        }
    }
}

/// Groups of lanes whose sums over rows run side by side, so that one addition does not wait for another.
const SUMMED: usize = 4;

/// sums ← Σ over rows of term(row, place in the row), for `GROUPS` groups of lanes from `column` on.
#[inline(always)]
fn sum_rows<T: Real, V: Lanes<T>, const GROUPS: usize>(
    rows: usize,
    column: usize,
    sums: &mut [T],
    add_term: &impl Fn(usize, usize, V) -> V,
) {
    let mut totals = [V::splat(T::ZERO); GROUPS];
    for row in 0..rows {
        for (group, total) in totals.iter_mut().enumerate() {
            *total = add_term(row, column + group * LANES, *total);
        }
    }
    for (group, total) in totals.into_iter().enumerate() {
        total.store(sums, column + group * LANES);
    }
}

/// [`sum_rows`] for all columns.
#[inline(always)]
fn sum_all_rows<T: Real, V: Lanes<T>>(
    rows: usize,
    sums: &mut [T],
    add_term: impl Fn(usize, usize, V) -> V,
) {
    let mut column = 0;
    while column < sums.len() {
        if sums.len() - column >= SUMMED * LANES {
            sum_rows::<T, V, SUMMED>(rows, column, sums, &add_term);
            column += SUMMED * LANES;
        } else {
            sum_rows::<T, V, 1>(rows, column, sums, &add_term);
            column += LANES;
        }
    }
}

wide! {
    /// Sum over rows: the gradient of a bias.
    fn column_sums<T, V>(rows: usize, stride: usize, delta: &[T], sums: &mut [T]) {
        sum_all_rows::<T, V>(rows, sums, |row, column, sum| {
            sum.add(V::load(delta, row * stride + column))
        });
    }
}

/// Rows that are normalised together, so that one row's sums hide the latency of another's.
const NORMALISED: usize = 4;

/// Parameters of a layer normalisation.
#[derive(Clone, Copy)]
struct Norm<'a, T> {
    units: usize,
    stride: usize,
    gain: &'a [T],
    shift: &'a [T],
}

/// `ROWS` rows of [`normalise`]; each row's arithmetic does not depend on `ROWS`.
#[inline(always)]
fn normalise_rows<T: Real, V: Lanes<T>, const ROWS: usize>(
    norm: Norm<'_, T>,
    value: &mut [T],
    normalised: &mut [T],
    inverse_deviation: &mut [T],
) {
    let Norm {
        units,
        stride,
        gain,
        shift,
    } = norm;
    let inverse_units = T::ONE / T::from_f64(units as f64);
    let padded = gain.len();
    let whole = units - units % LANES;
    let mut sums = [V::splat(T::ZERO); ROWS];
    for column in (0..padded).step_by(LANES) {
        for (row, sum) in sums.iter_mut().enumerate() {
            *sum = sum.add(V::load(value, row * stride + column));
        }
    }
    let means = sums.map(|sum| sum.sum() * inverse_units);
    let mut squares = [V::splat(T::ZERO); ROWS];
    for column in (0..whole).step_by(LANES) {
        for (row, squares) in squares.iter_mut().enumerate() {
            let centred = V::load(value, row * stride + column).sub(V::splat(means[row]));
            *squares = centred.mul_add(centred, *squares);
        }
    }
    for row in 0..ROWS {
        let mean = means[row];
        let mut squares = squares[row].sum();
        // Padding is no unit: it must not enter the variance.
        for &value in &value[row * stride..][whole..units] {
            squares += (value - mean) * (value - mean);
        }
        let variance = squares * inverse_units;
        inverse_deviation[row] = T::ONE / (variance + T::from_f64(LAYER_NORM_EPSILON)).sqrt();
    }
    for column in (0..padded).step_by(LANES) {
        let (gain, shift) = (V::load(gain, column), V::load(shift, column));
        for row in 0..ROWS {
            let place = row * stride + column;
            let centred = V::load(value, place).sub(V::splat(means[row]));
            let result = centred.mul(V::splat(inverse_deviation[row]));
            result.store(normalised, place);
            result.mul_add(gain, shift).rectify().store(value, place);
        }
    }
    for row in 0..ROWS {
        normalised[row * stride..][units..padded].fill(T::ZERO);
    }
}

wide! {
    /// Layer normalisation and ReLU in place: value ← max(gain (value − mean) / deviation + shift, 0).
    fn normalise<T, V>(
        rows: usize,
        norm: Norm<'_, T>,
        value: &mut [T],
        normalised: &mut [T],
        inverse_deviation: &mut [T],
    ) {
        let mut row = 0;
        while row < rows {
            let value = &mut value[row * norm.stride..];
            let normalised = &mut normalised[row * norm.stride..];
            let inverse_deviation = &mut inverse_deviation[row..];
            if rows - row >= NORMALISED {
                normalise_rows::<T, V, NORMALISED>(norm, value, normalised, inverse_deviation);
                row += NORMALISED;
            } else {
                normalise_rows::<T, V, 1>(norm, value, normalised, inverse_deviation);
                row += 1;
            }
        }
    }
}

wide! {
    /// Gradient of gain and shift.
    fn normalise_weight_gradient<T, V>(
        rows: usize,
        stride: usize,
        delta: &[T],
        normalised: &[T],
        gain: &mut [T],
        shift: &mut [T],
    ) {
        for (column, (gain, shift)) in
            gain.chunks_exact_mut(LANES).zip(shift.chunks_exact_mut(LANES)).enumerate()
        {
            let (mut gain_sum, mut shift_sum) = (V::splat(T::ZERO), V::splat(T::ZERO));
            for row in 0..rows {
                let place = row * stride + column * LANES;
                let delta = V::load(delta, place);
                gain_sum = delta.mul_add(V::load(normalised, place), gain_sum);
                shift_sum = shift_sum.add(delta);
            }
            gain_sum.store(gain, 0);
            shift_sum.store(shift, 0);
        }
    }
}

/// One row of the derivative through layer normalisation, in place:
/// δ ← (g δ − mean(g δ) − x̂ mean(g δ x̂)) / deviation.
#[inline(always)]
fn normalise_row_back<T: Real, V: Lanes<T>>(
    units: usize,
    gain: &[T],
    normalised: &[T],
    inverse: T,
    delta: &mut [T],
) {
    let inverse_units = T::ONE / T::from_f64(units as f64);
    let (mut sum, mut product) = (V::splat(T::ZERO), V::splat(T::ZERO));
    for ((delta, gain), normalised) in delta
        .chunks_exact(LANES)
        .zip(gain.chunks_exact(LANES))
        .zip(normalised.chunks_exact(LANES))
    {
        let scaled = V::load(delta, 0).mul(V::load(gain, 0));
        sum = sum.add(scaled);
        product = scaled.mul_add(V::load(normalised, 0), product);
    }
    let mean = V::splat(T::ZERO - sum.sum() * inverse_units);
    let product = V::splat(T::ZERO - product.sum() * inverse_units);
    let inverse = V::splat(inverse);
    for ((delta, gain), normalised) in delta
        .chunks_exact_mut(LANES)
        .zip(gain.chunks_exact(LANES))
        .zip(normalised.chunks_exact(LANES))
    {
        let centred = V::load(delta, 0).mul_add(V::load(gain, 0), mean);
        V::load(normalised, 0)
            .mul_add(product, centred)
            .mul(inverse)
            .store(delta, 0);
    }
    // Gains of padding are zero, but the mean is not.
    delta[units..].fill(T::ZERO);
}

wide! {
    fn normalise_back<T, V>(
        rows: usize,
        units: usize,
        stride: usize,
        gain: &[T],
        normalised: &[T],
        inverse_deviation: &[T],
        delta: &mut [T],
    ) {
        let padded = gain.len();
        for ((delta, normalised), &inverse) in
            delta.chunks_mut(stride).zip(normalised.chunks(stride)).zip(inverse_deviation).take(rows)
        {
            normalise_row_back::<T, V>(units, gain, &normalised[..padded], inverse, &mut delta[..padded]);
        }
    }
}

wide! {
    fn normalise_back_selected<T, V>(
        selected: &[usize],
        units: usize,
        stride: usize,
        gain: &[T],
        normalised: &[T],
        inverse_deviation: &[T],
        delta: &mut [T],
    ) {
        let padded = gain.len();
        for (delta, &row) in delta.chunks_mut(stride).zip(selected) {
            let normalised = &normalised[row * stride..][..padded];
            normalise_row_back::<T, V>(units, gain, normalised, inverse_deviation[row], &mut delta[..padded]);
        }
    }
}

wide! {
    /// The one row of output weights, where the selected row of `value` is positive.
    fn seed_selected<T, V>(selected: &[usize], weight: &[T], stride: usize, value: &[T], delta: &mut [T]) {
        for (delta, &row) in delta.chunks_mut(stride).zip(selected) {
            let value = &value[row * stride..];
            for column in (0..weight.len()).step_by(LANES) {
                let masked = V::load(weight, column).where_positive(V::load(value, column));
                masked.store(delta, column);
            }
        }
    }
}

wide! {
    /// Zero where the selected row of `value` is not positive.
    fn mask_selected<T, V>(selected: &[usize], padded: usize, stride: usize, value: &[T], delta: &mut [T]) {
        for (delta, &row) in delta.chunks_mut(stride).zip(selected) {
            let value = &value[row * stride..];
            for column in (0..padded).step_by(LANES) {
                let masked = V::load(delta, column).where_positive(V::load(value, column));
                masked.store(delta, column);
            }
        }
    }
}

wide! {
    /// Derivative in the last inputs of the first layer, scattered to the selected rows.
    fn tail_gradient<T, V>(
        selected: &[usize],
        padded: usize,
        stride: usize,
        tail: usize,
        delta: &[T],
        weight: &[T],
        d_tail: &mut [T],
    ) {
        for (delta, &row) in delta.chunks(stride).zip(selected) {
            for (out, weight) in d_tail[row * tail..][..tail].iter_mut().zip(weight.chunks(stride)) {
                *out = dot::<T, V>(&delta[..padded], &weight[..padded]);
            }
        }
    }
}
