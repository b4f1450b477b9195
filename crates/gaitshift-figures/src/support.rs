//! Support phases as pictures show them: shades behind charts, bars under them.

use gaitshift_analysis::recording::{Recording, Side};
use gaitshift_analysis::support::{ContactRule, PhaseInterval, Support, SupportPhase};

use crate::canvas::{Canvas, Ink, Paint, Rect};
use crate::chart::Panel;
use crate::style::{LEFT, RIGHT, WHITE, side_fill};

/// All phases in the order in which legends list them.
pub(crate) const PHASES: [SupportPhase; 4] = [
    SupportPhase::Double,
    SupportPhase::SingleRight,
    SupportPhase::SingleLeft,
    SupportPhase::Flight,
];

/// Support by the default contact rule, which all figures use.
pub(crate) fn find(recording: &Recording) -> Support {
    Support::find(recording, &ContactRule::default())
}

pub(crate) fn name(phase: SupportPhase) -> &'static str {
    match phase {
        SupportPhase::Double => "double support",
        SupportPhase::SingleRight => "right only",
        SupportPhase::SingleLeft => "left only",
        SupportPhase::Flight => "flight",
    }
}

/// Light enough to read curves on, and of different lightness for print without colour.
pub(crate) fn shade(phase: SupportPhase) -> Ink {
    match phase {
        SupportPhase::Double => Ink::hex(0xadadad),
        SupportPhase::SingleRight => RIGHT.mix(WHITE, 0.6),
        SupportPhase::SingleLeft => LEFT.mix(WHITE, 0.87),
        SupportPhase::Flight => WHITE,
    }
}

/// Shades the panel, whose x is time in s, by support phase.
pub(crate) fn shade_panel(canvas: &mut Canvas, panel: &Panel, phases: &[PhaseInterval]) {
    for interval in phases
        .iter()
        .filter(|interval| interval.phase != SupportPhase::Flight)
    {
        let band = panel.band(interval.start_s, interval.end_s);
        if band.width > 0.0 {
            canvas.rect(band, Paint::fill(shade(interval.phase)));
        }
    }
}

/// Two bars over the width of `area`, which spans `from_s` to `to_s`: right above left, filled while
/// that foot is on the ground.
pub(crate) fn contact_bars(
    canvas: &mut Canvas,
    area: Rect,
    (from_s, to_s): (f64, f64),
    support: &Support,
    times_s: &[f64],
) {
    let height = 0.42 * area.height;
    let place = |time: f64| area.left + (time - from_s) / (to_s - from_s).max(1e-9) * area.width;
    for side in Side::BOTH {
        let top = match side {
            Side::Right => area.top,
            Side::Left => area.bottom() - height,
        };
        let row = Rect::new(area.left, top, area.width, height);
        canvas.rect(row, Paint::fill(Ink::hex(0xf0f0f0)));
        for contact in support.contacts(side) {
            let (start, end) = (times_s[contact.start_row()], times_s[contact.end_row()]);
            if end > from_s && start < to_s {
                let (left, right) = (place(start.max(from_s)), place(end.min(to_s)));
                let bar = Rect::new(left, top, right - left, height);
                canvas.rect(bar, Paint::fill(side_fill(side)));
            }
        }
    }
}
