//! What a motion is just now: the rules for whole motions, on its latest steps.

use crate::cost::{cost_of_transport, froude_number, speed_m_per_s};
use crate::gait::{GaitClass, GaitEvidence, GaitRule};
use crate::recording::{Recording, Window, column};
use crate::steps::whole_strides;
use crate::support::Support;

/// A motion in its latest moments; `None` stands for what is undefined there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recent {
    /// What the latest steps are, by [`GaitEvidence::classify`].
    pub gait: GaitClass,
    /// Mean forward speed over the latest whole strides, or over half a second without one, m/s.
    pub speed_m_per_s: Option<f64>,
    /// Froude number `v / √(g l)` of that speed.
    pub froude: Option<f64>,
    /// Cost of transport (8) over the latest whole strides.
    pub cost_of_transport: Option<f64>,
}

/// Time over which speed is taken where there is no whole stride, s.
const SPEED_WINDOW_S: f64 = 0.5;

/// Describes the motion at `row` from the rows up to it.
///
/// The gait is that of the latest [`GaitRule::min_steps`] steps and whatever followed them; if as many steps do not
/// lie within the time that so many of the longest steps take, that of all this time. Once no foot has been set down
/// for longer than a step may take, it is that of the time since. `support` must be that of the recording. Speed and cost
/// are means over the same steps, cut to whole strides.
pub fn recent(recording: &Recording, support: &Support, rule: &GaitRule, row: usize) -> Recent {
    let times = recording.column(column::TIME_S);
    let unknown = Recent {
        gait: GaitClass::Standing,
        speed_m_per_s: None,
        froude: None,
        cost_of_transport: None,
    };
    let Some(&now_s) = times.get(row) else {
        return unknown;
    };
    let longest_s = rule.min_steps as f64 * rule.max_step_time_s;
    let begin = times.partition_point(|&time_s| time_s < now_s - longest_s);
    let Some(all) = Window::new(begin, row) else {
        return unknown;
    };
    let rows: Vec<usize> = support.touchdowns(all).map(|event| event.row).collect();
    let stopped = rows
        .last()
        .filter(|&&last| now_s - times[last] > rule.max_step_time_s)
        .and_then(|&last| Window::new(last + 1, row));
    let latest = rows
        .len()
        .checked_sub(rule.min_steps.saturating_add(1))
        .and_then(|first| Window::new(rows[first], row));
    let window = stopped.or(latest).unwrap_or(all);
    let strides = whole_strides(support, window);
    let lately = recording.window(now_s - SPEED_WINDOW_S, now_s);
    let speed = strides
        .or(lately)
        .or(Some(window))
        .and_then(|window| speed_m_per_s(recording, window));
    Recent {
        gait: GaitEvidence::gather(recording, support, window).classify(rule),
        speed_m_per_s: speed,
        froude: speed.and_then(|speed| froude_number(recording, speed)),
        cost_of_transport: strides.and_then(|strides| cost_of_transport(recording, strides)),
    }
}
