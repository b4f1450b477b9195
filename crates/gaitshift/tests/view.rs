//! Contract: `gaitshift view` prints where its page is, serves it on the loopback address alone, and refuses what it cannot
//! show with one error.

use crate::common;
use crate::common::Place;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Stdio};

struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Starts the program and gives the host and port that it prints.
fn start(place: &Place, arguments: &str) -> (Running, String) {
    let mut child = place
        .command(arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap())
        .read_line(&mut line)
        .unwrap();
    let url = line.split(' ').next().unwrap();
    let host = url.trim_start_matches("http://").trim_end_matches('/');
    (Running(child), host.to_owned())
}

fn page(host: &str) -> String {
    let mut stream = TcpStream::connect(host).unwrap();
    let request = format!("GET / HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

#[test]
fn the_page_is_where_the_program_says() {
    let place = Place::new();
    let (_running, host) = start(&place, "view --no-open --port 0");
    assert!(host.starts_with("127.0.0.1:"), "{host}");
    assert!(page(&host).contains("data-mode=\"live\""));
    // The port is taken now.
    let port = host.rsplit(':').next().unwrap();
    place.refused(&format!("view --no-open --port {port}"), &["--port"]);
}

#[test]
fn a_recording_is_served_as_its_page() {
    let place = Place::new();
    place.write_toy_recording("toy.csv");
    let (_running, host) = start(&place, "view toy.csv --no-open --port 0");
    let served = page(&host);
    assert!(served.contains("data-mode=\"replay\""));
    let exported = place.stdout("export html toy.csv");
    assert!(
        served.ends_with(&exported),
        "the same page as `export html` writes"
    );
}

#[test]
fn what_cannot_be_shown_is_refused() {
    let place = Place::new();
    place.write("other.csv", "time,value\n0,1\n");
    place.write("body.toml", "hip_mass_kg = 30\n");
    place.write("wrong.toml", "hip_mass = 30\n");
    std::fs::create_dir(place.path("empty")).unwrap();
    place.write("tiny.toml", common::TINY);
    place.stdout("train tiny.toml --steps 1000 --out run --set task.control_period_s=0.02");
    for (arguments, words) in [
        ("view other.csv", ["other.csv", "recording"]),
        ("view missing.csv", ["missing.csv", ""]),
        ("view empty", ["empty", "config.toml"]),
        (
            "view --controller missing.safetensors",
            ["missing.safetensors", ""],
        ),
        ("view --body wrong.toml", ["wrong.toml", "hip_mass"]),
        (
            "view --body body.toml --body body.toml --body body.toml",
            ["two bipeds", "--body"],
        ),
        ("view --listen 192.0.2.1", ["192.0.2.1", "--listen"]),
        // Its page was announced, and perhaps opened, before it was refused.
        (
            "view --controller shipped --controller run/controller-last.safetensors",
            ["control period", "side by side"],
        ),
        (
            "view --name http://here:8/",
            ["http://here:8/", "host name"],
        ),
        ("view --name=", ["host name", ""]),
    ] {
        place.refused(arguments, &words);
    }
}
