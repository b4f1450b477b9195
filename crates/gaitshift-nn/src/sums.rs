//! Sums over the rows of a matrix.

use crate::simd::{LANES, Scalar, Simd8, Vector, Vector8, vectorised};

/// Groups of lanes whose sums over rows run side by side, so that one addition does not wait for another.
const SUMMED: usize = 4;

/// sums ← Σ over rows of term(row, place in the row), for `GROUPS` groups of lanes from `column` on.
#[inline(always)]
fn sum_rows<T: Scalar, S: Simd8<T>, const GROUPS: usize>(
    simd: S,
    rows: usize,
    column: usize,
    sums: &mut [T],
    add_term: &impl Fn(usize, usize, S::Vector) -> S::Vector,
) {
    let mut totals = [simd.splat(T::ZERO); GROUPS];
    for row in 0..rows {
        for (group, total) in totals.iter_mut().enumerate() {
            *total = add_term(row, column + group * LANES, *total);
        }
    }
    for (group, total) in totals.into_iter().enumerate() {
        total.store(&mut sums[column + group * LANES..]);
    }
}

/// [`sum_rows`] for all columns.
#[inline(always)]
pub(crate) fn sum_all_rows<T: Scalar, S: Simd8<T>>(
    simd: S,
    rows: usize,
    sums: &mut [T],
    add_term: impl Fn(usize, usize, S::Vector) -> S::Vector,
) {
    let mut column = 0;
    while column < sums.len() {
        if sums.len() - column >= SUMMED * LANES {
            sum_rows::<T, S, SUMMED>(simd, rows, column, sums, &add_term);
            column += SUMMED * LANES;
        } else {
            sum_rows::<T, S, 1>(simd, rows, column, sums, &add_term);
            column += LANES;
        }
    }
}

vectorised! {
    /// Sum over rows: the gradient of a bias.
    pub(crate) fn column_sums<T>(simd, rows: usize, stride: usize, delta: &[T], sums: &mut [T]) {
        sum_all_rows(simd, rows, sums, |row, column, sum| {
            sum.add(simd.load(&delta[row * stride + column..]))
        });
    }
}
