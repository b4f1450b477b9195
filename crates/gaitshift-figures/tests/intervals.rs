//! Contract: a panel for each quantity, a dot and a line for each point, the same picture each time; nothing and values that
//! cannot be drawn are refused by name.

use gaitshift_figures::{FigureError, IntervalPanel, IntervalPoint, intervals_figure};

fn point(series: usize, x: f64, middle: f64) -> IntervalPoint {
    IntervalPoint {
        series,
        x,
        low: 0.5 * middle,
        middle,
        high: 2.0 * middle,
    }
}

fn panel(title: &str, points: Vec<IntervalPoint>) -> IntervalPanel {
    IntervalPanel {
        title: title.to_owned(),
        x_title: "phase".to_owned(),
        points,
    }
}

#[test]
fn panels_have_their_titles_and_points() {
    let series = ["slow".to_owned(), "fast".to_owned()];
    let panels = [
        panel("push (N s)", vec![point(0, 0.0, 3.0), point(1, 0.0, 4.0)]),
        panel("step (m)", vec![point(1, 3.0, 0.02)]),
        panel("nothing", Vec::new()),
    ];
    let figure = intervals_figure(&series, &panels).unwrap();
    for word in [
        "push (N s)",
        "step (m)",
        "nothing",
        "no values",
        "slow",
        "fast",
        "phase",
    ] {
        assert!(figure.svg.contains(word), "{word}");
    }
    // Two in the legend, three points.
    assert_eq!(figure.svg.matches("<circle").count(), 5);
    assert_eq!(figure.svg, intervals_figure(&series, &panels).unwrap().svg);
}

// What went wrong: the names of many series ran out of the picture.
#[test]
fn many_names_take_rows_and_a_long_one_is_shortened() {
    let mut series: Vec<String> = (0..13).map(|k| format!("ω_v = {k}.25")).collect();
    series.push("a name of a hundred letters ".repeat(8));
    let points = (0..14).map(|k| point(k, 0.0, 3.0)).collect();
    let figure = intervals_figure(&series, &[panel("push", points)]).unwrap();
    assert!(figure.svg.contains('…') && !figure.svg.contains(&series[13]));
    let wide: f64 = between(&figure.svg, "width=\"", "\"").parse().unwrap();
    for circle in figure.svg.split("<circle ").skip(1) {
        let x: f64 = between(circle, "cx=\"", "\"").parse().unwrap();
        assert!((0.0..wide).contains(&x), "{x} of {wide}");
    }
}

// The line over a single panel was cut off.
#[test]
fn a_single_panel_is_as_wide_as_its_note() {
    let one = [panel("latency (s)", vec![point(0, 1.0, 0.02)])];
    let series = ["ω = 3".to_owned()];
    let svg = intervals_figure(&series, &one).unwrap().svg;
    let width: f64 = between(&svg, "viewBox=\"0 0 ", " ").parse().unwrap();
    assert!(width > 46.0 + 250.0, "{width}");
}

fn between<'a>(text: &'a str, from: &str, to: &str) -> &'a str {
    let rest = text.split(from).nth(1).unwrap();
    rest.split(to).next().unwrap()
}

#[test]
fn what_cannot_be_drawn_is_named() {
    let empty = intervals_figure(&[], &[panel("a", Vec::new())]);
    assert!(matches!(empty, Err(FigureError::Empty { .. })));
    let bad = intervals_figure(&[], &[panel("b", vec![point(0, f64::NAN, 1.0)])]);
    assert!(matches!(bad, Err(FigureError::NotFinite { name, .. }) if name == "b"));
}
