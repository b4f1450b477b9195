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

#[test]
fn what_cannot_be_drawn_is_named() {
    let empty = intervals_figure(&[], &[panel("a", Vec::new())]);
    assert!(matches!(empty, Err(FigureError::Empty { .. })));
    let bad = intervals_figure(&[], &[panel("b", vec![point(0, f64::NAN, 1.0)])]);
    assert!(matches!(bad, Err(FigureError::NotFinite { name, .. }) if name == "b"));
}
