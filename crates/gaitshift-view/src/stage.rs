//! One or two bipeds under one slider, moved in steps of the control period. Knows no network and no clock.

use crate::biped::{Biped, Subject};
use crate::history::History;
use gaitshift_analysis::recording::{Recording, column};
use gaitshift_analysis::support::{Support, SupportPhase};
use gaitshift_analysis::{GaitClass, GaitRule, recent};
use gaitshift_body::{BodyParameters, ParameterError};
use gaitshift_task::OMEGA_V_MAX;
use serde::Serialize;

/// Duration of the preset changes' ramps, and of the run between them, in s.
const RAMP_S: f64 = 0.4;
const RUN_S: f64 = 6.0;
/// How long a body that fell lies before it starts again, in s of its own time.
const LIES_S: f64 = 1.5;
/// Time that the live figures and support phases are taken from, in s.
pub(crate) const SHOWN_S: f64 = 8.0;
/// Most rows that the live figures are taken from.
const MOST_ANALYSED: usize = 2000;
/// Largest force and longest duration of a push, in N and s.
const PUSH_MAX_N: f64 = 2000.0;
const PUSH_MAX_S: f64 = 2.0;

/// What is on the stage.
#[derive(Debug)]
pub struct Stage {
    pub(crate) bipeds: Vec<Biped>,
    omega_v: f64,
    /// Commands to come, one for each control period, the next one last.
    planned: Vec<f64>,
    lying_periods: u32,
    /// Counts starts and changes of bodies, so that the page does not join what does not belong together.
    pub(crate) epoch: u32,
}

/// A biped just now, as the page shows it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Now {
    pub gait: GaitClass,
    pub time_s: f64,
    pub speed_m_per_s: Option<f64>,
    pub froude: Option<f64>,
    pub cost_of_transport: Option<f64>,
    /// Kind, begin and end in s: 0 double support, 1 right, 2 left, 3 flight.
    pub phases: Vec<(u8, f64, f64)>,
}

/// A preset change of the command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Change {
    Run,
    Walk,
    Round,
}

impl Stage {
    /// One or two subjects at their starts. More than two are cut, and there must be one.
    pub fn new(subjects: Vec<Subject>) -> Self {
        let omega_v = 0.0;
        let bipeds = subjects.into_iter().take(2);
        Self {
            bipeds: bipeds.map(|subject| Biped::new(subject, omega_v)).collect(),
            omega_v,
            planned: Vec::new(),
            lying_periods: 0,
            epoch: 0,
        }
    }

    /// Control period of the stage in s: that of the first biped. A second one with another period is refused by
    /// whoever builds the stage.
    pub fn control_period_s(&self) -> f64 {
        self.bipeds.first().map_or(0.01, Biped::control_period_s)
    }

    /// The command of the slider.
    pub fn omega_v(&self) -> f64 {
        self.omega_v
    }

    /// Moves the slider; ends a preset change.
    ///
    /// # Errors
    /// A command that no motion takes.
    pub fn set_omega_v(&mut self, omega_v: f64) -> Result<(), String> {
        if !(-OMEGA_V_MAX..=OMEGA_V_MAX).contains(&omega_v) {
            return Err(format!(
                "omega_v is {omega_v}, but it must be from -{OMEGA_V_MAX} to {OMEGA_V_MAX}"
            ));
        }
        self.planned.clear();
        // Adding 0 turns -0 into 0, which is how it comes back from a profile.
        self.omega_v = omega_v + 0.0;
        Ok(())
    }

    pub(crate) fn change(&mut self, change: Change) {
        let period = self.control_period_s();
        let count = |seconds: f64| (seconds / period).round().max(1.0) as usize;
        let mut commands = Vec::new();
        let mut from = self.omega_v;
        let mut ramp_to = |commands: &mut Vec<f64>, to: f64| {
            let periods = count(RAMP_S);
            let at = |k: usize| from + (to - from) * k as f64 / periods as f64;
            commands.extend((1..periods).map(at));
            commands.push(to);
            from = to;
        };
        match change {
            Change::Run => ramp_to(&mut commands, 3.0),
            Change::Walk => ramp_to(&mut commands, 0.0),
            Change::Round => {
                ramp_to(&mut commands, 3.0);
                commands.resize(commands.len() + count(RUN_S), 3.0);
                ramp_to(&mut commands, 0.0);
            }
        }
        commands.reverse();
        self.planned = commands;
    }

    /// Moves everything one control period. Gives whether anything began anew.
    pub fn step(&mut self) -> bool {
        if self.bipeds.iter().any(|biped| biped.fell().is_some()) {
            self.lying_periods += 1;
            if f64::from(self.lying_periods) * self.control_period_s() >= LIES_S {
                self.restart();
                return true;
            }
        }
        if let Some(omega_v) = self.planned.pop() {
            self.omega_v = omega_v;
        }
        for biped in &mut self.bipeds {
            biped.step(self.omega_v);
        }
        false
    }

    /// Everything begins again from the start, on the bodies as they are.
    pub fn restart(&mut self) {
        self.lying_periods = 0;
        self.epoch += 1;
        for biped in &mut self.bipeds {
            biped.restart(self.omega_v);
        }
    }

    /// Pushes every hip with a force, forward and up in N, for a time in s.
    ///
    /// # Errors
    /// A push beyond 2000 N or 2 s.
    pub fn push(&mut self, force_n: [f64; 2], duration_s: f64) -> Result<(), String> {
        let size = force_n[0].hypot(force_n[1]);
        let fits = (0.0..=PUSH_MAX_N).contains(&size);
        if !(fits && duration_s > 0.0 && duration_s <= PUSH_MAX_S) {
            return Err(format!(
                "a push has at most {PUSH_MAX_N} N and lasts at most {PUSH_MAX_S} s; this one has {size} N for {duration_s} s"
            ));
        }
        for biped in &mut self.bipeds {
            biped.push(force_n, duration_s);
        }
        Ok(())
    }

    /// Changes parameters of the first body by name, at once; with an empty list it becomes what it was.
    ///
    /// # Errors
    /// An unknown name or a value out of range; nothing has changed then.
    pub fn change_body(&mut self, values: &[(String, f64)]) -> Result<(), String> {
        let Some(biped) = self.bipeds.first_mut() else {
            return Ok(());
        };
        let parameters = if values.is_empty() {
            biped.subject.body.parameters().clone()
        } else {
            overlay(biped.parameters(), values)?
        };
        if parameters.time_step_s != biped.parameters().time_step_s {
            return Err("time_step_s is fixed while the body moves".to_owned());
        }
        biped
            .change_body(parameters)
            .map_err(|e: ParameterError| e.to_string())?;
        self.epoch += 1;
        Ok(())
    }

    /// Puts the first controller on the stage twice, the second time on the original body, or takes that away.
    pub fn compare(&mut self, on: bool) {
        if on && self.bipeds.len() == 1 {
            let second = Subject {
                name: format!("{}, original body", self.bipeds[0].subject.name),
                ..self.bipeds[0].subject.clone()
            };
            self.bipeds.push(Biped::new(second, self.omega_v));
        } else if !on {
            self.bipeds.truncate(1);
        }
        self.restart();
    }

    /// Another controller on the stage, on its own body.
    pub fn replace(&mut self, subject: Subject) {
        self.planned.clear();
        self.bipeds = vec![Biped::new(subject, self.omega_v)];
        self.restart();
    }

    /// Number of bipeds.
    pub fn len(&self) -> usize {
        self.bipeds.len()
    }

    /// Whether nobody is on the stage.
    pub fn is_empty(&self) -> bool {
        self.bipeds.is_empty()
    }

    /// Time since the last start, in s.
    pub fn time_s(&self) -> f64 {
        self.bipeds.first().map_or(0.0, Biped::time_s)
    }

    /// Parameters of a biped's body as they are now.
    pub fn parameters(&self, index: usize) -> Option<&BodyParameters> {
        self.bipeds.get(index).map(Biped::parameters)
    }

    /// Whether a biped has fallen and is about to start again.
    pub fn fell(&self, index: usize) -> bool {
        self.bipeds
            .get(index)
            .is_some_and(|biped| biped.fell().is_some())
    }

    /// The last seconds of a biped's motion, as far as kept: a minute, and no longer than since the last start or
    /// change of its body.
    pub fn recording(&self, index: usize, seconds: f64) -> Option<Recording> {
        let rows = (seconds / self.control_period_s()).round().max(1.0) as usize;
        self.bipeds
            .get(index)
            .map(|biped| biped.recording(rows.saturating_add(1)))
    }

    /// The slider's history since the last start.
    pub fn history(&self, index: usize) -> Option<&History> {
        self.bipeds.get(index).map(|biped| &biped.history)
    }

    /// What the gait is now, by the rules of the analysis.
    pub fn gait(&self, index: usize) -> GaitClass {
        self.now(index).map_or(GaitClass::Standing, |now| now.gait)
    }

    pub(crate) fn now(&self, index: usize) -> Option<Now> {
        let biped = self.bipeds.get(index)?;
        let rows = (SHOWN_S / biped.control_period_s()).round() as usize + 1;
        let recording = biped.recording(rows.min(MOST_ANALYSED));
        let fallen = biped.fell().map(|_| GaitClass::Fallen);
        Some(describe(&recording, fallen))
    }
}

/// The end of a recording as the page shows it, and the gait that is known otherwise.
pub(crate) fn describe(recording: &Recording, known: Option<GaitClass>) -> Now {
    let rule = GaitRule::default();
    let support = Support::find(recording, &rule.contact);
    let recent = recent(
        recording,
        &support,
        &rule,
        recording.len().saturating_sub(1),
    );
    let times = recording.column(column::TIME_S);
    Now {
        gait: known.unwrap_or(recent.gait),
        time_s: times.last().copied().unwrap_or(0.0),
        speed_m_per_s: recent.speed_m_per_s,
        froude: recent.froude,
        cost_of_transport: recent.cost_of_transport,
        phases: support
            .phases()
            .iter()
            .map(|p| (phase_code(p.phase), p.start_s, p.end_s))
            .collect(),
    }
}

/// How the page tells support phases apart.
pub(crate) fn phase_code(phase: SupportPhase) -> u8 {
    match phase {
        SupportPhase::Double => 0,
        SupportPhase::SingleRight => 1,
        SupportPhase::SingleLeft => 2,
        SupportPhase::Flight => 3,
    }
}

/// The parameters with some of them replaced by name.
fn overlay(base: &BodyParameters, values: &[(String, f64)]) -> Result<BodyParameters, String> {
    let mut whole = serde_json::to_value(base).map_err(|e| e.to_string())?;
    for (name, value) in values {
        match whole.get_mut(name) {
            // Counts stay as they are: everything else is a floating-point number.
            Some(slot) if slot.is_f64() => *slot = serde_json::json!(value),
            _ => return Err(format!("a body has no parameter `{name}` to change here")),
        }
    }
    serde_json::from_value(whole).map_err(|e| e.to_string())
}
