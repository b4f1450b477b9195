//! What several settings of an experiment reached, seed by seed.

use crate::canvas::{Anchor, Canvas, Paint, Rect};
use crate::chart::{Axis, Panel};
use crate::raster::{fitting, text_width};
use crate::style::{FAINT, LABEL, LEFT, RIGHT, SMALL, TEXT};
use crate::{Figure, FigureError};

/// One setting and what its runs reached.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Its name.
    pub label: String,
    /// A value for each seed.
    pub values: Vec<f64>,
    /// The values together, with the interval's ends: (low, value, high).
    pub estimate: Option<(f64, f64, f64)>,
}

const ROW: f64 = 24.0;
/// Names take at most this width; longer ones are cut.
const WIDEST_LABEL: f64 = 330.0;
const PLOT_WIDTH: f64 = 380.0;

/// One row for each setting, from above: a dot for each seed, a bar from one end of the interval to the other, and a stroke
/// at the value of all seeds together. The axis goes from 0 to `greatest`, or further where a value lies further.
///
/// # Errors
/// [`FigureError::Empty`] without any value, [`FigureError::NotFinite`] for one that cannot be drawn.
pub fn settings_figure(
    settings: &[Setting],
    quantity: &str,
    greatest: f64,
) -> Result<Figure, FigureError> {
    let drawn = || {
        settings.iter().flat_map(|s| {
            let ends = s.estimate.map(|(low, value, high)| [low, value, high]);
            s.values.iter().copied().chain(ends.into_iter().flatten())
        })
    };
    if drawn().next().is_none() {
        return Err(FigureError::Empty {
            what: "the table of settings",
            needed: "one run",
        });
    }
    if let Some((index, value)) = drawn().enumerate().find(|(_, v)| !v.is_finite()) {
        return Err(FigureError::NotFinite {
            name: quantity.to_owned(),
            index,
            value,
        });
    }
    let labels: Vec<String> = settings
        .iter()
        .map(|s| fitting(&s.label, SMALL, WIDEST_LABEL))
        .collect();
    let widest = labels.iter().map(|label| text_width(label, SMALL));
    let left = 24.0 + widest.fold(0.0, f64::max);
    let area = Rect::new(left, 14.0, PLOT_WIDTH, ROW * settings.len() as f64 + 8.0);
    let (least, most) = drawn().fold((0.0, greatest), |(least, most), value| {
        (f64::min(least, value), f64::max(most, value))
    });
    let room = 0.02 * (most - least);
    let panel = Panel {
        area,
        x: Axis::exact(least - room, most + room, 8),
        y: Axis::exact(0.0, 1.0, 1),
    };
    let mut canvas = Canvas::new(area.right() + 20.0, area.bottom() + 46.0);
    for (value, _) in panel.x.ticks() {
        let x = panel.horizontal(value);
        canvas.line((x, area.top), (x, area.bottom()), Paint::stroke(FAINT, 0.7));
    }
    for (k, (setting, label)) in settings.iter().zip(&labels).enumerate() {
        let y = area.top + 4.0 + ROW * (k as f64 + 0.5);
        let name = (left - 10.0, y + 0.36 * SMALL);
        canvas.text(name, label, LABEL.anchor(Anchor::End));
        if let Some((low, value, high)) = setting.estimate {
            let (low, value, high) = (
                panel.horizontal(low),
                panel.horizontal(value),
                panel.horizontal(high),
            );
            let bar = Rect::new(low, y - 6.0, (high - low).max(1.0), 12.0);
            canvas.rect(bar, Paint::fill(LEFT.opacity(0.22)));
            canvas.line((value, y - 8.0), (value, y + 8.0), Paint::stroke(LEFT, 2.2));
        }
        // Spread over the row, or equal seeds would hide each other.
        let count = setting.values.len() as f64;
        for (seed, &value) in setting.values.iter().enumerate() {
            let offset = ((seed as f64 + 0.5) / count - 0.5) * 0.6 * ROW;
            let dot = (panel.horizontal(value), y + offset);
            canvas.circle(dot, 2.4, Paint::fill(RIGHT.opacity(0.85)));
        }
    }
    canvas.rect(area, Paint::stroke(TEXT, 0.8));
    panel.x_ticks(&mut canvas, true);
    panel.x_title(&mut canvas, quantity);
    Ok(Figure {
        svg: canvas.finish(),
    })
}
