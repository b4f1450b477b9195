//! Contract: the means told of an experiment's reward are those of the shipped controller's motion on its body, under the last
//! phase's weights and own terms, up to where an episode ends; what earns nothing anywhere is left out.

use crate::common::moved;
use gaitshift_analysis::recording::column;
use gaitshift_experiment::{Controller, Earned, Experiment, earned};
use gaitshift_task::Disturbance;

fn experiment(text: &str) -> Experiment {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    std::fs::write(&path, text).unwrap();
    Experiment::read(&path).unwrap()
}

fn term(earned: &Earned, name: &str) -> Option<f64> {
    let found = earned.terms.iter().find(|(other, _)| other == name);
    found.map(|(_, value)| *value)
}

#[test]
fn the_means_are_those_of_a_recording() {
    let e = experiment("base = \"fast\"\n[body]\nfriction = 1.2\n");
    let motions = earned(&e).unwrap();
    let last = e.curriculum.total_steps() - 1;
    let settings = e.curriculum.at(last, &e.task.reward);
    let commands: Vec<f64> = motions.iter().map(|motion| motion.omega_v).collect();
    assert_eq!(commands, [0.0, 3.0], "where it is to walk and to run");
    let mut task = e.task.clone();
    task.reward = settings.reward;
    for motion in &motions {
        let mut controller = Controller::shipped().unwrap();
        (controller.body, controller.task) = (e.body.clone(), task.clone());
        let recording = moved(
            &mut controller,
            &Disturbance::default(),
            None,
            motion.omega_v,
            10.0,
        );
        for (name, column) in [
            ("energy", column::REWARD_ENERGY),
            ("velocity", column::REWARD_VELOCITY),
            ("forward", column::REWARD_FORWARD),
            ("alive", column::REWARD_ALIVE),
        ] {
            let series = recording.column(column);
            // The first row is the start's, before which nothing was earned.
            let mean = series[1..].iter().sum::<f64>() / (series.len() - 1) as f64;
            let told = term(motion, name).unwrap_or(0.0);
            assert!((told - mean).abs() < 1e-9, "{name}: {told}, {mean}");
        }
        assert!((motion.duration_s - 10.0).abs() < 1e-9 && !motion.ended);
    }
}

#[test]
fn own_terms_have_the_last_phases_weight_and_what_earns_nothing_is_left_out() {
    let e = experiment(
        "base = \"fast\"\n\
         [[task.reward.extra]]\nname = \"half\"\nweight = 0.1\nexpression = \"1\"\n\
         [[task.reward.extra]]\nname = \"never\"\nweight = 1.0\nexpression = \"0\"\n\
         [criteria]\ngaits = []\nchanges = []\n\
         [[curriculum.phases]]\nname = \"first\"\nsteps = 100000\nomega_v = [0, 3]\n\
         [[curriculum.phases]]\nname = \"last\"\nsteps = 100000\nomega_v = [2, 2]\nreward_extra = { half = 0.5 }\n",
    );
    let motions = earned(&e).unwrap();
    assert_eq!(motions.len(), 1, "one command alone: {motions:?}");
    assert_eq!(motions[0].omega_v, 2.0);
    assert!((term(&motions[0], "half").unwrap() - 0.5).abs() < 1e-12);
    assert!(term(&motions[0], "velocity").unwrap() > 1.0);
    for name in ["never", "symmetry"] {
        assert_eq!(term(&motions[0], name), None, "{name}");
    }
}

#[test]
fn the_means_of_a_motion_that_is_ended_are_up_to_its_end() {
    let e = experiment(
        "base = \"fast\"\n\
         [[task.reward.extra]]\nname = \"one\"\nweight = 1.0\nexpression = \"1\"\n\
         [[task.termination.extra]]\nname = \"soon\"\nexpression = \"time_s > 1\"\n",
    );
    for motion in earned(&e).unwrap() {
        assert!(
            (motion.duration_s - 1.0).abs() < 0.05 && motion.ended,
            "{motion:?}"
        );
        assert!((term(&motion, "one").unwrap() - 1.0).abs() < 1e-12);
    }
}
