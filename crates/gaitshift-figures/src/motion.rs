//! A recorded motion as something to look at: a time range, values at any moment, poses.

use std::ops::Range;

use gaitshift_analysis::recording::{Column, Recording, Side, column};
use gaitshift_body::BodyParameters;

use crate::FigureError;

/// A row this close to the end of a range belongs to it: times are sums of rounded periods.
const TIME_TOLERANCE_S: f64 = 1e-9;

/// A recording with the rows of a time range.
#[derive(Clone, Debug)]
pub(crate) struct Motion<'a> {
    pub recording: &'a Recording,
    pub rows: Range<usize>,
}

impl<'a> Motion<'a> {
    /// The whole recording.
    pub fn whole(recording: &'a Recording) -> Result<Self, FigureError> {
        if recording.is_empty() {
            return Err(FigureError::Empty {
                what: "the recording",
                needed: "one row",
            });
        }
        Ok(Self {
            recording,
            rows: 0..recording.len(),
        })
    }

    /// The rows within `from_s` to `to_s`; the range may reach beyond the recording.
    pub fn between(recording: &'a Recording, from_s: f64, to_s: f64) -> Result<Self, FigureError> {
        let whole = Self::whole(recording)?;
        let times = recording.column(column::TIME_S);
        let first = times.partition_point(|&t| t < from_s - TIME_TOLERANCE_S);
        let rows = first..times.partition_point(|&t| t <= to_s + TIME_TOLERANCE_S);
        if rows.is_empty() || from_s.is_nan() || to_s.is_nan() {
            let (first_s, last_s) = (whole.first_s(), whole.last_s());
            return Err(FigureError::TimeRange {
                from_s,
                to_s,
                first_s,
                last_s,
            });
        }
        Ok(Self { recording, rows })
    }

    /// The values of a column in the range.
    pub fn values(&self, column: Column) -> &'a [f64] {
        &self.recording.column(column)[self.rows.clone()]
    }

    pub fn times(&self) -> &'a [f64] {
        self.values(column::TIME_S)
    }

    /// Time of the range's first row, s.
    pub fn first_s(&self) -> f64 {
        self.times()[0]
    }

    /// Time of the range's last row, s.
    pub fn last_s(&self) -> f64 {
        self.times()[self.rows.len() - 1]
    }

    pub fn duration_s(&self) -> f64 {
        self.last_s() - self.first_s()
    }

    /// Value at `time_s`, linear between rows of the whole recording and held outside of it.
    pub fn at(&self, column: Column, time_s: f64) -> f64 {
        let times = self.recording.column(column::TIME_S);
        let values = self.recording.column(column);
        let after = times.partition_point(|&t| t < time_s);
        if after == 0 {
            return values[0];
        }
        if after == times.len() {
            return values[after - 1];
        }
        let (t0, t1) = (times[after - 1], times[after]);
        let share = (time_s - t0) / (t1 - t0);
        values[after - 1] * (1.0 - share) + values[after] * share
    }

    /// Mean forward speed over `window_s` around `time_s` as far as recorded, in m/s.
    pub fn mean_speed(&self, time_s: f64, window_s: f64) -> f64 {
        let times = self.recording.column(column::TIME_S);
        let from = (time_s - 0.5 * window_s).max(times[0]);
        let to = (time_s + 0.5 * window_s).min(times[times.len() - 1]);
        if to > from {
            (self.at(column::X_M, to) - self.at(column::X_M, from)) / (to - from)
        } else {
            self.at(column::X_VELOCITY_M_PER_S, time_s)
        }
    }

    /// Where every part of the body is at `time_s`.
    pub fn pose(&self, time_s: f64) -> Pose {
        let at = |column| self.at(column, time_s);
        let theta = at(column::THETA_RAD);
        let leg = |side: Side| {
            let of = |columns: [Column; 2]| at(columns[side.index()]);
            LegPose {
                psi: theta + of(column::PHI_RAD),
                h: of(column::H_M),
                d: of(column::D_M),
                w: of(column::W_M),
                force_n: (of(column::TANGENTIAL_FORCE_N), of(column::NORMAL_FORCE_N)),
            }
        };
        Pose {
            x: at(column::X_M),
            z: at(column::Z_M),
            theta,
            legs: Side::BOTH.map(leg),
        }
    }
}

/// Position of the body, SI units and radians.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pose {
    /// Forward position of the hip axis.
    pub x: f64,
    /// Height of the hip axis.
    pub z: f64,
    /// Pitch of the hip segment.
    pub theta: f64,
    /// Right and left leg.
    pub legs: [LegPose; 2],
}

/// Position of one leg and the ground's force on it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LegPose {
    /// Absolute leg angle.
    pub psi: f64,
    /// Thigh displacement down the leg.
    pub h: f64,
    /// Compression of the distance thigh-foot.
    pub d: f64,
    /// Compression of the distance thigh-tibia.
    pub w: f64,
    /// Forward and upward ground reaction in N.
    pub force_n: (f64, f64),
}

/// The body that a recording says it was made with.
pub(crate) fn body_of(recording: &Recording) -> Result<BodyParameters, FigureError> {
    let body: BodyParameters =
        serde_json::from_value(recording.metadata.body.clone()).map_err(|cause| {
            FigureError::Body {
                cause: cause.to_string(),
            }
        })?;
    body.validate().map_err(|cause| FigureError::Body {
        cause: cause.to_string(),
    })?;
    Ok(body)
}
