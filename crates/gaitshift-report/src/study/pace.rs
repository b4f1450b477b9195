//! How long the measuring of a controller takes.

use super::motions::steady_motion;
use super::plan::{Plan, commands};
use super::{TRACED_S, fine_commands};
use crate::{ReportError, Subject};
use std::time::Instant;

/// Mean time of a try at a step in the ground or under noise, and the simulated time that a return map takes as long as, in s:
/// those of the shipped controller. One that falls early takes less.
const TRY_AT_A_STEP_S: f64 = 14.0;
const TRY_UNDER_NOISE_S: f64 = 7.5;
const RETURN_MAP_S: f64 = 300.0;

impl Plan {
    /// About how long measuring one controller takes on this machine, as busy as it is now, in s.
    ///
    /// # Errors
    /// A motion that cannot be recorded.
    pub fn duration_s(&self) -> Result<f64, ReportError> {
        let mut subject = Subject::shipped()?;
        let began = Instant::now();
        let (motions, motion_s) = (self.gaits, 20.0);
        for omega_v in motions {
            steady_motion(&mut subject, omega_v, motion_s)?;
        }
        let pace = began.elapsed().as_secs_f64() / (motions.len() as f64 * motion_s);
        Ok(pace * self.simulated_s(subject.body.parameters().time_step_s))
    }

    /// Simulated time, in s; that with the finer integration step counts as often as it has steps.
    fn simulated_s(&self, time_step_s: f64) -> f64 {
        let count = |range| commands(range).len() as f64;
        let [top, step, hold_s] = self.stairs;
        let stairs_s = 2.0 * count([0.0, top, step]) * hold_s;
        let starts_s = 20.0 * self.starts as f64 * count([0.0, top, self.starts_step]);
        let followed_s = TRACED_S[1] * self.followed.len() as f64;
        let usual_s = count(self.range) * self.steady_s + stairs_s + starts_s + followed_s + 111.0;
        let fine_s = fine_commands(self).len() as f64 * self.steady_s + stairs_s + starts_s;
        let changes_s = 4.0 * (self.phases + 1) as f64 * 20.0;
        let tries = (2 * self.trials) as f64;
        let steps_s = tries * 3.0 * count(self.step_heights_m) * TRY_AT_A_STEP_S;
        let noise_s = tries * 8.0 * self.noise_levels.len() as f64 * TRY_UNDER_NOISE_S;
        let maps_s = RETURN_MAP_S * self.followed.len() as f64;
        let fine_s = fine_s * time_step_s / self.fine_step_s;
        usual_s + fine_s + changes_s + steps_s + noise_s + maps_s
    }
}
