//! When a foot comes down, found while the motion goes on.

use gaitshift_body::BodyParameters;
use serde::{Deserialize, Serialize};

/// The rule of the analysis of recordings as it stands by default (`ContactRule` of gaitshift-analysis): forces as shares of
/// body weight, times in s.
const TOUCHES_FROM: f64 = 0.05;
const LEAVES_AT: f64 = 0.01;
const SHORTEST_GAP_S: f64 = 0.02;
const SHORTEST_CONTACT_S: f64 = 0.08;

/// The touchdowns of one foot as they come. Times are in integration steps.
///
/// The rule is the one by which recordings are analysed: contacts shorter than 0.08 s are scuffs, which are no touchdowns, and gaps
/// shorter than 0.02 s are none. It is known only later whether a contact is one; until then it counts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Touchdowns {
    touches_from_n: f64,
    leaves_at_n: f64,
    shortest_gap: u64,
    shortest_contact: u64,
    down: bool,
    /// When it left the ground the last time.
    left: Option<u64>,
    /// The last touchdown, unless it was a scuff.
    last: Option<u64>,
    /// The touchdown before.
    before: Option<u64>,
}

impl Touchdowns {
    /// A contact that the motion begins with has no touchdown.
    pub fn new(body: &BodyParameters) -> Self {
        let weight_n = body.total_mass_kg() * body.gravity_m_per_s2;
        let steps = |time_s: f64| (time_s / body.time_step_s).round() as u64;
        Self {
            touches_from_n: TOUCHES_FROM * weight_n,
            leaves_at_n: LEAVES_AT * weight_n,
            shortest_gap: steps(SHORTEST_GAP_S),
            shortest_contact: steps(SHORTEST_CONTACT_S),
            down: true,
            left: None,
            last: None,
            before: None,
        }
    }

    /// Sees the mean force, in N, on the foot in the control period that began at `begin`.
    pub fn see(&mut self, normal_n: f64, begin: u64) {
        let was_down = self.down;
        let least_n = if was_down {
            self.leaves_at_n
        } else {
            self.touches_from_n
        };
        self.down = normal_n > least_n;
        if was_down && !self.down {
            self.left = Some(begin);
        }
        let Some(left) = self.left else { return };
        if was_down || begin.saturating_sub(left) < self.shortest_gap {
            return;
        }
        // Off the ground for so long that the contact before is over.
        let scuff = |last: u64| left.saturating_sub(last) < self.shortest_contact;
        if self.last.is_some_and(scuff) {
            self.last = None;
        }
        if self.down {
            self.before = self.last.or(self.before);
            self.last = Some(begin);
            self.left = None;
        }
    }

    /// The last touchdown and the duration of the stride that ended with it. Both are taken back if it turns out to be a
    /// scuff.
    pub fn stride(&self) -> Option<(u64, u64)> {
        let (last, before) = (self.last?, self.before?);
        Some((last, last.saturating_sub(before)))
    }
}
