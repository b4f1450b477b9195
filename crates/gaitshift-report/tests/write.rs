//! Contract: the same subjects give the same bytes; the page comes first; numbers stand in `report.json` and `claims.csv`; what
//! cannot be reported on is an error that says what to do.

use crate::common::{quiet, text, tiny, written, written_into};
use gaitshift_report::{Plan, ReportError, Subject, Work, write_report};

#[test]
fn the_same_subject_gives_the_same_bytes() {
    let all = written(&mut [Subject::shipped().unwrap()]);
    let numbers: serde_json::Value = serde_json::from_slice(&all["report.json"]).unwrap();
    assert_eq!(numbers["format"], "gaitshift-report 2");
    let walk = &numbers["studies"][0]["steady"][0];
    assert_eq!(
        (&walk["omega_v"], &walk["gait"]),
        (&0.0.into(), &"walking".into())
    );
    let claims = text(&all["claims.csv"]);
    assert!(claims.contains(
        "it walks at ω_v = 0,double support,every attempt,shipped controller,1.0,,,1.0,holds,false,gaitshift evaluate --omega-v=0 --duration-s 12 --json,gait"
    ));

    // Figures of an earlier report stayed beside the new ones.
    let folder = tempfile::tempdir().unwrap();
    let earlier = folder.path().join("figures/2-earlier");
    std::fs::create_dir_all(&earlier).unwrap();
    std::fs::write(earlier.join("gaits.svg"), "").unwrap();
    std::fs::write(folder.path().join("figures/old.png"), "").unwrap();
    std::fs::write(folder.path().join("report.json"), &all["report.json"]).unwrap();
    let again = written_into(folder.path(), &mut [Subject::shipped().unwrap()], &[]);
    assert!(again == all, "the same bytes");
    assert!(!earlier.exists());
}

#[test]
fn what_cannot_be_reported_on_is_an_error() {
    let out = tempfile::tempdir().unwrap();
    let none = write_report(&mut [], &[], &tiny(), out.path(), &quiet(1));
    assert!(matches!(none, Err(ReportError::NoSubject)));
    let file = out.path().join("file");
    std::fs::write(&file, "").unwrap();
    let blocked = write_report(
        &mut [Subject::shipped().unwrap()],
        &[],
        &tiny(),
        &file,
        &quiet(1),
    );
    let message = blocked.unwrap_err().to_string();
    assert!(
        message.contains("file") && message.contains("--out"),
        "{message}"
    );
}

#[test]
fn what_stops_one_controller_stops_all_and_is_said() {
    let out = tempfile::tempdir().unwrap();
    let plan = Plan {
        range: [0.0, 0.0, 1.0],
        // Not an integration step: the finer motions cannot be made.
        fine_step_s: -1.0,
        ..tiny()
    };
    let mut subjects = [1, 2, 3].map(|_| Subject::shipped().unwrap());
    let error = write_report(&mut subjects, &[], &plan, out.path(), &quiet(2)).unwrap_err();
    assert!(error.to_string().contains("time_step_s"), "{error}");
    assert!(!out.path().join("report.html").exists());

    let stop = Work {
        stop: &|| true,
        ..quiet(2)
    };
    let stopped = write_report(&mut subjects, &[], &tiny(), out.path(), &stop);
    assert!(matches!(stopped, Err(ReportError::Stopped)));
}
