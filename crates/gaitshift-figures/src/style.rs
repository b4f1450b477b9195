//! Colours and sizes shared by all pictures.
//!
//! Colours are from the palette of M. Okabe and K. Ito ("Color universal design", 2008), which people
//! with any colour vision can tell apart. Right is always vermilion, left always blue.

use gaitshift_analysis::recording::Side;

use crate::canvas::{Ink, TextStyle};

pub(crate) const TEXT: Ink = Ink::hex(0x222222);
pub(crate) const QUIET: Ink = Ink::hex(0x6a6a6a);
pub(crate) const FAINT: Ink = Ink::hex(0xdddddd);
pub(crate) const WHITE: Ink = Ink::hex(0xffffff);
pub(crate) const RIGHT: Ink = Ink::hex(0xd55e00);
pub(crate) const LEFT: Ink = Ink::hex(0x0072b2);
pub(crate) const COMMAND: Ink = Ink::hex(0x008060);
/// The same colour as [`PAPER`], which is nowhere in the same picture.
pub(crate) const PUSH: Ink = PAPER;
pub(crate) const PAPER: Ink = Ink::hex(0xcc79a7);

/// Text along axes, in legends and titles, in user units.
pub(crate) const SMALL: f64 = 11.0;
pub(crate) const MEDIUM: f64 = 12.5;

pub(crate) const LABEL: TextStyle = TextStyle::new(SMALL, TEXT);
pub(crate) const TITLE: TextStyle = TextStyle::new(MEDIUM, TEXT);

/// Colour of a leg and everything that belongs to it.
pub(crate) const fn side_ink(side: Side) -> Ink {
    match side {
        Side::Right => RIGHT,
        Side::Left => LEFT,
    }
}

/// Fill of what belongs to a leg: the left one, which is behind, is paler, for both colours are equally dark in grey print.
pub(crate) fn side_fill(side: Side) -> Ink {
    match side {
        Side::Right => RIGHT,
        Side::Left => LEFT.mix(WHITE, 0.55),
    }
}

/// Colours of series drawn over each other.
pub(crate) const SERIES: [Ink; 6] = [
    LEFT,
    RIGHT,
    Ink::hex(0x009e73),
    Ink::hex(0xe69f00),
    Ink::hex(0x56b4e9),
    Ink::hex(0x555555),
];
