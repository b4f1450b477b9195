//! Contract: the server answers its own page on its own name alone (DNS rebinding, foreign origins, tricks with paths get
//! nothing); malformed, huge and endless messages are answered or end the connection; hundreds of connections and pages
//! that never read cost bounded memory, and an honest page is served beside them and after them.

mod common;

use common::{Socket, ask, connect, get, serve, serve_show, status};
use gaitshift_view::Show;
use std::io::Write;
use std::time::{Duration, Instant};

#[test]
fn only_its_own_names_are_answered() {
    let address = serve();
    let port = address.port();
    for host in [
        format!("127.0.0.1:{port}"),
        format!("localhost:{port}"),
        format!("LOCALHOST:{port}"),
        format!("[::1]:{port}"),
        format!("biped.example:{port}"),
        "localhost".to_owned(),
    ] {
        let answer = get(address, "/", &host, "");
        assert_eq!(status(&answer), 200, "{host}: {answer}");
    }
    for host in [
        format!("evil.example:{port}"),
        format!("localhost.evil.example:{port}"),
        format!("127.0.0.1.evil.example:{port}"),
        "localhost:80:80".to_owned(),
        "localhost:port".to_owned(),
        format!("192.168.0.7:{port}"),
        format!("[::1:{port}"),
        format!("user@localhost:{port}"),
        String::new(),
    ] {
        let answer = get(address, "/", &host, "");
        assert!([400, 403].contains(&status(&answer)), "{host}: {answer}");
        assert!(!answer.contains("<html"), "{host}");
    }
    let no_host = ask(address, "GET / HTTP/1.0\r\n\r\n");
    assert_eq!(status(&no_host), 403, "{no_host}");
    let two = get(
        address,
        "/",
        &format!("localhost:{port}"),
        "Host: evil.example\r\n",
    );
    assert!([400, 403].contains(&status(&two)), "{two}");
}

#[test]
fn only_its_own_page_may_open_the_socket() {
    let address = serve();
    let own = format!("Origin: http://{address}\r\n");
    assert!(Socket::open(address, &own).is_ok());
    assert!(
        Socket::open(address, "").is_ok(),
        "a program sends no origin"
    );
    for origin in [
        "http://evil.example".to_owned(),
        "null".to_owned(),
        format!("https://{address}"),
        format!("http://{address}.evil.example"),
        "http://127.0.0.1:1".to_owned(),
    ] {
        let refused = Socket::open(address, &format!("Origin: {origin}\r\n"));
        assert_eq!(refused.err(), Some(403), "{origin}");
    }
    let twice = format!("{own}Origin: http://evil.example\r\n");
    assert_eq!(Socket::open(address, &twice).err(), Some(403));
}

#[test]
fn there_are_no_files_behind_the_paths() {
    let address = serve();
    let host = address.to_string();
    for path in [
        "/../../../../etc/passwd",
        "/..%2f..%2f..%2fetc%2fpasswd",
        "/%2e%2e/%2e%2e/etc/passwd",
        "//etc/passwd",
        "/page.css/../../Cargo.toml",
        "/page.js%00.html",
        "/C:\\Windows\\win.ini",
        "/run.json",
    ] {
        let answer = get(address, path, &host, "");
        assert_eq!(status(&answer), 404, "{path}: {answer}");
        assert!(!answer.contains("root:"), "{path}");
    }
    let long = format!("/{}", "a".repeat(2_000_000));
    let answer = get(address, &long, &host, "");
    assert!(
        [0, 400, 404, 414, 431].contains(&status(&answer)),
        "{}",
        status(&answer)
    );
    assert_eq!(status(&get(address, "/", &host, "")), 200);
}

#[test]
fn the_page_may_reach_nothing_but_this_server() {
    let address = serve();
    let answer = get(address, "/", &address.to_string(), "");
    assert!(answer.contains("default-src 'none'") && answer.contains("connect-src 'self'"));
    assert!(answer.contains("frame-ancestors 'none'"));
    let page = answer.split("\r\n\r\n").nth(1).unwrap();
    assert!(
        !page.contains("http://") && !page.contains("https://"),
        "nothing is fetched from elsewhere"
    );
}

#[test]
fn what_is_not_understood_is_answered_and_changes_nothing() {
    let address = serve();
    let mut socket = Socket::open(address, "").unwrap();
    socket.hear_text("\"type\":\"bipeds\"").unwrap();
    for message in [
        "",
        "{",
        "null",
        "[]",
        "{\"type\":\"unknown\"}",
        "{\"type\":\"omega_v\"}",
        "{\"type\":\"omega_v\",\"value\":1e999}",
        "{\"type\":\"omega_v\",\"value\":\"1\"}",
        "{\"type\":\"omega_v\",\"value\":1,\"more\":2}",
        "{\"type\":\"omega_v\",\"value\":101}",
        "{\"type\":\"pace\",\"value\":0}",
        "{\"type\":\"step\",\"periods\":4000000000}",
        "{\"type\":\"push\",\"force_n\":[1e308,1e308],\"duration_s\":1}",
        "{\"type\":\"push\",\"force_n\":[1,0],\"duration_s\":-1}",
        "{\"type\":\"body\",\"values\":[[\"time_step_s\",0.001]]}",
        "{\"type\":\"body\",\"values\":[[\"hip_mass_kg\",-1]]}",
        "{\"type\":\"body\",\"values\":[[\"foot_sphere_count\",1000000]]}",
        "{\"type\":\"body\",\"values\":[[\"../secret\",1]]}",
        "{\"type\":\"save\",\"what\":\"/etc/passwd\",\"seconds\":1,\"biped\":0}",
        "{\"type\":\"save\",\"what\":\"recording\",\"seconds\":1,\"biped\":9}",
        "{\"type\":\"save\",\"what\":\"gif\",\"seconds\":1e9,\"biped\":0}",
        "{\"type\":\"evaluation\",\"step\":1}",
    ] {
        assert!(socket.say(message));
        let answer = socket.hear_text("\"type\":\"error\"");
        assert!(answer.is_some(), "no answer to {message}");
    }
    assert!(socket.say("{\"type\":\"omega_v\",\"value\":1.5}"));
    socket
        .hear_text("\"omega_v\":1.5")
        .expect("it still listens");
}

#[test]
fn huge_broken_and_endless_messages_end_the_connection() {
    let address = serve();
    let open = || Socket::open(address, "").unwrap();
    let nested = "[".repeat(4000);
    let mut socket = open();
    assert!(socket.say(&nested));
    socket
        .hear_text("\"type\":\"error\"")
        .expect("deep nesting is an error");

    // One byte over the limit; a length that nobody has memory for; a message in endless pieces; no text; no mask.
    let mut socket = open();
    socket.say(&"x".repeat(4097));
    assert!(socket.ends());
    let mut socket = open();
    socket.frame(0x81, u64::MAX >> 1, b"x");
    assert!(socket.ends());
    let mut socket = open();
    socket.frame(0x01, 1000, &[b' '; 1000]);
    for _ in 0..10 {
        socket.frame(0x00, 1000, &[b' '; 1000]);
    }
    assert!(socket.ends());
    let mut socket = open();
    socket.frame(0x81, 2, &[0xff, 0xfe]);
    assert!(socket.ends());
    let mut socket = open();
    socket.stream.write_all(&[0x81, 0x02, b'{', b'}']).unwrap();
    assert!(socket.ends());
    let mut socket = open();
    socket.frame(0xf7, 0, b"");
    assert!(socket.ends());

    // Nonsense without end, and orders without end.
    let mut socket = open();
    while socket.say("nonsense") {
        if socket.hear_text("error").is_none() {
            break;
        }
    }
    assert!(socket.ends());
    let mut socket = open();
    for _ in 0..20_000 {
        if !socket.say("{\"type\":\"reset\"}") {
            break;
        }
    }
    assert!(socket.ends());

    let mut socket = open();
    socket
        .hear_text("\"type\":\"now\"")
        .expect("an honest page is served");
}

#[test]
fn hundreds_of_connections_are_served_or_refused() {
    let address = serve();
    let silent: Vec<_> = (0..400).map(|_| connect(address)).collect();
    drop(silent);
    let mut open = Vec::new();
    let mut refused = 0;
    for _ in 0..40 {
        match Socket::open(address, "") {
            Ok(socket) => open.push(socket),
            Err(status) => {
                assert!([0, 503].contains(&status), "{status}");
                refused += 1;
            }
        }
    }
    assert!(refused >= 20, "{} stages at a time", open.len());
    let mut first = open.remove(0);
    first
        .hear_text("\"type\":\"now\"")
        .expect("who has a stage is served");
    drop((first, open));
    // Places are given back.
    let end = Instant::now() + Duration::from_secs(20);
    loop {
        match Socket::open(address, "") {
            Ok(mut socket) => {
                socket.hear_text("\"type\":\"now\"").unwrap();
                break;
            }
            Err(_) => assert!(Instant::now() < end, "no place is ever given back"),
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[cfg(target_os = "linux")]
fn resident_kb() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|l| l.starts_with("VmRSS")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn a_page_that_never_reads_loses_frames_and_costs_no_memory() {
    let address = serve();
    let mut lazy: Vec<_> = (0..8).map(|_| Socket::open(address, "").unwrap()).collect();
    std::thread::sleep(Duration::from_secs(1));
    let before_kb = resident_kb();
    // Orders to save, which fill whatever buffer there is, and are never read.
    for _ in 0..20 {
        for socket in &mut lazy {
            socket.say("{\"type\":\"save\",\"what\":\"recording\",\"seconds\":60,\"biped\":0}");
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    std::thread::sleep(Duration::from_secs(3));
    let grown_kb = resident_kb().saturating_sub(before_kb);
    assert!(grown_kb < 64_000, "{grown_kb} kB more");
    let mut honest = Socket::open(address, "").unwrap();
    honest
        .hear_text("\"type\":\"now\"")
        .expect("an honest page is served beside them");
}

#[test]
fn a_page_alone_has_no_socket() {
    let address = serve_show(Show::Page("<!doctype html><p>replay".to_owned()));
    assert!(get(address, "/", &address.to_string(), "").contains("<p>replay"));
    assert_eq!(Socket::open(address, "").err(), Some(404));
}

// A report was taken for the end of a run that was only stopped.
#[test]
fn a_run_is_finished_when_its_report_says_so() {
    let run = tempfile::tempdir().unwrap();
    let address = serve_show(Show::Run(
        run.path().to_owned(),
        Box::new(common::subject()),
    ));
    let finished = || {
        let answer = get(address, "/run.json", &address.to_string(), "");
        assert_eq!(status(&answer), 200, "{answer}");
        answer.contains("\"finished\":true")
    };
    assert!(!finished());
    for (report, expected) in [
        ("{\"finished\": false}", false),
        ("{\"fini", false),
        ("{\"finished\": true}", true),
    ] {
        std::fs::write(run.path().join("report.json"), report).unwrap();
        assert_eq!(finished(), expected, "{report}");
    }
}
