//! The body in one pose, from its real geometry.
//!
//! Each leg shows, from the hip down: the actuator's sleeve, the thigh that slides in it by `h`, then
//! the wobbling mechanism with `k1` between thigh and foot on one side and the tibia between `k3` and
//! `k2` on the other, and the foot with the spheres of its sole. Widths across the leg, which the
//! model does not have, are free.

use gaitshift_analysis::recording::Side;
use gaitshift_body::{BodyParameters, sphere_center};

use crate::canvas::{Canvas, Ink, Paint, Point};
use crate::motion::{LegPose, Pose};
use crate::style::{TEXT, WHITE, side_fill, side_ink};

/// From metres in the world to user units on the sheet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    /// World position shown at `left`.
    pub x_m: f64,
    /// Sheet position of `x_m`.
    pub left: f64,
    /// World height shown at `ground`.
    pub z_m: f64,
    /// Sheet position of that height.
    pub ground: f64,
    /// User units for a metre.
    pub scale: f64,
}

impl View {
    pub fn place(&self, (x, z): (f64, f64)) -> Point {
        (
            self.left + (x - self.x_m) * self.scale,
            self.ground - (z - self.z_m) * self.scale,
        )
    }

    /// The same view with `x_m` and `z_m` of the world shown at `left` and at the ground's place.
    pub fn moved(self, (x_m, z_m): (f64, f64), left: f64) -> Self {
        Self {
            x_m,
            z_m,
            left,
            ..self
        }
    }
}

/// A leg's own frame: distances down the leg from the hip axis and across it, both in m.
struct LegFrame {
    hip: (f64, f64),
    sin: f64,
    cos: f64,
    view: View,
}

impl LegFrame {
    fn place(&self, (down, across): (f64, f64)) -> Point {
        self.view.place((
            self.hip.0 + down * self.sin + across * self.cos,
            self.hip.1 - down * self.cos + across * self.sin,
        ))
    }

    fn block(&self, canvas: &mut Canvas, down: (f64, f64), across: (f64, f64), paint: Paint) {
        let corners = [
            (down.0, across.0),
            (down.0, across.1),
            (down.1, across.1),
            (down.1, across.0),
        ];
        canvas.polygon(corners.map(|corner| self.place(corner)), paint);
    }

    /// A zigzag between two distances down the leg, the straight ends a sixth each.
    fn spring(
        &self,
        canvas: &mut Canvas,
        down: (f64, f64),
        across: f64,
        half_width: f64,
        paint: Paint,
    ) {
        const TURNS: usize = 4;
        let at = |share: f64| down.0 + (down.1 - down.0) * share;
        let zigzag = (0..2 * TURNS).map(|i| {
            let share = (1.0 + 4.0 * (i as f64 + 0.5) / (2 * TURNS) as f64) / 6.0;
            let side = if i % 2 == 0 { half_width } else { -half_width };
            (at(share), across + side)
        });
        let ends = [(at(0.0), across), (at(1.0 / 6.0), across)];
        let other_ends = [(at(5.0 / 6.0), across), (at(1.0), across)];
        let points = ends.into_iter().chain(zigzag).chain(other_ends);
        canvas.polyline(points.map(|point| self.place(point)), paint);
    }
}

/// Half of the hip segment's diagonal, in leg lengths.
const HALF_TRUNK: f64 = 0.24;

/// Draws the whole body: the left leg behind, the hip segment, the right leg in front.
pub(crate) fn draw(canvas: &mut Canvas, view: &View, body: &BodyParameters, pose: &Pose) {
    let [right, left] = &pose.legs;
    draw_leg(canvas, view, body, pose, left, Side::Left);
    draw_hip(canvas, view, body, pose);
    draw_leg(canvas, view, body, pose, right, Side::Right);
    let line = (0.012 * body.leg_length_m * view.scale).max(0.5);
    let hip = view.place((pose.x, pose.z));
    let radius = 0.028 * body.leg_length_m * view.scale;
    canvas.circle(hip, radius, Paint::fill(WHITE).outlined(TEXT, line));
}

/// The hip segment with a nose forward and a stub upward, so that its pitch is seen.
fn draw_hip(canvas: &mut Canvas, view: &View, body: &BodyParameters, pose: &Pose) {
    // 0.3 m by 0.2 m at the default leg length: the box behind the default moment of inertia.
    let unit = body.leg_length_m / 0.8;
    let (sin, cos) = pose.theta.sin_cos();
    let place = |forward: f64, up: f64| {
        let (forward, up) = (forward * unit, up * unit + body.hip_com_height_m);
        view.place((
            pose.x + forward * cos - up * sin,
            pose.z + forward * sin + up * cos,
        ))
    };
    let outline = [
        (-0.15, -0.06),
        (-0.15, 0.06),
        (-0.11, 0.10),
        (0.09, 0.10),
        (0.15, 0.05),
        (0.15, -0.05),
        (0.09, -0.10),
        (-0.11, -0.10),
    ];
    let line = (0.02 * unit * view.scale).max(0.5);
    canvas.polygon(
        outline.map(|(forward, up)| place(forward, up)),
        Paint::fill(Ink::hex(0x8d8d8d)).outlined(Ink::hex(0x4a4a4a), line * 0.6),
    );
}

fn draw_leg(
    canvas: &mut Canvas,
    view: &View,
    body: &BodyParameters,
    pose: &Pose,
    leg: &LegPose,
    side: Side,
) {
    let (sin, cos) = leg.psi.sin_cos();
    let frame = LegFrame {
        hip: (pose.x, pose.z),
        sin,
        cos,
        view: *view,
    };
    // Sizes as shares of the leg, so that other bodies are drawn in proportion.
    let l = body.leg_length_m;
    let px = |metres: f64| (metres * view.scale).max(0.4);
    let (full, ink) = (side_ink(side), side_fill(side));
    let light = match side {
        Side::Right => full.mix(WHITE, 0.6),
        Side::Left => full.mix(WHITE, 0.85),
    };
    let dark = full.mix(Ink::hex(0), 0.45);
    let edge = px(0.008 * l);

    let thigh_top = 0.24 * l + leg.h;
    let thigh_bottom = 0.43 * l + leg.h;
    let foot_shift = leg.h - leg.d;
    let sphere = body.foot_sphere_radius_m;
    // The foot's upper plate lies a little over the highest sphere of its sole.
    let sole_height = body.foot_arc_radius_m * (1.0 - body.foot_arc_half_angle_rad.cos());
    let foot_plate = (l - (sole_height + 0.07 * l).min(0.35 * l)) + foot_shift;

    // Springs first, so that blocks cover their ends.
    let tibia = body.tibia_distance_m + leg.h - leg.w;
    let wire = Paint::stroke(dark, px(0.011 * l));
    frame.spring(
        canvas,
        (thigh_bottom, foot_plate),
        -0.045 * l,
        0.022 * l,
        wire,
    );
    frame.spring(canvas, (thigh_bottom, tibia), 0.045 * l, 0.017 * l, wire);
    frame.spring(canvas, (tibia, foot_plate), 0.045 * l, 0.017 * l, wire);

    // Sleeve of the actuator, rod, thigh.
    let steel = Ink::hex(0x5a5a5a);
    let rod = Paint::fill(Ink::hex(0xc4c4c4)).outlined(steel, edge);
    frame.block(canvas, (0.06 * l, thigh_top), (-0.016 * l, 0.016 * l), rod);
    let sleeve = Paint::fill(steel.mix(ink, 0.25)).outlined(Ink::hex(0x3a3a3a), edge);
    frame.block(canvas, (0.0, 0.15 * l), (-0.034 * l, 0.034 * l), sleeve);
    let solid = Paint::fill(ink).outlined(dark, edge);
    frame.block(
        canvas,
        (thigh_top, thigh_bottom),
        (-0.06 * l, 0.06 * l),
        solid,
    );

    // Wobbling tibia.
    let half = 0.04 * l;
    let mass = Paint::fill(light).outlined(dark, edge);
    frame.block(
        canvas,
        (tibia - half, tibia + half),
        (0.015 * l, 0.075 * l),
        mass,
    );

    // Foot: plate, neck, and the sole as the spheres' envelope.
    let spheres: Vec<Point> = (0..body.foot_sphere_count)
        .map(|i| {
            let (x, z) = sphere_center(body, leg.psi, foot_shift, i);
            view.place((pose.x + x, pose.z + z))
        })
        .collect();
    let plate = [(foot_plate, -0.075 * l), (foot_plate, 0.085 * l)].map(|p| frame.place(p));
    canvas.polygon(
        plate.iter().rev().copied().chain(spheres.iter().copied()),
        Paint::fill(ink).outlined(dark, edge),
    );
    canvas.polyline(plate, Paint::stroke(dark, px(0.02 * l)));
    canvas.polyline(spheres, Paint::stroke(dark, px(2.0 * sphere)));
}

/// How far the body reaches behind its hip axis and before it, in m; the first is negative.
pub(crate) fn reach(body: &BodyParameters, pose: &Pose) -> (f64, f64) {
    let trunk = HALF_TRUNK * body.leg_length_m;
    let spheres = pose.legs.iter().flat_map(|leg| {
        (0..body.foot_sphere_count).map(|i| sphere_center(body, leg.psi, leg.h - leg.d, i).0)
    });
    let radius = body.foot_sphere_radius_m;
    spheres.fold((-trunk, trunk), |(back, front), x| {
        (back.min(x - radius), front.max(x + radius))
    })
}

/// How far the trunk reaches above the hip axis at most, however it is pitched, in m.
pub(crate) fn above_hip(body: &BodyParameters) -> f64 {
    HALF_TRUNK * body.leg_length_m + body.hip_com_height_m.abs()
}

/// Where the ground pushes on a foot: the lowest point of its sole, in world coordinates.
pub(crate) fn lowest_point(body: &BodyParameters, pose: &Pose, leg: &LegPose) -> (f64, f64) {
    (0..body.foot_sphere_count)
        .map(|i| {
            let (x, z) = sphere_center(body, leg.psi, leg.h - leg.d, i);
            (pose.x + x, pose.z + z - body.foot_sphere_radius_m)
        })
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((pose.x, 0.0))
}

/// An arrow from `from` by `by`, in user units, with a filled head.
pub(crate) fn arrow(canvas: &mut Canvas, from: Point, by: Point, ink: Ink, width: f64) {
    let length = by.0.hypot(by.1);
    if length < 2.0 * width {
        return;
    }
    let (u, v) = (by.0 / length, by.1 / length);
    let head = (5.0 * width).min(0.6 * length);
    let tip = (from.0 + by.0, from.1 + by.1);
    let neck = (tip.0 - head * u, tip.1 - head * v);
    canvas.line(from, neck, Paint::stroke(ink, width));
    let wing = 0.45 * head;
    let barbs = [
        tip,
        (neck.0 - wing * v, neck.1 + wing * u),
        (neck.0 + wing * v, neck.1 - wing * u),
    ];
    canvas.polygon(barbs, Paint::fill(ink));
}
