//! `gaitshift transition`: the JSON that other programs rely on, ramps and profiles, the files written.

use crate::common::Place;
use gaitshift_analysis::Recording;
use gaitshift_analysis::recording::column;

#[test]
fn json_has_the_promised_fields_and_writes_no_file() {
    let place = Place::new();
    let value = place.json("transition --from 0 --to 3 --ramp-s 0.4 --json");
    let object = value.as_object().unwrap();
    assert!(value["survived"].is_boolean());
    for gait in ["gait_before", "gait_after"] {
        let gaits = ["standing", "walking", "running", "mixed", "fallen"];
        assert!(gaits.contains(&value[gait].as_str().unwrap()), "{value}");
    }
    for field in [
        "speed_before_m_per_s",
        "speed_after_m_per_s",
        "steps_to_change",
        "kinetic_potential_correlation_before",
        "kinetic_potential_correlation_after",
    ] {
        let value = object.get(field).unwrap_or_else(|| panic!("no {field}"));
        assert!(value.is_number() || value.is_null(), "{field}: {value}");
    }
    assert_eq!(value["ramp_start_s"], 10.0);
    assert_eq!(value["ramp_end_s"], 10.4);
    let survived_s = value["survived_s"].as_f64().unwrap();
    assert_eq!(value["survived"], (survived_s - 20.4).abs() < 1e-9);
    assert_eq!(std::fs::read_dir(place.path("")).unwrap().count(), 0);
}

// Options that disturb were only in its help.
#[test]
fn a_disturbed_change_says_what_disturbed_it_and_is_another_motion() {
    let place = Place::new();
    let change = "transition --start-s 3 --ramp-s 0.4 --after-s 3 --controller robust --json";
    let undisturbed = place.json(change);
    assert!(undisturbed.get("disturbance").is_none_or(|d| d.is_null()));
    place.write("late.toml", "latency_s = 0.01\n");
    for options in [
        "--push 100@4",
        "--push 100@4+0.5",
        "--slope 1deg@1",
        "--step-up 1cm@6",
        "--step-down 1cm@6",
        "--uneven 5mm",
        "--latency 10ms",
        "--weak 0.95",
        "--noise theta=0.02",
        "--disturbance late.toml",
    ] {
        let disturbed = place.json(&format!("{change} {options}"));
        assert!(
            disturbed["disturbance"].is_object(),
            "{options}: {disturbed}"
        );
        assert_ne!(
            disturbed["speed_after_m_per_s"], undisturbed["speed_after_m_per_s"],
            "{options}"
        );
    }
}

#[test]
fn without_json_it_writes_the_figure_and_the_recording() {
    let place = Place::new();
    let text = place.stdout("transition --start-s 0.3 --ramp-s 0.2 --after-s 1");
    for name in ["transition.svg", "transition.png", "recording.csv"] {
        let path = format!("out/transition/{name}");
        assert!(text.contains(&path), "{text}");
    }
    assert!(
        place
            .read("out/transition/transition.svg")
            .starts_with(b"<svg")
    );
    assert!(
        place
            .read("out/transition/transition.png")
            .starts_with(b"\x89PNG")
    );
    let recording = Recording::read_csv(place.path("out/transition/recording.csv")).unwrap();
    let times = recording.column(column::TIME_S);
    let commands = recording.column(column::OMEGA_V);
    let period_s = times[1] - times[0];
    for (&time_s, &command) in times.iter().zip(commands).skip(1) {
        // A row holds the command of the period that ends there.
        let expected = 3.0 * ((time_s - period_s - 0.3) / 0.2).clamp(0.0, 1.0);
        assert!((command - expected).abs() < 1e-9, "{command} at {time_s} s");
    }
}

#[test]
fn with_json_files_go_into_a_folder_that_is_named() {
    let place = Place::new();
    place.json("transition --start-s 0.2 --ramp-s 0 --after-s 1 --json --out here");
    assert!(place.path("here/recording.csv").exists());
    assert!(place.path("here/transition.svg").exists());
}

#[test]
fn commands_below_zero_are_commands() {
    let place = Place::new();
    let value =
        place.json("transition --from -0.5 --to -0.1 --start-s 0.5 --after-s 0.5 --json --out o");
    assert!(value.is_object());
    let recording = Recording::read_csv(place.path("o/recording.csv")).unwrap();
    assert_eq!(recording.column(column::OMEGA_V)[0], -0.5);
}

#[test]
fn a_profile_can_say_what_the_options_say() {
    let place = Place::new();
    place.write("ramp.csv", "# a ramp\ntime_s,omega_v\n0,0\n2,0\n2.4,3\n");
    let profile = place.json("transition --command-profile ramp.csv --after-s 2 --json");
    let options = place.json("transition --start-s 2 --ramp-s 0.4 --after-s 2 --json");
    assert_eq!(profile, options);
}

#[test]
fn from_the_first_change_to_the_last_is_the_ramp() {
    let place = Place::new();
    place.write("trip.csv", "time_s,omega_v\n1,0\n2,3\n4,3\n5,0\n6,0\n");
    let value = place.json("transition --command-profile trip.csv --after-s 1 --json");
    assert_eq!(value["ramp_start_s"], 1.0);
    assert_eq!(value["ramp_end_s"], 5.0);
}

// A profile that goes up and down again had no number of steps at all.
#[test]
fn each_change_of_a_profile_has_its_steps() {
    let place = Place::new();
    place.write("trip.csv", "time_s,omega_v\n10,0\n10.4,3\n20,3\n20.4,0\n");
    let transition = "transition --command-profile trip.csv --after-s 10";
    let value = place.json(&format!("{transition} --json"));
    assert!(value["steps_to_change"].is_null());
    let changes = value["changes"].as_array().unwrap();
    for (change, (start_s, before, after)) in changes
        .iter()
        .zip([(10.0, "walking", "running"), (20.0, "running", "walking")])
    {
        assert_eq!(change["start_s"], start_s);
        assert_eq!(change["gait_before"], before);
        assert_eq!(change["gait_after"], after);
        assert!((1..20).contains(&change["steps_to_change"].as_u64().unwrap()));
    }
    assert_eq!(changes.len(), 2);
    let text = place.stdout(transition);
    assert!(
        text.contains("from 20 s on    running → walking, changed"),
        "{text}"
    );
}

// What was "before" a command that changes from the start on was made up.
#[test]
fn before_a_change_from_the_start_on_there_is_no_gait() {
    let place = Place::new();
    place.write("sweep.csv", "time_s,omega_v\n0,0\n2,3\n");
    let transition = "transition --command-profile sweep.csv --after-s 1";
    let value = place.json(&format!("{transition} --json"));
    assert!(value["gait_before"].is_null(), "{value}");
    assert!(value["gait_after"].is_string(), "{value}");
    let text = place.stdout(transition);
    assert!(text.contains("gait            - → "), "{text}");
}

#[test]
fn a_profile_without_a_change_is_refused() {
    let place = Place::new();
    place.write("flat.csv", "time_s,omega_v\n0,1\n5,1\n");
    place.refused(
        "transition --command-profile flat.csv",
        &["flat.csv", "never changes", "gaitshift evaluate"],
    );
    place.refused("transition --command-profile absent.csv", &["absent.csv"]);
    // A change before the motion was reported as one that had come.
    place.write("past.csv", "time_s,omega_v\n-5,0\n-2,3\n");
    place.refused(
        "transition --command-profile past.csv",
        &["past.csv", "before the motion"],
    );
}

#[test]
fn a_seed_and_a_body_change_the_motion() {
    let place = Place::new();
    place.write("light.toml", "hip_mass_kg = 10.0\n");
    let transition = "transition --start-s 1 --after-s 1 --json";
    let plain = place.json(transition);
    assert_eq!(plain, place.json(transition));
    assert_ne!(plain, place.json(&format!("{transition} --seed 3")));
    assert_ne!(
        plain,
        place.json(&format!("{transition} --body light.toml"))
    );
}

// A simulation that diverged could not be told from a fall.
#[test]
fn what_ended_the_motion_is_told() {
    let place = Place::new();
    let transition = "transition --start-s 1 --after-s 1 --json";
    assert_eq!(place.json(transition)["ended_by"], "time limit");
    let output = place.output(&format!("{transition} --set time_step_s=0.01"));
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(value["ended_by"], "diverged");
    assert!(String::from_utf8_lossy(&output.stderr).contains("counted as a fall, diverged"));
    let rule = "task.termination.extra=[{name=\"late\",expression=\"time_s>1.5\"}]";
    let text = place.stdout(&format!("transition --start-s 1 --after-s 1 --set {rule}"));
    assert!(text.contains("s by `late`"), "{text}");
    place.refused("transition --seed 1..3", &["--seed", "whole number"]);
    let text = place.output("transition --start-s 1 --after-s 1 --set time_step_s=0.01");
    let text = String::from_utf8_lossy(&text.stdout).into_owned();
    assert!(
        text.contains("diverged at") && !text.contains("fell at"),
        "{text}"
    );
}
