//! Sizes of a network, its tensors by name, and where each lies in the flat buffer of parameters.

use std::ops::Range;

use crate::buffer::LINE;
use crate::product::{padded, row_stride};

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

/// Where a hidden layer lies in the flat parameters.
#[derive(Clone, Debug)]
pub(crate) struct Hidden {
    pub inputs: usize,
    pub units: usize,
    /// Columns as stored.
    pub padded: usize,
    /// Distance between rows of its activations, and between the weights of one input and the next.
    pub stride: usize,
    pub weight: usize,
    pub bias: usize,
    pub gain: usize,
    pub shift: usize,
}

impl Hidden {
    pub fn weight_range(&self) -> Range<usize> {
        self.weight..self.weight + self.inputs * self.stride
    }
}

/// Where a tensor lies in the flat parameters.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    pub start: usize,
    pub extents: [usize; 2],
    pub strides: [usize; 2],
}

impl Place {
    /// Where one of them lies.
    pub fn index(&self, row: usize, column: usize) -> usize {
        self.start + row * self.strides[0] + column * self.strides[1]
    }

    /// Where its elements lie, last index fastest.
    pub fn indices(&self) -> impl Iterator<Item = usize> + use<> {
        let (place, [rows, columns]) = (*self, self.extents);
        (0..rows).flat_map(move |row| (0..columns).map(move |column| place.index(row, column)))
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Layout {
    pub hidden: Vec<Hidden>,
    /// Output weights, one row of `last.padded` numbers per output.
    pub weight: usize,
    pub bias: usize,
    pub len: usize,
}

impl Layout {
    pub fn new(shape: &MlpShape) -> Self {
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
