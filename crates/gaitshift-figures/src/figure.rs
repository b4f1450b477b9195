//! A finished picture, as SVG text or as pixels.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use crate::FigureError;
use crate::raster;

/// A picture: SVG text that can also be written as PNG.
#[derive(Clone, Debug)]
pub struct Figure {
    /// The whole SVG document. Text names the font DejaVu Sans; [`Figure::to_png`] has it built in.
    pub svg: String,
}

impl Figure {
    /// PNG file content with `scale` pixels for each user unit of the SVG.
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
        raster::pixels(&self.svg, scale)?
            .encode_png()
            .map_err(|cause| FigureError::Raster {
                cause: cause.to_string(),
            })
    }

    /// Writes `path` as its ending says: `.svg`, or `.png` at 2 pixels a unit. Without one of these
    /// endings both files are written beside each other. Gives the paths written.
    ///
    /// # Errors
    /// [`FigureError::Write`] if a file cannot be written, [`FigureError::Extension`] if `path`
    /// names another picture format, else as [`Figure::to_png`].
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
            std::fs::write(path, content).map_err(|cause| FigureError::Write {
                path: path.clone(),
                cause,
            })?;
        }
        Ok(paths)
    }
}
