//! Files of the last seconds: recording, profile, picture, film, page.

use crate::replay::replay_html;
use crate::stage::Stage;
use gaitshift_analysis::Recording;
use gaitshift_analysis::recording::column;
use gaitshift_figures::{
    AnimationOptions, FilmFormat, Frames, animate, stride_at, strobe, write_film,
};

/// Longest film and longest of everything else, in s.
const LONGEST_FILM_S: f64 = 20.0;
const LONGEST_S: f64 = 60.0;

/// A file to be made, with all that it is made of.
#[derive(Debug)]
pub(crate) struct Order {
    kind: Kind,
    recording: Recording,
    profile: String,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Recording,
    Profile,
    Picture,
    Gif,
    Film,
    Page,
}

impl Order {
    /// Takes from the stage what the file needs.
    ///
    /// # Errors
    /// An unknown kind, a biped that is not there, a time out of range, a motion that has just begun.
    pub fn of(stage: &Stage, what: &str, seconds: f64, biped: usize) -> Result<Self, String> {
        let kind = match what {
            "recording" => Kind::Recording,
            "profile" => Kind::Profile,
            "picture" => Kind::Picture,
            "gif" => Kind::Gif,
            "mp4" => Kind::Film,
            "page" => Kind::Page,
            _ => return Err(format!("`{what}` cannot be saved")),
        };
        let longest = if matches!(kind, Kind::Gif | Kind::Film) {
            LONGEST_FILM_S
        } else {
            LONGEST_S
        };
        if !(seconds > 0.0 && seconds <= LONGEST_S) {
            return Err(format!("from 0 to {LONGEST_S} s can be saved"));
        }
        let nobody = || format!("there is no biped {biped} on the stage");
        let recording = stage
            .recording(biped, seconds.min(longest))
            .ok_or_else(nobody)?;
        if recording.len() < 2 {
            return Err("the motion has only just begun".to_owned());
        }
        let history = stage.history(biped).ok_or_else(nobody)?;
        Ok(Self {
            kind,
            recording,
            profile: history.to_csv().unwrap_or_default(),
        })
    }

    /// Makes the file: its name and content.
    ///
    /// # Errors
    /// Why not, in one sentence.
    pub fn fill(self) -> Result<(String, Vec<u8>), String> {
        let recording = &self.recording;
        let file = |name: &str, content: Vec<u8>| Ok((name.to_owned(), content));
        match self.kind {
            Kind::Recording => file("recording.csv", recording.to_csv()?.into_bytes()),
            Kind::Profile => file("profile.csv", self.profile.into_bytes()),
            Kind::Picture => file("stride.png", stride(recording)?),
            Kind::Gif => {
                let options = AnimationOptions {
                    fps: 25.0,
                    width_px: 640,
                    ..AnimationOptions::default()
                };
                file(
                    "motion.gif",
                    animate(recording, &options).map_err(|e| e.to_string())?,
                )
            }
            Kind::Film => file("motion.mp4", film(recording)?),
            Kind::Page => file("motion.html", replay_html(recording)?.into_bytes()),
        }
    }
}

/// An MP4, by way of a file of its own that is gone afterwards.
fn film(recording: &Recording) -> Result<Vec<u8>, String> {
    let options = AnimationOptions {
        fps: 60.0,
        width_px: 960,
        ..AnimationOptions::default()
    };
    let frames = Frames::new(recording, &options).map_err(|e| e.to_string())?;
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    let path = folder.path().join("motion.mp4");
    write_film(&frames, options.fps, false, FilmFormat::Mp4, &path).map_err(|e| e.to_string())?;
    std::fs::read(&path).map_err(|e| e.to_string())
}

/// The latest whole stride at a glance.
fn stride(recording: &Recording) -> Result<Vec<u8>, String> {
    let times = recording.column(column::TIME_S);
    let (first_s, last_s) = (times[0], times[times.len() - 1]);
    let mut at_s = last_s;
    while at_s >= first_s {
        if let Some((from_s, to_s)) = stride_at(recording, at_s) {
            let figure = strobe(recording, from_s, to_s, 12).map_err(|e| e.to_string())?;
            return figure.to_png(2.0).map_err(|e| e.to_string());
        }
        at_s -= 0.25;
    }
    Err("the right leg has not taken a whole stride yet".to_owned())
}
