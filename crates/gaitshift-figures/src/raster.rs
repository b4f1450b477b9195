//! From SVG text to pixels, in software and with a built-in font.

use std::sync::{Arc, LazyLock};

pub(crate) use resvg::tiny_skia::Color;
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{self, fontdb};

use crate::FigureError;
use crate::canvas::{Canvas, FONT, Ink, TextStyle};

/// Only the built-in faces: what is installed on the machine must not change a picture.
static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    for face in [dejavu::sans::regular(), dejavu::sans::bold()] {
        fonts.load_font_source(fontdb::Source::Binary(Arc::new(face)));
    }
    fonts.set_sans_serif_family(FONT);
    Arc::new(fonts)
});

/// Largest picture in pixels; 64 megapixels take 256 MB.
const MOST_PIXELS: f64 = 64e6;

/// Draws `svg` on `ground` with `scale` pixels for each user unit. On an opaque ground a last row or column that the picture covers
/// in part is opaque, too.
pub(crate) fn pixels(svg: &str, scale: f64, ground: Color) -> Result<Pixmap, FigureError> {
    let tree = parse(svg)?;
    let size = tree.size();
    let width = (f64::from(size.width()) * scale).round().max(1.0);
    let height = (f64::from(size.height()) * scale).round().max(1.0);
    let pixmap = if width * height <= MOST_PIXELS {
        Pixmap::new(width as u32, height as u32)
    } else {
        None
    };
    let mut pixmap = pixmap.ok_or_else(|| FigureError::Raster {
        cause: format!("{width} by {height} pixels are too many; choose a smaller scale"),
    })?;
    pixmap.fill(ground);
    let scale = scale as f32;
    resvg::render(
        &tree,
        Transform::from_scale(scale, scale),
        &mut pixmap.as_mut(),
    );
    Ok(pixmap)
}

/// Width of `text` in user units, as the built-in font sets it.
pub(crate) fn text_width(text: &str, size: f64) -> f64 {
    let mut canvas = Canvas::new(10.0, 10.0);
    canvas.text((0.0, 0.0), text, TextStyle::new(size, Ink::hex(0)));
    let width_of_nodes = |tree: usvg::Tree| {
        let texts = tree
            .root()
            .children()
            .iter()
            .filter(|n| matches!(n, usvg::Node::Text(_)));
        texts.map(|n| f64::from(n.bounding_box().width())).sum()
    };
    parse(&canvas.finish()).map_or(0.0, width_of_nodes)
}

fn parse(svg: &str) -> Result<usvg::Tree, FigureError> {
    let options = usvg::Options {
        fontdb: FONTS.clone(),
        ..usvg::Options::default()
    };
    usvg::Tree::from_str(svg, &options).map_err(|cause| FigureError::Raster {
        cause: cause.to_string(),
    })
}

/// The text, or as much of its beginning as fits into this width, in user units.
pub(crate) fn fitting(text: &str, size: f64, widest: f64) -> String {
    if text_width(text, size) <= widest {
        return text.to_owned();
    }
    let ends: Vec<usize> = text.char_indices().map(|(end, _)| end).collect();
    let fits = |&end: &usize| text_width(&text[..end], size) <= widest - 0.75 * size;
    let longest = ends.partition_point(fits).saturating_sub(1);
    format!("{}…", ends.get(longest).map_or("", |&end| &text[..end]))
}
