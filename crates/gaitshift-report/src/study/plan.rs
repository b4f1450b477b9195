//! What is measured, and how closely.

use serde::Serialize;

/// What is measured, and how closely.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plan {
    /// Walking and running command.
    pub gaits: [f64; 2],
    /// Least and greatest command of the steady motions, and the step between them.
    pub range: [f64; 3],
    /// Duration of each steady motion, in s; the first 5 s are not measured.
    pub steady_s: f64,
    /// The stairs of the command lead from 0 to this, where it runs, and down again, in these steps, each held for so long (s).
    pub stairs: [f64; 3],
    /// Random starts at each command of the stairs' range.
    pub starts: u64,
    /// Step between those commands.
    pub starts_step: f64,
    /// Trials of each disturbance.
    pub trials: u64,
    /// Heights of steps in the ground that are tried: least, greatest and the step between them, in m.
    pub step_heights_m: [f64; 3],
    /// Levels of noise that are tried, in standard deviations of the observation itself.
    pub noise_levels: Vec<f64>,
    /// Commands whose motion is followed at the integration step, and whose return map is sought.
    pub followed: Vec<f64>,
    /// Finer integration step beside the usual one, in s.
    pub fine_step_s: f64,
    /// Duration of a ramp of the command, in s, and phases of the stride from which it begins.
    pub ramp_s: f64,
    /// Phases of the stride.
    pub phases: usize,
}

impl Plan {
    /// The whole study.
    pub fn full() -> Self {
        Self {
            gaits: [0.0, 3.0],
            range: [-0.5, 3.5, 0.01],
            steady_s: 30.0,
            stairs: [1.6, 0.02, 20.0],
            starts: 13,
            starts_step: 0.05,
            trials: 10,
            step_heights_m: [0.002, 0.04, 0.002],
            noise_levels: vec![0.05, 0.1, 0.2, 0.5, 1.0, 2.0],
            followed: vec![0.0, 0.2, 0.4, 1.0, 3.0],
            fine_step_s: 5e-5,
            ramp_s: 0.4,
            phases: 20,
        }
    }

    /// The same questions with coarser steps and fewer starts.
    pub fn quick() -> Self {
        Self {
            range: [-0.5, 3.5, 0.05],
            steady_s: 20.0,
            starts: 8,
            phases: 10,
            ..Self::full()
        }
    }
}

/// From the first command to the last in steps; both ends included.
pub(super) fn commands([from, to, step]: [f64; 3]) -> Vec<f64> {
    let count = ((to - from) / step + 1e-6).floor().max(0.0) as usize;
    // Products of steps such as 0.05 have a long tail of digits.
    let tidy = |value: f64| (value * 1e9).round() / 1e9 + 0.0;
    (0..=count).map(|k| tidy(from + k as f64 * step)).collect()
}
