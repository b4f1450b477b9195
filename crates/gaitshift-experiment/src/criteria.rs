//! What is asked of a finished controller: `[criteria]` of an experiment.

use gaitshift_analysis::GaitClass;
use gaitshift_task::OMEGA_V_MAX;
use serde::{Deserialize, Serialize};

/// Longest motion, in s: as that of `gaitshift evaluate`.
const DURATION_MAX_S: f64 = 3600.0;
/// Most motions that a list may ask for.
const MOST: usize = 1000;

/// What a controller is tried on, and the bounds it has to keep. The defaults ask for what the paper
/// reports: walking at ω_v = 0, running at 3, its range of speeds, its costs of transport, and both
/// changes of gait from any phase of the stride: 39 criteria. A bound of 0 asks nothing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Criteria {
    /// Commands, each held for `duration_s` without a fall: a criterion each.
    pub omega_v: Vec<f64>,
    /// Duration of those motions, in s.
    pub duration_s: f64,
    /// The slowest of the motions that last has at most this Froude number.
    pub slowest_froude_max: f64,
    /// The fastest of them has at least this Froude number.
    pub fastest_froude_min: f64,
    /// The gaits asked for.
    pub gaits: Vec<AskedGait>,
    /// The changes of gait asked for.
    pub changes: Vec<AskedChange>,
}

/// A gait that is asked for under a command. Its bounds hold only of a motion that is that gait.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AskedGait {
    /// The command, one of [`Criteria::omega_v`].
    pub omega_v: f64,
    /// Walking, running or standing.
    pub gait: GaitClass,
    /// Least Froude number.
    #[serde(default)]
    pub froude_min: f64,
    /// Greatest Froude number.
    #[serde(default)]
    pub froude_max: f64,
    /// Greatest cost of transport.
    #[serde(default)]
    pub cost_of_transport_max: f64,
    /// Least magnitude of the energy correlations of that gait: walking, kinetic with potential energy, negative;
    /// running in single support, kinetic with potential energy, positive, and elastic with either, negative.
    #[serde(default)]
    pub correlation: f64,
}

/// A change between two commands at which gaits are asked for, from the one gait to the other without a fall.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AskedChange {
    /// The command before.
    pub from: f64,
    /// The command after.
    pub to: f64,
    /// Number of different phases of the stride from which it is tried: a criterion each.
    #[serde(default = "ten_phases")]
    pub phases: usize,
    /// Duration of the ramp of the command, in s.
    #[serde(default = "ramp_s")]
    pub ramp_s: f64,
    /// Time of steady motion before the ramp and after it, in s.
    #[serde(default = "steady_s")]
    pub steady_s: f64,
}

fn ten_phases() -> usize {
    10
}
fn ramp_s() -> f64 {
    0.4
}
fn steady_s() -> f64 {
    10.0
}

impl AskedGait {
    /// A gait without bounds.
    pub fn new(omega_v: f64, gait: GaitClass) -> Self {
        Self {
            omega_v,
            gait,
            froude_min: 0.0,
            froude_max: 0.0,
            cost_of_transport_max: 0.0,
            correlation: 0.0,
        }
    }
}

impl AskedChange {
    /// The change from one command to another, tried as by default.
    pub fn new(from: f64, to: f64) -> Self {
        Self {
            from,
            to,
            phases: ten_phases(),
            ramp_s: ramp_s(),
            steady_s: steady_s(),
        }
    }
}

impl Default for Criteria {
    fn default() -> Self {
        Self {
            omega_v: (0..=7).map(|k| 0.5 * f64::from(k)).collect(),
            duration_s: 20.0,
            slowest_froude_max: 0.20,
            fastest_froude_min: 0.93,
            gaits: vec![
                AskedGait {
                    froude_min: 0.15,
                    cost_of_transport_max: 0.342,
                    correlation: 0.5,
                    ..AskedGait::new(0.0, GaitClass::Walking)
                },
                AskedGait {
                    cost_of_transport_max: 0.347,
                    correlation: 0.5,
                    ..AskedGait::new(3.0, GaitClass::Running)
                },
            ],
            changes: vec![AskedChange::new(0.0, 3.0), AskedChange::new(3.0, 0.0)],
        }
    }
}

impl Criteria {
    /// The gait that is asked for under a command, if one is.
    pub fn gait_at(&self, omega_v: f64) -> Option<GaitClass> {
        let asked = self.gaits.iter().find(|asked| asked.omega_v == omega_v);
        asked.map(|asked| asked.gait)
    }

    /// The first command at which a gait is asked for.
    pub fn first(&self, gait: GaitClass) -> Option<&AskedGait> {
        self.gaits.iter().find(|asked| asked.gait == gait)
    }

    /// How many criteria there are.
    pub fn count(&self) -> usize {
        let asked = |bound: f64| usize::from(bound > 0.0);
        let of_gait = |g: &AskedGait| {
            let correlations = match g.gait {
                GaitClass::Running => 3,
                _ => 1,
            };
            1 + asked(g.froude_min)
                + asked(g.froude_max)
                + asked(g.cost_of_transport_max)
                + correlations * asked(g.correlation)
        };
        let tries = self.changes.iter().map(|change| change.phases);
        self.omega_v.len()
            + asked(self.slowest_froude_max)
            + asked(self.fastest_froude_min)
            + self.gaits.iter().map(of_gait).sum::<usize>()
            + tries.sum::<usize>()
    }

    /// Checks every value; the error is a sentence that names the key. `table` is put before the keys.
    pub(crate) fn validate(&self, table: &str) -> Result<(), String> {
        let require = |ok: bool, key: &str, value: &dyn std::fmt::Debug, accepted: &str| {
            if ok {
                return Ok(());
            }
            Err(format!(
                "`{table}{key}` is {value:?}, but it must be {accepted}"
            ))
        };
        let bound = |key: &str, value: f64| {
            let ok = value.is_finite() && value >= 0.0;
            require(ok, key, &value, "0, which asks nothing, or greater")
        };
        let commands = &self.omega_v;
        require(
            (1..=MOST).contains(&commands.len()),
            "omega_v",
            commands,
            "a list of 1 to 1000 commands",
        )?;
        let possible = |w: &f64| w.abs() <= OMEGA_V_MAX;
        let different = |(i, w): (usize, &f64)| !commands[..i].contains(w);
        require(
            commands.iter().all(possible) && commands.iter().enumerate().all(different),
            "omega_v",
            commands,
            "a list of different commands from -100 to 100",
        )?;
        require(
            self.duration_s > 0.0 && self.duration_s <= DURATION_MAX_S,
            "duration_s",
            &self.duration_s,
            "above 0 and at most 3600",
        )?;
        bound("slowest_froude_max", self.slowest_froude_max)?;
        bound("fastest_froude_min", self.fastest_froude_min)?;
        for (i, g) in self.gaits.iter().enumerate() {
            let key = |name: &str| format!("gaits[{i}].{name}");
            require(
                commands.contains(&g.omega_v),
                &key("omega_v"),
                &g.omega_v,
                &format!("one of the commands of `{table}omega_v`, {commands:?}"),
            )?;
            let first = self
                .gaits
                .iter()
                .position(|other| other.omega_v == g.omega_v);
            require(
                first == Some(i),
                &key("omega_v"),
                &g.omega_v,
                "a command at which no other gait is asked for",
            )?;
            let gaits = [GaitClass::Walking, GaitClass::Running, GaitClass::Standing];
            require(
                gaits.contains(&g.gait),
                &key("gait"),
                &g.gait.to_string(),
                "\"walking\", \"running\" or \"standing\"",
            )?;
            bound(&key("froude_min"), g.froude_min)?;
            bound(&key("froude_max"), g.froude_max)?;
            bound(&key("cost_of_transport_max"), g.cost_of_transport_max)?;
            require(
                g.froude_max == 0.0 || g.froude_min <= g.froude_max,
                &key("froude_min"),
                &g.froude_min,
                &format!("at most `froude_max`, {}", g.froude_max),
            )?;
            require(
                (0.0..1.0).contains(&g.correlation),
                &key("correlation"),
                &g.correlation,
                "0, which asks nothing, or greater and below 1",
            )?;
            let of_motion = g.froude_min + g.froude_max + g.cost_of_transport_max + g.correlation;
            require(
                g.gait != GaitClass::Standing || of_motion == 0.0,
                &key("gait"),
                &g.gait.to_string(),
                "\"walking\" or \"running\" to have bounds",
            )?;
        }
        for (i, c) in self.changes.iter().enumerate() {
            let key = |name: &str| format!("changes[{i}].{name}");
            for (name, omega_v) in [("from", c.from), ("to", c.to)] {
                require(
                    self.gait_at(omega_v).is_some(),
                    &key(name),
                    &omega_v,
                    &format!(
                        "a command at which `{table}gaits` asks for a gait; a file with its own `gaits` gives its own \
                         `changes` too, or `changes = []`"
                    ),
                )?;
            }
            require(
                c.from != c.to,
                &key("to"),
                &c.to,
                "another command than `from`",
            )?;
            require(
                (1..=MOST).contains(&c.phases),
                &key("phases"),
                &c.phases,
                "between 1 and 1000",
            )?;
            require(
                c.ramp_s >= 0.0 && c.ramp_s <= DURATION_MAX_S,
                &key("ramp_s"),
                &c.ramp_s,
                "between 0 and 3600",
            )?;
            require(
                c.steady_s > 0.0 && c.steady_s <= DURATION_MAX_S,
                &key("steady_s"),
                &c.steady_s,
                "above 0 and at most 3600",
            )?;
        }
        require(
            self.changes.len() <= MOST,
            "changes",
            &self.changes.len(),
            "a list of at most 1000",
        )
    }
}

impl std::fmt::Display for Criteria {
    /// In one line, e.g. `39 criteria: 8 commands from 0 to 3.5, walking at 0, running at 3, 0 -> 3, 3 -> 0`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let low = self.omega_v.iter().copied().fold(f64::INFINITY, f64::min);
        let high = self
            .omega_v
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max);
        let (count, commands) = (self.count(), self.omega_v.len());
        write!(
            f,
            "{count} criteria: {commands} commands from {low} to {high}"
        )?;
        for g in &self.gaits {
            write!(f, ", {} at {}", g.gait, g.omega_v)?;
        }
        for c in &self.changes {
            write!(f, ", {} -> {}", c.from, c.to)?;
        }
        Ok(())
    }
}
