//! `gaitshift render`: which pictures are drawn where, and bad input. What they show is tested with the
//! figures themselves.

use crate::common::Place;

fn place_with_recording() -> Place {
    let place = Place::new();
    place.write_toy_recording("toy.csv");
    place
}

#[test]
fn both_pictures_are_drawn_beside_the_recording() {
    let place = place_with_recording();
    let text = place.stdout("render toy.csv --from-s 1 --to-s 2 --fps 10 --width 200");
    assert!(place.read("toy.gif").starts_with(b"GIF89a"));
    assert!(place.read("toy-stride.svg").starts_with(b"<svg"));
    assert!(place.read("toy-stride.png").starts_with(b"\x89PNG"));
    for name in ["toy.gif", "toy-stride.svg", "toy-stride.png"] {
        assert!(text.contains(&format!("wrote {name}")), "{text}");
    }
}

#[test]
fn the_ending_of_the_file_says_which_picture_is_drawn() {
    let place = place_with_recording();
    let names = || {
        let entries = std::fs::read_dir(place.path("out")).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    };
    place.stdout("render toy.csv --out out/move.gif --to-s 1 --fps 5 --width 160");
    assert_eq!(names(), ["move.gif"]);
    place.stdout("render toy.csv --out out/stride.svg --stride-at-s 3 --poses 4");
    assert_eq!(names(), ["move.gif", "stride.svg"]);
    place.stdout("render toy.csv --out out --strobe");
    assert_eq!(
        names(),
        ["move.gif", "stride.svg", "toy-stride.png", "toy-stride.svg"]
    );
}

// `--out move.mp4` made a folder of that name and reported success.
#[test]
fn a_kind_of_file_that_is_not_written_is_refused() {
    let place = place_with_recording();
    for name in ["move.avi", "stride.pdf", "out/stride.jpg", "x.MKV"] {
        let words = [name, ".gif", ".svg"];
        place.refused(&format!("render toy.csv --out {name}"), &words);
        assert!(!place.path(name).exists());
    }
    // Frames made a folder of a film's name.
    place.refused(
        "render toy.csv --frames --out new.gif",
        &["new.gif", "folder"],
    );
    assert!(!place.path("new.gif").exists());
    let quick = "--strobe --stride-at-s 3 --poses 2";
    for folder in ["folder.mp4/", "version-1.5", "a.folder"] {
        place.stdout(&format!("render toy.csv --out {folder} {quick}"));
        assert!(place.path(folder).join("toy-stride.svg").exists());
    }
    // One that is there is a folder, whatever it is called.
    place.stdout(&format!("render toy.csv --out folder.mp4 {quick}"));
}

#[test]
fn the_same_recording_gives_the_same_pictures() {
    let place = place_with_recording();
    for folder in ["one", "two"] {
        place.stdout(&format!(
            "render toy.csv --out {folder} --from-s 2 --to-s 3 --fps 5 --width 160"
        ));
    }
    for name in ["toy.gif", "toy-stride.svg", "toy-stride.png"] {
        assert_eq!(
            place.read(&format!("one/{name}")),
            place.read(&format!("two/{name}"))
        );
    }
}

// A new recording of the same name stood beside the pictures of the old one.
#[test]
fn pictures_of_a_recording_that_is_replaced_do_not_stay() {
    let place = Place::new();
    let evaluate = "evaluate --omega-v 3 --duration-s 3 --out out";
    place.stdout(evaluate);
    place.stdout("render out/omega_v_3.csv --fps 5 --width 160");
    place.write("out/mine.png", "mine");
    let pictures = [
        "omega_v_3.gif",
        "omega_v_3-stride.svg",
        "omega_v_3-stride.png",
    ];
    let there = || pictures.map(|name| place.path("out").join(name).exists());
    assert_eq!(there(), [true; 3]);
    // The same motion again: the pictures still show it.
    place.stdout(evaluate);
    assert_eq!(there(), [true; 3]);
    let output = place.output(&format!("{evaluate} --seed 1"));
    assert_eq!(there(), [false; 3]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("omega_v_3.gif"));
    assert!(place.path("out/mine.png").exists());
}

#[test]
fn a_motion_without_a_stride_is_still_animated() {
    let place = Place::new();
    place.stdout("evaluate --omega-v 0 --duration-s 0.5 --out .");
    let output = place.output("render omega_v_0.csv --fps 5 --width 160");
    assert_eq!(output.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&output.stderr).contains("no picture of a stride"));
    assert!(place.path("omega_v_0.gif").exists());
    place.refused(
        "render omega_v_0.csv --strobe",
        &["no whole stride", "--stride-at-s", "--to-s"],
    );
}

// Of a fall there was no still. It is on the ground after 0.3 s, where the recording ends.
#[test]
fn a_time_that_is_no_stride_is_drawn_where_it_is_asked_for() {
    let place = Place::new();
    place.stdout("evaluate --omega-v 0 --duration-s 6 --push 600@4 --out .");
    let still = "render omega_v_0.csv --out fall.svg --from-s 4 --to-s 4.6 --poses 4";
    place.stdout(still);
    let svg = String::from_utf8(place.read("fall.svg")).unwrap();
    assert!(svg.contains("a pose every 0.10 s"), "{svg}");
    // With the animation, or a stride asked for, it is the stride.
    place.stdout("render omega_v_0.csv --from-s 1 --to-s 3 --fps 5 --width 160 --out both");
    place.stdout("render omega_v_0.csv --out stride.svg --stride-at-s 2");
    assert_eq!(
        place.read("both/omega_v_0-stride.svg"),
        place.read("stride.svg")
    );
}

#[test]
fn a_bad_recording_is_refused() {
    let place = place_with_recording();
    let whole = String::from_utf8(place.read("toy.csv")).unwrap();
    place.write("cut.csv", &whole[..whole.len() / 2]);
    place.write("other.csv", "time,value\n0,1\n");
    place.write("binary.csv", b"\xff\x00\x01");
    place.write("empty.csv", "");
    place.write("nan.csv", whole.replacen("\n0.0,", "\nnan,", 1));
    for name in [
        "cut.csv",
        "other.csv",
        "binary.csv",
        "empty.csv",
        "nan.csv",
        "absent.csv",
        ".",
    ] {
        place.refused(&format!("render {name}"), &[name]);
    }
}

#[test]
fn options_out_of_range_are_refused() {
    let place = place_with_recording();
    for (arguments, word) in [
        ("--from-s 50", "0 s to 6 s"),
        // A clock may begin below 0: what is refused is said of the recording.
        ("--from-s -2 --to-s -1", "0 s to 6 s"),
        ("--from-s nan", "--from-s"),
        ("--from-s 3 --to-s 2", "time range"),
        ("--fps 0", "fps"),
        ("--fps 1000", "fps"),
        ("--width 1", "width"),
        ("--slow-motion 0", "--slow-motion"),
        ("--poses 1 --strobe", "poses"),
        ("--stride-at-s 100", "--stride-at-s"),
        ("--strobe --out x.gif", ".svg"),
        // Nothing was said of what is not drawn.
        ("--out s.svg --fps 20 --width 320", "--fps and --width"),
        ("--strobe --slow-motion 2", "--slow-motion"),
        ("--out s.gif --poses 30", "--poses"),
        ("--frames --out frames --poses 7", "--poses"),
        // An error was said and the exit code was 0.
        ("--poses 1", "poses"),
        ("--poses 61", "poses"),
    ] {
        place.refused(&format!("render toy.csv {arguments}"), &[word]);
    }
    // An empty folder was left.
    place.refused("render toy.csv --from-s 50 --out new", &["0 s to 6 s"]);
    assert!(!place.path("new").exists());
}

#[test]
fn frames_are_numbered_pictures_of_the_asked_size_with_or_without_background() {
    let place = place_with_recording();
    place.stdout("render toy.csv --out frames --frames --fps 10 --to-s 0.3 --width 320");
    let frame = |folder: &str, k: u32| place.read(&format!("{folder}/frame-{k:05}.png"));
    assert!(!place.path("frames/frame-00004.png").exists());
    // A shorter film leaves no frames of a longer one behind it.
    place.stdout("render toy.csv --out fewer --frames --fps 10 --to-s 0.3 --width 320");
    place.stdout("render toy.csv --out fewer --frames --fps 10 --to-s 0.1 --width 320");
    assert!(place.path("fewer/frame-00001.png").exists());
    assert!(!place.path("fewer/frame-00002.png").exists());
    // Width, height and colour type stand in the first block of a PNG.
    let size = |png: &[u8]| {
        let number =
            |at: usize| u32::from_be_bytes([png[at], png[at + 1], png[at + 2], png[at + 3]]);
        (number(16), number(20))
    };
    assert_eq!(size(&frame("frames", 3)), (320, 200));
    assert_ne!(frame("frames", 0), frame("frames", 3));
    place
        .stdout("render toy.csv --out bare --frames --fps 10 --to-s 0.3 --width 320 --transparent");
    assert_ne!(frame("frames", 0), frame("bare", 0));
    place.refused("render toy.csv --frames", &["--out"]);
    place.refused("render toy.csv --out x.mp4 --transparent", &[".webm"]);
    place.refused(
        "render toy.csv --out frames --frames --fps 500",
        &["fps", "240"],
    );
}

#[test]
fn films_are_made_by_the_ffmpeg_that_is_found_or_say_what_to_do() {
    let place = place_with_recording();
    let without = place
        .command("render toy.csv --out film.mp4 --to-s 0.3 --width 160")
        .env("PATH", "")
        .output()
        .unwrap();
    assert_eq!(without.status.code(), Some(1));
    let said = String::from_utf8_lossy(&without.stderr);
    for part in [
        "film.mp4",
        "apt-get install ffmpeg",
        "--frames",
        "-framerate 60",
    ] {
        assert!(said.contains(part), "{said}");
    }
    if gaitshift_figures::find_ffmpeg().is_none() {
        return;
    }
    place.stdout("render toy.csv --out film.mp4 --to-s 0.3 --width 160");
    assert_eq!(&place.read("film.mp4")[4..8], b"ftyp");
    place.stdout("render toy.csv --out film.webm --to-s 0.3 --width 160 --transparent");
    assert_eq!(place.read("film.webm")[..4], [0x1a, 0x45, 0xdf, 0xa3]);
    place.refused("render toy.csv --out film.mp4 --strobe", &["--strobe"]);
}
