//! Contract: the MJCF is well-formed, names every joint in the order of the body's coordinates, and every
//! parameter that MuJoCo can express changes it; values MuJoCo refuses are not written. That MuJoCo moves the
//! body as we do is tested with MuJoCo itself: `crates/gaitshift-python/tests/test_mujoco_*.py`.

use gaitshift_body::{Body, BodyParameters};
use gaitshift_export::NominalContact;
use gaitshift_task::{Disturbance, Environment, TaskParameters};

fn mjcf(body: &BodyParameters) -> String {
    gaitshift_export::mjcf(body, &TaskParameters::default(), &Disturbance::default()).unwrap()
}

/// Opening and closing tags in order, comments left out; panics where they do not match.
fn tags(text: &str) -> Vec<String> {
    let mut rest = text;
    let (mut open, mut all) = (Vec::new(), Vec::new());
    while let Some(start) = rest.find('<') {
        rest = &rest[start..];
        if let Some(comment) = rest.strip_prefix("<!--") {
            let end = comment.find("-->").expect("a comment that ends");
            assert!(!comment[..end].contains("--"), "`--` within a comment");
            rest = &comment[end + 3..];
            continue;
        }
        let end = rest.find('>').expect("a tag that ends");
        let tag = &rest[1..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop().as_deref(), Some(name));
            continue;
        }
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        if !tag.ends_with('/') {
            open.push(tag.split_whitespace().next().unwrap().to_owned());
        }
        all.push(tag.to_owned());
    }
    assert!(open.is_empty(), "{open:?} not closed");
    all
}

fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    let start = tag.find(&format!(" {name}=\""))? + name.len() + 3;
    tag[start..].split('"').next()
}

#[test]
fn joints_come_in_the_order_of_the_coordinates() {
    let tags = tags(&mjcf(&BodyParameters::default()));
    let joints: Vec<&str> = tags
        .iter()
        .filter(|tag| tag.starts_with("joint ") && tag.contains("type="))
        .filter_map(|tag| attribute(tag, "name"))
        .collect();
    assert_eq!(
        joints,
        [
            "x",
            "z",
            "theta",
            "right_phi",
            "right_h",
            "right_d",
            "right_w",
            "left_phi",
            "left_h",
            "left_d",
            "left_w"
        ]
    );
    let spheres = tags.iter().filter(|t| t.contains("class=\"sole\" name"));
    assert_eq!(spheres.count(), 40);
    let sensors = tags
        .iter()
        .filter(|t| t.starts_with("joint") && t.contains("_joint"));
    assert_eq!(sensors.count(), 13);
}

#[test]
fn every_parameter_changes_the_file() {
    let default = BodyParameters::default();
    let text = mjcf(&default);
    let serde_json::Value::Object(fields) = serde_json::to_value(&default).unwrap() else {
        panic!("parameters are an object");
    };
    for (key, value) in &fields {
        // Of the numbers only the limit of divergence means nothing to MuJoCo.
        if key == "diverged_speed" {
            continue;
        }
        let mut changed = fields.clone();
        let new = match value.as_u64() {
            Some(count) => serde_json::json!(count + 1),
            None => serde_json::json!(value.as_f64().unwrap() * 1.1 + 1e-4),
        };
        changed.insert(key.clone(), new);
        let changed: BodyParameters = serde_json::from_value(changed.into()).unwrap();
        assert!(mjcf(&changed) != text, "{key}");
    }
}

#[test]
fn the_nominal_contact_carries_the_nominal_load() {
    for exponent in [1.0, 1.5, 3.0] {
        let p = BodyParameters {
            contact_exponent: exponent,
            ..BodyParameters::default()
        };
        let c = NominalContact::new(&p);
        let load = p.contact_stiffness * c.depth_m.powf(exponent);
        assert!((load - c.load_n).abs() < 1e-9 * c.load_n);
        assert!((c.stiffness_n_per_m * c.depth_m - c.load_n).abs() < 1e-9 * c.load_n);
    }
}

#[test]
fn extreme_bodies_are_written_with_finite_numbers() {
    let p = BodyParameters {
        thigh_inertia_kg_m2: 0.0,
        tibia_inertia_kg_m2: 0.0,
        foot_inertia_kg_m2: 0.0,
        gravity_m_per_s2: 0.0,
        friction: 0.0,
        contact_dissipation_s_per_m: 0.0,
        contact_stiffness: 0.0,
        actuator_force_n: 0.0,
        foot_sphere_count: 1,
        ..BodyParameters::default()
    };
    p.validate().unwrap();
    let text = mjcf(&p);
    assert!(!text.contains("NaN") && !text.contains("inf\""), "{text}");
    for tag in tags(&text).iter().filter(|t| t.starts_with("inertial")) {
        let inertia = attribute(tag, "diaginertia").unwrap();
        assert!(inertia.split(' ').all(|i| i.parse::<f64>().unwrap() > 0.0));
    }
}

// The exported body stood still under its policy: its pose at rest is symmetric, and so is the policy. The file had neither
// the start that the policy knows nor the time for which its actions are held.
#[test]
fn the_file_has_a_start_and_the_control_period() {
    let body = BodyParameters::default();
    let mut task = TaskParameters {
        control_period_s: 0.005,
        ..TaskParameters::default()
    };
    task.start.speed_m_per_s = 0.7;
    let text = gaitshift_export::mjcf(&body, &task, &Disturbance::default()).unwrap();
    let tags = tags(&text);
    let named = |name: &str| {
        let mut found = tags.iter().filter(|t| attribute(t, "name") == Some(name));
        let tag = found.next().unwrap_or_else(|| panic!("no {name}"));
        assert!(found.next().is_none());
        tag.as_str()
    };
    let period = named("control_period_s");
    assert!(period.starts_with("numeric "));
    assert_eq!(attribute(period, "data"), Some("0.005"));
    let key = named("start");
    assert!(key.starts_with("key "));
    let start = Environment::default_start(&Body::new(body).unwrap(), &task);
    for (name, values) in [("qpos", start.positions()), ("qvel", start.velocities())] {
        let text = attribute(key, name).unwrap().split(' ');
        let written: Vec<f64> = text.map(|v| v.parse().unwrap()).collect();
        assert_eq!(written, values, "{name}");
    }
    assert!(
        start.positions()[3] != start.positions()[7],
        "one leg in front"
    );
}

// A weak or a late actuator could not be exported.
#[test]
fn actuators_may_be_weak_and_late() {
    let body = BodyParameters::default();
    let disturbance = Disturbance {
        actuator_factor: [0.5, 1.0],
        latency_s: 0.01015,
        ..Disturbance::default()
    };
    let task = TaskParameters::default();
    let text = gaitshift_export::mjcf(&body, &task, &disturbance).unwrap();
    let tags = tags(&text);
    let motors: Vec<&String> = tags.iter().filter(|t| t.starts_with("motor ")).collect();
    let of =
        |name: &str| -> Vec<&str> { motors.iter().map(|t| attribute(t, name).unwrap()).collect() };
    assert_eq!(of("name"), ["right", "left"]);
    assert_eq!(of("gear"), ["300.0", "600.0"]);
    // Rounded to whole steps of 0.2 ms.
    assert_eq!(of("nsample"), ["51", "51"]);
    for delay in of("delay") {
        assert!(
            (delay.parse::<f64>().unwrap() - 0.0102).abs() < 1e-12,
            "{delay}"
        );
    }
    assert!(!mjcf(&body).contains("delay="));
}

#[test]
fn a_body_out_of_range_is_an_error() {
    let body = BodyParameters {
        foot_mass_kg: -1.0,
        ..BodyParameters::default()
    };
    let error = gaitshift_export::mjcf(&body, &TaskParameters::default(), &Disturbance::default())
        .unwrap_err();
    assert_eq!(error.key, "foot_mass_kg");
}
