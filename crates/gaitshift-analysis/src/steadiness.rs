//! How alike one stride is to the next: a gait that stumbles along has other steps every time.
//!
//! Times are finer than the rows: a touchdown's from the share of its control period in contact, a turn of the hip's from a
//! parabola through three rows. Rows of 10 ms alone would make every gait look unsteady by 1 %.

use std::f64::consts::TAU;

use crate::recording::{Recording, Side, Window, column, detail};
use crate::steps::Step;
use crate::{finite, ratio};

/// Fewest strides that have a spread.
const FEWEST: usize = 3;

/// How much the steps onto one foot differ from each other: standard deviations over means, 0 for steps all alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepVariation {
    /// Of their duration.
    pub time: Option<f64>,
    /// Of their length.
    pub length: Option<f64>,
}

impl StepVariation {
    /// Of the steps that end with the touchdown of `side`; nothing of fewer than three.
    pub fn find(recording: &Recording, steps: &[Step], side: Side) -> Self {
        let (times, lengths): (Vec<f64>, Vec<f64>) = steps
            .iter()
            .filter(|step| step.to == side)
            .map(|step| {
                let from = touchdown(recording, step.from, step.start_row);
                let to = touchdown(recording, step.to, step.end_row);
                (to.0 - from.0, to.1 - from.1)
            })
            .unzip();
        let variation = |values: &[f64]| {
            if values.len() < FEWEST {
                return None;
            }
            let deviation = crate::statistics::standard_deviation(values)?;
            ratio(deviation, crate::statistics::mean(values)?.abs())
        };
        Self {
            time: variation(&times),
            length: variation(&lengths),
        }
    }
}

/// Time in s and place of the hip in m at which a foot comes down whose contact begins with the period after `row`.
///
/// Without the share of contact within the period both are the row's.
fn touchdown(recording: &Recording, side: Side, row: usize) -> (f64, f64) {
    let (times, x_m) = (
        recording.column(column::TIME_S),
        recording.column(column::X_M),
    );
    let at = |row: usize| (times[row], x_m[row]);
    let Some(shares) = recording.detail(detail::CONTACT_SHARE[side.index()]) else {
        return at(row);
    };
    let Some(&share) = shares.get(row + 1) else {
        return at(row);
    };
    // A foot that is down for all of the period may have touched, too lightly to count, in the one before.
    let (end, share) = if share >= 1.0 && row > 0 {
        (row, shares[row])
    } else {
        (row + 1, share)
    };
    let (before, after) = (at(end - 1), at(end));
    let part = 1.0 - share.clamp(0.0, 1.0);
    (
        before.0 + part * (after.0 - before.0),
        before.1 + part * (after.1 - before.1),
    )
}

/// Phase of the left hip angle relative to the right one, over strides: π where the legs alternate evenly, 0 where they
/// swing together, as in a hop.
///
/// The point estimate of the coordination literature (F. J. Diedrich and W. H. Warren, J. Exp. Psychol.: Human Percept.
/// Perform. 21, 1995): where in the right leg's cycle, from one foremost hip angle to the next, the left leg has its own. It
/// asks for no contact, so that limping and dragging strides have one, too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HipPhase {
    /// Circular mean, in rad from 0 to 2π.
    pub mean_rad: f64,
    /// Circular standard deviation from stride to stride, `√(-2 ln R)`, in rad; its square is the variance.
    pub deviation_rad: f64,
    /// Strides with a phase: those in which the left leg swings foremost once.
    pub strides: usize,
}

impl HipPhase {
    /// Nothing with fewer than three strides that have a phase.
    pub fn find(recording: &Recording, window: Window) -> Option<Self> {
        let [right, left] = Side::BOTH.map(|side| foremost_s(recording, side, window));
        let phases: Vec<f64> = right
            .windows(2)
            .filter_map(|stride| {
                let from = left.partition_point(|&time_s| time_s < stride[0]);
                let to = left.partition_point(|&time_s| time_s < stride[1]);
                let once = to == from + 1;
                once.then(|| TAU * (left[from] - stride[0]) / (stride[1] - stride[0]))
            })
            .collect();
        if phases.len() < FEWEST {
            return None;
        }
        let count = phases.len() as f64;
        let cos = phases.iter().map(|phase| phase.cos()).sum::<f64>() / count;
        let sin = phases.iter().map(|phase| phase.sin()).sum::<f64>() / count;
        let length = cos.hypot(sin).min(1.0);
        Some(Self {
            mean_rad: finite(sin.atan2(cos).rem_euclid(TAU))?,
            deviation_rad: finite((-2.0 * length.ln()).max(0.0).sqrt())?,
            strides: phases.len(),
        })
    }
}

/// A leg whose hip angle varies by less than this does not swing, rad.
const LEAST_SWING_RAD: f64 = 0.05;
/// A swing goes this far beyond the middle of the hip angle's range, forward and back, as a share of the range.
const BEYOND_MIDDLE: f64 = 0.1;

/// Times at which a leg's hip angle is greatest in each swing forward, in s.
fn foremost_s(recording: &Recording, side: Side, window: Window) -> Vec<f64> {
    let phi = recording.column(column::PHI_RAD[side.index()]);
    let rows = window.start_row()..=window.end_row();
    let (least, most) = phi[rows.clone()].iter().fold(
        (f64::INFINITY, f64::NEG_INFINITY),
        |(least, most), &angle| (least.min(angle), most.max(angle)),
    );
    let range = most - least;
    let mut foremost = Vec::new();
    if !(range >= LEAST_SWING_RAD && range.is_finite()) {
        return foremost;
    }
    let middle = least + 0.5 * range;
    let (mut been_back, mut top) = (false, None);
    for row in rows {
        let beyond = (phi[row] - middle) / range;
        if beyond > BEYOND_MIDDLE && been_back {
            top = match top {
                Some(top) if phi[row] <= phi[top] => Some(top),
                _ => Some(row),
            };
        } else if beyond < -BEYOND_MIDDLE {
            // Only a swing that is over counts: what is cut off may go on rising.
            foremost.extend(top.take().map(|top| vertex_s(recording, phi, top)));
            been_back = true;
        }
    }
    foremost
}

/// Time of the vertex of the parabola through a row that is greater than its neighbours, and these, in s.
fn vertex_s(recording: &Recording, values: &[f64], top: usize) -> f64 {
    let times = recording.column(column::TIME_S);
    let (before, after) = (values[top - 1] - values[top], values[top + 1] - values[top]);
    let bend = before + after;
    let shift = if bend < 0.0 {
        (0.5 * (before - after) / bend).clamp(-0.5, 0.5)
    } else {
        0.0
    };
    let period_s = if shift < 0.0 {
        times[top] - times[top - 1]
    } else {
        times[top + 1] - times[top]
    };
    times[top] + shift * period_s
}
