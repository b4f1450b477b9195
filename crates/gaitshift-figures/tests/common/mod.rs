//! A kinematic toy that walks, runs and changes between the two, to have something to draw.
//!
//! It is no simulation: hip and legs follow prescribed curves and the ground forces are half sines
//! whose mean carries the body. Sizes, phases and signs are those of a real recording.
#![allow(dead_code)]

use std::f64::consts::{PI, TAU};
use std::path::PathBuf;

use gaitshift_analysis::recording::{COLUMNS, Column, Recording, RecordingMetadata, Side, column};
use gaitshift_analysis::support::{ContactRule, PhaseInterval, Support, SupportPhase};
use gaitshift_body::BodyParameters;
use gaitshift_figures::Figure;
use resvg::tiny_skia::Pixmap;
use resvg::usvg;

pub const PERIOD_S: f64 = 0.005;

/// Metadata of a body with default parameters.
pub fn metadata() -> RecordingMetadata {
    let body = BodyParameters::default();
    RecordingMetadata {
        control_period_s: PERIOD_S,
        total_mass_kg: body.total_mass_kg(),
        gravity_m_per_s2: body.gravity_m_per_s2,
        leg_length_m: body.leg_length_m,
        body: serde_json::to_value(&body).unwrap(),
        controller: "toy".to_owned(),
        seed: 0,
        fell: false,
        ended_by: "time limit".to_owned(),
        disturbance: None,
        ground: None,
    }
}

/// A motion of `duration_s` whose share of running (0 walks, 1 runs) is given for each time.
pub fn toy(duration_s: f64, running: impl Fn(f64) -> f64) -> Recording {
    let body = BodyParameters::default();
    let weight = body.total_mass_kg() * body.gravity_m_per_s2;
    let mut recording = Recording::new(metadata());
    let (mut x, mut stride) = (0.0, 0.0);
    for i in 0..=(duration_s / PERIOD_S).round() as usize {
        let time = i as f64 * PERIOD_S;
        let run = running(time).clamp(0.0, 1.0);
        let blend = |walk: f64, run_value: f64| walk + (run_value - walk) * run;
        let mean_speed = blend(0.62, 2.6);
        let stride_s = blend(1.05, 0.70);
        let duty = blend(0.62, 0.36);
        let swing_angle = blend(0.26, 0.40);
        // The hip is highest in mid-stance when walking, lowest when running.
        let bounce = (2.0 * TAU * (stride - 0.5 * duty)).cos() * blend(1.0, -1.0);
        let z = blend(0.785, 0.80) + blend(0.015, 0.035) * bounce;
        let speed = mean_speed - blend(0.10, 0.12) * bounce * blend(1.0, -1.0);

        let mut row = vec![0.0; COLUMNS.len()];
        let mut set = |column: Column, value: f64| row[column.index()] = value;
        let theta = 0.06 * (TAU * stride).sin();
        let mut elastic = 0.0;
        for side in Side::BOTH {
            let phase = (stride + 0.5 * side.index() as f64).rem_euclid(1.0);
            let (psi, normal, lift);
            if phase < duty {
                let share = phase / duty;
                psi = swing_angle * (1.0 - 2.0 * share);
                normal = weight * PI / (4.0 * duty) * (PI * share).sin();
                lift = 0.0;
            } else {
                let share = (phase - duty) / (1.0 - duty);
                psi = -swing_angle * (PI * share).cos();
                normal = 0.0;
                lift = (PI * share).sin();
            }
            let d = normal / 9750.0;
            let w = d * 6.0 / 16.0;
            let straight = body.leg_length_m - body.foot_arc_radius_m;
            // In stance the sole touches, in swing the leg is drawn up.
            let reach = (z - body.foot_arc_radius_m - 0.06 * lift) / psi.cos() - straight;
            elastic += 0.5 * 6000.0 * d * d + 0.5 * 10000.0 * w * w;
            let mut set_leg = |columns: [Column; 2], value| set(columns[side.index()], value);
            set_leg(column::PHI_RAD, psi - theta);
            set_leg(column::H_M, reach + d);
            set_leg(column::D_M, d);
            set_leg(column::W_M, w);
            set_leg(column::NORMAL_FORCE_N, normal);
            set_leg(column::TANGENTIAL_FORCE_N, -normal * psi.sin());
        }
        set(column::TIME_S, time);
        set(column::OMEGA_V, 3.0 * run);
        set(column::X_M, x);
        set(column::Z_M, z);
        set(column::THETA_RAD, theta);
        set(column::X_VELOCITY_M_PER_S, speed);
        set(
            column::KINETIC_ENERGY_J,
            0.5 * body.total_mass_kg() * speed * speed,
        );
        set(column::GRAVITATIONAL_ENERGY_J, weight * z);
        set(column::LEG_SPRING_ENERGY_J, elastic);
        set(column::ELASTIC_ENERGY_J, elastic);
        recording.push_row(&row).unwrap();
        x += speed * PERIOD_S;
        stride += PERIOD_S / stride_s;
    }
    recording
}

/// Walks, and from 3.0 to 3.4 s changes to running; 6.5 s.
pub fn transition() -> Recording {
    toy(6.5, |time| (time - 3.0) / 0.4)
}

/// The first `rows` rows of a walk.
pub fn short(rows: usize) -> Recording {
    let long = toy(rows as f64 * PERIOD_S, |_| 0.0);
    let mut recording = Recording::new(metadata());
    for i in 0..rows {
        let row: Vec<f64> = COLUMNS
            .iter()
            .map(|name| long.column(Column::named(name).unwrap())[i])
            .collect();
        recording.push_row(&row).unwrap();
    }
    recording
}

/// A body that hangs motionless over the ground: every column constant.
pub fn motionless(rows: usize) -> Recording {
    let mut recording = Recording::new(metadata());
    for i in 0..rows {
        let mut row = vec![0.0; COLUMNS.len()];
        row[column::TIME_S.index()] = i as f64 * PERIOD_S;
        row[column::Z_M.index()] = 1.0;
        recording.push_row(&row).unwrap();
    }
    recording
}

/// Writes a picture into the folder named by the environment variable `FIGURE_SAMPLES`, if it is set,
/// so that a person can look at what the tests have drawn.
pub fn keep(name: &str, content: &[u8]) {
    if let Some(folder) = std::env::var_os("FIGURE_SAMPLES").map(PathBuf::from) {
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join(name), content).unwrap();
    }
}

/// Asserts that the figure's SVG is well-formed and can be drawn, and gives its size in user units.
pub fn drawn_size(figure: &Figure) -> (f64, f64) {
    let tree = usvg::Tree::from_str(&figure.svg, &usvg::Options::default()).unwrap();
    for nonsense in ["NaN", "inf", "\"-0\""] {
        assert!(
            !figure.svg.contains(nonsense),
            "the SVG contains {nonsense}"
        );
    }
    (
        f64::from(tree.size().width()),
        f64::from(tree.size().height()),
    )
}

/// The figure's pixels at `scale`.
pub fn pixels(figure: &Figure, scale: f64) -> Pixmap {
    Pixmap::decode_png(&figure.to_png(scale).unwrap()).unwrap()
}

/// Red, green and blue of a pixel.
pub fn colour(pixels: &Pixmap, x: u32, y: u32) -> [u8; 3] {
    let pixel = pixels.pixel(x, y).unwrap();
    [pixel.red(), pixel.green(), pixel.blue()]
}

/// How often a piece of text occurs.
pub fn count(text: &str, piece: &str) -> usize {
    text.matches(piece).count()
}

/// Number of support phases of one kind that overlap a time range.
pub fn phases_between(recording: &Recording, phase: SupportPhase, from_s: f64, to_s: f64) -> usize {
    let support = Support::find(recording, &ContactRule::default());
    let overlaps = |interval: &&PhaseInterval| {
        interval.phase == phase && interval.end_s > from_s && interval.start_s < to_s
    };
    support.phases().iter().filter(overlaps).count()
}

/// A recording of finite but extreme numbers, such as a diverging simulation leaves behind.
pub fn extreme() -> Recording {
    let mut recording = Recording::new(metadata());
    for i in 0..40 {
        let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
        let mut row = vec![sign * 1e300; COLUMNS.len()];
        row[column::TIME_S.index()] = f64::from(i) * PERIOD_S;
        recording.push_row(&row).unwrap();
    }
    recording
}
