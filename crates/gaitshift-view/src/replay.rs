//! A recording as one page with play and scrub that needs no server and fetches nothing.

use crate::message::sample_columns;
use crate::page;
use crate::stage::phase_code;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gaitshift_analysis::recording::{Column, Recording, column, is_extra};
use gaitshift_analysis::support::Support;
use gaitshift_analysis::{GaitClass, GaitRule, recent};
use gaitshift_body::BodyParameters;
use serde::Serialize;

/// Time between two sets of figures, in s.
const FIGURES_EVERY_S: f64 = 0.1;
/// How long before its end a motion that fell is called fallen, in s.
const FALL_SHOWN_S: f64 = 0.2;

/// What a term of the reward is rounded to.
const REWARD_RESOLUTION: f64 = 1e-3;

/// A time series in whole multiples of what the eye can tell apart.
#[derive(Debug, Serialize)]
struct Series {
    offset: f64,
    resolution: f64,
    /// Bytes of a value, 2 or 4, little endian with a sign.
    width: u8,
    data: String,
}

#[derive(Debug, Serialize)]
struct Replay {
    controller: String,
    control_period_s: f64,
    body: BodyParameters,
    weight_n: f64,
    /// Points `[x, z]`, m; none where it is flat.
    ground: Option<Vec<[f64; 2]>>,
    time_s: Series,
    columns: Vec<Series>,
    /// The last columns, of the reward terms of one's own.
    own_columns: Vec<String>,
    /// Kind, begin and end in s.
    phases: Vec<(u8, f64, f64)>,
    figures: Vec<Figures>,
    version: &'static str,
}

/// Time in s, gait, speed in m/s, Froude number, cost of transport.
#[derive(Debug, Serialize)]
struct Figures(f64, GaitClass, Option<f64>, Option<f64>, Option<f64>);

/// A recording as one HTML page: the biped, play and scrub, and the same strips as beside the live stage.
///
/// # Errors
/// A recording of fewer than two rows, or one that does not say what its body is.
pub fn replay_html(recording: &Recording) -> Result<String, String> {
    if recording.len() < 2 {
        return Err("the recording has fewer than two rows: there is nothing to play".to_owned());
    }
    let body: BodyParameters = serde_json::from_value(recording.metadata.body.clone())
        .map_err(|e| format!("the recording does not describe its body ({e}); record the motion anew with this program"))?;
    body.validate().map_err(|e| e.to_string())?;
    let metadata = &recording.metadata;
    let weight_n = metadata.total_mass_kg * metadata.gravity_m_per_s2;
    let support = Support::find(recording, &GaitRule::default().contact);
    let mut columns: Vec<Series> = sample_columns()
        .into_iter()
        .map(|column| series(recording.column(column), resolution(column)))
        .collect();
    // No push is recorded.
    let nothing = vec![0.0; recording.len()];
    columns.extend([series(&nothing, 1.0), series(&nothing, 1.0)]);
    let mut own_columns = Vec::new();
    for (name, values) in recording.every_column().filter(|(name, _)| is_extra(name)) {
        own_columns.push(name.to_owned());
        columns.push(series(values, REWARD_RESOLUTION));
    }
    let replay = Replay {
        controller: metadata.controller.clone(),
        control_period_s: metadata.control_period_s,
        weight_n,
        ground: metadata.ground_to_draw().map(<[_]>::to_vec),
        time_s: series(recording.column(column::TIME_S), 1e-5),
        columns,
        own_columns,
        phases: support
            .phases()
            .iter()
            .map(|p| (phase_code(p.phase), round(p.start_s), round(p.end_s)))
            .collect(),
        figures: figures(recording, &support),
        body,
        version: env!("CARGO_PKG_VERSION"),
    };
    let data = serde_json::to_string(&replay).map_err(|e| e.to_string())?;
    Ok(page::replay_page(
        &format!("gaitshift: {}", metadata.controller),
        &data,
    ))
}

fn round(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

fn figures(recording: &Recording, support: &Support) -> Vec<Figures> {
    let rule = GaitRule::default();
    let times = recording.column(column::TIME_S);
    let last_s = times[times.len() - 1];
    let mut figures = Vec::new();
    let mut next_s = f64::NEG_INFINITY;
    for (row, &time_s) in times.iter().enumerate() {
        if time_s < next_s {
            continue;
        }
        next_s = time_s + FIGURES_EVERY_S - 1e-9;
        let now = recent(recording, support, &rule, row);
        let fallen = recording.metadata.fell && time_s > last_s - FALL_SHOWN_S;
        let gait = if fallen { GaitClass::Fallen } else { now.gait };
        figures.push(Figures(
            round(time_s),
            gait,
            now.speed_m_per_s.map(round),
            now.froude.map(round),
            now.cost_of_transport.map(round),
        ));
    }
    figures
}

/// What a value is rounded to: a tenth of a millimetre, of a milliradian, a tenth of a newton or joule.
fn resolution(column: Column) -> f64 {
    let name = column.name();
    if name.ends_with("_n") || name.ends_with("_j") {
        0.1
    } else if name.starts_with("reward") || name == "omega_v" {
        REWARD_RESOLUTION
    } else {
        1e-4
    }
}

fn series(values: &[f64], resolution: f64) -> Series {
    let (low, high) = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &v| {
            (low.min(v), high.max(v))
        });
    let offset = 0.5 * (low + high);
    // Wild motions are drawn more coarsely, not wrapped around.
    let resolution = resolution.max((high - low) / 4e9);
    let width = if (high - low) / resolution < 65_000.0 {
        2
    } else {
        4
    };
    let whole = values
        .iter()
        .map(|v| ((v - offset) / resolution).round() as i32);
    let bytes: Vec<u8> = if width == 2 {
        whole.flat_map(|v| (v as i16).to_le_bytes()).collect()
    } else {
        whole.flat_map(i32::to_le_bytes).collect()
    };
    Series {
        offset,
        resolution,
        width,
        data: STANDARD.encode(bytes),
    }
}
