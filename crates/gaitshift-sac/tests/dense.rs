//! The dense product against the definition, element by element in f64.
//!
//! - Any numbers of rows, shared index and columns, with gaps between rows, every epilogue, A read by rows or by columns.
//! - The processor's own kernel and the portable one agree to the rounding of f32 (2e-6 of the sum of
//!   absolute products).
//! - A row's result has the same bits whatever rows are computed with it; gaps between rows are left alone.
//! - NaN comes through the rectifier and is not hidden.

mod products;

use gaitshift_sac::dense::{Product, multiply, multiply_portable, padded, row_stride};
use products::{Kind, Problem, any_kind};
use proptest::prelude::*;

const KERNELS: [fn(Product<'_, f32>); 2] = [multiply::<f32>, multiply_portable::<f32>];

proptest! {
    #[test]
    fn product_follows_its_definition(
        rows in 0usize..60,
        shared in 1usize..70,
        eighths in 1usize..9,
        gap in 0usize..4,
        transposed: bool,
        kind in any_kind(),
    ) {
        let problem = Problem::new(rows, shared, 8 * eighths, gap, transposed);
        for kernel in KERNELS {
            let found = problem.run(kind, kernel);
            problem.check(kind, &found)?;
        }
    }
}

#[test]
fn a_row_does_not_depend_on_its_company() {
    let all = Problem::new(64, 37, 40, 0, false);
    let together = all.run(Kind::BiasRelu, multiply::<f32>);
    for row in 0..all.rows {
        let alone = Problem {
            rows: 1,
            a: all.a[row * all.a_stride..][..all.a_stride].to_vec(),
            ..all.clone()
        };
        assert_eq!(
            alone.run(Kind::BiasRelu, multiply::<f32>),
            together[row * 40..(row + 1) * 40]
        );
    }
}

#[test]
fn nan_is_not_hidden() {
    for kernel in KERNELS {
        let mut problem = Problem::new(7, 3, 8, 0, false);
        problem.a[problem.a_stride] = f32::NAN;
        let found = problem.run(Kind::BiasRelu, kernel);
        for (element, value) in found.iter().enumerate() {
            assert_eq!(value.is_nan(), element / 8 == 1);
        }
    }
}

/// Rows are an odd number of cache lines apart, so that a walk down a column does not fall into few sets of the cache.
#[test]
fn rows_are_an_odd_number_of_lines_apart() {
    for columns in 1..600 {
        let stride = row_stride(columns);
        assert!(stride >= padded(columns) && padded(columns) >= columns);
        assert_eq!(stride % 32, 16);
    }
}
