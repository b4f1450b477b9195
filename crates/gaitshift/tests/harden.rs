//! `gaitshift harden`: the JSON that other programs rely on, the files written, going on, and bad input.

use crate::common::Place;

/// No round: the controller as it is. It withstands many of these pushes and falls from many.
const SHORT: &str = "harden --controller robust --rounds 0 --impulse 24:44,-44:-24";

#[test]
fn the_json_has_what_is_promised_and_the_same_command_goes_on() {
    let place = Place::new();
    let value = place.json(&format!("{SHORT} --json"));
    let [first] = &value["rounds"].as_array().unwrap()[..] else {
        panic!("{value}")
    };
    assert_eq!(first["round"], 0);
    assert_eq!(
        (&first["met"], &first["criteria"]),
        (&37.into(), &39.into())
    );
    let pushes = &first["pushes"];
    assert_eq!(pushes["compared"], 128);
    let withstood = pushes["withstood"].as_u64().unwrap();
    assert!((20..120).contains(&withstood), "{first}");
    assert_eq!(first["steps_up"]["compared"], 0);
    let weak = first["weak_up"].as_u64().unwrap();
    assert!((96..=128).contains(&weak) && first["weak_compared"] == 128);
    assert_eq!(value["plan"]["omega_v"], serde_json::json!([0.0]));
    assert_eq!(value["controller"], "out/harden/controller.safetensors");
    for name in ["controller", "controller-last", "state"] {
        assert!(
            place
                .path(&format!("out/harden/{name}.safetensors"))
                .exists()
        );
    }
    // Nothing is done twice.
    let text = place.stdout(SHORT);
    let row = format!("{withstood}/128  {:>7}     37/39", format!("{weak}/128"));
    assert!(text.contains(&row), "{row}: {text}");
    assert!(
        text.contains("what it withstands: gaitshift stress"),
        "{text}"
    );
    place.refused(
        &format!("{SHORT} --seed 2"),
        &["out/harden", "another --out"],
    );
}

#[test]
fn steps_have_columns_of_their_own() {
    let place = Place::new();
    let text = place.stdout(&format!("{SHORT} --steps-up 5 --step-height 0.01:0.02"));
    let value = place.json(&format!(
        "{SHORT} --steps-up 5 --step-height 0.01:0.02 --json"
    ));
    assert_eq!(
        value["plan"]["step_up_m"],
        serde_json::json!([[0.01, 0.02]])
    );
    assert_eq!(value["plan"]["adam_steps"], 12_000);
    assert_eq!(value["plan"]["before_weight"], 4.0);
    let weak = value["rounds"][0]["weak_up"].as_u64().unwrap();
    let steps = &value["rounds"][0]["steps_up"];
    assert_eq!(steps["compared"], 128);
    let withstood = steps["withstood"].as_u64().unwrap();
    assert!((64..=128).contains(&withstood), "{steps}");
    let row = format!("{withstood}/128  {:>7}     37/39", format!("{weak}/128"));
    assert!(text.contains(&row), "{row}: {text}");
    // But a command to copy.
    let mut lines = text
        .lines()
        .filter(|line| !line.contains("gaitshift stress"));
    assert!(lines.all(|line| line.chars().count() <= 80), "{text}");
    let text = text.replace('\n', " ");
    let said = format!("{withstood} of 128 steps ({withstood} before)");
    assert!(text.contains(&said), "{said}: {text}");
    let said = format!("stays up in {weak} of 128 weakly disturbed motions ({weak} before)");
    assert!(text.contains(&said), "{said}: {text}");
}

#[test]
fn bad_input_is_refused() {
    let place = Place::new();
    place.refused(
        "harden --controller nothing.safetensors",
        &["nothing.safetensors"],
    );
    place.refused(
        "harden --impulse 36:20",
        &["FROM is greater than TO", "20:36"],
    );
    place.refused("harden --impulse 20:x", &["`x` is not a number"]);
    place.refused("harden --impulse 20:1e9", &["from -1000 to 1000 N s"]);
    place.refused(
        "harden --pushes 0",
        &["pushes in a round is 0", "between 1 and 10000"],
    );
    place.refused("harden --omega-v 0,0", &["given twice"]);
    place.refused("harden --step-height 0.01", &["--steps-up"]);
    place.refused(
        "harden --steps-up 5 --step-height 0.03:0.01",
        &["FROM is greater than TO", "0.01:0.03"],
    );
    place.refused(
        "harden --steps-up 5 --step-height 3",
        &["from 0.001 to 0.2 m"],
    );
    place.refused(
        "harden --steps-up 10001",
        &["steps up in a round is 10001", "between 0 and 10000"],
    );
    place.refused("harden --threads 0", &["1..=256"]);
    assert!(!place.path("out").exists());
}
