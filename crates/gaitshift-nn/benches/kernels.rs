//! The matrix products of an update, one chunk of rows at a time, and the element-wise passes behind them.
//!
//! `cargo bench -p gaitshift-nn --bench kernels`; the column of items per second counts multiplications and
//! additions, so 50 Gitem/s are 50 GFLOP/s. What the machine could do at most: `benchmarks/compare.py`.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use gaitshift_nn::product::{Epilogue, Left, Product, padded, row_stride};
use gaitshift_nn::{Buffer, Pattern, dense, sparse};

/// Rows that a learner works on together.
const CHUNK: usize = 64;
const UNITS: [usize; 4] = [64, 100, 128, 256];
/// Observation and action of the biped side by side.
const INPUTS: usize = 16;

fn main() {
    divan::main();
}

/// Plausible numbers without structure.
fn numbers(count: usize) -> Buffer<f32> {
    let mut buffer = Buffer::zeros(count);
    for (index, value) in buffer.iter_mut().enumerate() {
        *value = ((index * 37 % 101) as f32 - 50.0) / 50.0;
    }
    buffer
}

/// The same with so many of a hundred left as they are and the others zero.
fn thinned(count: usize, kept: usize) -> Buffer<f32> {
    let mut buffer = numbers(count);
    for (index, value) in buffer.iter_mut().enumerate() {
        if index * 7919 % 1009 * 100 >= kept * 1009 {
            *value = 0.0;
        }
    }
    buffer
}

/// Items are multiplications and additions, those with zeros included.
fn operations(rows: usize, shared: usize, columns: usize) -> ItemsCount {
    ItemsCount::new(2 * rows * shared * columns)
}

/// One chunk forward through a layer; without its zeros where `kept` of a hundred inputs are not.
fn forward(
    bencher: Bencher<'_, '_>,
    inputs: usize,
    x_stride: usize,
    units: usize,
    kept: Option<usize>,
) {
    let x = thinned(CHUNK * x_stride, kept.unwrap_or(100));
    let weight = numbers(inputs * row_stride(units));
    let bias = numbers(padded(units));
    let stride = row_stride(units);
    let mut y = numbers(CHUNK * stride);
    let mut pattern = Pattern::new(CHUNK, inputs);
    bencher
        .counter(operations(CHUNK, inputs, units))
        .bench_local(|| {
            let product = Product {
                rows: CHUNK,
                shared: inputs,
                columns: padded(units),
                a: Left::Rows(black_box(&x), x_stride),
                b: black_box(&weight),
                b_stride: row_stride(units),
                c: &mut y,
                c_stride: stride,
                epilogue: Epilogue::BiasRelu(&bias),
            };
            if kept.is_some() {
                pattern.read(CHUNK, inputs, black_box(&x), x_stride);
                sparse::multiply(product, &pattern);
            } else {
                dense::multiply(product);
            }
        });
}

/// The gradient of a layer's weights; without its zeros where `kept` of a hundred inputs are not.
fn weight_gradient(
    bencher: Bencher<'_, '_>,
    inputs: usize,
    x_stride: usize,
    units: usize,
    kept: Option<usize>,
) {
    let stride = row_stride(units);
    let (x, delta) = (
        thinned(CHUNK * x_stride, kept.unwrap_or(100)),
        numbers(CHUNK * stride),
    );
    let mut gradient = numbers(inputs * row_stride(units));
    let (mut stored, mut turned) = (Pattern::new(CHUNK, inputs), Pattern::new(CHUNK, inputs));
    stored.read(CHUNK, inputs, &x, x_stride);
    bencher
        .counter(operations(CHUNK, inputs, units))
        .bench_local(|| {
            let product = Product {
                rows: inputs,
                shared: CHUNK,
                columns: padded(units),
                a: Left::Transposed(black_box(&x), x_stride),
                b: black_box(&delta),
                b_stride: stride,
                c: &mut gradient,
                c_stride: row_stride(units),
                epilogue: Epilogue::None,
            };
            if kept.is_some() {
                turned.transpose(black_box(&stored));
                sparse::multiply(product, &turned);
            } else {
                dense::multiply(product);
            }
        });
}

/// First hidden layer.
#[divan::bench(args = UNITS)]
fn first_layer(bencher: Bencher<'_, '_>, units: usize) {
    forward(bencher, INPUTS, INPUTS, units, None);
}

/// Second hidden layer, every input counted.
#[divan::bench(args = UNITS)]
fn second_layer(bencher: Bencher<'_, '_>, units: usize) {
    forward(bencher, units, row_stride(units), units, None);
}

/// Second hidden layer, half of its inputs zero.
#[divan::bench(args = UNITS)]
fn second_layer_half_zero(bencher: Bencher<'_, '_>, units: usize) {
    forward(bencher, units, row_stride(units), units, Some(50));
}

/// Second hidden layer of 128 units, by the share of its inputs that are not zero, in percent.
#[divan::bench(args = [20, 30, 40, 50, 60, 70, 75, 80, 90])]
fn second_layer_by_share(bencher: Bencher<'_, '_>, kept: usize) {
    forward(bencher, 128, row_stride(128), 128, Some(kept));
}

/// Gradient of the first hidden layer's weights.
#[divan::bench(args = UNITS)]
fn first_weight_gradient(bencher: Bencher<'_, '_>, units: usize) {
    weight_gradient(bencher, INPUTS, INPUTS, units, None);
}

/// Gradient of the second hidden layer's weights, every input counted.
#[divan::bench(args = UNITS)]
fn second_weight_gradient(bencher: Bencher<'_, '_>, units: usize) {
    weight_gradient(bencher, units, row_stride(units), units, None);
}

/// Gradient of the second hidden layer's weights, half of its inputs zero.
#[divan::bench(args = UNITS)]
fn second_weight_gradient_half_zero(bencher: Bencher<'_, '_>, units: usize) {
    weight_gradient(bencher, units, row_stride(units), units, Some(50));
}
