//! The figure of a training run shows every episode in the colour of its command, later over earlier.

use crate::common;
use crate::common::{count, drawn_size, keep};
use gaitshift_figures::{
    FigureError, LearningCurves, episode_returns_figure, learning_curves_figure,
};

const LOW: &str = "fill=\"#440154\"";
const HIGH: &str = "fill=\"#e3d51c\"";

#[test]
fn every_episode_is_a_dot_in_the_colour_of_its_command() {
    let steps = [1e6, 2e6, 3e6, 4e6];
    let figure =
        episode_returns_figure(&steps, &[10.0, 500.0, -30.0, 900.0], &[0.0, 3.0, 0.0, 3.0])
            .unwrap();
    drawn_size(&figure);
    assert_eq!(count(&figure.svg, "<circle"), 4);
    // Two dots and an end of the colour bar each.
    assert_eq!(count(&figure.svg, LOW), 3);
    assert_eq!(count(&figure.svg, HIGH), 3);
}

#[test]
fn of_episodes_on_one_spot_the_latest_is_shown() {
    let figure =
        episode_returns_figure(&[1e6, 1e6, 2e6], &[5.0, 5.0, 9.0], &[0.0, 3.0, 0.0]).unwrap();
    assert_eq!(count(&figure.svg, "<circle"), 2);
    assert_eq!(count(&figure.svg, HIGH), 2);
}

#[test]
fn a_long_run_stays_a_small_picture() {
    let episodes = 60_000;
    let steps: Vec<f64> = (0..episodes).map(|i| i as f64 * 170.0).collect();
    let noise = |i: usize| ((i * 7919) % 1000) as f64 / 1000.0;
    let omega_v: Vec<f64> = (0..episodes)
        .map(|i| {
            if steps[i] < 4.5e6 {
                0.4 * noise(i) - 0.2
            } else {
                4.0 * noise(i) - 0.5
            }
        })
        .collect();
    let returns: Vec<f64> = (0..episodes)
        .map(|i| (1.0 - (-steps[i] / 2e6).exp()) * (800.0 + 900.0 * omega_v[i]) * noise(3 * i))
        .collect();
    let figure = episode_returns_figure(&steps, &returns, &omega_v).unwrap();
    keep("returns.svg", figure.svg.as_bytes());
    keep("returns.png", &figure.to_png(2.0).unwrap());
    assert!(figure.svg.len() < 6_000_000, "{} bytes", figure.svg.len());
    assert!(count(&figure.svg, "<circle") > 5_000);
}

#[test]
fn runs_without_variety_are_drawn() {
    for value in [0.0, 3.0, -1e12, 1e300] {
        let figure = episode_returns_figure(&[0.0, 0.0], &[value; 2], &[value; 2]).unwrap();
        drawn_size(&figure);
        figure.to_png(1.0).unwrap();
    }
}

#[test]
fn what_cannot_be_drawn_is_an_error() {
    let error = episode_returns_figure(&[], &[], &[]).unwrap_err();
    assert!(matches!(error, FigureError::Empty { .. }));
    let error = episode_returns_figure(&[1.0, 2.0], &[1.0, 2.0], &[0.0]).unwrap_err();
    assert!(matches!(
        error,
        FigureError::Length {
            name: "omega_v",
            found: 1,
            expected: 2
        }
    ));
    let error = episode_returns_figure(&[1.0, 2.0], &[1.0, f64::NAN], &[0.0, 0.0]).unwrap_err();
    assert!(matches!(error, FigureError::NotFinite { index: 1, .. }));
    assert!(error.to_string().contains("`returns`"));
}

fn curves(label: &str, runs: &[&[(f64, f64)]]) -> LearningCurves {
    LearningCurves {
        label: label.to_owned(),
        runs: runs.iter().map(|run| run.to_vec()).collect(),
    }
}

#[test]
fn several_runs_are_a_mean_with_a_band_and_one_is_a_line() {
    let a: &[(f64, f64)] = &[(1e6, 10.0), (2e6, 20.0), (3e6, 30.0)];
    let b: &[(f64, f64)] = &[(1e6, 20.0), (3e6, 10.0)];
    let both = learning_curves_figure(&[curves("two", &[a, b])], "criteria met").unwrap();
    keep("learning_curves.svg", both.svg.as_bytes());
    keep("learning_curves.png", &both.to_png(2.0).unwrap());
    assert_eq!(common::count(&both.svg, "two, mean and range of 2 runs"), 1);
    // The grid aside there is one filled area, the band.
    assert_eq!(common::count(&both.svg, "<polygon"), 1);
    let one = learning_curves_figure(&[curves("one", &[a])], "criteria met").unwrap();
    assert_eq!(common::count(&one.svg, "<polygon"), 0);
    assert_eq!(common::count(&one.svg, ">one<"), 1);
    // Where one run ends, the mean ends too; it went on as that of the other.
    let short = learning_curves_figure(&[curves("two", &[a, &b[..1]])], "criteria met").unwrap();
    assert_eq!(common::count(&short.svg, "<circle"), 1);
    let same = learning_curves_figure(&[curves("same", &[a, a])], "criteria met").unwrap();
    assert_ne!(both.svg, same.svg);
}

// The axis of counts that are all 0 went from -1 to 1.
#[test]
fn a_count_of_nothing_is_not_negative() {
    let none: &[(f64, f64)] = &[(1e6, 0.0), (2e6, 0.0)];
    let figure = learning_curves_figure(&[curves("none", &[none])], "criteria met").unwrap();
    assert_eq!(common::count(&figure.svg, ">\u{2212}"), 0);
    assert_eq!(common::count(&figure.svg, ">-"), 0);
    assert!(common::count(&figure.svg, ">1.0<") + common::count(&figure.svg, ">1<") > 0);
}

#[test]
fn runs_of_other_lengths_and_single_points_are_drawn() {
    let figure = learning_curves_figure(
        &[
            curves("short", &[&[(1e6, 3.0)], &[(1e6, 5.0), (2e6, 6.0)]]),
            curves("point", &[&[(1.5e6, 4.0)]]),
            curves("none", &[&[]]),
        ],
        "criteria met",
    )
    .unwrap();
    assert!(figure.to_png(1.0).is_ok());
    for bad in [vec![], vec![curves("none", &[&[]])]] {
        let error = learning_curves_figure(&bad, "criteria met").unwrap_err();
        assert!(matches!(error, FigureError::Empty { .. }));
    }
    let error = learning_curves_figure(&[curves("bad", &[&[(1.0, f64::NAN)]])], "x").unwrap_err();
    assert!(matches!(error, FigureError::NotFinite { .. }));
}
