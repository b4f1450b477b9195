//! Standard output belongs to results; a reader that stops reading is no error.

use crate::common::Place;
use std::process::Stdio;

#[test]
fn a_closed_pipe_ends_the_program_quietly() {
    let place = Place::new();
    for arguments in [
        "evaluate --omega-v 0 --duration-s 1",
        "evaluate --omega-v 0 --duration-s 1 --json",
        "transition --start-s 1 --after-s 1 --json",
    ] {
        let mut child = place
            .command(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(stderr, "", "{arguments}");
        assert_eq!(output.status.code(), Some(0), "{arguments}");
    }
}

// With its reader gone, files were missing and the answer was always yes.
#[test]
fn what_was_begun_is_finished_without_a_reader() {
    let place = Place::new();
    let code = |arguments: &str| {
        let mut child = place
            .command(arguments)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        child.wait().unwrap().code()
    };
    assert_eq!(
        code("evaluate --omega-v 0 --duration-s 1 --out out"),
        Some(0)
    );
    assert!(place.path("out/omega_v_0.csv").exists() && place.path("out/sweep.png").exists());
    place.write("stand.toml", "omega_v = [0]\nduration_s = 1\nchanges = []\ngaits = [{ omega_v = 0, gait = \"running\" }]\n");
    assert_eq!(code("evaluate --criteria stand.toml"), Some(1));
}

#[test]
fn json_stands_alone_on_standard_output() {
    let place = Place::new();
    for arguments in [
        "evaluate --omega-v 0,3 --duration-s 1 --json",
        "evaluate --omega-v 0 --duration-s 1 --json --out out",
        "transition --start-s 1 --after-s 1 --json --out out",
    ] {
        assert!(place.json(arguments).is_object(), "{arguments}");
        assert_eq!(place.stdout(arguments).lines().count(), 1, "{arguments}");
    }
}
