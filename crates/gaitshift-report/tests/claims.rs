//! Contract: a verdict follows from its rule and the numbers alone: near, within a factor of two, beyond; every attempt, some,
//! none; a claim about other runs than those given is not measured.

mod common;
use common::studies::study;
use gaitshift_analysis::GaitClass;
use gaitshift_report::{Finding, NoiseTolerance, Study, Verdict, judge_claims};

fn finding(studies: &[&Study], claim: &str) -> Finding {
    let findings = judge_claims(studies);
    let found = findings.into_iter().find(|f| f.claim.contains(claim));
    found.unwrap_or_else(|| panic!("no claim {claim}"))
}

#[test]
fn numbers_hold_within_a_tenth_differ_within_a_factor_of_two_and_fail_beyond() {
    for (froude, verdict) in [
        (0.22, Verdict::Holds),
        (0.24, Verdict::Holds),
        (0.25, Verdict::Differs),
        (0.12, Verdict::Differs),
        (0.10, Verdict::Fails),
        (0.45, Verdict::Fails),
    ] {
        let found = finding(&[&study(froude, 0.9)], "Froude number at ω_v = 0");
        assert_eq!(found.verdict, verdict, "{froude}");
        assert_eq!(found.seeds, [Some(froude)]);
        assert_eq!(found.interval(), [None, None], "one seed has no interval");
    }
    // 1.0 is more than twice 0.347.
    assert_eq!(
        finding(&[&study(0.2, 0.9)], "(8) running").verdict,
        Verdict::Fails
    );
}

#[test]
fn theirs_within_the_interval_over_seeds_holds() {
    let (slow, fast) = (study(0.12, 0.9), study(0.42, 0.9));
    let found = finding(&[&slow, &fast], "Froude number at ω_v = 0");
    assert_eq!(found.verdict, Verdict::Holds);
    let [low, high] = found.interval();
    assert!(low < Some(0.22) && high > Some(0.22));
}

#[test]
fn a_gait_that_is_not_there_has_no_cost() {
    let mut limping = study(0.2, 0.9);
    limping.steady[0].summary.gait = GaitClass::Mixed;
    assert_eq!(finding(&[&limping], "walks at").verdict, Verdict::Fails);
    let cost = finding(&[&limping], "(8) walking");
    assert_eq!((cost.verdict, cost.estimate), (Verdict::Fails, None));
    // One seed of three is fewer than half: its number is no result of the method.
    let good = study(0.22, 0.9);
    let walk = finding(&[&limping, &limping, &good], "walks at");
    assert_eq!(walk.verdict, Verdict::Differs);
    let froude = finding(&[&limping, &limping, &good], "Froude number at ω_v = 0");
    assert_eq!(froude.verdict, Verdict::Fails);
    assert_eq!(froude.seeds, [None, None, Some(0.22)]);
}

#[test]
fn attempts_correlations_and_steps_are_judged_by_their_rules() {
    let seed = study(0.22, 0.9);
    let of = |claim: &str| finding(&[&seed], claim);
    assert_eq!(of("0 → 3").verdict, Verdict::Differs);
    assert_eq!(of("0 → 3").estimate.unwrap().value, 0.75);
    assert_eq!(of("3 → 0").verdict, Verdict::Fails);
    assert_eq!(of("steps from walk to run").estimate.unwrap().value, 1.0);
    assert_eq!(of("steps from walk to run").verdict, Verdict::Holds);
    assert_eq!(
        of("walking: kinetic and potential").verdict,
        Verdict::Differs
    );
    assert_eq!(of("support: kinetic and potential").verdict, Verdict::Holds);
    assert_eq!(of("support: elastic and kinetic").verdict, Verdict::Fails);
    // 3 cm is not passed everywhere, so 4 cm does not count.
    assert_eq!(of("step up survived walking").estimate.unwrap().value, 2.0);
}

#[test]
fn the_most_sensitive_observations_are_those_that_bear_least() {
    let mut seed = study(0.22, 0.9);
    let row = |observation, successes| NoiseTolerance {
        omega_v: 0.0,
        observation,
        level: 1.0,
        deviation: 1.0,
        successes,
        trials: 10,
    };
    seed.noise = vec![
        row("x_velocity_m_per_s", 9),
        row("theta_velocity_rad_per_s", 0),
        row("phi_rad", 4),
        row("h_m", 3),
        row("phi_velocity_rad_per_s", 1),
    ];
    let found = finding(&[&seed], "noise walking");
    // Of the three named, h comes before one.
    assert_eq!(found.estimate.unwrap().value, 2.0 / 3.0);
    assert_eq!(found.verdict, Verdict::Differs);
}

#[test]
fn claims_about_other_runs_are_not_measured() {
    let seed = study(0.22, 0.9);
    let paper = Study {
        group: "paper".to_owned(),
        late_falls: Some(0.02),
        ..seed.clone()
    };
    let without = Study {
        group: "paper, without the energy term".to_owned(),
        ..seed.clone()
    };
    assert_eq!(
        finding(&[&seed], "Fig. 4: with phase I").verdict,
        Verdict::NotMeasured
    );
    assert_eq!(
        finding(&[&paper], "Fig. 4: with phase I").verdict,
        Verdict::Holds
    );
    assert_eq!(
        finding(&[&seed], "energy term there is no walk").verdict,
        Verdict::NotMeasured
    );
    assert_eq!(
        finding(&[&without], "energy term there is no walk").verdict,
        Verdict::Fails
    );
}
