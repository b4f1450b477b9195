//! A finished picture, as SVG text or as pixels.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use crate::FigureError;
use crate::raster;
use gaitshift_analysis::write_whole;

/// A picture: SVG text that can also be written as PNG.
#[derive(Clone, Debug)]
pub struct Figure {
    /// The whole SVG document. Text names the font DejaVu Sans; [`Figure::to_png`] has it built in.
    pub svg: String,
}

impl Figure {
    /// PNG file content with `scale` pixels for each user unit of the SVG, and its resolution: a unit is 1/96 inch.
    ///
    /// # Errors
    /// [`FigureError::Option`] if `scale` is not in (0, 20], [`FigureError::Raster`] if the SVG
    /// text, which anyone may have edited, cannot be drawn.
    pub fn to_png(&self, scale: f64) -> Result<Vec<u8>, FigureError> {
        if !(scale > 0.0 && scale <= 20.0) {
            return Err(FigureError::Option {
                name: "scale",
                value: scale,
                allowed: "above 0 and at most 20",
            });
        }
        let png = raster::pixels(&self.svg, scale, raster::Color::WHITE)?
            .encode_png()
            .map_err(|cause| FigureError::Raster {
                cause: cause.to_string(),
            })?;
        Ok(with_resolution(png, scale * UNITS_PER_METRE))
    }

    /// Writes `path` as its ending says: `.svg`, or `.png` at 2 pixels a unit. Without one of these
    /// endings both files are written beside each other. Gives the paths written.
    ///
    /// # Errors
    /// [`FigureError::Write`] if a file cannot be written, [`FigureError::Extension`] if `path`
    /// names another picture format, else as [`Figure::to_png`]. A file that was there is then as it was.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<Vec<PathBuf>, FigureError> {
        let path = path.as_ref();
        let ending = path
            .extension()
            .and_then(OsStr::to_str)
            .map(str::to_ascii_lowercase);
        let paths = match ending.as_deref() {
            Some("svg" | "png") => vec![path.to_owned()],
            Some("jpg" | "jpeg" | "gif" | "pdf" | "eps" | "webp") => {
                return Err(FigureError::Extension {
                    path: path.to_owned(),
                });
            }
            // `run.2` is a name with a dot in it, not a file ending.
            _ => ["svg", "png"]
                .map(|ending| {
                    let mut name = path.as_os_str().to_owned();
                    name.push(".");
                    name.push(ending);
                    PathBuf::from(name)
                })
                .to_vec(),
        };
        for path in &paths {
            let is_svg = path
                .extension()
                .is_some_and(|e| e.eq_ignore_ascii_case("svg"));
            let content = if is_svg {
                self.svg.clone().into_bytes()
            } else {
                self.to_png(2.0)?
            };
            write_whole(path, &content).map_err(|cause| FigureError::Write {
                path: path.clone(),
                cause,
            })?;
        }
        Ok(paths)
    }
}

/// User units, which are pixels of CSS, in a metre.
const UNITS_PER_METRE: f64 = 96.0 / 0.0254;
/// Signature and header chunk of a PNG; the resolution's chunk follows.
const HEADER: usize = 8 + 25;

/// A PNG with a `pHYs` chunk: its pixels per metre.
fn with_resolution(mut png: Vec<u8>, pixels_per_metre: f64) -> Vec<u8> {
    let mut chunk = b"pHYs".to_vec();
    let rounded = (pixels_per_metre.round() as u32).to_be_bytes();
    chunk.extend(rounded);
    chunk.extend(rounded);
    chunk.push(1);
    let mut bytes = ((chunk.len() - 4) as u32).to_be_bytes().to_vec();
    let checksum = crc32fast::hash(&chunk);
    bytes.extend(chunk);
    bytes.extend(checksum.to_be_bytes());
    if png.len() >= HEADER {
        png.splice(HEADER..HEADER, bytes);
    }
    png
}
