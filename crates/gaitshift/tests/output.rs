//! Standard output belongs to results; a reader that stops reading is no error.

mod common;
use common::Place;
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
