//! The strobe picture shows the asked number of poses with the body's true geometry: soles that carry
//! touch the drawn ground, springs and thighs move by `h`, `d` and `w` as the model says.

use crate::common;
use crate::common::{count, drawn_size, keep, metadata};
use gaitshift_analysis::recording::{COLUMNS, Column, Recording, RecordingMetadata, column};
use gaitshift_body::{Body, BodyParameters, BodyState};
use gaitshift_figures::{Figure, FigureError, stride_at, strobe, strobe_within};

/// User units for a metre at the default leg length of 0.8 m.
const SCALE: f64 = 105.0 / 0.8;
/// Width of the line that draws a sole: the diameter of its spheres.
const SOLE: f64 = 2.0 * 0.012 * SCALE;

/// Points of all polylines of that stroke width.
fn polylines(figure: &Figure, stroke: f64) -> Vec<Vec<(f64, f64)>> {
    let stroke = format!("stroke-width=\"{}\"", (stroke * 100.0).round() / 100.0);
    let lines = figure
        .svg
        .lines()
        .filter(|line| line.starts_with("<polyline"));
    lines
        .filter(|line| line.contains(&stroke))
        .map(|line| {
            let points = line.split('"').nth(1).unwrap().split(' ');
            let pair = |point: &str| {
                let (x, y) = point.split_once(',').unwrap();
                (x.parse().unwrap(), y.parse().unwrap())
            };
            points.map(pair).collect()
        })
        .collect()
}

// The first poses of a run were cut off at the picture's left edge: its feet swing further behind the hip than the margin.
#[test]
fn no_foot_is_cut_off() {
    for (back, front) in [(-1.2, 0.4), (-0.3, 1.3), (-1.4, -1.2)] {
        let state = BodyState::from_coordinates(
            &{
                let mut positions = [0.0; 11];
                positions[1] = 0.7;
                positions[3] = back;
                positions[7] = front;
                positions
            },
            &[0.0; 11],
        );
        let figure = strobe(&hold(&state), 0.0, 1.0, 2).unwrap();
        let (width, _) = common::drawn_size(&figure);
        let soles = polylines(&figure, SOLE);
        assert_eq!(soles.len(), 4);
        for (x, _) in soles.iter().flatten() {
            let half = 0.5 * SOLE;
            assert!((half..=width - half).contains(x), "{x} of {width}");
        }
    }
}

/// Where the line of the ground lies.
fn ground(figure: &Figure) -> f64 {
    let line = figure.svg.lines().find(|line| line.contains("#7d7468"));
    let y = line.and_then(|line| line.split("y1=\"").nth(1)).unwrap();
    y.split('"').next().unwrap().parse().unwrap()
}

/// Height of the lowest point of each sole over the ground in m; left and right leg of each pose.
fn clearances(figure: &Figure) -> Vec<f64> {
    let lowest = |sole: &Vec<(f64, f64)>| {
        let deepest = sole
            .iter()
            .map(|point| point.1)
            .fold(f64::NEG_INFINITY, f64::max);
        (ground(figure) - deepest) / SCALE - 0.012
    };
    polylines(figure, SOLE).iter().map(lowest).collect()
}

// Strobe pictures of a report were 204 and 197 mm wide, more than both columns of a journal, under a strip of nothing.
#[test]
fn a_picture_keeps_to_its_width_and_to_the_height_of_its_bodies() {
    let recording = common::transition();
    for (time_s, poses) in [(1.2, 10), (4.6, 10), (4.6, 20)] {
        let (from_s, to_s) = stride_at(&recording, time_s).unwrap();
        let within = strobe_within(&recording, from_s, to_s, poses, 680.0).unwrap();
        let (width, _) = drawn_size(&within);
        assert!((660.0..=680.0).contains(&width), "{width}");
        assert_eq!(count(&within.svg, "<circle"), poses);
        keep(
            &format!("within_{poses}_{time_s}.png"),
            &within.to_png(2.0).unwrap(),
        );
        // The highest thing below the note, which ends at 18, is a trunk.
        let pixels = common::pixels(&within, 1.0);
        // The last column may be covered in part.
        let row_is_white = |y: u32| {
            (0..pixels.width() - 1).all(|x| {
                let pixel = pixels.pixel(x, y).unwrap();
                pixel.red() > 250 && pixel.green() > 250 && pixel.blue() > 250
            })
        };
        let empty = (19..100).take_while(|&y| row_is_white(y)).count();
        assert!(
            (1..=20).contains(&empty),
            "{empty} empty rows at {time_s} s, {poses} poses"
        );
    }
    let (from_s, to_s) = stride_at(&recording, 1.2).unwrap();
    let wide = strobe_within(&recording, from_s, to_s, 3, 5000.0).unwrap();
    assert_eq!(wide.svg, strobe(&recording, from_s, to_s, 3).unwrap().svg);
    let error = strobe_within(&recording, from_s, to_s, 3, 10.0).unwrap_err();
    assert!(matches!(error, FigureError::Option { name: "width", .. }));
}

/// A recording of one pose, held for two rows.
fn hold(state: &BodyState) -> Recording {
    let mut recording = Recording::new(metadata());
    let positions = state.positions();
    let columns = [
        column::X_M,
        column::Z_M,
        column::THETA_RAD,
        column::RIGHT_PHI_RAD,
        column::RIGHT_H_M,
        column::RIGHT_D_M,
        column::RIGHT_W_M,
        column::LEFT_PHI_RAD,
        column::LEFT_H_M,
        column::LEFT_D_M,
        column::LEFT_W_M,
    ];
    for time_s in [0.0, 0.1] {
        let mut row = vec![0.0; COLUMNS.len()];
        row[column::TIME_S.index()] = time_s;
        for (column, value) in columns.into_iter().zip(positions) {
            row[column.index()] = value;
        }
        recording.push_row(&row).unwrap();
    }
    recording
}

#[test]
fn a_stride_shows_its_poses_and_contacts() {
    let recording = common::transition();
    for (name, time_s, poses) in [("walk", 1.2, 9), ("run", 4.6, 8)] {
        let (from_s, to_s) = stride_at(&recording, time_s).unwrap();
        assert!(from_s <= time_s && time_s < to_s);
        let figure = strobe(&recording, from_s, to_s, poses).unwrap();
        keep(&format!("strobe_{name}.svg"), figure.svg.as_bytes());
        keep(&format!("strobe_{name}.png"), &figure.to_png(2.0).unwrap());
        drawn_size(&figure);
        assert_eq!(polylines(&figure, SOLE).len(), 2 * poses);
        assert_eq!(
            count(&figure.svg, "<circle"),
            poses,
            "a hip joint in each pose"
        );
    }
}

#[test]
fn feet_that_carry_stand_on_the_ground() {
    let recording = common::toy(3.0, |_| 0.0);
    let figure = strobe(&recording, 0.0, 2.0, 21).unwrap();
    let clearances = clearances(&figure);
    // The toy always has a foot on the ground when it walks; half a unit is a tenth of a sole.
    for pose in clearances.chunks(2) {
        let lowest = pose[0].min(pose[1]);
        assert!(lowest.abs() < 0.5 / SCALE, "{pose:?}");
    }
    assert!(
        clearances.iter().any(|&clearance| clearance > 0.02),
        "a swinging foot is lifted"
    );
}

/// A standing body that is at `x = 0` in the first of two rows and `way_m` further in the second, on this ground.
fn moved_on(ground: Vec<[f64; 2]>, way_m: f64, rise_m: f64) -> Recording {
    let body = Body::new(BodyParameters::default()).unwrap();
    let state = BodyState::standing(&body);
    let mut recording = Recording::new(RecordingMetadata {
        ground: Some(ground),
        ..metadata()
    });
    for (time_s, x, rise) in [(0.0, 0.0, 0.0), (0.1, way_m, rise_m)] {
        let mut row = vec![0.0; COLUMNS.len()];
        row[column::TIME_S.index()] = time_s;
        row[column::X_M.index()] = x;
        row[column::Z_M.index()] = state.z + rise;
        recording.push_row(&row).unwrap();
    }
    recording
}

// Poses before and after a step stood on one line, and none showed the step.
#[test]
fn where_the_ground_is_not_flat_each_pose_stands_on_the_ground_around_it() {
    let step = vec![[-10.0, 0.0], [0.95, 0.0], [0.95, 0.1], [10.0, 0.1]];
    let figure = strobe(&moved_on(step, 1.0, 0.1), 0.0, 0.1, 2).unwrap();
    let lines = figure.svg.lines();
    let pieces: Vec<_> = lines
        .filter(|line| line.starts_with("<polyline") && line.contains("#7d7468"))
        .collect();
    let heights = |piece: &str| -> Vec<f64> {
        let points = piece.split('"').nth(1).unwrap().split(' ');
        let y = |point: &str| point.split_once(',').unwrap().1.parse().unwrap();
        points.map(y).collect()
    };
    assert_eq!(pieces.len(), 2, "one for each pose");
    let (before, after) = (heights(pieces[0]), heights(pieces[1]));
    assert_eq!(before.len(), 2);
    assert_eq!(after.len(), 4, "the step's two corners between the ends");
    assert!((before[0] - before[1]).abs() < 1e-9 && (after[0] - before[0]).abs() < 0.011);
    assert!((before[0] - after[3] - 0.1 * SCALE).abs() < 0.011);
    let soles = polylines(&figure, SOLE);
    for (sole, level) in soles.iter().zip([before[0], before[0], after[3], after[3]]) {
        let lowest = sole.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
        let clearance_m = (level - lowest) / SCALE - 0.012;
        assert!(clearance_m.abs() < 0.5 / SCALE, "{clearance_m}");
    }
    keep("strobe_step.png", &figure.to_png(2.0).unwrap());
    assert!(figure.svg.contains("each on the ground around it"));
}

// Heights from the lowest ground of a long climb would make a picture of nothing but ground.
#[test]
fn a_climb_does_not_make_the_picture_higher() {
    let flat = moved_on(vec![[-10.0, 0.0], [10.0, 0.0]], 5.0, 0.0);
    let (_, height) = drawn_size(&strobe(&flat, 0.0, 0.1, 4).unwrap());
    for (slope, far) in [(0.5, 10.0), (1.0, 1e6)] {
        let climb = moved_on(
            vec![[-far, -slope * far], [far, slope * far]],
            5.0,
            5.0 * slope,
        );
        let figure = strobe(&climb, 0.0, 0.1, 4).unwrap();
        assert!((drawn_size(&figure).1 - height).abs() < 1.0);
        assert!(figure.svg.contains("heights over the ground below the hip"));
        figure.to_png(1.0).unwrap();
    }
}

#[test]
fn the_drawn_geometry_is_that_of_the_model() {
    let body = Body::new(BodyParameters::default()).unwrap();
    for (theta, psi, thigh, foot) in [
        (0.0, [0.0, 0.3], [0.0, 0.0], [0.0, 0.0]),
        (0.4, [0.5, -0.4], [0.06, -0.05], [0.02, -0.09]),
        (-0.3, [-0.7, 0.1], [-0.1, 0.1], [-0.13, 0.05]),
    ] {
        let mut state = BodyState::with_leg_angles(&body, psi);
        state.theta = theta;
        for leg in 0..2 {
            state.legs[leg].thigh = thigh[leg];
            state.legs[leg].foot = foot[leg];
            state.legs[leg].tibia = 0.5 * (thigh[leg] + foot[leg]);
        }
        // The model's own answer to where the lower sole touches.
        state.z = body.lowest_hip_height(&state);
        let clearances = clearances(&strobe(&hold(&state), 0.0, 0.1, 2).unwrap());
        let lowest = clearances.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(
            lowest.abs() < 0.02 / SCALE,
            "{psi:?}: {lowest} m over the ground"
        );
    }
}

#[test]
fn springs_end_where_the_masses_are() {
    // Upright legs: down the leg is down the sheet, and each quantity moves its own parts alone.
    let body = Body::new(BodyParameters::default()).unwrap();
    let springs = |thigh: f64, tibia: f64, foot: f64| {
        let mut state = BodyState::standing(&body);
        state.z += 0.3;
        for leg in &mut state.legs {
            (leg.thigh, leg.tibia, leg.foot) = (thigh, tibia, foot);
        }
        let figure = strobe(&hold(&state), 0.0, 0.1, 2).unwrap();
        let wires = polylines(&figure, 0.011 * 105.0);
        let ends = |wire: &Vec<(f64, f64)>| {
            let down = |point: Option<&(f64, f64)>| point.unwrap().1 / SCALE;
            (down(wire.first()), down(wire.last()))
        };
        // Foot to thigh (k1), tibia to thigh (k3), foot to tibia (k2).
        [ends(&wires[0]), ends(&wires[1]), ends(&wires[2])]
    };
    let rest = springs(0.0, 0.0, 0.0);
    for (moved, by) in [
        (
            springs(0.05, 0.0, 0.0),
            [(0.05, 0.0), (0.05, 0.0), (0.0, 0.0)],
        ),
        (
            springs(0.0, 0.03, 0.0),
            [(0.0, 0.0), (0.0, 0.03), (0.03, 0.0)],
        ),
        (
            springs(0.0, 0.0, -0.06),
            [(0.0, -0.06), (0.0, 0.0), (0.0, -0.06)],
        ),
    ] {
        for ((moved, rest), by) in moved.into_iter().zip(rest).zip(by) {
            assert!(
                (moved.0 - rest.0 - by.0).abs() < 2e-4,
                "{moved:?} {rest:?} {by:?}"
            );
            assert!(
                (moved.1 - rest.1 - by.1).abs() < 2e-4,
                "{moved:?} {rest:?} {by:?}"
            );
        }
    }
}

#[test]
fn poses_between_rows_are_between_their_poses() {
    let body = Body::new(BodyParameters::default()).unwrap();
    let recording = |heights: [f64; 2]| {
        let mut both = Recording::new(metadata());
        for (row, z) in heights.into_iter().enumerate() {
            let state = BodyState {
                z,
                ..BodyState::standing(&body)
            };
            let one = hold(&state);
            let value = |name: &&str| one.column(Column::named(name).unwrap())[row];
            both.push_row(&COLUMNS.iter().map(value).collect::<Vec<_>>())
                .unwrap();
        }
        both
    };
    let heights = |recording: &Recording| {
        let figure = strobe(recording, 0.0, 0.1, 3).unwrap();
        let hips = figure
            .svg
            .lines()
            .filter(|line| line.starts_with("<circle"));
        hips.map(|line| {
            (ground(&figure) - line.split('"').nth(3).unwrap().parse::<f64>().unwrap()) / SCALE
        })
        .collect::<Vec<_>>()
    };
    for (found, expected) in heights(&recording([0.9, 1.1]))
        .into_iter()
        .zip([0.9, 1.0, 1.1])
    {
        assert!((found - expected).abs() < 1e-4, "{found} {expected}");
    }
}

#[test]
fn poor_recordings_are_drawn() {
    for recording in [common::short(2), common::motionless(30), common::extreme()] {
        let figure = strobe(&recording, f64::NEG_INFINITY, f64::INFINITY, 60).unwrap();
        drawn_size(&figure);
        figure.to_png(1.0).unwrap();
        assert_eq!(stride_at(&recording, 0.02), None);
    }
    assert_eq!(stride_at(&common::short(0), 0.0), None);
}

#[test]
fn what_cannot_be_drawn_is_an_error() {
    let recording = common::transition();
    for poses in [0, 1, 61] {
        let error = strobe(&recording, 0.0, 1.0, poses).unwrap_err();
        assert!(matches!(error, FigureError::Option { name: "poses", .. }));
    }
    for (from_s, to_s) in [(7.0, 8.0), (1.0, 0.5), (1.001, 1.002), (1.0, 1.0)] {
        let error = strobe(&recording, from_s, to_s, 5).unwrap_err();
        assert!(
            matches!(error, FigureError::TimeRange { .. }),
            "{from_s} to {to_s}: {error}"
        );
        // What is recorded, not what was asked for.
        assert!(error.to_string().contains("0 s to 6.5 s"), "{error}");
    }
    let error = strobe(&common::short(0), 0.0, 1.0, 5).unwrap_err();
    assert!(matches!(error, FigureError::Empty { .. }));
}
