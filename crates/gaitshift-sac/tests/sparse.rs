//! Products that leave out zeros give what the dense ones give, to the bit.
//!
//! - Any numbers of rows, shared index and columns, any share of zeros from none to all, every epilogue, A read by rows or
//!   by columns.
//! - NaN is no zero.
//! - A pattern of another matrix is refused.

mod products;

use gaitshift_sac::Pattern;
use gaitshift_sac::dense::{multiply, multiply_portable};
use gaitshift_sac::sparse;
use products::{Kind, Problem, any_kind};
use proptest::prelude::*;

/// Leaves a share of about `kept` of A's elements and makes the others zero.
fn thin_out(problem: &mut Problem, kept: f64) {
    let mut state = 1u32;
    for value in &mut problem.a {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        if f64::from(state >> 8) >= kept * f64::from(1 << 24) {
            *value = 0.0;
        }
    }
}

/// The pattern of A as the product reads it.
fn pattern(problem: &Problem) -> Pattern {
    let (down, across) = if problem.transposed {
        (problem.shared, problem.rows)
    } else {
        (problem.rows, problem.shared)
    };
    let mut stored = Pattern::new(down, across);
    stored.read(down, across, &problem.a, problem.a_stride);
    if !problem.transposed {
        return stored;
    }
    let mut turned = Pattern::new(down, across);
    turned.transpose(&stored);
    turned
}

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
        thin_out(&mut problem, kept);
        let found = problem.run(kind, |product| sparse::multiply(product, &pattern(&problem)));
        prop_assert_eq!(&found, &problem.run(kind, multiply::<f32>));
        problem.check(kind, &found)?;
        problem.check(kind, &problem.run(kind, multiply_portable::<f32>))?;
    }
}

#[test]
fn nan_is_not_hidden() {
    let mut problem = Problem::new(7, 30, 8, 0, false);
    problem.a.fill(0.0);
    problem.a[problem.a_stride + 4] = f32::NAN;
    let found = problem.run(Kind::BiasRelu, |product| {
        sparse::multiply(product, &pattern(&problem));
    });
    for (element, value) in found.iter().enumerate() {
        assert_eq!(value.is_nan(), element / 8 == 1);
    }
}

#[test]
#[should_panic(expected = "pattern")]
fn a_pattern_of_another_size_is_refused() {
    let problem = Problem::new(7, 30, 8, 0, false);
    let other = pattern(&Problem::new(7, 31, 8, 0, false));
    problem.run(Kind::None, |product| sparse::multiply(product, &other));
}
