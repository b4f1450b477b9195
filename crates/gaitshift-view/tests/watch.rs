//! Contract: a page that lags behind a motion of another program loses rows, but is told of the ground it goes on; one that
//! is opened between two steps shows the body where it is.

use crate::common::{Socket, serve_show};
use gaitshift_analysis::recording::{COLUMNS, RecordingMetadata, column};
use gaitshift_body::BodyParameters;
use gaitshift_view::{Show, Watched};
use std::time::Duration;

const SLOPE: [[f64; 2]; 2] = [[0.0, 0.0], [1.0, 0.1]];

fn metadata(body: &BodyParameters, ground: Option<Vec<[f64; 2]>>) -> RecordingMetadata {
    RecordingMetadata {
        control_period_s: 0.01,
        total_mass_kg: body.total_mass_kg(),
        gravity_m_per_s2: body.gravity_m_per_s2,
        leg_length_m: body.leg_length_m,
        body: serde_json::Value::Null,
        controller: "another program".to_owned(),
        seed: 0,
        fell: false,
        ended_by: String::new(),
        disturbance: None,
        ground,
    }
}

#[test]
fn a_page_that_lags_behind_is_told_of_a_new_ground() {
    let body = BodyParameters::default();
    let watched = Watched::new("another program", &body, metadata(&body, None), Vec::new());
    let mut page = Socket::open(serve_show(Show::Watched(watched.clone())), "").unwrap();
    let first = page.hear_text("\"type\":\"bipeds\"").unwrap();
    assert!(first.contains("\"epoch\":0") && !first.contains("\"ground\":"));
    // More than the connection holds while nothing is read, then a beginning, then more than waits for a slow page.
    let row = vec![0.0; COLUMNS.len()];
    for k in 0..100_000 {
        watched.push(&row);
        // The server sends what there is.
        if k % 200 == 0 {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
    watched.begin(&body, metadata(&body, Some(SLOPE.to_vec())));
    for _ in 0..1000 {
        watched.push(&row);
    }
    let told = page.hear_text("\"epoch\":1,\"control_period_s\"");
    assert!(told.is_some_and(|t| t.contains("[1.0,0.1]")));
}

#[test]
fn a_page_opened_between_two_steps_shows_where_the_body_is() {
    let body = BodyParameters::default();
    let watched = Watched::new("another program", &body, metadata(&body, None), Vec::new());
    let mut row = vec![0.0; COLUMNS.len()];
    for x_m in [1.0, 2.5] {
        row[column::X_M.index()] = x_m;
        watched.push(&row);
    }
    let mut page = Socket::open(serve_show(Show::Watched(watched)), "").unwrap();
    page.hear_text("\"type\":\"bipeds\"").unwrap();
    let sample = loop {
        let (opcode, payload) = page.hear().unwrap();
        if opcode == 2 {
            break payload;
        }
    };
    let value = 2.5_f32.to_le_bytes();
    assert!(sample.windows(4).any(|bytes| bytes == value));
}
