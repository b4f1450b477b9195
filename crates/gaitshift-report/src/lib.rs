//! The study in one page: controllers measured as the paper and its journal version measured theirs, and beyond; every claim
//! beside what was found; every figure.
//!
//! - [`Subject`]: a controller, the seed it was trained with, and what it is a seed of;
//! - [`Plan`] and [`Study`]: what is measured, and what was found, of one subject;
//! - [`judge_claims`]: the papers' claims with verdicts that are computed;
//! - [`write_report`]: the page, its figures and its numbers, measured on several threads;
//! - [`study_experiments`]: the training runs of the study; [`recorded_experiments`]: what those that were run showed.
//!
//! Nothing is random but starts and noise, which seeds draw: the same subjects and plan give the same files, byte for byte.

mod claims;
mod episodes;
mod error;
mod experiments;
mod figures;
mod group;
mod headline;
mod page;
mod recorded;
mod return_map;
mod seeds;
mod source;
mod study;
mod subject;
mod table;
mod trace;
mod write;

pub use claims::{Finding, Judged, Verdict, judge_claims};
pub use episodes::{Episodes, Stretch};
pub use error::ReportError;
pub use experiments::{StudyLearner, study_experiments};
pub use headline::{HeadlineNumber, headline_numbers};
pub use recorded::{RecordedExperiment, recorded_experiments};
pub use return_map::{Differences, ReturnMap, Section, spectral_radius};
pub use study::{
    Change, Landing, Measured, NoiseTolerance, Plan, StartedMotion, Steady, StepHeight, Study,
    set_program_file,
};
pub use subject::Subject;
pub use table::Table;
pub use trace::{Trace, TraceRow};
pub use write::{Work, write_report};
