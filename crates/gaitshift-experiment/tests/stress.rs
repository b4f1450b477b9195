//! Contract: limits do not depend on the threads; they hold when tried by themselves, and what is a rung greater does not;
//! a body that falls undisturbed has no limits; kinds of disturbances that are asked for alone have the limits they have among
//! all.

use crate::common::moved;
use gaitshift_body::Body;
use gaitshift_experiment::{Controller, Limit, Stress, StressKind, StressPlan, stress};
use gaitshift_task::Disturbance;
use std::sync::atomic::{AtomicUsize, Ordering};

fn plan() -> StressPlan {
    StressPlan {
        omega_v: vec![3.0],
        seeds: vec![1, 2],
        phases: 2,
        after_s: 2.0,
        settling_s: 3.0,
        ..StressPlan::quick()
    }
}

fn of(plan: &StressPlan, threads: usize) -> Stress {
    let controller = Controller::shipped().unwrap();
    let body = Body::new(controller.body.clone()).unwrap();
    stress(&controller, &body, plan, threads, &|_, _| ()).unwrap()
}

fn limit<'a>(found: &'a Stress, disturbance: StressKind, which: &str) -> &'a Limit {
    let mut limits = found.limits.iter();
    limits
        .find(|l| l.disturbance == disturbance && l.which == which)
        .unwrap()
}

#[test]
fn limits_do_not_depend_on_the_threads_and_are_counted() {
    let controller = Controller::shipped().unwrap();
    let body = Body::new(controller.body.clone()).unwrap();
    let (plan, greatest) = (plan(), AtomicUsize::new(0));
    let count = |done: usize, total: usize| {
        assert!(done <= total);
        greatest.fetch_max(done, Ordering::SeqCst);
    };
    let several = stress(&controller, &body, &plan, 3, &count).unwrap();
    assert_eq!(several, of(&plan, 1));
    // Two directions at two phases, steps, slopes, eight observations, latency.
    assert_eq!(several.limits.len(), 4 + 2 + 2 + 8 + 1);
    assert_eq!(greatest.into_inner(), 2 * several.limits.len());
    for limit in &several.limits {
        assert_eq!(limit.limits.len(), 2);
        let (least, greatest) = (limit.least.unwrap(), limit.greatest.unwrap());
        assert!(0.0 < least && least <= limit.median.unwrap() && greatest <= limit.greatest_tried);
    }
}

// The quick plan has none, so that nothing tried them.
#[test]
fn pushes_up_and_down_have_limits_of_their_own() {
    let vertical = StressPlan {
        kinds: vec![StressKind::Push],
        seeds: vec![1],
        vertical_pushes: true,
        ..plan()
    };
    let found = of(&vertical, 1);
    let which: Vec<&str> = found.limits.iter().map(|l| l.which).collect();
    assert_eq!(
        which,
        [
            "forward", "forward", "backward", "backward", "up", "up", "down", "down"
        ]
    );
    let of_direction = |which| limit(&found, StressKind::Push, which).limits[0].unwrap();
    let limits = ["forward", "backward", "up", "down"].map(of_direction);
    assert!(limits.iter().all(|limit| *limit > 0.0), "{limits:?}");
    // The run is pushed up by far more than it is pushed down before it falls.
    assert!(limits[2] > 1.5 * limits[3], "{limits:?}");
    // Those along the way are what they are without.
    let level = of(
        &StressPlan {
            vertical_pushes: false,
            ..vertical
        },
        1,
    );
    assert_eq!(level.limits[..], found.limits[..4]);
}

#[test]
fn a_limit_holds_and_a_little_more_does_not() {
    let plan = StressPlan {
        bisections: 4,
        seeds: vec![1],
        ..plan()
    };
    let found = of(&plan, 1);
    let latency_s = limit(&found, StressKind::Latency, "").limits[0].unwrap();
    let mut controller = Controller::shipped().unwrap();
    // From its start on a motion is harder to bear late than from a settled one, so that only what is far too much is
    // tried that way.
    let mut falls = |latency_s: f64| {
        let late = Disturbance {
            latency_s,
            ..Disturbance::default()
        };
        let motion = moved(&mut controller, &late, Some(1), 3.0, 5.0);
        motion.metadata.fell
    };
    assert!(latency_s > 0.004 && latency_s < 0.05, "{latency_s}");
    assert!(!falls(0.25 * latency_s) && falls(3.0 * latency_s));
}

// A single place of the step's face let a walk over 3.6 cm that trips over 1.5 cm where its foot meets the face.
#[test]
fn a_step_is_borne_where_it_is_borne_at_every_place() {
    let step_m = |phases| {
        let plan = StressPlan {
            omega_v: vec![0.0],
            phases,
            seeds: vec![1],
            ..plan()
        };
        limit(&of(&plan, 1), StressKind::Step, "up").limits[0].unwrap()
    };
    // Half the places are among all of them; what one of them refuses, all do. Sizes are tried in the same order.
    let (one, two, eight) = (step_m(1), step_m(2), step_m(8));
    assert!(eight <= two && two <= one, "{one} {two} {eight}");
    assert!(eight < one, "{eight}");
}

#[test]
fn who_falls_undisturbed_has_no_limits() {
    let controller = Controller::shipped().unwrap();
    let mut parameters = controller.body.clone();
    parameters.actuator_force_n = 0.0;
    let body = Body::new(parameters).unwrap();
    let found = stress(&controller, &body, &plan(), 1, &|_, _| ()).unwrap();
    for limit in &found.limits {
        assert_eq!(limit.limits, [None, None]);
        assert_eq!(
            (limit.least, limit.median, limit.greatest),
            (None, None, None)
        );
    }
}

#[test]
fn kinds_asked_for_alone_have_the_same_limits() {
    let all = of(&plan(), 1);
    let kinds = vec![StressKind::Latency, StressKind::Push];
    let alone = of(&StressPlan { kinds, ..plan() }, 1);
    let wanted = |l: &&Limit| matches!(l.disturbance, StressKind::Push | StressKind::Latency);
    let expected: Vec<Limit> = all.limits.iter().filter(wanted).cloned().collect();
    assert_eq!(alone.limits, expected);
    assert_eq!(alone.limits.len(), 4 + 1);
}
