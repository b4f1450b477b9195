//! The command `ω_v` over time: constant, a ramp, or any profile read from a CSV file.

use gaitshift_analysis::join_stretches;
use std::path::Path;

/// `ω_v` over time, piecewise linear, constant before the first and after the last point.
#[derive(Debug, Clone, PartialEq)]
pub struct CommandProfile {
    points: Vec<(f64, f64)>,
}

/// A profile that cannot be read.
#[derive(Debug, thiserror::Error)]
#[error(
    "cannot read the command profile {path}: {cause}; expected a CSV file with the columns `time_s,omega_v`, times increasing"
)]
pub struct ProfileError {
    /// The file.
    pub path: String,
    /// What is wrong, with the line where there is one.
    pub cause: String,
}

impl CommandProfile {
    /// The same command for all time.
    pub fn constant(omega_v: f64) -> Self {
        Self {
            points: vec![(0.0, omega_v)],
        }
    }

    /// Straight lines through the points (time in s, command); `None` unless there is a point, all numbers are
    /// finite and times increase.
    pub fn through(points: &[(f64, f64)]) -> Option<Self> {
        let finite = points.iter().all(|p| p.0.is_finite() && p.1.is_finite());
        let increasing = points.windows(2).all(|p| p[0].0 < p[1].0);
        (finite && increasing && !points.is_empty()).then(|| Self {
            points: points.to_vec(),
        })
    }

    /// A linear ramp that begins at `start_s` and takes `ramp_s`.
    pub fn ramp(from: f64, to: f64, start_s: f64, ramp_s: f64) -> Self {
        Self {
            points: vec![(start_s, from), (start_s + ramp_s.max(0.0), to)],
        }
    }

    /// Goes on with a linear ramp to `to` that begins at `start_s`, but not before the last point, and
    /// takes `ramp_s`.
    pub fn then_ramp(mut self, to: f64, start_s: f64, ramp_s: f64) -> Self {
        if let Some(&(last_s, from)) = self.points.last() {
            let start_s = start_s.max(last_s);
            self.points.push((start_s, from));
            self.points.push((start_s + ramp_s.max(0.0), to));
        }
        self
    }

    /// The command at time `time_s`.
    pub fn at(&self, time_s: f64) -> f64 {
        let next = self.points.partition_point(|p| p.0 <= time_s);
        if next == 0 {
            return self.points[0].1;
        }
        let (t0, w0) = self.points[next - 1];
        match self.points.get(next) {
            Some(&(t1, w1)) => w0 + (w1 - w0) * (time_s - t0) / (t1 - t0),
            None => w0,
        }
    }

    /// Time of the last point, in s.
    pub fn end_s(&self) -> f64 {
        self.points.last().map_or(0.0, |p| p.0)
    }

    /// Least and greatest command.
    pub fn range(&self) -> (f64, f64) {
        self.points
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
                (low.min(p.1), high.max(p.1))
            })
    }

    /// The time at which the command leaves its first value and the time from which on it has its last,
    /// in s; `None` if it never changes.
    pub fn change_s(&self) -> Option<(f64, f64)> {
        let (first, last) = (self.points.first()?.1, self.points.last()?.1);
        let leaves = self.points.iter().position(|p| p.1 != first)?;
        let arrives = self
            .points
            .iter()
            .rposition(|p| p.1 != last)
            .map_or(leaves, |k| k + 1);
        Some((self.points[leaves - 1].0, self.points[arrives].0))
    }

    /// The stretches of time in which the command changes, in s: those less than `rest_s` apart are one.
    pub fn changes_s(&self, rest_s: f64) -> Vec<(f64, f64)> {
        let pairs = self.points.windows(2);
        let changing = pairs.filter(|pair| pair[0].1 != pair[1].1);
        join_stretches(changing.map(|pair| (pair[0].0, pair[1].0)), rest_s)
    }

    /// The text of the CSV file that [`CommandProfile::read_csv`] reads back to the same bits, unless the profile has a jump.
    pub fn to_csv(&self) -> String {
        let mut text = String::from("time_s,omega_v\n");
        for (time_s, omega_v) in &self.points {
            // Debug is the shortest form that reads back to the same bits.
            text.push_str(&format!("{time_s:?},{omega_v:?}\n"));
        }
        text
    }

    /// Reads a CSV file with the columns `time_s` and `omega_v`, in any order.
    ///
    /// # Errors
    /// An unreadable file, a missing column, a line that is no pair of finite numbers, times that do
    /// not increase, or no line at all.
    pub fn read_csv(path: &Path) -> Result<Self, ProfileError> {
        let error = |cause: String| ProfileError {
            path: path.display().to_string(),
            cause,
        };
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .comment(Some(b'#'))
            .from_path(path)
            .map_err(|e| error(e.to_string()))?;
        let header = reader.headers().map_err(|e| error(e.to_string()))?.clone();
        let column = |name: &str| {
            let mut of_that_name = (0..header.len()).filter(|&k| header.get(k) == Some(name));
            match (of_that_name.next(), of_that_name.next()) {
                (Some(column), None) => Ok(column),
                (Some(_), Some(_)) => Err(error(format!("the header has `{name}` twice"))),
                (None, _) => Err(error(format!("the header has no column `{name}`"))),
            }
        };
        let (time, omega_v) = (column("time_s")?, column("omega_v")?);
        let mut points: Vec<(f64, f64)> = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|e| error(e.to_string()))?;
            let line = record.position().map_or(0, csv::Position::line);
            let number = |index: usize, name: &str| {
                let text = record.get(index).unwrap_or("");
                text.parse::<f64>()
                    .ok()
                    .filter(|v| v.is_finite())
                    .ok_or_else(|| {
                        error(format!(
                            "line {line}: `{text}` is not a number (column `{name}`)"
                        ))
                    })
            };
            let point = (number(time, "time_s")?, number(omega_v, "omega_v")?);
            if points.last().is_some_and(|last| last.0 >= point.0) {
                return Err(error(format!(
                    "line {line}: time_s does not increase; for a jump of the command let it be a little later, as 8.0001 after 8"
                )));
            }
            points.push(point);
        }
        if points.is_empty() {
            return Err(error("it has no data lines".to_owned()));
        }
        Ok(Self { points })
    }
}
