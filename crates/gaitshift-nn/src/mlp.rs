//! Multi-layer perceptrons: hidden layers `[linear, layer norm?, ReLU]`, then a linear output.
//!
//! All parameters of a network are one flat buffer; hidden weights lie in the order inputs × units (see
//! [`crate::product`]), the output layer's in the order outputs × units. [`Mlp::tensors`] and [`Mlp::load_tensors`] translate
//! from and to the layout and names of PyTorch (`weight` is outputs × inputs).

use rand::Rng;

use crate::buffer::Buffer;
use crate::layout::{Layout, MlpShape, NamedTensor, Place};
use crate::simd::Scalar;

/// A multi-layer perceptron.
#[derive(Clone, Debug)]
pub struct Mlp<T> {
    pub(crate) shape: MlpShape,
    pub(crate) layout: Layout,
    /// All parameters; padding is zero and stays zero.
    pub parameters: Buffer<T>,
}

impl<T: Scalar> Mlp<T> {
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
    pub fn random(shape: MlpShape, rng: &mut impl Rng) -> Self {
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
    pub(crate) fn places(&self) -> Vec<Place> {
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
}

/// Uniform in `low..high`, with 53 bits.
fn uniform(rng: &mut impl Rng, low: f64, high: f64) -> f64 {
    let unit = (rng.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64);
    low + (high - low) * unit
}
