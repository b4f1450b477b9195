//! Panels of lines and points with one legend: what the figures of a study have in common.

use gaitshift_analysis::support::{PhaseInterval, SupportPhase};

use crate::canvas::{Anchor, Canvas, Ink, Paint, Point, Rect, TextStyle};
use crate::chart::{Axis, Panel};
use crate::legend::{Spacing, places};
use crate::raster::{fitting, text_width};
use crate::style::{LABEL, QUIET, SERIES, SMALL, TEXT, TITLE, WHITE};
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
    /// Courses of which this one is the mean, as thin lines in its colour.
    pub runs: Vec<Vec<(f64, f64)>>,
    /// Where it is uncertain: (x, low, high), x rising.
    pub band: Vec<(f64, f64, f64)>,
    /// Where on x a motion fell, so that there is no y: crosses over the panel in its colour.
    pub fell: Vec<f64>,
}

impl Series {
    /// The same as the mean of several courses.
    pub fn of_runs(self, runs: Vec<Vec<(f64, f64)>>) -> Self {
        Self { runs, ..self }
    }

    /// The same with a band (x, low, high).
    pub fn within(self, band: Vec<(f64, f64, f64)>) -> Self {
        Self { band, ..self }
    }

    /// The same with falls.
    pub fn fell_at(self, fell: Vec<f64>) -> Self {
        Self { fell, ..self }
    }

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
            runs: Vec::new(),
            band: Vec::new(),
            fell: Vec::new(),
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

    /// Every point that is drawn, those of its band and of its runs included.
    fn places(&self) -> impl Iterator<Item = (f64, f64)> {
        let band = self
            .band
            .iter()
            .flat_map(|&(x, low, high)| [(x, low), (x, high)]);
        let runs = self.runs.iter().flatten().copied();
        self.points.iter().copied().chain(band).chain(runs)
    }

    fn is_empty(&self) -> bool {
        self.places().next().is_none() && self.fell.is_empty()
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
    /// Values of x that a thin dotted line marks, each with a word beside its foot.
    pub x_levels: Vec<(f64, String)>,
    /// Values of y that the axis shows at least.
    pub y_shows: Vec<f64>,
    /// Whether the vertical axis is logarithmic; all its values are positive then.
    pub y_log: bool,
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
    // Room for the longest numbers beside the axes of each column, and for half a number beyond the last.
    let mut titles = vec![0.0_f64; columns];
    for (k, chart) in charts.iter().enumerate() {
        let distance = Panel::y_title_distance(&y_axis(chart, panel_height));
        titles[k % columns] = titles[k % columns].max(distance);
    }
    let (beside, right) = (SMALL + 3.0, 16.0);
    let axes: f64 = titles.iter().map(|distance| distance + beside).sum();
    let panel_width = (width - axes - columns as f64 * right) / columns as f64;
    if !(panel_width >= 60.0 && width <= 4000.0 && (40.0..=2000.0).contains(&panel_height)) {
        return Err(FigureError::Option {
            name: "width",
            value: width,
            allowed: "wide enough for panels of 60 units, and at most 4000; panels 40 to 2000 units high",
        });
    }
    let lefts: Vec<f64> = titles
        .iter()
        .scan(0.0, |x, distance| {
            let left = *x + distance + beside;
            *x = left + panel_width + right;
            Some(left)
        })
        .collect();
    let looks = Looks::of(charts);
    let legend = Legend::new(&looks, charts, width - 16.0);
    let mut canvas_height = legend.height + 6.0;
    let mut tops = Vec::new();
    for row in charts.chunks(columns) {
        let titled = row.iter().any(|chart| !chart.title.is_empty());
        canvas_height += if titled { 18.0 } else { 6.0 };
        canvas_height += row.iter().map(strip_height).fold(0.0, f64::max);
        tops.push(canvas_height);
        canvas_height += panel_height + 2.0 * SMALL + 18.0;
    }
    let mut canvas = Canvas::new(width, canvas_height);
    legend.draw(&mut canvas, 8.0);
    for (k, chart) in charts.iter().enumerate() {
        let column = k % columns;
        let area = Rect::new(lefts[column], tops[k / columns], panel_width, panel_height);
        draw(&mut canvas, area, chart, &looks, titles[column]);
    }
    Ok(Figure {
        svg: canvas.finish(),
    })
}

fn check(charts: &[Chart]) -> Result<(), FigureError> {
    if charts
        .iter()
        .flat_map(|chart| &chart.series)
        .all(Series::is_empty)
    {
        return Err(FigureError::Empty {
            what: "the chart",
            needed: "one point",
        });
    }
    for chart in charts {
        for series in &chart.series {
            let low = series.places().find(|&(_, y)| chart.y_log && y <= 0.0);
            if let Some((_, value)) = low {
                return Err(FigureError::Option {
                    name: "y_log",
                    value,
                    allowed: "with positive values only",
                });
            }
            let values = series.places().map(|(x, y)| [x, y]);
            let falls = series.fell.iter().map(|&x| [x, 0.0]);
            for (index, pair) in values.chain(falls).enumerate() {
                if let Some(value) = pair.into_iter().find(|value| !value.is_finite()) {
                    return Err(FigureError::NotFinite {
                        name: series.label.clone(),
                        index,
                        value,
                    });
                }
            }
        }
    }
    Ok(())
}

/// Falls lie over the panel, those of each series in a row of their own.
const FALLS_ROW: f64 = 8.0;

fn strip_height(chart: &Chart) -> f64 {
    let rows = chart.series.iter().filter(|series| !series.fell.is_empty());
    FALLS_ROW * rows.count() as f64
}

/// The vertical axis of a panel of that height.
fn y_axis(chart: &Chart, height: f64) -> Axis {
    let levels = chart.levels.iter().map(|(level, _)| *level);
    let points = chart.series.iter().flat_map(Series::places);
    let values = points.map(|point| point.1).chain(levels);
    let values = values.chain(chart.y_shows.iter().copied());
    if chart.y_log {
        return Axis::logarithmic(values);
    }
    Axis::around(values, (height / 16.0).clamp(3.0, 8.0) as usize)
}

/// Which look each name has.
struct Looks {
    names: Vec<(String, Drawn)>,
    /// Over the shades of support phases lines are dark, and told apart by dashes alone.
    dark: bool,
}

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
            if !series.is_empty() && names.iter().all(|(name, _)| *name != series.label) {
                names.push((series.label.clone(), series.drawn));
            }
        }
        let dark = charts.iter().any(|chart| !chart.phases.is_empty());
        Self { names, dark }
    }

    fn index(&self, label: &str) -> usize {
        self.names
            .iter()
            .position(|(name, _)| name == label)
            .unwrap_or(0)
    }

    fn ink(&self, index: usize) -> Ink {
        if self.dark {
            TEXT
        } else {
            SERIES[index % SERIES.len()]
        }
    }

    /// Which dashes and which mark: after six looks the colours come again with other ones.
    fn shape(index: usize) -> usize {
        (index + index / SERIES.len()) % DASHES.len()
    }

    fn line(&self, index: usize, width: f64) -> Paint {
        let paint = Paint::stroke(self.ink(index), width);
        match DASHES[Self::shape(index)] {
            Some(dash) => paint.dashed(dash),
            None => paint,
        }
    }

    /// Filled circle, hollow square, filled triangle, hollow diamond, cross, hollow circle.
    fn mark(&self, canvas: &mut Canvas, (x, y): Point, index: usize) {
        let ink = self.ink(index);
        // Hollow ones are open: what lies below them shows.
        let (filled, hollow) = (Paint::fill(ink), Paint::stroke(ink, 1.2));
        let r = 2.6;
        match Self::shape(index) {
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
            4 => Self::cross(canvas, (x, y), r, ink),
            _ => canvas.circle((x, y), r, hollow),
        }
    }

    fn cross(canvas: &mut Canvas, (x, y): Point, r: f64, ink: Ink) {
        canvas.line((x - r, y - r), (x + r, y + r), Paint::stroke(ink, 1.4));
        canvas.line((x - r, y + r), (x + r, y - r), Paint::stroke(ink, 1.4));
    }
}

/// The series by name, then falls and the support phases where there are any.
struct Legend<'a> {
    looks: &'a Looks,
    falls: bool,
    phases: bool,
    /// The names of the series, as far as they fit.
    names: Vec<String>,
    /// Position of each entry relative to the legend's first base line.
    places: Vec<Point>,
    height: f64,
}

impl<'a> Legend<'a> {
    const SPACING: Spacing = Spacing {
        name: 28.0,
        gap: 12.0,
        row: 15.0,
    };
    const FELL: &'static str = "fell (over the panel)";

    fn new(looks: &'a Looks, charts: &[Chart], width: f64) -> Self {
        let phases = charts.iter().any(|chart| !chart.phases.is_empty());
        let falls = charts.iter().any(|chart| strip_height(chart) > 0.0);
        let fit = |(name, _): &(String, Drawn)| fitting(name, SMALL, width - Self::SPACING.name);
        let names: Vec<String> = looks.names.iter().map(fit).collect();
        let mut entries: Vec<&str> = names.iter().map(String::as_str).collect();
        if falls {
            entries.push(Self::FELL);
        }
        if phases {
            entries.extend(support::PHASES.map(support::name));
        }
        let (places, height) = places(entries, Self::SPACING, width);
        Self {
            looks,
            falls,
            phases,
            height,
            names,
            places,
        }
    }

    fn draw(&self, canvas: &mut Canvas, left: f64) {
        let base = 14.0;
        let names = self.names.iter().zip(&self.looks.names);
        let mut places = self.places.iter().map(|(x, y)| (left + x, base + y));
        for (index, ((name, (_, drawn)), (x, y))) in names.zip(&mut places).enumerate() {
            let middle = y - 4.0;
            if *drawn != Drawn::Marks {
                canvas.line((x, middle), (x + 23.0, middle), self.looks.line(index, 1.5));
            }
            if *drawn != Drawn::Line {
                self.looks.mark(canvas, (x + 11.5, middle), index);
            }
            canvas.text((x + Self::SPACING.name, y), name, LABEL);
        }
        if self.falls
            && let Some((x, y)) = places.next()
        {
            Looks::cross(canvas, (x + 11.5, y - 4.0), 2.4, TEXT);
            canvas.text((x + Self::SPACING.name, y), Self::FELL, LABEL);
        }
        if self.phases {
            for (phase, (x, y)) in support::PHASES.into_iter().zip(places) {
                let swatch = Rect::new(x, y - 9.5, 23.0, 11.0);
                canvas.rect(swatch, Paint::fill(support::shade(phase)));
                canvas.rect(swatch, Paint::stroke(QUIET, 0.6));
                canvas.text((x + Self::SPACING.name, y), support::name(phase), LABEL);
            }
        }
    }
}

fn draw(canvas: &mut Canvas, area: Rect, chart: &Chart, looks: &Looks, y_title: f64) {
    let points = || chart.series.iter().flat_map(Series::places);
    let ticks = (area.width / 28.0).clamp(3.0, 10.0) as usize;
    let x = match chart.x_range {
        Some((from, to)) => Axis::exact(from, to, ticks),
        None => {
            let falls = chart
                .series
                .iter()
                .flat_map(|series| series.fell.iter().copied());
            Axis::around(points().map(|point| point.0).chain(falls), ticks)
        }
    };
    let panel = Panel {
        area,
        x,
        y: y_axis(chart, area.height),
    };
    if chart.phases.is_empty() {
        panel.grid(canvas);
    } else {
        support::shade_panel(canvas, &panel, &chart.phases);
    }
    let dotted = Paint::stroke(TEXT, 0.9).dashed("1 2");
    let mut places: Vec<Point> = points().map(|(x, y)| panel.place(x, y)).collect();
    for (level, word) in &chart.levels {
        let (_, y) = panel.place(panel.x.from, *level);
        canvas.line((area.left, y), (area.right(), y), dotted);
        let width = text_width(word, WORD) + 8.0;
        // At the right and above the line, if there it hides nothing; then at the left, and between from right to left.
        let between = (1..20).rev().map(|k| f64::from(k) / 20.0);
        let at: Vec<Point> = [1.0, 0.0]
            .into_iter()
            .chain(between)
            .map(|share| area.left + share * (area.width - width))
            .flat_map(|left| [(left, y - 14.0), (left, y)])
            .collect();
        let (left, top) = level_word(canvas, area, word, width, &at, &places);
        // The next word keeps clear of this one.
        let middle = (0..=8).map(|k| (left + width * f64::from(k) / 8.0, top + 7.0));
        places.extend(middle);
    }
    for (level, word) in &chart.x_levels {
        let x = panel.horizontal(*level);
        canvas.line((x, area.top), (x, area.bottom()), dotted);
        let width = text_width(word, WORD) + 8.0;
        let (foot, head) = (area.bottom() - 14.0, area.top + 1.0);
        let at = [(x, foot), (x, head), (x - width, foot), (x - width, head)];
        level_word(canvas, area, word, width, &at, &places);
    }
    for series in &chart.series {
        let ink = looks.ink(looks.index(&series.label));
        let upper = series.band.iter().map(|&(x, _, high)| (x, high));
        let lower = series.band.iter().rev().map(|&(x, low, _)| (x, low));
        let band = upper.chain(lower).map(|(x, y)| panel.place(x, y));
        if series.band.len() > 1 {
            canvas.open_clip(area);
            canvas.polygon(band, Paint::fill(ink.opacity(0.18)));
            canvas.close_clip();
        }
        for run in &series.runs {
            let (xs, ys): (Vec<f64>, Vec<f64>) = run.iter().copied().unzip();
            panel.curve(canvas, &xs, &ys, Paint::stroke(ink.opacity(0.5), 0.6));
        }
    }
    let (below, above): (Vec<&Series>, Vec<&Series>) =
        chart.series.iter().partition(|series| series.below);
    for series in below.into_iter().chain(above) {
        let index = looks.index(&series.label);
        let (xs, ys): (Vec<f64>, Vec<f64>) = series.points.iter().copied().unzip();
        if series.drawn != Drawn::Marks && xs.len() > 1 {
            let width = if series.runs.is_empty() { 1.5 } else { 2.2 };
            panel.curve(canvas, &xs, &ys, looks.line(index, width));
        }
        if series.drawn != Drawn::Line || xs.len() == 1 {
            for &(x, y) in &series.points {
                if (panel.x.from..=panel.x.to).contains(&x) {
                    looks.mark(canvas, panel.place(x, y), index);
                }
            }
        }
    }
    let strip = strip_height(chart);
    let fallen = chart.series.iter().filter(|series| !series.fell.is_empty());
    for (row, series) in fallen.enumerate() {
        let y = area.top - strip + FALLS_ROW * (row as f64 + 0.4);
        let ink = looks.ink(looks.index(&series.label));
        for &x in series
            .fell
            .iter()
            .filter(|&x| (panel.x.from..=panel.x.to).contains(x))
        {
            Looks::cross(canvas, (panel.horizontal(x), y), 2.4, ink);
        }
    }
    panel.frame(canvas, true);
    if !chart.title.is_empty() {
        canvas.text((area.left, area.top - strip - 6.0), &chart.title, TITLE);
    }
    panel.x_title(canvas, &chart.x_title);
    panel.y_title(canvas, &chart.y_title, y_title);
}

/// Size of the word beside a level.
const WORD: f64 = 9.0;

/// A word at that of the places `at` (its left upper corner) where it hides the fewest points, the first of equals; gives the place. No line
/// of the grid runs through it.
fn level_word(
    canvas: &mut Canvas,
    area: Rect,
    word: &str,
    width: f64,
    at: &[Point],
    points: &[Point],
) -> Point {
    // Marks have a radius of 3; those on the line itself stay beside the word.
    let hidden = |left: f64, top: f64| {
        let covers = |p: &&Point| {
            (left - 3.0..left + width + 3.0).contains(&p.0)
                && (top - 3.0..top + 13.5).contains(&p.1)
        };
        points.iter().filter(covers).count()
    };
    let inside = |&(left, top): &Point| {
        top >= area.top
            && top + 13.0 <= area.bottom()
            && left >= area.left - 0.1
            && left + width <= area.right() + 0.1
    };
    let (left, top) = at
        .iter()
        .copied()
        .filter(inside)
        .min_by_key(|&(left, top)| hidden(left, top))
        .unwrap_or(at[0]);
    let ground = Rect::new(left + 2.0, top + 2.5, width - 4.0, 10.5);
    canvas.rect(ground, Paint::fill(WHITE));
    canvas.text((left + 4.0, top + 11.0), word, TextStyle::new(WORD, TEXT));
    (left, top)
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
    /// Colour and, where it is hatched, the distance of the lines and their colour.
    const FILLS: [(u32, f64, Ink); 10] = [
        (0x0072b2, 0.0, TEXT),
        (0xf0d9a0, 0.0, TEXT),
        (0xe0894a, 4.0, TEXT),
        (0xffffff, 0.0, TEXT),
        (0x3d3d3d, 0.0, TEXT),
        (0xb8dcf0, 5.0, TEXT),
        (0x009e73, 4.0, WHITE),
        (0xcc79a7, 2.2, TEXT),
        (0xffffff, 3.0, TEXT),
        (0xa6a6a6, 0.0, TEXT),
    ];
    let (fill, hatch, lines) = FILLS[index % FILLS.len()];
    canvas.rect(rect, Paint::fill(Ink::hex(fill)));
    if hatch > 0.0 && rect.width > 0.5 {
        canvas.hatch(rect, lines.opacity(0.75), hatch);
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
