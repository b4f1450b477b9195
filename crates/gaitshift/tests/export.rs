//! Contract: `gaitshift export` writes body, controller and recording to a file or to standard output, the
//! same bytes either way, and refuses what it cannot read with one error that names it.

use crate::common;
use crate::common::Place;
use gaitshift_experiment::Controller;
use gaitshift_task::Disturbance;
use std::path::Path;

#[test]
fn every_format_goes_to_a_file_or_to_standard_output() {
    let place = Place::new();
    place.write_toy_recording("toy.csv");
    for (format, begins) in [
        ("mjcf", &b"<!-- "[..]),
        ("onnx", b"\x08\x08"),
        ("csv toy.csv", b"# gaitshift-recording 1 "),
        ("npz toy.csv", b"PK\x03\x04"),
    ] {
        let printed = place.output(&format!("export {format}"));
        assert_eq!(printed.status.code(), Some(0), "{format}");
        assert!(printed.stdout.starts_with(begins), "{format}");
        assert_eq!(
            place.stdout(&format!("export {format} -o out")),
            "wrote out\n"
        );
        assert_eq!(place.read("out"), printed.stdout, "{format}");
    }
    assert_eq!(
        place.output("export csv toy.csv").stdout,
        place.read("toy.csv")
    );
}

#[test]
fn the_body_is_the_one_asked_for() {
    let place = Place::new();
    place.write("ice.toml", "friction = 0.125\n");
    let text = place.stdout("export mjcf --body ice.toml");
    assert!(text.contains("friction=\"0.125 0 0\""));
    assert_ne!(text, place.stdout("export mjcf"));
}

// It was the default body, whose hip has its mass 0.05 m higher: the shipped policy fell on it where it should run.
#[test]
fn the_body_is_that_of_the_policy() {
    let place = Place::new();
    let text = place.stdout("export mjcf");
    assert!(text.contains("pos=\"0 0 -0.05\""), "{text}");
    let shipped = Controller::shipped().unwrap();
    assert_eq!(
        text,
        gaitshift_export::mjcf(&shipped.body, &shipped.task, &Disturbance::default()).unwrap()
    );
    let robust = Controller::read(Path::new("robust")).unwrap();
    assert_eq!(
        place.stdout("export mjcf --controller robust"),
        gaitshift_export::mjcf(&robust.body, &robust.task, &Disturbance::default()).unwrap()
    );
    // What --body and --set leave out is the controller's too.
    place.write("ice.toml", "friction = 0.125\n");
    for changed in ["--body ice.toml", "--set friction=0.125"] {
        let text = place.stdout(&format!("export mjcf {changed}"));
        assert!(text.contains("pos=\"0 0 -0.05\""), "{changed}: {text}");
    }
}

#[test]
fn the_ground_is_the_one_asked_for() {
    let place = Place::new();
    let flat = place.stdout("export mjcf");
    assert!(flat.contains("name=\"ground\" type=\"plane\""));
    let hill_options = "export mjcf --slope 0.1rad@2 --step-up 0.03 --step-down 0.02@5";
    let hill = place.stdout(hill_options);
    assert_ne!(hill, flat);
    // Flat, the slope, and the same raised and lowered.
    assert!(hill.contains("ground_3") && hill.contains("type=\"box\""));
    let tilted = place.stdout("export mjcf --slope 0.1rad");
    assert!(tilted.contains("type=\"plane\"") && tilted.contains("euler=\"0 -0.1"));
    let file = "[terrain]\nslope_rad = 0.1\nslope_from_m = 2\n\
                steps = [{ height_m = 0.03, at_m = 3 }, { height_m = -0.02, at_m = 5 }]\n";
    place.write("hill.toml", file);
    assert_eq!(place.stdout("export mjcf --disturbance hill.toml"), hill);
    // What MJCF can say of actuators it says; it has no noise and no pushes.
    place.write(
        "late.toml",
        format!("latency_s = 0.01\nactuator_factor = [0.5, 1]\n{file}"),
    );
    let late = place.stdout("export mjcf --disturbance late.toml");
    assert!(late.contains("gear=\"300.0\"") && late.contains("nsample=\"50\""));
    let hill = hill_options.to_owned() + " --weak right=0.5 --latency 10ms";
    assert_eq!(place.stdout(&hill), late);
    for refused in [
        "noise = { theta_rad = 0.1 }",
        "pushes = [{ forward_n = 9 }]",
    ] {
        place.write("noisy.toml", refused);
        place.refused(
            "export mjcf --disturbance noisy.toml",
            &["noisy.toml", "MuJoCo applies no `noise` or `pushes`"],
        );
    }
    place.refused("export mjcf --slope 2rad", &["slope"]);
}

#[test]
fn what_cannot_be_exported_is_refused() {
    let place = Place::new();
    place.write("bad.toml", "frction = 0.5\n");
    place.write("bad.csv", "time_s\n0\n");
    place.refused("export mjcf --body bad.toml", &["bad.toml", "frction"]);
    place.refused("export mjcf --body no.toml", &["no.toml"]);
    place.refused("export onnx --controller bad.csv", &["bad.csv"]);
    place.refused("export npz bad.csv", &["bad.csv"]);
    place.refused("export csv no.csv", &["no.csv"]);
    place.refused("export gltf", &["gltf"]);
    place.write("file", "");
    place.refused("export mjcf -o file/biped.xml", &["file", "--out"]);
}

#[test]
fn what_is_read_is_not_written_over() {
    let place = Place::new();
    place.write_toy_recording("toy.csv");
    let toy = place.read("toy.csv");
    for format in ["csv", "npz", "html"] {
        place.refused(
            &format!("export {format} toy.csv -o toy.csv"),
            &["toy.csv", "written over"],
        );
    }
    assert_eq!(place.read("toy.csv"), toy);
    place.write(
        "c.safetensors",
        Controller::shipped().unwrap().to_bytes().unwrap(),
    );
    place.write("b.toml", "friction = 0.5\n");
    place.write("d.toml", "latency_s = 0.01\n");
    for (command, over) in [
        ("onnx --controller c.safetensors", "c.safetensors"),
        ("mjcf --controller c.safetensors", "c.safetensors"),
        ("mjcf --body b.toml", "b.toml"),
        ("mjcf --disturbance d.toml", "d.toml"),
    ] {
        let before = place.read(over);
        place.refused(
            &format!("export {command} -o {over}"),
            &[over, "written over"],
        );
        assert_eq!(place.read(over), before, "{command}");
    }
    Controller::read(&place.path("c.safetensors")).unwrap();
}

// The best controller of a run was replaced, and a card put beside its logs.
#[test]
fn a_run_is_no_folder_for_a_hub() {
    let place = Place::new();
    place.write("tiny.toml", common::TINY);
    place.stdout("train tiny.toml --steps 1000 --out run");
    for controller in ["run", "shipped"] {
        place.refused(
            &format!("export hub --controller {controller} --out run"),
            &["run is a run's folder", "another --out"],
        );
    }
    assert!(!place.path("run/README.md").exists());
    for name in ["state.safetensors", "rounds.jsonl"] {
        std::fs::create_dir_all(place.path("hard")).unwrap();
        place.write(&format!("hard/{name}"), "");
    }
    place.refused(
        "export hub --out hard",
        &["hard is a hardening's folder", "another --out"],
    );
    std::fs::create_dir(place.path("mine")).unwrap();
    let file = "mine/controller.safetensors";
    place.write(file, Controller::shipped().unwrap().to_bytes().unwrap());
    place.refused(
        &format!("export hub --controller {file} --out mine"),
        &[file, "written over"],
    );
}

// Every other command made the folder of what it wrote.
#[test]
fn the_folder_is_made() {
    let place = Place::new();
    place.write_toy_recording("toy.csv");
    for (format, path) in [
        ("mjcf", "a/b/biped.xml"),
        ("onnx", "c/policy.onnx"),
        ("csv toy.csv", "d/e/toy.csv"),
        ("npz toy.csv", "f/toy.npz"),
    ] {
        place.stdout(&format!("export {format} --out {path}"));
        assert!(!place.read(path).is_empty(), "{path}");
    }
}
