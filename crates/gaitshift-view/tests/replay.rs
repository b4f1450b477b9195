//! Contract: a recording becomes one page that needs nothing else, whatever its controller is called; what cannot be drawn
//! is refused.

use crate::common::subject;
use gaitshift_view::{Stage, replay_html};

fn recording(seconds: f64) -> gaitshift_analysis::Recording {
    let mut stage = Stage::new(vec![subject()]);
    for _ in 0..(seconds / stage.control_period_s()) as u32 {
        stage.step();
    }
    stage.recording(0, seconds).unwrap()
}

#[test]
fn the_page_is_complete_small_and_fetches_nothing() {
    let html = replay_html(&recording(20.0)).unwrap();
    assert!(html.len() < 450_000, "{} bytes for 20 s", html.len());
    assert!(!html.contains("{{"), "every place is filled");
    for fetched in ["http://", "https://", "src=", "href="] {
        assert!(!html.contains(fetched), "{fetched}");
    }
    assert!(html.contains("\"walking\""));
}

#[test]
fn the_ground_of_the_recording_is_in_the_page() {
    let mut sloped = recording(1.0);
    assert!(replay_html(&sloped).unwrap().contains("\"ground\":null"));
    sloped.metadata.ground = Some(vec![[0.0, 0.0], [2.0, 0.25]]);
    let html = replay_html(&sloped).unwrap();
    assert!(html.contains("\"ground\":[[0.0,0.0],[2.0,0.25]]"));
    // What is no ground is not drawn.
    sloped.metadata.ground = Some(vec![[1.0, 0.0], [0.0, f64::NAN]]);
    assert!(replay_html(&sloped).unwrap().contains("\"ground\":null"));
}

#[test]
fn no_name_breaks_out_of_the_page() {
    let mut named = recording(1.0);
    named.metadata.controller = "</script><script>alert(1)</script>{{tail}}<!--".to_owned();
    let html = replay_html(&named).unwrap();
    let plain = replay_html(&recording(1.0)).unwrap();
    assert_eq!(
        html.matches("<script").count(),
        plain.matches("<script").count()
    );
    assert!(!html.contains("alert(1)</script>"));
}

#[test]
fn what_cannot_be_played_is_refused() {
    let short = replay_html(&Stage::new(vec![subject()]).recording(0, 1.0).unwrap());
    assert!(short.unwrap_err().contains("two rows"));
    let mut foreign = recording(1.0);
    foreign.metadata.body = serde_json::json!({"legs": 4});
    assert!(replay_html(&foreign).unwrap_err().contains("body"));
}
