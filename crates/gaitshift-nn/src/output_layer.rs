//! The linear output layer, which has few outputs: a product of its own, forward and backward.

use crate::simd::{LANES, Scalar, Simd8, Vector, Vector8, vectorised};
use crate::sums::{column_sums, sum_all_rows};

/// Rows whose products with the same weights are summed side by side: as many sums as the multiply-add units keep in
/// flight.
const PROJECTED: usize = 8;

/// `ROWS` rows of [`project`]; each row's arithmetic does not depend on `ROWS`.
#[inline(always)]
fn project_rows<T: Scalar, const ROWS: usize>(
    simd: impl Simd8<T>,
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
        let mut sums = [simd.splat(T::ZERO); ROWS];
        for group in 0..groups {
            let weight = simd.load(&weight[group]);
            for (x, sum) in x.iter().zip(&mut sums) {
                *sum = simd.load(&x[group]).mul_add(weight, *sum);
            }
        }
        for (row, sum) in sums.into_iter().enumerate() {
            out[row * outputs + output] = bias + sum.sum();
        }
    }
}

vectorised! {
    /// out = X Wᵀ + bias, for the few rows of W that an output layer has.
    pub(crate) fn project<T>(simd, rows: usize,
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
                project_rows::<T, PROJECTED>(simd, padded, x, stride, weight, bias, out);
                row += PROJECTED;
            } else {
                project_rows::<T, 1>(simd, padded, x, stride, weight, bias, out);
                row += 1;
            }
        }
    }
}

/// Columns from `column` on, `GROUPS` groups of lanes, of [`output_back`] for `OUTPUTS` outputs.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn output_columns_back<T: Scalar, const OUTPUTS: usize, const GROUPS: usize>(
    simd: impl Simd8<T>,
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
    let weights: [[_; GROUPS]; OUTPUTS] = std::array::from_fn(|output| {
        std::array::from_fn(|group| simd.load(&weight[place(output, group)..]))
    });
    let mut gradients = [[simd.splat(T::ZERO); GROUPS]; OUTPUTS];
    let mut sums = [simd.splat(T::ZERO); GROUPS];
    // Slices of one length for each row, checked once.
    let values = value.chunks_exact(stride);
    let deltas = delta.chunks_exact_mut(stride);
    let d_outs = d_out.chunks_exact(OUTPUTS).take(rows);
    for ((d_out, value), delta) in d_outs.zip(values).zip(deltas) {
        let d_out: [_; OUTPUTS] = std::array::from_fn(|output| simd.splat(d_out[output]));
        let value = &value[column..][..GROUPS * LANES];
        let delta = &mut delta[column..][..GROUPS * LANES];
        for (group, sum) in sums.iter_mut().enumerate() {
            let value = simd.load(&value[group * LANES..]);
            let mut derivative = simd.splat(T::ZERO);
            for output in 0..OUTPUTS {
                derivative = d_out[output].mul_add(weights[output][group], derivative);
                gradients[output][group] = d_out[output].mul_add(value, gradients[output][group]);
            }
            let derivative = derivative.where_positive(value);
            derivative.store(&mut delta[group * LANES..]);
            *sum = sum.add(derivative);
        }
    }
    for (output, gradients) in gradients.into_iter().enumerate() {
        for (group, gradient) in gradients.into_iter().enumerate() {
            gradient.store(&mut weight_gradient[place(output, group)..]);
        }
    }
    for (group, sum) in sums.into_iter().enumerate() {
        sum.store(&mut delta_sums[column + group * LANES..]);
    }
}

/// [`output_back`] for `OUTPUTS` outputs, as many groups of lanes at a time as the registers hold.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn outputs_back<T: Scalar, const OUTPUTS: usize, const GROUPS: usize>(
    simd: impl Simd8<T>,
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
        output_columns_back::<T, OUTPUTS, GROUPS>(
            simd,
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
        output_columns_back::<T, OUTPUTS, 1>(
            simd,
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

vectorised! {
    /// One pass back through the output layer: the derivative in the last hidden layer before its ReLU, given the
    /// layer's values after it; that derivative's sum over rows; the gradients of the output layer's weights and biases.
    pub(crate) fn output_back<T>(simd, rows: usize,
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
        // The numbers of outputs that a critic and an actor of two actions have.
        match outputs {
            1 => outputs_back::<T, 1, 2>(simd, rows, padded, stride, d_out, weight, value, delta, weight_gradient, delta_sums,
            ),
            4 => outputs_back::<T, 4, 1>(simd, rows, padded, stride, d_out, weight, value, delta, weight_gradient, delta_sums,
            ),
            _ => {
                for (output, weight) in weight_gradient.chunks_exact_mut(padded).enumerate() {
                    sum_all_rows(simd, rows, weight, |row, column, sum| {
                        let d_out = simd.splat(d_out[row * outputs + output]);
                        d_out.mul_add(simd.load(&value[row * stride + column..]), sum)
                    });
                }
                for row in 0..rows {
                    for column in (0..padded).step_by(LANES) {
                        let mut sum = simd.splat(T::ZERO);
                        for output in 0..outputs {
                            let d_out = simd.splat(d_out[row * outputs + output]);
                            sum = d_out.mul_add(simd.load(&weight[output * padded + column..]), sum);
                        }
                        let place = row * stride + column;
                        sum.where_positive(simd.load(&value[place..])).store(&mut delta[place..]);
                    }
                }
                column_sums(rows, stride, delta, delta_sums);
            }
        }
    }
}
