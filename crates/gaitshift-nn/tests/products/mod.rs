//! Matrix products with their definition, for the tests of the kernels.

#![allow(dead_code, reason = "each test uses a part")]

use gaitshift_nn::Pattern;
use gaitshift_nn::product::{Epilogue, Left, Product};
use proptest::prelude::*;

/// Plausible numbers that are not all alike.
fn numbers(count: usize, seed: usize) -> Vec<f32> {
    (0..count)
        .map(|index| ((index * 7919 + seed * 104_729) % 2003) as f32 / 1001.0 - 1.0)
        .collect()
}

/// What is at the end of a sum.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    None,
    Bias,
    BiasRelu,
    Mask,
}

pub fn any_kind() -> impl Strategy<Value = Kind> {
    prop_oneof![
        Just(Kind::None),
        Just(Kind::Bias),
        Just(Kind::BiasRelu),
        Just(Kind::Mask)
    ]
}

/// A (rows × shared) B (shared × columns), with gaps between the rows of both and of the result.
#[derive(Clone, Debug)]
pub struct Problem {
    pub rows: usize,
    pub shared: usize,
    pub columns: usize,
    /// A is stored transposed.
    pub transposed: bool,
    pub a: Vec<f32>,
    pub a_stride: usize,
    pub b: Vec<f32>,
    pub b_stride: usize,
    pub extra: Vec<f32>,
}

impl Problem {
    pub fn new(rows: usize, shared: usize, columns: usize, gap: usize, transposed: bool) -> Self {
        let (down, across) = if transposed {
            (shared, rows)
        } else {
            (rows, shared)
        };
        // Whole vectors, as rows of activations are.
        let a_stride = (across + gap).next_multiple_of(8);
        let b_stride = columns + gap;
        let mut a = numbers(down * a_stride, 1);
        for row in a.chunks_mut(a_stride.max(1)) {
            row[across..].fill(0.0);
        }
        Self {
            rows,
            shared,
            columns,
            transposed,
            a,
            a_stride,
            b: numbers(shared * b_stride, 2),
            b_stride,
            extra: numbers(rows.max(1) * columns, 3),
        }
    }

    /// The result, without its gaps, which must still be as they were.
    pub fn run(&self, kind: Kind, kernel: impl FnOnce(Product<'_, f32>)) -> Vec<f32> {
        let c_stride = self.columns + 3;
        let mut c = vec![f32::NAN; self.rows * c_stride];
        kernel(Product {
            rows: self.rows,
            shared: self.shared,
            columns: self.columns,
            a: if self.transposed {
                Left::Transposed(&self.a, self.a_stride)
            } else {
                Left::Rows(&self.a, self.a_stride)
            },
            b: &self.b,
            b_stride: self.b_stride,
            c: &mut c,
            c_stride,
            epilogue: match kind {
                Kind::None => Epilogue::None,
                Kind::Bias => Epilogue::Bias(&self.extra),
                Kind::BiasRelu => Epilogue::BiasRelu(&self.extra),
                Kind::Mask => Epilogue::Mask(&self.extra, self.columns),
            },
        });
        c.chunks(c_stride)
            .flat_map(|row| {
                assert!(row[self.columns..].iter().all(|gap| gap.is_nan()));
                row[..self.columns].to_vec()
            })
            .collect()
    }

    fn a(&self, row: usize, index: usize) -> f32 {
        if self.transposed {
            self.a[index * self.a_stride + row]
        } else {
            self.a[row * self.a_stride + index]
        }
    }

    /// Result and the sum of absolute products that its rounding scales with.
    fn expected(&self, kind: Kind, row: usize, column: usize) -> (f64, f64) {
        let products = (0..self.shared).map(|index| {
            f64::from(self.a(row, index)) * f64::from(self.b[index * self.b_stride + column])
        });
        let (sum, size) = products.fold((0.0, 0.0), |(sum, size), product: f64| {
            (sum + product, size + product.abs())
        });
        let bias = f64::from(self.extra[column]);
        let mask = f64::from(self.extra[row * self.columns + column]);
        let value = match kind {
            Kind::None => sum,
            Kind::Bias => sum + bias,
            Kind::BiasRelu => (sum + bias).max(0.0),
            Kind::Mask if mask > 0.0 => sum,
            Kind::Mask => 0.0,
        };
        (value, size + bias.abs())
    }

    pub fn check(&self, kind: Kind, found: &[f32]) -> Result<(), TestCaseError> {
        prop_assert_eq!(found.len(), self.rows * self.columns);
        for row in 0..self.rows {
            for column in 0..self.columns {
                let (expected, size) = self.expected(kind, row, column);
                let found = f64::from(found[row * self.columns + column]);
                prop_assert!(
                    (found - expected).abs() <= 2e-6 * size.max(1e-3),
                    "{found} {expected}"
                );
            }
        }
        Ok(())
    }

    /// Leaves a share of about `kept` of A's elements and makes the others zero.
    pub fn thin_out(&mut self, kept: f64) {
        let mut state = 1u32;
        for value in &mut self.a {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            if f64::from(state >> 8) >= kept * f64::from(1 << 24) {
                *value = 0.0;
            }
        }
    }

    /// The pattern of A as the product reads it.
    pub fn pattern(&self) -> Pattern {
        let (down, across) = if self.transposed {
            (self.shared, self.rows)
        } else {
            (self.rows, self.shared)
        };
        let mut stored = Pattern::new(down, across);
        stored.read(down, across, &self.a, self.a_stride);
        if !self.transposed {
            return stored;
        }
        let mut turned = Pattern::new(down, across);
        turned.transpose(&stored);
        turned
    }
}
