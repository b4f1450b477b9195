//! Films and numbered frames: drawn on all cores, encoded by the `ffmpeg` of the machine.

use std::env;
use std::io::{Read, Write};
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;

use crate::FigureError;
use crate::frames::Frames;

/// Frames that a thread draws before the next ones are handed out: enough to keep it busy, few enough to keep in memory.
const BATCH: usize = 4;

/// The file formats of films.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilmFormat {
    /// H.264 in MP4; it has no transparency.
    Mp4,
    /// VP9 in WebM, with transparency if asked for.
    WebM,
}

impl FilmFormat {
    /// The format that a file's ending names.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "mp4" => Some(Self::Mp4),
            "webm" => Some(Self::WebM),
            _ => None,
        }
    }

    fn arguments(self, transparent: bool) -> &'static [&'static str] {
        match (self, transparent) {
            (Self::Mp4, _) => &[
                "-c:v",
                "libx264",
                "-preset",
                "veryfast",
                "-crf",
                "18",
                "-pix_fmt",
                "yuv420p",
                "-movflags",
                "+faststart",
                "-f",
                "mp4",
            ],
            (Self::WebM, false) => &[
                "-c:v",
                "libvpx-vp9",
                "-crf",
                "24",
                "-b:v",
                "0",
                "-deadline",
                "realtime",
                "-cpu-used",
                "6",
                "-row-mt",
                "1",
                "-pix_fmt",
                "yuv420p",
                "-f",
                "webm",
            ],
            (Self::WebM, true) => &[
                "-c:v",
                "libvpx-vp9",
                "-crf",
                "24",
                "-b:v",
                "0",
                "-deadline",
                "realtime",
                "-cpu-used",
                "6",
                "-row-mt",
                "1",
                "-auto-alt-ref",
                "0",
                "-pix_fmt",
                "yuva420p",
                "-f",
                "webm",
            ],
        }
    }
}

/// The `ffmpeg` found in the folders of `PATH`.
pub fn find_ffmpeg() -> Option<PathBuf> {
    let name = format!("ffmpeg{}", env::consts::EXE_SUFFIX);
    env::split_paths(&env::var_os("PATH")?)
        .map(|folder| folder.join(&name))
        .find(|path| path.is_file())
}

/// Writes all frames as a film at `fps` frames a second.
///
/// # Errors
/// [`FigureError::NoFfmpeg`] where there is none, [`FigureError::Encode`] if it fails, or as [`Frames::draw`].
pub fn write_film(
    frames: &Frames<'_>,
    fps: f64,
    transparent: bool,
    format: FilmFormat,
    path: &Path,
) -> Result<(), FigureError> {
    let program = find_ffmpeg().ok_or_else(|| FigureError::NoFfmpeg {
        path: path.to_owned(),
        fps,
    })?;
    let first = frames.draw(0)?;
    let failed = |cause: String| FigureError::Encode { cause };
    // A name that begins with a dash or names a protocol is still a file.
    let output = std::path::absolute(path).map_err(|e| failed(e.to_string()))?;
    let mut ffmpeg = Command::new(&program)
        .args(["-hide_banner", "-loglevel", "error", "-nostdin", "-y"])
        .args(["-f", "rawvideo", "-pix_fmt", "rgba"])
        .args(["-video_size", &format!("{}x{}", first.width, first.height)])
        .args(["-framerate", &fps.to_string(), "-i", "pipe:0"])
        .args(format.arguments(transparent))
        .arg(output)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|e| failed(format!("{} cannot be started: {e}", program.display())))?;
    let (stdin, stderr) = (ffmpeg.stdin.take(), ffmpeg.stderr.take());
    let (drawn, said) = thread::scope(|scope| {
        // What it says must be read while it is written to, or both would wait for each other.
        let listener = thread::Builder::new().spawn_scoped(scope, move || {
            let mut said = String::new();
            let _ = stderr.map(|stderr| stderr.take(64 << 10).read_to_string(&mut said));
            said
        });
        let listener = match listener {
            Ok(listener) => listener,
            Err(e) => {
                return (
                    Err(failed(format!("no thread to listen to it: {e}"))),
                    String::new(),
                );
            }
        };
        let drawn = stdin.map_or(Ok(()), |mut stdin| {
            draw_in_order(
                frames,
                |k| frames.draw(k),
                |_, picture| {
                    // If it has ended, its words say why.
                    Ok(stdin.write_all(&picture.rgba).is_ok())
                },
            )
        });
        (drawn, listener.join().unwrap_or_default())
    });
    let status = ffmpeg.wait().map_err(|e| failed(e.to_string()))?;
    drawn?;
    if status.success() {
        return Ok(());
    }
    let said = said.trim();
    Err(failed(format!("ffmpeg ended with {status}: {said}")))
}

/// Writes all frames into a folder as `frame-00000.png` and so on, and removes what a longer film left behind them there.
/// Gives their number.
///
/// # Errors
/// [`FigureError::Write`] for a file that cannot be written, or as [`Frames::draw`].
pub fn write_frames(frames: &Frames<'_>, folder: &Path) -> Result<usize, FigureError> {
    let file = |k: usize| folder.join(format!("frame-{k:05}.png"));
    draw_in_order(
        frames,
        |k| frames.png(k),
        |k, png| {
            let path = file(k);
            std::fs::write(&path, png)
                .map(|()| true)
                .map_err(|cause| FigureError::Write { path, cause })
        },
    )?;
    // Whoever joins the frames takes all that are there.
    let mut behind = frames.len()..;
    while behind
        .next()
        .is_some_and(|k| std::fs::remove_file(file(k)).is_ok())
    {}
    Ok(frames.len())
}

/// Draws on all cores and hands the frames over in order, until `take` has enough.
fn draw_in_order<T: Send>(
    frames: &Frames<'_>,
    draw: impl Fn(usize) -> Result<T, FigureError> + Sync,
    mut take: impl FnMut(usize, T) -> Result<bool, FigureError>,
) -> Result<(), FigureError> {
    let threads = thread::available_parallelism()
        .map_or(1, NonZero::get)
        .min(16);
    let batch = threads * BATCH;
    let draw = &draw;
    for begin in (0..frames.len()).step_by(batch) {
        let end = (begin + batch).min(frames.len());
        let drawn: Vec<Vec<Result<T, FigureError>>> = thread::scope(|scope| {
            let of_thread = |t: usize| (begin + t..end).step_by(threads).map(draw).collect();
            let workers: Vec<_> = (1..threads)
                .map(|t| {
                    let thread = thread::Builder::new();
                    (t, thread.spawn_scoped(scope, move || of_thread(t)))
                })
                .collect();
            let own = of_thread(0);
            let others = workers.into_iter().map(|(t, worker)| match worker {
                Ok(worker) => worker
                    .join()
                    .unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
                // The system refuses a thread.
                Err(_) => of_thread(t),
            });
            std::iter::once(own).chain(others).collect()
        });
        let mut columns: Vec<_> = drawn.into_iter().map(Vec::into_iter).collect();
        for k in begin..end {
            match columns[(k - begin) % threads].next() {
                Some(frame) => {
                    if !take(k, frame?)? {
                        return Ok(());
                    }
                }
                None => break,
            }
        }
    }
    Ok(())
}
