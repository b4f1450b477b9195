//! Contract: what the stage shows is what the program computes: the slider's history, written and read as a command
//! profile, replays the motion to the last bit; the gait is the analysis' own; pushes, other bodies and falls act, and the
//! history says when it alone no longer replays the motion; what cannot be is refused and changes nothing.

use crate::common::subject;
use gaitshift_analysis::GaitClass;
use gaitshift_analysis::recording::{COLUMNS, Column, Recording};
use gaitshift_experiment::{CommandProfile, Controller, Deterministic, Rollout};
use gaitshift_task::{Environment, RewardParameters};
use gaitshift_view::Stage;

fn walk(stage: &mut Stage, seconds: f64) {
    for _ in 0..(seconds / stage.control_period_s()).round() as u32 {
        stage.step();
    }
}

/// What `gaitshift transition --command-profile` computes from a history.
fn replayed(csv: &str, duration_s: f64) -> Recording {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("profile.csv");
    std::fs::write(&path, csv).unwrap();
    let profile = CommandProfile::read_csv(&path).unwrap();
    let mut subject = subject();
    let start = Environment::default_start(&subject.body, &subject.controller.task);
    Rollout {
        body: &subject.body,
        task: &subject.controller.task,
        start,
        profile: &profile,
        duration_s,
        seed: 0,
        disturbance: None,
        controller: "shipped",
    }
    .record(&mut Deterministic(&mut subject.controller.policy))
    .unwrap()
}

#[test]
fn the_sliders_history_replays_to_the_last_bit() {
    let mut stage = Stage::new(vec![subject()]);
    walk(&mut stage, 1.0);
    // A hand on the slider: uneven values at uneven times, some of them twice, down to the sign of zero.
    let mut x = 0.3_f64;
    for k in 0..400_u32 {
        x = 3.7 * x * (1.0 - x);
        if k % 7 != 3 {
            stage.set_omega_v(3.5 * x - 0.2).unwrap();
        }
        if k == 200 {
            stage.set_omega_v(-0.0).unwrap();
        }
        walk(&mut stage, 0.01 * f64::from(1 + k % 4));
    }
    stage.set_omega_v(0.0).unwrap();
    walk(&mut stage, 5.0);
    let csv = stage.history(0).unwrap().to_csv().unwrap();
    let live = stage.recording(0, 60.0).unwrap();
    let again = replayed(&csv, live.duration_s());
    assert!(live.len() > 1000);
    for name in COLUMNS {
        let column = Column::named(name).unwrap();
        let bits = |r: &Recording| {
            r.column(column)
                .iter()
                .map(|v| v.to_bits())
                .collect::<Vec<_>>()
        };
        assert_eq!(bits(&live), bits(&again), "{name}");
    }
    assert_eq!(live.metadata.body, again.metadata.body);
}

#[test]
fn the_slider_changes_the_gait_from_walking_to_running_and_back() {
    let mut stage = Stage::new(vec![subject()]);
    walk(&mut stage, 6.0);
    assert_eq!(stage.gait(0), GaitClass::Walking);
    stage.set_omega_v(3.0).unwrap();
    walk(&mut stage, 6.0);
    assert_eq!(stage.gait(0), GaitClass::Running);
    stage.set_omega_v(0.0).unwrap();
    walk(&mut stage, 8.0);
    assert_eq!(stage.gait(0), GaitClass::Walking);
}

#[test]
fn a_push_makes_it_stumble_and_the_history_says_so() {
    let mut stage = Stage::new(vec![subject()]);
    walk(&mut stage, 6.0);
    let pushed_at_s = stage.time_s();
    stage.push([300.0, 0.0], 0.1).unwrap();
    walk(&mut stage, 1.0);
    let pushed = stage.recording(0, 60.0).unwrap();
    let mut unpushed = Stage::new(vec![subject()]);
    walk(&mut unpushed, 7.0);
    let speed = |r: &Recording, time_s: f64| {
        let column = Column::named("x_velocity_m_per_s").unwrap();
        r.column(column)[(time_s / 0.01).round() as usize]
    };
    let unpushed = unpushed.recording(0, 60.0).unwrap();
    assert_eq!(speed(&pushed, pushed_at_s), speed(&unpushed, pushed_at_s));
    // 30 N s on 40 kg.
    let faster = speed(&pushed, pushed_at_s + 0.1) - speed(&unpushed, pushed_at_s + 0.1);
    assert!(faster > 0.3, "{faster} m/s faster");
    let csv = stage.history(0).unwrap().to_csv().unwrap();
    assert!(csv.starts_with("# pushed at 6"), "{csv}");
    assert!(csv.contains("does not replay"));
    walk(&mut stage, 7.0);
    assert_eq!(stage.gait(0), GaitClass::Walking, "it recovers");

    assert!(stage.push([2001.0, 0.0], 0.1).is_err());
    assert!(stage.push([f64::NAN, 0.0], 0.1).is_err());
    assert!(stage.push([1.0, 0.0], f64::INFINITY).is_err());
}

#[test]
fn a_fall_is_told_and_it_starts_again() {
    let mut stage = Stage::new(vec![subject()]);
    walk(&mut stage, 2.0);
    stage.push([-2000.0, 0.0], 1.0).unwrap();
    walk(&mut stage, 1.2);
    assert!(stage.fell(0));
    assert_eq!(stage.gait(0), GaitClass::Fallen);
    assert!(stage.recording(0, 60.0).unwrap().metadata.fell);
    walk(&mut stage, 1.6);
    assert!(!stage.fell(0));
    walk(&mut stage, 6.0);
    assert_eq!(stage.gait(0), GaitClass::Walking);
}

#[test]
fn another_body_goes_on_in_the_same_state() {
    let mut stage = Stage::new(vec![subject()]);
    walk(&mut stage, 3.0);
    let before = stage.recording(0, 1.0).unwrap();
    let change = |name: &str, value: f64| vec![(name.to_owned(), value)];
    stage.change_body(&change("hip_mass_kg", 26.0)).unwrap();
    let after = stage.recording(0, 1.0).unwrap();
    assert_eq!(stage.parameters(0).unwrap().hip_mass_kg, 26.0);
    assert_eq!(after.len(), 1, "a recording is of one body");
    let x = Column::named("x_m").unwrap();
    assert_eq!(before.column(x).last(), after.column(x).last());
    assert_eq!(after.metadata.total_mass_kg, 46.0);
    let csv = stage.history(0).unwrap().to_csv().unwrap();
    assert!(csv.contains("# the body was changed at 3"), "{csv}");

    let unchanged = stage.parameters(0).unwrap().clone();
    for (name, value) in [
        ("hip_mass_kg", 0.0),
        ("hip_mass_kg", f64::NAN),
        ("no_such_thing", 1.0),
        ("foot_sphere_count", 3.0),
        ("time_step_s", 0.001),
    ] {
        assert!(stage.change_body(&change(name, value)).is_err(), "{name}");
        assert_eq!(stage.parameters(0), Some(&unchanged));
    }
    stage.change_body(&[]).unwrap();
    let own = Controller::shipped().unwrap().body;
    assert_eq!(stage.parameters(0), Some(&own));
}

#[test]
fn two_bipeds_move_as_each_alone() {
    let mut both = Stage::new(vec![subject(), subject()]);
    let mut alone = Stage::new(vec![subject()]);
    for stage in [&mut both, &mut alone] {
        walk(stage, 2.0);
        stage.set_omega_v(1.7).unwrap();
        walk(stage, 2.0);
    }
    let of = |stage: &Stage, k: usize| stage.recording(k, 60.0).unwrap();
    assert_eq!(of(&both, 0), of(&alone, 0));
    assert_eq!(of(&both, 1), of(&alone, 0));
}

#[test]
fn memory_is_bounded_however_long_it_walks() {
    let mut stage = Stage::new(vec![subject()]);
    walk(&mut stage, 70.0);
    let kept = stage.recording(0, f64::MAX).unwrap();
    assert_eq!(kept.len(), 6000);
    assert!((stage.recording(0, 2.0).unwrap().duration_s() - 2.0).abs() < 1e-9);
}

#[test]
fn a_command_beyond_all_measure_is_refused() {
    let mut stage = Stage::new(vec![subject()]);
    for omega_v in [f64::NAN, f64::INFINITY, 100.1, -1e9] {
        assert!(stage.set_omega_v(omega_v).is_err());
        assert_eq!(stage.omega_v(), 0.0);
    }
}

#[test]
fn a_reward_term_of_ones_own_is_in_a_live_recording_as_in_a_rollout() {
    let mut own = subject();
    let term = serde_json::json!({"name": "height", "weight": 2.0, "expression": "z_m"});
    let reward: RewardParameters =
        serde_json::from_value(serde_json::json!({ "extra": [term] })).unwrap();
    own.controller.task.reward.extra = reward.extra;
    let mut stage = Stage::new(vec![own.clone()]);
    walk(&mut stage, 2.0);
    let live = stage.recording(0, 60.0).unwrap();
    let profile = CommandProfile::constant(0.0);
    let again = Rollout {
        body: &own.body,
        task: &own.controller.task,
        start: Environment::default_start(&own.body, &own.controller.task),
        profile: &profile,
        duration_s: live.duration_s(),
        seed: 0,
        disturbance: None,
        controller: "shipped",
    }
    .record(&mut Deterministic(&mut own.controller.policy))
    .unwrap();
    let height = |recording: &Recording| {
        let found = recording.every_column().find(|c| c.0 == "reward_height");
        found.map(|(_, values)| values.to_vec())
    };
    let values = height(&live).unwrap();
    assert_eq!(Some(&values), height(&again).as_ref());
    assert!(values.len() > 100 && values[1..].iter().all(|v| *v > 1.0));
    // It is in the page that plays a recording, too.
    let page = gaitshift_view::replay_html(&live).unwrap();
    assert!(page.contains("\"own_columns\":[\"reward_height\"]"));
}
