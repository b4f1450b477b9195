//! The animation shows the asked time at the asked pace, moves what moves and leaves the rest alone
//! (no flicker), and is small enough for a page.

use crate::common;
use crate::common::keep;
use gaitshift_analysis::recording::{COLUMNS, Column, Recording, column};
use gaitshift_figures::{AnimationOptions, FigureError, animate};

/// A decoded GIF: frames as a viewer shows them.
struct Film {
    width: usize,
    height: usize,
    delays_cs: Vec<u16>,
    frames: Vec<Vec<[u8; 3]>>,
}

impl Film {
    fn decode(file: &[u8]) -> Self {
        let mut decoder = gif::DecodeOptions::new().read_info(file).unwrap();
        let (width, height) = (usize::from(decoder.width()), usize::from(decoder.height()));
        let palette: Vec<[u8; 3]> = decoder
            .global_palette()
            .unwrap()
            .chunks_exact(3)
            .map(|rgb| [rgb[0], rgb[1], rgb[2]])
            .collect();
        let mut film = Self {
            width,
            height,
            delays_cs: Vec::new(),
            frames: Vec::new(),
        };
        let mut shown = vec![None; width * height];
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            assert!(frame.palette.is_none(), "one palette for all frames");
            for (i, &index) in frame.buffer.iter().enumerate() {
                let x = usize::from(frame.left) + i % usize::from(frame.width);
                let y = usize::from(frame.top) + i / usize::from(frame.width);
                if Some(index) != frame.transparent {
                    shown[y * width + x] = Some(palette[usize::from(index)]);
                }
            }
            film.delays_cs.push(frame.delay);
            let covered = "the first frame covers the whole picture";
            film.frames
                .push(shown.iter().map(|pixel| pixel.expect(covered)).collect());
        }
        film
    }

    fn of(recording: &Recording, options: &AnimationOptions) -> Self {
        Self::decode(&animate(recording, options).unwrap())
    }

    /// Pixel at a place in user units (the picture is 640 by 400 of them).
    fn at(&self, frame: usize, x: usize, y: usize) -> [u8; 3] {
        let scale = |units: usize| units * self.width / 640;
        self.frames[frame][scale(y) * self.width + scale(x)]
    }
}

/// Small and short, to be quick.
fn quick() -> AnimationOptions {
    AnimationOptions {
        from_s: Some(2.6),
        to_s: Some(3.8),
        fps: 10.0,
        ..Default::default()
    }
}

#[test]
fn a_whole_gait_change_is_small_enough_for_a_page() {
    let options = AnimationOptions {
        to_s: Some(6.0),
        fps: 20.0,
        ..Default::default()
    };
    let file = animate(&common::transition(), &options).unwrap();
    keep("transition.gif", &file);
    assert!(file.len() < 2_000_000, "{} bytes", file.len());
    let film = Film::decode(&file);
    assert_eq!((film.width, film.height), (640, 400));
    assert_eq!(film.frames.len(), 121);
}

#[test]
fn frames_and_delays_follow_the_pace() {
    let recording = common::transition();
    let film = Film::of(&recording, &quick());
    assert_eq!(film.frames.len(), 13);
    assert!(film.delays_cs.iter().all(|&delay| delay == 10));

    let slow = AnimationOptions {
        slow_motion: 4.0,
        width_px: 200,
        ..quick()
    };
    let film = Film::of(&recording, &slow);
    assert_eq!(film.frames.len(), 4 * 12 + 1);
    assert_eq!((film.width, film.height), (200, 125));

    // 30 frames a second are not a whole number of hundredths each; the error must not add up.
    let uneven = AnimationOptions {
        fps: 30.0,
        width_px: 160,
        ..quick()
    };
    let film = Film::of(&recording, &uneven);
    let total: u16 = film.delays_cs.iter().take(30).sum();
    assert_eq!(total, 100);
}

#[test]
fn everything_that_should_move_moves_and_the_rest_does_not() {
    let film = Film::of(&common::transition(), &quick());
    let last = film.frames.len() - 1;
    for pair in film.frames.windows(2) {
        assert_ne!(pair[0], pair[1], "the body moves from frame to frame");
    }
    // The knob: its middle is white, the groove under it grey and, once passed, green.
    let white = [0xff; 3];
    let (low_end, middle, high_end) = ((58, 40), (158, 40), (258, 40));
    assert_eq!(film.at(0, low_end.0, low_end.1), white);
    assert_eq!(film.at(0, middle.0, middle.1), [0xdc; 3]);
    assert_eq!(film.at(last, middle.0, middle.1), [0x00, 0x80, 0x60]);
    assert_eq!(film.at(last, high_end.0, high_end.1), white);
    // Sky and soil keep exactly their colours in every frame.
    for frame in 0..film.frames.len() {
        assert_eq!(film.at(frame, 5, 5), white);
        assert_eq!(film.at(frame, 2, 321), [0xec, 0xe7, 0xdf]);
    }
}

#[test]
fn legs_have_their_own_colours_in_every_frame() {
    let film = Film::of(&common::transition(), &quick());
    for frame in &film.frames {
        // Above the timeline, which has the same colours.
        let body = &frame[80 * film.width..300 * film.width];
        // The left leg is paler: in grey print the two colours alone are one.
        for ink in [[0xd5, 0x5e, 0x00], [0x8c, 0xc0, 0xdc]] {
            let pixels = body.iter().filter(|&&pixel| pixel == ink).count();
            assert!(pixels > 500, "{ink:?}: {pixels} pixels");
        }
    }
}

#[test]
fn forces_are_drawn_only_on_feet_that_carry() {
    let black = |film: &Film, frame: usize| {
        let body = &film.frames[frame][80 * film.width..300 * film.width];
        body.iter().filter(|&&pixel| pixel == [0x11; 3]).count()
    };
    let options = AnimationOptions {
        from_s: Some(0.0),
        to_s: Some(0.0),
        ..quick()
    };
    let standing = Film::of(&common::toy(0.5, |_| 0.0), &options);
    let hanging = Film::of(&common::motionless(50), &options);
    assert!(black(&standing, 0) > 50);
    assert_eq!(black(&hanging, 0), 0);
}

#[test]
fn the_same_recording_gives_the_same_file() {
    let recording = common::transition();
    let options = AnimationOptions {
        width_px: 160,
        ..quick()
    };
    assert_eq!(
        animate(&recording, &options).unwrap(),
        animate(&recording, &options).unwrap()
    );
}

/// The recording, told to begin at `start_s`.
fn beginning_at(recording: &Recording, start_s: f64) -> Recording {
    let mut late = Recording::new(recording.metadata.clone());
    for row in 0..recording.len() {
        let mut values: Vec<f64> = COLUMNS
            .iter()
            .map(|name| recording.column(Column::named(name).unwrap())[row])
            .collect();
        values[column::TIME_S.index()] += start_s;
        late.push_row(&values).unwrap();
    }
    late
}

// An animation from 8 s to 14 s counted from 0, so that no moment of it could be found in the figure.
#[test]
fn the_time_shown_is_the_recordings() {
    let recording = common::toy(0.5, |_| 0.0);
    let options = |from_s: f64| AnimationOptions {
        from_s: Some(from_s),
        to_s: Some(from_s + 0.4),
        ..quick()
    };
    let early = Film::of(&recording, &options(0.0));
    let late = Film::of(&beginning_at(&recording, 88.0), &options(88.0));
    let differing: Vec<usize> = (0..early.frames[0].len())
        .filter(|&i| {
            // The palettes may differ by shades.
            let shades = early.frames[0][i].iter().zip(late.frames[0][i]);
            shades.map(|(a, b)| a.abs_diff(b)).max() > Some(60)
        })
        .collect();
    // Nothing but the time, at the lower right.
    assert!(differing.len() > 10);
    for i in differing {
        let (x, y) = (i % early.width, i / early.width);
        assert!(x > 560 && y > 385, "{x}, {y}");
    }
}

// The word went blank while the gait changed.
#[test]
fn the_gait_has_a_name_while_it_changes() {
    // Steps of a gait between walking and running, neither of them.
    let recording = common::toy(9.0, |t| ((t - 3.0) / 3.0).clamp(0.0, 1.0));
    let options = AnimationOptions {
        from_s: Some(2.0),
        to_s: Some(7.0),
        fps: 10.0,
        ..Default::default()
    };
    let film = Film::of(&recording, &options);
    for frame in &film.frames {
        // Where the gait stands, between the knob and the speed.
        let written = (20..47).any(|y| (296..440).any(|x| frame[y * film.width + x] != [0xff; 3]));
        assert!(written);
    }
}

#[test]
fn poor_recordings_are_drawn() {
    let options = AnimationOptions {
        width_px: 160,
        ..Default::default()
    };
    for (recording, frames) in [
        (common::short(1), 1),
        (common::short(2), 1),
        (common::motionless(41), 6),
        (common::extreme(), 5),
    ] {
        assert_eq!(Film::of(&recording, &options).frames.len(), frames);
    }
}

#[test]
fn what_cannot_be_drawn_is_an_error() {
    let recording = common::transition();
    let name_of = |options: AnimationOptions| match animate(&recording, &options).unwrap_err() {
        FigureError::Option { name, .. } => name,
        other => panic!("{other}"),
    };
    assert_eq!(
        name_of(AnimationOptions {
            fps: 0.0,
            ..quick()
        }),
        "fps"
    );
    assert_eq!(
        name_of(AnimationOptions {
            fps: f64::NAN,
            ..quick()
        }),
        "fps"
    );
    assert_eq!(
        name_of(AnimationOptions {
            slow_motion: -1.0,
            ..quick()
        }),
        "slow_motion"
    );
    assert_eq!(
        name_of(AnimationOptions {
            width_px: 5000,
            ..quick()
        }),
        "width_px"
    );
    assert_eq!(
        name_of(AnimationOptions {
            fps: 50.0,
            slow_motion: 100.0,
            ..quick()
        }),
        "number of frames"
    );

    let error = animate(&common::short(0), &quick()).unwrap_err();
    assert!(matches!(error, FigureError::Empty { .. }));
    let late = AnimationOptions {
        from_s: Some(50.0),
        to_s: None,
        ..quick()
    };
    assert!(matches!(
        animate(&recording, &late),
        Err(FigureError::TimeRange { .. })
    ));

    let mut foreign = common::short(5);
    foreign.metadata.body = serde_json::json!({ "leg_length_m": "long" });
    let all = AnimationOptions::default();
    let error = animate(&foreign, &all).unwrap_err();
    assert!(matches!(error, FigureError::Body { .. }), "{error}");
    foreign.metadata.body = serde_json::json!({ "leg_length_m": -1.0 });
    let error = animate(&foreign, &all).unwrap_err();
    assert!(error.to_string().contains("leg_length_m"), "{error}");
}
