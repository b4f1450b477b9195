//! Contract: a batch does not depend on how its environments are grouped; the command moves only where it is asked to, and
//! is held over falls where it is asked for.

use gaitshift_body::{Body, BodyParameters};
use gaitshift_task::{
    CommandDraw, Curriculum, EndReason, EnvironmentBatch, RewardParameters, TaskParameters,
};

fn body() -> Body {
    Body::new(BodyParameters::default()).unwrap()
}

#[test]
fn a_batch_does_not_depend_on_its_size() {
    let (task, curriculum) = (TaskParameters::default(), Curriculum::default());
    let mut settings = curriculum.at(0, &task.reward);
    settings.command.redraw_interval_s = 0.5;
    let run = |count| {
        let mut batch = EnvironmentBatch::new(body(), task.clone(), count, 7, &settings);
        for _ in 0..600 {
            for i in 0..count {
                let (_, finished) = batch.step(i, [0.5, 0.3], 0.0, &settings);
                if finished.is_some() {
                    batch.reset(i, &settings);
                }
            }
        }
        batch.environment(1).observation()
    };
    assert_eq!(run(2), run(5));
}

#[test]
fn the_command_stays_within_an_episode_unless_asked_to_change() {
    let (task, curriculum) = (TaskParameters::default(), Curriculum::default());
    let mut settings = curriculum.at(5_000_000, &task.reward);
    for (interval, changes) in [(0.0, false), (0.05, true)] {
        settings.command = CommandDraw {
            redraw_interval_s: interval,
            redraw_ramp_s: 0.1,
            ..CommandDraw::default()
        };
        let mut batch = EnvironmentBatch::new(body(), task.clone(), 1, 3, &settings);
        let first = batch.environment(0).omega_v;
        let mut seen = false;
        for _ in 0..50 {
            batch.step(0, [0.5, 0.5], 0.0, &settings);
            let now = batch.environment(0).omega_v;
            assert!((-0.5..=3.5).contains(&now));
            seen |= now != first;
        }
        assert_eq!(seen, changes);
    }
}

/// Commands of `periods` periods of one environment whose legs give way again and again, and the periods
/// in which an episode ended with its reason.
fn commands_of_a_body_that_falls(
    hold_periods: u32,
    periods: u32,
) -> (Vec<f64>, Vec<(u32, EndReason)>) {
    let task = TaskParameters::default();
    let curriculum = Curriculum {
        command: CommandDraw {
            hold_periods,
            ..CommandDraw::default()
        },
        ..Curriculum::default()
    };
    let settings = curriculum.at(curriculum.total_steps(), &task.reward);
    let mut batch = EnvironmentBatch::new(body(), task, 1, 5, &settings);
    let (mut commands, mut ends) = (Vec::new(), Vec::new());
    for period in 1..=periods {
        commands.push(batch.environment(0).omega_v);
        let (outcome, finished) = batch.step(0, [-1.0, -1.0], 0.0, &settings);
        assert_eq!(outcome.ended.is_some(), finished.is_some());
        if let Some(ended) = outcome.ended {
            ends.push((period, ended));
            batch.reset(0, &settings);
        }
    }
    (commands, ends)
}

#[test]
fn a_held_command_goes_on_after_falls_until_its_time_is_over() {
    let (commands, ends) = commands_of_a_body_that_falls(250, 750);
    for held in commands.chunks(250) {
        assert!(held.iter().all(|c| *c == held[0]), "{held:?}");
    }
    assert!(commands[0] != commands[250] && commands[250] != commands[500]);
    let cut: Vec<u32> = ends
        .iter()
        .filter(|(_, ended)| *ended == EndReason::TimeLimit)
        .map(|(period, _)| *period)
        .collect();
    assert_eq!(cut, [250, 500, 750]);
    assert!(
        ends.len() > 2 * cut.len(),
        "it should fall in between: {ends:?}"
    );
}

#[test]
fn a_command_that_is_not_held_is_drawn_for_every_episode() {
    let (commands, ends) = commands_of_a_body_that_falls(0, 750);
    for (period, ended) in &ends[..ends.len() - 1] {
        assert_eq!(*ended, EndReason::HipHeight);
        let period = *period as usize;
        assert!(commands[period] != commands[period - 1]);
    }
}

#[test]
fn a_ramp_of_the_command_may_be_as_long_as_a_number_can_say() {
    // What went wrong: the length of a ramp in control periods passed the greatest number of its type, which stopped
    // the program in a debug build and gave a ramp of no length in a release build.
    let mut curriculum = Curriculum::default();
    curriculum.command.redraw_interval_s = 1e-3;
    curriculum.command.redraw_ramp_s = f64::MAX;
    curriculum
        .validate(&BodyParameters::default(), &RewardParameters::default())
        .unwrap();
    let task = TaskParameters::default();
    let settings = curriculum.at(0, &task.reward);
    let mut batch = EnvironmentBatch::new(body(), task, 1, 1, &settings);
    let before = batch.environment(0).omega_v;
    for _ in 0..20 {
        batch.step(0, [0.5, 0.5], 0.0, &settings);
    }
    let moved = batch.environment(0).omega_v - before;
    assert!(moved.abs() < 1e-6, "{moved}");
}
