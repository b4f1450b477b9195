//! The table of time series that every analysis, figure and picture reads.
//!
//! One row per control period; row 0 is the initial state. Depending on the column, a row holds
//! - the value at the row's time (states, energies),
//! - the mean over the period that ends at the row's time (forces; in row 0 there is no such period, so
//!   analyses do not read the forces of row 0), or
//! - an amount accumulated since the first row (works, dissipations).
//!
//! A recording holds finite numbers only, and its time increases from row to row: [`Recording::push_row`]
//! and [`Recording::read_csv`] refuse anything else. A motion that diverged is recorded up to its last
//! finite state, with `ended_by` set to [`ended_by::DIVERGED`].
//!
//! # The file
//! ```text
//! # gaitshift-recording 1 {"control_period_s":0.01,...,"rows":2001}
//! time_s,omega_v,x_m,...
//! 0.0,3.0,0.0,...
//! ```
//! Numbers are written in the shortest form that reads back to the same bits. `rows` lets a reader
//! notice a file that was cut off. Columns may come in any order; columns unknown to this version are
//! ignored. [`DETAILS`] are columns that a file may lack.

mod columns;
mod csv_file;
mod details;
mod error;

pub use columns::{COLUMNS, Column, column};
pub use details::{DETAILS, Detail, detail};
pub use error::{RecordingError, RowError};

use serde::{Deserialize, Serialize};

/// Times closer than this are the same: far below any control period, far above rounding.
pub(crate) const TIME_TOLERANCE_S: f64 = 1e-9;

/// What a recording says about itself besides its rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordingMetadata {
    /// Time between two rows, s.
    pub control_period_s: f64,
    /// Mass of the whole body, kg.
    pub total_mass_kg: f64,
    /// Gravitational acceleration, m/s².
    pub gravity_m_per_s2: f64,
    /// Leg length `l` from the hip axis to the sole at `h = d = 0`, m.
    pub leg_length_m: f64,
    /// The full body parameters, as the simulator serialises them.
    pub body: serde_json::Value,
    /// Name or path of the controller.
    pub controller: String,
    /// Seed of the initial state and of everything random in the motion.
    pub seed: u64,
    /// Whether the body fell.
    pub fell: bool,
    /// Why the motion ended; see [`ended_by`] for the usual words.
    pub ended_by: String,
    /// What disturbed the motion, as the simulator serialises it; absent if nothing did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disturbance: Option<serde_json::Value>,
    /// Points `[x, z]` of the ground, m, with straight lines between and beyond them; absent if it is flat.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ground: Option<Vec<[f64; 2]>>,
}

impl RecordingMetadata {
    /// The points of the ground, if it is not flat. What a file says need not be ground: then there are none.
    pub fn ground_to_draw(&self) -> Option<&[[f64; 2]]> {
        let sound = |points: &&[[f64; 2]]| {
            points.len() > 1
                && points.iter().flatten().all(|v| v.abs() <= GREATEST_M)
                && points.windows(2).all(|p| p[0][0] <= p[1][0])
        };
        self.ground.as_deref().filter(sound)
    }
}

/// Beyond this, in m, there is no ground to draw.
const GREATEST_M: f64 = 1e6;

/// Whether a column holds a reward term of one's own.
pub fn is_extra(column: &str) -> bool {
    let fits = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    column.starts_with("reward_") && column.chars().all(fits) && Column::named(column).is_none()
}

/// The usual values of [`RecordingMetadata::ended_by`]; a rule of one's own that ended the motion gives its name.
pub mod ended_by {
    /// The motion was to last this long and did.
    pub const TIME_LIMIT: &str = "time limit";
    /// The simulated state stopped being finite or plausible.
    pub const DIVERGED: &str = "diverged";
    /// A reward term or a rule of one's own had no finite value.
    pub const UNDEFINED: &str = "undefined";
}

/// One of the two legs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// The right leg.
    Right,
    /// The left leg.
    Left,
}

impl Side {
    /// Both legs, in the order in which columns and per-leg arrays hold them.
    pub const BOTH: [Side; 2] = [Side::Right, Side::Left];

    /// Position of this leg in per-leg arrays.
    pub fn index(self) -> usize {
        self as usize
    }

    /// The leg on the other side.
    pub fn other(self) -> Side {
        match self {
            Side::Right => Side::Left,
            Side::Left => Side::Right,
        }
    }
}

/// A recorded motion: metadata and one time series per column of [`COLUMNS`].
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// What the recording says about itself.
    pub metadata: RecordingMetadata,
    columns: Vec<Vec<f64>>,
    /// Of each detail a value per row, or none.
    details: Vec<Vec<f64>>,
    /// Reward terms of one's own by the names of their columns, with a value per row.
    extra: Vec<(String, Vec<f64>)>,
}

impl Recording {
    /// A recording without rows.
    pub fn new(metadata: RecordingMetadata) -> Self {
        Self {
            metadata,
            columns: vec![Vec::new(); COLUMNS.len()],
            details: vec![Vec::new(); DETAILS.len()],
            extra: Vec::new(),
        }
    }

    /// Appends a row, its values in the order of [`COLUMNS`] and, in every row or in none, of [`DETAILS`] after them.
    ///
    /// # Errors
    /// Refuses a row of another width, with a value that is not finite, or not later than the last row;
    /// the recording is then unchanged.
    pub fn push_row(&mut self, row: &[f64]) -> Result<(), RowError> {
        let detailed = if self.is_empty() {
            row.len() != COLUMNS.len()
        } else {
            self.details.iter().all(|series| !series.is_empty())
        };
        let expected = COLUMNS.len() + if detailed { DETAILS.len() } else { 0 };
        if row.len() != expected {
            return Err(RowError::Width {
                found: row.len(),
                expected: if self.is_empty() {
                    COLUMNS.len()
                } else {
                    expected
                },
            });
        }
        if let Some(position) = row.iter().position(|value| !value.is_finite()) {
            return Err(RowError::NotFinite {
                column: (*COLUMNS.iter().chain(DETAILS).nth(position).unwrap_or(&"")).to_owned(),
                value: row[position],
            });
        }
        // A detail that was set for the rows so far needs a value of this one, too.
        let mut details = DETAILS.iter().zip(&self.details);
        if let Some((name, series)) = details.find(|(_, d)| !detailed && !d.is_empty()) {
            return Err(RowError::DetailLength {
                column: (*name).to_owned(),
                found: series.len(),
                expected: self.len() + 1,
            });
        }
        let time_s = row[column::TIME_S.index()];
        if let Some(&previous_s) = self.column(column::TIME_S).last()
            && time_s <= previous_s
        {
            return Err(RowError::TimeNotIncreasing { time_s, previous_s });
        }
        for (series, &value) in self.columns.iter_mut().chain(&mut self.details).zip(row) {
            series.push(value);
        }
        Ok(())
    }

    /// The time series of a column, one value per row.
    pub fn column(&self, column: Column) -> &[f64] {
        &self.columns[column.index()]
    }

    /// The first row that is not one control period after the one before, within 2 %, since other programs add times up;
    /// and how long after it is, in s.
    pub fn off_period(&self) -> Option<(usize, f64)> {
        let period_s = self.metadata.control_period_s;
        let apart = self.column(column::TIME_S).windows(2).map(|t| t[1] - t[0]);
        let mut rows = (1..).zip(apart);
        rows.find(|(_, apart_s)| (apart_s - period_s).abs() > 0.02 * period_s)
    }

    /// The time series of a detail, one value per row, if it was recorded.
    pub fn detail(&self, detail: Detail) -> Option<&[f64]> {
        let series = &self.details[detail.index()];
        (!series.is_empty()).then_some(&series[..])
    }

    /// Gives every row its value of a detail.
    ///
    /// # Errors
    /// Refuses another number of values than rows, and a value that is not finite.
    pub fn set_detail(&mut self, detail: Detail, values: Vec<f64>) -> Result<(), RowError> {
        self.check_series(detail.name(), &values)?;
        self.details[detail.index()] = values;
        Ok(())
    }

    /// Gives every row its value of a reward term of one's own, in the column `reward_NAME`.
    ///
    /// # Errors
    /// Refuses another number of values than rows, and a value that is not finite.
    ///
    /// # Panics
    /// If it is no column of such a term ([`is_extra`]).
    pub fn set_extra(&mut self, column: &str, values: Vec<f64>) -> Result<(), RowError> {
        assert!(
            is_extra(column),
            "`{column}` is no column of a reward term of one's own"
        );
        self.check_series(column, &values)?;
        self.extra.retain(|(name, _)| name != column);
        self.extra.push((column.to_owned(), values));
        Ok(())
    }

    fn check_series(&self, name: &str, values: &[f64]) -> Result<(), RowError> {
        if values.len() != self.len() {
            return Err(RowError::DetailLength {
                column: name.to_owned(),
                found: values.len(),
                expected: self.len(),
            });
        }
        if let Some(&value) = values.iter().find(|value| !value.is_finite()) {
            return Err(RowError::NotFinite {
                column: name.to_owned(),
                value,
            });
        }
        Ok(())
    }

    /// The recorded columns by name: all of [`COLUMNS`], then the details that there are.
    pub fn named_columns(&self) -> impl Iterator<Item = (&'static str, &[f64])> {
        let names = COLUMNS.iter().chain(DETAILS).copied();
        let series = self.columns.iter().chain(&self.details);
        let width = COLUMNS.len();
        names
            .zip(series.map(|series| &series[..]))
            .enumerate()
            .filter(move |(k, (_, series))| *k < width || !series.is_empty())
            .map(|(_, named)| named)
    }

    /// Every column there is: [`Recording::named_columns`], then the reward terms of one's own.
    pub fn every_column(&self) -> impl Iterator<Item = (&str, &[f64])> {
        let extra = self
            .extra
            .iter()
            .map(|(name, series)| (&name[..], &series[..]));
        self.named_columns()
            .map(|named| (named.0 as &str, named.1))
            .chain(extra)
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.column(column::TIME_S).len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Time from the first row to the last, s; 0 without rows.
    pub fn duration_s(&self) -> f64 {
        self.whole().map_or(0.0, |window| window.duration_s(self))
    }

    /// The rows from `start_s` to `end_s`, both included; `None` unless there are at least two.
    ///
    /// Times count as the `time_s` column does, in s.
    pub fn window(&self, start_s: f64, end_s: f64) -> Option<Window> {
        let times = self.column(column::TIME_S);
        let start_row = times.partition_point(|&time| time < start_s - TIME_TOLERANCE_S);
        let rows_before_end = times.partition_point(|&time| time <= end_s + TIME_TOLERANCE_S);
        Window::new(start_row, rows_before_end.checked_sub(1)?)
    }

    /// A part of the recording as a recording of its own: its times, works and metadata are those of the whole.
    ///
    /// # Panics
    /// If the window reaches beyond the recording.
    pub fn part(&self, window: Window) -> Recording {
        let rows = window.start_row()..=window.end_row();
        let cut = |series: &Vec<f64>| match series.len() {
            0 => Vec::new(),
            _ => series[rows.clone()].to_vec(),
        };
        Recording {
            metadata: self.metadata.clone(),
            columns: self.columns.iter().map(cut).collect(),
            details: self.details.iter().map(cut).collect(),
            extra: self
                .extra
                .iter()
                .map(|(name, series)| (name.clone(), cut(series)))
                .collect(),
        }
    }

    /// All rows; `None` unless there are at least two.
    pub fn whole(&self) -> Option<Window> {
        Window::new(0, self.len().checked_sub(1)?)
    }
}

/// Two different rows of a recording and the rows between: a stretch of time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    start_row: usize,
    end_row: usize,
}

impl Window {
    /// The stretch from one row to a later one; `None` if `end_row` is not later.
    pub fn new(start_row: usize, end_row: usize) -> Option<Window> {
        (start_row < end_row).then_some(Window { start_row, end_row })
    }

    /// Row at which the stretch begins.
    pub fn start_row(self) -> usize {
        self.start_row
    }

    /// Row at which the stretch ends.
    pub fn end_row(self) -> usize {
        self.end_row
    }

    /// Whether `row` is one of the window's rows, first and last included.
    pub fn contains(self, row: usize) -> bool {
        (self.start_row..=self.end_row).contains(&row)
    }

    /// What both windows cover, if that is a stretch of time.
    pub fn intersection(self, other: Window) -> Option<Window> {
        Window::new(
            self.start_row.max(other.start_row),
            self.end_row.min(other.end_row),
        )
    }

    /// By how much a column changes from the window's first row to its last.
    ///
    /// # Panics
    /// If the window reaches beyond the recording.
    pub fn change(self, recording: &Recording, column: Column) -> f64 {
        let series = recording.column(column);
        series[self.end_row] - series[self.start_row]
    }

    /// By how much a detail changes from the window's first row to its last; `None` if it was not recorded.
    ///
    /// # Panics
    /// If the window reaches beyond the recording.
    pub fn detail_change(self, recording: &Recording, detail: Detail) -> Option<f64> {
        let series = recording.detail(detail)?;
        Some(series[self.end_row] - series[self.start_row])
    }

    /// How long the window lasts, s.
    ///
    /// # Panics
    /// If the window reaches beyond the recording.
    pub fn duration_s(self, recording: &Recording) -> f64 {
        self.change(recording, column::TIME_S)
    }
}
