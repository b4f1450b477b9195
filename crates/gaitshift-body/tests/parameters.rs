//! Contract: the defaults are a body of 40 kg that can be; whatever cannot be is refused by its key, its value and what is
//! accepted; what can be but is probably not meant gets a warning; parameters go through TOML without losing a bit, and unknown keys are refused.

use gaitshift_body::{Body, BodyParameters, BodyState, RIGHT};

/// The default parameters with one of them replaced.
fn with(key: &str, value: f64) -> BodyParameters {
    let mut table = toml::Table::try_from(BodyParameters::default()).unwrap();
    let old = table.get(key).unwrap_or_else(|| panic!("no key {key}"));
    let value = match old {
        toml::Value::Integer(_) => toml::Value::Integer(value as i64),
        _ => toml::Value::Float(value),
    };
    table.insert(key.to_owned(), value);
    table.try_into().unwrap()
}

fn keys() -> Vec<String> {
    let table = toml::Table::try_from(BodyParameters::default()).unwrap();
    table.keys().cloned().collect()
}

#[test]
fn the_defaults_are_a_body_of_forty_kilograms() {
    let p = BodyParameters::default();
    p.validate().unwrap();
    assert_eq!(p.total_mass_kg(), 40.0);
    Body::new(p).unwrap();
}

#[test]
fn no_parameter_may_be_something_other_than_a_number() {
    for key in keys() {
        if key == "foot_sphere_count" {
            continue;
        }
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let error = with(&key, value).validate().unwrap_err();
            assert_eq!(error.key, key);
        }
    }
}

#[test]
fn what_cannot_be_is_refused_by_name_and_value() {
    for (key, value, accepted) in [
        ("hip_mass_kg", 0.0, "greater than 0"),
        ("foot_mass_kg", -1.0, "greater than 0"),
        ("friction", -0.1, "0 or greater"),
        ("time_step_s", 0.011, "at most 0.01"),
        ("time_step_s", 0.0, "greater than 0"),
        ("contact_exponent", 0.5, "between 1 and 3"),
        ("contact_exponent", 3.1, "between 1 and 3"),
        ("foot_sphere_count", 0.0, "between 1 and 1000"),
        ("foot_sphere_count", 1001.0, "between 1 and 1000"),
        (
            "foot_sphere_radius_m",
            0.27,
            "smaller than foot_arc_radius_m",
        ),
        ("foot_arc_radius_m", 0.81, "at most leg_length_m"),
        ("foot_arc_half_angle_rad", 3.2, "at most pi"),
        ("hip_com_height_m", -2.1, "between -2 and 2"),
    ] {
        let error = with(key, value).validate().unwrap_err();
        assert_eq!((error.key, error.value), (key, value));
        let message = error.to_string();
        for word in [key, accepted] {
            assert!(message.contains(word), "{message}");
        }
        assert!(Body::new(with(key, value)).is_err());
    }
}

#[test]
fn limits_themselves_are_accepted() {
    for (key, value) in [
        ("friction", 0.0),
        ("gravity_m_per_s2", 0.0),
        ("time_step_s", 0.01),
        ("contact_exponent", 3.0),
        ("foot_sphere_count", 1.0),
        ("foot_arc_radius_m", 0.8),
    ] {
        with(key, value)
            .validate()
            .unwrap_or_else(|e| panic!("{e}"));
    }
}

#[test]
fn parameters_go_through_toml_without_losing_a_bit() {
    let p = BodyParameters {
        friction: 0.1 + 0.2,
        hip_mass_kg: f64::from_bits(0x4034_0000_0000_0001),
        ..BodyParameters::default()
    };
    let text = toml::to_string(&p).unwrap();
    assert_eq!(toml::from_str::<BodyParameters>(&text).unwrap(), p);
    let error = toml::from_str::<BodyParameters>("frikction = 1.0").unwrap_err();
    assert!(error.message().contains("frikction"), "{error}");
}

fn changed(change: impl Fn(&mut BodyParameters)) -> BodyParameters {
    let mut body = BodyParameters::default();
    change(&mut body);
    body
}

#[test]
fn the_default_body_is_valid_and_not_warned_of() {
    let body = BodyParameters::default();
    body.validate().unwrap();
    assert_eq!(body.warnings(), Vec::<String>::new());
}

// A foot of a billion kilograms was trained with, and nobody said a word.
#[test]
fn a_mass_beyond_any_animal_is_refused() {
    let error = changed(|b| b.foot_mass_kg = 1e9).validate().unwrap_err();
    assert_eq!((error.key, error.value), ("foot_mass_kg", 1e9));
    assert!(error.to_string().contains("at most 10000"), "{error}");
    let error = changed(|b| b.leg_length_m = 800.0).validate().unwrap_err();
    assert_eq!(error.key, "leg_length_m");
}

#[test]
fn a_body_that_cannot_lift_itself_is_warned_of() {
    let heavy = changed(|b| b.hip_mass_kg = 500.0);
    heavy.validate().unwrap();
    assert!(
        heavy.warnings()[0].contains("`actuator_force_n`"),
        "{:?}",
        heavy.warnings()
    );
    let soft = changed(|b| b.contact_stiffness = 1e3);
    assert!(
        soft.warnings()[0].contains("`contact_stiffness`"),
        "{:?}",
        soft.warnings()
    );
}

// Another length of the leg left the segments where they were, without a word.
#[test]
fn segments_that_do_not_follow_the_leg_are_warned_of() {
    let long = changed(|b| b.leg_length_m = 1.6);
    let [warning] = &long.warnings()[..] else {
        panic!("{:?}", long.warnings());
    };
    for word in [
        "`leg_length_m` is 1.6",
        "`thigh_distance_m` 0.400",
        "`foot_distance_m` 1.500",
        "`stroke_m` 0.200",
        "`thigh_inertia_kg_m2` 0.320",
    ] {
        assert!(warning.contains(word), "{warning}");
    }
    let in_proportion = changed(|b| {
        b.leg_length_m = 1.6;
        b.thigh_distance_m = 0.4;
        b.tibia_distance_m = 1.1;
        b.foot_distance_m = 1.5;
    });
    assert_eq!(in_proportion.warnings(), Vec::<String>::new());
    let short = changed(|b| b.leg_length_m = 0.7);
    assert!(
        short
            .warnings()
            .iter()
            .any(|w| w.contains("below the sole"))
    );
}

// The lowest sphere alone was asked to carry the body, so that soft ground which all of them share was warned of.
#[test]
fn a_foot_that_sinks_in_is_warned_of_where_its_spheres_together_do_not_carry_it() {
    let mut warned_of = Vec::new();
    for stiffness in [1e3, 2e3, 5e3, 8e3, 1e4, 1.4e4, 3e4, 1e5] {
        let parameters = changed(|b| b.contact_stiffness = stiffness);
        let too_deep_m = 0.1 * parameters.foot_arc_radius_m;
        let weight_n = parameters.total_mass_kg() * parameters.gravity_m_per_s2;
        let warned = parameters.warnings().iter().any(|w| w.contains("sinks"));
        let body = Body::new(parameters).unwrap();
        let mut sunk = BodyState::with_leg_angles(&body, [0.0; 2]);
        sunk.z -= too_deep_m;
        let carried = body.foot_contact(&sunk, RIGHT).normal_n >= weight_n;
        assert_eq!(warned, !carried, "{stiffness} N/m");
        warned_of.push(warned);
    }
    assert!(warned_of[0] && !warned_of[5]);
}
