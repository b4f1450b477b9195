//! Contract: every criterion is measured on rollouts of the very controller that is judged, a body
//! that does not walk meets none of those that ask for a gait, and what is undefined is not met.

use gaitshift_body::{Body, BodyParameters};
use gaitshift_experiment::{Criteria, Judgement, judge};
use gaitshift_task::TaskParameters;

fn judged(action: [f32; 2], criteria: &Criteria) -> Judgement {
    let body = Body::new(BodyParameters::default()).unwrap();
    let mut control = |_: &[f32; 14], out: &mut [f32; 2]| *out = action;
    judge(&body, &TaskParameters::default(), criteria, &mut control).unwrap()
}

#[test]
fn a_limp_body_falls_and_meets_nothing() {
    let j = judged([0.0, 0.0], &Criteria::default());
    assert_eq!((j.rows.len(), j.checks.len()), (8, 39));
    assert!(
        j.rows
            .iter()
            .all(|r| r.summary.fell && r.summary.survived_s < 3.0)
    );
    // A motion that does not last has no stride to change gait from.
    assert!(j.to_running.is_empty() && j.to_walking.is_empty());
    assert_eq!((j.met(), j.accepted()), (0, false));
    assert!(j.checks.iter().all(|c| c.credit < 1.0));
    assert!(j.score() < 39.0 && j.score().is_finite());
}

#[test]
fn surviving_alone_is_not_walking() {
    // Two control periods are survived by anyone; no gait can be told from them.
    let criteria = Criteria {
        duration_s: 0.01,
        steady_s: 0.005,
        phases: 1,
        ..Criteria::default()
    };
    let j = judged([0.5, 0.5], &criteria);
    let met: Vec<&str> = j
        .checks
        .iter()
        .filter(|c| c.met)
        .map(|c| c.name.as_str())
        .collect();
    assert!(!j.accepted());
    assert!(
        met.iter()
            .filter(|name| name.starts_with("survives"))
            .count()
            == 8,
        "{met:?}"
    );
    let gaits = ["walks at", "runs at", "changes", "correlation"];
    assert!(
        !met.iter()
            .any(|name| gaits.iter().any(|gait| name.contains(gait))),
        "{met:?}"
    );
}

#[test]
fn the_same_controller_is_judged_alike_twice() {
    let criteria = Criteria {
        duration_s: 1.0,
        phases: 2,
        steady_s: 0.5,
        ..Criteria::default()
    };
    assert_eq!(
        judged([0.55, 0.45], &criteria),
        judged([0.55, 0.45], &criteria)
    );
}
