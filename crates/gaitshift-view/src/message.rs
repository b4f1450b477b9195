//! What page and server say to each other.

use crate::stage::{Change, Now, Stage};
use gaitshift_analysis::recording::{COLUMNS, column};
use serde::{Deserialize, Serialize};

/// Largest message that is read from a page, in bytes.
pub(crate) const MOST_BYTES: usize = 4096;

/// What a page asks for, as JSON with the key `type`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Request {
    /// Moves the slider.
    OmegaV {
        /// The command.
        value: f64,
    },
    /// A preset change of the command: `run`, `walk` or `round` (walk, run, walk).
    Change {
        /// Which.
        name: String,
    },
    /// Stops time, or lets it go on.
    Pause {
        /// Whether time stands still.
        on: bool,
    },
    /// Moves on by some control periods while time stands still.
    Step {
        /// How many, at most 100.
        periods: u32,
    },
    /// How fast time runs, 0.01 to 1.
    Pace {
        /// 1 is as in reality.
        value: f64,
    },
    /// Begins again from the start.
    Reset {},
    /// Pushes the hip.
    Push {
        /// Forward and up, in N.
        force_n: [f64; 2],
        /// How long, in s.
        duration_s: f64,
    },
    /// Changes parameters of the first body; an empty list takes all changes back.
    Body {
        /// Names and values, as in a body's TOML file.
        values: Vec<(String, f64)>,
    },
    /// The same controller beside it on the original body.
    Compare {
        /// Whether it is there.
        on: bool,
    },
    /// Asks for a file of the last seconds.
    Save {
        /// `recording`, `profile`, `picture`, `gif`, `mp4` or `page`.
        what: String,
        /// How long, in s.
        seconds: f64,
        /// Which biped, from 0.
        biped: usize,
    },
    /// Puts the controller of an evaluation of the run on the stage.
    Evaluation {
        /// The evaluation's environment step.
        step: u64,
    },
}

impl Request {
    /// Reads a message.
    ///
    /// # Errors
    /// What is wrong with it, in one sentence.
    pub fn read(text: &str) -> Result<Self, String> {
        if text.len() > MOST_BYTES {
            return Err(format!("a message has at most {MOST_BYTES} bytes"));
        }
        serde_json::from_str(text).map_err(|e| format!("the message is not understood: {e}"))
    }
}

impl Change {
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "run" => Some(Self::Run),
            "walk" => Some(Self::Walk),
            "round" => Some(Self::Round),
            _ => None,
        }
    }
}

/// What a page needs to know before the first sample, and again when it changes.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename = "bipeds")]
pub(crate) struct BipedsMessage<'a> {
    pub epoch: u32,
    pub control_period_s: f64,
    pub bipeds: Vec<BipedMessage<'a>>,
    /// Whether an MP4 can be made.
    pub films: bool,
    pub version: &'static str,
}

#[derive(Debug, Serialize)]
pub(crate) struct BipedMessage<'a> {
    pub name: &'a str,
    /// Points of the ground as (x, height), in m, where it is not flat.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ground: Option<&'a [[f64; 2]]>,
    pub trained: [f64; 2],
    pub body: &'a gaitshift_body::BodyParameters,
    pub given: &'a gaitshift_body::BodyParameters,
    pub weight_n: f64,
    /// Columns of the reward terms of one's own, which follow the others in its samples.
    pub own_columns: &'a [String],
}

impl<'a> BipedsMessage<'a> {
    pub fn of(stage: &'a Stage, films: bool) -> Self {
        let biped = |a: &'a crate::biped::Biped| {
            let body = a.parameters();
            BipedMessage {
                name: &a.subject.name,
                ground: None,
                trained: a.subject.trained,
                body,
                given: a.subject.body.parameters(),
                weight_n: body.total_mass_kg() * body.gravity_m_per_s2,
                own_columns: a.own_columns(),
            }
        };
        Self {
            epoch: stage.epoch,
            control_period_s: stage.control_period_s(),
            bipeds: stage.bipeds.iter().map(biped).collect(),
            films,
            version: env!("CARGO_PKG_VERSION"),
        }
    }
}

/// The figures beside the stage, several times a second.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename = "now")]
pub(crate) struct NowMessage {
    pub epoch: u32,
    pub omega_v: f64,
    pub paused: bool,
    pub pace: f64,
    /// Samples that were left out because the page read too slowly.
    pub dropped: u64,
    /// Time by which the motion lags behind the clock since it began, in s.
    pub behind_s: f64,
    pub bipeds: Vec<Now>,
}

/// Something to tell the user.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub(crate) enum Notice {
    Error { message: String },
    Saving { what: String },
}

/// Columns of a sample that follow its time, as 32-bit floats; then the push, forward and up in N.
pub(crate) fn sample_columns() -> Vec<gaitshift_analysis::recording::Column> {
    let mut columns = vec![column::X_M, column::Z_M, column::THETA_RAD];
    for side in 0..2 {
        columns.extend([
            column::PHI_RAD[side],
            column::H_M[side],
            column::D_M[side],
            column::W_M[side],
            column::TANGENTIAL_FORCE_N[side],
            column::NORMAL_FORCE_N[side],
        ]);
    }
    columns.extend([
        column::OMEGA_V,
        column::KINETIC_ENERGY_J,
        column::GRAVITATIONAL_ENERGY_J,
        column::ELASTIC_ENERGY_J,
        column::X_VELOCITY_M_PER_S,
        column::REWARD_ENERGY,
        column::REWARD_VELOCITY,
        column::REWARD_FORWARD,
        column::REWARD_ALIVE,
        column::REWARD_LEG,
        column::REWARD_FRICTION,
        column::REWARD_WORK,
    ]);
    columns
}

/// A binary message of samples: kind 1, biped, two bytes of nothing, epoch, number of samples (each 32 bits, little
/// endian), then for every sample the time in s as a 64-bit float, the columns, the push and the columns of one's own as
/// 32-bit floats.
#[derive(Debug)]
pub(crate) struct Samples {
    bytes: Vec<u8>,
    count: u32,
}

impl Samples {
    pub fn new(biped: usize, epoch: u32) -> Self {
        let mut bytes = vec![1, biped as u8, 0, 0];
        bytes.extend(epoch.to_le_bytes());
        bytes.extend(0_u32.to_le_bytes());
        Self { bytes, count: 0 }
    }

    /// Adds a row of a recording, with the columns of one's own after the others.
    pub fn push(
        &mut self,
        row: &[f64],
        push_n: [f64; 2],
        columns: &[gaitshift_analysis::recording::Column],
    ) {
        self.bytes.extend(row[column::TIME_S.index()].to_le_bytes());
        for column in columns {
            self.bytes
                .extend((row[column.index()] as f32).to_le_bytes());
        }
        for value in push_n.iter().chain(&row[COLUMNS.len()..]) {
            self.bytes.extend((*value as f32).to_le_bytes());
        }
        self.count += 1;
    }

    pub fn count(&self) -> u32 {
        self.count
    }

    pub fn finish(mut self) -> Vec<u8> {
        self.bytes[8..12].copy_from_slice(&self.count.to_le_bytes());
        self.bytes
    }
}

/// A binary message with a file: kind 2, length of the name, the name, the content.
pub(crate) fn file_message(name: &str, content: &[u8]) -> Vec<u8> {
    let name = &name.as_bytes()[..name.len().min(255)];
    let mut bytes = Vec::with_capacity(2 + name.len() + content.len());
    bytes.extend([2, name.len() as u8]);
    bytes.extend(name);
    bytes.extend(content);
    bytes
}
