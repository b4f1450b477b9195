//! Contract: steps run from touchdown to touchdown; their frequency, length, duty factor and asymmetry
//! are those of the motion, and sliding feet are told from standing ones.

use crate::common::{Frame, Gait, close, record};
use gaitshift_analysis::recording::{Recording, Side, Window};
use gaitshift_analysis::steps::{
    LegTiming, Step, find_steps, foot_slide, step_frequency_hz, step_length_m, step_time_asymmetry,
    step_time_s, whole_strides,
};
use gaitshift_analysis::support::{ContactRule, Support};

fn analysed(recording: &Recording) -> (Support, Window, Vec<Step>) {
    let support = Support::find(recording, &ContactRule::default());
    let window = recording.window(1.0, 9.0).expect("rows");
    let steps = find_steps(recording, &support, window);
    (support, window, steps)
}

#[test]
fn steps_of_a_walk() {
    let recording = Gait::WALK.record(10.0);
    let (support, window, steps) = analysed(&recording);
    // Touchdowns at 1.0, 1.5, ... 9.0 s.
    assert_eq!(steps.len(), 16);
    assert_eq!((steps[0].from, steps[0].to), (Side::Right, Side::Left));
    assert!(steps.iter().all(|step| step.alternates()
        && step.double_support_periods == 20
        && step.flight_periods == 0));
    assert!((steps[3].start_s - 2.5).abs() < 1e-9 && (steps[3].duration_s - 0.5).abs() < 1e-9);
    close(step_frequency_hz(&steps), 2.0);
    close(step_length_m(&steps), 0.4);
    close(step_time_asymmetry(&steps), 0.0);
    for side in Side::BOTH {
        let timing = LegTiming::find(&recording, &support, side, window).expect("strides");
        close(Some(timing.duty_factor), 0.6);
        close(Some(timing.stance_s), 0.6);
        close(Some(timing.swing_s), 0.4);
    }
    let strides = whole_strides(&support, window).expect("strides");
    assert_eq!((strides.start_row(), strides.end_row()), (200, 1800));
}

#[test]
fn steps_of_a_run() {
    let recording = Gait::RUN.record(10.0);
    let (support, window, steps) = analysed(&recording);
    assert!(steps.iter().all(|step| step.alternates()
        && step.double_support_periods == 0
        && step.flight_periods == 20));
    close(step_frequency_hz(&steps), 1.0 / 0.35);
    close(step_length_m(&steps), 0.7);
    let timing = LegTiming::find(&recording, &support, Side::Left, window).expect("strides");
    close(Some(timing.duty_factor), 0.25 / 0.7);
}

#[test]
fn an_uneven_rhythm_shows_as_asymmetry() {
    let recording = Gait {
        left_phase: 0.6,
        ..Gait::WALK
    }
    .record(10.0);
    let (_, _, steps) = analysed(&recording);
    close(step_time_s(&steps, Side::Left), 0.6);
    close(step_time_s(&steps, Side::Right), 0.4);
    close(step_time_asymmetry(&steps), 0.4);
}

#[test]
fn whole_strides_end_with_the_foot_they_began_with() {
    let recording = Gait::WALK.record(10.0);
    let (support, _, _) = analysed(&recording);
    let strides = |start_s, end_s| {
        let window = recording.window(start_s, end_s).expect("rows");
        whole_strides(&support, window).map(|strides| (strides.start_row(), strides.end_row()))
    };
    assert_eq!(strides(1.2, 3.8), Some((300, 700)));
    assert_eq!(strides(1.2, 2.4), None);
    assert_eq!(strides(1.1, 1.4), None);
    // From a last touchdown of the left foot on it hops on the right one.
    let hopping = record(10.0, |time_s| {
        let mut frame = Gait::WALK.frame(time_s);
        frame.contact[1] &= time_s < 2.0;
        frame
    });
    let support = Support::find(&hopping, &ContactRule::default());
    let window = hopping.window(1.2, 5.0).expect("rows");
    let found = whole_strides(&support, window).expect("strides of the right foot");
    assert_eq!((found.start_row(), found.end_row()), (400, 1000));
}

#[test]
fn feet_that_stand_do_not_slide_and_skates_do() {
    let standing = Gait::WALK.record(10.0);
    let (support, window, _) = analysed(&standing);
    close(foot_slide(&standing, &support, window), 0.0);

    let skating = record(10.0, |time_s| Frame {
        psi_rad: [0.2, -0.2],
        ..Gait::WALK.frame(time_s)
    });
    let (support, window, _) = analysed(&skating);
    close(foot_slide(&skating, &support, window), 1.0);
}

#[test]
fn a_body_that_stays_put_has_no_steps_to_measure() {
    let recording = record(10.0, |_| Frame {
        contact: [true; 2],
        ..Frame::default()
    });
    let (support, window, steps) = analysed(&recording);
    assert!(steps.is_empty());
    assert_eq!(step_frequency_hz(&steps), None);
    assert_eq!(step_length_m(&steps), None);
    assert_eq!(step_time_asymmetry(&steps), None);
    assert_eq!(
        LegTiming::find(&recording, &support, Side::Right, window),
        None
    );
    assert_eq!(foot_slide(&recording, &support, window), None);
    assert_eq!(whole_strides(&support, window), None);
}
