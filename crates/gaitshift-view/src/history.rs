//! The slider's history as a command profile that replays it to the bit.

use gaitshift_experiment::CommandProfile;

/// The longest motion that `gaitshift transition --command-profile` replays, in s.
const LONGEST_S: f64 = 3600.0;

/// The command of every control period since the start, kept as the points of a piecewise linear profile: at the
/// beginning of each period the profile has exactly the command that the period had.
#[derive(Debug, Clone, Default)]
pub struct History {
    points: Vec<(f64, f64)>,
    /// Beginning of the latest period, and its command.
    latest: Option<(f64, f64)>,
    /// What a command profile cannot tell, in words.
    remarks: Vec<String>,
}

impl History {
    /// Adds the period that begins at `time_s`. Periods after the first hour are not kept.
    pub fn push(&mut self, time_s: f64, omega_v: f64) {
        if time_s > LONGEST_S {
            self.remark("the motion lasted longer than an hour; the rest is missing".to_owned());
            return;
        }
        match self.latest {
            Some((_, before)) if before == omega_v => {}
            Some(before) => {
                // Constant up to the last period that had the old command, then straight to the new one: no period
                // begins in between.
                if self.points.last() != Some(&before) {
                    self.points.push(before);
                }
                self.points.push((time_s, omega_v));
            }
            None => self.points.push((time_s, omega_v)),
        }
        self.latest = Some((time_s, omega_v));
    }

    /// Notes something that keeps the profile from replaying the motion.
    pub fn remark(&mut self, remark: String) {
        const MOST: usize = 100;
        if self.remarks.len() < MOST && self.remarks.last() != Some(&remark) {
            self.remarks.push(remark);
        }
    }

    /// The command over time; `None` before the first period.
    pub fn profile(&self) -> Option<CommandProfile> {
        CommandProfile::through(&self.points)
    }

    /// The file for `gaitshift transition --command-profile`.
    pub fn to_csv(&self) -> Option<String> {
        let mut text = String::new();
        for remark in &self.remarks {
            text.push_str(&format!("# {remark}\n"));
        }
        if !self.remarks.is_empty() {
            text.push_str("# This profile alone does not replay the motion.\n");
        }
        text.push_str(&self.profile()?.to_csv());
        Some(text)
    }
}
