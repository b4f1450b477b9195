//! Contract: every criterion is measured on rollouts of the very controller that is judged, a body
//! that does not walk meets none of those that ask for a gait, what is asked of a gait or of a change of
//! gait holds only where there is one, what is undefined is not met, and what is not met says why.

use crate::common::moved;
use gaitshift_analysis::GaitClass;
use gaitshift_analysis::recording::column;
use gaitshift_body::{Body, BodyParameters};
use gaitshift_experiment::{
    AskedChange, AskedGait, Check, Control, Controller, Criteria, Deterministic, Judgement, judge,
};
use gaitshift_task::{ACTION_SIZE, Disturbance, OBSERVATION_SIZE, TaskParameters};
use std::path::Path;

fn judged(action: [f32; 2], criteria: &Criteria) -> Judgement {
    let body = Body::new(BodyParameters::default()).unwrap();
    let mut control = |_: &[f32; 14], out: &mut [f32; 2]| *out = action;
    judge(&body, &TaskParameters::default(), criteria, &mut control).unwrap()
}

/// Both changes from so many phases of the stride.
fn changes(phases: usize, steady_s: f64) -> Vec<AskedChange> {
    [(0.0, 3.0), (3.0, 0.0)]
        .map(|(from, to)| AskedChange {
            phases,
            steady_s,
            ..AskedChange::new(from, to)
        })
        .to_vec()
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
    assert_eq!(j.changes.len(), 2);
    assert!(j.changes.iter().all(|c| c.tries.is_empty()));
    assert_eq!((j.met(), j.accepted()), (0, false));
    assert!(j.checks.iter().all(|c| c.credit < 1.0));
    assert!(j.score() < 39.0 && j.score().is_finite());
}

#[test]
fn surviving_alone_is_not_walking() {
    // Two control periods are survived by anyone; no gait can be told from them.
    let criteria = Criteria {
        duration_s: 0.01,
        changes: changes(1, 0.005),
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
        changes: changes(2, 0.5),
        ..Criteria::default()
    };
    assert_eq!(
        judged([0.55, 0.45], &criteria),
        judged([0.55, 0.45], &criteria)
    );
}

/// The shipped controller, deaf to its command: it is told `omega_v` whatever is asked.
fn deaf(omega_v: f32, criteria: &Criteria) -> Judgement {
    let mut shipped = Controller::shipped().unwrap();
    let body = Body::new(shipped.body.clone()).unwrap();
    let mut control = |asked: &[f32; OBSERVATION_SIZE], action: &mut [f32; ACTION_SIZE]| {
        let mut told = *asked;
        told[OBSERVATION_SIZE - 1] =
            omega_v * gaitshift_task::OBSERVATION_SCALE[OBSERVATION_SIZE - 1];
        Deterministic(&mut shipped.policy).act(&told, action);
    };
    judge(&body, &shipped.task, criteria, &mut control).unwrap()
}

/// Two phases of the stride and two commands, to be quick.
fn quick() -> Criteria {
    Criteria {
        omega_v: vec![0.0, 3.0],
        duration_s: 10.0,
        changes: changes(2, 10.0),
        ..Criteria::default()
    }
}

fn named<'a>(j: &'a Judgement, part: &str) -> Vec<&'a Check> {
    let found: Vec<&Check> = j.checks.iter().filter(|c| c.name.contains(part)).collect();
    assert!(!found.is_empty(), "no criterion is called {part}");
    found
}

fn not_met_because(j: &Judgement, part: &str, reason: &str) {
    for c in named(j, part) {
        assert!(!c.met, "{} is met", c.name);
        assert!(c.credit < 1.0, "{}: credit {}", c.name, c.credit);
        assert_eq!(c.reason.as_deref(), Some(reason), "{}", c.name);
    }
}

// A controller that walked at every command met all ten "changes 3 -> 0", since it walked in the end,
// and the cost of transport "running", since a walk is cheap: 22 of 39 criteria without a single run.
#[test]
fn a_walker_changes_no_gait_and_has_no_cost_of_running() {
    let j = deaf(0.0, &quick());
    let gaits: Vec<GaitClass> = j.rows.iter().map(|r| r.summary.gait).collect();
    assert_eq!(gaits, [GaitClass::Walking; 2]);
    assert!(j.changes[1].tries.iter().all(|t| t.survived));
    assert_eq!(named(&j, "changes 3 -> 0").len(), 2);
    let before = "before the change the motion is walking, not running";
    not_met_because(&j, "changes 3 -> 0", before);
    let after = "after the change the motion is walking, not running";
    not_met_because(&j, "changes 0 -> 3", after);
    let walks = "the motion is walking, not running";
    not_met_because(&j, "cost of transport running", walks);
    assert_eq!(named(&j, "correlation running").len(), 3);
    not_met_because(&j, "correlation running", walks);
    not_met_because(&j, "runs at", walks);
    // What is asked of the walk it does meet.
    for part in ["walks at", "cost of transport walking"] {
        assert!(named(&j, part).iter().all(|c| c.met && c.reason.is_none()));
    }
}

#[test]
fn a_runner_changes_no_gait_and_has_no_cost_of_walking() {
    let j = deaf(3.0, &quick());
    let gaits: Vec<GaitClass> = j.rows.iter().map(|r| r.summary.gait).collect();
    assert_eq!(gaits, [GaitClass::Running; 2]);
    let before = "before the change the motion is running, not walking";
    not_met_because(&j, "changes 0 -> 3", before);
    let after = "after the change the motion is running, not walking";
    not_met_because(&j, "changes 3 -> 0", after);
    let runs = "the motion is running, not walking";
    not_met_because(&j, "cost of transport walking", runs);
    not_met_because(&j, "correlation walking", runs);
    for part in ["runs at", "cost of transport running"] {
        assert!(named(&j, part).iter().all(|c| c.met));
    }
}

/// What README.md, docs/results.md and docs/robustness.md say of the controllers that come with the program.
#[test]
fn the_controllers_that_come_with_the_program_meet_what_is_said_of_them() {
    for (name, met) in [("shipped", 39), ("robust", 37)] {
        let mut controller = Controller::read(Path::new(name)).unwrap();
        let body = Body::new(controller.body.clone()).unwrap();
        let mut control = Deterministic(&mut controller.policy);
        let j = judge(&body, &controller.task, &Criteria::default(), &mut control).unwrap();
        assert_eq!((j.met(), j.checks.len()), (met, 39), "{name}");
    }
}

/// What docs/robustness.md says that `robust` withstands, from the start that is meant where none is named.
#[test]
fn robust_stays_up_where_it_was_meant_to() {
    let mut robust = Controller::read(Path::new("robust")).unwrap();
    let push = |forward_n, start_s| {
        format!("[[pushes]]\nforward_n = {forward_n}\nup_n = 0\nstart_s = {start_s}\n")
    };
    let mut disturbances = vec![
        "latency_s = 0.02\n".to_owned(),
        "[terrain]\nslope_rad = 0.0523\nslope_from_m = 2\n".to_owned(),
        "[terrain]\nslope_rad = -0.0523\nslope_from_m = 2\n".to_owned(),
        "[[terrain.steps]]\nheight_m = 0.03\nat_m = 4.05\n".to_owned(),
        "[[terrain.steps]]\nheight_m = -0.03\nat_m = 4.05\n".to_owned(),
    ];
    for forward_n in [250, -200] {
        disturbances.extend([6.0, 6.3, 6.6].map(|start_s| push(forward_n, start_s)));
    }
    for text in disturbances {
        let disturbance: Disturbance = toml::from_str(&text).unwrap();
        for omega_v in [0.0, 1.0, 2.0, 3.0] {
            let recording = moved(&mut robust, &disturbance, None, omega_v, 14.0);
            assert!(!recording.metadata.fell, "{omega_v}: {text}");
            let x = recording.column(column::X_M);
            assert!(x[x.len() - 1] > 4.0, "{omega_v} stands: {text}");
        }
    }
}

#[test]
fn the_shipped_controller_changes_both_ways() {
    let mut shipped = Controller::shipped().unwrap();
    let body = Body::new(shipped.body.clone()).unwrap();
    let mut control = Deterministic(&mut shipped.policy);
    let j = judge(&body, &shipped.task, &quick(), &mut control).unwrap();
    for part in ["changes", "cost of transport", "correlation"] {
        for c in named(&j, part) {
            assert!(c.met, "{}: {:?}", c.name, c.reason);
        }
    }
}

#[test]
fn whatever_is_not_met_says_why() {
    let j = judged([0.0, 0.0], &quick());
    for c in &j.checks {
        assert_eq!(c.met, c.reason.is_none(), "{}", c.name);
        let reason = c.reason.as_deref().unwrap();
        assert!(!reason.is_empty());
    }
    for part in ["survives", "walks at", "runs at", "cost of", "correlation"] {
        for c in named(&j, part) {
            let reason = c.reason.as_deref().unwrap();
            assert!(reason.starts_with("fell after "), "{}: {reason}", c.name);
        }
    }
    for c in named(&j, "changes") {
        let reason = c.reason.as_deref().unwrap();
        assert!(reason.starts_with("no motion to change from"), "{reason}");
    }
}

/// All 39 in the words in which runs of before have them: what is told of a run must not depend on the version that judged it.
#[test]
fn the_papers_criteria_are_asked_in_their_own_words() {
    let j = judged([0.0, 0.0], &Criteria::default());
    let mut names: Vec<String> = (0..8)
        .map(|k| format!("survives 20 s at omega_v = {}", 0.5 * f64::from(k)))
        .collect();
    names.extend(
        [
            "walks at omega_v = 0: share of steps with double support",
            "Froude number at omega_v = 0 at least 0.15",
            "runs at omega_v = 3: share of steps with flight",
            "least Froude number at most 0.2",
            "greatest Froude number at least 0.93",
            "cost of transport walking at omega_v = 0 at most 0.342",
            "cost of transport running at omega_v = 3 at most 0.347",
        ]
        .map(str::to_owned),
    );
    for change in ["0 -> 3", "3 -> 0"] {
        names.extend(
            (0..10)
                .map(|k| format!("changes {change} from phase {k}/10 of the stride: survived, s")),
        );
    }
    names.extend(
        [
            "kinetic-potential correlation walking below -0.5",
            "kinetic-potential correlation running (single support) above 0.5",
            "elastic-kinetic correlation running (single support) below -0.5",
            "elastic-potential correlation running (single support) below -0.5",
        ]
        .map(str::to_owned),
    );
    let asked: Vec<&str> = j.checks.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(asked, names);
}

#[test]
fn a_controller_is_judged_by_what_is_asked_of_it() {
    let mut shipped = Controller::shipped().unwrap();
    let body = Body::new(shipped.body.clone()).unwrap();
    let slow = AskedGait {
        froude_min: 0.1,
        froude_max: 0.3,
        correlation: 0.4,
        ..AskedGait::new(0.0, GaitClass::Walking)
    };
    let criteria = Criteria {
        omega_v: vec![0.0, 0.2, 3.0],
        duration_s: 12.0,
        slowest_froude_max: 0.0,
        fastest_froude_min: 0.5,
        gaits: vec![
            slow.clone(),
            AskedGait {
                cost_of_transport_max: 0.001,
                correlation: 0.1,
                ..AskedGait::new(0.2, GaitClass::Walking)
            },
            AskedGait {
                froude_max: 0.5,
                ..AskedGait::new(3.0, GaitClass::Standing)
            },
        ],
        changes: vec![AskedChange {
            phases: 1,
            ..AskedChange::new(0.0, 0.2)
        }],
    };
    let mut control = Deterministic(&mut shipped.policy);
    let j = judge(&body, &shipped.task, &criteria, &mut control).unwrap();
    assert_eq!(j.checks.len(), criteria.count());
    let asked: Vec<Option<GaitClass>> = j.rows.iter().map(|row| row.asked).collect();
    let (walking, standing) = (Some(GaitClass::Walking), Some(GaitClass::Standing));
    assert_eq!(asked, [walking, walking, standing]);
    let outcome = |part: &str| {
        let [check] = named(&j, part)[..] else {
            panic!("{part}: {:?}", named(&j, part))
        };
        check.met
    };
    assert!(outcome("walks at omega_v = 0:"));
    assert!(outcome("Froude number at omega_v = 0 at least 0.1"));
    assert!(outcome("Froude number at omega_v = 0 at most 0.3"));
    assert!(outcome("greatest Froude number at least 0.5"));
    assert!(outcome("walks at omega_v = 0.2:"));
    assert!(outcome("walking at omega_v = 0 below -0.4"));
    // The same gait before and after.
    assert!(outcome("changes 0 -> 0.2 from phase 0/1"));
    assert!(!outcome(
        "cost of transport walking at omega_v = 0.2 at most 0.001"
    ));
    assert!(!outcome("stands at omega_v = 3: speed in m/s"));
    assert!(!outcome("Froude number at omega_v = 3 at most 0.5"));
    assert!(j.checks.iter().all(|c| !c.name.starts_with("least")));
}
