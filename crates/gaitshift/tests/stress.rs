//! `gaitshift stress`: the JSON that other programs rely on, the table, the files written, and bad input.

use crate::common::Place;

const SHORT: &str = "stress --quick --omega-v 3 --seed 1";

#[test]
fn the_json_is_the_file_and_has_what_is_promised() {
    let place = Place::new();
    let value = place.json(&format!("{SHORT} --json --out out"));
    let limits = value["limits"].as_array().unwrap();
    assert_eq!(limits.len(), 8 + 2 + 2 + 8 + 1);
    for limit in limits {
        for field in ["disturbance", "which", "unit"] {
            assert!(limit[field].is_string(), "{limit}");
        }
        for field in ["omega_v", "least", "median", "greatest", "greatest_tried"] {
            assert!(limit[field].is_number(), "{limit}");
        }
        assert_eq!(limit["phase"].is_number(), limit["disturbance"] == "push");
        assert_eq!(limit["limits"].as_array().unwrap().len(), 1);
    }
    let file: serde_json::Value = serde_json::from_slice(&place.read("out/stress.json")).unwrap();
    assert_eq!(file, value);
    assert_eq!(value["plan"]["seeds"], serde_json::json!([1]));
    assert!(place.path("out/stress.svg").exists() && place.path("out/stress.png").exists());
}

#[test]
fn the_table_has_a_row_for_each_disturbance_and_nothing_is_written_with_json_alone() {
    let place = Place::new();
    let text = place.stdout(SHORT);
    for row in [
        "push forward, phase 0.25",
        "step up",
        "slope down",
        "noise theta_velocity",
        "latency",
    ] {
        assert!(
            text.lines().any(|line| line.starts_with(row)),
            "{row}: {text}"
        );
    }
    assert!(text.contains("wrote out/stress/stress.json"), "{text}");
    let other = Place::new();
    other.json(&format!("{SHORT} --json"));
    assert!(!other.path("out").exists());
}

#[test]
fn pushes_may_be_asked_for_alone() {
    let place = Place::new();
    let text = place.stdout(&format!("{SHORT} --only push,latency"));
    let rows = text
        .lines()
        .filter(|line| line.starts_with("push ") || line.starts_with("latency"));
    assert_eq!(rows.count(), 8 + 1);
    for other in ["step", "slope"] {
        assert!(!text.contains(other), "{text}");
    }
    let file: serde_json::Value =
        serde_json::from_slice(&place.read("out/stress/stress.json")).unwrap();
    assert_eq!(
        file["plan"]["kinds"],
        serde_json::json!(["push", "latency"])
    );
}

#[test]
fn bad_input_is_refused() {
    let place = Place::new();
    place.refused(
        "stress --controller nothing.safetensors",
        &["nothing.safetensors"],
    );
    place.refused("stress --omega-v 1000", &["100"]);
    place.refused("stress --threads 0", &["1..=256"]);
    place.refused("stress --only pushes", &["pushes", "push"]);
}
