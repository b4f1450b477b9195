//! Contract: walking is feet stepping in turn with double support in every step and no flight, running
//! the same with flight and no double support. Standing, skating, hopping, limping, pausing and changing
//! gait are neither, chatter and mirroring change nothing, and a fall is a fall.

use crate::common::{Frame, Gait, record};
use gaitshift_analysis::recording::{Recording, ended_by};
use gaitshift_analysis::{AnalysisOptions, GaitClass, GaitRule, summarise};

fn class(recording: &Recording) -> GaitClass {
    summarise(recording, &AnalysisOptions::default()).gait
}

fn class_of(motion: impl Fn(f64) -> Frame) -> GaitClass {
    class(&record(20.0, motion))
}

#[test]
fn walking_and_running_are_recognised() {
    assert_eq!(class(&Gait::WALK.record(20.0)), GaitClass::Walking);
    assert_eq!(class(&Gait::RUN.record(20.0)), GaitClass::Running);
    assert_eq!(
        class_of(|time_s| Gait::WALK.frame(time_s).mirrored()),
        GaitClass::Walking
    );
    assert_eq!(
        class_of(|time_s| Gait::RUN.frame(time_s).mirrored()),
        GaitClass::Running
    );
    let backwards = |time_s: f64| {
        Gait {
            speed_m_per_s: -0.4,
            ..Gait::WALK
        }
        .frame(time_s)
    };
    assert_eq!(class_of(backwards), GaitClass::Walking);
}

#[test]
fn standing_still_is_standing() {
    assert_eq!(
        class_of(|_| Frame {
            contact: [true; 2],
            ..Frame::default()
        }),
        GaitClass::Standing
    );
    assert_eq!(
        class_of(|_| Frame {
            contact: [true, false],
            ..Frame::default()
        }),
        GaitClass::Standing
    );
}

#[test]
fn treading_on_the_spot_is_standing() {
    let treading = Gait {
        speed_m_per_s: 0.0,
        ..Gait::WALK
    };
    assert_eq!(class(&treading.record(20.0)), GaitClass::Standing);
    let slow = Gait {
        speed_m_per_s: 0.09,
        ..Gait::WALK
    };
    assert_eq!(class(&slow.record(20.0)), GaitClass::Standing);
    let faster = Gait {
        speed_m_per_s: 0.11,
        ..Gait::WALK
    };
    assert_eq!(class(&faster.record(20.0)), GaitClass::Walking);
}

#[test]
fn skating_is_not_walking() {
    let on_both_feet = |time_s| Frame {
        contact: [true; 2],
        psi_rad: [0.2, -0.2],
        ..Gait::WALK.frame(time_s)
    };
    assert_eq!(class_of(on_both_feet), GaitClass::Standing);
    // The feet are lifted in turn, but it is sliding that brings the body forward.
    let lifting_feet = |time_s| Frame {
        psi_rad: [0.2, -0.2],
        ..Gait::WALK.frame(time_s)
    };
    assert_eq!(class_of(lifting_feet), GaitClass::Mixed);
    // Nothing but the sliding speaks against it.
    let slippery = GaitRule {
        max_foot_slide: 1.1,
        ..GaitRule::default()
    };
    let options = AnalysisOptions {
        rule: slippery,
        ..AnalysisOptions::default()
    };
    assert_eq!(
        summarise(&record(20.0, lifting_feet), &options).gait,
        GaitClass::Walking
    );
}

#[test]
fn hopping_is_not_running() {
    let on_one_leg = |time_s: f64| Frame {
        contact: [time_s.rem_euclid(0.35) < 0.25, false],
        ..Gait::RUN.frame(time_s)
    };
    assert_eq!(class_of(on_one_leg), GaitClass::Mixed);
    let on_both_legs = |time_s: f64| Frame {
        contact: [time_s.rem_euclid(0.35) < 0.25; 2],
        ..Gait::RUN.frame(time_s)
    };
    assert_eq!(class_of(on_both_legs), GaitClass::Mixed);
    let on_both_legs_one_late = Gait {
        left_phase: 0.05,
        ..Gait::RUN
    };
    assert_eq!(class(&on_both_legs_one_late.record(20.0)), GaitClass::Mixed);
    let on_the_spot = |time_s| Frame {
        x_m: 0.0,
        ..on_one_leg(time_s)
    };
    assert_eq!(class_of(on_the_spot), GaitClass::Mixed);
}

#[test]
fn dragging_one_leg_is_not_walking() {
    let dragging = |time_s: f64| Frame {
        contact: [true, Gait::WALK.frame(time_s).contact[1]],
        ..Gait::WALK.frame(time_s)
    };
    assert_eq!(class_of(dragging), GaitClass::Mixed);
}

#[test]
fn limping_is_neither() {
    let even_enough = GaitRule {
        max_step_time_asymmetry: 0.5,
        ..GaitRule::default()
    };
    let options = AnalysisOptions {
        rule: even_enough,
        ..AnalysisOptions::default()
    };
    let walk = |left_phase| {
        Gait {
            left_phase,
            stance_s: 0.7,
            ..Gait::WALK
        }
        .record(20.0)
    };
    for left_phase in [0.44, 0.5, 0.56] {
        assert_eq!(class(&walk(left_phase)), GaitClass::Walking, "{left_phase}");
    }
    for left_phase in [0.4, 0.6] {
        assert_eq!(class(&walk(left_phase)), GaitClass::Mixed, "{left_phase}");
        // Nothing but the rhythm speaks against it.
        assert_eq!(
            summarise(&walk(left_phase), &options).gait,
            GaitClass::Walking
        );
    }
    let run = Gait {
        left_phase: 0.6,
        ..Gait::RUN
    }
    .record(20.0);
    assert_eq!(class(&run), GaitClass::Mixed);
    assert_eq!(summarise(&run, &options).gait, GaitClass::Running);
}

#[test]
fn grounded_running_is_neither() {
    // No flight, and no double support but what a change of feet within one period looks like.
    assert_eq!(
        class(
            &Gait {
                stance_s: 0.35,
                ..Gait::RUN
            }
            .record(20.0)
        ),
        GaitClass::Mixed
    );
    assert_eq!(
        class(
            &Gait {
                stance_s: 0.355,
                ..Gait::RUN
            }
            .record(20.0)
        ),
        GaitClass::Mixed
    );
    assert_eq!(
        class(
            &Gait {
                stance_s: 0.36,
                ..Gait::RUN
            }
            .record(20.0)
        ),
        GaitClass::Walking
    );
    assert_eq!(
        class(
            &Gait {
                stance_s: 0.345,
                ..Gait::RUN
            }
            .record(20.0)
        ),
        GaitClass::Mixed
    );
    assert_eq!(
        class(
            &Gait {
                stance_s: 0.34,
                ..Gait::RUN
            }
            .record(20.0)
        ),
        GaitClass::Running
    );
}

#[test]
fn flight_in_every_second_step_is_neither() {
    let skipping = |time_s: f64| {
        let since_s = time_s.rem_euclid(0.7);
        Frame {
            contact: [since_s < 0.4, (0.35..0.6).contains(&since_s)],
            ..Gait::RUN.frame(time_s)
        }
    };
    assert_eq!(class_of(skipping), GaitClass::Mixed);
}

#[test]
fn pausing_and_changing_gait_are_mixed() {
    let stopping = |time_s: f64| Gait::WALK.frame(time_s.min(15.3));
    assert_eq!(class_of(stopping), GaitClass::Mixed);
    let changing = |time_s: f64| {
        if time_s < 12.0 {
            Gait::WALK.frame(time_s)
        } else {
            Gait::RUN.frame(time_s - 12.0)
        }
    };
    assert_eq!(class_of(changing), GaitClass::Mixed);
}

#[test]
fn chatter_changes_nothing() {
    for gait in [Gait::WALK, Gait::RUN] {
        let clean = gait.record(20.0);
        let chattering = record(20.0, |time_s| {
            let mut frame = gait.frame(time_s);
            let stride_s = 2.0 * gait.step_s;
            for (side, phase) in [0.0, 0.5].into_iter().enumerate() {
                let since_s = (time_s - phase * stride_s).rem_euclid(stride_s);
                let bounces = (0.01..0.02).contains(&since_s);
                let scuffs = (stride_s - 0.15..stride_s - 0.14).contains(&since_s);
                frame.contact[side] = (frame.contact[side] && !bounces) || scuffs;
            }
            frame
        });
        assert_ne!(clean, chattering);
        let options = AnalysisOptions::default();
        let (mut scuffing, clean) = (
            summarise(&chattering, &options),
            summarise(&clean, &options),
        );
        // One scuff of each foot a stride is seen and counted, and changes nothing else.
        let scuffs = scuffing.scuffs_per_step.expect("steps");
        assert!((scuffs - 1.0).abs() < 0.05, "{scuffs}");
        scuffing.scuffs_per_step = clean.scuffs_per_step;
        assert_eq!(scuffing, clean);
    }
}

#[test]
fn one_stumble_in_twenty_steps_is_tolerated_and_two_are_not() {
    // The window holds 29 steps; a stumbling one has no double support.
    let stumbling = |stumbles: usize| {
        record(20.0, move |time_s| {
            let mut frame = Gait::WALK.frame(time_s);
            let step = (time_s / 0.5).floor() as usize;
            let since_s = time_s.rem_euclid(0.5);
            if (20..20 + stumbles).contains(&step) && since_s < 0.1 {
                // The foot behind leaves early.
                frame.contact = if step.is_multiple_of(2) {
                    [true, false]
                } else {
                    [false, true]
                };
            }
            frame
        })
    };
    assert_eq!(class(&stumbling(1)), GaitClass::Walking);
    assert_eq!(class(&stumbling(2)), GaitClass::Mixed);
}

#[test]
fn a_fall_is_a_fall() {
    let mut recording = Gait::WALK.record(20.0);
    recording.metadata.fell = true;
    assert_eq!(class(&recording), GaitClass::Fallen);
    recording.metadata.fell = false;
    recording.metadata.ended_by = ended_by::DIVERGED.to_owned();
    assert_eq!(class(&recording), GaitClass::Fallen);
}

#[test]
fn the_rule_can_be_changed() {
    let hurried = AnalysisOptions {
        rule: GaitRule {
            min_speed_m_per_s: 0.9,
            ..GaitRule::default()
        },
        ..AnalysisOptions::default()
    };
    assert_eq!(
        summarise(&Gait::WALK.record(20.0), &hurried).gait,
        GaitClass::Standing
    );
}

#[test]
fn rules_are_read_strictly_and_completed_by_defaults() {
    let rule: GaitRule =
        serde_json::from_str(r#"{"min_steps": 8, "contact": {"min_gap_s": 0.01}}"#).expect("read");
    assert_eq!((rule.min_steps, rule.contact.min_gap_s), (8, 0.01));
    assert_eq!(rule.max_foot_slide, GaitRule::default().max_foot_slide);
    assert!(serde_json::from_str::<GaitRule>(r#"{"min_step": 8}"#).is_err());
    assert_eq!(
        serde_json::to_string(&GaitClass::Walking).expect("json"),
        "\"walking\""
    );
    assert_eq!(GaitClass::Running.to_string(), "running");
}
