//! A change of gait in the manner of the paper's Fig. 3.

use gaitshift_analysis::recording::{Recording, column};

use crate::canvas::{Canvas, Ink, Paint, Rect};
use crate::chart::{Axis, Panel};
use crate::legend::{Spacing, places};
use crate::motion::Motion;
use crate::raster::fitting;
use crate::style::{COMMAND, LABEL, MEDIUM, PUSH, QUIET, TEXT, TITLE};
use crate::support;
use crate::{Figure, FigureError};

const HATCH: Ink = TEXT.opacity(0.55);
/// Slopes of the command this near to each other, as a share of the steepest, are those of one line.
const STRAIGHT: f64 = 1e-6;
/// Least width of the mark of a push, in user units.
const NARROWEST: f64 = 1.5;
/// Its height, at the top of a panel.
const MARK: f64 = 7.0;

/// What a figure of a time range shows and how large it is.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureOptions {
    /// First time shown, in s; `None` for 2.5 s before the ramp.
    pub from_s: Option<f64>,
    /// Last time shown, in s; `None` for 2.5 s after the ramp.
    pub to_s: Option<f64>,
    /// Width of the SVG in user units, 300 to 4000; text keeps its size of 11 to 12 units.
    pub width: f64,
    /// A line over the figure.
    pub title: Option<String>,
}

impl Default for FigureOptions {
    /// The ramp with 2.5 s on both sides, 440 units wide: on a column of 85 mm text is 6 points.
    fn default() -> Self {
        Self {
            from_s: None,
            to_s: None,
            width: 440.0,
            title: None,
        }
    }
}

/// Kinetic, gravitational and elastic energy and the speed against time, in stacked panels.
///
/// The background tells the support phases apart, the hatching marks the `ramp` from its start to its
/// end in s, or each of several, but no command that changes along a curve, and the command `ω_v` is drawn over the speed with its
/// own axis. Pushes are marked while they last. Gravitational energy is counted from its lowest value in the picture.
///
/// # Errors
/// [`FigureError::Empty`] or [`FigureError::TimeRange`] if no row lies in the range,
/// [`FigureError::Option`] for a width out of range or a ramp that is not finite.
pub fn transition_figure(
    recording: &Recording,
    ramp: (f64, f64),
    options: &FigureOptions,
) -> Result<Figure, FigureError> {
    if !(300.0..=4000.0).contains(&options.width) {
        return Err(FigureError::Option {
            name: "width",
            value: options.width,
            allowed: "300 to 4000 units",
        });
    }
    for (name, value) in [("ramp start", ramp.0), ("ramp end", ramp.1)] {
        if !value.is_finite() {
            return Err(FigureError::Option {
                name,
                value,
                allowed: "a finite time in s",
            });
        }
    }
    let from_s = options.from_s.unwrap_or(ramp.0 - 2.5);
    let to_s = options.to_s.unwrap_or(ramp.1 + 2.5);
    let motion = Motion::between(recording, from_s, to_s)?;
    let support = support::find(recording);

    let left = 58.0;
    let right = 54.0;
    let title_height = if options.title.is_some() { 22.0 } else { 0.0 };
    let hatched = ramps(recording, ramp);
    let shown =
        |&(start_s, end_s): &(f64, f64)| end_s > motion.first_s() && start_s < motion.last_s();
    let pushes: Vec<_> = pushes(recording).into_iter().filter(shown).collect();
    let legend = Legend::new(
        options.width - 24.0,
        !hatched.is_empty(),
        !pushes.is_empty(),
    );
    let top = title_height + legend.height + 12.0;
    let (panel_height, gap) = (104.0, 8.0);
    let height = top + 4.0 * panel_height + 3.0 * gap + 46.0;
    let mut canvas = Canvas::new(options.width, height);
    if let Some(title) = &options.title {
        // Bold letters are wider by about a tenth.
        let title = fitting(title, MEDIUM, (options.width - 24.0) / 1.12);
        canvas.text((12.0, 17.0), &title, TITLE.bold());
    }
    legend.draw(&mut canvas, 12.0, title_height + 18.0);

    let lowest = motion
        .values(column::GRAVITATIONAL_ENERGY_J)
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min);
    let potential: Vec<f64> = motion
        .values(column::GRAVITATIONAL_ENERGY_J)
        .iter()
        .map(|e| e - lowest)
        .collect();
    let curves: [(&str, &[f64]); 4] = [
        ("kinetic (J)", motion.values(column::KINETIC_ENERGY_J)),
        ("potential (J)", &potential),
        ("elastic (J)", motion.values(column::ELASTIC_ENERGY_J)),
        ("speed (m/s)", motion.values(column::X_VELOCITY_M_PER_S)),
    ];
    let time = Axis::exact(motion.first_s(), motion.last_s(), 6);
    for (i, (name, values)) in curves.into_iter().enumerate() {
        let top = top + i as f64 * (panel_height + gap);
        let area = Rect::new(left, top, options.width - left - right, panel_height);
        let y = Axis::around(values.iter().copied(), 4);
        let panel = Panel {
            area,
            x: time.clone(),
            y,
        };
        support::shade_panel(&mut canvas, &panel, support.phases());
        for &ramp in &hatched {
            hatch_ramp(&mut canvas, &panel, ramp);
        }
        for &(start_s, end_s) in &pushes {
            let band = panel.band(start_s, end_s);
            let width = band.width.max(NARROWEST);
            let mark = Rect {
                left: band.left.min(area.right() - width),
                width,
                height: MARK,
                ..band
            };
            canvas.rect(mark, Paint::fill(PUSH));
        }
        let is_speed = i + 1 == curves.len();
        if is_speed {
            draw_command(&mut canvas, &panel, &motion);
        }
        panel.curve(
            &mut canvas,
            motion.times(),
            values,
            Paint::stroke(TEXT, 1.5),
        );
        panel.frame(&mut canvas, is_speed);
        panel.y_title(&mut canvas, name, 42.0);
        if is_speed {
            panel.x_title(&mut canvas, "time (s)");
        }
    }
    Ok(Figure {
        svg: canvas.finish(),
    })
}

/// From when to when each push of a recording lasts, in s.
fn pushes(recording: &Recording) -> Vec<(f64, f64)> {
    let disturbance = recording.metadata.disturbance.as_ref();
    let pushes = disturbance.and_then(|d| d.get("pushes")?.as_array());
    let interval = |push: &serde_json::Value| {
        let force = |name: &str| push.get(name).and_then(serde_json::Value::as_f64);
        let pushes = [force("forward_n"), force("up_n")].into_iter().flatten();
        if pushes.fold(0.0, |most, n| f64::max(most, n.abs())) == 0.0 {
            return None;
        }
        let start_s = push.get("start_s")?.as_f64()?;
        Some((start_s, start_s + push.get("duration_s")?.as_f64()?))
    };
    pushes.map_or_else(Vec::new, |pushes| {
        pushes.iter().filter_map(interval).collect()
    })
}

/// The straight ramps of the command, in s: `ramp` if it is the only change, otherwise what is recorded. A row holds the
/// command of the period that ends there.
fn ramps(recording: &Recording, ramp: (f64, f64)) -> Vec<(f64, f64)> {
    let commands = recording.column(column::OMEGA_V);
    let times = recording.column(column::TIME_S);
    // Rows whose command differs from that of the row before, in unbroken stretches.
    let mut stretches: Vec<(usize, usize)> = Vec::new();
    for row in 1..commands.len() {
        if commands[row] != commands[row - 1] {
            match stretches.last_mut() {
                Some((_, last)) if *last + 1 == row => *last = row,
                _ => stretches.push((row, row)),
            }
        }
    }
    let only = stretches.len() <= 1;
    let straight = |&(first, last): &(usize, usize)| {
        // At both ends a period may be a part of the ramp only.
        let slopes: Vec<f64> = (first + 1..last)
            .map(|row| (commands[row] - commands[row - 1]) / (times[row] - times[row - 1]))
            .collect();
        let greatest = slopes.iter().fold(0.0_f64, |most, s| most.max(s.abs()));
        let same = |pair: &[f64]| (pair[0] - pair[1]).abs() <= STRAIGHT * greatest;
        slopes.windows(2).all(same)
    };
    if stretches.is_empty() {
        return vec![ramp];
    }
    let ramps = stretches.iter().filter(|stretch| straight(stretch));
    let interval = |&(first, last): &(usize, usize)| {
        if only {
            ramp
        } else {
            (times[first.saturating_sub(2)], times[last - 1])
        }
    };
    ramps.map(interval).collect()
}

fn hatch_ramp(canvas: &mut Canvas, panel: &Panel, ramp: (f64, f64)) {
    let band = panel.band(ramp.0, ramp.1);
    if band.width > 0.0 {
        canvas.hatch(band, HATCH, 6.0);
        for x in [band.left, band.right()] {
            canvas.line((x, band.top), (x, band.bottom()), Paint::stroke(TEXT, 0.6));
        }
    }
}

fn draw_command(canvas: &mut Canvas, panel: &Panel, motion: &Motion) {
    let command = motion.values(column::OMEGA_V);
    let axis = Axis::around(command.iter().copied(), 4);
    let over = Panel {
        y: axis.clone(),
        ..panel.clone()
    };
    let paint = Paint::stroke(COMMAND, 1.3).dashed("5 3");
    over.curve(canvas, motion.times(), command, paint);
    panel.right_axis(canvas, &axis, "command ω\u{1d65} (s/m)", COMMAND);
}

/// Swatches of the support phases, of the ramp and of pushes, in as many rows as the width needs.
struct Legend {
    entries: Vec<(&'static str, Swatch)>,
    /// Position of each entry relative to the legend's first base line.
    places: Vec<(f64, f64)>,
    height: f64,
}

#[derive(Clone, Copy)]
enum Swatch {
    Fill(Ink),
    Hatch,
}

impl Legend {
    const SPACING: Spacing = Spacing {
        name: 18.0,
        gap: 11.0,
        row: 17.0,
    };

    fn new(width: f64, ramp: bool, push: bool) -> Self {
        let phases = support::PHASES.into_iter();
        let mut entries: Vec<_> = phases
            .map(|phase| (support::name(phase), Swatch::Fill(support::shade(phase))))
            .collect();
        entries.extend(ramp.then_some(("ramp", Swatch::Hatch)));
        entries.extend(push.then_some(("push", Swatch::Fill(PUSH))));
        let names = entries.iter().map(|(name, _)| *name);
        let (places, height) = places(names, Self::SPACING, width);
        Self {
            entries,
            places,
            height,
        }
    }

    fn draw(&self, canvas: &mut Canvas, left: f64, base: f64) {
        for (&(name, swatch), (x, y)) in self.entries.iter().zip(&self.places) {
            let (x, y) = (left + x, base + y);
            let place = Rect::new(x, y - 9.5, 14.0, 11.0);
            match swatch {
                Swatch::Fill(ink) => canvas.rect(place, Paint::fill(ink)),
                Swatch::Hatch => canvas.hatch(place, HATCH, 5.0),
            }
            canvas.rect(place, Paint::stroke(QUIET, 0.6));
            canvas.text((x + Self::SPACING.name, y), name, LABEL);
        }
    }
}
