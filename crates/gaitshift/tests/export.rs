//! Contract: `gaitshift export` writes body, controller and recording to a file or to standard output, the
//! same bytes either way, and refuses what it cannot read with one error that names it.

mod common;
use common::Place;

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
        assert_eq!(place.stdout(&format!("export {format} -o out")), "");
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

#[test]
fn the_ground_is_the_one_asked_for() {
    let place = Place::new();
    let flat = place.stdout("export mjcf");
    assert!(flat.contains("name=\"ground\" type=\"plane\""));
    let hill = place.stdout("export mjcf --slope 0.1rad@2 --step-up 0.03 --step-down 0.02@5");
    assert_ne!(hill, flat);
    // Flat, the slope, and the same raised and lowered.
    assert!(hill.contains("ground_3") && hill.contains("type=\"box\""));
    let tilted = place.stdout("export mjcf --slope 0.1rad");
    assert!(tilted.contains("type=\"plane\"") && tilted.contains("euler=\"0 -0.1"));
    let file = "[terrain]\nslope_rad = 0.1\nslope_from_m = 2\n\
                steps = [{ height_m = 0.03, at_m = 3 }, { height_m = -0.02, at_m = 5 }]\n";
    place.write("hill.toml", file);
    assert_eq!(place.stdout("export mjcf --disturbance hill.toml"), hill);
    place.write("late.toml", format!("latency_s = 0.01\n{file}"));
    place.refused(
        "export mjcf --disturbance late.toml",
        &["late.toml", "terrain"],
    );
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
    let output = place.output("export mjcf -o file/biped.xml");
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("file"));
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
