//! Contract: charts and bars show every point and part that is given, tell series apart without colour, keep to their
//! sheet, and refuse what cannot be drawn.

use crate::common;
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

/// The numbers of an attribute in all lines that contain `of`.
fn numbers(svg: &str, of: &str, attribute: &str) -> Vec<f64> {
    let named = format!(" {attribute}=\"");
    let lines = svg.lines().filter(|line| line.contains(of));
    lines
        .filter_map(|line| line.split(&named).nth(1)?.split('"').next()?.parse().ok())
        .collect()
}

// The title of a panel's vertical axis stood at a fixed distance, and numbers as long as 0.015 ran into it.
#[test]
fn titles_keep_clear_of_long_numbers() {
    let small = Series::marks("a", vec![(0.0, 0.0), (1.0, 0.015)]);
    let svg = charts_figure(
        &[chart(vec![series("a", 0.0)]), chart(vec![small])],
        2,
        680.0,
        120.0,
    )
    .unwrap()
    .svg;
    let titles = numbers(&svg, ">share</text>", "x");
    // The frames of the two panels, after the sheet.
    let frames: Vec<f64> = numbers(&svg, "fill=\"none\" stroke=\"#222222\"", "x");
    assert_eq!((titles.len(), frames.len()), (2, 2));
    // 0.015 in letters of 11 units is some 31 wide, and 6.5 from its panel.
    assert!(frames[1] - titles[1] > 40.0, "{titles:?} {frames:?}");
    assert!(frames[0] - titles[0] < frames[1] - titles[1]);
}

#[test]
fn a_title_longer_than_its_axis_is_set_smaller() {
    let long = Chart {
        y_title: "mean change of the total energy within a period (J)".to_owned(),
        ..chart(vec![series("a", 0.0)])
    };
    let svg = charts_figure(&[long], 1, COLUMN_WIDTH, 120.0).unwrap().svg;
    let sizes = numbers(&svg, "rotate(-90", "font-size");
    assert!(sizes.iter().all(|&size| size < 11.0), "{sizes:?}");
}

#[test]
fn falls_are_crosses_over_the_panel_in_a_row_for_each_series() {
    let rising = series("rising", 0.0).fell_at(vec![1.5, 2.5]);
    let falling = Series::marks("falling", Vec::new()).fell_at(vec![3.0]);
    let svg = charts_figure(&[chart(vec![rising, falling])], 1, COLUMN_WIDTH, 120.0)
        .unwrap()
        .svg;
    let top = numbers(
        &svg,
        "fill=\"none\" stroke=\"#222222\" stroke-width=\"0.8\"",
        "y",
    )[0];
    let crosses = |colour: &str| {
        let stroke = format!("stroke=\"{colour}\" stroke-width=\"1.4\"");
        numbers(&svg, &stroke, "y1")
    };
    // Two strokes each.
    let (blue, orange) = (crosses("#0072b2"), crosses("#d55e00"));
    assert_eq!((blue.len(), orange.len()), (4, 2));
    assert!(blue.iter().chain(&orange).all(|&y| y < top));
    let lowest = blue.iter().copied().fold(0.0, f64::max);
    assert!(orange.iter().all(|&y| y > lowest - 1.0));
    assert_eq!(svg.matches(">fell (over the panel)</text>").count(), 1);
    let none = charts_figure(&[chart(vec![series("a", 0.0)])], 1, COLUMN_WIDTH, 120.0);
    assert!(!none.unwrap().svg.contains("fell"));
}

#[test]
fn runs_lie_thin_in_a_band_below_their_mean() {
    let run = |shift: f64| vec![(0.0, shift), (1.0, 1.0 + shift)];
    let mean = Series::line("experiment", run(0.5))
        .of_runs(vec![run(0.0), run(1.0)])
        .within(vec![(0.0, 0.1, 0.9), (1.0, 1.1, 1.9)]);
    let svg = charts_figure(&[chart(vec![mean])], 1, COLUMN_WIDTH, 120.0)
        .unwrap()
        .svg;
    let widths = numbers(&svg, "<polyline", "stroke-width");
    assert_eq!(widths, [0.6, 0.6, 2.2]);
    assert_eq!(svg.matches("fill-opacity=\"0.18\"").count(), 1);
    // The axis reaches to the runs, and the legend has one entry.
    assert!(svg.contains(">0.0</text>") && svg.contains(">2.0</text>"));
    assert_eq!(svg.matches(">experiment</text>").count(), 1);
}

#[test]
fn more_series_than_colours_differ_in_dashes_and_marks() {
    let all: Vec<Series> = (0..12)
        .map(|k| Series::line(&format!("s{k}"), vec![(0.0, f64::from(k)), (1.0, 0.0)]))
        .collect();
    let svg = charts_figure(&[chart(all)], 1, 680.0, 120.0).unwrap().svg;
    let looks: std::collections::BTreeSet<&str> = svg
        .lines()
        .filter(|line| line.starts_with("<polyline"))
        .filter_map(|line| line.split("\" fill").nth(1))
        .collect();
    assert_eq!(looks.len(), 12);
}

#[test]
fn equal_factors_lie_equally_far_apart_on_a_logarithmic_axis() {
    let series = |low: f64| Series::marks("a", vec![(0.0, low), (1.0, 1.0), (2.0, 2.0)]);
    let logarithmic = |low: f64| {
        let chart = Chart {
            y_log: true,
            ..chart(vec![series(low)])
        };
        charts_figure(&[chart], 1, COLUMN_WIDTH, 120.0)
    };
    let svg = logarithmic(0.5).unwrap().svg;
    let heights = numbers(&svg, "r=\"2.6\"", "cy");
    // The entry of the legend comes first.
    assert!((heights[1] - heights[2] - (heights[2] - heights[3])).abs() < 0.03);
    for number in ["0.5", "1", "2"] {
        assert!(svg.contains(&format!(">{number}</text>")), "{number}");
    }
    assert!(matches!(
        logarithmic(0.0),
        Err(FigureError::Option { name: "y_log", .. })
    ));
}

#[test]
fn no_line_of_the_grid_runs_through_the_word_of_a_level() {
    let levels = Chart {
        levels: vec![(2.3, "people".to_owned())],
        x_levels: vec![(1.5, "journal".to_owned())],
        ..chart(vec![series("a", 0.0)])
    };
    let svg = charts_figure(&[levels], 1, COLUMN_WIDTH, 120.0)
        .unwrap()
        .svg;
    let lines: Vec<&str> = svg.lines().collect();
    for word in [">people</text>", ">journal</text>"] {
        let at = lines.iter().position(|line| line.contains(word)).unwrap();
        assert!(
            lines[at - 1].contains("fill=\"#ffffff\""),
            "{}",
            lines[at - 1]
        );
        let faint = |line: &&&str| line.contains("#dddddd");
        assert_eq!(lines[at..].iter().filter(faint).count(), 0);
    }
}
