//! From a recorded motion to science.
//!
//! A [`Recording`] is a table of time series; everything here is computed from it alone, so that any
//! simulator able to write one is judged by the same rules:
//!
//! - [`support`]: which feet bear weight when, touchdown and lift-off;
//! - [`steps`]: step frequency, step length, duty factor, symmetry;
//! - [`gait`]: walking, running, standing or neither, with the figures the verdict rests on;
//! - [`cost`]: cost of transport (8) and Froude number;
//! - [`energy`]: how kinetic, gravitational and elastic energy move relative to each other;
//! - [`flow`]: work and losses by element and leg, peak forces;
//! - [`steadiness`]: how alike steps are, and the phase between the hips;
//! - [`feet`]: how high feet swing, and how they rub the ground;
//! - [`mod@recent`]: what a motion is just now, for whoever watches it;
//! - [`summary`] and [`transition`]: all of it for a steady motion and for a change of gait;
//! - [`statistics`]: means, intervals and correlations, also for comparing many runs.
//!
//! A quantity that is undefined for a motion (the step length of one that takes no step) is `None`,
//! never NaN or zero.

pub mod cost;
pub mod energy;
pub mod feet;
pub mod files;
pub mod flow;
pub mod gait;
pub mod recent;
pub mod recording;
pub mod statistics;
pub mod steadiness;
pub mod steps;
pub mod summary;
pub mod support;
pub mod transition;

pub use files::{name_taken, write_whole};
pub use gait::{GaitClass, GaitRule};
pub use recent::{Recent, recent};
pub use recording::{Recording, RecordingMetadata, Side, Window};
pub use summary::{AnalysisOptions, GaitSummary, summarise};
pub use transition::{
    GaitChange, REST_S, TransitionOptions, TransitionSummary, changes_of_gait, command_changes,
    join_stretches, summarise_transition,
};

/// The value if it is a finite number: extreme but finite recordings can overflow in a ratio or a sum.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// `numerator / denominator` where that is a finite number.
fn ratio(numerator: f64, denominator: f64) -> Option<f64> {
    finite(numerator / denominator)
}
