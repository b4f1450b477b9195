//! `gaitshift render`: pictures of a recording.

use crate::arguments::RenderArguments;
use crate::failure::Failure;
use crate::gaits::read_recording;
use crate::output;
use gaitshift_analysis::Recording;
use gaitshift_analysis::recording::column;
use gaitshift_figures::{
    AnimationOptions, FigureError, FilmFormat, Frames, animate, stride_at, strobe, write_film,
    write_frames,
};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Unless asked for.
const POSES: u16 = 12;
const WIDTH_PX: u32 = 640;
/// Frames a second unless asked for: as many as a GIF shows evenly, and as screens show.
const GIF_FPS: f64 = 25.0;
const FILM_FPS: f64 = 60.0;

/// Where the pictures go; what has no place is not drawn.
#[derive(Debug, Default, PartialEq)]
struct Places {
    animation: Option<PathBuf>,
    stride: Option<PathBuf>,
}

/// Runs the command.
pub fn run(arguments: &RenderArguments) -> Result<(), Failure> {
    let a = arguments;
    let places = places(a)?;
    require_use(a, &places)?;
    let recording = read_recording(&a.recording)?;
    draw(a, &places, &recording).map_err(|failure| match failure {
        Failure::Input(cause) if cause.starts_with("the recording") => {
            Failure::input(format!("{}: {cause}", a.recording.display()))
        }
        failure => failure,
    })
}

fn draw(a: &RenderArguments, places: &Places, recording: &Recording) -> Result<(), Failure> {
    let mut files = Vec::new();
    if let Some(path) = &places.stride {
        let poses = usize::from(a.poses.unwrap_or(POSES));
        let written = match (a.stride_at_s, a.from_s, a.to_s) {
            // A fall is no whole stride.
            (None, Some(from_s), Some(to_s)) if places.animation.is_none() => {
                write_poses(recording, (from_s, to_s), poses, path)
            }
            (at_s, from_s, to_s) => {
                let time_s = at_s.unwrap_or_else(|| middle_s(recording, from_s, to_s));
                write_stride(recording, time_s, poses, path)
            }
        };
        match written {
            Ok(written) => files.extend(written),
            // A motion that takes no stride can still be animated.
            Err(failure @ Failure::Input(_))
                if places.animation.is_some() && a.stride_at_s.is_none() =>
            {
                if let Failure::Input(message) = failure {
                    output::note(&format!("no picture of a stride: {message}"));
                }
            }
            Err(failure) => return Err(failure),
        }
    }
    if let Some(path) = &places.animation {
        let film = FilmFormat::of(path);
        let options = AnimationOptions {
            fps: a.fps.unwrap_or(if film.is_some() || a.frames {
                FILM_FPS
            } else {
                GIF_FPS
            }),
            from_s: a.from_s,
            to_s: a.to_s,
            slow_motion: a.slow_motion.unwrap_or(1.0),
            width_px: a.width.unwrap_or(WIDTH_PX),
            transparent: a.transparent,
        };
        match film {
            _ if a.frames => return write_all_frames(recording, &options, path),
            Some(format) => write_film_file(recording, &options, format, path)?,
            None => write_animation(recording, &options, path)?,
        }
        files.push(path.clone());
    }
    output::written(&files)
}

/// Writes a film through `ffmpeg`.
fn write_film_file(
    recording: &Recording,
    options: &AnimationOptions,
    format: FilmFormat,
    path: &Path,
) -> Result<(), Failure> {
    let failure = |error| match error {
        FigureError::NoFfmpeg { .. } => Failure::run(error),
        error => output::figure_failure(error),
    };
    let frames = Frames::new(recording, options).map_err(failure)?;
    output::create_folder_of(path)?;
    write_film(&frames, options.fps, options.transparent, format, path).map_err(failure)
}

/// Writes every frame into a folder.
fn write_all_frames(
    recording: &Recording,
    options: &AnimationOptions,
    folder: &Path,
) -> Result<(), Failure> {
    let frames = Frames::new(recording, options).map_err(output::figure_failure)?;
    output::create_folder(folder)?;
    let count = write_frames(&frames, folder).map_err(output::figure_failure)?;
    output::line(&format!(
        "wrote {count} frames, {}",
        folder.join("frame-*.png").display()
    ))
}

/// An option of what is not drawn would be ignored.
fn require_use(a: &RenderArguments, places: &Places) -> Result<(), Failure> {
    let given = |options: &[(&str, bool)]| -> Vec<String> {
        let given = options.iter().filter(|(_, given)| *given);
        given.map(|(name, _)| (*name).to_owned()).collect()
    };
    let of_animation = given(&[
        ("--fps", a.fps.is_some()),
        ("--slow-motion", a.slow_motion.is_some()),
        ("--width", a.width.is_some()),
    ]);
    let of_stride = given(&[
        ("--stride-at-s", a.stride_at_s.is_some()),
        ("--poses", a.poses.is_some()),
    ]);
    let refuse = |options: &[String], what: &str, but: &str| {
        Err(Failure::input(format!(
            "only {but} is drawn, so {} would have no effect: leave it out, or have {what} drawn too, by another --out or \
             without --strobe",
            options.join(" and ")
        )))
    };
    if places.animation.is_none() && !of_animation.is_empty() {
        return refuse(&of_animation, "the animation", "the stride");
    }
    if places.stride.is_none() && !of_stride.is_empty() {
        return refuse(&of_stride, "the stride", "the animation");
    }
    Ok(())
}

/// What is drawn, and where to.
fn places(a: &RenderArguments) -> Result<Places, Failure> {
    if a.frames {
        if let Some(out) = a.out.as_deref().filter(|out| names_a_file(out).is_some()) {
            return Err(Failure::input(format!(
                "{}: --frames writes a folder of pictures; give a folder, with a `/` at its end if it is called so, or leave \
                 --frames out for an animation",
                out.display()
            )));
        }
        return Ok(Places {
            animation: a.out.clone(),
            ..Places::default()
        });
    }
    let webm = a.out.as_deref().and_then(FilmFormat::of) == Some(FilmFormat::WebM);
    if a.transparent && !webm {
        return Err(Failure::input(
            "--transparent is for --frames and for films ending in .webm: GIF and MP4 cannot be transparent",
        ));
    }
    let ending = |path: &Path| {
        if is_folder(path) {
            return None;
        }
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        ["gif", "mp4", "webm", "svg", "png"]
            .contains(&ending.as_str())
            .then_some(ending)
    };
    if let Some(out) = &a.out
        && let Some(ending) = ending(out)
    {
        let moving = ["gif", "mp4", "webm"].contains(&ending.as_str());
        if moving && a.strobe {
            return Err(Failure::input(format!(
                "--strobe draws only the stride, which cannot be written as {}; give a folder or a \
                 file ending in .svg or .png",
                out.display()
            )));
        }
        let (animation, stride) = if moving {
            (Some(out.clone()), None)
        } else {
            (None, Some(out.clone()))
        };
        return Ok(Places { animation, stride });
    }
    if let Some(out) = &a.out
        && let Some(ending) = names_a_file(out)
    {
        return Err(Failure::input(format!(
            "{}: cannot write a picture as .{ending}; give a file ending in .gif, .mp4 or .webm (animation), .svg or \
             .png (stride), or a folder, with a `/` at its end if it is called so",
            out.display()
        )));
    }
    let own = a.recording.parent().unwrap_or(Path::new(""));
    let folder = a.out.as_deref().unwrap_or(own);
    let [animation, stride] = names(&a.recording).map(|name| folder.join(name));
    Ok(Places {
        animation: (!a.strobe).then_some(animation),
        stride: Some(stride),
    })
}

/// What a recording's pictures are called: the animation, and the stride without its ending.
fn names(recording: &Path) -> [OsString; 2] {
    [".gif", "-stride"].map(|ending| {
        let mut name = recording.file_stem().unwrap_or_default().to_owned();
        name.push(ending);
        name
    })
}

/// Where the pictures of a recording are unless another place is asked for.
pub fn pictures_beside(recording: &Path) -> [PathBuf; 3] {
    let [animation, stride] = names(recording).map(|name| recording.with_file_name(name));
    let stride = stride.into_os_string();
    let [svg, png] = [".svg", ".png"].map(|ending| {
        let mut path = stride.clone();
        path.push(ending);
        path.into()
    });
    [animation, svg, png]
}

/// The ending of what is meant as a file: up to four letters and digits, and no folder of that name.
fn names_a_file(path: &Path) -> Option<&str> {
    let ending = path.extension()?.to_str()?;
    let usual = ending.len() <= 4
        && ending.chars().all(|c| c.is_ascii_alphanumeric())
        && ending.chars().any(|c| c.is_ascii_alphabetic());
    (usual && !is_folder(path)).then_some(ending)
}

/// Whether a path is a folder, or says that it is to be one.
fn is_folder(path: &Path) -> bool {
    path.is_dir() || path.as_os_str().to_string_lossy().ends_with(['/', '\\'])
}

/// Middle of the time range as far as recorded, in s.
fn middle_s(recording: &Recording, from_s: Option<f64>, to_s: Option<f64>) -> f64 {
    let times = recording.column(column::TIME_S);
    let first_s = times.first().copied().unwrap_or(0.0);
    let last_s = times.last().copied().unwrap_or(0.0);
    let from_s = from_s.map_or(first_s, |s| s.max(first_s));
    let to_s = to_s.map_or(last_s, |s| s.min(last_s));
    0.5 * (from_s + to_s)
}

/// Writes the stride around `time_s`; gives the files written.
pub fn write_stride(
    recording: &Recording,
    time_s: f64,
    poses: usize,
    path: &Path,
) -> Result<Vec<PathBuf>, Failure> {
    let (from_s, to_s) = stride_at(recording, time_s).ok_or_else(|| {
        Failure::input(format!(
            "no whole stride of the right leg is recorded around {time_s} s; choose another --stride-at-s, or have \
             the time between --from-s and --to-s drawn by --out FILE.svg"
        ))
    })?;
    write_poses(recording, (from_s, to_s), poses, path)
}

/// Writes poses of a time range; gives the files written.
fn write_poses(
    recording: &Recording,
    (from_s, to_s): (f64, f64),
    poses: usize,
    path: &Path,
) -> Result<Vec<PathBuf>, Failure> {
    let figure = strobe(recording, from_s, to_s, poses).map_err(output::figure_failure)?;
    output::create_folder_of(path)?;
    figure.write(path).map_err(output::figure_failure)
}

/// Writes the animation.
pub fn write_animation(
    recording: &Recording,
    options: &AnimationOptions,
    path: &Path,
) -> Result<(), Failure> {
    let gif = animate(recording, options).map_err(output::figure_failure)?;
    output::create_folder_of(path)?;
    output::file(path, &gif)
}
