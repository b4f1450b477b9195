//! Contract: a hardening is the same to the bit whatever the threads and whether or not it was stopped; its best controller meets at least as
//! many criteria as the one that it began with; ways over a step begin at its first touch; what is imitated is free of the noise that leads
//! beside a way; what a folder holds of something else is
//! neither taken nor lost.

use gaitshift_experiment::{Controller, Hardening, HardeningPlan, HardeningRound};
use std::path::Path;

fn plan() -> HardeningPlan {
    HardeningPlan {
        impulse_n_s: vec![[24.0, 30.0]],
        pushes: 3,
        steps_up: 2,
        motions: 6,
        adam_steps: 60,
        compared: 4,
        ..HardeningPlan::default()
    }
}

/// What `robust` was made of: a smaller network, and pushes that it does not withstand.
fn unhardened() -> Controller {
    let name = "../../controllers/robust/before-hardening.safetensors";
    Controller::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(name)).unwrap()
}

fn begin(plan: HardeningPlan, folder: &Path, threads: usize) -> Hardening {
    Hardening::new(unhardened(), plan, folder, threads, "gaitshift harden").unwrap()
}

/// What the state of a hardening holds under a name.
fn values(folder: &Path, name: &str) -> Vec<f32> {
    let state = std::fs::read(folder.join("state.safetensors")).unwrap();
    let state = safetensors::SafeTensors::deserialize(&state).unwrap();
    let numbers = state.tensor(name).unwrap().data().chunks_exact(4);
    numbers
        .map(|b| f32::from_le_bytes(b.try_into().unwrap()))
        .collect()
}

/// Without the wall-clock.
fn rounds(hardening: &Hardening) -> Vec<HardeningRound> {
    let untimed = |round: &HardeningRound| HardeningRound {
        elapsed_s: 0.0,
        ..round.clone()
    };
    hardening.rounds().iter().map(untimed).collect()
}

#[test]
fn stopped_and_continued_with_other_threads_it_is_the_same() {
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let mut at_once = begin(plan(), whole.path(), 1);
    at_once.round().unwrap();
    at_once.round().unwrap();
    begin(plan(), parts.path(), 3).round().unwrap();
    let mut continued = begin(plan(), parts.path(), 2);
    continued.round().unwrap();
    assert_eq!(rounds(&continued), rounds(&at_once));
    let last =
        |folder: &Path| Controller::read(&folder.join("controller-last.safetensors")).unwrap();
    let (one, other) = (last(whole.path()), last(parts.path()));
    assert_eq!(one.policy.tensors(), other.policy.tensors());
    let original = unhardened();
    assert_ne!(one.policy.tensors(), original.policy.tensors());
    // What is fitted is the half of a mean with the mirror image, so the sizes stay.
    assert_eq!(one.policy.shape(), original.policy.shape());

    let [first, rest @ ..] = &rounds(&continued)[..] else {
        panic!("no rounds")
    };
    assert_eq!(
        (first.round, first.met, first.criteria, first.best),
        (0, 38, 39, true)
    );
    let mut ways = [0, 0];
    for (round, number) in rest.iter().zip(1..) {
        assert_eq!(round.round, number);
        for (ways, outcomes) in ways.iter_mut().zip([round.pushes, round.steps_up]) {
            *ways += outcomes.found;
            assert_eq!(*ways > 0, outcomes.found_loss > 0.0);
        }
        for (outcomes, cases) in [(round.pushes, 3), (round.steps_up, 2)] {
            assert!(outcomes.alone + outcomes.found <= outcomes.met && outcomes.met <= cases);
            assert_eq!(outcomes.compared, 4);
        }
        assert!(round.weak_up <= round.weak_compared && round.weak_compared == 4);
        // At 0 it gets to a step before long, and undisturbed it never falls.
        assert_eq!((round.pushes.met, round.steps_up.met), (3, 2));
        assert!(round.before_loss > 0.0);
        assert!(!round.best || round.met >= 38, "{round:?}");
    }
    let best = rest.iter().rev().find(|round| round.best);
    let kept = Controller::read(&continued.best_path()).unwrap();
    match best {
        None => assert_eq!(kept.policy.tensors(), original.policy.tensors()),
        Some(_) => assert_ne!(kept.policy.tensors(), original.policy.tensors()),
    }
    let lines = std::fs::read_to_string(parts.path().join("rounds.jsonl")).unwrap();
    assert_eq!(lines.lines().count(), 3);
}

// What went wrong: after a kill between the state and the files made of it, the best controller was never written.
#[test]
fn what_a_kill_kept_from_being_written_is_written_by_the_next_call() {
    let folder = tempfile::tempdir().unwrap();
    let made = [
        "controller.safetensors",
        "controller-last.safetensors",
        "rounds.jsonl",
    ];
    begin(plan(), folder.path(), 2);
    let read = || made.map(|name| std::fs::read(folder.path().join(name)).unwrap());
    let before = read();
    for name in made {
        std::fs::remove_file(folder.path().join(name)).unwrap();
    }
    begin(plan(), folder.path(), 2);
    assert!(read() == before);
    // The best controller alone was told of, and was not there, or another.
    let best = folder.path().join(made[0]);
    std::fs::remove_file(&best).unwrap();
    begin(plan(), folder.path(), 2);
    assert!(read() == before);
    let shipped = Controller::read(Path::new("shipped")).unwrap();
    shipped.write(&best).unwrap();
    begin(plan(), folder.path(), 2);
    assert!(read() == before);
}

#[test]
fn what_the_folder_holds_of_something_else_stays() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |plan: HardeningPlan, controller: Controller| {
        let refused = Hardening::new(controller, plan, folder.path(), 1, "");
        refused.unwrap_err().to_string()
    };
    std::fs::write(folder.path().join("controller.safetensors"), "mine").unwrap();
    assert!(refused(plan(), unhardened()).contains("already holds controller.safetensors"));
    let mine = std::fs::read(folder.path().join("controller.safetensors")).unwrap();
    assert_eq!(mine, b"mine");
    std::fs::remove_file(folder.path().join("controller.safetensors")).unwrap();

    // It was emptied.
    std::fs::write(folder.path().join("lock"), "mine").unwrap();
    assert!(refused(plan(), unhardened()).contains("already holds lock"));
    assert_eq!(std::fs::read(folder.path().join("lock")).unwrap(), b"mine");
    std::fs::remove_file(folder.path().join("lock")).unwrap();

    let running = begin(plan(), folder.path(), 1);
    assert!(refused(plan(), unhardened()).contains("by another process"));
    drop(running);
    let other = HardeningPlan { seed: 2, ..plan() };
    let shipped = Controller::read(Path::new("shipped")).unwrap();
    for message in [refused(other, unhardened()), refused(plan(), shipped)] {
        assert!(
            message.contains("another controller, or with other"),
            "{message}"
        );
    }
    let state = folder.path().join("state.safetensors");
    let bytes = std::fs::read(&state).unwrap();
    std::fs::write(&state, &bytes[..bytes.len() / 2]).unwrap();
    assert!(
        refused(plan(), unhardened()).contains("restore it from a copy, or give another --out")
    );
}

// What went wrong: hardened with ways that begin before a foot touches the step, a controller learned nothing of steps.
#[test]
fn a_controller_that_stops_at_high_steps_finds_ways_over_them_from_their_first_touch_on() {
    let folder = tempfile::tempdir().unwrap();
    let plan = HardeningPlan {
        impulse_n_s: vec![[1.0, 1.0]],
        pushes: 1,
        step_up_m: vec![[0.06, 0.06]],
        steps_up: 6,
        compared: 1,
        ..plan()
    };
    let mut hardening = begin(plan, folder.path(), 2);
    let round = hardening.round().unwrap();
    let steps = round.steps_up;
    assert_eq!(steps.met, 6);
    assert!(steps.alone < 6 && steps.found > 0, "{steps:?}");
    assert_eq!((round.pushes.alone, round.pushes.found), (1, 0));
}

// Asked to answer a push at its begin, which it cannot see yet, a controller became so sharp that it fell from noise and weak pushes.
#[test]
fn what_is_imitated_grows_from_nothing_with_the_push() {
    let folder = tempfile::tempdir().unwrap();
    let plan = HardeningPlan {
        impulse_n_s: vec![[26.0, 26.0]],
        pushes: 6,
        steps_up: 0,
        ..plan()
    };
    let mut hardening = begin(plan, folder.path(), 2);
    let found = hardening.round().unwrap().pushes.found;
    assert!(found > 0);
    let observations = values(folder.path(), "push.found.00.observations");
    let actions = values(folder.path(), "push.found.00.actions");
    let mut original = unhardened();
    let mut own = vec![0.0; actions.len()];
    original
        .policy
        .mean_action(&observations, &mut own)
        .unwrap();
    let periods = (2.0 / original.task.control_period_s).round() as usize;
    let difference = |period: usize| {
        let both = 2 * period..2 * period + 2;
        both.map(|k| (actions[k] - own[k]).abs())
            .fold(0.0, f32::max)
    };
    assert!(difference(0) < 1e-5);
    assert!((0..periods).any(|period| difference(period) > 0.01));
}

// Where the body is led by noise too, the commands that are imitated are those without it.
#[test]
fn noise_leads_beside_the_way_and_is_not_imitated() {
    let folder = tempfile::tempdir().unwrap();
    let plan = HardeningPlan {
        impulse_n_s: vec![[1.0, 5.0]],
        steps_up: 0,
        ..plan()
    };
    begin(plan, folder.path(), 2).round().unwrap();
    let observations = values(folder.path(), "push.alone.00.observations");
    let actions = values(folder.path(), "push.alone.00.actions");
    // Three pushes that it withstands, 2 s of each once without noise and once with it.
    let mut original = unhardened();
    let periods = (2.0 / original.task.control_period_s).round() as usize;
    assert_eq!(actions.len(), 2 * (3 * 2 * periods));
    let mut own = vec![0.0; actions.len()];
    original
        .policy
        .mean_action(&observations, &mut own)
        .unwrap();
    for (imitated, own) in actions.iter().zip(&own) {
        assert!((imitated - own).abs() < 1e-5);
    }
    let (clean, noisy) = observations.split_at(observations.len() / 6);
    assert_ne!(clean, &noisy[..clean.len()]);
}

#[test]
fn a_wider_network_begins_with_what_the_controller_does() {
    let (folder, plan) = (
        tempfile::tempdir().unwrap(),
        HardeningPlan {
            hidden_units: 120,
            ..plan()
        },
    );
    let hardening = begin(plan.clone(), folder.path(), 2);
    assert_eq!(hardening.rounds()[0].met, 38);
    let begun = Controller::read(&hardening.best_path()).unwrap();
    // The mean of a policy of that width and its mirror image.
    assert_eq!(begun.policy.shape().hidden, [240, 240]);
    drop(hardening);
    let mut continued = begin(plan, folder.path(), 2);
    assert_eq!(continued.rounds().len(), 1);
    continued.round().unwrap();
    let last = Controller::read(&folder.path().join("controller-last.safetensors")).unwrap();
    assert_eq!(last.policy.shape(), begun.policy.shape());
    assert_ne!(last.policy.tensors(), begun.policy.tensors());
}

#[test]
fn a_plan_that_cannot_be_followed_is_refused() {
    for (plan, named) in [
        (
            HardeningPlan {
                omega_v: vec![],
                ..plan()
            },
            "commands",
        ),
        (
            HardeningPlan {
                omega_v: vec![f64::NAN],
                ..plan()
            },
            "commands",
        ),
        (
            HardeningPlan {
                impulse_n_s: vec![],
                ..plan()
            },
            "impulses",
        ),
        (
            HardeningPlan {
                impulse_n_s: vec![[2.0, 1.0]],
                ..plan()
            },
            "impulses",
        ),
        (
            HardeningPlan {
                impulse_n_s: vec![[0.0, 1e9]],
                ..plan()
            },
            "impulses",
        ),
        (
            HardeningPlan {
                pushes: 0,
                ..plan()
            },
            "pushes in a round is 0",
        ),
        (
            HardeningPlan {
                motions: 0,
                ..plan()
            },
            "motions is 0",
        ),
        (
            HardeningPlan {
                steps_up: 10_001,
                ..plan()
            },
            "steps up in a round is 10001",
        ),
        (
            HardeningPlan {
                step_omega_v: vec![],
                ..plan()
            },
            "commands for steps",
        ),
        (
            HardeningPlan {
                step_up_m: vec![[0.0, 0.03]],
                ..plan()
            },
            "heights of steps",
        ),
        (
            HardeningPlan {
                step_up_m: vec![[0.03, f64::NAN]],
                ..plan()
            },
            "heights of steps",
        ),
        (
            HardeningPlan {
                adam_steps: 0,
                ..plan()
            },
            "steps of Adam in a round is 0",
        ),
        (
            HardeningPlan {
                hidden_units: 4097,
                ..plan()
            },
            "hidden units is 4097",
        ),
        (
            HardeningPlan {
                before_weight: f64::NAN,
                ..plan()
            },
            "what the controller did before is NaN",
        ),
        (
            HardeningPlan {
                compared: 0,
                ..plan()
            },
            "pushes to compare by is 0",
        ),
    ] {
        let refused = plan.validate().unwrap_err();
        assert!(refused.contains(named), "{refused}");
    }
}

#[test]
fn what_it_did_before_weighs_more_with_steps_alone() {
    let pushes = HardeningPlan::default();
    assert_eq!(HardeningPlan::with_steps_up(0), pushes);
    let both = HardeningPlan::with_steps_up(240);
    assert_eq!((both.steps_up, both.pushes), (240, pushes.pushes));
    assert!(both.before_weight > pushes.before_weight && both.adam_steps > pushes.adam_steps);
    both.validate().unwrap();
}
