//! The matrix kernels against the definition, element by element in f64.
//!
//! - Any numbers of rows, inner index and columns, with padding between rows, every epilogue.
//! - The processor's own kernel and the portable one agree to the rounding of f32 (2e-6 of the sum of
//!   absolute products).
//! - A row's result has the same bits whatever rows are computed with it.
//! - NaN comes through the rectifier and is not hidden.

use gaitshift_sac::dense::{
    Epilogue, MatMul, Outer, matmul, matmul_portable, outer, outer_portable, padded, panel_index,
    row_stride,
};
use proptest::prelude::*;

/// Plausible numbers that are not all alike.
fn numbers(count: usize, seed: usize) -> Vec<f32> {
    (0..count)
        .map(|index| ((index * 7919 + seed * 104_729) % 2003) as f32 / 1001.0 - 1.0)
        .collect()
}

fn panelled(k: usize, columns: usize, matrix: &[f32]) -> Vec<f32> {
    let mut panels = vec![0.0; k * columns];
    for row in 0..k {
        for column in 0..columns {
            panels[panel_index(k, row, column)] = matrix[row * columns + column];
        }
    }
    panels
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    None,
    Bias,
    BiasRelu,
    Mask,
}

struct Problem {
    rows: usize,
    k: usize,
    columns: usize,
    x: Vec<f32>,
    x_stride: usize,
    matrix: Vec<f32>,
    extra: Vec<f32>,
}

impl Problem {
    fn new(rows: usize, k: usize, columns: usize, gap: usize) -> Self {
        let x_stride = k + gap;
        Self {
            rows,
            k,
            columns,
            x: numbers(rows * x_stride, 1),
            x_stride,
            matrix: numbers(k * columns, 2),
            extra: numbers(rows.max(1) * columns, 3),
        }
    }

    fn run(&self, kind: Kind, kernel: fn(MatMul<'_, f32>)) -> Vec<f32> {
        let y_stride = self.columns + 3;
        let mut y = vec![f32::NAN; self.rows * y_stride];
        let panels = panelled(self.k, self.columns, &self.matrix);
        kernel(MatMul {
            rows: self.rows,
            k: self.k,
            x: &self.x,
            x_stride: self.x_stride,
            panels: &panels,
            columns: self.columns,
            y: &mut y,
            y_stride,
            epilogue: match kind {
                Kind::None => Epilogue::None,
                Kind::Bias => Epilogue::Bias(&self.extra),
                Kind::BiasRelu => Epilogue::BiasRelu(&self.extra),
                Kind::Mask => Epilogue::Mask(&self.extra, self.columns),
            },
        });
        y.chunks(y_stride)
            .flat_map(|row| row[..self.columns].to_vec())
            .collect()
    }

    /// Result and the sum of absolute products that its rounding scales with.
    fn expected(&self, kind: Kind, row: usize, column: usize) -> (f64, f64) {
        let products = (0..self.k).map(|index| {
            f64::from(self.x[row * self.x_stride + index])
                * f64::from(self.matrix[index * self.columns + column])
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
            Kind::Mask => {
                if mask > 0.0 {
                    sum
                } else {
                    0.0
                }
            }
        };
        (value, size + bias.abs())
    }
}

proptest! {
    #[test]
    fn product_follows_its_definition(
        rows in 0usize..20,
        k in 1usize..40,
        eighths in 1usize..9,
        gap in 0usize..4,
        kind in prop_oneof![Just(Kind::None), Just(Kind::Bias), Just(Kind::BiasRelu), Just(Kind::Mask)],
    ) {
        let problem = Problem::new(rows, k, 8 * eighths, gap);
        for kernel in [matmul::<f32> as fn(MatMul<'_, f32>), matmul_portable::<f32>] {
            let found = problem.run(kind, kernel);
            for row in 0..rows {
                for column in 0..problem.columns {
                    let (expected, size) = problem.expected(kind, row, column);
                    let found = f64::from(found[row * problem.columns + column]);
                    prop_assert!((found - expected).abs() <= 2e-6 * size.max(1e-3), "{found} {expected}");
                }
            }
        }
    }

    #[test]
    fn outer_product_follows_its_definition(
        rows in 0usize..70,
        k in 1usize..20,
        eighths in 1usize..9,
        gap in 0usize..4,
    ) {
        let columns = 8 * eighths;
        let (x_stride, y_stride) = (k + gap, columns + gap);
        let (x, y) = (numbers(rows * x_stride, 4), numbers(rows * y_stride, 5));
        for kernel in [outer::<f32> as fn(Outer<'_, f32>), outer_portable::<f32>] {
            let mut panels = vec![f32::NAN; k * columns];
            kernel(Outer { rows, k, x: &x, x_stride, columns, y: &y, y_stride, panels: &mut panels });
            for index in 0..k {
                for column in 0..columns {
                    let products = (0..rows)
                        .map(|row| f64::from(x[row * x_stride + index]) * f64::from(y[row * y_stride + column]));
                    let (sum, size) =
                        products.fold((0.0, 1e-3), |(sum, size), product: f64| (sum + product, size + product.abs()));
                    let found = f64::from(panels[panel_index(k, index, column)]);
                    prop_assert!((found - sum).abs() <= 2e-6 * size);
                }
            }
        }
    }
}

#[test]
fn a_row_does_not_depend_on_its_company() {
    let all = Problem::new(64, 37, 40, 0);
    let together = all.run(Kind::BiasRelu, matmul::<f32>);
    for row in 0..all.rows {
        let alone = Problem {
            rows: 1,
            x: all.x[row * all.x_stride..][..all.k].to_vec(),
            x_stride: all.k,
            matrix: all.matrix.clone(),
            extra: all.extra.clone(),
            ..all
        };
        assert_eq!(
            alone.run(Kind::BiasRelu, matmul::<f32>),
            together[row * 40..(row + 1) * 40]
        );
    }
}

#[test]
fn nan_is_not_hidden() {
    for kernel in [matmul::<f32> as fn(MatMul<'_, f32>), matmul_portable::<f32>] {
        let mut problem = Problem::new(7, 3, 8, 0);
        problem.x[4] = f32::NAN;
        let found = problem.run(Kind::BiasRelu, kernel);
        for (element, value) in found.iter().enumerate() {
            assert_eq!(value.is_nan(), element / 8 == 1);
        }
    }
}

/// Activation rows are an odd number of cache lines apart, so that a walk down a column does not fall into few
/// sets of the cache.
#[test]
fn rows_are_an_odd_number_of_lines_apart() {
    for columns in 1..600 {
        let stride = row_stride(columns);
        assert!(stride >= padded(columns) && padded(columns) >= columns);
        assert_eq!(stride % 32, 16);
    }
}
