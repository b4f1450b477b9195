//! What can keep a picture from being drawn.

use std::path::PathBuf;

/// Why a figure or an animation could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FigureError {
    /// There is nothing to draw.
    #[error("{what} is empty: there is nothing to draw; record or evaluate at least {needed}")]
    Empty {
        /// The input that holds too little.
        what: &'static str,
        /// The least that would do.
        needed: &'static str,
    },
    /// The asked time range holds no recorded motion.
    #[error(
        "the time range {from_s} s to {to_s} s holds no recorded motion: the recording covers \
         {} s to {} s; choose a range inside it that ends after it starts",
        hundredths(*first_s),
        hundredths(*last_s)
    )]
    TimeRange {
        /// Start of the asked range in s.
        from_s: f64,
        /// End of the asked range in s.
        to_s: f64,
        /// First recorded time in s.
        first_s: f64,
        /// Last recorded time in s.
        last_s: f64,
    },
    /// A value that should be drawn is infinite or not a number.
    #[error(
        "`{name}` is {value} at entry {index}: only finite numbers can be drawn; a motion that \
         diverged can be drawn up to the moment before"
    )]
    NotFinite {
        /// Column or argument.
        name: String,
        /// Zero-based position in it.
        index: usize,
        /// The offending value.
        value: f64,
    },
    /// An option lies outside its range.
    #[error("option `{name}` is {value}, but must be {allowed}")]
    Option {
        /// Name of the option.
        name: &'static str,
        /// The value given.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Columns that belong together differ in length.
    #[error("`{name}` has {found} entries where {expected} are needed, one for each step count")]
    Length {
        /// Name of the argument.
        name: &'static str,
        /// Its length.
        found: usize,
        /// The length it must have.
        expected: usize,
    },
    /// The recording does not carry the body that moved.
    #[error(
        "the recording's metadata do not describe a body ({cause}): a pose cannot be drawn; \
         record the motion anew with this program"
    )]
    Body {
        /// What is missing or wrong.
        cause: String,
    },
    /// The file name does not say which kind of picture is wanted.
    #[error("{path}: a figure is written as `.svg` or `.png`, or as both when no ending is given")]
    Extension {
        /// The path as given.
        path: PathBuf,
    },
    /// The picture could not be written.
    #[error(
        "cannot write the picture {}: {cause}; check the path, its permissions and the room on its disk",
        path.display()
    )]
    Write {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        cause: std::io::Error,
    },
    /// The drawing could not be turned into pixels.
    #[error("the drawing cannot be turned into pixels: {cause}")]
    Raster {
        /// What the renderer said.
        cause: String,
    },
    /// A film needs a program that is not there.
    #[error(
        "{}: MP4 and WebM need `ffmpeg`, which is not in PATH; install it (Debian, Ubuntu: apt-get install \
         ffmpeg; macOS: brew install ffmpeg), or write frames with --frames --out frames and join them where \
         there is one: ffmpeg -framerate {fps} -i frames/frame-%05d.png -pix_fmt yuv420p film.mp4",
        path.display()
    )]
    NoFfmpeg {
        /// The film that was asked for.
        path: PathBuf,
        /// Its frames a second.
        fps: f64,
    },
    /// The animation could not be encoded.
    #[error("the animation cannot be encoded: {cause}")]
    Encode {
        /// What the encoder said.
        cause: String,
    },
}

/// A time without the digits that its clock adds.
fn hundredths(time_s: f64) -> f64 {
    (time_s * 100.0).round() / 100.0
}
