//! Support phases: which feet bear weight when.
//!
//! A foot comes into contact in the control period whose mean ground reaction force exceeds a fraction
//! of body weight, and leaves it when the force falls to a smaller fraction; [`ContactRule`] then removes
//! chatter. Sums of both feet's contacts are the
//! phases double support, single support and flight.

use serde::{Deserialize, Serialize};

use crate::ratio;
use crate::recording::{Recording, Side, TIME_TOLERANCE_S, Window, column};

/// When a foot counts as being on the ground.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ContactRule {
    /// The vertical ground reaction force beyond which a foot comes into contact, as a fraction of
    /// body weight.
    ///
    /// Default 0.05: 20 N for a body of 40 kg, a customary threshold for force plates.
    pub min_force_fraction: f64,
    /// The force at which a foot in contact leaves the ground, as a fraction of body weight; one above
    /// `min_force_fraction` counts as that.
    ///
    /// Default 0.01: a rear foot that trails with a few newtons before it lifts off is still down, and
    /// must not count as lifted and set down again whenever the force wavers about one threshold.
    pub release_force_fraction: f64,
    /// An interruption of a contact shorter than this is filled, s.
    ///
    /// Default 0.02 s: a bouncing foot loses the ground for a few milliseconds, a foot that swings is
    /// off it for more than a hundred. Filled before short contacts are dropped.
    pub min_gap_s: f64,
    /// A contact shorter than this is dropped, s.
    ///
    /// Default 0.08 s: a foot that scuffs the ground in mid-swing does not make a step. Scuffs of this
    /// body's learned gaits last up to 0.05 s, stances 0.19 s and more, with nothing in between. Scuffs
    /// are counted: [`Support::scuffs`].
    pub min_contact_s: f64,
}

impl Default for ContactRule {
    fn default() -> Self {
        Self {
            min_force_fraction: 0.05,
            release_force_fraction: 0.01,
            min_gap_s: 0.02,
            min_contact_s: 0.08,
        }
    }
}

/// How many and which feet are on the ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SupportPhase {
    /// Both feet.
    Double,
    /// The right foot alone.
    SingleRight,
    /// The left foot alone.
    SingleLeft,
    /// No foot.
    Flight,
}

impl SupportPhase {
    fn from_contacts([right, left]: [bool; 2]) -> Self {
        match (right, left) {
            (true, true) => SupportPhase::Double,
            (true, false) => SupportPhase::SingleRight,
            (false, true) => SupportPhase::SingleLeft,
            (false, false) => SupportPhase::Flight,
        }
    }

    /// Whether exactly one foot is on the ground.
    pub fn is_single(self) -> bool {
        matches!(self, SupportPhase::SingleRight | SupportPhase::SingleLeft)
    }
}

/// A stretch of the recording in one support phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhaseInterval {
    /// The phase.
    pub phase: SupportPhase,
    /// Its rows, first and last instant included; neighbouring intervals share a row.
    pub window: Window,
    /// Time at which it begins, s.
    pub start_s: f64,
    /// Time at which it ends, s.
    pub end_s: f64,
}

/// Whether a foot comes down or goes up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FootEventKind {
    /// The foot comes into contact.
    Touchdown,
    /// The foot leaves the ground.
    LiftOff,
}

/// A foot comes down or goes up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FootEvent {
    /// Which foot.
    pub side: Side,
    /// What it does.
    pub kind: FootEventKind,
    /// Row at which it does so.
    pub row: usize,
    /// Time at which it does so, s.
    pub time_s: f64,
}

/// Shares of a window's time in each kind of support; they sum to one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SupportFractions {
    /// Both feet on the ground, in [0, 1].
    pub double_support: f64,
    /// One foot on the ground, in [0, 1].
    pub single_support: f64,
    /// No foot on the ground, in [0, 1].
    pub flight: f64,
}

/// The support of a whole recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Support {
    phases: Vec<PhaseInterval>,
    contacts: [Vec<Window>; 2],
    scuffs: [Vec<Window>; 2],
    events: Vec<FootEvent>,
}

impl Support {
    /// Finds the support phases of a recording. A recording of fewer than two rows has none.
    pub fn find(recording: &Recording, rule: &ContactRule) -> Self {
        let [(right, right_scuffs), (left, left_scuffs)] =
            Side::BOTH.map(|side| contact_of_periods(recording, side, rule));
        let in_contact = [right, left];
        let times = recording.column(column::TIME_S);
        let periods = recording.len().saturating_sub(1);

        let contacts = [0, 1].map(|side: usize| {
            runs(periods, |period| in_contact[side][period])
                .filter(|(touching, _)| *touching)
                .map(|(_, window)| window)
                .collect::<Vec<_>>()
        });
        let phases = runs(periods, |period| {
            SupportPhase::from_contacts([in_contact[0][period], in_contact[1][period]])
        })
        .map(|(phase, window)| PhaseInterval {
            phase,
            window,
            start_s: times[window.start_row()],
            end_s: times[window.end_row()],
        })
        .collect();

        let mut events = Vec::new();
        for side in Side::BOTH {
            let mut add = |kind, row: usize| {
                // Contacts that reach the recording's ends began before it or end after it.
                if row > 0 && row < periods {
                    events.push(FootEvent {
                        side,
                        kind,
                        row,
                        time_s: times[row],
                    });
                }
            };
            for contact in &contacts[side.index()] {
                add(FootEventKind::Touchdown, contact.start_row());
                add(FootEventKind::LiftOff, contact.end_row());
            }
        }
        events.sort_by_key(|event| (event.row, event.side));
        Self {
            phases,
            contacts,
            scuffs: [right_scuffs, left_scuffs],
            events,
        }
    }

    /// The phases in the order of time, without gaps.
    pub fn phases(&self) -> &[PhaseInterval] {
        &self.phases
    }

    /// The contacts of one foot in the order of time.
    pub fn contacts(&self, side: Side) -> &[Window] {
        &self.contacts[side.index()]
    }

    /// The contacts of one foot that were dropped as too short, in the order of time.
    pub fn scuffs(&self, side: Side) -> &[Window] {
        &self.scuffs[side.index()]
    }

    /// All touchdowns and lift-offs in the order of time; of two at once the right foot's comes first.
    pub fn events(&self) -> &[FootEvent] {
        &self.events
    }

    /// The touchdowns within a window, in the order of time.
    pub fn touchdowns(&self, window: Window) -> impl Iterator<Item = &FootEvent> {
        let from = |row: usize| self.events.partition_point(|event| event.row < row);
        self.events[from(window.start_row())..from(window.end_row() + 1)]
            .iter()
            .filter(|event| event.kind == FootEventKind::Touchdown)
    }

    /// How many control periods of a window are spent in phases that `wanted` accepts.
    pub fn periods(&self, window: Window, wanted: impl Fn(SupportPhase) -> bool) -> usize {
        self.parts(window, wanted)
            .map(|part| part.end_row() - part.start_row())
            .sum()
    }

    /// Shares of the window's time in each kind of support.
    pub fn fractions(&self, recording: &Recording, window: Window) -> Option<SupportFractions> {
        let duration_s = window.duration_s(recording);
        let share = |wanted: fn(SupportPhase) -> bool| {
            let part_s: f64 = self
                .parts(window, wanted)
                .map(|part| part.duration_s(recording))
                .sum();
            // Rounding must not make a share larger than the whole; an empty sum is -0.
            ratio(part_s, duration_s).map(|share| share.min(1.0) + 0.0)
        };
        Some(SupportFractions {
            double_support: share(|phase| phase == SupportPhase::Double)?,
            single_support: share(SupportPhase::is_single)?,
            flight: share(|phase| phase == SupportPhase::Flight)?,
        })
    }

    /// The parts of a window in phases that `wanted` accepts.
    fn parts(
        &self,
        window: Window,
        wanted: impl Fn(SupportPhase) -> bool,
    ) -> impl Iterator<Item = Window> {
        let after = |row: usize| {
            let phases = &self.phases;
            phases.partition_point(|interval| interval.window.end_row() <= row)
        };
        let (first, last) = (after(window.start_row()), after(window.end_row()));
        self.phases[first..(last + 1).min(self.phases.len())]
            .iter()
            .filter(move |interval| wanted(interval.phase))
            .filter_map(move |interval| interval.window.intersection(window))
    }
}

/// Whether the foot is in contact in each control period, chatter removed, and the contacts that were
/// dropped for it.
///
/// Period `k` lies between the rows `k` and `k + 1`; its mean force stands in row `k + 1`.
fn contact_of_periods(
    recording: &Recording,
    side: Side,
    rule: &ContactRule,
) -> (Vec<bool>, Vec<Window>) {
    let weight_n = recording.metadata.total_mass_kg * recording.metadata.gravity_m_per_s2;
    let touch_n = rule.min_force_fraction * weight_n;
    let release_n = touch_n.min(rule.release_force_fraction * weight_n);
    let forces = recording.column(column::NORMAL_FORCE_N[side.index()]);
    let mut down = false;
    let mut contact: Vec<bool> = forces
        .iter()
        .skip(1)
        .map(|&force| {
            down = force > if down { release_n } else { touch_n };
            down
        })
        .collect();
    replace_short_runs(recording, &mut contact, false, rule.min_gap_s);
    let scuffs = replace_short_runs(recording, &mut contact, true, rule.min_contact_s);
    (contact, scuffs)
}

/// Turns runs of `value` shorter than `min_duration_s` into the opposite, unless they reach the
/// recording's first or last period: how long those really lasted is unknown. Returns those runs.
fn replace_short_runs(
    recording: &Recording,
    contact: &mut [bool],
    value: bool,
    min_duration_s: f64,
) -> Vec<Window> {
    let periods = contact.len();
    let short: Vec<Window> = runs(periods, |period| contact[period])
        .filter(|&(run_value, run)| {
            run_value == value
                && run.start_row() > 0
                && run.end_row() < periods
                && run.duration_s(recording) < min_duration_s - TIME_TOLERANCE_S
        })
        .map(|(_, run)| run)
        .collect();
    for run in &short {
        contact[run.start_row()..run.end_row()].fill(!value);
    }
    short
}

/// Maximal runs of equal values over the periods `0..periods`, as windows of rows.
fn runs<'a, T: PartialEq + 'a>(
    periods: usize,
    value: impl Fn(usize) -> T + 'a,
) -> impl Iterator<Item = (T, Window)> + 'a {
    let mut start = 0;
    std::iter::from_fn(move || {
        let run_value = (start < periods).then(|| value(start))?;
        let length = (start..periods)
            .take_while(|&period| value(period) == run_value)
            .count();
        let window = Window::new(start, start + length)?;
        start += length;
        Some((run_value, window))
    })
}
