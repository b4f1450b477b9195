//! The curriculum as data: phases with their lengths, ranges of the command and changed weights.

use crate::error::require;
use crate::overrides::blend;
use crate::{LearnerSettings, Overrides, Randomization, RewardParameters, TaskError};
use gaitshift_body::BodyParameters;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Most environment steps of a phase: their sum must stay countable.
const MOST_STEPS: u64 = 1_000_000_000_000_000;
/// Largest |ω_v| that is taken anywhere: far beyond what any controller was trained for, far below where numbers overflow.
pub const OMEGA_V_MAX: f64 = 100.0;

/// One phase of training. Everything optional stays as the task has it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Phase {
    /// Name, for logs.
    pub name: String,
    /// Length in environment steps.
    pub steps: u64,
    /// Range from which `ω_v` is drawn, at the start of the phase.
    pub omega_v: [f64; 2],
    /// Range at its end; between the two the range moves linearly. Default: the same range.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub omega_v_end: Option<[f64; 2]>,
    /// Keys of the reward that the phase replaces.
    #[serde(default, skip_serializing_if = "Overrides::is_empty")]
    pub reward: Overrides<RewardParameters>,
    /// Keys of the reward that move linearly during the phase, and where to.
    #[serde(default, skip_serializing_if = "Overrides::is_empty")]
    pub reward_end: Overrides<RewardParameters>,
    /// Weights of reward terms of one's own that the phase replaces, by their names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub reward_extra: BTreeMap<String, f64>,
    /// Such weights that move linearly during the phase, and where to.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub reward_extra_end: BTreeMap<String, f64>,
    /// Settings of the learner that the phase replaces.
    #[serde(default, skip_serializing_if = "Overrides::is_empty")]
    pub learner: Overrides<LearnerSettings>,
    /// Settings of the learner that move linearly during the phase, and where to.
    #[serde(default, skip_serializing_if = "Overrides::is_empty")]
    pub learner_end: Overrides<LearnerSettings>,
    /// Episodes on bodies, delays and sensors that differ. Default: all as they are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub randomization: Option<Randomization>,
}

/// How `ω_v` is drawn from the phase's range.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CommandDraw {
    /// Mean time between changes of the command within an episode, in s; 0: never (the paper).
    pub redraw_interval_s: f64,
    /// Longest ramp of such a change, in s; its length is drawn uniformly from 0 to this.
    pub redraw_ramp_s: f64,
    /// *Open.* Control periods for which a command is held, over falls: an episode that falls starts again
    /// under the same command, one that lasts is cut off when they are over. So every command gets the
    /// same number of steps. 0: every episode draws its own, and commands that fall get fewer steps.
    pub hold_periods: u32,
}

impl Default for CommandDraw {
    fn default() -> Self {
        Self {
            redraw_interval_s: 0.0,
            redraw_ramp_s: 0.4,
            hold_periods: 0,
        }
    }
}

/// The phases of a training run in order, and how commands are drawn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Curriculum {
    /// How `ω_v` is drawn.
    pub command: CommandDraw,
    /// The phases.
    pub phases: Vec<Phase>,
}

/// What holds at one step of training.
#[derive(Debug, Clone, PartialEq)]
pub struct PhaseSettings {
    /// Index of the phase.
    pub index: usize,
    /// Range of `ω_v`.
    pub omega_v: [f64; 2],
    /// How `ω_v` is drawn from it.
    pub command: CommandDraw,
    /// The reward in force.
    pub reward: RewardParameters,
    /// What else differs from episode to episode, if the phase asks for it.
    pub randomization: Option<Randomization>,
}

impl Default for Curriculum {
    /// The paper's schedule: 10 million steps in two phases, the first relaxed at its beginning.
    fn default() -> Self {
        let phase = |name: &str, steps, omega_v| Phase {
            name: name.to_owned(),
            steps,
            omega_v,
            ..Phase::default()
        };
        let relaxed = Overrides::from([("omega_e", 0.06), ("omega_s", 0.0)]);
        Self {
            command: CommandDraw::default(),
            phases: vec![
                Phase {
                    reward: relaxed,
                    ..phase("I, relaxed", 500_000, [-0.2, 0.2])
                },
                phase("I", 4_000_000, [-0.2, 0.2]),
                phase("II", 5_500_000, [-0.5, 3.5]),
            ],
        }
    }
}

impl Curriculum {
    /// Total length in environment steps.
    pub fn total_steps(&self) -> u64 {
        self.phases.iter().map(|p| p.steps).sum()
    }

    /// The phase of environment step `step`, its index, and how far it has come, from 0 to 1. Past the end the last
    /// phase goes on; none where there are no phases.
    fn phase(&self, step: u64) -> Option<(usize, &Phase, f64)> {
        let mut start = 0;
        let last = self.phases.len().checked_sub(1)?;
        let mut phases = self.phases.iter().enumerate();
        phases.find_map(|(index, phase)| {
            if step < start + phase.steps || index == last {
                let progress = ((step - start) as f64 / phase.steps.max(1) as f64).clamp(0.0, 1.0);
                return Some((index, phase, progress));
            }
            start += phase.steps;
            None
        })
    }

    /// What holds at environment step `step`, given the task's own reward.
    /// Past the end the last phase goes on.
    pub fn at(&self, step: u64, reward: &RewardParameters) -> PhaseSettings {
        let Some((index, phase, progress)) = self.phase(step) else {
            return PhaseSettings {
                index: 0,
                omega_v: [0.0, 0.0],
                command: self.command.clone(),
                reward: reward.clone(),
                randomization: None,
            };
        };
        let end = phase.omega_v_end.unwrap_or(phase.omega_v);
        let mix = |k: usize| phase.omega_v[k] + progress * (end[k] - phase.omega_v[k]);
        let mut reward = reward.clone();
        phase.reward.blend_into(&mut reward, 1.0);
        phase.reward_end.blend_into(&mut reward, progress);
        let weights = [
            (&phase.reward_extra, 1.0),
            (&phase.reward_extra_end, progress),
        ];
        for (weights, share) in weights {
            for (name, weight) in weights {
                if let Some(current) = reward.extra.weight_mut(name) {
                    *current = blend(*current, *weight, share);
                }
            }
        }
        PhaseSettings {
            index,
            omega_v: [mix(0), mix(1)],
            command: self.command.clone(),
            reward,
            randomization: phase.randomization.clone(),
        }
    }

    /// The learner's settings at environment step `step`, given those that it has where no phase says otherwise.
    pub fn learner_at(&self, step: u64, own: &LearnerSettings) -> LearnerSettings {
        let mut settings = *own;
        if let Some((_, phase, progress)) = self.phase(step) {
            phase.learner.blend_into(&mut settings, 1.0);
            phase.learner_end.blend_into(&mut settings, progress);
        }
        settings
    }

    /// The first environment step of the first phase that rehearses, if one does.
    pub fn rehearsal_start(&self) -> Option<u64> {
        let rehearses = |phase: &Phase| {
            let weights = [&phase.learner, &phase.learner_end];
            weights
                .iter()
                .any(|table| table.get("rehearsal") > Some(0.0))
        };
        let before = self.phases.iter().position(rehearses)?;
        Some(self.phases[..before].iter().map(|phase| phase.steps).sum())
    }

    /// Whether a phase with a randomization has begun by environment step `step`.
    pub fn randomizes_by(&self, step: u64) -> bool {
        let begun = self.phase(step).map_or(0, |(now, ..)| now + 1);
        let mut phases = self.phases[..begun].iter();
        phases.any(|phase| phase.randomization.is_some())
    }

    /// The settings at the end of the last phase with a randomization, if there is one.
    pub fn last_randomized(&self, reward: &RewardParameters) -> Option<PhaseSettings> {
        let randomizes = |phase: &Phase| phase.randomization.is_some();
        let last = self.phases.iter().rposition(randomizes)?;
        let end: u64 = self.phases[..=last].iter().map(|phase| phase.steps).sum();
        Some(self.at(end.saturating_sub(1), reward))
    }

    /// Checks every field, for training on `body` with a task of this reward.
    ///
    /// # Errors
    /// The first field out of range.
    pub fn validate(
        &self,
        body: &BodyParameters,
        reward: &RewardParameters,
    ) -> Result<(), TaskError> {
        let c = &self.command;
        require(
            (1..=1000).contains(&self.phases.len()),
            "curriculum.phases",
            format!("a list of {}", self.phases.len()),
            "a list of 1 to 1000 phases",
        )?;
        for (key, value) in [
            ("curriculum.command.redraw_interval_s", c.redraw_interval_s),
            ("curriculum.command.redraw_ramp_s", c.redraw_ramp_s),
        ] {
            require(
                value.is_finite() && value >= 0.0,
                key,
                value,
                "0 or greater",
            )?;
        }
        require(
            c.hold_periods == 0 || c.redraw_interval_s == 0.0,
            "curriculum.command.hold_periods",
            c.hold_periods,
            "0 where `redraw_interval_s` lets commands change within episodes",
        )?;
        let possible = |r: [f64; 2]| -OMEGA_V_MAX <= r[0] && r[0] <= r[1] && r[1] <= OMEGA_V_MAX;
        let range = "[low, high] with -100 <= low <= high <= 100";
        for (i, p) in self.phases.iter().enumerate() {
            let key = |name: &str| format!("curriculum.phases[{i}].{name}");
            require(
                (1..=MOST_STEPS).contains(&p.steps),
                &key("steps"),
                p.steps,
                "between 1 and 1e15",
            )?;
            require(
                self.phases[..i].iter().all(|before| before.name != p.name),
                &key("name"),
                format!("{:?} again", p.name),
                "a name of its own, by which the phase can be changed",
            )?;
            require(possible(p.omega_v), &key("omega_v"), p.omega_v, range)?;
            if let Some(r) = p.omega_v_end {
                require(possible(r), &key("omega_v_end"), r, range)?;
            }
            p.reward.validate(&key("reward"))?;
            p.reward_end.validate(&key("reward_end"))?;
            for (table, weights) in [
                ("reward_extra", &p.reward_extra),
                ("reward_extra_end", &p.reward_extra_end),
            ] {
                for (name, weight) in weights {
                    let key = key(&format!("{table}.{name}"));
                    let known = reward.extra.names().any(|known| known == name);
                    require(
                        known,
                        &key,
                        weight,
                        "the weight of a term that `task.reward.extra` has",
                    )?;
                    require(weight.is_finite(), &key, weight, "finite")?;
                }
            }
            p.learner.validate(&key("learner"))?;
            p.learner_end.validate(&key("learner_end"))?;
            if let Some(randomization) = &p.randomization {
                randomization.validate(&key("randomization"), body)?;
            }
        }
        Ok(())
    }
}
