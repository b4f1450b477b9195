//! A stride at a glance: poses at equal times side by side.

use gaitshift_analysis::recording::{Recording, Side, column};

use crate::biped::{self, View};
use crate::canvas::{Anchor, Canvas, Ink, Paint, Rect, TextStyle};
use crate::chart::{Axis, Panel};
use crate::ground::Ground;
use crate::motion::{Motion, Pose, body_of};
use crate::raster::text_width;
use crate::style::{LABEL, QUIET, SMALL, TEXT, WHITE, side_ink};
use crate::support;
use crate::{Figure, FigureError};

/// Least distance between neighbouring poses, in leg lengths: closer, they hide each other.
const LEAST_SPACING: f64 = 0.62;
/// User units for a leg length.
const LEG: f64 = 105.0;
/// Least distance of the first and the last hip from the picture's edge, in leg lengths, and of any part of a body, in user
/// units.
const LEAST_MARGIN: f64 = 0.75;
const EDGE: f64 = 6.0;
/// From one line of the note to the next, in user units.
const NOTE: f64 = 12.0;

/// A strobe picture of the time from `from_s` to `to_s`: `poses` (2 to 60) poses at equal times, the
/// path of the hip, and below when each foot was on the ground.
///
/// Bodies and heights are to scale. The horizontal axis is time: poses stand as far apart as the body
/// travels at its mean speed, or further where they would hide each other; the picture says by how much.
/// Where the ground is not flat each pose stands on the ground around it.
/// [`strobe_within`] keeps to a width.
///
/// # Errors
/// [`FigureError::Empty`] or [`FigureError::TimeRange`] if fewer than two rows lie in the range,
/// [`FigureError::Option`] for a number of poses out of range, [`FigureError::Body`] if the recording
/// does not say what the body looks like.
pub fn strobe(
    recording: &Recording,
    from_s: f64,
    to_s: f64,
    poses: usize,
) -> Result<Figure, FigureError> {
    strobe_within(recording, from_s, to_s, poses, f64::INFINITY)
}

/// [`strobe`] at most `width` user units wide: where it would be wider, the bodies are smaller.
///
/// # Errors
/// Those of [`strobe`], and [`FigureError::Option`] for a width of less than 100.
pub fn strobe_within(
    recording: &Recording,
    from_s: f64,
    to_s: f64,
    poses: usize,
    width: f64,
) -> Result<Figure, FigureError> {
    if width.is_nan() || width < 100.0 {
        return Err(FigureError::Option {
            name: "width",
            value: width,
            allowed: "100 or more",
        });
    }
    if !(2..=60).contains(&poses) {
        return Err(FigureError::Option {
            name: "poses",
            value: poses as f64,
            allowed: "2 to 60",
        });
    }
    let motion = Motion::between(recording, from_s, to_s)?;
    let body = body_of(recording)?;
    let (first_s, last_s) = (motion.first_s(), motion.last_s());
    let duration_s = motion.duration_s();
    if duration_s <= 0.0 {
        let whole = Motion::whole(recording)?;
        return Err(FigureError::TimeRange {
            from_s,
            to_s,
            first_s: whole.first_s(),
            last_s: whole.last_s(),
        });
    }

    let interval_s = duration_s / (poses - 1) as f64;
    let x = motion.values(column::X_M);
    let way = x[x.len() - 1] - x[0];
    let poses: Vec<(f64, Pose)> = (0..poses)
        .map(|i| {
            let time_s = first_s + i as f64 * interval_s;
            (time_s, motion.pose(time_s))
        })
        .collect();
    let between = (poses.len() - 1) as f64;
    let travelled_m = way / between;
    let spacing = |leg: f64| {
        let travelled = travelled_m * leg / body.leg_length_m;
        travelled.clamp(LEAST_SPACING * leg, 4.0 * leg)
    };
    // Whole bodies, however far their feet reach beyond the first and the last hip.
    let margins = |leg: f64| {
        let (mut left, mut right) = (LEAST_MARGIN * leg, LEAST_MARGIN * leg);
        for (i, (_, pose)) in poses.iter().enumerate() {
            let (back, front) = biped::reach(&body, pose);
            let scale = leg / body.leg_length_m;
            let from_first = spacing(leg) * i as f64;
            left = left.max(EDGE - back * scale - from_first);
            right = right.max(EDGE + front * scale - (spacing(leg) * between - from_first));
        }
        (left, right)
    };
    let full_width = |leg: f64| spacing(leg) * between + margins(leg).0 + margins(leg).1;
    // All of it but the edges grows with the leg.
    let shrunk = (width - 2.0 * EDGE) / (full_width(LEG) - 2.0 * EDGE).max(1.0);
    let leg = LEG * shrunk.min(1.0);
    let scale = leg / body.leg_length_m;
    let (spacing, (left_margin, right_margin)) = (spacing(leg), margins(leg));
    let travelled = travelled_m * scale;
    let width = spacing * between + left_margin + right_margin;
    let profile = Ground::of(recording);
    // Each pose on the ground around it, as far as the next pose's.
    let around = |pose: &Pose| {
        let half_m = 0.5 * spacing / scale;
        profile.between(pose.x - half_m, pose.x + half_m)
    };
    let heights = poses.iter().flat_map(|(_, pose)| around(pose));
    let (lowest_m, rise_m) = {
        let extent = |(low, high): (f64, f64), (_, z): (f64, f64)| (low.min(z), high.max(z));
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), extent);
        (low, high - low)
    };
    // A range that climbs by more would be all ground.
    let climbs = rise_m > body.leg_length_m;
    let base_m = |x: f64| if climbs { profile.height(x) } else { lowest_m };
    let rise = if climbs { 0.0 } else { rise_m * scale };
    let note = if travelled > 0.01 * leg {
        let stretch = spacing / travelled;
        if (stretch - 1.0).abs() < 0.005 {
            "distances to scale".to_owned()
        } else {
            format!("poses {stretch:.1} times as far apart as travelled")
        }
    } else {
        "poses drawn side by side".to_owned()
    };
    let heights: &[&str] = match (profile.is_flat(), climbs) {
        (true, _) => &[],
        (false, false) => &["each on the ground around it"],
        (false, true) => &[
            "each on the ground around it",
            "heights over the ground below the hip",
        ],
    };
    let decimals = if interval_s < 0.02 { 4 } else { 2 };
    let every = format!("a pose every {interval_s:.decimals$} s");
    let parts = [every, note]
        .into_iter()
        .chain(heights.iter().map(|&part| part.to_owned()));
    let note = lines(parts, width - 16.0);
    // Under the note there is room for the highest trunk.
    let highest_m = poses
        .iter()
        .map(|(_, pose)| pose.z - base_m(pose.x) + biped::above_hip(&body));
    let highest = highest_m.fold(0.0, f64::max) * scale;
    let ground = 24.0 + NOTE * (note.len() - 1) as f64 + highest.clamp(leg, 1.6 * leg + rise);
    let bars = Rect::new(left_margin, ground + 18.0, spacing * between, 22.0);
    let mut canvas = Canvas::new(width, bars.bottom() + 42.0);

    let soil = Paint::fill(Ink::hex(0xece7df));
    let surface = Paint::stroke(Ink::hex(0x7d7468), 1.2);
    let floor = Rect::new(0.0, ground, width, 7.0);
    canvas.rect(floor, soil);
    if profile.is_flat() {
        canvas.line((0.0, ground), (width, ground), surface);
    }

    let left_of = |time_s: f64| left_margin + (time_s - first_s) / duration_s * bars.width;
    let view = View {
        x_m: 0.0,
        z_m: 0.0,
        left: 0.0,
        ground,
        scale,
    };
    let view_of =
        |(time_s, pose): &(f64, Pose)| view.moved((pose.x, base_m(pose.x)), left_of(*time_s));
    if !profile.is_flat() {
        canvas.open_clip(Rect::new(0.0, 18.0, width, floor.bottom() - 18.0));
        for shown in &poses {
            let view = view_of(shown);
            let around: Vec<_> = around(&shown.1)
                .into_iter()
                .map(|point| view.place(point))
                .collect();
            let ends = [around[around.len() - 1].0, around[0].0].map(|x| (x, floor.bottom()));
            canvas.polygon(around.iter().copied().chain(ends), soil);
            canvas.polyline(around, surface);
        }
        canvas.close_clip();
    }
    for shown in &poses {
        biped::draw(&mut canvas, &view_of(shown), &body, &shown.1);
    }
    let times = motion.times();
    let hips: Vec<_> = times
        .iter()
        .zip(
            motion
                .values(column::X_M)
                .iter()
                .zip(motion.values(column::Z_M)),
        )
        .map(|(&time, (&x, &z))| (left_of(time), ground - (z - base_m(x)) * scale))
        .collect();
    canvas.polyline(hips.iter().copied(), Paint::stroke(WHITE.opacity(0.8), 3.4));
    canvas.polyline(hips, Paint::stroke(TEXT, 1.4));

    let support = support::find(recording);
    let all_times = recording.column(column::TIME_S);
    support::contact_bars(&mut canvas, bars, (first_s, last_s), &support, all_times);
    for (side, name, y) in [(Side::Right, "right", 8.5), (Side::Left, "left", 21.5)] {
        let style = TextStyle::new(SMALL, side_ink(side)).anchor(Anchor::End);
        canvas.text((bars.left - 6.0, bars.top + y), name, style);
    }
    let axis = Panel {
        area: bars,
        x: Axis::exact(first_s, last_s, 8),
        y: Axis::exact(0.0, 1.0, 1),
    };
    for (time_s, label) in axis.x.ticks() {
        let x = axis.horizontal(time_s);
        canvas.line(
            (x, bars.bottom() + 2.0),
            (x, bars.bottom() + 6.0),
            Paint::stroke(TEXT, 0.8),
        );
        canvas.text(
            (x, bars.bottom() + 17.0),
            &label,
            LABEL.anchor(Anchor::Middle),
        );
    }
    axis.x_title(&mut canvas, "time (s)");
    for (k, line) in note.iter().enumerate() {
        canvas.text(
            (8.0, 15.0 + NOTE * k as f64),
            line,
            TextStyle::new(10.0, QUIET),
        );
    }
    Ok(Figure {
        svg: canvas.finish(),
    })
}

/// The parts of a note in lines of at most `width` user units, broken between parts.
fn lines(parts: impl Iterator<Item = String>, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for part in parts {
        match lines.last_mut() {
            Some(line) if text_width(&format!("{line}, {part}"), 10.0) <= width => {
                line.push_str(", ");
                line.push_str(&part);
            }
            Some(line) => {
                line.push(',');
                lines.push(part);
            }
            None => lines.push(part),
        }
    }
    lines
}

/// The stride around `time_s`: from a touchdown of the right foot to its next one, in s. `None` if no
/// whole stride is recorded there.
pub fn stride_at(recording: &Recording, time_s: f64) -> Option<(f64, f64)> {
    let support = support::find(recording);
    let touchdowns: Vec<f64> = support
        .touchdowns(recording.whole()?)
        .filter(|touchdown| touchdown.side == Side::Right)
        .map(|touchdown| touchdown.time_s)
        .collect();
    let next = touchdowns.partition_point(|&touchdown| touchdown <= time_s);
    Some((
        *touchdowns.get(next.checked_sub(1)?)?,
        *touchdowns.get(next)?,
    ))
}
