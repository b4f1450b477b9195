//! Moving pictures frame by frame, as pixels: what films are encoded from, and what the Python package shows.

use gaitshift_analysis::recording::Recording;
use gaitshift_body::{BodyParameters, BodyState};
use resvg::tiny_skia::{Color, Pixmap};

use crate::animation::{AnimationOptions, Scene, in_range};
use crate::biped;
use crate::canvas::{Anchor, Canvas, TextStyle};
use crate::ground::Ground;
use crate::motion::{LegPose, Pose};
use crate::scenery::{self, HIP, WIDTH};
use crate::style::{QUIET, TEXT};
use crate::{FigureError, raster};

/// Height of a single frame in user units: no timeline is under it.
const HEIGHT: f64 = 330.0;
/// Most frames of a film: an hour at 120 frames a second.
const MOST_FRAMES: f64 = 432_000.0;

/// One frame: four bytes (red, green, blue, opacity) for each pixel, row by row from the top, colours not multiplied by opacity.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The pixels.
    pub rgba: Vec<u8>,
}

impl Picture {
    fn of(pixmap: &Pixmap) -> Self {
        let pixels = pixmap.pixels().iter();
        let rgba = pixels.flat_map(|pixel| match pixel.alpha() {
            255 => [pixel.red(), pixel.green(), pixel.blue(), 255],
            _ => {
                let colour = pixel.demultiply();
                [colour.red(), colour.green(), colour.blue(), colour.alpha()]
            }
        });
        Self {
            width: pixmap.width(),
            height: pixmap.height(),
            rgba: rgba.collect(),
        }
    }
}

/// The frames of a motion, drawn when asked for. Threads may draw different frames at the same time.
pub struct Frames<'a> {
    scene: Scene<'a>,
    frame_s: f64,
    count: usize,
    scale: f64,
}

impl<'a> Frames<'a> {
    /// Prepares the frames of a recording, as [`crate::animate`] draws them, for up to 240 frames a second and 3840 pixels
    /// of width. Width and height are even, as video codecs ask for.
    ///
    /// # Errors
    /// As [`crate::animate`], with other bounds.
    pub fn new(recording: &'a Recording, options: &AnimationOptions) -> Result<Self, FigureError> {
        in_range("fps", options.fps, 1.0, 240.0, "1 to 240 frames a second")?;
        let width_px = f64::from(options.width_px);
        in_range("width_px", width_px, 160.0, 3840.0, "160 to 3840 pixels")?;
        options.check_slow_motion()?;
        let scene = Scene::new(recording, options)?;
        let frame_s = 1.0 / (options.fps * options.slow_motion);
        let count = (scene.duration_s() / frame_s + 1e-6).floor() + 1.0;
        in_range(
            "number of frames",
            count,
            1.0,
            MOST_FRAMES,
            "at most 432000: choose a shorter time range, fewer frames a second or less slow motion",
        )?;
        Ok(Self {
            scene,
            frame_s,
            count: count as usize,
            // Sixteen to ten: a width that is a multiple of 16 gives an even height.
            scale: (width_px / 16.0).round() * 16.0 / WIDTH,
        })
    }

    /// Number of frames.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there is none, which does not happen: a motion has a first frame.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Frame `index`, from 0.
    ///
    /// # Errors
    /// [`FigureError::Raster`] if the drawing cannot be turned into pixels.
    pub fn draw(&self, index: usize) -> Result<Picture, FigureError> {
        Ok(Picture::of(&self.pixels(index)?))
    }

    /// Frame `index` as the content of a PNG file.
    ///
    /// # Errors
    /// As [`Frames::draw`].
    pub fn png(&self, index: usize) -> Result<Vec<u8>, FigureError> {
        self.pixels(index)?
            .encode_png()
            .map_err(|cause| FigureError::Raster {
                cause: cause.to_string(),
            })
    }

    fn pixels(&self, index: usize) -> Result<Pixmap, FigureError> {
        let time_s = self.scene.first_s() + index as f64 * self.frame_s;
        raster::pixels(&self.scene.draw(time_s), self.scale, Color::TRANSPARENT)
    }
}

/// A body at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Snapshot<'a> {
    /// The body.
    pub body: &'a BodyParameters,
    /// Points `[x, z]` of the ground, in m, with straight lines between and beyond them; none where it is flat.
    pub ground: Option<&'a [[f64; 2]]>,
    /// Its state.
    pub state: &'a BodyState,
    /// Forward and upward ground reaction on the right and the left foot, in N.
    pub force_n: [(f64, f64); 2],
    /// The command.
    pub omega_v: f64,
    /// Time since the start, in s.
    pub time_s: f64,
}

impl Snapshot<'_> {
    /// The body with ground, forces, knob, speed and time, `width_px` wide (160 to 3840; the height is 33 sixty-fourths).
    ///
    /// # Errors
    /// [`FigureError::Option`] for another width, [`FigureError::Raster`] if the drawing cannot be turned into pixels.
    pub fn draw(&self, width_px: u32) -> Result<Picture, FigureError> {
        let width = f64::from(width_px);
        in_range("width_px", width, 160.0, 3840.0, "160 to 3840 pixels")?;
        let s = self.state;
        let leg = |side: usize| {
            let leg = &s.legs[side];
            LegPose {
                psi: leg.psi,
                h: leg.thigh,
                d: leg.d(),
                w: leg.w(),
                force_n: self.force_n[side],
            }
        };
        let pose = Pose {
            x: s.x,
            z: s.z,
            theta: s.theta,
            legs: [leg(0), leg(1)],
        };
        let mut canvas = Canvas::new(WIDTH, HEIGHT);
        let ground = Ground::through(self.ground);
        let view = scenery::view_of(self.body, s.x).moved((s.x, ground.level(s.x)), HIP);
        let weight_n = self.body.total_mass_kg() * self.body.gravity_m_per_s2;
        scenery::draw_ground(&mut canvas, &view, &ground);
        biped::draw(&mut canvas, &view, self.body, &pose);
        scenery::draw_forces(&mut canvas, &view, self.body, &pose, weight_n, &ground);
        scenery::draw_knob(&mut canvas, &scenery::knob(&[self.omega_v]), self.omega_v);
        let figures = [
            (536.0, "speed", format!("{:.2} m/s", s.x_dot + 0.0)),
            (622.0, "time", format!("{:.2} s", self.time_s)),
        ];
        for (x, name, value) in figures {
            let name_style = TextStyle::new(11.0, QUIET).anchor(Anchor::End);
            canvas.text((x, 27.0), name, name_style);
            let value_style = TextStyle::new(17.0, TEXT).anchor(Anchor::End);
            canvas.text((x, 47.0), &value, value_style);
        }
        let pixmap = raster::pixels(&canvas.finish(), width / WIDTH, Color::TRANSPARENT)?;
        Ok(Picture::of(&pixmap))
    }
}
