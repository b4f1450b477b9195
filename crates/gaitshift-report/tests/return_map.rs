//! Contract: the spectral radius is that of matrices whose eigenvalues are known, complex ones too; a run's map has a fixed
//! point, its differences agree over decades of widths and to either side, and deviations shrink as the largest multiplier says.

use gaitshift_report::{ReturnMap, Subject, spectral_radius};

const SIZE: usize = 20;

fn matrix(of: impl Fn(usize, usize) -> f64) -> Vec<[f64; SIZE]> {
    (0..SIZE)
        .map(|j| std::array::from_fn(|i| of(i, j)))
        .collect()
}

#[test]
fn spectral_radii_of_known_matrices() {
    let near = |columns: &[[f64; SIZE]], expected: f64| {
        let found = spectral_radius(columns).unwrap();
        assert!(
            (found / expected - 1.0).abs() < 2e-3,
            "{found} instead of {expected}"
        );
    };
    // Triangular: the diagonal holds the eigenvalues, whatever is beside it.
    near(
        &matrix(|i, j| match i.cmp(&j) {
            std::cmp::Ordering::Equal => -0.9 + 0.05 * i as f64,
            std::cmp::Ordering::Less => 3.0,
            std::cmp::Ordering::Greater => 0.0,
        }),
        0.9,
    );
    // A turn by 0.3 rad shrunk to 0.8, a pair of complex eigenvalues, beside zeros.
    let (sin, cos) = 0.3_f64.sin_cos();
    near(
        &matrix(|i, j| match (i, j) {
            (4, 4) | (7, 7) => 0.8 * cos,
            (4, 7) => -0.8 * sin,
            (7, 4) => 0.8 * sin,
            _ => 0.0,
        }),
        0.8,
    );
    assert_eq!(spectral_radius(&matrix(|_, _| 0.0)), Some(0.0));
    // Shifts coordinates onwards and the last one out: after 20 times nothing is left.
    assert_eq!(
        spectral_radius(&matrix(|i, j| f64::from(u8::from(i == j + 1)))),
        Some(0.0)
    );
    assert_eq!(spectral_radius(&matrix(|_, _| f64::NAN)), None);
}

#[test]
fn the_run_is_a_stable_fixed_point() {
    let map = ReturnMap::find(&mut Subject::shipped().unwrap(), 0.9)
        .unwrap()
        .expect("it runs");
    assert!(map.residual < 1e-6, "{map:?}");
    assert!((0.6..0.8).contains(&map.stride_s), "{map:?}");
    let largest = map.multiplier.unwrap();
    assert!((0.2..1.0).contains(&largest), "{map:?}");
    assert!((largest - map.decay.unwrap()).abs() < 0.05, "{map:?}");
    // With commands held for 10 ms the stride is no whole number of them; the return is still one.
    assert!((largest - map.held.unwrap()).abs() < 0.05, "{map:?}");
    // Two decades of widths agree, to either side too. A width of 1e-6 is that of rounding, and is there to show it.
    for differences in &map.differences[1..] {
        for from in [
            differences.central,
            differences.forward,
            differences.backward,
        ] {
            assert!((largest - from.unwrap()).abs() < 0.03, "{map:?}");
        }
    }
    assert_eq!(map.multiplier, map.differences[2].central);
}
