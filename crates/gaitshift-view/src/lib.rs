//! The biped live in the browser: a server on the loopback address, its page, and replays in one file.
//!
//! The motion is computed here, in real time and at the body's full integration step, one session for each tab; the
//! page draws what it is sent. Page, styles and scripts are part of the program; nothing is fetched from anywhere.
//!
//! - [`Server`]: listens and serves a [`Show`]: a live stage, a run's folder, or a recording;
//! - [`Watched`]: a motion that another program moves;
//! - [`Stage`]: one or two controllers on their bodies under one slider, without any network;
//! - [`replay_html`]: a recording as one page that needs no server.

mod biped;
mod guard;
mod history;
mod message;
mod page;
mod replay;
mod run_folder;
mod save;
mod server;
mod socket;
mod stage;
mod watch;

pub use biped::Subject;
pub use history::History;
pub use message::Request;
pub use replay::replay_html;
pub use server::{Server, Show, Stopper, ViewError, ViewOptions};
pub use stage::Stage;
pub use watch::Watched;

/// Range of the command that the recipes train for, and the shipped controller was.
pub const RECIPES_RANGE: [f64; 2] = [-0.5, 3.5];

/// The widest range of the command in a curriculum; `None` without phases.
pub fn trained_range(curriculum: &gaitshift_task::Curriculum) -> Option<[f64; 2]> {
    let ranges = curriculum
        .phases
        .iter()
        .flat_map(|phase| [Some(phase.omega_v), phase.omega_v_end])
        .flatten();
    ranges.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
}
