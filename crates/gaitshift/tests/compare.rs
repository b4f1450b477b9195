//! `gaitshift compare`: one table with names, the same figures as each by itself, the course of runs, bad input.

use crate::common::{Place, TINY};
use serde_json::Value;

fn rows(value: &Value) -> &Vec<Value> {
    value["rows"].as_array().unwrap()
}

#[test]
fn controllers_and_recordings_stand_in_one_table() {
    let place = Place::new();
    // What went wrong: a folder called `shipped` hid the controller of that name; then a run in it was compared beside the controller.
    std::fs::create_dir(place.path("shipped")).unwrap();
    place.write("shipped/config.toml", "name = 'mine'\nseed = 7\n");
    let motion = "--omega-v 0,3 --duration-s 3";
    place.stdout(&format!("evaluate {motion} --out out"));
    place.write(
        "same.safetensors",
        include_bytes!("../../gaitshift-experiment/controllers/biped.safetensors"),
    );
    let items = "shipped same.safetensors out/omega_v_3.csv";
    let value = place.json(&format!("compare {items} {motion} --json"));
    let names: Vec<&str> = rows(&value)
        .iter()
        .map(|row| row["name"].as_str().unwrap())
        .collect();
    assert_eq!(
        names,
        [
            "shipped",
            "shipped",
            "same.safetensors",
            "same.safetensors",
            "out/omega_v_3.csv"
        ]
    );
    assert_eq!(value["runs"], serde_json::json!([]));
    // What each by itself is told.
    let alone = place.json(&format!("evaluate {motion} --json"));
    for (row, other) in [(0, 0), (1, 1), (2, 0), (3, 1), (4, 1)] {
        let mut row = rows(&value)[row].clone();
        row.as_object_mut().unwrap().remove("name");
        assert_eq!(row, rows(&alone)[other]);
    }
    assert!(!place.path("out/compare").exists());
    let text = place.stdout(&format!("compare {items} {motion}"));
    for name in ["shipped", "same.safetensors", "out/omega_v_3.csv"] {
        assert!(text.contains(name), "{text}");
    }
    assert!(text.starts_with("default start\n"), "{text}");
    let svg = String::from_utf8(place.read("out/compare/sweep.svg")).unwrap();
    for name in ["shipped", "same.safetensors", "out/omega_v_3.csv"] {
        assert!(svg.contains(&format!(">{name}<")), "{name}");
    }
    // What is changed is the same for all, and said once.
    let text =
        place.stdout("compare shipped --omega-v 3 --duration-s 1 --set friction=0.5 --seed 1,2");
    assert!(
        text.starts_with("2 random starts, friction=0.5\n"),
        "{text}"
    );
}

#[test]
fn runs_are_compared_by_their_course_too() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    place.stdout("train tiny.toml --seeds 1-2");
    let compare = "compare runs/tiny-run-1 runs/tiny-run-2/ shipped --omega-v 3 --duration-s 1";
    let value = place.json(&format!("{compare} --json"));
    let runs = value["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 2);
    assert_eq!(
        (&runs[1]["name"], &runs[1]["seed"]),
        (&Value::from("runs/tiny-run-2"), &Value::from(2))
    );
    assert_eq!(runs[0]["evaluations"], 2);
    let text = place.stdout(&format!("{compare} --out here --seed 1..2"));
    assert!(
        text.contains("runs/tiny-run-1") && text.contains("of 2"),
        "{text}"
    );
    let experiments = value["experiments"].as_array().unwrap();
    assert_eq!(experiments.len(), 1);
    assert_eq!(experiments[0]["seeds"], 2);
    assert!(text.contains("effect, 95 %"), "{text}");
    let table = String::from_utf8(place.read("here/table.md")).unwrap();
    assert!(table.contains("| tiny run | 2 | 2 |"), "{table}");
    assert!(place.path("here/table.png").is_file());
    let svg = String::from_utf8(place.read("here/learning.svg")).unwrap();
    assert!(
        svg.contains("tiny run, mean and range of 2 runs"),
        "two seeds are one curve"
    );
}

// The table of other runs stayed beside the figure of a comparison.
#[test]
fn nothing_of_an_earlier_comparison_is_left() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    place.stdout("train tiny.toml --out run");
    place.write_toy_recording("toy.csv");
    place.stdout("compare run --omega-v 0 --duration-s 1");
    let files = [
        "table.md",
        "table.json",
        "table.svg",
        "learning.svg",
        "sweep.svg",
    ];
    let there = |name: &str| place.path(&format!("out/compare/{name}")).exists();
    assert!(files.iter().all(|name| there(name)));
    place.stdout("compare shipped --omega-v 0 --duration-s 1");
    assert_eq!(files.map(there), [false, false, false, false, true]);
    place.stdout("compare toy.csv");
    let drawn = there("sweep.svg");
    std::fs::remove_dir_all(place.path("out")).unwrap();
    place.stdout("compare toy.csv");
    assert_eq!(drawn, there("sweep.svg"));
}

// The step of another evaluation was given, where one that met more criteria by chance scored less.
#[test]
fn the_best_is_the_evaluation_whose_controller_is_kept() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    place.stdout("train tiny.toml --out run");
    let text = String::from_utf8(place.read("run/evaluations.jsonl")).unwrap();
    let mut evaluations: Vec<Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    for (evaluation, (met, score)) in evaluations.iter_mut().zip([(30, 30.5), (29, 33.5)]) {
        (evaluation["met"], evaluation["score"]) = (met.into(), score.into());
    }
    let lines: Vec<String> = evaluations.iter().map(|e| format!("{e}\n")).collect();
    place.write("run/evaluations.jsonl", lines.concat());
    let value = place.json("compare run --omega-v 0 --duration-s 1 --json");
    assert_eq!(value["runs"][0]["best_step"], evaluations[1]["step"]);
    assert_eq!(value["runs"][0]["best_met"], 29);
}

// It was said to have been trained for 0 s.
#[test]
fn of_a_run_that_was_not_evaluated_nothing_is_said() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    let never = "--set training.evaluation_interval_steps=1000000";
    place.stdout(&format!("train tiny.toml {never} --steps 1000 --out run"));
    let text = place.stdout("compare run --omega-v 0 --duration-s 1");
    let line = text
        .lines()
        .find(|line| line.starts_with("run ") && line.contains("tiny"));
    let cells: Vec<&str> = line.unwrap().split_whitespace().collect();
    assert_eq!(cells[cells.len() - 3..], ["-"; 3], "{text}");
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let place = Place::new();
    place.write("bad.csv", "time_s\n0\n");
    place.refused("compare", &["FILE|DIR|NAME"]);
    place.refused("compare shipped absent", &["absent"]);
    place.refused("compare bad.csv", &["bad.csv"]);
    place.refused(
        "compare shipped --set frction=1",
        &["did you mean `friction`?"],
    );
    std::fs::create_dir(place.path("run")).unwrap();
    place.write("run/config.toml", "name = \"run\"\nseed = 1\n");
    place.write("run/evaluations.jsonl", "{}\n");
    place.refused("compare run", &["evaluations.jsonl", "line 1"]);
}

// A run given twice was two seeds; runs of other settings were seeds of one experiment; numbers of criteria were subtracted
// whatever the criteria.
#[test]
fn only_what_can_be_taken_together_is() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    place.stdout("train tiny.toml --out a");
    place.stdout("train tiny.toml --out slippery --set body.friction=0.6");
    let one = "--set criteria={omega_v=[0],duration_s=1,gaits=[],changes=[]}";
    place.stdout(&format!("train tiny.toml --out easy {one}"));
    place.refused("compare a ./a", &["./a is given twice"]);
    place.refused("report a a/", &["a/ is given twice"]);
    let motion = "--omega-v 0 --duration-s 1 --json";
    let value = place.json(&format!("compare a slippery easy {motion}"));
    let experiments = value["experiments"].as_array().unwrap();
    let seeds: Vec<&Value> = experiments.iter().map(|e| &e["seeds"]).collect();
    assert_eq!(seeds, [1, 1, 1]);
    assert_eq!(experiments[1]["variant"], "tiny run (slippery)");
    assert!(experiments[1]["effect"]["value"].is_number());
    assert_eq!(experiments[2]["effect"], Value::Null);
    assert_eq!(value["runs"][0]["criteria"], 39);
}

#[test]
fn a_recording_is_said_to_stay_as_it_is() {
    let place = Place::new();
    place.stdout("evaluate --omega-v 3 --duration-s 1 --out out");
    let output = place
        .output("compare out/omega_v_3.csv shipped --omega-v 3 --duration-s 1 --set friction=0.5");
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("out/omega_v_3.csv is a recording"), "{said}");
}
