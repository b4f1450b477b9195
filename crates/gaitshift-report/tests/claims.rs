//! Contract: a verdict follows from its rule and the numbers alone: near, within a factor of two, beyond; every attempt, some,
//! none. Each claim is judged by the experiment that it is about, other methods stand beside it, and an experiment that was not
//! given is not measured. What a claim says of a range of commands is judged within that range.

use crate::common::studies::{motion, study};
use gaitshift_analysis::GaitClass::{Fallen, Mixed, Running, Standing, Walking};
use gaitshift_report::{
    Finding, Judged, NoiseTolerance, RecordedExperiment, Steady, Stretch, Study, Verdict,
    judge_claims, recorded_experiments,
};

fn judged(studies: &[&Study], claim: &str) -> Judged {
    judged_with(studies, &[], claim)
}

fn judged_with(studies: &[&Study], recorded: &[RecordedExperiment], claim: &str) -> Judged {
    let found = judge_claims(studies, recorded).into_iter();
    let mut found = found.filter(|j| j.claim.contains(claim));
    let judged = found.next().unwrap_or_else(|| panic!("no claim {claim}"));
    assert!(found.next().is_none(), "{claim} is not one claim");
    judged
}

/// What the seeds of an experiment that no claim is about say.
fn finding(studies: &[&Study], claim: &str) -> Finding {
    judged(studies, claim).beside.remove(0)
}

fn of(experiment: &str, steady: Vec<Steady>) -> Study {
    Study {
        group: experiment.to_owned(),
        steady,
        ..study(0.22, 0.9)
    }
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
fn a_wide_interval_makes_no_claim_hold() {
    let verdict = |seeds: [f64; 2]| {
        let seeds = seeds.map(|froude| study(froude, 0.9));
        finding(&[&seeds[0], &seeds[1]], "Froude number at ω_v = 0").verdict
    };
    assert_eq!(verdict([0.21, 0.23]), Verdict::Holds);
    // Near on average, but each seed is somewhere else.
    assert_eq!(verdict([0.10, 0.34]), Verdict::Undecided);
    // Theirs is within the interval, and the estimate is not near.
    assert_eq!(verdict([0.12, 0.42]), Verdict::Differs);
}

#[test]
fn a_gait_that_is_not_there_has_no_cost() {
    let mut limping = study(0.2, 0.9);
    limping.steady[0].summary.gait = Mixed;
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
    // 0.3 is less than a fifth of 3.2.
    assert_eq!(of("ASIMO").estimate.unwrap().value, 0.3 / 3.2);
    assert_eq!(of("ASIMO").verdict, Verdict::Holds);
    assert_eq!(of("0 → 3").verdict, Verdict::Differs);
    assert_eq!(of("0 → 3").estimate.unwrap().value, 0.75);
    assert_eq!(of("3 → 0").verdict, Verdict::Fails);
    // On the journal version's ramp, not on the paper's.
    assert_eq!(of("steps from walk to run").estimate.unwrap().value, 2.5);
    assert_eq!(of("steps from walk to run").verdict, Verdict::Differs);
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
    let row = |observation: &str, successes| NoiseTolerance {
        omega_v: 0.0,
        observation: observation.to_owned(),
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
    // What went wrong: the interval was that of the seeds with all three, none, and did not hold the mean.
    let several = finding(&[&seed, &seed, &seed], "noise walking");
    let estimate = several.estimate.unwrap();
    assert_eq!(estimate.interval, [2.0 / 3.0; 2]);
}

#[test]
fn a_claim_is_judged_by_its_experiment_and_others_stand_beside_it() {
    let seed = study(0.22, 0.9);
    let paper = of("paper", seed.steady.clone());
    let journal = of("journal", Vec::new());
    let all = [&seed, &paper, &journal];
    let froude = judged(&all, "Froude number at ω_v = 0");
    assert_eq!(froude.own.experiment, "paper");
    assert_eq!(froude.own.seeds, [Some(0.22)]);
    // The journal version's runs say nothing to it.
    assert_eq!(froude.beside.len(), 1);
    assert_eq!(froude.beside[0].experiment, "g");
    // And the paper's say nothing to the journal version's claims.
    assert_eq!(judged(&all, "greatest speed").own.seeds, [None]);
    let missing = judged(&[&seed], "Froude number at ω_v = 0").own;
    assert_eq!(
        (missing.verdict, missing.estimate),
        (Verdict::NotMeasured, None)
    );
}

#[test]
fn claims_about_training_need_its_log() {
    let seed = study(0.22, 0.9);
    let claim = "Fig. 4: with phase I";
    assert_eq!(finding(&[&seed], claim).verdict, Verdict::NotMeasured);
    let trained = Study {
        late_falls: Some(0.02),
        ..seed.clone()
    };
    assert_eq!(finding(&[&trained], claim).verdict, Verdict::Holds);
    // What a method leaves out, another one tells nothing about.
    let without = "Fig. 4: without phase I";
    assert_eq!(finding(&[&trained], without).verdict, Verdict::NotMeasured);
}

#[test]
fn the_journal_versions_speeds_are_those_of_its_commands() {
    let mut seed = study(0.2, 0.9);
    let speed = (9.81_f64 * 0.8).sqrt();
    seed.steady.insert(0, motion(-0.5, Walking, 0.05, 0.3));
    seed.steady.push(motion(3.5, Running, 1.2, 0.3));
    seed.steady.insert(2, motion(2.0, Running, 0.8, 0.3));
    let value = |claim| finding(&[&seed], claim).estimate.unwrap().value;
    assert!((value("least speed") - 0.2 * speed).abs() < 1e-12);
    // That at 3 is beyond 2.93.
    assert!((value("greatest speed") - 0.8 * speed).abs() < 1e-12);
    assert_eq!(value("least Froude"), 0.05);
}

#[test]
fn the_greatest_command_is_one_below_which_none_falls() {
    let mut seed = study(0.2, 0.9);
    seed.steady.insert(1, motion(1.0, Fallen, 0.5, 0.3));
    seed.steady[1].summary.fell = true;
    let found = finding(&[&seed], "it does not fall");
    assert_eq!(
        (found.seeds, found.verdict),
        (vec![Some(0.0)], Verdict::Fails)
    );
}

#[test]
fn only_a_gait_means_that_it_is_there_and_advances() {
    let verdict = |experiment: &str, claim: &str, gait, froude: f64| {
        // Commands that it was not trained with do not count.
        let steady = vec![
            motion(
                0.0,
                if claim.contains("runs") {
                    Walking
                } else {
                    gait
                },
                froude,
                0.3,
            ),
            motion(1.5, gait, froude, 0.3),
            motion(2.5, gait, froude, 0.3),
            motion(3.0, Fallen, froude, 0.3),
        ];
        judged(&[&of(experiment, steady)], claim).own.verdict
    };
    let full = "journal, full range from the start";
    assert_eq!(verdict(full, "only walks", Walking, 0.2), Verdict::Holds);
    for other in [Standing, Fallen, Mixed, Running] {
        assert_eq!(verdict(full, "only walks", other, 0.2), Verdict::Fails);
    }
    assert_eq!(verdict(full, "only walks", Walking, -0.2), Verdict::Fails);
    let high = "journal, high range from the start";
    assert_eq!(verdict(high, "only runs", Running, 0.9), Verdict::Holds);
    assert_eq!(verdict(high, "only runs", Fallen, 0.9), Verdict::Fails);
}

#[test]
fn without_the_energy_term_is_compared_with_the_method() {
    let with = |experiment: &str, gait, drag: f64, clearance: f64| {
        let mut seed = of(experiment, vec![motion(0.0, gait, 0.2, 0.3)]);
        let summary = &mut seed.steady[0].summary;
        summary.drag_work_j_per_m = Some(drag);
        summary.clearance_right_m = Some(clearance);
        summary.clearance_left_m = Some(clearance);
        seed
    };
    let paper = with("paper", Walking, 2.0, 0.04);
    let dragging = with("paper, without the energy term", Mixed, 3.0, 0.01);
    let own = |studies: &[&Study], claim| judged(studies, claim).own;
    let both = [&paper, &dragging];
    assert_eq!(own(&both, "still advances").verdict, Verdict::Holds);
    assert_eq!(own(&both, "no steady walk or run").verdict, Verdict::Holds);
    let drag = own(&both, "drag more in swing");
    assert_eq!(
        (drag.seeds, drag.verdict),
        (vec![Some(1.5)], Verdict::Holds)
    );
    let clearance = own(&both, "clears the ground by less");
    assert_eq!(
        (clearance.seeds, clearance.verdict),
        (vec![Some(0.25)], Verdict::Holds)
    );
    // Without the method there is nothing to compare with.
    assert_eq!(own(&[&dragging], "drag more").verdict, Verdict::NotMeasured);
    // Falling everywhere is neither advancing nor dragging.
    let mut falling = dragging.clone();
    falling.steady[0].summary.fell = true;
    let both = [&paper, &falling];
    for claim in ["still advances", "no steady walk or run", "drag more"] {
        assert_eq!(own(&both, claim).verdict, Verdict::Fails, "{claim}");
    }
}

#[test]
fn courses_of_training_are_judged_tenth_by_tenth() {
    let course = |experiment: &str, returns: [f64; 10], falls: [f64; 10]| {
        let mut seed = of(experiment, Vec::new());
        seed.late_falls = Some(falls[9]);
        let tenth = |k: usize| Stretch {
            from_step: 1e6 * k as f64,
            to_step: 1e6 * (k + 1) as f64,
            mean_return: returns[k],
            falls: falls[k],
        };
        seed.training = (0..10).map(tenth).collect();
        seed
    };
    let rising = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0];
    let mut declining = rising;
    declining[6..].fill(3.0);
    let name = "journal, without 1/(1+ω_v)";
    let mut falls = [0.1; 10];
    let claims = ["its return falls after 6", "it falls at 8"];
    let verdicts = |seed: &Study| claims.map(|claim| judged(&[seed], claim).own.verdict);
    assert_eq!(verdicts(&course(name, rising, falls)), [Verdict::Fails; 2]);
    falls[8] = 0.9;
    assert_eq!(
        verdicts(&course(name, declining, falls)),
        [Verdict::Holds; 2]
    );

    let journal = course("journal", rising, [0.4; 10]);
    let without = course("journal, without its first phase", rising, [0.8; 10]);
    let start = judged(&[&journal, &without], "first million steps").own;
    assert_eq!(
        (start.seeds, start.verdict),
        (vec![Some(2.0)], Verdict::Holds)
    );
}

#[test]
fn falling_at_the_start_is_falling_within_seconds() {
    let name = "journal, without its first phase";
    let verdict = |survived_s: f64| {
        let mut seed = of(name, vec![motion(0.0, Fallen, 0.2, 0.3)]);
        seed.steady[0].summary.fell = true;
        seed.steady[0].summary.survived_s = survived_s;
        judged(&[&seed], "within 5 s of a motion").own.verdict
    };
    assert_eq!(verdict(1.0), Verdict::Holds);
    assert_eq!(verdict(12.0), Verdict::Fails);
}

#[test]
fn without_runs_of_its_experiment_a_claim_is_judged_by_what_is_recorded() {
    let seed = study(0.22, 0.9);
    let recorded = |values: &[Option<f64>]| RecordedExperiment {
        name: "paper".to_owned(),
        repeats: None,
        learner: None,
        runs: "trained earlier".to_owned(),
        seeds: (1..).take(values.len()).collect(),
        claims: [("Froude number at ω_v = 0".to_owned(), values.to_vec())].into(),
        studies: Vec::new(),
    };
    let own = |studies: &[&Study], values: &[Option<f64>]| {
        judged_with(studies, &[recorded(values)], "Froude number at ω_v = 0").own
    };
    let found = own(&[&seed], &[Some(0.21), Some(0.23)]);
    assert_eq!((found.verdict, found.recorded), (Verdict::Holds, true));
    assert_eq!(found.seeds, [Some(0.21), Some(0.23)]);
    // By the same rules: fewer than half of the seeds.
    assert_eq!(
        own(&[&seed], &[Some(0.21), None, None]).verdict,
        Verdict::Fails
    );
    // What is measured comes first, and what is recorded says nothing to other claims.
    let paper = of("paper", seed.steady.clone());
    assert!(!own(&[&paper], &[Some(0.5)]).recorded);
    let other = judged_with(
        &[&seed],
        &[recorded(&[Some(0.2)])],
        "Froude number at ω_v = 3",
    )
    .own;
    assert_eq!(
        (other.verdict, other.recorded),
        (Verdict::NotMeasured, false)
    );
}

#[test]
fn a_recorded_method_that_no_claim_is_about_stands_beside_as_if_it_were_measured() {
    let claim = "Froude number at ω_v = 0";
    let recorded = RecordedExperiment {
        name: "fast".to_owned(),
        repeats: None,
        learner: None,
        runs: "trained earlier".to_owned(),
        seeds: vec![1, 2],
        claims: [(claim.to_owned(), vec![Some(0.21), Some(0.23)])].into(),
        studies: Vec::new(),
    };
    let seed = of("shipped controller", study(0.22, 0.9).steady);
    let beside = |studies: &[&Study], claim: &str| {
        let judged = judge_claims(studies, std::slice::from_ref(&recorded));
        let found = judged.into_iter().find(|j| j.claim == claim).unwrap();
        let told = |f: Finding| (f.experiment, f.verdict, f.recorded);
        found.beside.into_iter().map(told).collect::<Vec<_>>()
    };
    let shipped = ("shipped controller".to_owned(), Verdict::Holds, false);
    let fast = |verdict, recorded| ("fast".to_owned(), verdict, recorded);
    assert_eq!(
        beside(&[&seed], claim),
        [shipped.clone(), fast(Verdict::Holds, true)]
    );
    // Its runs on the page come first, and it has one column.
    let own = of("fast", study(0.5, 0.9).steady);
    assert_eq!(
        beside(&[&own, &seed], claim),
        [fast(Verdict::Fails, false), shipped]
    );
    let told = beside(&[&seed], "Froude number at ω_v = 3");
    assert_eq!(told[1], fast(Verdict::NotMeasured, false));
}

#[test]
fn runs_of_an_experiment_with_another_learner_have_a_finding_of_their_own() {
    let claim = "Froude number at ω_v = 0";
    let of_learner =
        |name: &str, repeats: Option<&str>, learner: &str, froude| RecordedExperiment {
            name: name.to_owned(),
            repeats: repeats.map(str::to_owned),
            learner: Some(learner.to_owned()),
            runs: "trained earlier".to_owned(),
            seeds: vec![1],
            claims: [(claim.to_owned(), vec![Some(froude)])].into(),
            studies: Vec::new(),
        };
    let recorded = [
        of_learner("paper", None, "fewer updates", 0.5),
        of_learner("paper, plain", Some("paper"), "plain", 0.22),
        of_learner("journal, plain", Some("journal"), "plain", 0.1),
    ];
    let told = |claim| {
        let judged = judged_with(&[&study(0.3, 0.9)], &recorded, claim);
        let told = |f: Finding| (f.experiment, f.verdict, f.recorded);
        let others = judged.other_learners.into_iter().map(told);
        assert_eq!(judged.beside.len(), 1, "only what no claim is about");
        (told(judged.own), others.collect::<Vec<_>>())
    };
    let (own, others) = told(claim);
    assert_eq!(own, ("paper".to_owned(), Verdict::Fails, true));
    assert_eq!(others, [("paper, plain".to_owned(), Verdict::Holds, true)]);
    // One finding for each learner, of a claim that it says nothing about, too.
    let (_, others) = told("least speed");
    let unmeasured = ("journal, plain".to_owned(), Verdict::NotMeasured, false);
    assert_eq!(others, [unmeasured]);
}

#[test]
fn what_comes_recorded_is_of_claims_that_there_are() {
    let claims = judge_claims(&[], &[]);
    for recorded in recorded_experiments().unwrap() {
        assert!(!recorded.seeds.is_empty() && !recorded.claims.is_empty());
        // Where two runs of an experiment learned differently, the page says of both what they learned with.
        assert!(recorded.repeats.is_none() || recorded.learner.is_some());
        let named = recorded.repeats.as_ref().unwrap_or(&recorded.name);
        // Every seed can be drawn: its motions from the least command on, and its whole training.
        for (study, &seed) in recorded.studies.iter().zip(&recorded.seeds) {
            assert_eq!((&study.group, study.seed), (&recorded.name, seed));
            assert_eq!(study.steady[0].omega_v, -0.5, "{}", study.name);
            assert!(study.steady.len() >= 81, "{}", study.name);
            assert!(study.course.len() >= 94, "{}", study.name);
        }
        assert_eq!(recorded.studies.len(), recorded.seeds.len());
        for (claim, values) in &recorded.claims {
            let known = claims.iter().find(|j| j.claim == claim);
            let known = known.unwrap_or_else(|| panic!("no claim {claim}"));
            let about = &known.own.experiment;
            assert!(about == named || about == known.source, "{claim}");
            assert_eq!(values.len(), recorded.seeds.len(), "{claim}");
        }
        // Nothing that is claimed of it is left out; a method that no claim is about stands beside those about the methods.
        let own = claims.iter().filter(|j| j.own.experiment == *named);
        let methods = claims.iter().filter(|j| j.own.experiment == j.source);
        let asked = match own.count() {
            0 => methods.count(),
            own => own,
        };
        assert_eq!(asked, recorded.claims.len(), "{}", recorded.name);
    }
}
