//! Layer normalisation and the rectifier behind it, forward and backward.

use crate::simd::{LANES, Scalar, Simd8, Vector, Vector8, vectorised};

/// Added to the variance in layer normalisation, as in PyTorch.
pub const LAYER_NORM_EPSILON: f64 = 1e-5;

/// Rows that are normalised together, so that one row's sums hide the latency of another's.
const NORMALISED: usize = 4;

/// Parameters of a layer normalisation.
#[derive(Clone, Copy)]
pub(crate) struct Norm<'a, T> {
    pub units: usize,
    pub stride: usize,
    pub gain: &'a [T],
    pub shift: &'a [T],
}

/// The first rows of a matrix as vectors of eight: in rows of one length the loops below need no checks.
#[inline(always)]
fn vectors<T, const ROWS: usize>(
    matrix: &mut [T],
    stride: usize,
    count: usize,
) -> [&mut [[T; LANES]]; ROWS] {
    let mut rows = matrix.chunks_mut(stride);
    std::array::from_fn(|_| {
        let row = rows.next().unwrap_or_default();
        &mut row.as_chunks_mut().0[..count]
    })
}

/// `ROWS` rows of [`normalise`]; each row's arithmetic does not depend on `ROWS`.
#[inline(always)]
#[allow(clippy::needless_range_loop)] // The same rows and places of several matrices.
fn normalise_rows<T: Scalar, const ROWS: usize>(
    simd: impl Simd8<T>,
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
    let (gain, _) = gain.as_chunks::<LANES>();
    let count = gain.len();
    let shift = &shift.as_chunks::<LANES>().0[..count];
    let (whole, rest) = (units / LANES, units % LANES);
    let values = vectors::<T, ROWS>(value, stride, count);
    let results = vectors::<T, ROWS>(normalised, stride, count);
    let inverse_deviation = &mut inverse_deviation[..ROWS];

    let mut sums = [simd.splat(T::ZERO); ROWS];
    for place in 0..count {
        for row in 0..ROWS {
            sums[row] = sums[row].add(simd.load(&values[row][place]));
        }
    }
    let means = sums.map(|sum| sum.sum() * inverse_units);
    let mut squares = [simd.splat(T::ZERO); ROWS];
    for place in 0..whole.min(count) {
        for row in 0..ROWS {
            let centred = simd.load(&values[row][place]).sub(simd.splat(means[row]));
            squares[row] = centred.mul_add(centred, squares[row]);
        }
    }
    for row in 0..ROWS {
        let mean = means[row];
        let mut squares = squares[row].sum();
        // Padding is no unit: it must not enter the variance.
        if rest > 0 {
            for &value in &values[row][whole][..rest] {
                squares += (value - mean) * (value - mean);
            }
        }
        let variance = squares * inverse_units;
        inverse_deviation[row] = T::ONE / (variance + T::from_f64(LAYER_NORM_EPSILON)).sqrt();
    }
    for place in 0..count {
        let (gain, shift) = (simd.load(&gain[place]), simd.load(&shift[place]));
        for row in 0..ROWS {
            let centred = simd.load(&values[row][place]).sub(simd.splat(means[row]));
            let result = centred.mul(simd.splat(inverse_deviation[row]));
            result.store(&mut results[row][place]);
            result
                .mul_add(gain, shift)
                .rectify()
                .store(&mut values[row][place]);
        }
    }
    if rest > 0 {
        for results in results {
            results[whole][rest..].fill(T::ZERO);
        }
    }
}

vectorised! {
    /// Layer normalisation and ReLU in place: value ← max(gain (value − mean) / deviation + shift, 0).
    pub(crate) fn normalise<T>(simd, rows: usize,
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
                normalise_rows::<T, NORMALISED>(simd, norm, value, normalised, inverse_deviation);
                row += NORMALISED;
            } else {
                normalise_rows::<T, 1>(simd, norm, value, normalised, inverse_deviation);
                row += 1;
            }
        }
    }
}

vectorised! {
    /// Gradient of gain and shift.
    pub(crate) fn normalise_weight_gradient<T>(simd, rows: usize,
        stride: usize,
        delta: &[T],
        normalised: &[T],
        gain: &mut [T],
        shift: &mut [T],
    ) {
        for (column, (gain, shift)) in
            gain.chunks_exact_mut(LANES).zip(shift.chunks_exact_mut(LANES)).enumerate()
        {
            let (mut gain_sum, mut shift_sum) = (simd.splat(T::ZERO), simd.splat(T::ZERO));
            for row in 0..rows {
                let place = row * stride + column * LANES;
                let place = place..place + LANES;
                let delta = simd.load(&delta[place.clone()]);
                gain_sum = delta.mul_add(simd.load(&normalised[place]), gain_sum);
                shift_sum = shift_sum.add(delta);
            }
            gain_sum.store(gain);
            shift_sum.store(shift);
        }
    }
}

/// One row of the derivative through layer normalisation, in place:
/// δ ← (g δ − mean(g δ) − x̂ mean(g δ x̂)) / deviation.
#[inline(always)]
fn normalise_row_back<T: Scalar>(
    simd: impl Simd8<T>,
    units: usize,
    gain: &[T],
    normalised: &[T],
    inverse: T,
    delta: &mut [T],
) {
    let inverse_units = T::ONE / T::from_f64(units as f64);
    let (mut sum, mut product) = (simd.splat(T::ZERO), simd.splat(T::ZERO));
    for ((delta, gain), normalised) in delta
        .chunks_exact(LANES)
        .zip(gain.chunks_exact(LANES))
        .zip(normalised.chunks_exact(LANES))
    {
        let scaled = simd.load(delta).mul(simd.load(gain));
        sum = sum.add(scaled);
        product = scaled.mul_add(simd.load(normalised), product);
    }
    let mean = simd.splat(T::ZERO - sum.sum() * inverse_units);
    let product = simd.splat(T::ZERO - product.sum() * inverse_units);
    let inverse = simd.splat(inverse);
    for ((delta, gain), normalised) in delta
        .chunks_exact_mut(LANES)
        .zip(gain.chunks_exact(LANES))
        .zip(normalised.chunks_exact(LANES))
    {
        let centred = simd.load(delta).mul_add(simd.load(gain), mean);
        simd.load(normalised)
            .mul_add(product, centred)
            .mul(inverse)
            .store(delta);
    }
    // Gains of padding are zero, but the mean is not.
    delta[units..].fill(T::ZERO);
}

vectorised! {
    pub(crate) fn normalise_back<T>(simd, rows: usize,
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
            normalise_row_back::<T>(simd, units, gain, &normalised[..padded], inverse, &mut delta[..padded]);
        }
    }
}

vectorised! {
    pub(crate) fn normalise_back_selected<T>(simd, selected: &[usize],
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
            normalise_row_back::<T>(simd, units, gain, normalised, inverse_deviation[row], &mut delta[..padded]);
        }
    }
}
