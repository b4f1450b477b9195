//! `gaitshift demo`: one command shows everything, whatever the controller can do.

use crate::common::Place;

#[test]
fn it_prints_the_table_and_writes_every_picture_it_names() {
    let place = Place::new();
    let text = place.stdout("demo --out seen");
    for word in ["Froude", "ω_v 0 → 3 in 0.4 s", "ω_v 3 → 0 in 0.4 s"] {
        assert!(text.contains(word), "{text}");
    }
    let written: Vec<&str> = text
        .lines()
        .filter_map(|line| line.strip_prefix("wrote "))
        .collect();
    for name in [
        "walk-run-walk.gif",
        "walk-to-run.svg",
        "run-to-walk.png",
        "sweep.svg",
    ] {
        assert!(written.contains(&format!("seen/{name}").as_str()), "{text}");
    }
    for name in written {
        let content = place.read(name);
        let starts: [&[u8]; 3] = [b"GIF89a", b"<svg", b"\x89PNG"];
        assert!(
            starts.iter().any(|start| content.starts_with(start)),
            "{name}"
        );
    }
}

#[test]
fn another_controller_has_to_be_one() {
    let place = Place::new();
    place.write("no.safetensors", "no");
    place.refused("demo --controller no.safetensors", &["no.safetensors"]);
    assert!(!place.path("out").exists());
}
