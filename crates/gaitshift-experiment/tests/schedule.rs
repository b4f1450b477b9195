//! Contract: a course passes through its points, is straight between them and level outside; without
//! points it says nothing. Points out of order or out of range are refused with key and remedy.

use gaitshift_experiment::{Course, Experiment};

#[test]
fn a_course_is_straight_between_its_points_and_level_outside() {
    let course = Course(vec![[0.2, 4.0], [0.6, 2.0]]);
    for (share, value) in [
        (0.0, 4.0),
        (0.2, 4.0),
        (0.4, 3.0),
        (0.5, 2.5),
        (0.6, 2.0),
        (1.0, 2.0),
    ] {
        assert!((course.at(share).unwrap() - value).abs() < 1e-12, "{share}");
    }
    assert_eq!(Course::default().at(0.5), None);
}

#[test]
fn impossible_schedules_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("e.toml");
    for (line, key, remedy) in [
        (
            "learning_rate = [[0.0, 0.0]]",
            "learning_rate",
            "greater than 0",
        ),
        ("alpha = [[0.0, -0.1]]", "alpha", "0 or greater"),
        ("horizon = [[0.0, 0.5]]", "horizon", "1 control period"),
        (
            "horizon = [[0.5, 50.0], [0.5, 60.0]]",
            "horizon",
            "rising from 0 to 1",
        ),
        (
            "alpha = [[0.0, 0.1], [1.5, 0.1]]",
            "alpha",
            "rising from 0 to 1",
        ),
    ] {
        std::fs::write(&file, format!("[training.schedule]\n{line}\n")).unwrap();
        let error = Experiment::load(file.to_str().unwrap())
            .unwrap_err()
            .to_string();
        assert!(
            error.contains(&format!("training.schedule.{key}")) && error.contains(remedy),
            "{error}"
        );
    }
    std::fs::write(
        &file,
        "[learner]\ntemperature = { kind = \"auto\", initial = 0.2 }\n[training.schedule]\nalpha = [[0.0, 0.1]]\n",
    )
    .unwrap();
    let error = Experiment::load(file.to_str().unwrap())
        .unwrap_err()
        .to_string();
    assert!(error.contains("learner.temperature"), "{error}");
}
