//! What can be said of an experiment before it is trained: what differs from its base, and what looks like a mistake.

use crate::config::{ConfigError, Experiment, RECIPES, read};
use crate::edits::edits;
use crate::rehearsal::RehearsalParameters;
use gaitshift_task::{ExtraTerm, Keyed, Phase, Randomization, RewardParameters, TerrainRanges};
use std::path::Path;

/// An experiment, looked at before it runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Review {
    /// The recipe or file that it is based on; nothing for a recipe itself.
    pub base: Option<String>,
    /// What differs from the base: a sentence for each key, the phases together in one if they are
    /// others.
    pub differences: Vec<String>,
    /// What can be trained but is probably not meant, a sentence each.
    pub warnings: Vec<String>,
}

impl Review {
    /// Looks at `experiment`, which is what `file_or_recipe` says, with changes of single values.
    ///
    /// # Errors
    /// A file that cannot be read or used.
    pub fn of(file_or_recipe: &str, experiment: &Experiment) -> Result<Self, ConfigError> {
        let recipe = RECIPES.iter().find(|(name, _)| *name == file_or_recipe);
        let base = match recipe {
            Some((name, text)) => Experiment::base_of(text, &format!("recipe `{name}`"))?,
            None => Experiment::base_of(&read(Path::new(file_or_recipe))?, file_or_recipe)?,
        };
        let as_it_comes = Experiment::load(file_or_recipe)?;
        let (base, before) = match base {
            // With changes of single values a recipe is what they change.
            _ if recipe.is_some() && is_changed(&as_it_comes, experiment)? => {
                (Some(file_or_recipe.to_owned()), as_it_comes)
            }
            Some((name, base)) => (Some(name), base),
            None => (None, as_it_comes),
        };
        let mut warnings = experiment.warnings();
        warnings.extend(replaced(&before, experiment));
        warnings.extend(unreached(experiment));
        warnings.extend(seldom(experiment));
        warnings.extend(fall_height(&before, experiment));
        Ok(Self {
            base,
            differences: differences(&before, experiment)?,
            warnings,
        })
    }
}

/// Whether anything is changed but the threads, which are the machine's.
fn is_changed(before: &Experiment, after: &Experiment) -> Result<bool, ConfigError> {
    let edits = edits(before, after)?;
    Ok(edits.iter().any(|edit| edit.key != "learner.threads"))
}

/// A leg of another length beside the base's height of a fall.
fn fall_height(before: &Experiment, after: &Experiment) -> Option<String> {
    let scale = after.body.leg_length_m / before.body.leg_length_m;
    let height_m = after.task.termination.min_hip_height_m;
    let kept = height_m == before.task.termination.min_hip_height_m;
    (scale != 1.0 && height_m > 0.0 && kept).then(|| {
        format!(
            "`task.termination.min_hip_height_m` is {height_m}, {:.0} % of a leg of {} m instead of {:.0} %; in proportion {:.3}. Below it \
             a motion counts as a fall, which shapes the gait",
            100.0 * height_m / after.body.leg_length_m,
            after.body.leg_length_m,
            100.0 * height_m / before.body.leg_length_m,
            height_m * scale
        )
    })
}

fn differences(before: &Experiment, after: &Experiment) -> Result<Vec<String>, ConfigError> {
    const PHASES: &str = "curriculum.phases";
    let phases = &after.curriculum.phases;
    let same_phases =
        (before.curriculum.phases.iter().map(|p| &p.name)).eq(phases.iter().map(|p| &p.name));
    let mut differences = Vec::new();
    let (mut before, mut after) = (before.clone(), after.clone());
    if same_phases {
        let pairs = before.curriculum.phases.iter_mut();
        for (old, new) in pairs.zip(&mut after.curriculum.phases) {
            differences.extend(randomized(old, new));
        }
    }
    let phases = &after.curriculum.phases;
    for mut edit in edits(&before, &after)? {
        match edit.key.strip_prefix(PHASES) {
            None if edit.key == "name" => continue,
            None => {}
            Some(_) if !same_phases => continue,
            // A phase by its name, as `--set` takes it, instead of its place in the list.
            Some(within) => {
                let key = |(index, phase): (usize, &Phase)| {
                    let key = within.strip_prefix(&format!("[{index}]"))?;
                    Some(format!("{PHASES}.{}{key}", phase.name))
                };
                if let Some(key) = phases.iter().enumerate().find_map(key) {
                    edit.key = key;
                }
            }
        }
        differences.push(edit.to_string());
    }
    if !same_phases {
        let phases = |e: &Experiment| {
            let (count, steps) = (e.curriculum.phases.len(), e.curriculum.total_steps());
            format!("{count} of {steps} steps in all")
        };
        let names = |e: &Experiment| {
            let quoted = e.curriculum.phases.iter().map(|p| format!("`{}`", p.name));
            quoted.collect::<Vec<_>>().join(", ")
        };
        let (mut from, mut to) = (phases(&before), phases(&after));
        if from == to {
            (from, to) = (names(&before), names(&after));
        }
        differences.push(format!("`{PHASES}`, {to} instead of {from}"));
    }
    Ok(differences)
}

/// Takes out the randomization that only one of two phases has: three dozen values that differ from nothing. What it is, the
/// phase says. In what both have, ranges that only one of them gives are compared with those that change nothing.
fn randomized(old: &mut Phase, new: &mut Phase) -> Option<String> {
    let (from, to) = match (&mut old.randomization, &mut new.randomization) {
        (None, None) => return None,
        (Some(old), Some(new)) => {
            for one in [old, new] {
                *one = one.clone().in_full();
            }
            return None;
        }
        (None, Some(_)) => ("nothing", "what the phase draws"),
        (Some(_), None) => ("what the base draws", "nothing"),
    };
    (old.randomization, new.randomization) = (None, None);
    let name = &new.name;
    Some(format!(
        "`curriculum.phases.{name}.randomization` from {from} to {to}"
    ))
}

/// Rewards that differ from the base and that the phases, often those of the base, replace from their start.
fn replaced(before: &Experiment, after: &Experiment) -> Vec<String> {
    let phases = &after.curriculum.phases;
    let (old, new) = (&before.task.reward, &after.task.reward);
    let values = old.values().into_iter().zip(new.values());
    let mut warnings = Vec::new();
    for (key, (from, to)) in RewardParameters::KEYS.iter().zip(values) {
        if from != to && phases.iter().all(|phase| phase.reward.get(key).is_some()) {
            warnings.push(format!(
                "`task.reward.{key}` is {to} and has no effect: every phase sets its own `reward.{key}`"
            ));
        }
    }
    for term in Vec::<ExtraTerm>::from(new.extra.clone()) {
        let name = &term.name;
        let silent = |phase: &Phase| {
            let (begin, end) = (
                phase.reward_extra.get(name),
                phase.reward_extra_end.get(name),
            );
            begin == Some(&0.0) && end.is_none_or(|weight| *weight == 0.0)
        };
        if term.weight != 0.0 && phases.iter().all(silent) {
            warnings.push(format!(
                "the reward term `{name}` of `task.reward.extra` has no effect: every phase sets its weight to 0 in `reward_extra`"
            ));
        }
    }
    let rehearsal = &after.training.rehearsal;
    if *rehearsal != RehearsalParameters::default() && after.curriculum.rehearsal_start().is_none()
    {
        warnings.push(
            "`training.rehearsal` has no effect: no phase rehearses (`learner = { rehearsal = 10 }`)"
                .to_owned(),
        );
    }
    warnings
}

/// Longest mean time between events of which most episodes still have one, in time limits.
const SELDOM: f64 = 10.0;
/// Faster than any biped here has run, in m/s.
const OUT_OF_REACH_M_PER_S: f64 = 8.0;

/// What an episode is over before.
fn seldom(e: &Experiment) -> Vec<String> {
    let limit_s = e.task.termination.time_limit_s;
    let reach_m = OUT_OF_REACH_M_PER_S * limit_s;
    let interval = |key: &str, interval_s: f64| {
        (interval_s > SELDOM * limit_s).then(|| {
            format!(
                "`{key}` is {interval_s} s in the mean, but episodes last {limit_s} s at most: fewer than one in ten has one"
            )
        })
    };
    let redrawn_s = e.curriculum.command.redraw_interval_s;
    let redrawn = interval("curriculum.command.redraw_interval_s", redrawn_s);
    let mut warnings = Vec::from_iter(redrawn);
    for phase in &e.curriculum.phases {
        let Some(randomization) = &phase.randomization else {
            continue;
        };
        let key = format!("curriculum.phases.{}.randomization", phase.name);
        if let Some(pushes) = &randomization.pushes {
            warnings.extend(interval(
                &format!("{key}.pushes.interval_s"),
                pushes.interval_s,
            ));
        }
        let begins = randomization.terrain.iter().flat_map(begins);
        for (name, from_m) in begins.filter(|(_, from_m)| *from_m > reach_m) {
            warnings.push(format!(
                "`{key}.terrain.{name}` is never reached: the ground is flat up to {from_m} m, and episodes last {limit_s} s at most"
            ));
        }
    }
    warnings
}

/// Where ground that is drawn ceases to be flat at the earliest, in m.
fn begins(terrain: &TerrainRanges) -> Vec<(&'static str, f64)> {
    let (steps, uneven) = (&terrain.steps, &terrain.uneven);
    let all = [
        ("slope_rad", terrain.slope_rad, terrain.slope_from_m[0]),
        ("steps", steps.height_m, steps.from_m + steps.spacing_m[0]),
        ("uneven", uneven.height_m, uneven.from_m),
    ];
    let drawn = all.into_iter().filter(|(_, size, _)| *size != [0.0; 2]);
    drawn.map(|(name, _, from_m)| (name, from_m)).collect()
}

/// Times and commands that the run never comes to.
fn unreached(e: &Experiment) -> Vec<String> {
    let mut warnings = Vec::new();
    let total = e.curriculum.total_steps();
    let t = &e.training;
    let times = [
        (
            "training.learning_starts",
            t.learning_starts,
            "nothing is learned",
        ),
        (
            "training.evaluation_interval_steps",
            t.evaluation_interval_steps,
            "no controller is evaluated",
        ),
        (
            "training.metrics_interval_steps",
            t.metrics_interval_steps,
            "`metrics.csv` gets no row",
        ),
    ];
    for (key, steps, consequence) in times {
        // An interval as long as the run ends with it.
        if steps > total || (steps == total && key == "training.learning_starts") {
            warnings.push(format!(
                "`{key}` is {steps}, but the phases have {total} steps in all: {consequence}"
            ));
        }
    }
    let rehearsed = e.curriculum.rehearsal_start();
    if rehearsed.is_some_and(|start| start < t.evaluation_interval_steps) && t.warm_start.is_none()
    {
        warnings.push(
            "a phase rehearses before the first evaluation: the rehearsed walk has then not been evaluated"
                .to_owned(),
        );
    }
    let phases = &e.curriculum.phases;
    for phase in phases {
        if (phase.randomization.as_ref()).is_some_and(Randomization::changes_nothing) {
            warnings.push(format!(
                "`curriculum.phases.{}.randomization` changes nothing: its `share` is 0, or it gives no range",
                phase.name
            ));
        }
    }
    let ranges = || {
        phases.iter().flat_map(|phase| {
            let end = phase.omega_v_end.unwrap_or(phase.omega_v);
            [phase.omega_v, end]
        })
    };
    let low = ranges().fold(f64::INFINITY, |low, range| low.min(range[0]));
    let high = ranges().fold(f64::NEG_INFINITY, |high, range| high.max(range[1]));
    for asked in &e.criteria.gaits {
        let (gait, omega_v) = (asked.gait, asked.omega_v);
        if !(low..=high).contains(&omega_v) {
            warnings.push(format!(
                "no phase reaches the command {omega_v}, at which {gait} is judged: commands are drawn from {low} to {high}; \
                 change it or the gaits of `[criteria]`"
            ));
        }
    }
    let judged = |omega_v: f64| {
        e.criteria
            .gaits
            .iter()
            .any(|asked| asked.omega_v == omega_v)
    };
    let beyond = e
        .criteria
        .omega_v
        .iter()
        .filter(|omega_v| !(low..=high).contains(*omega_v) && !judged(**omega_v));
    let beyond: Vec<String> = beyond.map(f64::to_string).collect();
    if !beyond.is_empty() {
        warnings.push(format!(
            "no phase reaches {} of `criteria.omega_v`: commands are drawn from {low} to {high}",
            beyond.join(", ")
        ));
    }
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    if e.learner.threads > threads {
        warnings.push(format!(
            "`learner.threads` is {}, but this machine has {threads}: more threads than processors are slower",
            e.learner.threads
        ));
    }
    warnings
}
