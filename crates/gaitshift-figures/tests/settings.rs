//! The figure of settings shows every seed of every setting, and the interval of each; what cannot be drawn is named.

use crate::common::{count, drawn_size};
use gaitshift_figures::{FigureError, Setting, settings_figure};

fn setting(label: &str, values: &[f64]) -> Setting {
    Setting {
        label: label.to_owned(),
        values: values.to_vec(),
        estimate: values.first().map(|&v| (v - 1.0, v, v + 1.0)),
    }
}

#[test]
fn every_seed_is_a_dot_beside_the_name_of_its_setting() {
    let settings = [
        setting("rubber", &[30.0, 31.0, 31.0]),
        setting("ice <1>", &[12.0, 14.0]),
    ];
    let figure = settings_figure(&settings, "criteria met", 39.0).unwrap();
    let (width, height) = drawn_size(&figure);
    assert!(width > 400.0 && height > 80.0);
    assert_eq!(count(&figure.svg, "<circle"), 5);
    for text in ["rubber", "ice &lt;1&gt;", "criteria met"] {
        assert!(figure.svg.contains(text), "{text}");
    }
    // More settings make a higher picture, not a wider one.
    let many: Vec<Setting> = (0..40)
        .map(|k| setting(&format!("s{k}"), &[k as f64]))
        .collect();
    let tall = drawn_size(&settings_figure(&many, "criteria met", 39.0).unwrap());
    assert!(tall.1 > 8.0 * height && tall.0 <= width + 20.0);
}

#[test]
fn a_long_name_is_cut() {
    let long = "learning_rate=0.0001 ".repeat(20);
    let figure = settings_figure(&[setting(&long, &[1.0])], "criteria met", 39.0).unwrap();
    assert!(figure.svg.contains('…') && !figure.svg.contains(&long));
    assert!(drawn_size(&figure).0 < 1000.0);
}

#[test]
fn what_cannot_be_drawn_is_named() {
    let empty = settings_figure(&[setting("none", &[])], "criteria met", 39.0);
    assert!(matches!(empty, Err(FigureError::Empty { .. })));
    let infinite = settings_figure(&[setting("far", &[f64::INFINITY])], "criteria met", 39.0);
    assert!(matches!(infinite, Err(FigureError::NotFinite { .. })));
}
