//! How settings of the learner move during a run.

use serde::{Deserialize, Serialize};

/// A value over the run: points (share of the run in \[0, 1\], value), joined by straight lines and level
/// outside. Without points the setting stays as the learner has it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Course(pub Vec<[f64; 2]>);

impl Course {
    /// The value at a share of the run; nothing where there are no points.
    pub fn at(&self, share: f64) -> Option<f64> {
        let last = self.0.last()?;
        Some(match self.0.iter().position(|p| p[0] > share) {
            None => last[1],
            Some(0) => self.0[0][1],
            Some(i) => {
                let ([x0, y0], [x1, y1]) = (self.0[i - 1], self.0[i]);
                y0 + (y1 - y0) * (share - x0) / (x1 - x0)
            }
        })
    }
}

/// How settings of the learner move during a run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Schedule {
    /// Learning rate of actor and critics.
    pub learning_rate: Course,
    /// The fixed temperature α.
    pub alpha: Course,
    /// The horizon 1 / (1 - γ), in control periods: a short one finds fast gaits, a long one learns not
    /// to fall.
    pub horizon: Course,
}

impl Schedule {
    /// # Errors
    /// Says which key is wrong, why, and what is accepted.
    pub(crate) fn validate(&self) -> Result<(), String> {
        let check = |key: &str, course: &Course, valid: fn(f64) -> bool, accepted: &str| {
            let points = &course.0;
            let shares = points.iter().all(|p| (0.0..=1.0).contains(&p[0]));
            let ordered = points.windows(2).all(|w| w[0][0] < w[1][0]);
            if !(shares && ordered) {
                return Err(format!(
                    "`training.schedule.{key}` is {points:?}, but it must be [share of the run, value] pairs with \
                     shares rising from 0 to 1"
                ));
            }
            match points.iter().find(|p| !valid(p[1])) {
                Some(p) => Err(format!(
                    "`training.schedule.{key}` has the value {}, but it must be {accepted}",
                    p[1]
                )),
                None => Ok(()),
            }
        };
        check(
            "learning_rate",
            &self.learning_rate,
            |v| v.is_finite() && v > 0.0,
            "greater than 0",
        )?;
        check(
            "alpha",
            &self.alpha,
            |v| v.is_finite() && v >= 0.0,
            "0 or greater",
        )?;
        check(
            "horizon",
            &self.horizon,
            |v| v.is_finite() && v >= 1.0,
            "1 control period or greater",
        )
    }
}
