//! Contract: training can begin with a controller; while only the critics learn the controller stays as it is to the
//! bit, and after that it moves; stopped and resumed in between, the bits are the same; one of other layers is refused.

use crate::common::{Until, file, unevaluated};
use gaitshift_experiment::{Controller, Experiment, Symmetry, Training, WarmStart};
use std::path::Path;

fn from_shipped(critic_steps: u64) -> Experiment {
    let mut experiment = unevaluated();
    experiment.learner.actor_hidden = vec![200, 200];
    experiment.training.symmetry = Symmetry::None; // with mirrored batches the controller would be a mean, in other tensors
    experiment.training.warm_start = Some(WarmStart {
        controller: "shipped".to_owned(),
        critic_steps,
    });
    experiment
}

fn trained(experiment: Experiment, folder: &Path) -> Controller {
    let mut training = Training::new(experiment, folder, "test").unwrap();
    assert!(training.run(&mut Until::default()).unwrap().finished);
    Controller::read(&folder.join("controller-last.safetensors")).unwrap()
}

#[test]
fn the_controller_stays_while_only_the_critics_learn_and_moves_after() {
    let root = tempfile::tempdir().unwrap();
    let shipped = Controller::shipped().unwrap().policy.tensors();
    let held = trained(from_shipped(u64::MAX), &root.path().join("held"));
    assert_eq!(held.policy.tensors(), shipped);
    assert!(held.provenance.updates > 100);
    let free = trained(from_shipped(5000), &root.path().join("free"));
    assert_ne!(free.policy.tensors(), shipped);
}

#[test]
fn a_resumed_run_holds_the_actor_as_long_as_an_uninterrupted_one() {
    let root = tempfile::tempdir().unwrap();
    let (whole, parts) = (root.path().join("whole"), root.path().join("parts"));
    trained(from_shipped(5000), &whole);
    Training::new(from_shipped(5000), &parts, "test")
        .unwrap()
        .run(&mut Until::step(2500))
        .unwrap();
    Training::resume(&parts)
        .unwrap()
        .run(&mut Until::default())
        .unwrap();
    let last = "controller-last.safetensors";
    assert_eq!(file(&whole, last), file(&parts, last));
}

#[test]
fn a_controller_of_other_layers_or_none_is_refused_before_anything_is_written() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("run");
    let refused = |experiment| {
        let error = Training::new(experiment, &folder, "test").unwrap_err();
        assert!(!folder.exists());
        error.to_string()
    };
    let mut smaller = from_shipped(0);
    smaller.learner.actor_hidden = vec![16, 16];
    let error = refused(smaller);
    assert!(
        error.contains("shipped")
            && error.contains("[200, 200]")
            && error.contains("learner.actor_hidden"),
        "{error}"
    );
    let mut missing = from_shipped(0);
    missing.training.warm_start = Some(WarmStart {
        controller: "no-such.safetensors".to_owned(),
        critic_steps: 0,
    });
    let error = refused(missing);
    assert!(error.contains("no-such.safetensors"), "{error}");
}
