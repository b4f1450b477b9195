//! The moving picture: the body on its way, the knob, and when which foot was on the ground.

use gaitshift_analysis::cost::froude_number;
use gaitshift_analysis::gait::{GaitClass, GaitRule};
use gaitshift_analysis::recording::{Recording, Side, column};
use gaitshift_analysis::steps::{Step, find_steps};
use gaitshift_analysis::support::Support;
use gaitshift_body::BodyParameters;

use crate::FigureError;
use crate::biped::{self, View};
use crate::canvas::{Anchor, Canvas, Paint, Rect, TextStyle};
use crate::chart::{Axis, Panel};
use crate::gif::Palette;
use crate::ground::Ground;
use crate::motion::{Motion, body_of};
use crate::raster::{self, Color};
use crate::scenery::{self, HIP, WIDTH};
use crate::style::{COMMAND, FAINT, QUIET, TEXT, side_ink};
use crate::support;

/// Layout in user units; `width_px` scales it.
const HEIGHT: f64 = 400.0;
/// The timeline under the picture.
const TIMELINE: Rect = Rect::new(58.0, 338.0, 564.0, 48.0);
/// Speed is shown as its mean over about one step, so that the figures can be read.
const SPEED_WINDOW_S: f64 = 0.5;
/// How long before its end a motion that fell is called fallen.
const FALL_SHOWN_S: f64 = 0.2;
/// Longest animation; more would make a file that no page shows.
const MOST_FRAMES: f64 = 3000.0;

/// Which part of a motion is animated and how.
#[derive(Clone, Debug, PartialEq)]
pub struct AnimationOptions {
    /// Frames shown per second, 1 to 50.
    pub fps: f64,
    /// Start in s; `None` for the recording's start.
    pub from_s: Option<f64>,
    /// End in s; `None` for the recording's end.
    pub to_s: Option<f64>,
    /// How many times slower than in reality it plays, 0.1 to 100.
    pub slow_motion: f64,
    /// Width in pixels, 160 to 1920; the height is five eighths of it.
    pub width_px: u32,
    /// Whether the background is left out. A GIF has none that shines through.
    pub transparent: bool,
}

impl Default for AnimationOptions {
    /// The whole recording in real time, 25 frames a second, 640 by 400 pixels.
    fn default() -> Self {
        Self {
            fps: 25.0,
            from_s: None,
            to_s: None,
            slow_motion: 1.0,
            width_px: 640,
            transparent: false,
        }
    }
}

impl AnimationOptions {
    fn check(&self) -> Result<(), FigureError> {
        in_range("fps", self.fps, 1.0, 50.0, "1 to 50 frames a second")?;
        self.check_slow_motion()?;
        let width_px = f64::from(self.width_px);
        in_range("width_px", width_px, 160.0, 1920.0, "160 to 1920 pixels")
    }

    pub(crate) fn check_slow_motion(&self) -> Result<(), FigureError> {
        let slower = self.slow_motion;
        in_range("slow_motion", slower, 0.1, 100.0, "0.1 to 100 times slower")
    }
}

/// Refuses an option out of its range, or one that is no number.
pub(crate) fn in_range(
    name: &'static str,
    value: f64,
    least: f64,
    most: f64,
    allowed: &'static str,
) -> Result<(), FigureError> {
    if (least..=most).contains(&value) {
        Ok(())
    } else {
        Err(FigureError::Option {
            name,
            value,
            allowed,
        })
    }
}

/// The motion as an endlessly repeated GIF, file content.
///
/// The camera follows the hip. The knob above is the command `ω_v`; beside it stand the speed (its mean
/// over half a second) and the Froude number `v / √(g l)`, and what the present step is by
/// [`GaitRule::class_of_step`]. Arrows are the ground reaction forces. The timeline below shows when
/// each foot was on the ground, and the speed.
///
/// # Errors
/// [`FigureError::Empty`] or [`FigureError::TimeRange`] if no row lies in the range,
/// [`FigureError::Option`] for an option out of range or more than 3000 frames,
/// [`FigureError::Body`] if the recording does not say what the body looks like.
pub fn animate(recording: &Recording, options: &AnimationOptions) -> Result<Vec<u8>, FigureError> {
    options.check()?;
    let scene = Scene::new(recording, options)?;
    let frame_s = 1.0 / (options.fps * options.slow_motion);
    let frames = (scene.motion.duration_s() / frame_s + 1e-6).floor() + 1.0;
    if frames > MOST_FRAMES {
        return Err(FigureError::Option {
            name: "number of frames",
            value: frames,
            allowed: "at most 3000: choose a shorter time range, fewer frames a second or less slow motion",
        });
    }
    let frames = frames as usize;
    let scale = f64::from(options.width_px) / WIDTH;
    let draw = |frame: usize| {
        let time_s = scene.motion.first_s() + frame as f64 * frame_s;
        raster::pixels(&scene.draw(time_s), scale, Color::WHITE)
    };

    // A sample of the frames decides on the colours of all, so that nothing flickers.
    let samples = frames.min(16);
    let sampled = (0..samples).map(|i| draw(i * (frames - 1) / (samples - 1).max(1)));
    let palette = Palette::of(sampled)?;
    palette.encode((0..frames).map(draw), options.fps)
}

/// Everything that stays the same from frame to frame.
pub(crate) struct Scene<'a> {
    motion: Motion<'a>,
    body: BodyParameters,
    support: Support,
    steps: Vec<(Step, GaitClass)>,
    view: View,
    slow_motion: f64,
    transparent: bool,
    knob: Axis,
    timeline: Panel,
    speeds: Vec<f64>,
}

impl<'a> Scene<'a> {
    pub fn new(recording: &'a Recording, options: &AnimationOptions) -> Result<Self, FigureError> {
        let from_s = options.from_s.unwrap_or(f64::NEG_INFINITY);
        let to_s = options.to_s.unwrap_or(f64::INFINITY);
        let motion = Motion::between(recording, from_s, to_s)?;
        let body = body_of(recording)?;
        let support = support::find(recording);
        let rule = GaitRule::default();
        let steps = match recording.whole() {
            Some(window) => find_steps(recording, &support, window)
                .into_iter()
                .map(|step| (step, rule.class_of_step(&step)))
                .collect(),
            None => Vec::new(),
        };
        let view = scenery::view_of(&body, 0.0);
        let knob = scenery::knob(motion.values(column::OMEGA_V));
        let speeds: Vec<f64> = motion
            .times()
            .iter()
            .map(|&t| motion.mean_speed(t, SPEED_WINDOW_S))
            .collect();
        let speed_axis = Axis::around(speeds.iter().copied().chain([0.0]), 2);
        let timeline = Panel {
            area: TIMELINE,
            x: Axis::exact(motion.first_s(), motion.last_s(), 8),
            y: speed_axis,
        };
        let slow_motion = options.slow_motion;
        Ok(Self {
            motion,
            body,
            support,
            steps,
            view,
            slow_motion,
            transparent: options.transparent,
            knob,
            timeline,
            speeds,
        })
    }

    /// Time of the first frame, in s.
    pub fn first_s(&self) -> f64 {
        self.motion.first_s()
    }

    /// Time from the first frame to the last moment shown, in s.
    pub fn duration_s(&self) -> f64 {
        self.motion.duration_s()
    }

    pub fn draw(&self, time_s: f64) -> String {
        let mut canvas = if self.transparent {
            Canvas::transparent(WIDTH, HEIGHT)
        } else {
            Canvas::new(WIDTH, HEIGHT)
        };
        let pose = self.motion.pose(time_s);
        let ground = Ground::of(self.motion.recording);
        let view = self.view.moved((pose.x, ground.level(pose.x)), HIP);
        let metadata = &self.motion.recording.metadata;
        let weight_n = metadata.total_mass_kg * metadata.gravity_m_per_s2;
        scenery::draw_ground(&mut canvas, &view, &ground);
        biped::draw(&mut canvas, &view, &self.body, &pose);
        scenery::draw_forces(&mut canvas, &view, &self.body, &pose, weight_n, &ground);
        let command = self.motion.at(column::OMEGA_V, time_s);
        scenery::draw_knob(&mut canvas, &self.knob, command);
        self.draw_figures(&mut canvas, time_s);
        self.draw_timeline(&mut canvas, time_s);
        canvas.finish()
    }

    /// Gait, speed, Froude number, time.
    fn draw_figures(&self, canvas: &mut Canvas, time_s: f64) {
        if let Some(word) = self.gait_word(time_s) {
            canvas.text((296.0, 44.0), word, TextStyle::new(23.0, TEXT).bold());
        }
        let phases = self.support.phases();
        let phase = phases.partition_point(|interval| interval.end_s < time_s);
        if let Some(interval) = phases.get(phase) {
            let style = TextStyle::new(11.0, QUIET);
            canvas.text((297.0, 62.0), support::name(interval.phase), style);
        }
        let speed = self.motion.mean_speed(time_s, SPEED_WINDOW_S);
        let mut figure = |x: f64, name: &str, value: String| {
            let name_style = TextStyle::new(11.0, QUIET).anchor(Anchor::End);
            canvas.text((x, 27.0), name, name_style);
            let value_style = TextStyle::new(17.0, TEXT).anchor(Anchor::End);
            canvas.text((x, 47.0), &value, value_style);
        };
        figure(546.0, "speed", format!("{speed:.2} m/s"));
        if let Some(froude) = froude_number(self.motion.recording, speed) {
            figure(622.0, "Froude", format!("{froude:.2}"));
        }
        if self.slow_motion != 1.0 {
            let speed = if self.slow_motion > 1.0 {
                format!("{:.3}", self.slow_motion)
            } else {
                format!("{:.3}", 1.0 / self.slow_motion)
            };
            let speed = speed.trim_end_matches('0').trim_end_matches('.');
            let word = if self.slow_motion > 1.0 {
                "slower"
            } else {
                "faster"
            };
            let style = TextStyle::new(11.0, QUIET).anchor(Anchor::End);
            canvas.text(
                (622.0, 68.0),
                &format!("{speed} \u{d7} {word} than real"),
                style,
            );
        }
    }

    /// What the step under way is; nothing before the first and after the last whole step. A step of neither gait between
    /// steps of both belongs to the change. At the end of a motion that fell it says so.
    fn gait_word(&self, time_s: f64) -> Option<&'static str> {
        let recording = self.motion.recording;
        let end_s = recording
            .column(column::TIME_S)
            .last()
            .copied()
            .unwrap_or(f64::INFINITY);
        if recording.metadata.fell && time_s > end_s - FALL_SHOWN_S {
            return Some("fallen");
        }
        let after = self
            .steps
            .partition_point(|(step, _)| step.start_s <= time_s);
        let at = after.checked_sub(1)?;
        let (step, class) = self.steps.get(at)?;
        if time_s > step.start_s + step.duration_s {
            return None;
        }
        let gait = |(_, class): &&(Step, GaitClass)| *class != GaitClass::Mixed;
        let before = self.steps[..at].iter().rev().find(gait);
        let next = self.steps[at..].iter().find(gait);
        Some(match class {
            GaitClass::Walking => "walking",
            GaitClass::Running => "running",
            _ if before.zip(next).is_some_and(|(a, b)| a.1 != b.1) => "changing",
            _ => "mixed",
        })
    }

    /// Contacts of both feet and the speed over the whole animation, with a cursor.
    fn draw_timeline(&self, canvas: &mut Canvas, time_s: f64) {
        let panel = &self.timeline;
        let bars = Rect::new(TIMELINE.left, TIMELINE.top, TIMELINE.width, 16.0);
        let span = (panel.x.from, panel.x.to);
        let times = self.motion.recording.column(column::TIME_S);
        support::contact_bars(canvas, bars, span, &self.support, times);
        let right_aligned = |ink| TextStyle::new(9.5, ink).anchor(Anchor::End);
        let names = [("right", Side::Right, 6.5), ("left", Side::Left, 16.5)];
        for (name, side, y) in names {
            let position = (TIMELINE.left - 6.0, TIMELINE.top + y);
            canvas.text(position, name, right_aligned(side_ink(side)));
        }
        let below = Rect::new(TIMELINE.left, TIMELINE.top + 20.0, TIMELINE.width, 28.0);
        let speed = Panel {
            area: below,
            ..panel.clone()
        };
        let (_, zero) = speed.place(span.0, 0.0);
        canvas.line(
            (below.left, zero),
            (below.right(), zero),
            Paint::stroke(FAINT, 1.0),
        );
        speed.curve(
            canvas,
            self.motion.times(),
            &self.speeds,
            Paint::stroke(TEXT, 1.6),
        );
        let position = (TIMELINE.left - 6.0, below.top + 18.0);
        canvas.text(position, "speed", right_aligned(QUIET));
        let x = panel.horizontal(time_s);
        let top = TIMELINE.top - 4.0;
        canvas.line(
            (x, top),
            (x, TIMELINE.bottom() + 2.0),
            Paint::stroke(COMMAND, 2.0),
        );
        let (_, y) = speed.place(time_s, self.motion.mean_speed(time_s, SPEED_WINDOW_S));
        canvas.circle((x, y), 3.2, Paint::fill(COMMAND));
        let position = (TIMELINE.right(), HEIGHT - 2.5);
        // The recording's time, by which figures and options count too.
        let time = format!("{time_s:.1} s");
        canvas.text(position, &time, right_aligned(QUIET));
    }
}
