//! What stands around the body in moving pictures: ground, forces, the knob. The same in films and single frames.

use gaitshift_analysis::recording::Side;
use gaitshift_body::BodyParameters;

use crate::biped::{self, View};
use crate::canvas::{Anchor, Canvas, Ink, Paint, Rect, TextStyle};
use crate::chart::Axis;
use crate::ground::Ground;
use crate::motion::Pose;
use crate::style::{COMMAND, QUIET, WHITE, side_ink};

/// Width of the sheet and where ground and hip are on it, in user units.
pub(crate) const WIDTH: f64 = 640.0;
pub(crate) const GROUND: f64 = 302.0;
pub(crate) const HIP: f64 = 300.0;
/// Depth of the ground shown, in user units.
const SOIL: f64 = 22.0;

/// The view of a body, its hip at `x_m` at the hip's place on the sheet.
pub(crate) fn view_of(body: &BodyParameters, x_m: f64) -> View {
    // Pelvis, raised by a jump, stays under the writing for a leg of any length.
    View {
        x_m,
        z_m: 0.0,
        left: HIP,
        ground: GROUND,
        scale: 182.0 / body.leg_length_m,
    }
}

/// The ground with a post every metre, so that motion over it is seen.
pub(crate) fn draw_ground(canvas: &mut Canvas, view: &View, ground: &Ground<'_>) {
    let soil = Ink::hex(0xece7df);
    let surface = Paint::stroke(Ink::hex(0x7d7468), 1.6);
    if ground.is_flat() {
        canvas.rect(Rect::new(0.0, GROUND, WIDTH, SOIL), Paint::fill(soil));
        canvas.line((0.0, GROUND), (WIDTH, GROUND), surface);
    } else {
        let edge = |x: f64| view.x_m + (x - HIP) / view.scale;
        let profile: Vec<_> = ground
            .between(edge(0.0), edge(WIDTH))
            .into_iter()
            .map(|point| view.place(point))
            .collect();
        canvas.open_clip(Rect::new(0.0, 84.0, WIDTH, GROUND + SOIL - 84.0));
        let below = [(WIDTH, GROUND + SOIL), (0.0, GROUND + SOIL)];
        let area = profile.iter().copied().chain(below);
        canvas.polygon(area, Paint::fill(soil));
        canvas.polyline(profile, surface);
        canvas.close_clip();
    }
    // Marks every quarter metre; positions beyond any track are not marked.
    let first = ((view.x_m - HIP / view.scale) * 4.0)
        .floor()
        .clamp(-4e6, 4e6) as i64
        - 2;
    let count = (4.0 * WIDTH / view.scale).ceil().min(1000.0) as i64 + 4;
    let ink = Ink::hex(0xa39a8c);
    for quarter in first..=first + count {
        let x_m = quarter as f64 / 4.0;
        let (x, y) = view.place((x_m, ground.height(x_m)));
        if y > GROUND + SOIL {
            continue;
        }
        if quarter % 4 == 0 {
            canvas.line(
                (x, 84.0),
                (x, y - 0.8),
                Paint::stroke(Ink::hex(0xf0f0f0), 1.5),
            );
            canvas.line((x, y), (x, y + 8.0), Paint::stroke(ink, 1.6));
            let style = TextStyle::new(9.5, QUIET).anchor(Anchor::Middle);
            canvas.text((x, y + 18.5), &format!("{} m", quarter / 4), style);
        } else {
            canvas.line((x, y), (x, y + 4.5), Paint::stroke(ink, 1.0));
        }
    }
}

/// Ground reaction forces, body weight a third of the leg long.
pub(crate) fn draw_forces(
    canvas: &mut Canvas,
    view: &View,
    body: &BodyParameters,
    pose: &Pose,
    weight_n: f64,
    ground: &Ground<'_>,
) {
    let weight_n = weight_n.max(1e-9);
    let units_per_newton = body.leg_length_m * view.scale / 3.0 / weight_n;
    for side in [Side::Left, Side::Right] {
        let leg = &pose.legs[side.index()];
        let (forward, up) = leg.force_n;
        if up < 0.05 * weight_n {
            continue;
        }
        let (x, _) = biped::lowest_point(body, pose, leg);
        // Two weights at most, or a hard landing would leave the picture.
        let scale = units_per_newton * (4.0 * weight_n / up.hypot(forward)).min(1.0);
        let by = (forward * scale, -up * scale);
        let foot = view.place((x, ground.height(x)));
        biped::arrow(canvas, foot, by, Ink::hex(0x111111), 2.6);
        canvas.circle(foot, 3.2, Paint::fill(side_ink(side)).outlined(WHITE, 0.8));
    }
}

/// The range of the knob for these commands: at least 0 to 3.
pub(crate) fn knob(commands: &[f64]) -> Axis {
    Axis::exact(
        commands.iter().copied().fold(0.0, f64::min).floor(),
        commands.iter().copied().fold(3.0, f64::max).ceil(),
        5,
    )
}

/// The command, as a slider.
pub(crate) fn draw_knob(canvas: &mut Canvas, knob: &Axis, value: f64) {
    let (left, right, y) = (58.0, 258.0, 40.0);
    let place = |value: f64| left + knob.share(value) * (right - left);
    canvas.text(
        (18.0, y + 6.0),
        "ω\u{1d65}",
        TextStyle::new(20.0, COMMAND).bold(),
    );
    let groove = Rect::new(left, y - 3.0, right - left, 6.0);
    canvas.rounded_rect(groove, 3.0, Paint::fill(Ink::hex(0xdcdcdc)));
    let zero = place(0.0_f64.clamp(knob.from, knob.to));
    let thumb = place(value);
    let filled = Rect::new(zero.min(thumb), y - 3.0, (thumb - zero).abs(), 6.0);
    canvas.rounded_rect(filled, 3.0, Paint::fill(COMMAND));
    for (tick, label) in knob.ticks() {
        let x = place(tick);
        canvas.line((x, y + 8.0), (x, y + 12.0), Paint::stroke(QUIET, 1.0));
        let style = TextStyle::new(10.0, QUIET).anchor(Anchor::Middle);
        canvas.text((x, y + 23.0), &label, style);
    }
    canvas.circle((thumb, y), 9.5, Paint::fill(WHITE).outlined(COMMAND, 3.0));
    let style = TextStyle::new(14.0, COMMAND).bold().anchor(Anchor::Middle);
    canvas.text((thumb, y - 15.0), &format!("{value:.1}"), style);
}
