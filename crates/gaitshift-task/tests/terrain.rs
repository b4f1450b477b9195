//! Contract: the ground is the sum of slope, steps and unevenness; a seed draws the same ground again.

use gaitshift_task::{TerrainParameters, TerrainStep, UnevenGround};

#[test]
fn the_ground_is_the_sum_of_its_parts() {
    let slope = TerrainParameters {
        slope_rad: 0.1,
        slope_from_m: Some(2.0),
        steps: vec![
            TerrainStep {
                height_m: -0.05,
                at_m: 4.0,
            },
            TerrainStep {
                height_m: 0.03,
                at_m: 1.0,
            },
        ],
        ..TerrainParameters::default()
    };
    let terrain = slope.terrain().unwrap();
    for (x, height) in [
        (0.0, 0.0),
        (0.999, 0.0),
        (1.0, 0.03),
        (3.0, 0.03 + 0.1f64.tan()),
        (5.0, -0.02 + 3.0 * 0.1f64.tan()),
    ] {
        assert!((terrain.height(x) - height).abs() < 1e-12, "{x}");
    }
    let uneven = TerrainParameters {
        uneven: UnevenGround {
            height_m: 0.02,
            ..UnevenGround::default()
        },
        ..TerrainParameters::default()
    };
    let both = TerrainParameters {
        uneven: uneven.uneven,
        ..slope.clone()
    };
    let (rough, both) = (uneven.terrain().unwrap(), both.terrain().unwrap());
    let heights: Vec<f64> = (0..4000)
        .map(|k| rough.height(0.03 * f64::from(k)))
        .collect();
    assert!(heights.iter().all(|z| z.abs() <= 0.02));
    assert!(heights.iter().any(|z| *z > 0.015) && heights.iter().any(|z| *z < -0.015));
    for k in 0..4000 {
        let x = 0.03 * f64::from(k) + 0.001;
        let sum = rough.height(x) + terrain.height(x);
        assert!((both.height(x) - sum).abs() < 1e-9, "{x}");
    }
    // Flat where it begins, and another seed is another ground.
    assert_eq!(rough.height(0.9), 0.0);
    let other = UnevenGround {
        seed: 1,
        ..uneven.uneven
    };
    let other = TerrainParameters {
        uneven: other,
        ..uneven.clone()
    };
    assert_ne!(other.terrain(), uneven.terrain());
    assert_eq!(uneven.terrain(), uneven.terrain());
}
