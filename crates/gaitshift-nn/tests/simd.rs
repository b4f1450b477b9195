//! Whatever instructions the processor has, the products are right, with zeros and without: AVX-512 and AVX2 give the same
//! bits, and the code for any processor, which no other test would reach on one with AVX2, agrees with the definition.
//!
//! The limit holds for the whole process, so all is one test.

mod products;

use gaitshift_nn::dense::multiply;
use gaitshift_nn::simd::{Level, level, limit};
use gaitshift_nn::sparse;
use products::{Kind, Problem};

fn problems() -> Vec<(Kind, Problem)> {
    let kinds = [Kind::None, Kind::Bias, Kind::BiasRelu, Kind::Mask];
    let mut problems = Vec::new();
    // Every number of vectors in a strip, every rest of rows in a tile, words of marks that are full and not.
    for eighths in 1..=30 {
        for rows in [1, 2, 5, 6, 7, 24, 31, 64] {
            for (shared, transposed) in [(1, false), (64, true), (70, false)] {
                let kind = kinds[problems.len() % kinds.len()];
                let mut problem = Problem::new(rows, shared, 8 * eighths, rows % 3, transposed);
                if problems.len() % 5 > 0 {
                    problem.thin_out(0.5);
                }
                problems.push((kind, problem));
            }
        }
    }
    problems
}

#[test]
fn every_level_multiplies_alike() {
    let problems = problems();
    let highest = level();
    let mut fused: Option<Vec<Vec<f32>>> = None;
    for most in [Level::Avx512, Level::Avx2, Level::Portable] {
        limit(most);
        assert_eq!(level(), highest.min(most));
        let results: Vec<_> = problems
            .iter()
            .map(|(kind, problem)| {
                let dense = problem.run(*kind, multiply::<f32>);
                let found = problem.run(*kind, |product| {
                    sparse::multiply(product, &problem.pattern());
                });
                assert_eq!(dense, found);
                problem.check(*kind, &found).unwrap();
                found
            })
            .collect();
        if level() > Level::Portable {
            assert!(fused.get_or_insert_with(|| results.clone()) == &results);
        }
    }
}
