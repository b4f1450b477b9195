//! The one way to draw: shapes and text written as SVG.
//!
//! Lengths are in user units (pixels at scale 1), x to the right, y down.

use std::fmt::{self, Write as _};

/// Font family of every text; the renderer has its bytes built in.
pub(crate) const FONT: &str = "DejaVu Sans";

/// The subscript v of ω_v. The font's own glyph does not fit its letters, so a small v below the base line takes its place.
const SUBSCRIPT_V: char = '\u{1d65}';
const SUBSCRIPT_SIZE: f64 = 0.75;
const SUBSCRIPT_DROP: f64 = 0.22;

/// A colour with opacity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ink {
    /// Red, green and blue, 0 to 255.
    pub rgb: [u8; 3],
    /// 0 (invisible) to 1 (opaque).
    pub opacity: f64,
}

impl Ink {
    /// Opaque colour from `0xRRGGBB`.
    pub const fn hex(rgb: u32) -> Self {
        Self {
            rgb: [(rgb >> 16) as u8, (rgb >> 8) as u8, rgb as u8],
            opacity: 1.0,
        }
    }

    /// The same colour, more or less transparent.
    pub const fn opacity(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }

    /// Mixed with `other`: 0 keeps this colour, 1 gives the other.
    pub fn mix(self, other: Self, share: f64) -> Self {
        let blend = |a: u8, b: u8| {
            (f64::from(a) + (f64::from(b) - f64::from(a)) * share.clamp(0.0, 1.0)).round() as u8
        };
        Self {
            rgb: std::array::from_fn(|i| blend(self.rgb[i], other.rgb[i])),
            opacity: self.opacity,
        }
    }
}

impl fmt::Display for Ink {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [r, g, b] = self.rgb;
        write!(f, "#{r:02x}{g:02x}{b:02x}")
    }
}

/// A position in user units.
pub(crate) type Point = (f64, f64);

/// An upright rectangle in user units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rect {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
}

impl Rect {
    pub const fn new(left: f64, top: f64, width: f64, height: f64) -> Self {
        Self {
            left,
            top,
            width,
            height,
        }
    }

    pub fn right(&self) -> f64 {
        self.left + self.width
    }

    pub fn bottom(&self) -> f64 {
        self.top + self.height
    }
}

/// How a shape is painted: inside, outline, both.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paint {
    fill: Option<Ink>,
    stroke: Option<(Ink, f64)>,
    dash: Option<&'static str>,
}

impl Paint {
    pub const fn fill(ink: Ink) -> Self {
        Self {
            fill: Some(ink),
            stroke: None,
            dash: None,
        }
    }

    pub const fn stroke(ink: Ink, width: f64) -> Self {
        Self {
            fill: None,
            stroke: Some((ink, width)),
            dash: None,
        }
    }

    pub const fn outlined(self, ink: Ink, width: f64) -> Self {
        Self {
            stroke: Some((ink, width)),
            ..self
        }
    }

    pub const fn dashed(self, dash: &'static str) -> Self {
        Self {
            dash: Some(dash),
            ..self
        }
    }
}

impl fmt::Display for Paint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.fill {
            Some(ink) => {
                write!(f, r#" fill="{ink}""#)?;
                if ink.opacity < 1.0 {
                    write!(f, r#" fill-opacity="{}""#, Number(ink.opacity))?;
                }
            }
            None => f.write_str(r#" fill="none""#)?,
        }
        if let Some((ink, width)) = self.stroke {
            write!(f, r#" stroke="{ink}" stroke-width="{}""#, Number(width))?;
            if ink.opacity < 1.0 {
                write!(f, r#" stroke-opacity="{}""#, Number(ink.opacity))?;
            }
        }
        if let Some(dash) = self.dash {
            write!(f, r#" stroke-dasharray="{dash}""#)?;
        }
        Ok(())
    }
}

/// Which point of a text its position names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// Look of a text.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TextStyle {
    pub size: f64,
    pub ink: Ink,
    pub anchor: Anchor,
    pub bold: bool,
    /// Turned a quarter to read from bottom to top.
    pub upwards: bool,
}

impl TextStyle {
    pub const fn new(size: f64, ink: Ink) -> Self {
        Self {
            size,
            ink,
            anchor: Anchor::Start,
            bold: false,
            upwards: false,
        }
    }

    pub const fn anchor(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }

    pub const fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    pub const fn upwards(self) -> Self {
        Self {
            upwards: true,
            ..self
        }
    }
}

/// An SVG document under construction.
#[derive(Debug)]
pub(crate) struct Canvas {
    width: f64,
    height: f64,
    body: String,
}

// Writing to a `String` cannot fail, so the results of `write!` are dropped.
impl Canvas {
    /// A sheet without a background.
    pub fn transparent(width: f64, height: f64) -> Self {
        Self {
            width,
            height,
            body: String::new(),
        }
    }

    /// A white sheet.
    pub fn new(width: f64, height: f64) -> Self {
        let mut canvas = Self::transparent(width, height);
        canvas.rect(
            Rect::new(0.0, 0.0, width, height),
            Paint::fill(Ink::hex(0xffffff)),
        );
        canvas
    }

    pub fn rect(&mut self, rect: Rect, paint: Paint) {
        self.rounded_rect(rect, 0.0, paint);
    }

    pub fn rounded_rect(&mut self, rect: Rect, radius: f64, paint: Paint) {
        let _ = write!(
            self.body,
            r#"<rect x="{}" y="{}" width="{}" height="{}""#,
            Number(rect.left),
            Number(rect.top),
            Number(rect.width.max(0.0)),
            Number(rect.height.max(0.0))
        );
        if radius > 0.0 {
            let _ = write!(self.body, r#" rx="{}""#, Number(radius));
        }
        let _ = writeln!(self.body, "{paint}/>");
    }

    pub fn line(&mut self, from: Point, to: Point, paint: Paint) {
        let _ = writeln!(
            self.body,
            r#"<line x1="{}" y1="{}" x2="{}" y2="{}"{paint}/>"#,
            Number(from.0),
            Number(from.1),
            Number(to.0),
            Number(to.1)
        );
    }

    pub fn polyline(&mut self, points: impl IntoIterator<Item = Point>, paint: Paint) {
        self.points("polyline", points, paint);
    }

    pub fn polygon(&mut self, points: impl IntoIterator<Item = Point>, paint: Paint) {
        self.points("polygon", points, paint);
    }

    fn points(&mut self, element: &str, points: impl IntoIterator<Item = Point>, paint: Paint) {
        let _ = write!(self.body, r#"<{element} points=""#);
        for (i, (x, y)) in points.into_iter().enumerate() {
            let gap = if i == 0 { "" } else { " " };
            let _ = write!(self.body, "{gap}{},{}", Number(x), Number(y));
        }
        let _ = writeln!(
            self.body,
            r#""{paint} stroke-linejoin="round" stroke-linecap="round"/>"#
        );
    }

    pub fn circle(&mut self, centre: Point, radius: f64, paint: Paint) {
        let _ = writeln!(
            self.body,
            r#"<circle cx="{}" cy="{}" r="{}"{paint}/>"#,
            Number(centre.0),
            Number(centre.1),
            Number(radius)
        );
    }

    /// `position` is on the text's base line.
    pub fn text(&mut self, position: Point, text: &str, style: TextStyle) {
        let (x, y) = (Number(position.0), Number(position.1));
        let _ = write!(
            self.body,
            r#"<text x="{x}" y="{y}" font-family="{FONT}, Verdana, sans-serif" font-size="{}" fill="{}""#,
            Number(style.size),
            style.ink
        );
        if style.ink.opacity < 1.0 {
            let _ = write!(
                self.body,
                r#" fill-opacity="{}""#,
                Number(style.ink.opacity)
            );
        }
        match style.anchor {
            Anchor::Start => {}
            Anchor::Middle => self.body.push_str(r#" text-anchor="middle""#),
            Anchor::End => self.body.push_str(r#" text-anchor="end""#),
        }
        if style.bold {
            self.body.push_str(r#" font-weight="bold""#);
        }
        if style.upwards {
            let _ = write!(self.body, r#" transform="rotate(-90 {x} {y})""#);
        }
        self.body.push('>');
        let mut lowered = false;
        for character in text.chars() {
            if lowered && character != SUBSCRIPT_V {
                // Back to the base line; a shift lasts until the next.
                let _ = write!(
                    self.body,
                    r#"<tspan dy="-{}">"#,
                    Number(SUBSCRIPT_DROP * style.size)
                );
            }
            let raised = lowered && character != SUBSCRIPT_V;
            lowered = character == SUBSCRIPT_V;
            match character {
                SUBSCRIPT_V => {
                    let _ = write!(
                        self.body,
                        r#"<tspan dy="{}" font-size="{}">v</tspan>"#,
                        Number(SUBSCRIPT_DROP * style.size),
                        Number(SUBSCRIPT_SIZE * style.size)
                    );
                }
                '<' => self.body.push_str("&lt;"),
                '>' => self.body.push_str("&gt;"),
                '&' => self.body.push_str("&amp;"),
                // Characters that XML does not allow.
                c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => self.body.push(' '),
                c => self.body.push(c),
            }
            if raised {
                self.body.push_str("</tspan>");
            }
        }
        self.body.push_str("</text>\n");
    }

    /// Everything drawn until [`Self::close_clip`] shows only inside `rect`.
    ///
    /// A nested document rather than a clip path: clip paths need names, and names of several figures
    /// put into one page would collide.
    pub fn open_clip(&mut self, rect: Rect) {
        let (left, top) = (Number(rect.left), Number(rect.top));
        let (width, height) = (Number(rect.width.max(0.0)), Number(rect.height.max(0.0)));
        let _ = writeln!(
            self.body,
            r#"<svg x="{left}" y="{top}" width="{width}" height="{height}" viewBox="{left} {top} {width} {height}">"#
        );
    }

    pub fn close_clip(&mut self) {
        self.body.push_str("</svg>\n");
    }

    /// A rectangle filled with thin diagonal lines.
    pub fn hatch(&mut self, rect: Rect, ink: Ink, spacing: f64) {
        self.open_clip(rect);
        let reach = rect.width + rect.height;
        let lines = (reach / spacing.max(1.0)).ceil().min(2000.0) as usize;
        for i in 0..=lines {
            let x = rect.left + i as f64 * spacing;
            self.line(
                (x, rect.top),
                (x - rect.height, rect.bottom()),
                Paint::stroke(ink, 0.6),
            );
        }
        self.close_clip();
    }

    /// The document.
    pub fn finish(self) -> String {
        let (width, height) = (Number(self.width), Number(self.height));
        let mut svg = format!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}">"#
        );
        svg.push('\n');
        svg.push_str(&self.body);
        svg.push_str("</svg>\n");
        svg
    }
}

/// A coordinate in as few digits as a picture needs: hundredths, never an exponent.
struct Number(f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Far outside any sheet; renderers compute in single precision.
        let hundredths = (self.0.clamp(-1e5, 1e5) * 100.0).round() as i64;
        let (whole, rest) = (hundredths / 100, hundredths.abs() % 100);
        if hundredths < 0 && whole == 0 {
            f.write_str("-")?;
        }
        write!(f, "{whole}")?;
        match rest {
            0 => Ok(()),
            r if r % 10 == 0 => write!(f, ".{}", r / 10),
            r => write!(f, ".{r:02}"),
        }
    }
}
