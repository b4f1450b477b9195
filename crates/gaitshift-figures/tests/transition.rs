//! The figure of a gait change shows the support phases that the analysis finds, marks the ramp where
//! it is, and draws whatever a recording may hold without panicking.

use crate::common;
use crate::common::{colour, count, drawn_size, keep, phases_between, pixels};
use gaitshift_analysis::recording::{COLUMNS, Column, Recording, column};
use gaitshift_analysis::support::SupportPhase;
use gaitshift_figures::{FigureError, FigureOptions, transition_figure};

const RAMP: (f64, f64) = (3.0, 3.4);
/// Edges of the panels in user units at the default width.
const LEFT: f64 = 58.0;
const RIGHT: f64 = 386.0;

fn shown() -> FigureOptions {
    FigureOptions {
        from_s: Some(0.5),
        to_s: Some(5.5),
        ..FigureOptions::default()
    }
}

#[test]
fn every_support_phase_is_shaded_in_every_panel() {
    let recording = common::transition();
    let figure = transition_figure(&recording, RAMP, &shown()).unwrap();
    keep("transition.svg", figure.svg.as_bytes());
    keep("transition.png", &figure.to_png(2.0).unwrap());
    drawn_size(&figure);
    for (phase, ink) in [
        (SupportPhase::Double, "#adadad"),
        (SupportPhase::SingleRight, "#eebf99"),
        (SupportPhase::SingleLeft, "#deedf5"),
    ] {
        let phases = phases_between(&recording, phase, 0.5, 5.5);
        assert!(phases > 2);
        let shades = count(&figure.svg, &format!("fill=\"{ink}\""));
        assert_eq!(
            shades,
            4 * phases + 1,
            "{phase:?}: four panels and the legend"
        );
    }
}

#[test]
fn shades_lie_where_the_phases_are() {
    let recording = common::transition();
    let figure = transition_figure(&recording, RAMP, &shown()).unwrap();
    let picture = pixels(&figure, 2.0);
    let support = gaitshift_analysis::support::Support::find(&recording, &Default::default());
    for interval in support.phases() {
        let middle = 0.5 * (interval.start_s + interval.end_s);
        let in_ramp = middle > RAMP.0 && middle < RAMP.1;
        if !(0.5..=5.5).contains(&middle) || in_ramp || interval.end_s - interval.start_s < 0.03 {
            continue;
        }
        let x = LEFT + (middle - 0.5) / 5.0 * (RIGHT - LEFT);
        // In the lower part of the first panel only the background is drawn at some height.
        let expected = match interval.phase {
            SupportPhase::Double => [0xad, 0xad, 0xad],
            SupportPhase::SingleRight => [0xee, 0xbf, 0x99],
            SupportPhase::SingleLeft => [0xde, 0xed, 0xf5],
            SupportPhase::Flight => [0xff, 0xff, 0xff],
        };
        let found = colour(&picture, (2.0 * x) as u32, 2 * 80);
        assert_eq!(found, expected, "{:?} at {middle} s", interval.phase);
    }
}

#[test]
fn the_hatching_covers_the_ramp_and_nothing_else() {
    let recording = common::transition();
    let figure = transition_figure(&recording, RAMP, &shown()).unwrap();
    let bands: Vec<(f64, f64)> = figure
        .svg
        .split("<svg x=\"")
        .skip(1)
        .map(|rest| {
            let mut quoted = rest.split('"');
            let left: f64 = quoted.next().unwrap().parse().unwrap();
            let width: f64 = quoted.nth(3).unwrap().parse().unwrap();
            (left, left + width)
        })
        .collect();
    let place = |time: f64| LEFT + (time - 0.5) / 5.0 * (RIGHT - LEFT);
    let on_ramp = |band: &&(f64, f64)| {
        (band.0 - place(RAMP.0)).abs() < 0.1 && (band.1 - place(RAMP.1)).abs() < 0.1
    };
    assert_eq!(bands.iter().filter(on_ramp).count(), 4);
    // The rest are the curves over the whole width and the swatch of the legend.
    let whole = |band: &&(f64, f64)| (band.0 - LEFT).abs() < 0.1 && (band.1 - RIGHT).abs() < 0.1;
    assert_eq!(bands.iter().filter(whole).count(), 5);
    assert_eq!(bands.len(), 4 + 5 + 1);
}

/// The toy with another command.
fn commanded(command: impl Fn(f64) -> f64) -> Recording {
    let toy = common::transition();
    let mut recording = Recording::new(toy.metadata.clone());
    for row in 0..toy.len() {
        let mut values: Vec<f64> = COLUMNS
            .iter()
            .map(|name| toy.column(Column::named(name).unwrap())[row])
            .collect();
        // A row holds the command of the period that ends there.
        let time_s = values[column::TIME_S.index()] - common::PERIOD_S;
        values[column::OMEGA_V.index()] = command(time_s.max(0.0));
        recording.push_row(&values).unwrap();
    }
    recording
}

/// From where to where it is hatched in the first panel, in s.
fn hatched(recording: &Recording, change: (f64, f64)) -> Vec<(f64, f64)> {
    let figure = transition_figure(recording, change, &shown()).unwrap();
    let time = |x: f64| 0.5 + (x - LEFT) / (RIGHT - LEFT) * 5.0;
    let mut found: Vec<(f64, f64)> = figure
        .svg
        .split("<svg x=\"")
        .skip(1)
        .filter_map(|rest| {
            let mut quoted = rest.split('"');
            let left: f64 = quoted.next()?.parse().ok()?;
            let width: f64 = quoted.nth(3)?.parse().ok()?;
            // Not the curves, which are as wide as the panel, nor the swatch of the legend, which is not in one.
            let hatch = left > LEFT + 1.0 && width > 30.0;
            hatch.then(|| (time(left), time(left + width)))
        })
        .collect();
    assert_eq!(count(&figure.svg, ">ramp<"), usize::from(!found.is_empty()));
    // Four panels with the same hatching.
    found.truncate(found.len() / 4);
    found
}

// From its first change to its last everything was hatched, over a command that follows a curve as over one ramp.
#[test]
fn a_curve_is_no_ramp_and_several_ramps_are_several() {
    let curve = commanded(|t| 1.5 - 1.5 * (0.6 * t).cos());
    assert_eq!(hatched(&curve, (0.0, 6.5)), []);
    let triangle = commanded(|t| 3.0 - (t - 3.0).abs());
    assert_eq!(hatched(&triangle, (0.0, 6.0)), []);
    let trip = commanded(|t| {
        3.0 * (2.0 * (t - 1.0))
            .clamp(0.0, 1.0)
            .min((2.0 * (4.5 - t)).clamp(0.0, 1.0))
    });
    let ramps = hatched(&trip, (1.0, 4.5));
    let near =
        |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).abs() < 0.011 && (a.1 - b.1).abs() < 0.011;
    assert_eq!(ramps.len(), 2, "{ramps:?}");
    assert!(
        near(ramps[0], (1.0, 1.5)) && near(ramps[1], (4.0, 4.5)),
        "{ramps:?}"
    );
}

#[test]
fn size_title_and_axes_are_as_asked() {
    let options = FigureOptions {
        width: 600.0,
        title: Some("0 < ω \"&\" \u{0}3".to_owned()),
        ..FigureOptions::default()
    };
    let figure = transition_figure(&common::transition(), RAMP, &options).unwrap();
    assert_eq!(drawn_size(&figure).0, 600.0);
    assert!(figure.svg.contains("0 &lt; ω \"&amp;\"  3"));
    for text in [
        "kinetic (J)",
        "potential (J)",
        "elastic (J)",
        "speed (m/s)",
        "time (s)",
    ] {
        assert_eq!(count(&figure.svg, text), 1, "{text}");
    }
    let narrow = FigureOptions {
        width: 300.0,
        ..FigureOptions::default()
    };
    let narrow = transition_figure(&common::transition(), RAMP, &narrow).unwrap();
    let usual = transition_figure(&common::transition(), RAMP, &FigureOptions::default()).unwrap();
    assert!(
        drawn_size(&narrow).1 > drawn_size(&usual).1,
        "the legend takes more rows"
    );
}

#[test]
fn the_same_recording_gives_the_same_figure() {
    let draw = || {
        transition_figure(&common::transition(), RAMP, &shown())
            .unwrap()
            .svg
    };
    assert_eq!(draw(), draw());
}

#[test]
fn poor_recordings_are_drawn() {
    let all = FigureOptions {
        from_s: Some(-1.0),
        to_s: Some(9.0),
        ..FigureOptions::default()
    };
    for recording in [
        common::short(1),
        common::short(2),
        common::motionless(50),
        common::extreme(),
    ] {
        let figure = transition_figure(&recording, (0.05, 0.1), &all).unwrap();
        drawn_size(&figure);
        figure.to_png(1.0).unwrap();
    }
}

#[test]
fn what_cannot_be_drawn_is_an_error() {
    let empty = common::short(0);
    let error = transition_figure(&empty, RAMP, &shown()).unwrap_err();
    assert!(matches!(error, FigureError::Empty { .. }));

    let recording = common::transition();
    let error = transition_figure(&recording, (30.0, 30.4), &FigureOptions::default()).unwrap_err();
    assert!(matches!(error, FigureError::TimeRange { .. }));
    assert!(error.to_string().contains("covers 0 s to 6.5 s"), "{error}");

    let backwards = FigureOptions {
        from_s: Some(5.0),
        to_s: Some(4.0),
        ..shown()
    };
    let error = transition_figure(&recording, RAMP, &backwards).unwrap_err();
    assert!(matches!(error, FigureError::TimeRange { .. }));

    for width in [0.0, 299.0, 1e9, f64::NAN] {
        let options = FigureOptions { width, ..shown() };
        let error = transition_figure(&recording, RAMP, &options).unwrap_err();
        assert!(matches!(error, FigureError::Option { name: "width", .. }));
    }
    let error = transition_figure(&recording, (f64::NAN, 1.0), &shown()).unwrap_err();
    assert!(matches!(
        error,
        FigureError::Option {
            name: "ramp start",
            ..
        }
    ));
}

#[test]
fn support_phases_differ_in_grey_print() {
    // Single support of right and left had the same grey, 0.87 and 0.84 of white.
    let figure = transition_figure(&common::transition(), (4.0, 4.4), &Default::default()).unwrap();
    let lightness = |hex: &str| {
        let byte = |at: usize| f64::from(u8::from_str_radix(&hex[at..at + 2], 16).unwrap());
        (0.2126 * byte(0) + 0.7152 * byte(2) + 0.0722 * byte(4)) / 255.0
    };
    let mut shades: Vec<f64> = ["adadad", "eebf99", "deedf5", "ffffff"]
        .into_iter()
        .inspect(|shade| assert!(figure.svg.contains(&format!("fill=\"#{shade}\""))))
        .map(lightness)
        .collect();
    shades.sort_by(f64::total_cmp);
    for pair in shades.windows(2) {
        assert!(pair[1] - pair[0] > 0.07, "{pair:?}");
    }
}

// A figure of a stumble did not say when the push was.
#[test]
fn a_push_is_marked_while_it_lasts() {
    let mut recording = common::transition();
    let marks = |recording: &Recording| {
        let figure = transition_figure(recording, RAMP, &shown()).unwrap();
        keep("transition_push.png", &figure.to_png(2.0).unwrap());
        let rects = figure.svg.split("<rect ").skip(1);
        let of_push = rects.filter(|rect| rect.contains("#cc79a7"));
        let places = of_push.map(|rect| {
            let number = |name: &str| {
                let value = rect.split(&format!("{name}=\"")).nth(1).unwrap();
                value.split('"').next().unwrap().parse::<f64>().unwrap()
            };
            (number("x"), number("width"))
        });
        places.collect::<Vec<_>>()
    };
    recording.metadata.disturbance = Some(serde_json::json!({"pushes": [
        {"forward_n": 80.0, "start_s": 2.0, "duration_s": 0.1},
        {"forward_n": 0.0, "up_n": 0.0, "start_s": 2.5, "duration_s": 0.1},
        {"forward_n": 80.0, "start_s": 5.5, "duration_s": 0.1},
        {"forward_n": 80.0, "start_s": 0.4, "duration_s": 0.1},
    ]}));
    let marks_of_one = marks(&recording);
    // Four panels and the legend; the second is none, the third comes after what is shown, the fourth ends where it begins.
    assert_eq!(marks_of_one.len(), 5, "{marks_of_one:?}");
    let (x, width) = marks_of_one[1];
    let second = (RIGHT - LEFT) / 5.0;
    assert!((x - (LEFT + 1.5 * second)).abs() < 0.1, "{x}");
    assert!((width - 0.1 * second).abs() < 0.1, "{width}");
    // A short one at the end stays within the frame.
    recording.metadata.disturbance = Some(serde_json::json!({"pushes": [
        {"up_n": -80.0, "start_s": 5.499, "duration_s": 0.1},
    ]}));
    let (x, width) = marks(&recording)[1];
    assert!(width > 1.0 && x + width < RIGHT + 1e-6, "{x} {width}");
    for none in [
        serde_json::json!({"pushes": []}),
        serde_json::json!({"pushes": [{"start_s": "soon"}, 3]}),
        serde_json::json!(null),
    ] {
        recording.metadata.disturbance = Some(none);
        assert!(marks(&recording).is_empty());
    }
}
