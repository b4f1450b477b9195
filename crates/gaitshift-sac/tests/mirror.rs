//! A mirror is a signed permutation that undoes itself; anything else is refused with its cause.

use gaitshift_sac::{Mirror, SacError, reflect};

#[test]
fn twice_is_identity() {
    let map = [(3, -1.0), (1, -1.0), (2, 1.0), (0, -1.0)];
    let mirror = Mirror {
        observation: map.to_vec(),
        action: vec![(0, 1.0)],
    };
    mirror.validate(4, 1).unwrap();
    let original = [1.0f32, 2.0, -3.0, 4.0];
    let (mut image, mut back) = ([0.0; 4], [0.0; 4]);
    reflect(&map, &original, &mut image);
    assert_eq!(image, [-4.0, -2.0, -3.0, -1.0]);
    reflect(&map, &image, &mut back);
    assert_eq!(back, original);
}

#[test]
fn what_is_no_mirror_is_refused() {
    for (map, cause) in [
        (vec![(0, 1.0)], "1 entries for 2"),
        (vec![(0, 1.0), (2, 1.0)], "takes number 2 of 2"),
        (vec![(0, 1.0), (1, 0.5)], "sign 0.5"),
        (vec![(0, 1.0), (1, f32::NAN)], "sign NaN"),
        (vec![(1, 1.0), (1, 1.0)], "twice is not itself"),
        (vec![(1, 1.0), (0, -1.0)], "twice is not itself"),
    ] {
        let mirror = Mirror {
            observation: map.clone(),
            action: vec![(0, 1.0)],
        };
        let error = mirror.validate(2, 1).unwrap_err();
        assert!(matches!(
            error,
            SacError::Mirror {
                what: "observation",
                ..
            }
        ));
        assert!(error.to_string().contains(cause), "{map:?}: {error}");
    }
}
