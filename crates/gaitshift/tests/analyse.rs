//! Contract: `gaitshift analyse` says of a recording's file what `evaluate` and `transition` say of the motion
//! itself, so that another simulator's recording is judged by the same rules.

use crate::common::Place;
use serde_json::Value;

#[test]
fn a_steady_motion_is_described_as_evaluate_does() {
    let place = Place::new();
    let evaluated = place.json("evaluate --omega-v 0,3 --duration-s 3 --out motions --json");
    let analysed = place.json("analyse motions/omega_v_0.csv motions/omega_v_3.csv --json");
    for k in 0..2 {
        let Value::Object(fields) = &evaluated["rows"][k] else {
            panic!("a row is an object");
        };
        for (name, value) in fields {
            assert_eq!(analysed["rows"][k][name], *value, "{name}");
        }
        assert_eq!(analysed["rows"][k]["controller"], "the shipped controller");
    }
    let table = place.stdout("analyse motions/omega_v_0.csv");
    assert!(table.contains("gait"), "{table}");
    // Rows of several recordings could not be told apart.
    let table = place.stdout("analyse motions/omega_v_0.csv motions/omega_v_3.csv");
    assert!(table.contains("motions/omega_v_3.csv"), "{table}");
    place.stdout("evaluate --omega-v 0,3 --duration-s 1 --out short --json");
    let table = place.stdout("analyse short/omega_v_0.csv short/omega_v_3.csv");
    assert!(table.contains("short/omega_v_0.csv: "), "{table}");
    place.refused(
        "analyse motions/omega_v_0.csv motions/omega_v_0.csv",
        &["twice"],
    );
}

#[test]
fn a_transition_is_described_as_transition_does() {
    let place = Place::new();
    let changed = place.json("transition --start-s 2 --after-s 2 --json --out change");
    let analysed = place.json("analyse --transition change/recording.csv --json");
    let found = &analysed["transitions"][0];
    assert_eq!(
        (&found["ramp_start_s"], &found["ramp_end_s"]),
        (&2.0.into(), &2.4.into())
    );
    let Value::Object(fields) = &changed else {
        panic!("a transition is an object");
    };
    for (name, value) in fields {
        assert_eq!(found[name], *value, "{name}");
    }
    // What went wrong: the times of the ramp stood there twice.
    let printed = place.stdout("analyse --transition change/recording.csv --json");
    assert_eq!(printed.matches("\"ramp_start_s\"").count(), 1, "{printed}");
    let text = place.stdout("analyse --transition change/recording.csv");
    assert!(text.contains("from 2 s to 2.4 s"), "{text}");

    // Up and down again: two changes, in both alike.
    place.write("trip.csv", "time_s,omega_v\n8,0\n8.4,3\n16,3\n16.4,0\n");
    let trip = "transition --command-profile trip.csv --after-s 8 --json --out trip";
    let changed = place.json(trip);
    let analysed = place.json("analyse --transition trip/recording.csv --json");
    assert_eq!(analysed["transitions"][0]["changes"], changed["changes"]);
    assert_eq!(changed["changes"].as_array().unwrap().len(), 2);
}

#[test]
fn what_is_no_recording_or_has_no_transition_is_refused() {
    let place = Place::new();
    place.write_toy_recording("toy.csv");
    place.refused("analyse no.csv", &["no.csv"]);
    // Missing rows were taken for a longer control period, in part of the figures.
    let text = String::from_utf8(place.read("toy.csv")).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let gap = [&lines[..500], &lines[700..], &[""]].concat().join("\n");
    place.write("gap.csv", gap.replace("\"rows\":1201", "\"rows\":1001"));
    place.refused(
        "analyse gap.csv",
        &["gap.csv", "line 501", "control_period_s"],
    );
    place.refused("analyse --transition toy.csv", &["toy.csv", "--transition"]);
    place.refused(
        "analyse --transition --settling-s 1 toy.csv",
        &["--settling-s"],
    );
}
