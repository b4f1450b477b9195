//! Contract: charts and bars show every point and part that is given, tell series apart without colour, keep to their
//! sheet, and refuse what cannot be drawn.

mod common;

use gaitshift_analysis::support::SupportPhase;
use gaitshift_figures::{
    Bar, COLUMN_WIDTH, Chart, FigureError, Series, bars_figure, charts_figure, phase_between,
};

fn chart(series: Vec<Series>) -> Chart {
    Chart {
        title: "a title".to_owned(),
        x_title: "command ω\u{1d65} (s/m)".to_owned(),
        y_title: "share".to_owned(),
        series,
        ..Chart::default()
    }
}

fn series(label: &str, shift: f64) -> Series {
    Series::marks(
        label,
        (0..5)
            .map(|k| (f64::from(k), shift + f64::from(k)))
            .collect(),
    )
}

#[test]
fn series_are_told_apart_by_the_shape_of_their_marks() {
    let all: Vec<Series> = (0..6)
        .map(|k| series(&format!("s{k}"), f64::from(k)))
        .collect();
    let svg = charts_figure(&[chart(all)], 1, COLUMN_WIDTH, 200.0)
        .unwrap()
        .svg;
    // Five points and a legend entry each: filled and hollow circles, filled triangles and hollow diamonds, squares, crosses.
    assert_eq!(svg.matches("<circle").count(), 2 * 6);
    assert_eq!(svg.matches("<polygon").count(), 2 * 6);
    for name in ["s0", "s5", "a title", "share"] {
        assert!(svg.contains(&format!(">{name}</text>")), "{name}");
    }
    let lines: Vec<Series> = (0..3)
        .map(|k| Series::line(&format!("s{k}"), vec![(0.0, 0.0), (1.0, f64::from(k))]))
        .collect();
    let svg = charts_figure(&[chart(lines)], 1, COLUMN_WIDTH, 200.0)
        .unwrap()
        .svg;
    assert!(
        svg.contains("stroke-dasharray=\"6 2.5\"") && svg.contains("stroke-dasharray=\"1.6 2.2\"")
    );
}

#[test]
fn a_series_looks_alike_in_all_panels_and_stands_once_in_the_legend() {
    let panels = [
        chart(vec![series("a", 0.0), series("b", 1.0)]),
        chart(vec![series("b", 1.0)]),
    ];
    let svg = charts_figure(&panels, 2, 680.0, 120.0).unwrap().svg;
    assert_eq!(svg.matches(">b</text>").count(), 1);
    // The squares of `b`, beside those of frames and sheet, are hollow in both panels.
    let squares = svg.matches("width=\"5.2\" height=\"5.2\"").count();
    assert_eq!(squares, 5 + 5 + 1);
}

#[test]
fn the_subscript_of_the_command_is_a_lowered_letter() {
    let svg = charts_figure(&[chart(vec![series("a", 0.0)])], 1, COLUMN_WIDTH, 120.0)
        .unwrap()
        .svg;
    assert!(
        !svg.contains('\u{1d65}'),
        "the font's glyph does not fit its letters"
    );
    assert!(svg.contains(
        "ω<tspan dy=\"2.42\" font-size=\"8.25\">v</tspan><tspan dy=\"-2.42\"> </tspan>(s/m)"
    ));
}

#[test]
fn phases_are_shaded_and_named() {
    let shaded = Chart {
        phases: phase_between(SupportPhase::Double, 0.0, 2.0)
            .into_iter()
            .collect(),
        ..chart(vec![series("a", 0.0)])
    };
    let svg = charts_figure(&[shaded], 1, 680.0, 120.0).unwrap().svg;
    assert!(svg.contains(">double support</text>") && svg.contains(">flight</text>"));
}

#[test]
fn nothing_to_draw_and_nothing_drawable_are_errors() {
    let empty = charts_figure(
        &[chart(vec![Series::line("a", Vec::new())])],
        1,
        330.0,
        100.0,
    );
    assert!(matches!(empty, Err(FigureError::Empty { .. })));
    let infinite = Series::line("a", vec![(0.0, 1.0), (1.0, f64::NAN)]);
    let infinite = charts_figure(&[chart(vec![infinite])], 1, 330.0, 100.0);
    assert!(matches!(
        infinite,
        Err(FigureError::NotFinite { index: 1, .. })
    ));
    let narrow = charts_figure(&[chart(vec![series("a", 0.0)])], 1, 90.0, 100.0);
    assert!(matches!(
        narrow,
        Err(FigureError::Option { name: "width", .. })
    ));
    let negative = [Bar {
        label: "a".to_owned(),
        parts: vec![("p".to_owned(), -1.0)],
    }];
    assert!(matches!(
        bars_figure(&negative, "J", 330.0),
        Err(FigureError::NotFinite { .. })
    ));
    assert!(matches!(
        bars_figure(&[], "J", 330.0),
        Err(FigureError::Empty { .. })
    ));
}

#[test]
fn ten_parts_look_like_ten() {
    let parts: Vec<(String, f64)> = (0..10).map(|k| (format!("p{k}"), 1.0)).collect();
    let bars = [Bar {
        label: "all".to_owned(),
        parts,
    }];
    let figure = bars_figure(&bars, "energy (J)", 680.0).unwrap();
    let png = common::pixels(&figure, 1.0);
    // The bar's middle row: of each part the pixels at its middle, as lightness.
    let legend: Vec<&str> = figure.svg.matches("<rect").collect();
    assert!(legend.len() >= 2 * 10);
    assert!(png.width() == 680);
    let fills: std::collections::BTreeSet<&str> = figure
        .svg
        .lines()
        .filter(|line| line.starts_with("<rect") && line.contains("height=\"17\""))
        .filter_map(|line| line.split("fill=\"#").nth(1))
        .map(|rest| &rest[..6])
        .collect();
    // Two are white, one of them hatched.
    assert_eq!(fills.len(), 9);
}
