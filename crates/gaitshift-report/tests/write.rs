//! Contract: the same subjects give the same bytes; the page comes first; numbers stand in `report.json` and `claims.csv`; what
//! cannot be reported on is an error that says what to do.

mod common;
use common::{text, tiny, written};
use gaitshift_report::{ReportError, Subject, write_report};

#[test]
fn the_same_subject_gives_the_same_bytes() {
    let all = written(&mut [Subject::shipped().unwrap()]);
    let numbers: serde_json::Value = serde_json::from_slice(&all["report.json"]).unwrap();
    assert_eq!(numbers["format"], "gaitshift-report 1");
    let walk = &numbers["studies"][0]["steady"][0];
    assert_eq!(
        (&walk["omega_v"], &walk["gait"]),
        (&0.0.into(), &"walking".into())
    );
    let claims = text(&all["claims.csv"]);
    assert!(claims.contains("it walks at ω_v = 0,double support,1.0,,,every attempt,holds"));

    assert!(
        written(&mut [Subject::shipped().unwrap()]) == all,
        "the same bytes"
    );
}

#[test]
fn what_cannot_be_reported_on_is_an_error() {
    let out = tempfile::tempdir().unwrap();
    let none = write_report(&mut [], &tiny(), out.path(), &mut |_| {});
    assert!(matches!(none, Err(ReportError::NoSubject)));
    let file = out.path().join("file");
    std::fs::write(&file, "").unwrap();
    let blocked = write_report(
        &mut [Subject::shipped().unwrap()],
        &tiny(),
        &file,
        &mut |_| {},
    );
    let message = blocked.unwrap_err().to_string();
    assert!(
        message.contains("file") && message.contains("--out"),
        "{message}"
    );
}
