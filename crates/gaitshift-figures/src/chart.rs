//! Axes, ticks and lines of a chart panel.

use crate::canvas::{Anchor, Canvas, Ink, Paint, Point, Rect, TextStyle};
use crate::raster::text_width;
use crate::style::{FAINT, LABEL, SMALL, TEXT};

/// Values beyond this cannot be told apart in a picture, and their differences could overflow.
const GREATEST: f64 = 1e15;

/// A range of values with round ticks.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    pub from: f64,
    pub to: f64,
    step: f64,
    /// Whether equal factors, not equal differences, lie equally far apart.
    log: bool,
}

impl Axis {
    /// Exactly `from` to `to`, with about `ticks` ticks; an empty range is widened.
    pub fn exact(from: f64, to: f64, ticks: usize) -> Self {
        let (mut from, mut to) = (
            from.clamp(-GREATEST, GREATEST),
            to.clamp(-GREATEST, GREATEST),
        );
        // Narrower than this, neighbouring ticks would have the same label.
        let least = 1e-6 * from.abs().max(to.abs()).max(1e-3);
        if to - from < least {
            let room = (0.1 * from.abs()).max(0.5);
            (from, to) = (from - room, to + room);
        }
        Self {
            from,
            to,
            step: round_step((to - from) / ticks.max(1) as f64),
            log: false,
        }
    }

    /// A logarithmic range around all `values`, which are positive, with ticks at 1, 2 and 5 times the powers of ten.
    pub fn logarithmic(values: impl IntoIterator<Item = f64>) -> Self {
        let (low, high) = values
            .into_iter()
            .fold((f64::INFINITY, 0.0_f64), |(low, high), value| {
                (low.min(value), high.max(value))
            });
        let (low, high) = if low > high { (1.0, 10.0) } else { (low, high) };
        Self {
            from: (low / 1.2).max(1.0 / GREATEST),
            to: (high * 1.2).min(GREATEST),
            step: 1.0,
            log: true,
        }
    }

    /// A range around all `values` with a little room, with about `ticks` ticks.
    pub fn around(values: impl IntoIterator<Item = f64>, ticks: usize) -> Self {
        let (low, high) = values
            .into_iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            });
        if low > high {
            return Self::exact(0.0, 1.0, ticks);
        }
        let tight = Self::exact(low, high, ticks);
        let room = 0.06 * (tight.to - tight.from);
        Self::exact(tight.from - room, tight.to + room, ticks)
    }

    /// Position of a value: 0 at the start of the range, 1 at its end.
    pub fn share(&self, value: f64) -> f64 {
        if self.log {
            return (value / self.from).ln() / (self.to / self.from).ln();
        }
        (value - self.from) / (self.to - self.from)
    }

    /// Ticks in the range and what is written beside them.
    pub fn ticks(&self) -> Vec<(f64, String)> {
        if self.log {
            return self.log_ticks();
        }
        let first = (self.from / self.step - 1e-6).ceil();
        let last = (self.to / self.step + 1e-6).floor();
        let count = (last - first).clamp(-1.0, 50.0) as i64;
        let decimals = (-self.step.log10()).ceil().clamp(0.0, 9.0) as usize;
        (0..=count)
            .map(|i| {
                // Adding 0 turns a negative zero into zero.
                let value = (first + i as f64) * self.step + 0.0;
                (value, label(value, decimals))
            })
            .collect()
    }
}

impl Axis {
    fn log_ticks(&self) -> Vec<(f64, String)> {
        let powers = self.from.log10().floor() as i32..=self.to.log10().ceil() as i32;
        powers
            .flat_map(|power| [1.0, 2.0, 5.0].map(|factor| (factor * 10f64.powi(power), power)))
            .filter(|(value, _)| (self.from..=self.to).contains(value))
            .map(|(value, power)| (value, label(value, (-power).clamp(0, 9) as usize)))
            .collect()
    }
}

/// 1, 2 or 5 times a power of ten, at least `rough`.
fn round_step(rough: f64) -> f64 {
    let power = 10f64.powf(rough.log10().floor());
    let factor = [1.0, 2.0, 5.0]
        .into_iter()
        .find(|f| f * power >= rough * 0.999);
    factor.unwrap_or(10.0) * power
}

/// A number with a true minus sign, as a power of ten where it is long.
fn label(value: f64, decimals: usize) -> String {
    let text = if value.abs() >= 1e5 || (value != 0.0 && value.abs() < 1e-5) {
        format!("{value:.1e}")
    } else {
        format!("{value:.decimals$}")
    };
    text.replace('-', "\u{2212}")
}

/// A panel: its place on the sheet and its two axes.
#[derive(Clone, Debug)]
pub(crate) struct Panel {
    pub area: Rect,
    pub x: Axis,
    pub y: Axis,
}

impl Panel {
    /// Position of a pair of values on the sheet.
    pub fn place(&self, x: f64, y: f64) -> Point {
        (
            self.horizontal(x),
            self.area.bottom() - self.y.share(y) * self.area.height,
        )
    }

    pub fn horizontal(&self, x: f64) -> f64 {
        self.area.left + self.x.share(x) * self.area.width
    }

    /// The part of the panel between two values of x, over its full height.
    pub fn band(&self, from: f64, to: f64) -> Rect {
        let left = self.horizontal(from.max(self.x.from));
        let right = self.horizontal(to.min(self.x.to));
        Rect::new(left, self.area.top, right - left, self.area.height)
    }

    /// Faint lines at the ticks of y.
    pub fn grid(&self, canvas: &mut Canvas) {
        for (value, _) in self.y.ticks() {
            let (_, y) = self.place(self.x.from, value);
            canvas.line(
                (self.area.left, y),
                (self.area.right(), y),
                Paint::stroke(FAINT, 0.7),
            );
        }
    }

    /// A curve, clipped to the panel. Points closer than the eye can tell are left out.
    pub fn curve(&self, canvas: &mut Canvas, xs: &[f64], ys: &[f64], paint: Paint) {
        let mut points: Vec<Point> = Vec::new();
        let mut skipped = None;
        for (&x, &y) in xs.iter().zip(ys) {
            let point = self.place(x, y);
            let near = |last: &Point| (point.0 - last.0).hypot(point.1 - last.1) < 0.35;
            if points.last().is_some_and(near) {
                skipped = Some(point);
            } else {
                points.push(point);
                skipped = None;
            }
        }
        points.extend(skipped);
        canvas.open_clip(self.area);
        if let [only] = points[..] {
            canvas.polyline([(only.0 - 1.0, only.1), (only.0 + 1.0, only.1)], paint);
        } else {
            canvas.polyline(points, paint);
        }
        canvas.close_clip();
    }

    /// The frame and the ticks of both axes; numbers below only if `x_labels`.
    pub fn frame(&self, canvas: &mut Canvas, x_labels: bool) {
        let area = self.area;
        canvas.rect(area, Paint::stroke(TEXT, 0.8));
        for (value, text) in self.y.ticks() {
            let (_, y) = self.place(self.x.from, value);
            canvas.line(
                (area.left - 4.0, y),
                (area.left, y),
                Paint::stroke(TEXT, 0.8),
            );
            let position = (area.left - 6.5, y + 0.36 * SMALL);
            canvas.text(position, &text, LABEL.anchor(Anchor::End));
        }
        self.x_ticks(canvas, x_labels);
    }

    /// The ticks of the lower axis; numbers only if `labels`.
    pub fn x_ticks(&self, canvas: &mut Canvas, labels: bool) {
        for (value, text) in self.x.ticks() {
            let x = self.horizontal(value);
            let foot = self.area.bottom();
            canvas.line((x, foot), (x, foot + 4.0), Paint::stroke(TEXT, 0.8));
            if labels {
                let position = (x, foot + 5.0 + SMALL);
                canvas.text(position, &text, LABEL.anchor(Anchor::Middle));
            }
        }
    }

    /// Ticks and title of a second axis on the right; takes up to 56 units there for usual numbers.
    pub fn right_axis(&self, canvas: &mut Canvas, axis: &Axis, title: &str, ink: Ink) {
        let area = self.area;
        let style = TextStyle::new(SMALL, ink);
        let mut widest: f64 = 0.0;
        for (value, text) in axis.ticks() {
            let y = area.bottom() - axis.share(value) * area.height;
            let x = area.right();
            canvas.line((x, y), (x + 4.0, y), Paint::stroke(ink, 0.8));
            canvas.text((x + 6.5, y + 0.36 * SMALL), &text, style);
            widest = widest.max(text_width(&text, SMALL));
        }
        let position = (
            area.right() + 6.5 + widest + 5.0 + SMALL,
            area.top + 0.5 * area.height,
        );
        canvas.text(position, title, style.anchor(Anchor::Middle).upwards());
    }

    /// How far from the panel the title of the left axis stands at least, so that it keeps clear of the ticks' numbers.
    pub fn y_title_distance(y: &Axis) -> f64 {
        let widths = y
            .ticks()
            .into_iter()
            .map(|(_, text)| text_width(&text, SMALL));
        6.5 + widths.fold(0.0, f64::max) + 6.0
    }

    /// Title of the left axis, reading upwards, `distance` from the panel; smaller where it would be longer than the axis.
    pub fn y_title(&self, canvas: &mut Canvas, title: &str, distance: f64) {
        let length = text_width(title, SMALL).max(1.0);
        let style = TextStyle::new(SMALL * (self.area.height / length).min(1.0), TEXT);
        let position = (
            self.area.left - distance,
            self.area.top + 0.5 * self.area.height,
        );
        canvas.text(position, title, style.anchor(Anchor::Middle).upwards());
    }

    /// Title of the lower axis.
    pub fn x_title(&self, canvas: &mut Canvas, title: &str) {
        let position = (
            self.area.left + 0.5 * self.area.width,
            self.area.bottom() + 2.0 * SMALL + 11.0,
        );
        canvas.text(position, title, LABEL.anchor(Anchor::Middle));
    }
}
