//! Contract: a profile is piecewise linear and constant outside its points; what is wrong in a file is
//! reported with file, line and remedy.

use gaitshift_experiment::CommandProfile;

#[test]
fn ramps_are_linear_between_and_constant_outside() {
    let ramp = CommandProfile::ramp(0.0, 3.0, 10.0, 0.4);
    assert_eq!(ramp.at(0.0), 0.0);
    assert_eq!(ramp.at(10.0), 0.0);
    assert!((ramp.at(10.2) - 1.5).abs() < 1e-9);
    assert_eq!(ramp.at(11.0), 3.0);
    assert_eq!(CommandProfile::ramp(1.0, 2.0, 5.0, 0.0).at(5.0), 2.0);
    assert_eq!(CommandProfile::constant(0.7).at(99.0), 0.7);
}

#[test]
fn changes_that_are_apart_are_told_apart() {
    let trip = CommandProfile::constant(0.0)
        .then_ramp(3.0, 10.0, 0.4)
        .then_ramp(0.0, 20.0, 0.4);
    assert_eq!(trip.changes_s(4.0), [(10.0, 10.4), (20.0, 20.4)]);
    assert_eq!(trip.changes_s(15.0), [(10.0, 20.4)]);
    assert_eq!(trip.change_s(), Some((10.0, 20.4)));
    // Two slopes in a row are one change.
    let bent = CommandProfile::through(&[(1.0, 0.0), (2.0, 1.0), (3.0, 3.0), (5.0, 3.0)]).unwrap();
    assert_eq!(bent.changes_s(4.0), [(1.0, 3.0)]);
    assert!(CommandProfile::constant(1.0).changes_s(4.0).is_empty());
}

#[test]
fn files_are_read_or_refused_with_their_line() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("profile.csv");
    let read = |text: &str| {
        std::fs::write(&file, text).unwrap();
        CommandProfile::read_csv(&file).map_err(|e| e.to_string())
    };
    let profile = read("# a comment\nomega_v, time_s\n0, 0\n3, 2\n").unwrap();
    assert_eq!((profile.at(1.0), profile.end_s()), (1.5, 2.0));
    for (text, word) in [
        ("time_s,omega\n0,1\n", "omega_v"),
        ("time_s,omega_v\n0,fast\n", "line 2"),
        ("time_s,omega_v\n0,1\n0,2\n", "line 3"),
        ("time_s,omega_v\n0,inf\n", "line 2"),
        ("time_s,omega_v\n0,1,2\n", "line"),
        ("time_s,omega_v\n", "no data"),
        ("time_s,omega_v,time_s\n0,1,2\n", "twice"),
        ("", "time_s"),
    ] {
        let message = read(text).unwrap_err();
        assert!(
            message.contains(word) && message.contains("profile.csv"),
            "{text:?}: {message}"
        );
    }
    assert!(CommandProfile::read_csv(&folder.path().join("none.csv")).is_err());
}
