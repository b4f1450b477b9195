//! Gait class of a steady motion, after R. McN. Alexander's definition (1996): walking has double
//! support, running has flight.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::cost::speed_m_per_s;
use crate::recording::{Recording, Window};
use crate::steps::{Step, find_steps, foot_slide, step_time_asymmetry};
use crate::support::{ContactRule, Support, SupportFractions};

/// What a motion is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GaitClass {
    /// No foot is ever set down anew, or the body stays where it is without leaving the ground. A body
    /// that skates with both feet on the ground stands on them.
    Standing,
    /// The feet step in turn, with double support in every step and without flight.
    Walking,
    /// The feet step in turn, with flight in every step and without double support.
    Running,
    /// It moves in another way: limping, hopping, shuffling, skating with lifted feet, changing gait.
    #[default]
    Mixed,
    /// The body fell, or its simulation diverged.
    Fallen,
}

impl fmt::Display for GaitClass {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            GaitClass::Standing => "standing",
            GaitClass::Walking => "walking",
            GaitClass::Running => "running",
            GaitClass::Mixed => "mixed",
            GaitClass::Fallen => "fallen",
        })
    }
}

/// What counts as walking, running and standing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GaitRule {
    /// When a foot counts as being on the ground.
    pub contact: ContactRule,
    /// Slower than this, in either direction, is neither walking nor running, m/s.
    ///
    /// Default 0.1 m/s, a Froude number of 0.04 for a leg of 0.8 m: slower motion is swaying or
    /// treading on the spot.
    pub min_speed_m_per_s: f64,
    /// The least number of steps in a gait. Default 4: two whole strides.
    pub min_steps: usize,
    /// Share of the steps that must be steps of the gait. Default 0.95: one stumble in twenty steps is
    /// tolerated.
    pub min_step_share: f64,
    /// Control periods in double support (or in flight) that make a step one with double support (or
    /// with flight).
    ///
    /// Default 2: forces are means over a control period, so that a foot taking over from the other
    /// within one period looks like one period of double support.
    pub min_phase_periods: usize,
    /// Largest share of time in flight in a walk, in double support in a run. Default 0.01.
    pub max_foreign_share: f64,
    /// The longest time between touchdowns, or from the window's ends to the nearest, in a gait, s.
    ///
    /// Default 1.5 s, more than twice a slow step of a body with legs of 0.8 m: whoever pauses longer
    /// has stopped walking.
    pub max_step_time_s: f64,
    /// Largest [`step_time_asymmetry`]; beyond it the motion limps.
    ///
    /// Default 0.3: one step lasts a third longer than the other. Healthy people stay below 0.1.
    pub max_step_time_asymmetry: f64,
    /// Largest [`foot_slide`]; beyond it the motion skates.
    ///
    /// Default 0.3: feet on the ground go along for less than a third of the hip's way.
    pub max_foot_slide: f64,
}

impl Default for GaitRule {
    fn default() -> Self {
        Self {
            contact: ContactRule::default(),
            min_speed_m_per_s: 0.1,
            min_steps: 4,
            min_step_share: 0.95,
            min_phase_periods: 2,
            max_foreign_share: 0.01,
            max_step_time_s: 1.5,
            max_step_time_asymmetry: 0.3,
            max_foot_slide: 0.3,
        }
    }
}

impl GaitRule {
    /// Whether both feet are on the ground in the step for long enough to count.
    pub fn has_double_support(&self, step: &Step) -> bool {
        step.double_support_periods >= self.min_phase_periods
    }

    /// Whether no foot is on the ground in the step for long enough to count.
    pub fn has_flight(&self, step: &Step) -> bool {
        step.flight_periods >= self.min_phase_periods
    }

    /// The gait to which a single step belongs: walking, running or, for all others, mixed.
    pub fn class_of_step(&self, step: &Step) -> GaitClass {
        match (
            step.alternates(),
            self.has_double_support(step),
            self.has_flight(step),
        ) {
            (true, true, false) => GaitClass::Walking,
            (true, false, true) => GaitClass::Running,
            _ => GaitClass::Mixed,
        }
    }
}

/// The figures on which the gait class of a window rests.
#[derive(Debug, Clone, PartialEq)]
pub struct GaitEvidence {
    /// Mean forward speed of the hip, m/s.
    pub speed_m_per_s: Option<f64>,
    /// Shares of time in double support, single support and flight.
    pub support: Option<SupportFractions>,
    /// The steps that begin and end within the window.
    pub steps: Vec<Step>,
    /// Number of touchdowns within the window.
    pub touchdowns: usize,
    /// The longest time without a touchdown, the window's ends included, s.
    pub longest_pause_s: f64,
    /// Limping index, see [`step_time_asymmetry`].
    pub step_time_asymmetry: Option<f64>,
    /// Sliding of the feet, see [`foot_slide`].
    pub foot_slide: Option<f64>,
}

impl GaitEvidence {
    /// Gathers the figures from a window of a recording.
    pub fn gather(recording: &Recording, support: &Support, window: Window) -> Self {
        let steps = find_steps(recording, support, window);
        let times = recording.column(crate::recording::column::TIME_S);
        let mut longest_pause_s = 0.0_f64;
        let mut previous_s = times[window.start_row()];
        let touchdown_times = support.touchdowns(window).map(|touchdown| touchdown.time_s);
        for time_s in touchdown_times.chain([times[window.end_row()]]) {
            longest_pause_s = longest_pause_s.max(time_s - previous_s);
            previous_s = time_s;
        }
        Self {
            speed_m_per_s: speed_m_per_s(recording, window),
            support: support.fractions(recording, window),
            touchdowns: support.touchdowns(window).count(),
            longest_pause_s,
            step_time_asymmetry: step_time_asymmetry(&steps),
            foot_slide: foot_slide(recording, support, window),
            steps,
        }
    }

    /// Share of the steps that `wanted` accepts, in [0, 1]; `None` without steps.
    pub fn share_of_steps(&self, wanted: impl Fn(&Step) -> bool) -> Option<f64> {
        let wanted = self.steps.iter().filter(|step| wanted(step)).count();
        crate::ratio(wanted as f64, self.steps.len() as f64)
    }

    /// The gait class by the rule. Never [`GaitClass::Fallen`], which is the recording's to say.
    pub fn classify(&self, rule: &GaitRule) -> GaitClass {
        let (Some(speed_m_per_s), Some(support)) = (self.speed_m_per_s, self.support) else {
            return GaitClass::Mixed;
        };
        let grounded = support.flight <= rule.max_foreign_share;
        let moves = speed_m_per_s.abs() >= rule.min_speed_m_per_s;
        if grounded && (self.touchdowns == 0 || !moves) {
            return GaitClass::Standing;
        }
        let steady = moves
            && self.steps.len() >= rule.min_steps
            && self.longest_pause_s <= rule.max_step_time_s
            && at_most(self.step_time_asymmetry, rule.max_step_time_asymmetry)
            && at_most(self.foot_slide, rule.max_foot_slide);
        let made_of = |class| {
            self.share_of_steps(|step| rule.class_of_step(step) == class)
                .is_some_and(|share| share >= rule.min_step_share)
        };
        if steady && grounded && made_of(GaitClass::Walking) {
            GaitClass::Walking
        } else if steady
            && support.double_support <= rule.max_foreign_share
            && made_of(GaitClass::Running)
        {
            GaitClass::Running
        } else {
            GaitClass::Mixed
        }
    }
}

fn at_most(value: Option<f64>, limit: f64) -> bool {
    value.is_some_and(|value| value <= limit)
}
