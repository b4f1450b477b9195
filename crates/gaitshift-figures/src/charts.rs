//! Panels of lines and points with one legend: what the figures of a study have in common.

use gaitshift_analysis::support::{PhaseInterval, SupportPhase};

use crate::canvas::{Anchor, Canvas, Ink, Paint, Point, Rect, TextStyle};
use crate::chart::{Axis, Panel};
use crate::raster::text_width;
use crate::style::{LABEL, QUIET, SERIES, SMALL, TEXT, TITLE};
use crate::support;
use crate::{Figure, FigureError};

/// Width of a figure that fills a journal's column of 85 to 90 mm, in user units of 1/96 inch.
pub const COLUMN_WIDTH: f64 = 330.0;
/// Width of a figure that fills both columns.
pub const PAGE_WIDTH: f64 = 680.0;

/// How the points of a series are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drawn {
    /// A line.
    Line,
    /// Marks without a line.
    Marks,
    /// Marks joined by a line.
    MarkedLine,
}

/// Points under a name. Series of the same name look alike in all panels and have one entry in the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub label: String,
    /// Pairs (x, y), in the order in which a line joins them.
    pub points: Vec<(f64, f64)>,
    /// Line, marks or both.
    pub drawn: Drawn,
    /// Whether it lies below the others, wherever it stands in the legend.
    pub below: bool,
}

impl Series {
    /// The same below all others.
    pub fn below(self) -> Self {
        Self {
            below: true,
            ..self
        }
    }

    /// A line.
    pub fn line(label: &str, points: Vec<(f64, f64)>) -> Self {
        Self {
            label: label.to_owned(),
            points,
            drawn: Drawn::Line,
            below: false,
        }
    }

    /// Marks.
    pub fn marks(label: &str, points: Vec<(f64, f64)>) -> Self {
        Self {
            drawn: Drawn::Marks,
            ..Self::line(label, points)
        }
    }

    /// Marks joined by a line.
    pub fn marked_line(label: &str, points: Vec<(f64, f64)>) -> Self {
        Self {
            drawn: Drawn::MarkedLine,
            ..Self::line(label, points)
        }
    }
}

/// A panel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    /// Over the panel; may be empty.
    pub title: String,
    /// Title of the horizontal axis with its unit.
    pub x_title: String,
    /// Title of the vertical axis with its unit.
    pub y_title: String,
    /// What is drawn, the first below the others.
    pub series: Vec<Series>,
    /// Support phases in the background, their times in the unit of x.
    pub phases: Vec<PhaseInterval>,
    /// Values of y that a thin dotted line marks, each with a word beside it.
    pub levels: Vec<(f64, String)>,
    /// Values of y that the axis shows at least.
    pub y_shows: Vec<f64>,
    /// Range of x; that of the points if absent.
    pub x_range: Option<(f64, f64)>,
}

/// Panels in `columns` beside each other on a sheet `width` units wide, each `panel_height` high, under one legend.
///
/// Series are told apart by colour, by dashes and by the shape of their marks, so that grey print is enough.
///
/// # Errors
/// [`FigureError::Empty`] without any point, [`FigureError::NotFinite`] for a value that cannot be drawn,
/// [`FigureError::Option`] for a sheet too narrow for its panels.
pub fn charts_figure(
    charts: &[Chart],
    columns: usize,
    width: f64,
    panel_height: f64,
) -> Result<Figure, FigureError> {
    check(charts)?;
    let columns = columns.clamp(1, charts.len());
    let (left, right, gap) = (50.0, 10.0, 56.0);
    let panel_width = (width - left - right - (columns - 1) as f64 * gap) / columns as f64;
    if !(panel_width >= 60.0 && width <= 4000.0 && (40.0..=2000.0).contains(&panel_height)) {
        return Err(FigureError::Option {
            name: "width",
            value: width,
            allowed: "wide enough for panels of 60 units, and at most 4000; panels 40 to 2000 units high",
        });
    }
    let looks = Looks::of(charts);
    let legend = Legend::new(&looks, charts, width - 16.0);
    let rows = charts.len().div_ceil(columns);
    let titled = |row: usize| {
        let of_row = charts.iter().skip(row * columns).take(columns);
        of_row.clone().any(|chart| !chart.title.is_empty())
    };
    let mut tops = Vec::with_capacity(rows);
    let mut y = legend.height + 6.0;
    for row in 0..rows {
        y += if titled(row) { 18.0 } else { 6.0 };
        tops.push(y);
        y += panel_height + 2.0 * SMALL + 18.0;
    }
    let mut canvas = Canvas::new(width, y);
    legend.draw(&mut canvas, 8.0);
    for (k, chart) in charts.iter().enumerate() {
        let area = Rect::new(
            left + (k % columns) as f64 * (panel_width + gap),
            tops[k / columns],
            panel_width,
            panel_height,
        );
        draw(&mut canvas, area, chart, &looks);
    }
    Ok(Figure {
        svg: canvas.finish(),
    })
}

fn check(charts: &[Chart]) -> Result<(), FigureError> {
    let series = || charts.iter().flat_map(|chart| &chart.series);
    if series().all(|series| series.points.is_empty()) {
        return Err(FigureError::Empty {
            what: "the chart",
            needed: "one point",
        });
    }
    for series in series() {
        for (index, &(x, y)) in series.points.iter().enumerate() {
            if let Some(value) = [x, y].into_iter().find(|value| !value.is_finite()) {
                return Err(FigureError::NotFinite {
                    name: series.label.clone(),
                    index,
                    value,
                });
            }
        }
    }
    Ok(())
}

/// Which look each name has.
struct Looks(Vec<(String, Drawn)>);

const DASHES: [Option<&str>; 6] = [
    None,
    Some("6 2.5"),
    Some("1.6 2.2"),
    Some("8 2.5 1.6 2.5"),
    Some("3 1.6"),
    Some("10 4"),
];

impl Looks {
    fn of(charts: &[Chart]) -> Self {
        let mut names: Vec<(String, Drawn)> = Vec::new();
        for series in charts.iter().flat_map(|chart| &chart.series) {
            if !series.points.is_empty() && names.iter().all(|(name, _)| *name != series.label) {
                names.push((series.label.clone(), series.drawn));
            }
        }
        Self(names)
    }

    fn index(&self, label: &str) -> usize {
        self.0
            .iter()
            .position(|(name, _)| name == label)
            .unwrap_or(0)
    }

    fn ink(index: usize) -> Ink {
        SERIES[index % SERIES.len()]
    }

    fn line(index: usize) -> Paint {
        let paint = Paint::stroke(Self::ink(index), 1.5);
        match DASHES[index % DASHES.len()] {
            Some(dash) => paint.dashed(dash),
            None => paint,
        }
    }

    /// Filled circle, hollow square, filled triangle, hollow diamond, cross, hollow circle.
    fn mark(canvas: &mut Canvas, (x, y): Point, index: usize) {
        let ink = Self::ink(index);
        // Hollow ones are open: what lies below them shows.
        let (filled, hollow) = (Paint::fill(ink), Paint::stroke(ink, 1.2));
        let r = 2.6;
        match index % 6 {
            0 => canvas.circle((x, y), r, filled),
            1 => canvas.rect(Rect::new(x - r, y - r, 2.0 * r, 2.0 * r), hollow),
            2 => canvas.polygon(
                [
                    (x, y - 1.25 * r),
                    (x + 1.15 * r, y + 0.8 * r),
                    (x - 1.15 * r, y + 0.8 * r),
                ],
                filled,
            ),
            3 => canvas.polygon(
                [
                    (x, y - 1.4 * r),
                    (x + 1.4 * r, y),
                    (x, y + 1.4 * r),
                    (x - 1.4 * r, y),
                ],
                hollow,
            ),
            4 => {
                canvas.line((x - r, y - r), (x + r, y + r), Paint::stroke(ink, 1.4));
                canvas.line((x - r, y + r), (x + r, y - r), Paint::stroke(ink, 1.4));
            }
            _ => canvas.circle((x, y), r, hollow),
        }
    }
}

/// The series by name, then the support phases if any panel is shaded.
struct Legend<'a> {
    looks: &'a Looks,
    phases: bool,
    /// Position of each entry relative to the legend's first base line.
    places: Vec<Point>,
    height: f64,
}

impl<'a> Legend<'a> {
    const ROW: f64 = 15.0;
    const SWATCH: f64 = 28.0;

    fn new(looks: &'a Looks, charts: &[Chart], width: f64) -> Self {
        let phases = charts.iter().any(|chart| !chart.phases.is_empty());
        let (mut x, mut y) = (0.0, 0.0);
        let mut places = Vec::new();
        let mut names: Vec<&str> = looks.0.iter().map(|(name, _)| name.as_str()).collect();
        if phases {
            names.extend(support::PHASES.map(support::name));
        }
        for name in names {
            let entry = Self::SWATCH + text_width(name, SMALL);
            if x > 0.0 && x + entry > width {
                (x, y) = (0.0, y + Self::ROW);
            }
            places.push((x, y));
            x += entry + 12.0;
        }
        Self {
            looks,
            phases,
            height: y + Self::ROW,
            places,
        }
    }

    fn draw(&self, canvas: &mut Canvas, left: f64) {
        let base = 14.0;
        let names = self.looks.0.iter();
        let mut places = self.places.iter().map(|(x, y)| (left + x, base + y));
        for (index, ((name, drawn), (x, y))) in names.zip(&mut places).enumerate() {
            let middle = y - 4.0;
            if *drawn != Drawn::Marks {
                canvas.line((x, middle), (x + 23.0, middle), Looks::line(index));
            }
            if *drawn != Drawn::Line {
                Looks::mark(canvas, (x + 11.5, middle), index);
            }
            canvas.text((x + Self::SWATCH, y), name, LABEL);
        }
        if self.phases {
            for (phase, (x, y)) in support::PHASES.into_iter().zip(places) {
                let swatch = Rect::new(x + 6.0, y - 9.5, 17.0, 11.0);
                canvas.rect(swatch, Paint::fill(support::shade(phase)));
                canvas.rect(swatch, Paint::stroke(QUIET, 0.6));
                canvas.text((x + Self::SWATCH, y), support::name(phase), LABEL);
            }
        }
    }
}

fn draw(canvas: &mut Canvas, area: Rect, chart: &Chart, looks: &Looks) {
    let points = || chart.series.iter().flat_map(|series| &series.points);
    let ticks = (area.width / 34.0).clamp(3.0, 10.0) as usize;
    let x = match chart.x_range {
        Some((from, to)) => Axis::exact(from, to, ticks),
        None => Axis::around(points().map(|point| point.0), ticks),
    };
    let levels = chart.levels.iter().map(|(level, _)| *level);
    let values = points().map(|point| point.1).chain(levels);
    let panel = Panel {
        area,
        x,
        y: Axis::around(
            values.chain(chart.y_shows.iter().copied()),
            (area.height / 16.0).clamp(3.0, 8.0) as usize,
        ),
    };
    if chart.phases.is_empty() {
        panel.grid(canvas);
    } else {
        support::shade_panel(canvas, &panel, &chart.phases);
    }
    for (level, word) in &chart.levels {
        let (_, y) = panel.place(panel.x.from, *level);
        let dotted = Paint::stroke(TEXT, 0.9).dashed("1 2");
        canvas.line((area.left, y), (area.right(), y), dotted);
        // Where it hides the fewest points, if it can be at the right and above its line.
        let width = text_width(word, 9.0) + 8.0;
        let hidden = |left: f64, top: f64| {
            let places = points().map(|&(x, y)| panel.place(x, y));
            let covers =
                |p: &Point| (left..left + width).contains(&p.0) && (top..top + 15.0).contains(&p.1);
            places.filter(covers).count()
        };
        let (right, above) = (area.right() - width, y - 14.0);
        let at = [
            (right, above),
            (area.left, above),
            (right, y),
            (area.left, y),
        ];
        let inside = |&(_, top): &(f64, f64)| top >= area.top && top + 13.0 <= area.bottom();
        let (left, top) = at
            .into_iter()
            .filter(inside)
            .min_by_key(|&(left, top)| hidden(left, top))
            .unwrap_or((right, above));
        let style = TextStyle::new(9.0, TEXT);
        canvas.text((left + 4.0, top + 11.0), word, style);
    }
    let (below, above): (Vec<&Series>, Vec<&Series>) =
        chart.series.iter().partition(|series| series.below);
    for series in below.into_iter().chain(above) {
        let index = looks.index(&series.label);
        let (xs, ys): (Vec<f64>, Vec<f64>) = series.points.iter().copied().unzip();
        if series.drawn != Drawn::Marks && xs.len() > 1 {
            panel.curve(canvas, &xs, &ys, Looks::line(index));
        }
        if series.drawn != Drawn::Line || xs.len() == 1 {
            for &(x, y) in &series.points {
                if (panel.x.from..=panel.x.to).contains(&x) {
                    Looks::mark(canvas, panel.place(x, y), index);
                }
            }
        }
    }
    panel.frame(canvas, true);
    if !chart.title.is_empty() {
        canvas.text((area.left, area.top - 6.0), &chart.title, TITLE);
    }
    panel.x_title(canvas, &chart.x_title);
    panel.y_title(canvas, &chart.y_title, 38.0);
}

/// A bar made of parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// Beside the bar.
    pub label: String,
    /// Parts from left to right by name, 0 or greater.
    pub parts: Vec<(String, f64)>,
}

/// Bars lying below each other, their parts in the order given; up to ten are told apart by lightness and hatching.
///
/// # Errors
/// [`FigureError::Empty`] without a part, [`FigureError::NotFinite`] for one that is negative or not a number.
pub fn bars_figure(bars: &[Bar], quantity: &str, width: f64) -> Result<Figure, FigureError> {
    let mut names: Vec<&str> = Vec::new();
    for (name, value) in bars.iter().flat_map(|bar| &bar.parts) {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
        if !(value.is_finite() && *value >= 0.0) {
            return Err(FigureError::NotFinite {
                name: name.clone(),
                index: 0,
                value: *value,
            });
        }
    }
    if names.is_empty() {
        return Err(FigureError::Empty {
            what: "the bars",
            needed: "one part",
        });
    }
    let (row, thick, swatch) = (15.0, 17.0, 20.0);
    let (mut x, mut y) = (0.0, 0.0);
    let mut places = Vec::new();
    for name in &names {
        let entry = swatch + text_width(name, SMALL);
        if x > 0.0 && x + entry > width - 16.0 {
            (x, y) = (0.0, y + row);
        }
        places.push((8.0 + x, 14.0 + y));
        x += entry + 12.0;
    }
    let labels = bars.iter().map(|bar| text_width(&bar.label, SMALL));
    let left = 14.0 + labels.fold(0.0, f64::max);
    let top = 24.0 + y;
    let total = |bar: &Bar| bar.parts.iter().map(|part| part.1).sum::<f64>();
    let most = bars.iter().map(total).fold(0.0, f64::max);
    let height = bars.len() as f64 * (thick + 8.0) + 6.0;
    let panel = Panel {
        area: Rect::new(left, top, width - left - 14.0, height),
        x: Axis::exact(0.0, 1.03 * most.max(1e-9), (width / 75.0) as usize),
        y: Axis::exact(0.0, 1.0, 1),
    };
    let mut canvas = Canvas::new(width, top + height + 2.0 * SMALL + 18.0);
    for (index, (name, &(x, y))) in names.iter().zip(&places).enumerate() {
        part(&mut canvas, Rect::new(x, y - 9.5, 15.0, 11.0), index);
        canvas.text((x + swatch, y), name, LABEL);
    }
    for (k, bar) in bars.iter().enumerate() {
        let bar_top = top + 7.0 + k as f64 * (thick + 8.0);
        let mut from = 0.0;
        for (name, value) in &bar.parts {
            let index = names.iter().position(|n| n == name).unwrap_or(0);
            let (a, b) = (panel.horizontal(from), panel.horizontal(from + value));
            part(&mut canvas, Rect::new(a, bar_top, b - a, thick), index);
            from += value;
        }
        let style = LABEL.anchor(Anchor::End);
        canvas.text((left - 6.0, bar_top + 12.5), &bar.label, style);
    }
    canvas.line(
        (left, panel.area.bottom()),
        (panel.area.right(), panel.area.bottom()),
        Paint::stroke(TEXT, 0.8),
    );
    panel.x_ticks(&mut canvas, true);
    panel.x_title(&mut canvas, quantity);
    Ok(Figure {
        svg: canvas.finish(),
    })
}

/// Fills a part: no two of ten look alike, in grey either.
fn part(canvas: &mut Canvas, rect: Rect, index: usize) {
    /// Colour and, where it is hatched, the distance of the lines.
    const FILLS: [(u32, f64); 10] = [
        (0x0072b2, 0.0),
        (0xf0d9a0, 0.0),
        (0xe0894a, 4.0),
        (0xffffff, 0.0),
        (0x3d3d3d, 0.0),
        (0xb8dcf0, 5.0),
        (0x009e73, 0.0),
        (0xcc79a7, 2.2),
        (0xffffff, 3.0),
        (0xa6a6a6, 0.0),
    ];
    let (fill, hatch) = FILLS[index % FILLS.len()];
    canvas.rect(rect, Paint::fill(Ink::hex(fill)));
    if hatch > 0.0 && rect.width > 0.5 {
        canvas.hatch(rect, TEXT.opacity(0.75), hatch);
    }
    canvas.rect(rect, Paint::stroke(TEXT, 0.6));
}

/// A phase of the support in the unit of a chart's x, for [`Chart::phases`].
pub fn phase_between(phase: SupportPhase, from: f64, to: f64) -> Option<PhaseInterval> {
    let window = gaitshift_analysis::Window::new(0, 1)?;
    Some(PhaseInterval {
        phase,
        window,
        start_s: from,
        end_s: to,
    })
}
