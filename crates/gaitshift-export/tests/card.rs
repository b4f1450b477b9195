//! Contract: a card tells what the judgement measured, the controller's origin and what its body has of its own; a licence
//! that would break its YAML header is refused.

use gaitshift_body::{Body, BodyParameters};
use gaitshift_experiment::{Controller, Criteria, Deterministic, Judgement, judge};
use gaitshift_export::card;

fn judged(controller: &mut Controller) -> Judgement {
    let body = Body::new(controller.body.clone()).unwrap();
    let criteria = Criteria::default();
    let mut policy = Deterministic(&mut controller.policy);
    judge(&body, &controller.task, &criteria, &mut policy).unwrap()
}

#[test]
fn it_tells_what_was_measured_and_where_it_comes_from() {
    let mut controller = Controller::shipped().unwrap();
    controller.body = BodyParameters::default();
    controller.provenance.experiment_digest = Some("0123abcd".to_owned());
    let judgement = judged(&mut controller);
    let text = card(&controller, &judgement, "c.safetensors", Some("mit")).unwrap();
    assert!(text.starts_with("---\n") && text.contains("\nlicense: mit\n"));
    for row in &judgement.rows {
        let line = format!("| {} | {} |", row.omega_v, row.summary.gait);
        assert!(text.contains(&line), "{line}");
    }
    let p = &controller.provenance;
    for word in [
        p.command.clone(),
        format!("`{}` (digest 0123abcd), seed {}", p.experiment, p.seed),
        format!("{} environment steps", p.environment_steps),
        format!("{} of {} criteria", judgement.met(), judgement.checks.len()),
        "gaitshift demo --controller c.safetensors".to_owned(),
    ] {
        assert!(text.contains(&word), "{word}");
    }
    assert!(text.contains("default body") && !text.contains("differs"));
}

#[test]
fn what_the_body_has_of_its_own_and_what_is_not_met_is_said() {
    let mut controller = Controller::shipped().unwrap();
    controller.body.friction = 0.25;
    controller.provenance.experiment_digest = None;
    let judgement = judged(&mut controller);
    let text = card(&controller, &judgement, "c.safetensors", None).unwrap();
    assert!(text.contains("(digest unknown)"));
    assert!(!text.contains("license:"));
    assert!(text.contains("| `friction` | 0.25 | 1.0 |"), "{text}");
    let missed = judgement.checks.iter().find(|check| !check.met).unwrap();
    assert!(text.contains("Not met: ") && text.contains(&missed.name));
}

#[test]
fn a_licence_that_would_break_the_header_is_refused() {
    let mut controller = Controller::shipped().unwrap();
    let judgement = judged(&mut controller);
    for licence in ["", "mit\ntags: x", "a: b", "\""] {
        let error = card(&controller, &judgement, "c", Some(licence)).unwrap_err();
        assert!(error.to_string().contains("apache-2.0"), "{error}");
    }
}
