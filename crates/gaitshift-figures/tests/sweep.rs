//! The sweep shows every quantity of every command that is defined, marks the paper's values, shows
//! a fall as one, and joins commands of one gait only.

use crate::common;
use crate::common::{count, drawn_size, keep};
use gaitshift_analysis::{AnalysisOptions, GaitClass, summarise};
use gaitshift_figures::{FigureError, SweepPoint, SweepSeries, sweep_figure};

const FIRST: &str = "fill=\"#0072b2\"";
const PAPER: &str = "fill=\"#cc79a7\"";

fn series(label: &str, points: Vec<SweepPoint>) -> SweepSeries {
    SweepSeries {
        label: label.to_owned(),
        points,
    }
}

fn point(omega_v: f64) -> SweepPoint {
    SweepPoint {
        omega_v,
        fell: false,
        gait: Some(GaitClass::Walking),
        speed_m_per_s: Some(0.6 + 0.7 * omega_v),
        froude: Some(0.2 + 0.25 * omega_v),
        cost_of_transport: Some(0.3),
        double_support: Some((0.4 - 0.3 * omega_v).max(0.0)),
        single_support: Some(0.6),
        flight: Some((0.2 * omega_v - 0.2).max(0.0)),
        deviations: [None; 6],
    }
}

#[test]
fn all_panels_and_the_papers_values_are_there() {
    let points: Vec<SweepPoint> = (0..8).map(|i| point(0.5 * f64::from(i))).collect();
    let mut second = points.clone();
    second[7].fell = true;
    second[2].cost_of_transport = None;
    for point in &mut second {
        point.froude = point.froude.map(|froude| froude + 0.1);
    }
    let figure = sweep_figure(&[series("seed 1", points), series("seed <2>", second)]).unwrap();
    keep("sweep.svg", figure.svg.as_bytes());
    keep("sweep.png", &figure.to_png(2.0).unwrap());
    drawn_size(&figure);
    for title in [
        "speed (m/s)",
        "Froude number",
        "cost of transport",
        "double support",
        "single support",
        "flight",
        "seed 1",
        "seed &lt;2&gt;",
        "the paper",
        "fell",
    ] {
        assert_eq!(count(&figure.svg, &format!(">{title}<")), 1, "{title}");
    }
    assert_eq!(
        count(&figure.svg, PAPER),
        6 + 1,
        "three quantities at two commands, and the legend"
    );
    assert_eq!(count(&figure.svg, FIRST), 6 * 8 + 1);
}

#[test]
fn undefined_quantities_are_left_out_and_falls_are_hollow() {
    let mut fallen = SweepPoint {
        omega_v: 1.0,
        fell: true,
        ..SweepPoint::default()
    };
    fallen.speed_m_per_s = Some(0.4);
    let figure = sweep_figure(&[series("a", vec![point(0.0), fallen])]).unwrap();
    assert_eq!(count(&figure.svg, FIRST), 6 + 1);
    // In the speed panel and in the legend.
    let hollow = figure
        .svg
        .lines()
        .filter(|line| line.starts_with("<circle") && line.contains("fill=\"#ffffff\""));
    assert_eq!(hollow.count(), 2);
    drawn_size(&figure);
}

#[test]
fn of_means_the_standard_deviations_are_bars() {
    let mut mean = point(1.0);
    mean.deviations[0] = Some(0.3);
    mean.deviations[2] = Some(0.0);
    mean.fell = true;
    let bars = |points| {
        let svg = sweep_figure(&[series("a", points)]).unwrap().svg;
        let ink = FIRST.replace("fill", "stroke");
        let lines = svg.lines().filter(|line| line.starts_with("<line"));
        (lines.filter(|line| line.contains(&ink)).count(), svg)
    };
    let (count, svg) = bars(vec![point(0.0), mean]);
    assert_eq!(count, 2);
    assert!(svg.contains("mean over starts ± standard deviation"));
    assert!(svg.contains("one or more fell"));
    let (count, svg) = bars(vec![point(0.0), point(1.0)]);
    assert_eq!(count, 0);
    assert!(!svg.contains("mean over starts"));
    mean.deviations[1] = Some(f64::NAN);
    let refused = sweep_figure(&[series("a", vec![mean])]);
    assert!(matches!(refused, Err(FigureError::NotFinite { .. })));
}

#[test]
fn no_line_leads_through_a_gap_between_gaits_or_to_a_fall() {
    // A line led from the fastest walk to the slowest run, through speeds that no motion has, and into falls.
    let gaits = [
        GaitClass::Walking,
        GaitClass::Walking,
        GaitClass::Mixed,
        GaitClass::Mixed,
        GaitClass::Running,
        GaitClass::Running,
        GaitClass::Running,
        GaitClass::Running,
    ];
    let points: Vec<SweepPoint> = (0..8)
        .zip(gaits)
        .map(|(i, gait)| SweepPoint {
            gait: Some(gait),
            fell: i == 6,
            ..point(0.5 * f64::from(i))
        })
        .collect();
    let figure = sweep_figure(&[series("a", points)]).unwrap();
    let lines = figure
        .svg
        .lines()
        .filter(|line| line.starts_with("<polyline"));
    // In each panel: the two walks, and the two runs before the fall.
    assert_eq!(lines.count(), 6 * 2);
    drawn_size(&figure);
}

#[test]
fn a_point_is_what_the_analysis_says() {
    let recording = common::toy(12.0, |_| 1.0);
    let summary = summarise(&recording, &AnalysisOptions::default());
    let point = SweepPoint::new(3.0, &summary);
    assert_eq!(point.omega_v, 3.0);
    assert!((point.speed_m_per_s.unwrap() - 2.6).abs() < 0.05);
    assert_eq!(point.double_support, Some(0.0));
    assert!(point.flight.unwrap() > 0.2);
    sweep_figure(&[series("toy", vec![point])]).unwrap();
}

#[test]
fn what_cannot_be_drawn_is_an_error() {
    for nothing in [vec![], vec![series("none", vec![])]] {
        assert!(matches!(
            sweep_figure(&nothing),
            Err(FigureError::Empty { .. })
        ));
    }
    let bad = SweepPoint {
        froude: Some(f64::INFINITY),
        ..point(1.0)
    };
    let error = sweep_figure(&[series("a", vec![point(0.0), bad])]).unwrap_err();
    assert!(matches!(error, FigureError::NotFinite { index: 1, .. }));
    assert!(error.to_string().contains("Froude number"));
}
