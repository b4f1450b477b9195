//! Panels of intervals: of each point a middle and its range.

use crate::canvas::{Canvas, Paint, Rect};
use crate::chart::{Axis, Panel};
use crate::legend::{Spacing, places};
use crate::raster::{fitting, text_width};
use crate::style::{LABEL, QUIET, SERIES, SMALL, TITLE};
use crate::{Figure, FigureError};

/// A middle value and its range at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntervalPoint {
    /// Index of its series, which gives its colour.
    pub series: usize,
    /// Place on the horizontal axis.
    pub x: f64,
    /// Lower end of the range.
    pub low: f64,
    /// Middle, drawn as a dot.
    pub middle: f64,
    /// Upper end of the range.
    pub high: f64,
}

/// A panel of intervals.
#[derive(Clone, Debug, PartialEq)]
pub struct IntervalPanel {
    /// What it shows, with its unit.
    pub title: String,
    /// Title of the horizontal axis.
    pub x_title: String,
    /// Its points; those of a series are joined in the order of x.
    pub points: Vec<IntervalPoint>,
}

const COLUMNS: usize = 4;
const SPACING: Spacing = Spacing {
    name: 16.0,
    gap: 16.0,
    row: 17.0,
};
const NOTE: &str = "dots: median over the starts; lines: least to greatest";
/// Of the legend.
const FIRST_BASE: f64 = 19.0;

/// Intervals in panels, four beside each other, their series named above them. The values begin at 0.
///
/// # Errors
/// [`FigureError::Empty`] without any point, [`FigureError::NotFinite`] for a value that cannot be drawn.
pub fn intervals_figure(
    series: &[String],
    panels: &[IntervalPanel],
) -> Result<Figure, FigureError> {
    if panels.iter().all(|panel| panel.points.is_empty()) {
        return Err(FigureError::Empty {
            what: "the table of intervals",
            needed: "one point",
        });
    }
    for panel in panels {
        for (index, p) in panel.points.iter().enumerate() {
            let values = [p.x, p.low, p.middle, p.high];
            if let Some(&value) = values.iter().find(|value| !value.is_finite()) {
                return Err(FigureError::NotFinite {
                    name: panel.title.clone(),
                    index,
                    value,
                });
            }
        }
    }
    let (width, height, gap) = (150.0, 104.0, (46.0, 62.0));
    let left = 46.0;
    let columns = panels.len().min(COLUMNS);
    let rows = panels.len().div_ceil(COLUMNS);
    let of_panels = left + columns as f64 * (width + gap.0) - gap.0 + 14.0;
    // One panel is narrower than what stands over it.
    let sheet_width = of_panels.max(left + text_width(NOTE, SMALL) + SPACING.gap);
    let legend_width = sheet_width - left - SPACING.gap;
    let fit = |name: &String| fitting(name, SMALL, legend_width - SPACING.name);
    let names: Vec<String> = series.iter().map(fit).collect();
    let (places, legend_height) = places(names.iter().map(String::as_str), SPACING, legend_width);
    let note = FIRST_BASE + legend_height;
    let top = note + 16.0;
    let mut canvas = Canvas::new(sheet_width, top + rows as f64 * (height + gap.1));
    for ((name, (x, y)), ink) in names.iter().zip(places).zip(SERIES.into_iter().cycle()) {
        let (x, base) = (left + x, FIRST_BASE + y);
        canvas.circle((x + 6.0, base - 4.0), 3.5, Paint::fill(ink));
        canvas.text((x + SPACING.name, base), name, LABEL);
    }
    canvas.text((left, note), NOTE, LABEL);
    for (k, panel) in panels.iter().enumerate() {
        let place = ((k % COLUMNS) as f64, (k / COLUMNS) as f64);
        let area = Rect::new(
            left + place.0 * (width + gap.0),
            top + 8.0 + place.1 * (height + gap.1),
            width,
            height,
        );
        draw(&mut canvas, area, panel);
    }
    Ok(Figure {
        svg: canvas.finish(),
    })
}

fn draw(canvas: &mut Canvas, area: Rect, panel: &IntervalPanel) {
    let points = &panel.points;
    let chart = Panel {
        area,
        x: Axis::around(points.iter().map(|p| p.x), 4),
        y: Axis::around(points.iter().map(|p| p.high).chain([0.0]), 4),
    };
    chart.grid(canvas);
    canvas.text((area.left, area.top - 7.0), &panel.title, TITLE);
    let last = points.iter().map(|p| p.series).max().unwrap_or(0);
    for (series, ink) in (0..=last).zip(SERIES.into_iter().cycle()) {
        let mut own: Vec<_> = points.iter().filter(|p| p.series == series).collect();
        own.sort_by(|a, b| a.x.total_cmp(&b.x));
        // Ranges of several series at one place stand beside each other.
        let apart = 3.0_f64.min(14.0 / last.max(1) as f64);
        let shift = apart * (series as f64 - 0.5 * last as f64);
        let shared = points
            .iter()
            .any(|p| p.series != series && own.iter().any(|o| o.x == p.x));
        let at = |x: f64, y: f64| {
            let (x, y) = chart.place(x, y);
            (if shared { x + shift } else { x }, y)
        };
        if own.len() > 1 {
            let line = own.iter().map(|p| at(p.x, p.middle));
            canvas.polyline(line, Paint::stroke(ink.opacity(0.45), 1.0));
        }
        for p in own {
            canvas.line(at(p.x, p.low), at(p.x, p.high), Paint::stroke(ink, 1.6));
            canvas.circle(at(p.x, p.middle), 2.8, Paint::fill(ink));
        }
    }
    if points.is_empty() {
        let middle = (area.left + 8.0, area.top + 0.5 * area.height);
        canvas.text(
            middle,
            "no values",
            crate::canvas::TextStyle::new(SMALL, QUIET),
        );
    }
    chart.frame(canvas, true);
    chart.x_title(canvas, &panel.x_title);
}
