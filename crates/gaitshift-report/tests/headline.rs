//! Contract: the numbers beside those of people follow from the motions alone; what a study lacks has no number; of several seeds
//! they have an interval.

use crate::common::studies::{motion, study};
use gaitshift_analysis::GaitClass::{Mixed, Running, Walking};
use gaitshift_report::{HeadlineNumber, StartedMotion, Study, headline_numbers};

fn number(studies: &[&Study], name: &str) -> HeadlineNumber {
    let numbers = headline_numbers(studies);
    let found = numbers.into_iter().find(|n| n.name.contains(name));
    found.unwrap_or_else(|| panic!("no number {name}"))
}

/// It runs from 0.6 on upwards, but for one running stair below, and down to 0.4, but for another; at 0.4 and 0.6 the speeds differ.
fn with_stairs() -> Study {
    let stair = |omega_v, gait| motion(omega_v, gait, 0.2 + omega_v, 0.3);
    let mut study = study(0.2, 0.9);
    study.stairs_up = vec![
        stair(0.2, Running),
        stair(0.4, Mixed),
        stair(0.6, Running),
        stair(0.8, Running),
    ];
    study.stairs_down = vec![
        stair(0.8, Mixed),
        motion(0.6, Running, 0.9, 0.3),
        motion(0.4, Running, 0.66, 0.3),
        motion(0.2, Walking, 0.44, 0.3),
        stair(0.1, Running),
    ];
    study
}

#[test]
fn the_hysteresis_is_where_stairs_differ_up_and_down() {
    let mut study = with_stairs();
    let of = |study: &Study, name| number(&[study], name).seeds[0];
    assert_eq!(of(&study, "from which on it runs"), Some(0.6));
    assert_eq!(of(&study, "down to which it runs"), Some(0.4));
    // At 0.2 the speeds differ by less than motions do.
    let width = |study: &Study| of(study, "width of the hysteresis").unwrap();
    assert!((width(&study) - 0.4).abs() < 1e-12);
    // So does a fall on one of the ways, but not on both.
    study.stairs_up[3].summary.fell = true;
    assert!((width(&study) - 0.6).abs() < 1e-12);
    study.stairs_down[0].summary.fell = true;
    assert!((width(&study) - 0.4).abs() < 1e-12);
}

#[test]
fn gaits_are_bounded_by_all_motions_stairs_included() {
    let study = with_stairs();
    let of = |name| number(&[&study], name).seeds[0].unwrap();
    // A walk with 0.44 on the stairs; the least run is the one at 0.1.
    assert!((of("of a steady walk") - 0.1936).abs() < 1e-12);
    assert!((of("of a steady run") - 0.09).abs() < 1e-12);
    assert!((of("gap in Froude number") - (0.3 - 0.44)).abs() < 1e-12);
}

#[test]
fn commands_whose_starts_end_in_both_gaits_are_counted() {
    let mut study = study(0.2, 0.9);
    let started = |(omega_v, gait)| StartedMotion {
        omega_v,
        seed: 1,
        gait,
        speed_m_per_s: None,
        duty_factor: None,
        double_support: None,
        flight: None,
    };
    study.starts = [
        (0.0, Walking),
        (0.0, Walking),
        (0.5, Walking),
        (0.5, Running),
        (1.0, Running),
        (1.0, Mixed),
    ]
    .map(started)
    .to_vec();
    assert_eq!(number(&[&study], "random starts").seeds, [Some(1.0)]);
}

// The mean over seeds had values of one that fell, its impact included.
#[test]
fn a_fall_has_no_numbers_of_a_steady_motion() {
    let mut study = study(0.2, 0.9);
    let recovery =
        |study: &Study| number(&[study], "energy recovery of the centre of mass at ω_v = 3");
    let run = study.steady.iter_mut().find(|row| row.omega_v == 3.0);
    run.unwrap().summary.energy_recovery = Some(0.3);
    assert_eq!(recovery(&study).seeds, [Some(0.3)]);
    let run = study.steady.iter_mut().find(|row| row.omega_v == 3.0);
    run.unwrap().summary.fell = true;
    assert_eq!(recovery(&study).seeds, [None]);
}

#[test]
fn what_is_not_there_has_no_number_and_seeds_have_an_interval() {
    let (slow, fast) = (study(0.12, 0.9), study(0.42, 0.9));
    let none = number(&[&slow], "from which on it runs");
    assert_eq!((none.seeds, none.estimate), (vec![None], None));
    let walk = number(&[&slow, &fast], "of a steady walk");
    let [low, high] = walk.interval();
    assert!(low < high && low >= Some(0.0144) && high <= Some(0.1764));
    assert_eq!(
        number(&[&slow], "of a steady walk").interval(),
        [None, None]
    );
}
