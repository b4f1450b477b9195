//! Figures and animations of recorded gaits, drawn in software.
//!
//! Every picture is made from a [`Recording`](gaitshift_analysis::recording::Recording) or from plain
//! numbers and is the same on every machine: shapes and text are written as SVG, and pixels come from a
//! software renderer with a built-in font. No display is needed.
//!
//! - [`transition_figure`]: energies and speed over a change of gait, support phases shaded;
//! - [`animate`]: the body on its way, as a GIF;
//! - [`Frames`]: the same frame by frame, [`write_film`] and [`write_frames`] to files; [`Snapshot`]: a body at one instant;
//! - [`strobe`], [`strobe_within`]: a stride at a glance;
//! - [`sweep_figure`]: speed, cost of transport and support against the command;
//! - [`charts_figure`], [`bars_figure`]: panels of lines and points, bars made of parts;
//! - [`settings_figure`]: what several settings reached, seed by seed;
//! - [`episode_returns_figure`]: the course of a training run.
//!
//! Colours are safe for any colour vision. Right is vermilion and left is blue in all of them, and paler where both are drawn, so
//! that grey print tells them apart.
//!
//! ```
//! use gaitshift_figures::episode_returns_figure;
//! let figure = episode_returns_figure(&[1e3, 2e3, 3e3], &[40.0, 90.0, 700.0], &[0.0, 1.0, 3.0])?;
//! assert!(figure.svg.starts_with("<svg"));
//! # Ok::<(), gaitshift_figures::FigureError>(())
//! ```

mod animation;
mod biped;
mod canvas;
mod chart;
mod charts;
mod error;
mod figure;
mod film;
mod frames;
mod gif;
mod ground;
mod intervals;
mod learning;
mod legend;
mod motion;
mod raster;
mod scenery;
mod settings;
mod strobe;
mod style;
mod support;
mod sweep;
mod transition;

pub use animation::{AnimationOptions, animate};
pub use charts::{
    Bar, COLUMN_WIDTH, Chart, Drawn, PAGE_WIDTH, Series, bars_figure, charts_figure, phase_between,
};
pub use error::FigureError;
pub use figure::Figure;
pub use film::{FilmFormat, find_ffmpeg, write_film, write_frames};
pub use frames::{Frames, Picture, Snapshot};
pub use intervals::{IntervalPanel, IntervalPoint, intervals_figure};
pub use learning::{LearningCurves, episode_returns_figure, learning_curves_figure};
pub use settings::{Setting, settings_figure};
pub use strobe::{stride_at, strobe, strobe_within};
pub use sweep::{SweepPoint, SweepSeries, sweep_figure};
pub use transition::{FigureOptions, transition_figure};
