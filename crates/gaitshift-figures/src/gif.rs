//! GIF with one palette for all frames, each frame holding only what changed.

use std::collections::BTreeMap;

use ::gif::{DisposalMethod, Encoder, Frame, Repeat};
use resvg::tiny_skia::Pixmap;

use crate::FigureError;

type Rgb = [u8; 3];

/// Palette entry that leaves the pixel as it was.
const UNCHANGED: u8 = 255;
/// Entries given to exact colours; large flat areas are among these and come out unaltered.
const EXACT: usize = 48;

/// The colours of an animation.
pub(crate) struct Palette {
    /// At most 255; the entry after them is [`UNCHANGED`].
    colours: Vec<Rgb>,
}

impl Palette {
    /// The most frequent colours of some frames as they are, then the most frequent kinds of the many
    /// that smooth edges are made of, each kind by its mean.
    pub fn of(
        frames: impl Iterator<Item = Result<Pixmap, FigureError>>,
    ) -> Result<Self, FigureError> {
        let mut counts: BTreeMap<Rgb, u64> = BTreeMap::new();
        for frame in frames {
            for (colour, length) in runs_of(&frame?) {
                *counts.entry(colour).or_default() += length as u64;
            }
        }
        let mut by_count: Vec<(Rgb, u64)> = counts.into_iter().collect();
        // Stable: equally frequent colours keep the order of their values.
        by_count.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
        let rest = by_count.split_off(by_count.len().min(EXACT));
        let mut colours: Vec<Rgb> = by_count.into_iter().map(|(colour, _)| colour).collect();

        let mut kinds: BTreeMap<Rgb, ([u64; 3], u64)> = BTreeMap::new();
        for (colour, count) in rest {
            let (sum, total) = kinds.entry(colour.map(|c| c >> 4)).or_default();
            for (sum, channel) in sum.iter_mut().zip(colour) {
                *sum += u64::from(channel) * count;
            }
            *total += count;
        }
        let mut kinds: Vec<([u64; 3], u64)> = kinds.into_values().collect();
        kinds.sort_by_key(|&(_, total)| std::cmp::Reverse(total));
        let room = usize::from(UNCHANGED) - colours.len();
        colours.extend(
            kinds
                .into_iter()
                .take(room)
                .map(|(sum, total)| sum.map(|s| (s / total) as u8)),
        );
        Ok(Self { colours })
    }

    /// The whole animation, repeated endlessly.
    pub fn encode(
        &self,
        frames: impl Iterator<Item = Result<Pixmap, FigureError>>,
        fps: f64,
    ) -> Result<Vec<u8>, FigureError> {
        let failed = |cause: ::gif::EncodingError| FigureError::Encode {
            cause: cause.to_string(),
        };
        let mut file = Vec::new();
        let mut encoder: Option<Encoder<&mut Vec<u8>>> = None;
        let mut table: Vec<u8> = self.colours.concat();
        table.resize(3 * 256, 0);
        let mut nearest = BTreeMap::new();
        let mut shown: Vec<u8> = Vec::new();
        let mut width = 0;
        let mut target = Some(&mut file);
        for (i, frame) in frames.enumerate() {
            let frame = frame?;
            let mut indices = Vec::with_capacity(frame.pixels().len());
            for (colour, length) in runs_of(&frame) {
                let index = *nearest
                    .entry(colour)
                    .or_insert_with(|| self.nearest(colour));
                indices.resize(indices.len() + length, index);
            }
            if let Some(file) = target.take() {
                width = frame.width() as usize;
                let size = (frame.width() as u16, frame.height() as u16);
                let mut new = Encoder::new(file, size.0, size.1, &table).map_err(failed)?;
                new.set_repeat(Repeat::Infinite).map_err(failed)?;
                encoder = Some(new);
            }
            let mut changed = changed_part(&shown, &indices, width);
            changed.delay = delay(i, fps);
            if let Some(encoder) = &mut encoder {
                encoder.write_frame(&changed).map_err(failed)?;
            }
            shown = indices;
        }
        drop(encoder);
        Ok(file)
    }

    fn nearest(&self, colour: Rgb) -> u8 {
        let distance = |other: &Rgb| -> i32 {
            let channel = |i: usize| (i32::from(colour[i]) - i32::from(other[i])).pow(2);
            // The eye is most sensitive to green, least to blue.
            2 * channel(0) + 4 * channel(1) + 3 * channel(2)
        };
        let best = self
            .colours
            .iter()
            .enumerate()
            .min_by_key(|(_, other)| distance(other));
        best.map_or(0, |(index, _)| index as u8)
    }
}

/// The pixels of an opaque picture, row by row, as runs of one colour: most of it is background.
fn runs_of(picture: &Pixmap) -> impl Iterator<Item = (Rgb, usize)> + '_ {
    picture.pixels().chunk_by(|a, b| a == b).map(|run| {
        let pixel = run[0];
        ([pixel.red(), pixel.green(), pixel.blue()], run.len())
    })
}

/// The smallest rectangle that holds all changes, unchanged pixels in it left as they were.
fn changed_part(shown: &[u8], indices: &[u8], width: usize) -> Frame<'static> {
    let height = indices.len() / width.max(1);
    let differs = |at: usize| shown.get(at) != Some(&indices[at]);
    let mut bounds: Option<[usize; 4]> = None;
    for at in (0..indices.len()).filter(|&at| differs(at)) {
        let (x, y) = (at % width, at / width);
        let [left, top, right, bottom] = bounds.unwrap_or([x, y, x, y]);
        bounds = Some([left.min(x), top.min(y), right.max(x), bottom.max(y)]);
    }
    // A frame must have a pixel even if nothing moved.
    let [left, top, right, bottom] = bounds.unwrap_or([0, 0, 0, 0]);
    debug_assert!(right < width && bottom < height);
    let mut buffer = Vec::with_capacity((right - left + 1) * (bottom - top + 1));
    for y in top..=bottom {
        for x in left..=right {
            let at = y * width + x;
            buffer.push(if differs(at) { indices[at] } else { UNCHANGED });
        }
    }
    Frame {
        left: left as u16,
        top: top as u16,
        width: (right - left + 1) as u16,
        height: (bottom - top + 1) as u16,
        buffer: buffer.into(),
        transparent: Some(UNCHANGED),
        dispose: DisposalMethod::Keep,
        ..Frame::default()
    }
}

/// Time for which frame `i` is shown, in hundredths of a second, such that rounding does not add up.
fn delay(i: usize, fps: f64) -> u16 {
    let end = |i: usize| (100.0 * i as f64 / fps).round();
    (end(i + 1) - end(i)) as u16
}
