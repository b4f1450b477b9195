//! Where the entries of a legend stand: beside each other, in as many rows as the width needs.

use crate::canvas::Point;
use crate::raster::text_width;
use crate::style::SMALL;

/// How the entries of a legend follow each other, in user units.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spacing {
    /// From an entry's begin to its name: the swatch and what is left free behind it.
    pub name: f64,
    /// From an entry's end to the next.
    pub gap: f64,
    /// From a base line to the next.
    pub row: f64,
}

/// The place of each entry relative to the first row's begin and base line, and the height of all rows. An entry that is wider than
/// `width` has a row of its own.
pub(crate) fn places<'a>(
    names: impl IntoIterator<Item = &'a str>,
    spacing: Spacing,
    width: f64,
) -> (Vec<Point>, f64) {
    let (mut x, mut y) = (0.0, 0.0);
    let mut places = Vec::new();
    for name in names {
        let entry = spacing.name + text_width(name, SMALL);
        if x > 0.0 && x + entry > width {
            (x, y) = (0.0, y + spacing.row);
        }
        places.push((x, y));
        x += entry + spacing.gap;
    }
    (places, y + spacing.row)
}
