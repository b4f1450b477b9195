//! What feet do besides bearing weight: how high they swing, and how they rub the ground.

use crate::recording::{Recording, Side, Window, column, detail};
use crate::support::{FootEventKind, Support};
use crate::{cost, ratio, statistics};

/// Height of the sole's lowest point over the ground as a swinging leg passes the other one, m, mean over the whole swings of a
/// leg in a window; of a swing that passes more than once, the lowest.
///
/// There a leg without a knee is nearest to the ground. `None` without the detail, or if no swing passes the other leg:
/// in a hop the legs swing together.
pub fn clearance_m(
    recording: &Recording,
    support: &Support,
    side: Side,
    window: Window,
) -> Option<f64> {
    let heights = recording.detail(detail::SOLE_HEIGHT_M[side.index()])?;
    let [own, other] =
        [side, side.other()].map(|side| recording.column(column::PHI_RAD[side.index()]));
    let ahead = |row: usize| own[row] - other[row];
    let events: Vec<_> = support
        .events()
        .iter()
        .filter(|event| event.side == side && window.contains(event.row))
        .collect();
    let clearances: Vec<f64> = events
        .windows(2)
        .filter(|pair| {
            (pair[0].kind, pair[1].kind) == (FootEventKind::LiftOff, FootEventKind::Touchdown)
        })
        .filter_map(|swing| {
            let passings = (swing[0].row..swing[1].row).filter_map(|row| {
                let (before, after) = (ahead(row), ahead(row + 1));
                // Forward or backward.
                let passes = (before < 0.0) != (after < 0.0);
                let share = before / (before - after);
                passes.then(|| heights[row] + share * (heights[row + 1] - heights[row]))
            });
            passings.reduce(f64::min)
        })
        .collect();
    statistics::mean(&clearances)
}

/// Work of friction of both feet per metre, J/m: of feet in stance, and of feet that should be swinging.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rubbing {
    /// Slip of standing feet.
    pub slip_j_per_m: f64,
    /// Drag of feet between stances: scuffs, and contacts too light to count.
    pub drag_j_per_m: f64,
}

impl Rubbing {
    /// `None` without the detail, or where there is no cost of transport.
    pub fn find(recording: &Recording, support: &Support, window: Window) -> Option<Self> {
        let way_m = cost::way_m(recording, window)?;
        let (mut slip_j, mut all_j) = (0.0, 0.0);
        for side in Side::BOTH {
            let friction = detail::FRICTION_DISSIPATION_J[side.index()];
            all_j += window.detail_change(recording, friction)?;
            for contact in support.contacts(side) {
                if let Some(stance) = contact.intersection(window) {
                    slip_j += stance.detail_change(recording, friction)?;
                }
            }
        }
        Some(Self {
            slip_j_per_m: ratio(slip_j, way_m)?,
            drag_j_per_m: ratio((all_j - slip_j).max(0.0), way_m)?,
        })
    }
}
