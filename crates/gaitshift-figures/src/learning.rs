//! How a training run went: the return of every episode against the steps taken.

use std::collections::BTreeMap;

use crate::canvas::{Canvas, Ink, Paint, Rect};
use crate::chart::{Axis, Panel};
use crate::charts::COLUMN_WIDTH;
use crate::raster::fitting;
use crate::style::{LABEL, SERIES, SMALL, TEXT};
use crate::{Figure, FigureError};

/// Colours of the command from low to high: dark blue over green to yellow, in rising lightness, after
/// the map viridis of S. van der Walt and N. Smith, which any colour vision and grey print can read.
const MAP: [u32; 6] = [0x440154, 0x414487, 0x2a788e, 0x22a884, 0x7ad151, 0xe3d51c];
/// Shades told apart; more could not be seen.
const SHADES: usize = 32;

/// The return of each episode against the steps at its end, coloured by the command `ω_v` it was given,
/// in the manner of the paper's Fig. 4, as wide as a journal's column.
///
/// The three slices are parallel, in the order of time; where episodes cover each other the later is on
/// top.
///
/// # Errors
/// [`FigureError::Empty`] without episodes, [`FigureError::Length`] if the slices differ in length,
/// [`FigureError::NotFinite`] for a value that cannot be drawn.
pub fn episode_returns_figure(
    steps: &[f64],
    returns: &[f64],
    omega_v: &[f64],
) -> Result<Figure, FigureError> {
    if steps.is_empty() {
        return Err(FigureError::Empty {
            what: "the training log",
            needed: "one whole episode",
        });
    }
    for (name, values) in [("steps", steps), ("returns", returns), ("omega_v", omega_v)] {
        if values.len() != steps.len() {
            let (found, expected) = (values.len(), steps.len());
            return Err(FigureError::Length {
                name,
                found,
                expected,
            });
        }
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            let value = values[index];
            return Err(FigureError::NotFinite {
                name: name.to_owned(),
                index,
                value,
            });
        }
    }

    let millions: Vec<f64> = steps.iter().map(|step| step * 1e-6).collect();
    let last = millions.iter().copied().fold(0.0, f64::max);
    let panel = Panel {
        area: Rect::new(58.0, 10.0, COLUMN_WIDTH - 58.0 - 70.0, 170.0),
        x: Axis::exact(0.0, 1.02 * last, 6),
        y: Axis::around(returns.iter().copied().chain([0.0]), 6),
    };
    let low = omega_v.iter().copied().fold(f64::INFINITY, f64::min);
    let high = omega_v.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let command = Axis::exact(low, high, 5);
    let mut canvas = Canvas::new(COLUMN_WIDTH, 228.0);
    panel.grid(&mut canvas);
    draw_episodes(&mut canvas, &panel, &command, &millions, returns, omega_v);
    panel.frame(&mut canvas, true);
    panel.x_title(&mut canvas, "steps (millions)");
    let distance = Panel::y_title_distance(&panel.y).min(45.0);
    panel.y_title(&mut canvas, "return of the episode", distance);
    draw_colour_bar(&mut canvas, &panel, &command);
    Ok(Figure {
        svg: canvas.finish(),
    })
}

/// A dot for each episode, but only one, the latest, on each spot: a long run has so many that a
/// picture of all would be as large as its log.
fn draw_episodes(
    canvas: &mut Canvas,
    panel: &Panel,
    command: &Axis,
    millions: &[f64],
    returns: &[f64],
    omega_v: &[f64],
) {
    let mut spots: BTreeMap<(i64, i64), usize> = BTreeMap::new();
    for i in 0..millions.len() {
        let (x, y) = panel.place(millions[i], returns[i]);
        spots.insert(((x * 1.25) as i64, (y * 1.25) as i64), i);
    }
    let mut latest: Vec<usize> = spots.into_values().collect();
    latest.sort_unstable();
    for i in latest {
        let shade = (command.share(omega_v[i]) * (SHADES - 1) as f64).round();
        let ink = colour(shade / (SHADES - 1) as f64).opacity(0.8);
        canvas.circle(panel.place(millions[i], returns[i]), 1.3, Paint::fill(ink));
    }
}

fn draw_colour_bar(canvas: &mut Canvas, panel: &Panel, command: &Axis) {
    let area = Rect::new(
        panel.area.right() + 10.0,
        panel.area.top,
        12.0,
        panel.area.height,
    );
    let height = area.height / SHADES as f64;
    for i in 0..SHADES {
        let top = area.bottom() - (i + 1) as f64 * height;
        // A little taller than its place, or the sheet would shine through the seams.
        let shade = Rect::new(
            area.left,
            top,
            area.width,
            height + if i > 0 { 0.5 } else { 0.0 },
        );
        canvas.rect(shade, Paint::fill(colour(i as f64 / (SHADES - 1) as f64)));
    }
    let bar = Panel {
        area,
        x: Axis::exact(0.0, 1.0, 1),
        y: command.clone(),
    };
    canvas.rect(area, Paint::stroke(TEXT, 0.8));
    bar.right_axis(canvas, command, "command ω\u{1d65} (s/m)", TEXT);
}

fn colour(share: f64) -> Ink {
    let place = share.clamp(0.0, 1.0) * (MAP.len() - 1) as f64;
    let lower = (place as usize).min(MAP.len() - 2);
    Ink::hex(MAP[lower]).mix(Ink::hex(MAP[lower + 1]), place - lower as f64)
}

/// The courses of runs that differ by their seed only.
#[derive(Clone, Debug, PartialEq)]
pub struct LearningCurves {
    /// Name in the legend.
    pub label: String,
    /// Of each run points (environment step, value), steps rising.
    pub runs: Vec<Vec<(f64, f64)>>,
}

/// A quantity over the course of training, for one or more groups of runs: every run as a thin line, of several runs their
/// mean as a thick one and the band from the least to the greatest. Between its points a run is a straight line; where one
/// has ended, the others go on without it.
///
/// # Errors
/// [`FigureError::Empty`] without any point, [`FigureError::NotFinite`] for a value that cannot be drawn.
pub fn learning_curves_figure(
    curves: &[LearningCurves],
    quantity: &str,
) -> Result<Figure, FigureError> {
    let points = || curves.iter().flat_map(|c| &c.runs).flatten();
    if points().next().is_none() {
        return Err(FigureError::Empty {
            what: "the course of training",
            needed: "one evaluation",
        });
    }
    for (index, &(step, value)) in points().enumerate() {
        if let Some(value) = [step, value].into_iter().find(|v| !v.is_finite()) {
            return Err(FigureError::NotFinite {
                name: quantity.to_owned(),
                index,
                value,
            });
        }
    }
    let last = points().fold(0.0_f64, |last, point| last.max(point.0));
    // Where all is 0 the axis leads up from there: what is counted is never negative.
    let high = if points().all(|point| point.1 == 0.0) {
        1.0
    } else {
        0.0
    };
    let top = 20.0 + 17.0 * curves.len() as f64;
    let panel = Panel {
        area: Rect::new(58.0, top, 420.0, 230.0),
        x: Axis::exact(0.0, 1.02e-6 * last.max(1.0), 6),
        y: Axis::around(points().map(|point| point.1).chain([0.0, high]), 6),
    };
    let mut canvas = Canvas::new(500.0, top + 282.0);
    panel.grid(&mut canvas);
    for (k, (group, ink)) in curves.iter().zip(SERIES.into_iter().cycle()).enumerate() {
        draw_group(&mut canvas, &panel, group, ink);
        let base = 19.0 + 17.0 * k as f64;
        canvas.line(
            (58.0, base - 4.0),
            (76.0, base - 4.0),
            Paint::stroke(ink, 2.2),
        );
        let runs = match group.runs.len() {
            1 => group.label.clone(),
            several => format!("{}, mean and range of {several} runs", group.label),
        };
        canvas.text((82.0, base), &fitting(&runs, SMALL, 412.0), LABEL);
    }
    panel.frame(&mut canvas, true);
    panel.x_title(&mut canvas, "steps (millions)");
    panel.y_title(&mut canvas, quantity, 42.0);
    Ok(Figure {
        svg: canvas.finish(),
    })
}

fn draw_group(canvas: &mut Canvas, panel: &Panel, group: &LearningCurves, ink: Ink) {
    let mut steps: Vec<f64> = group.runs.iter().flatten().map(|point| point.0).collect();
    steps.sort_by(f64::total_cmp);
    steps.dedup();
    let several = group.runs.len() > 1;
    // At each step that all runs reach: a mean of fewer would jump where one ends.
    let values: Vec<(f64, Vec<f64>)> = steps
        .iter()
        .map(|&step| {
            let reached = group.runs.iter().filter_map(|run| value_at(run, step));
            (step * 1e-6, reached.collect::<Vec<f64>>())
        })
        .filter(|(_, values)| values.len() == group.runs.len())
        .collect();
    let millions: Vec<f64> = values.iter().map(|(step, _)| *step).collect();
    let of =
        |fold: fn(&[f64]) -> f64| -> Vec<f64> { values.iter().map(|(_, v)| fold(v)).collect() };
    let mean = of(|v| v.iter().sum::<f64>() / v.len() as f64);
    if several {
        let least = of(|v| v.iter().copied().fold(f64::INFINITY, f64::min));
        let greatest = of(|v| v.iter().copied().fold(f64::NEG_INFINITY, f64::max));
        let upper = millions.iter().zip(&greatest);
        let lower = millions.iter().zip(&least).rev();
        let band = upper.chain(lower).map(|(&x, &y)| panel.place(x, y));
        canvas.polygon(band, Paint::fill(ink.opacity(0.18)));
        for run in &group.runs {
            let (xs, ys): (Vec<f64>, Vec<f64>) = run.iter().map(|p| (p.0 * 1e-6, p.1)).unzip();
            panel.curve(canvas, &xs, &ys, Paint::stroke(ink.opacity(0.45), 0.7));
        }
    }
    if let ([x], [y]) = (&millions[..], &mean[..]) {
        canvas.circle(panel.place(*x, *y), 3.0, Paint::fill(ink));
    }
    panel.curve(canvas, &millions, &mean, Paint::stroke(ink, 2.2));
}

/// Value of a run at a step, by a straight line between its points; nothing before the first and after the last.
fn value_at(run: &[(f64, f64)], step: f64) -> Option<f64> {
    let after = run.partition_point(|point| point.0 < step);
    let next = run.get(after)?;
    if next.0 == step {
        return Some(next.1);
    }
    let before = run.get(after.checked_sub(1)?)?;
    let share = (step - before.0) / (next.0 - before.0);
    Some(before.1 + share * (next.1 - before.1))
}
