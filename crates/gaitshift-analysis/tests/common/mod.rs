//! Synthetic motions with known answers, as a recorder would write them.
#![allow(dead_code)] // Each test file uses its own part.

use std::f64::consts::PI;

use gaitshift_analysis::recording::{
    COLUMNS, Column, Recording, RecordingMetadata, column, ended_by,
};

pub const PERIOD_S: f64 = 0.005;
pub const MASS_KG: f64 = 40.0;
pub const GRAVITY: f64 = 9.81;
pub const LEG_M: f64 = 0.8;
pub const WEIGHT_N: f64 = MASS_KG * GRAVITY;

pub fn metadata() -> RecordingMetadata {
    RecordingMetadata {
        control_period_s: PERIOD_S,
        total_mass_kg: MASS_KG,
        gravity_m_per_s2: GRAVITY,
        leg_length_m: LEG_M,
        body: serde_json::json!({"leg_length_m": 0.8, "foot": {"spheres": 20}}),
        controller: "synthetic".to_owned(),
        seed: u64::MAX,
        fell: false,
        ended_by: ended_by::TIME_LIMIT.to_owned(),
        disturbance: None,
        ground: None,
    }
}

/// The body at one instant.
#[derive(Debug, Clone, Copy, Default)]
pub struct Frame {
    pub x_m: f64,
    /// Absolute leg angles, right and left.
    pub psi_rad: [f64; 2],
    /// Which feet bear weight; read at the middle of each control period.
    pub contact: [bool; 2],
    pub kinetic_j: f64,
    pub gravitational_j: f64,
    pub elastic_j: f64,
    pub positive_work_j: f64,
}

impl Frame {
    /// The same motion with the legs' roles exchanged.
    pub fn mirrored(mut self) -> Frame {
        self.psi_rad.swap(0, 1);
        self.contact.swap(0, 1);
        self
    }
}

/// Records a motion given as a function of time.
pub fn record(duration_s: f64, motion: impl Fn(f64) -> Frame) -> Recording {
    let mut recording = Recording::new(metadata());
    for period in 0..=(duration_s / PERIOD_S).round() as usize {
        let time_s = period as f64 * PERIOD_S;
        let now = motion(time_s);
        let contact = match period {
            0 => [false; 2],
            _ => motion(time_s - 0.5 * PERIOD_S).contact,
        };
        let feet = contact.iter().filter(|&&touching| touching).count().max(1);
        let mut row = vec![0.0; COLUMNS.len()];
        let mut set = |column: Column, value| row[column.index()] = value;
        set(column::TIME_S, time_s);
        set(column::X_M, now.x_m);
        set(column::Z_M, LEG_M);
        for (side, touching) in contact.into_iter().enumerate() {
            let share = if touching { 1.0 / feet as f64 } else { 0.0 };
            set(column::PHI_RAD[side], now.psi_rad[side]);
            set(column::NORMAL_FORCE_N[side], share * WEIGHT_N);
        }
        set(column::KINETIC_ENERGY_J, now.kinetic_j);
        set(column::GRAVITATIONAL_ENERGY_J, now.gravitational_j);
        set(column::ELASTIC_ENERGY_J, now.elastic_j);
        set(column::ACTUATOR_POSITIVE_WORK_J, now.positive_work_j);
        recording.push_row(&row).expect("synthetic rows are valid");
    }
    recording
}

/// A gait at constant speed whose feet stand still while they are on the ground.
#[derive(Debug, Clone, Copy)]
pub struct Gait {
    pub speed_m_per_s: f64,
    pub step_s: f64,
    /// How long each foot stays on the ground.
    pub stance_s: f64,
    /// Time from the right touchdown to the left one, as a fraction of the stride; 0.5 is even.
    pub left_phase: f64,
    pub cost_of_transport: f64,
}

impl Gait {
    /// Double support for 0.1 s at the beginning of each step of 0.5 s and 0.4 m.
    pub const WALK: Gait = Gait {
        speed_m_per_s: 0.8,
        step_s: 0.5,
        stance_s: 0.6,
        left_phase: 0.5,
        cost_of_transport: 0.2,
    };
    /// Flight for 0.1 s at the end of each step of 0.35 s and 0.7 m.
    pub const RUN: Gait = Gait {
        speed_m_per_s: 2.0,
        step_s: 0.35,
        stance_s: 0.25,
        left_phase: 0.5,
        cost_of_transport: 0.3,
    };

    pub fn frame(&self, time_s: f64) -> Frame {
        let stride_s = 2.0 * self.step_s;
        let since_touchdown_s =
            [0.0, self.left_phase].map(|phase| (time_s - phase * stride_s).rem_euclid(stride_s));
        let stance_m = self.speed_m_per_s * self.stance_s;
        let psi_rad = since_touchdown_s.map(|since_s| {
            let foot_ahead_m = if since_s <= self.stance_s {
                0.5 * stance_m - self.speed_m_per_s * since_s
            } else {
                stance_m * ((since_s - self.stance_s) / (stride_s - self.stance_s) - 0.5)
            };
            (foot_ahead_m / LEG_M).asin()
        });
        let x_m = self.speed_m_per_s * time_s;
        let mut frame = Frame {
            x_m,
            psi_rad,
            contact: since_touchdown_s.map(|since_s| since_s < self.stance_s),
            positive_work_j: self.cost_of_transport * WEIGHT_N * x_m,
            ..Frame::default()
        };
        if self.stance_s >= self.step_s {
            // A pendulum on top of the stance leg: what one energy loses, the other gains.
            let swing_j = 8.0 * (2.0 * PI * time_s / self.step_s).cos();
            frame.kinetic_j = 30.0 + swing_j;
            frame.gravitational_j = 300.0 - swing_j;
        } else {
            // A mass on a spring: both dip in stance while the spring is compressed.
            let since_s = time_s.rem_euclid(self.step_s);
            let dip_j = if since_s < self.stance_s {
                20.0 * (PI * since_s / self.stance_s).sin()
            } else {
                0.0
            };
            frame.kinetic_j = 90.0 - dip_j;
            frame.gravitational_j = 310.0 - dip_j;
            frame.elastic_j = 2.0 * dip_j;
        }
        frame
    }

    pub fn record(&self, duration_s: f64) -> Recording {
        record(duration_s, |time_s| self.frame(time_s))
    }
}

pub fn close(actual: Option<f64>, expected: f64) {
    let actual = actual.expect("defined");
    assert!(
        (actual - expected).abs() < 1e-9,
        "{actual} is not {expected}"
    );
}
