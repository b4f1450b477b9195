//! Products that leave out zeros give what the dense ones give, to the bit.
//!
//! - Any numbers of rows, shared index and columns, any share of zeros from none to all, every epilogue, A read by rows or
//!   by columns.
//! - NaN is no zero.
//! - A pattern of another matrix is refused, and so is one whose last reading failed.

use crate::products::{Kind, Problem, any_kind};
use gaitshift_nn::dense::multiply;
use gaitshift_nn::product::{Epilogue, Left, Product};
use gaitshift_nn::{Pattern, sparse};
use proptest::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};

proptest! {
    #[test]
    fn same_bits_as_the_dense_product(
        rows in 1usize..140,
        shared in 1usize..140,
        eighths in 1usize..30,
        gap in 0usize..4,
        transposed: bool,
        kept in prop_oneof![Just(0.0), 0.0..1.0, Just(1.0)],
        kind in any_kind(),
    ) {
        let mut problem = Problem::new(rows, shared, 8 * eighths, gap, transposed);
        problem.thin_out(kept);
        let found = problem.run(kind, |product| sparse::multiply(product, &problem.pattern()));
        prop_assert_eq!(&found, &problem.run(kind, multiply::<f32>));
        problem.check(kind, &found)?;
    }
}

#[test]
fn a_product_without_rows_or_columns_writes_nothing() {
    for (rows, shared, columns) in [(0, 3, 8), (3, 5, 0), (0, 5, 0)] {
        let a = vec![1.0_f32; rows * 8];
        let mut pattern = Pattern::new(rows, shared);
        pattern.read(rows, shared, &a, 8);
        let product = Product {
            rows,
            shared,
            columns,
            a: Left::Rows(&a, 8),
            b: &vec![1.0; shared * columns],
            b_stride: columns,
            c: &mut [],
            c_stride: columns,
            epilogue: Epilogue::None,
        };
        sparse::multiply(product, &pattern);
    }
}

#[test]
fn nan_is_not_hidden() {
    let mut problem = Problem::new(7, 30, 8, 0, false);
    problem.a.fill(0.0);
    problem.a[problem.a_stride + 4] = f32::NAN;
    let found = problem.run(Kind::BiasRelu, |product| {
        sparse::multiply(product, &problem.pattern());
    });
    for (element, value) in found.iter().enumerate() {
        assert_eq!(value.is_nan(), element / 8 == 1);
    }
}

#[test]
#[should_panic(expected = "pattern")]
fn a_pattern_of_another_size_is_refused() {
    let problem = Problem::new(7, 30, 8, 0, false);
    let other = Problem::new(7, 31, 8, 0, false).pattern();
    problem.run(Kind::None, |product| sparse::multiply(product, &other));
}

/// The marks of an earlier matrix once stood under the size of the matrix that could not be read, so that a product read
/// outside its slices.
#[test]
fn a_pattern_whose_reading_failed_is_that_of_no_matrix() {
    let mut pattern = Pattern::new(1, 64);
    let mut last = [0.0_f32; 64];
    last[63] = 1.0;
    pattern.read(1, 64, &last, 64);
    let failed = catch_unwind(AssertUnwindSafe(|| pattern.read::<f32>(1, 10, &[], 16)));
    assert!(failed.is_err());
    let small = Problem::new(1, 10, 8, 0, false);
    let refused = catch_unwind(AssertUnwindSafe(|| {
        small.run(Kind::None, |product| sparse::multiply(product, &pattern))
    }));
    assert!(refused.is_err());
}
