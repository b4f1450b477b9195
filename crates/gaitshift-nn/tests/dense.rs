//! The dense product against the definition, element by element in f64.
//!
//! - Any numbers of rows, shared index and columns, with gaps between rows, every epilogue, A read by rows or by columns.
//! - Right to the rounding of f32 (2e-6 of the sum of absolute products). That every level of instructions is, is shown in
//!   `simd.rs`.
//! - A row's result has the same bits whatever rows are computed with it; gaps between rows are left alone.
//! - NaN comes through the rectifier and is not hidden.

use crate::products::{Kind, Problem, any_kind};
use gaitshift_nn::dense::multiply;
use gaitshift_nn::product::{Epilogue, Left, Product, padded, row_stride};
use proptest::prelude::*;

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
        problem.check(kind, &problem.run(kind, multiply::<f32>))?;
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
    let mut problem = Problem::new(7, 3, 8, 0, false);
    problem.a[problem.a_stride] = f32::NAN;
    let found = problem.run(Kind::BiasRelu, multiply::<f32>);
    for (element, value) in found.iter().enumerate() {
        assert_eq!(value.is_nan(), element / 8 == 1);
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

/// The check of a product's sizes was made in wrapping arithmetic: with a huge distance between rows it passed, and a safe
/// call read outside its slices. Every such product is refused now.
#[test]
fn sizes_that_overflow_are_refused() {
    let huge = usize::MAX / 3 + 1;
    let (a, b, mask) = ([1.0f32; 64], [1.0; 64], [1.0; 64]);
    let small = Product {
        rows: 4,
        shared: 4,
        columns: 8,
        a: Left::Rows(&a, 8),
        b: &b,
        b_stride: 8,
        c: &mut [0.0; 64],
        c_stride: 8,
        epilogue: Epilogue::None,
    };
    // 3 · huge wraps to 2: the last element seems to lie inside.
    let mut out = [[0.0; 64]; 5];
    let [c_1, c_2, c_3, c_4, c_5] = &mut out;
    let wrong = [
        Product {
            a: Left::Rows(&a, huge),
            c: c_1,
            epilogue: Epilogue::None,
            ..small
        },
        Product {
            a: Left::Transposed(&a, huge),
            c: c_2,
            epilogue: Epilogue::None,
            ..small
        },
        Product {
            b_stride: huge,
            c: c_3,
            epilogue: Epilogue::None,
            ..small
        },
        Product {
            c_stride: huge,
            c: c_4,
            epilogue: Epilogue::None,
            ..small
        },
        Product {
            epilogue: Epilogue::Mask(&mask, huge),
            c: c_5,
            ..small
        },
    ];
    for product in wrong {
        let text = format!("{product:?}");
        let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| multiply(product)));
        let message = outcome.expect_err(&text);
        let message = message.downcast_ref::<&str>().copied().unwrap_or_default();
        assert!(message.contains("outside"), "{message}");
    }
}
