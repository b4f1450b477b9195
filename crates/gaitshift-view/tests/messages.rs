//! Contract: whatever messages a page sends, in whatever order, the server stays up and goes on answering that page and the
//! next, unless it has ended the conversation as it says it does: after too many messages that it does not understand.
//!
//! Messages are valid ones with some numbers and words put in the place of others. `BOLERO_RANDOM_ITERATIONS` says how many
//! conversations are tried instead of the small number here.

use crate::common::{Socket, serve};
use bolero::TypeGenerator;
use std::time::Duration;

const VALID: [&str; 19] = [
    r#"{"type":"omega_v","value":1.5}"#,
    r#"{"type":"change","name":"run"}"#,
    r#"{"type":"change","name":"walk"}"#,
    r#"{"type":"change","name":"round"}"#,
    r#"{"type":"pause","on":true}"#,
    r#"{"type":"pause","on":false}"#,
    r#"{"type":"step","periods":3}"#,
    r#"{"type":"pace","value":0.5}"#,
    r#"{"type":"reset"}"#,
    r#"{"type":"push","force_n":[100,-50],"duration_s":0.1}"#,
    r#"{"type":"body","values":[["hip_mass_kg",25],["friction",0.5]]}"#,
    r#"{"type":"body","values":[["leg_length_m",0.9]]}"#,
    r#"{"type":"body","values":[["contact_stiffness",50000],["foot_sphere_count",12]]}"#,
    r#"{"type":"body","values":[]}"#,
    r#"{"type":"compare","on":true}"#,
    r#"{"type":"compare","on":false}"#,
    r#"{"type":"save","what":"recording","seconds":1,"biped":0}"#,
    r#"{"type":"save","what":"profile","seconds":2,"biped":1}"#,
    r#"{"type":"evaluation","step":1000}"#,
];

const OTHERS: [&str; 22] = [
    "0",
    "-1",
    "1",
    "3",
    "100",
    "0.01",
    "1e308",
    "-1e308",
    "1e-320",
    "1e999",
    "18446744073709551615",
    "18446744073709551616",
    "4294967296",
    "-0.0",
    "null",
    "true",
    "\"\\u0000\"",
    "[]",
    "{}",
    "gravity_m_per_s2",
    "stop_stiffness_n_per_m",
    "\u{1f9bf}",
];

#[derive(Debug, Clone, TypeGenerator)]
struct Message {
    valid: u8,
    /// Which word gives way to which other.
    changes: [Option<(u8, u8)>; 2],
    cut: Option<u8>,
}

impl Message {
    fn text(&self) -> String {
        let mut text = VALID[usize::from(self.valid) % VALID.len()].to_owned();
        for (word, other) in self.changes.iter().flatten() {
            let words = words(&text);
            let place = words[usize::from(*word) % words.len()].clone();
            text.replace_range(place, OTHERS[usize::from(*other) % OTHERS.len()]);
        }
        if let Some(at) = self.cut {
            let at = usize::from(at) % text.len();
            text.truncate(
                (0..=at)
                    .rev()
                    .find(|&k| text.is_char_boundary(k))
                    .unwrap_or(0),
            );
        }
        text
    }
}

/// Where numbers and names stand.
fn words(text: &str) -> Vec<std::ops::Range<usize>> {
    let inside = |c: char| c.is_alphanumeric() || "._-+".contains(c);
    let mut words: Vec<std::ops::Range<usize>> = Vec::new();
    for (k, c) in text.char_indices().filter(|&(_, c)| inside(c)) {
        match words.last_mut() {
            Some(word) if word.end == k => word.end = k + c.len_utf8(),
            _ => words.push(k..k + c.len_utf8()),
        }
    }
    if words.is_empty() {
        words.push(0..text.len());
    }
    words
}

#[test]
fn no_conversation_ends_the_server() {
    let address = serve();
    bolero::check!()
        .with_type::<[Message; 12]>()
        .with_iterations(300)
        .with_test_time(Duration::MAX)
        .for_each(move |messages: &[Message; 12]| {
            let texts: Vec<String> = messages.iter().map(Message::text).collect();
            let mut socket = Socket::open(address, "").unwrap();
            socket.hear_text("\"type\":\"bipeds\"").unwrap();
            for text in &texts {
                assert!(socket.say(text), "ended at {text}: {texts:#?}");
            }
            // Twelve are fewer than the wrong ones after which a page is sent away, so it is still heard.
            assert!(socket.say(r#"{"type":"change","name":"are you there"}"#));
            let answered = std::iter::from_fn(|| socket.hear())
                .take(10_000)
                .any(|(_, payload)| String::from_utf8_lossy(&payload).contains("are you there"));
            assert!(answered, "no answer after {texts:#?}");
        });
}
