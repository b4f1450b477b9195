//! Contract: `report` and `reproduce` refuse what they cannot use with one error, before they measure anything. What they write is
//! tested in gaitshift-report.

mod common;
use common::Place;

#[test]
fn what_cannot_be_reported_on_is_one_error() {
    let place = Place::new();
    place.refused("report no-such-run", &["no-such-run"]);
    place.refused("report --quick", &["RUN|FILE|NAME"]);
    place.refused("reproduce --quick --dry-run", &["--dry-run"]);
    // Said at once, not after a minute of measuring.
    place.write("file", "");
    let output = place.output("report --quick shipped --out file");
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(error.contains("file") && error.contains("--out"), "{error}");
    assert!(!error.contains("steady motions"), "{error}");
}
