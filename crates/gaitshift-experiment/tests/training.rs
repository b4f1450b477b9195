//! Contract: the same configuration and seed give the same bits whatever the number of threads; a
//! resumed run equals an uninterrupted one, controller and logs, randomized episodes included; values are those of a
//! command when held; a step ends in what the next one sees; a controller file needs nothing else and broken ones are refused; nothing overwrites an existing run.

use crate::common::{Until, file, text, tiny};
use gaitshift_experiment::{Control, Controller, Deterministic, Evaluation, Experiment, Training};
use gaitshift_sac::Agent;
use gaitshift_task::{OBSERVATION_SIZE, Overrides};
use std::path::Path;

fn on_threads(threads: usize) -> Experiment {
    let mut experiment = tiny();
    experiment.learner.threads = threads;
    experiment
}

/// The parts of a log that do not tell the wall-clock.
fn without_clock(folder: &Path) -> Vec<String> {
    let text = text(folder, "metrics.csv");
    let clock = text.lines().next().and_then(|header| {
        header
            .split(',')
            .position(|name| name.ends_with("elapsed_s"))
    });
    text.lines()
        .map(|line| {
            let keep = |(i, v)| (Some(i) != clock).then_some(v);
            line.split(',')
                .enumerate()
                .filter_map(keep)
                .collect::<Vec<&str>>()
                .join(",")
        })
        .collect()
}

/// Learns nothing, so that all evaluations score the same and the first is kept.
fn untaught() -> Experiment {
    let mut experiment = tiny();
    experiment.training.learning_starts = 1_000_000;
    experiment.training.evaluation_interval_steps = 1000;
    for phase in &mut experiment.curriculum.phases {
        (phase.learner, phase.learner_end) = (Overrides::default(), Overrides::default());
    }
    experiment
}

// Judged undisturbed, a controller is at its best before it has met any disturbance: that of a run with a last phase of
// disturbances was the one from before it.
#[test]
fn where_phases_randomize_what_has_met_no_disturbance_is_not_the_best() {
    let folder = tempfile::tempdir().unwrap();
    let mut experiment = untaught();
    let best = |experiment: &Experiment, name: &str| {
        let run = folder.path().join(name);
        let report = Training::new(experiment.clone(), &run, "")
            .unwrap()
            .run(&mut Until::default())
            .unwrap();
        let evaluations = Evaluation::read_all(&run).unwrap();
        let best = Evaluation::best(&evaluations).unwrap();
        assert_eq!(Some(best.step), report.best_step);
        for e in &evaluations {
            let randomized = experiment.curriculum.randomizes_by(e.step - 1);
            assert_eq!(e.disturbed_survival.is_some(), randomized, "{}", e.step);
            assert!(
                e.disturbed_survival
                    .is_none_or(|share| (0.0..=1.0).contains(&share))
            );
        }
        let controller = Controller::read(&run).unwrap();
        assert_eq!(controller.provenance.environment_steps, best.step);
        best.step
    };
    // At 2000 the phase that randomizes only begins.
    assert_eq!(best(&experiment, "randomized"), 3000);
    for phase in &mut experiment.curriculum.phases {
        phase.randomization = None;
    }
    assert_eq!(best(&experiment, "plain"), 1000);
}

// The best score stayed that under the disturbances before, which no controller under harder ones could exceed.
#[test]
fn edited_disturbances_choose_the_best_controller_anew() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let mut experiment = untaught();
    let report = Training::new(experiment.clone(), &run, "")
        .unwrap()
        .run(&mut Until::step(3500))
        .unwrap();
    assert!(report.best_step == Some(3000) && report.step < 6000);
    let before = report.step;
    let drawn = experiment.curriculum.phases[2].randomization.as_mut();
    drawn.unwrap().latency_s = [0.0, 0.02];
    let edited = experiment.to_toml().unwrap();
    std::fs::write(run.join("config.toml"), &edited).unwrap();
    let mut until = Until::default();
    let report = Training::resume(&run).unwrap().run(&mut until).unwrap();
    let best = report.best_step.unwrap();
    assert!(best > before, "{best}");
    assert!(
        until
            .notes
            .iter()
            .any(|n| n.contains("begins anew") && n.contains("step-0000003000")),
        "{:?}",
        until.notes
    );
    let evaluations = Evaluation::read_all(&run).unwrap();
    for e in &evaluations {
        assert_eq!(
            e.disturbance_edits,
            u32::from(e.step > before),
            "{}",
            e.step
        );
    }
    assert_eq!(Evaluation::best(&evaluations).unwrap().step, best);
    let controller = Controller::read(&run).unwrap();
    assert_eq!(controller.provenance.environment_steps, best);
}

// Only what is drawn at random was compared, and in a run without that nothing was, though the starts and endings of its
// motions decide every criterion.
#[test]
fn edits_of_what_controllers_are_judged_by_choose_the_best_anew_and_others_do_not() {
    let root = tempfile::tempdir().unwrap();
    let after = |name: &str, randomizes: bool, edit: &dyn Fn(&mut Experiment)| {
        let run = root.path().join(name);
        let mut experiment = untaught();
        if !randomizes {
            for phase in &mut experiment.curriculum.phases {
                phase.randomization = None;
            }
        }
        // Nothing that comes later is better than the first.
        experiment.training.evaluation_interval_steps = 3000;
        let report = Training::new(experiment.clone(), &run, "")
            .unwrap()
            .run(&mut Until::step(3500))
            .unwrap();
        assert_eq!(report.best_step, Some(3000));
        edit(&mut experiment);
        let edited = experiment.to_toml().unwrap();
        std::fs::write(run.join("config.toml"), &edited).unwrap();
        let mut until = Until::default();
        Training::resume(&run).unwrap().run(&mut until).unwrap();
        let told = until.notes.iter().any(|n| n.contains("begins anew"));
        let evaluations = Evaluation::read_all(&run).unwrap();
        assert_eq!(
            evaluations.last().unwrap().disturbance_edits,
            u32::from(told)
        );
        told
    };
    let pitch = |e: &mut Experiment| e.task.termination.pitch_limit_rad = 1.0;
    let range = |e: &mut Experiment| e.curriculum.phases[2].omega_v[1] = 3.0;
    let limit = |e: &mut Experiment| e.task.termination.time_limit_s = 100.0;
    let more = |e: &mut Experiment| e.curriculum.phases[2].steps += 1000;
    assert!(after("pitch", true, &pitch));
    assert!(after("plain-pitch", false, &pitch));
    assert!(after("range", true, &range));
    assert!(!after("plain-range", false, &range));
    assert!(after("limit", true, &limit));
    assert!(!after("plain-limit", false, &limit));
    assert!(!after("more", true, &more));
}

#[test]
fn threads_and_interruptions_do_not_change_a_bit() {
    let root = tempfile::tempdir().unwrap();
    let at = |name: &str| root.path().join(name);

    let whole = at("whole");
    let mut observer = Until::default();
    let report = Training::new(tiny(), &whole, "test")
        .unwrap()
        .run(&mut observer)
        .unwrap();
    assert!(report.finished && report.step == 6000 && observer.evaluations == 3);
    let [note] = observer.notes.as_slice() else {
        panic!("{:?}", observer.notes)
    };
    assert!(note.starts_with("rehearsing the walk of step 4"), "{note}");
    assert_eq!(report.updates, (6000 - 500) / 8 + 1);
    assert_eq!(without_clock(&whole).len(), 1 + 6);
    let agent = Agent::load(&whole.join("checkpoint/agent.safetensors")).unwrap();
    assert!(agent.rehearsal().is_some_and(|walk| walk.rows() <= 1000));
    assert!(whole.join("controller-walk.safetensors").exists());

    let threaded = at("threaded");
    Training::new(on_threads(2), &threaded, "test")
        .unwrap()
        .run(&mut Until::default())
        .unwrap();

    let broken = at("broken");
    let stopped = Training::new(tiny(), &broken, "test")
        .unwrap()
        .run(&mut Until::step(2500))
        .unwrap();
    // In the middle of a phase that moves learning rate, α, horizon and entropy.
    let s = tiny().learner_at(stopped.step);
    assert!(
        !stopped.finished && s.alpha > 0.05 && s.alpha < 0.1,
        "{s:?}"
    );
    let report = Training::resume(&broken)
        .unwrap()
        .run(&mut Until::default())
        .unwrap();
    assert!(report.finished);

    for other in [&threaded, &broken] {
        assert_eq!(
            file(&whole, "controller-last.safetensors"),
            file(other, "controller-last.safetensors")
        );
        assert_eq!(file(&whole, "episodes.csv"), file(other, "episodes.csv"));
        assert_eq!(without_clock(&whole), without_clock(other));
    }
    assert_eq!(
        file(&whole, "checkpoint/replay.safetensors"),
        file(&broken, "checkpoint/replay.safetensors")
    );

    let error = Training::new(tiny(), &whole, "test")
        .unwrap_err()
        .to_string();
    assert!(error.contains("--resume"), "{error}");

    // The controller runs from its file alone, and broken files are refused.
    let path = whole.join("controller-last.safetensors");
    let mut controller = Controller::read(&path).unwrap();
    assert_eq!(controller.provenance.environment_steps, 6000);
    assert_eq!(controller.body, tiny().body);
    let mut action = [9.0; 2];
    Deterministic(&mut controller.policy).act(&[0.1; 14], &mut action);
    assert!(action.iter().all(|a| a.abs() <= 1.0));
    let bytes = std::fs::read(&path).unwrap();
    for length in [0, 4, 100, bytes.len() / 2, bytes.len() - 1] {
        let error = Controller::from_bytes(&bytes[..length], &path)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("controller-last") && error.contains("`gaitshift train` wrote"),
            "{error}"
        );
    }
    let foreign = Controller::from_bytes(&file(&whole, "checkpoint/agent.safetensors"), &path);
    assert!(foreign.unwrap_err().to_string().contains("another program"));

    // A damaged checkpoint is refused, not half-read.
    let state = whole.join("checkpoint/state.json");
    let text = std::fs::read_to_string(&state).unwrap();
    std::fs::write(&state, &text[..text.len() / 2]).unwrap();
    let error = Training::resume(&whole).unwrap_err().to_string();
    assert!(
        error.contains("state.json") && error.contains("damaged"),
        "{error}"
    );
    let error = Training::resume(&at("nowhere")).unwrap_err().to_string();
    assert!(error.contains("config.toml"), "{error}");
}

#[test]
fn a_changing_command_cuts_transitions_off_and_keeps_to_its_value() {
    const ENVIRONMENTS: usize = 4;
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("run");
    let mut experiment = tiny();
    experiment.curriculum.command.redraw_interval_s = 0.1;
    // Large enough that nothing is overwritten: neighbouring slots are neighbouring steps.
    experiment.training.replay_capacity = 10_000;
    Training::new(experiment, &folder, "test")
        .unwrap()
        .run(&mut Until::step(2500))
        .unwrap();
    let bytes = file(&folder, "checkpoint/replay.safetensors");
    let replay = safetensors::SafeTensors::deserialize(&bytes).unwrap();
    let observations = |name: &str| -> Vec<[f32; OBSERVATION_SIZE]> {
        let data = replay.tensor(name).unwrap().data();
        let float = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
        data.chunks_exact(4 * OBSERVATION_SIZE)
            .map(|row| std::array::from_fn(|i| float(&row[4 * i..])))
            .collect()
    };
    let (seen, seen_next) = (
        observations("observations"),
        observations("next_observations"),
    );
    let command = |o: &[f32; OBSERVATION_SIZE]| o[OBSERVATION_SIZE - 1];
    let now: Vec<f32> = seen.iter().map(command).collect();
    let next: Vec<f32> = seen_next.iter().map(command).collect();
    let flags = replay.tensor("flags").unwrap().data();
    assert_eq!(now, next);
    // Noise of the sensors included.
    for slot in (0..now.len() - ENVIRONMENTS).filter(|&slot| flags[slot] == 0) {
        assert_eq!(seen_next[slot], seen[slot + ENVIRONMENTS], "slot {slot}");
    }
    let mut changes = 0;
    for slot in 0..now.len() - ENVIRONMENTS {
        if now[slot + ENVIRONMENTS] != now[slot] {
            assert_ne!(flags[slot] & 0b11, 0, "slot {slot} goes on");
            changes += 1;
        }
    }
    assert!(changes > 100, "{changes}");
}
