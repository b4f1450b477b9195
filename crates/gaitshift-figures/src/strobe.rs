//! A stride at a glance: poses at equal times side by side.

use gaitshift_analysis::recording::{Recording, Side, column};

use crate::biped::{self, View};
use crate::canvas::{Anchor, Canvas, Ink, Paint, Rect, TextStyle};
use crate::chart::{Axis, Panel};
use crate::ground::Ground;
use crate::motion::{Motion, Pose, body_of};
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

/// A strobe picture of the time from `from_s` to `to_s`: `poses` (2 to 60) poses at equal times, the
/// path of the hip, and below when each foot was on the ground.
///
/// Bodies and heights are to scale. The horizontal axis is time: poses stand as far apart as the body
/// travels at its mean speed, or further where they would hide each other; the picture says by how much.
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
        return Err(FigureError::TimeRange {
            from_s,
            to_s,
            first_s,
            last_s,
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
    // Under the note there is room for the highest trunk.
    let highest_m = poses
        .iter()
        .map(|(_, pose)| pose.z - profile.height(pose.x) + biped::above_hip(&body));
    let highest = highest_m.fold(0.0, f64::max) * scale;
    let ground = 24.0 + highest.clamp(leg, 1.6 * leg);
    let bars = Rect::new(left_margin, ground + 18.0, spacing * between, 22.0);
    let mut canvas = Canvas::new(width, bars.bottom() + 42.0);

    let floor = Rect::new(0.0, ground, width, 7.0);
    canvas.rect(floor, Paint::fill(Ink::hex(0xece7df)));
    canvas.line(
        (0.0, ground),
        (width, ground),
        Paint::stroke(Ink::hex(0x7d7468), 1.2),
    );

    let left_of = |time_s: f64| left_margin + (time_s - first_s) / duration_s * bars.width;
    let view = View {
        x_m: 0.0,
        z_m: 0.0,
        left: 0.0,
        ground,
        scale,
    };
    for (time_s, pose) in &poses {
        let view = view.moved((pose.x, profile.height(pose.x)), left_of(*time_s));
        biped::draw(&mut canvas, &view, &body, pose);
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
        .map(|(&time, (&x, &z))| (left_of(time), ground - (z - profile.height(x)) * scale))
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
    let heights = match profile.corners() {
        Some(_) => ", heights over the ground below the hip",
        None => "",
    };
    let note = format!("a pose every {interval_s:.2} s, {note}{heights}");
    canvas.text((8.0, 15.0), &note, TextStyle::new(10.0, QUIET));
    Ok(Figure {
        svg: canvas.finish(),
    })
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
