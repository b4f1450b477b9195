//! The matrix products of an update, one chunk of rows at a time, and the element-wise passes behind them.
//!
//! `cargo bench -p gaitshift-sac --bench kernels`; the column of items per second counts multiplications and
//! additions, so 50 Gitem/s are 50 GFLOP/s. What the machine could do at most: `benchmarks/compare.py`.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use gaitshift_sac::dense::{self, Epilogue, MatMul, Outer, padded, row_stride};
use gaitshift_sac::{Buffer, CHUNK};

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

fn forward(bencher: Bencher<'_, '_>, inputs: usize, x_stride: usize, units: usize) {
    let (x, weight, bias) = (
        numbers(CHUNK * x_stride),
        numbers(inputs * padded(units)),
        numbers(padded(units)),
    );
    let stride = row_stride(units);
    let mut y = numbers(CHUNK * stride);
    bencher
        .counter(ItemsCount::new(2 * CHUNK * inputs * units))
        .bench_local(|| {
            dense::matmul(MatMul {
                rows: CHUNK,
                k: inputs,
                x: black_box(&x),
                x_stride,
                panels: black_box(&weight),
                columns: padded(units),
                y: &mut y,
                y_stride: stride,
                epilogue: Epilogue::BiasRelu(&bias),
            });
        });
}

fn weight_gradient(bencher: Bencher<'_, '_>, inputs: usize, x_stride: usize, units: usize) {
    let stride = row_stride(units);
    let (x, delta) = (numbers(CHUNK * x_stride), numbers(CHUNK * stride));
    let mut gradient = numbers(inputs * padded(units));
    bencher
        .counter(ItemsCount::new(2 * CHUNK * inputs * units))
        .bench_local(|| {
            dense::outer(Outer {
                rows: CHUNK,
                k: inputs,
                x: black_box(&x),
                x_stride,
                columns: padded(units),
                y: black_box(&delta),
                y_stride: stride,
                panels: &mut gradient,
            });
        });
}

/// First hidden layer.
#[divan::bench(args = UNITS)]
fn first_layer(bencher: Bencher<'_, '_>, units: usize) {
    forward(bencher, INPUTS, INPUTS, units);
}

/// Second hidden layer.
#[divan::bench(args = UNITS)]
fn second_layer(bencher: Bencher<'_, '_>, units: usize) {
    forward(bencher, units, row_stride(units), units);
}

/// Gradient of the first hidden layer's weights.
#[divan::bench(args = UNITS)]
fn first_weight_gradient(bencher: Bencher<'_, '_>, units: usize) {
    weight_gradient(bencher, INPUTS, INPUTS, units);
}

/// Gradient of the second hidden layer's weights.
#[divan::bench(args = UNITS)]
fn second_weight_gradient(bencher: Bencher<'_, '_>, units: usize) {
    weight_gradient(bencher, units, row_stride(units), units);
}
