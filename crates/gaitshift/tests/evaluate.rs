//! `gaitshift evaluate`: the JSON that other programs rely on, the ways to change a motion, the files
//! written, and bad input. What the shipped controller achieves is not asked here.

use crate::common::Place;
use gaitshift_analysis::recording::column;
use gaitshift_analysis::{AnalysisOptions, Recording, summarise};
use serde_json::{Value, json};

/// The fields of a row that are promised, and whether they are null where undefined.
const FIELDS: [(&str, bool); 12] = [
    ("omega_v", true),
    ("survived_s", false),
    ("fell", false),
    ("gait", false),
    ("speed_m_per_s", true),
    ("froude", true),
    ("double_support", true),
    ("single_support", true),
    ("flight", true),
    ("cost_of_transport", true),
    ("step_frequency_hz", true),
    ("step_length_m", true),
];

fn rows(value: &Value) -> &Vec<Value> {
    value["rows"].as_array().expect("rows")
}

#[test]
fn json_has_a_row_for_each_command_with_the_promised_fields() {
    let value = Place::new().json("evaluate --omega-v 0,0.5,-0.25,3.5 --duration-s 3 --json");
    assert_eq!(value.as_object().unwrap().len(), 1);
    let commands: Vec<f64> = rows(&value)
        .iter()
        .map(|row| row["omega_v"].as_f64().unwrap())
        .collect();
    assert_eq!(commands, [0.0, 0.5, -0.25, 3.5]);
    for row in rows(&value) {
        for (field, nullable) in FIELDS {
            let value = row
                .get(field)
                .unwrap_or_else(|| panic!("no {field} in {row}"));
            match field {
                "fell" => assert!(value.is_boolean(), "{row}"),
                "gait" => {
                    let gaits = ["standing", "walking", "running", "mixed", "fallen"];
                    assert!(gaits.contains(&value.as_str().unwrap()), "{row}");
                }
                _ => assert!(
                    value.is_number() || nullable && value.is_null(),
                    "{field}: {row}"
                ),
            }
        }
        let survived_s = row["survived_s"].as_f64().unwrap();
        assert_eq!(row["fell"], survived_s < 3.0 - 1e-9, "{row}");
        let share = |field: &str| row[field].as_f64().unwrap();
        let shares = ["double_support", "single_support", "flight"].map(share);
        assert!(
            shares.iter().all(|share| (0.0..=1.0).contains(share)),
            "{row}"
        );
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{row}");
    }
}

#[test]
fn without_options_it_tries_the_whole_range_for_20_s() {
    let value = Place::new().json("evaluate --json");
    let commands: Vec<f64> = rows(&value)
        .iter()
        .map(|row| row["omega_v"].as_f64().unwrap())
        .collect();
    assert_eq!(commands, [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5]);
    for row in rows(&value) {
        if row["fell"] == false {
            assert_eq!(row["survived_s"], 20.0);
            assert_eq!(row["window_start_s"], 5.0);
        }
    }
}

#[test]
fn the_table_has_a_line_for_each_command() {
    let text = Place::new().stdout("evaluate --omega-v 0,3 --duration-s 2");
    assert!(text.contains("Froude") && text.contains("CoT"), "{text}");
    let starts = |start: &str| {
        text.lines()
            .any(|line| line.trim_start().starts_with(start))
    };
    assert!(starts("0  ") && starts("3  "), "{text}");
}

#[test]
fn the_same_command_gives_the_same_bytes() {
    let place = Place::new();
    for arguments in [
        "evaluate --omega-v 0,3 --duration-s 3 --json",
        "evaluate --omega-v 1 --duration-s 3 --seed 7 --json",
    ] {
        assert_eq!(place.stdout(arguments), place.stdout(arguments));
    }
}

#[test]
fn a_seed_draws_another_start() {
    let place = Place::new();
    place.stdout("evaluate --omega-v 0 --duration-s 1 --out default");
    place.stdout("evaluate --omega-v 0 --duration-s 1 --seed 1 --out one");
    place.stdout("evaluate --omega-v 0 --duration-s 1 --seed 2 --out two");
    let start = |folder: &str| {
        let file = place.path(folder).join("omega_v_0.csv");
        let recording = Recording::read_csv(file).unwrap();
        let legs = column::PHI_RAD.map(|leg| recording.column(leg)[0]);
        (legs, recording.metadata.seed)
    };
    assert_eq!(start("default"), ([0.25, -0.25], 0));
    assert_ne!(start("one").0, start("default").0);
    assert_ne!(start("one").0, start("two").0);
    assert_eq!(start("two").1, 2);
}

#[test]
fn a_constant_profile_is_the_command_itself() {
    let place = Place::new();
    place.write("one.csv", "time_s,omega_v\n0,1\n");
    let profile = place.json("evaluate --command-profile one.csv --duration-s 3 --json");
    let command = place.json("evaluate --omega-v 1 --duration-s 3 --json");
    assert_eq!(profile, command);
}

#[test]
fn under_a_changing_profile_the_command_is_null() {
    let place = Place::new();
    place.write("rise.csv", "omega_v, time_s\n-0.5, 0\n3.5, 30\n");
    let value = place.json("evaluate --command-profile rise.csv --json --out out");
    assert_eq!(rows(&value).len(), 1);
    assert!(rows(&value)[0]["omega_v"].is_null());
    // Without --duration-s the motion outlasts the profile, unless it falls.
    let survived_s = rows(&value)[0]["survived_s"].as_f64().unwrap();
    assert!(
        rows(&value)[0]["fell"] == true || survived_s == 35.0,
        "{value}"
    );
    let recording = Recording::read_csv(place.path("out/profile.csv")).unwrap();
    let commands = recording.column(column::OMEGA_V);
    assert!(commands.is_sorted() && commands[0] == -0.5 && *commands.last().unwrap() > -0.5);
}

#[test]
fn a_body_file_changes_only_what_it_names() {
    let place = Place::new();
    let evaluate = "evaluate --omega-v 0 --duration-s 2 --json";
    let plain = place.json(evaluate);
    place.write("same.toml", "leg_length_m = 0.8\n");
    assert_eq!(plain, place.json(&format!("{evaluate} --body same.toml")));
    place.write("other.toml", "hip_mass_kg = 35.0\n");
    assert_ne!(
        plain,
        place.json(&format!("{evaluate} --body other.toml --out out"))
    );
    let recording = Recording::read_csv(place.path("out/omega_v_0.csv")).unwrap();
    assert_eq!(recording.metadata.total_mass_kg, 55.0);
}

#[test]
fn a_recording_tells_the_same_as_the_row() {
    let place = Place::new();
    let value = place.json("evaluate --omega-v 0.5 --duration-s 4 --settling-s 1 --json --out o/p");
    let recording = Recording::read_csv(place.path("o/p/omega_v_0.5.csv")).unwrap();
    let options = AnalysisOptions {
        settling_time_s: 1.0,
        ..AnalysisOptions::default()
    };
    let mut summary = serde_json::to_value(summarise(&recording, &options)).unwrap();
    summary["omega_v"] = Value::from(0.5);
    summary["seed"] = Value::Null;
    let furthest_m = recording
        .column(column::X_M)
        .iter()
        .copied()
        .fold(0.0, f64::max);
    summary["reached_m"] = Value::from(furthest_m);
    assert_eq!(rows(&value)[0], summary);
    assert!(place.read("o/p/sweep.svg").starts_with(b"<svg"));
    assert!(place.read("o/p/sweep.png").starts_with(b"\x89PNG"));
}

#[test]
fn nothing_is_written_unasked() {
    let place = Place::new();
    place.stdout("evaluate --omega-v 0 --duration-s 1");
    assert_eq!(std::fs::read_dir(place.path("")).unwrap().count(), 0);
}

#[test]
fn criteria_decide_the_exit_code() {
    let output = Place::new().output("evaluate --criteria --json");
    let value: Value = serde_json::from_slice(&output.stdout).unwrap();
    let checks = value["checks"].as_array().unwrap();
    let met = checks.iter().filter(|check| check["met"] == true).count();
    assert_eq!(value["met"], met);
    assert_eq!(value["accepted"], met == checks.len());
    for check in checks {
        assert_eq!(check["met"] == true, check["reason"].is_null(), "{check}");
    }
    assert_eq!(rows(&value).len(), 8);
    let code = if value["accepted"] == true { 0 } else { 1 };
    assert_eq!(output.status.code(), Some(code));
}

#[test]
fn criteria_are_those_of_the_file_or_of_the_run() {
    const MINE: &str = "omega_v = [0, 3]\nduration_s = 6\nslowest_froude_max = 0\nfastest_froude_min = 0.5\nchanges = []\n\
        [[gaits]]\nomega_v = 3\ngait = \"running\"\n";
    let place = Place::new();
    place.write("mine.toml", MINE);
    let text = place.stdout("evaluate --criteria mine.toml");
    for words in [
        "4 criteria: 2 commands from 0 to 3, running at 3 (mine.toml)",
        "runs at omega_v = 3",
        "4 of 4 criteria met",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let value = place.json("evaluate --criteria=mine.toml --json");
    assert_eq!(
        (&value["met"], &value["accepted"]),
        (&4.into(), &true.into())
    );
    assert_eq!(value["rows"][1]["asked"], "running");
    assert!(value["rows"][0]["asked"].is_null());
    assert_eq!(value["changes"], serde_json::json!([]));
    // A run's folder stands for its criteria too.
    std::fs::create_dir(place.path("run")).unwrap();
    let shipped = include_bytes!("../../gaitshift-experiment/controllers/biped.safetensors");
    place.write("run/controller.safetensors", shipped);
    let table = MINE.replace("[[gaits]]", "[[criteria.gaits]]");
    place.write(
        "run/config.toml",
        format!("name = \"r\"\n[criteria]\n{table}"),
    );
    let text = place.stdout("evaluate --controller run --criteria");
    assert!(
        text.contains("4 of 4") && text.contains("(of run)"),
        "{text}"
    );
    // What cannot be used is named.
    place.write("empty.toml", "omega_v = []\n");
    place.refused(
        "evaluate --criteria empty.toml",
        &["empty.toml", "`omega_v` is []"],
    );
    place.refused("evaluate --criteria absent.toml", &["absent.toml"]);
    place.write("skip.toml", MINE.replace("running", "skipping"));
    place.refused(
        "evaluate --criteria skip.toml",
        &["skip.toml", "`skipping`", "running"],
    );
}

// The criteria could be tried from the default start alone.
#[test]
fn criteria_can_be_tried_from_random_starts() {
    let place = Place::new();
    place.write(
        "two.toml",
        "omega_v = [0, 3]\nduration_s = 6\nslowest_froude_max = 0\nfastest_froude_min = 0.5\nchanges = []\ngaits = []\n",
    );
    let one = place.json("evaluate --criteria two.toml --seed 5 --json");
    assert_eq!((&one["seed"], &one["met"]), (&5.into(), &3.into()));
    let default = place.json("evaluate --criteria two.toml --json");
    assert!(default["seed"].is_null());
    assert_ne!(one["rows"], default["rows"]);
    let several = place.json("evaluate --criteria two.toml --seed 5,6 --json");
    assert_eq!(several["accepted"], 2);
    assert_eq!(several["starts"].as_array().unwrap().len(), 2);
    assert_eq!(several["starts"][0], one);
    let text = place.stdout("evaluate --criteria two.toml --seed 5,6");
    for words in [
        "2 random starts; 3 criteria",
        "2 of 2",
        "survives 6 s at omega_v = 3",
        "every criterion is met from 2 of 2 starts",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let strict =
        "evaluate --criteria two.toml --seed 5,6 --set task.termination.min_hip_height_m=0.79";
    assert_eq!(place.output(strict).status.code(), Some(1));
}

#[test]
fn a_file_that_is_no_controller_is_refused() {
    let place = Place::new();
    let shipped = include_bytes!("../../gaitshift-experiment/controllers/biped.safetensors");
    place.write("half.safetensors", &shipped[..shipped.len() / 2]);
    place.write("cut.safetensors", &shipped[..shipped.len() - 1]);
    place.write("head.safetensors", &shipped[..4]);
    place.write("empty.safetensors", "");
    place.write("picture.png", b"\x89PNG\r\n\x1a\n some picture");
    place.write("foreign.safetensors", b"\x02\0\0\0\0\0\0\0{}");
    for name in [
        "half.safetensors",
        "cut.safetensors",
        "head.safetensors",
        "empty.safetensors",
        "picture.png",
        "foreign.safetensors",
        "absent.safetensors",
        ".",
    ] {
        place.refused(
            &format!("evaluate --controller {name}"),
            &["controller", name, "gaitshift train"],
        );
    }
}

#[test]
fn a_bad_body_file_is_refused() {
    let place = Place::new();
    let cases = [
        ("unknown.toml", "foot_mas_kg = 2.0\n", "foot_mas_kg"),
        ("typed.toml", "foot_mass_kg = \"heavy\"\n", "foot_mass_kg"),
        ("negative.toml", "foot_mass_kg = -1.0\n", "foot_mass_kg"),
        ("zero.toml", "time_step_s = 0.0\n", "time_step_s"),
        ("nan.toml", "friction = nan\n", "friction"),
        ("step.toml", "time_step_s = 0.0003\n", "time_step_s"),
        ("broken.toml", "foot_mass_kg 2.0\n", "foot_mass_kg"),
    ];
    for (name, content, key) in cases {
        place.write(name, content);
        place.refused(&format!("evaluate --body {name}"), &[name, key]);
    }
    place.refused("evaluate --body absent.toml", &["absent.toml"]);
}

#[test]
fn a_bad_profile_is_refused() {
    let place = Place::new();
    let cases: [(&str, &[u8], &str); 9] = [
        ("empty.csv", b"", "time_s"),
        ("header.csv", b"time_s,omega_v\n", "no data"),
        ("column.csv", b"time_s,command\n0,1\n", "omega_v"),
        ("word.csv", b"time_s,omega_v\n0,1\n1,fast\n", "line 3"),
        ("nan.csv", b"time_s,omega_v\n0,nan\n", "line 2"),
        ("order.csv", b"time_s,omega_v\n1,0\n0,3\n", "line 3"),
        ("short.csv", b"time_s,omega_v\n0\n", "omega_v"),
        ("binary.csv", b"\xff\xfe\x00\x01", "time_s"),
        (
            "large.csv",
            b"time_s,omega_v\n0,1e9\n",
            "between -100 and 100",
        ),
    ];
    for (name, content, word) in cases {
        place.write(name, content);
        place.refused(&format!("evaluate --command-profile {name}"), &[name, word]);
    }
    place.refused("evaluate --command-profile absent.csv", &["absent.csv"]);
}

#[test]
fn several_starts_are_told_with_mean_spread_and_falls() {
    let place = Place::new();
    let evaluate = "evaluate --omega-v 0:3:3 --duration-s 3 --seed 1..3";
    let value = place.json(&format!("{evaluate} --json"));
    let rows = rows(&value);
    let seeds: Vec<u64> = rows
        .iter()
        .map(|row| row["seed"].as_u64().unwrap())
        .collect();
    assert_eq!(seeds, [1, 2, 3, 1, 2, 3]);
    let spread = value["spread"].as_array().unwrap();
    assert_eq!(spread.len(), 2);
    for (k, command) in spread.iter().enumerate() {
        let own = &rows[3 * k..3 * k + 3];
        assert_eq!(command["omega_v"], own[0]["omega_v"]);
        assert_eq!(command["motions"], 3);
        let fell = own.iter().filter(|row| row["fell"] == true).count();
        assert_eq!(command["falls"], fell);
        let gaits: u64 = command["gaits"]
            .as_object()
            .unwrap()
            .values()
            .map(|n| n.as_u64().unwrap())
            .sum();
        assert_eq!(gaits, 3);
        let upright = own.iter().filter(|row| row["fell"] == false);
        let speeds: Vec<f64> = upright
            .map(|row| row["speed_m_per_s"].as_f64().unwrap())
            .collect();
        let count = speeds.len() as f64;
        let mean = speeds.iter().sum::<f64>() / count;
        let squares: f64 = speeds.iter().map(|v| (v - mean).powi(2)).sum();
        let near = |value: &Value, expected: f64| {
            assert!((value.as_f64().unwrap() - expected).abs() < 1e-12)
        };
        near(&command["speed_m_per_s"]["mean"], mean);
        near(
            &command["speed_m_per_s"]["sd"],
            (squares / (count - 1.0)).sqrt(),
        );
    }
    let text = place.stdout(&format!("{evaluate} --out out"));
    assert!(
        text.contains("3 random starts") && text.contains("of 3") && text.contains('±'),
        "{text}"
    );
    for name in ["omega_v_0_seed_1.csv", "omega_v_3_seed_3.csv", "sweep.svg"] {
        assert!(place.path("out").join(name).exists(), "{name}");
    }
    // The start is the one that the seed alone draws.
    let one = place.json("evaluate --omega-v 3 --duration-s 3 --seed 2 --json");
    assert_eq!(self::rows(&one)[0], rows[4]);
    // It was given only where there are several.
    assert_eq!(rows[4]["seed"], 2);
    let default = place.json("evaluate --omega-v 3 --duration-s 1 --json");
    assert!(
        self::rows(&default)[0]
            .get("seed")
            .is_some_and(Value::is_null)
    );
}

#[test]
fn ranges_include_both_ends() {
    let place = Place::new();
    let value = place.json("evaluate --omega-v 1:1.3:0.1,-0.5,3:2:-0.5 --duration-s 0.5 --json");
    let commands: Vec<f64> = rows(&value)
        .iter()
        .map(|row| row["omega_v"].as_f64().unwrap())
        .collect();
    assert_eq!(commands, [1.0, 1.1, 1.2, 1.3, -0.5, 3.0, 2.5, 2.0]);
    for bad in [
        "0:1",
        "0:1:0",
        "0:1:-1",
        "0:1:0.0001",
        "0:200:1",
        "a:1:1",
        "0:1:1:1",
    ] {
        place.refused(&format!("evaluate --omega-v {bad}"), &["--omega-v"]);
    }
    for bad in ["3..1", "a", "-1", "1..a", "1..100000"] {
        place.refused(&format!("evaluate --seed={bad}"), &["--seed"]);
    }
}

// The heading spoke of 5 s where the part described began elsewhere.
#[test]
fn the_heading_says_where_the_figures_begin() {
    let place = Place::new();
    let heading = |options: &str| {
        place
            .stdout(&format!("evaluate --omega-v 0 {options}"))
            .lines()
            .next()
            .unwrap()
            .to_owned()
    };
    assert!(heading("--duration-s 12").ends_with("measured from 5 s on"));
    assert!(heading("--duration-s 4").ends_with("measured from 2 s on, the middle of the motion"));
    assert!(heading("--duration-s 4 --settling-s 1").ends_with("measured from 1 s on"));
}

// A good walk was "mixed" if it was short, without a word.
#[test]
fn a_motion_too_short_to_have_a_gait_says_so() {
    let place = Place::new();
    let text = place.stdout("evaluate --omega-v 0 --duration-s 3");
    assert!(
        text.contains("ω_v 0: ") && text.contains("too few to tell a gait, which takes 4"),
        "{text}"
    );
    assert!(!place.stdout("evaluate --omega-v 0").contains("too few"));
    let text = place.stdout("transition --start-s 2 --after-s 8 --out change");
    assert!(
        text.contains("before: ") && text.contains("too few to tell a gait"),
        "{text}"
    );
    assert!(!place.stdout("transition --out change").contains("too few"));
    // Where a table sums up several, nothing was said.
    for command in ["evaluate --seed 1..2", "compare shipped robust"] {
        let text = place.stdout(&format!("{command} --omega-v 0 --duration-s 3"));
        assert!(
            text.contains("2 of 2 motions tell no gait") && text.contains("too few"),
            "{text}"
        );
    }
    let text = place.stdout("evaluate --omega-v 0 --set task.control_period_s=1 --duration-s 0.1");
    assert!(text.contains("nothing is left to measure"), "{text}");
}

// A body that was changed was described under the same heading as the controller's own.
#[test]
fn the_heading_says_what_was_changed() {
    let place = Place::new();
    place.write("ice.toml", "friction = 0.6\n");
    let text = place.stdout(
        "evaluate --omega-v 0 --duration-s 1 --body ice.toml --set foot_mass_kg=2 --push 10@0.5",
    );
    let heading = text.lines().next().unwrap();
    assert!(
        heading.contains("default start, body of ice.toml, foot_mass_kg=2, push of 10 N"),
        "{heading}"
    );
}

// The best cost of a comparison was that of a body that fell.
#[test]
fn of_a_motion_that_fell_the_table_has_the_gait_and_the_time() {
    let text = Place::new()
        .stdout("evaluate --omega-v 0 --duration-s 4 --set task.termination.min_hip_height_m=0.79");
    let row = text.lines().find(|line| line.contains("fallen")).unwrap();
    let cells: Vec<&str> = row.split_whitespace().collect();
    assert_eq!(cells[3..], ["-"; 8], "{row}");
}

#[test]
fn single_values_of_body_and_task_can_be_set() {
    let place = Place::new();
    place.write("ice.toml", "[body]\nfriction = 0.6\n");
    let evaluate = "evaluate --omega-v 0 --duration-s 2 --json";
    let file = place.json(&format!("{evaluate} --body ice.toml"));
    assert_eq!(file, place.json(&format!("{evaluate} --set friction=0.6")));
    assert_ne!(file, place.json(evaluate));
    let strict = place.json(&format!(
        "{evaluate} --set task.termination.min_hip_height_m=0.79"
    ));
    assert_eq!(rows(&strict)[0]["fell"], true);
    place.refused(
        "evaluate --set frction=0.6",
        &["frction", "did you mean `friction`?"],
    );
    place.refused("evaluate --set friction", &["KEY=VALUE"]);
    // The answer was a list of all keys of the body.
    place.refused(
        "evaluate --set learner.gamma=1",
        &["`learner`", "of training", "`task.KEY`"],
    );
    place.write("short.toml", "base = \"fast\"\n");
    place.refused("evaluate --body short.toml", &["short.toml", "[body]"]);
    place.refused(
        "evaluate --set task.control_period_s=0.00015",
        &["control_period_s"],
    );
}

// A leg of another length left the segments where they were, without a word.
#[test]
fn a_body_out_of_proportion_is_warned_of() {
    let output =
        Place::new().output("evaluate --omega-v 0 --duration-s 0.5 --set leg_length_m=0.85 --json");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(
        stderr.contains("warning: `leg_length_m` is 0.85"),
        "{stderr}"
    );
    serde_json::from_slice::<Value>(&output.stdout).unwrap();
}

#[test]
fn a_runs_folder_stands_for_its_best_controller() {
    let place = Place::new();
    let shipped = include_bytes!("../../gaitshift-experiment/controllers/biped.safetensors");
    std::fs::create_dir(place.path("run")).unwrap();
    place.write("run/controller.safetensors", shipped);
    let evaluate = "evaluate --omega-v 0 --duration-s 1 --json";
    let expected = place.json(evaluate);
    assert_eq!(
        expected,
        place.json(&format!("{evaluate} --controller run"))
    );
    std::fs::rename(
        place.path("run/controller.safetensors"),
        place.path("run/controller-last.safetensors"),
    )
    .unwrap();
    let output = place.output(&format!("{evaluate} --controller run/"));
    let value: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(expected, value);
    // It was taken for the best one without a word.
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(stderr.contains("run/: not evaluated yet"), "{stderr}");
    std::fs::create_dir(place.path("empty")).unwrap();
    place.refused("evaluate --controller empty", &["empty", "gaitshift train"]);
}

#[test]
fn a_disturbed_motion_says_what_disturbed_it() {
    let place = Place::new();
    let evaluate = "evaluate --omega-v 3 --duration-s 6 --json";
    let row = |options: &str| place.json(&format!("{evaluate} {options}"))["rows"][0].clone();
    let plain = row("");
    assert!(plain.get("disturbance").is_none());
    let pushed = row("--push 60:-20@4+25%,50ms --latency 2ms --weak right=0.9 --noise phi=0.01");
    assert_ne!(pushed["speed_m_per_s"], plain["speed_m_per_s"]);
    let applied = &pushed["disturbance"];
    let push = &applied["pushes"][0];
    assert_eq!(
        (&push["forward_n"], &push["up_n"]),
        (&json!(60.0), &json!(-20.0))
    );
    assert!(push["start_s"].as_f64().unwrap() > 4.0 && push["duration_s"] == 0.05);
    assert_eq!(applied["latency_s"], 0.002);
    assert_eq!(applied["actuator_factor"], json!([0.9, 1.0]));
    assert_eq!(applied["noise"]["phi_rad"], 0.01);
    // The same from a file, with an option over it.
    place.write(
        "d.toml",
        "latency_s = 0.5\nactuator_factor = [0.9, 1.0]\nnoise = { phi_rad = 0.01 }\n[[pushes]]\nforward_n = 60\nup_n = -20\n\
         start_s = 4\nphase = 0.25\nduration_s = 0.05\n",
    );
    assert_eq!(row("--disturbance d.toml --latency 0.002"), pushed);
}

/// What the first line of a recording says.
fn header(place: &Place, recording: &str) -> Value {
    let text = String::from_utf8(place.read(recording)).unwrap();
    let line = text.lines().next().unwrap();
    serde_json::from_str(&line[line.find('{').unwrap()..]).unwrap()
}

#[test]
fn the_ground_is_in_the_header_of_the_recording() {
    let place = Place::new();
    place.stdout("evaluate --omega-v 3 --duration-s 3 --slope 2deg@1 --step-down 2cm@2 --out out");
    let metadata = header(&place, "out/omega_v_3.csv");
    assert_eq!(metadata["ground"][1], json!([1.0, 0.0]));
    let steps = &metadata["disturbance"]["terrain"]["steps"];
    assert_eq!(steps[0], json!({"height_m": -0.02, "at_m": 2.0}));
    // What reads recordings reads these.
    place.stdout("analyse out/omega_v_3.csv");
}

// Nothing tried a motion on it.
#[test]
fn uneven_ground_moves_the_feet_and_its_seed_makes_it() {
    let place = Place::new();
    let row = |options: &str| {
        let value = place.json(&format!(
            "evaluate --omega-v 3 --duration-s 4 --json {options}"
        ));
        value["rows"][0].clone()
    };
    let flat = row("");
    let uneven = row("--uneven 1cm");
    let terrain = &uneven["disturbance"]["terrain"]["uneven"];
    assert_eq!(terrain["height_m"], 0.01, "{uneven}");
    assert_ne!(uneven["speed_m_per_s"], flat["speed_m_per_s"]);
    assert_eq!(uneven, row("--uneven 1cm"));
    place.stdout("evaluate --omega-v 3 --duration-s 4 --uneven 1cm --out out");
    let metadata = header(&place, "out/omega_v_3.csv");
    let ground = metadata["ground"].as_array().unwrap();
    let heights = ground.iter().map(|point| point[1].as_f64().unwrap());
    let (low, high) = heights.fold((0.0_f64, 0.0_f64), |(low, high), h| {
        (low.min(h), high.max(h))
    });
    assert!(low < -0.003 && high > 0.003, "{low} {high}");
}

#[test]
fn disturbances_that_make_no_sense_are_refused_with_what_would() {
    let place = Place::new();
    place.write("bad.toml", "latency_s = 5\n");
    place.write("typo.toml", "[terrain]\nslop_rad = 0.1\n");
    for (options, words) in [
        ("--noise thta=1", &["theta"][..]),
        ("--noise theta", &["NAME=SD"]),
        ("--push 100", &["FORCE@START"]),
        ("--push 100@5+2", &["PHASE"]),
        ("--push 8Ns@5", &["give the force, here 80 for 0.1 s"]),
        ("--slope 3", &["3deg"]),
        ("--weak 2", &["from 0"]),
        ("--step-up 30", &["1 m"]),
        ("--latency 3", &["1 s"]),
        ("--disturbance bad.toml", &["bad.toml", "latency_s"]),
        (
            "--disturbance typo.toml",
            &["typo.toml", "did you mean `slope_rad`"],
        ),
        ("--criteria --latency 0.01", &["undisturbed"]),
    ] {
        place.refused(&format!("evaluate {options}"), words);
    }
}

// A table called both a fall; a push after the end was told as if it had come.
#[test]
fn what_diverged_and_what_never_came_is_said() {
    let place = Place::new();
    let said = |options: &str| {
        let output = place.output(&format!("evaluate --omega-v 3 --duration-s 2 {options}"));
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(said("--set time_step_s=0.01").contains("1 of 1 motion, counted as a fall, diverged"));
    assert!(said("--push 80@100").contains("the push at 100 s never came"));
    assert!(!said("--push 80@1").contains("never came"));
    // A clock that adds up its periods is a little late.
    let output = place.output("evaluate --omega-v 3 --duration-s 20.4 --push 80@20.4");
    assert!(String::from_utf8_lossy(&output.stderr).contains("never came"));
    // Its phase of the stride comes after the end; and one that ends the motion came.
    assert!(said("--push 80@1.9+0.9").contains("the push at 1.9 s never came"));
    // One that falls at 0.97 s was among the falls under a push.
    assert!(
        said("--seed 1..3 --push 8@1.5")
            .contains("1 of 3 motions ended before the push at 1.5 s, or before its phase of the stride: ω_v 3 from seed 3, which fell before")
    );
    let ended = said("--push 1e6@1");
    assert!(
        ended.contains("diverged: the disturbance") && !ended.contains("never came"),
        "{ended}"
    );
    let undefined = "task.reward.extra=[{name=\"u\",weight=1,expression=\"ln(1-time_s)\"}]";
    assert!(
        said(&format!("--set {undefined}")).contains("counted as a fall, ended because a reward")
    );
}

// A step that the walk does not get to was counted as withstood.
#[test]
fn ground_that_is_not_reached_is_said() {
    let place = Place::new();
    let said = |options: &str| {
        let output = place.output(&format!("evaluate --omega-v 0,3 --duration-s 4 {options}"));
        String::from_utf8(output.stderr).unwrap()
    };
    let words = "1 of 2 motions never reached the";
    for (option, what) in [
        ("--step-up 0.005@6", "step at 6 m: ω_v 0\n"),
        ("--slope 0.1%@6", "slope at 6 m: ω_v 0\n"),
    ] {
        assert!(
            said(option).contains(&format!("{words} {what}")),
            "{option}"
        );
    }
    assert!(!said("--step-up 0.005@1").contains("reached"));
    // It stands before a step that it touches; a fall comes before a step or after.
    let stands = place.json("evaluate --omega-v 0 --duration-s 15 --step-up 0.05 --json");
    let output = place.output("evaluate --omega-v 0 --duration-s 15 --step-up 0.05");
    assert!(stands["rows"][0]["reached_m"].as_f64().unwrap() < 3.0);
    assert!(output.status.success() && output.stderr.is_empty());
    assert!(
        said("--step-up 0.01@40 --push 900@2 --seed 3")
            .contains("ω_v 3 from seed 3, which fell before")
    );
    assert!(said("--step-up 0.01@40 --seed 1..4").contains("and so on"));
    let rows = place.json("evaluate --omega-v 3 --duration-s 4 --json");
    let reached_m = rows["rows"][0]["reached_m"].as_f64().unwrap();
    assert!((6.0..14.0).contains(&reached_m), "{reached_m}");
}

// A rule of one's own was told as a fall, or not at all; a motion too short to measure was measured from 5 s on.
#[test]
fn what_ended_a_motion_is_told_beside_the_table() {
    let place = Place::new();
    let rule = "task.termination.extra=[{name=\"leap\",expression=\"time_s>0.005\"}]";
    let output = place.output(&format!("evaluate --omega-v 0 --set {rule}"));
    let (said, table) = (output.stderr, output.stdout);
    assert!(String::from_utf8_lossy(&said).contains("ended by the rule `leap`"));
    let table = String::from_utf8_lossy(&table);
    assert!(
        table.contains("nothing measured") && !table.contains("from 5 s on"),
        "{table}"
    );
}

#[test]
fn slips_on_the_command_line_are_answered() {
    let place = Place::new();
    // Answered by `unexpected argument '-1' found`.
    for slip in [
        "--latency -1ms",
        "--uneven -1cm",
        "--step-up -3cm",
        "--step-down -3mm",
        "--weak -50%",
    ] {
        let option = slip.split(' ').next().unwrap();
        place.refused(&format!("evaluate {slip}"), &[option, "invalid value"]);
    }
    place.refused("evaluate --omega-v 0..3", &["FIRST:LAST:STEP"]);
    // It was told to go behind `--`, where it was taken as a controller.
    let output = place.output("compare shipped --push 80@5");
    assert!(!String::from_utf8_lossy(&output.stderr).contains("tip"));
    let output = place.output("export mjcf --push 10@3");
    assert!(String::from_utf8_lossy(&output.stderr).contains("tip: a model holds neither pushes"));
    place.write("my run.safetensors", "");
    let mut alone = place.command("evaluate");
    let output = alone.arg("my run.safetensors").output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("--controller 'my run.safetensors'"), "{said}");
    // It was told by the system's error and its number, and in most commands was no bad input.
    place.write("file", "");
    for command in [
        "evaluate --omega-v 0 --duration-s 1 --out file",
        "evaluate --omega-v 0 --duration-s 1 --out file/out",
        "harden --rounds 1 --out file",
        "reproduce --quick --out file",
        "export onnx --out file/policy.onnx",
        "train fast --out file",
        "train fast --out file/run",
        "train fast --seeds 1-2 --out file",
    ] {
        place.refused(command, &["a file is where a folder is to be", "--out"]);
    }
    std::fs::create_dir_all(place.path("out/omega_v_0.csv")).unwrap();
    std::fs::create_dir_all(place.path("other/sweep.svg")).unwrap();
    for command in [
        "export onnx --out .",
        "evaluate --omega-v 0 --duration-s 1 --out out",
        "evaluate --omega-v 0 --duration-s 1 --out other",
    ] {
        place.refused(
            command,
            &["is a folder", "remove it, or give another --out"],
        );
    }
}

// Motions that fell before the change had a row of their own, and the others no falls.
#[test]
fn under_a_profile_all_starts_are_one_row() {
    let place = Place::new();
    place.write("p.csv", "time_s,omega_v\n6,0\n6.4,3\n");
    let evaluate = "evaluate --command-profile p.csv --seed 1..6 --slope 4deg@3 --settling-s 7";
    let value = place.json(&format!("{evaluate} --duration-s 14 --json"));
    let spread = value["spread"].as_array().unwrap();
    let falls = rows(&value)
        .iter()
        .filter(|row| row["fell"] == true)
        .count();
    assert_eq!(spread.len(), 1);
    assert_eq!(spread[0]["falls"], falls);
    assert!((1..6).contains(&falls), "{falls}");
    // A change that never comes was not spoken of.
    let output = place.output("evaluate --command-profile p.csv --duration-s 5");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        said.contains("p.csv") && said.contains("--duration-s"),
        "{said}"
    );
}

// It was replaced by the recording, whose name is that of the help's example.
#[test]
fn a_profile_is_not_written_over() {
    let place = Place::new();
    let profile = "time_s,omega_v\n1,0\n2,3\n";
    place.write("profile.csv", profile);
    let words = &["profile.csv", "written over", "--out"];
    place.refused("evaluate --command-profile profile.csv --out .", words);
    place.write("profile_seed_2.csv", profile);
    place.refused(
        "evaluate --command-profile profile_seed_2.csv --seed 1,2 --out .",
        &["profile_seed_2.csv", "written over"],
    );
    place.write("recording.csv", profile);
    place.refused(
        "transition --command-profile recording.csv --out .",
        words[1..].as_ref(),
    );
    assert_eq!(place.read("profile.csv"), profile.as_bytes());
    assert_eq!(place.read("recording.csv"), profile.as_bytes());
}

// Each was checked as soon as it was read, so that neither could come first.
#[test]
fn values_that_depend_on_each_other_are_changed_together() {
    let place = Place::new();
    let (step, period) = (
        "--set time_step_s=0.0003",
        "--set task.control_period_s=0.0033",
    );
    let evaluate = "evaluate --omega-v 0 --duration-s 1 --json";
    let row = place.json(&format!("{evaluate} {step} {period}"));
    assert_eq!(row, place.json(&format!("{evaluate} {period} {step}")));
    place.refused(
        &format!("{evaluate} {period}"),
        &["control_period_s", "time_step_s"],
    );
    place.write("step.toml", "time_step_s = 0.0003\n");
    assert_eq!(
        row,
        place.json(&format!("{evaluate} --body step.toml {period}"))
    );
    place.refused(
        &format!("{evaluate} --body step.toml"),
        &["step.toml", "time_step_s"],
    );
}

// The second line was dropped.
#[test]
fn a_value_is_one_line() {
    let place = Place::new();
    let output = place
        .command("evaluate --omega-v 0 --duration-s 1")
        .args(["--set", "friction=0.6\nfoot_mass_kg=9"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("friction"));
}

// It was measured, and then its recording could not be written.
#[test]
fn a_motion_without_gravity_is_recorded() {
    let place = Place::new();
    place.stdout("evaluate --omega-v 0 --duration-s 1 --set gravity_m_per_s2=0 --out out");
    let rows = place.json("analyse out/omega_v_0.csv --json");
    assert!(rows["rows"][0]["froude"].is_null(), "{rows}");
}

#[test]
fn a_command_is_measured_once() {
    let place = Place::new();
    place.refused("evaluate --omega-v 0,1,0", &["command 0 is given twice"]);
    place.refused("stress --omega-v 3,2:3:1", &["command 3 is given twice"]);
    place.refused("evaluate --seed -1", &["`-1` is not a whole number"]);
}

// The remedy was about paths and permissions.
#[test]
fn what_is_no_text_and_no_file_is_refused_with_what_would_do() {
    let place = Place::new();
    place.write("latin.toml", b"[body]\n# Gr\xf6\xdfe\nfriction = 0.6\n");
    place.refused(
        "evaluate --body latin.toml",
        &["latin.toml", "line 2", "UTF-8"],
    );
    std::fs::create_dir(place.path("folder")).unwrap();
    place.refused("evaluate --criteria folder", &["folder", "give a file"]);
}
