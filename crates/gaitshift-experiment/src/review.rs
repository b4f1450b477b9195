//! What can be said of an experiment before it is trained: what differs from its base, and what looks like a mistake.

use crate::config::{ConfigError, Experiment, read};
use crate::edits::edits;
use gaitshift_task::Phase;
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
        let is_file = file_or_recipe.contains(['/', '\\', '.']);
        let (base, before) = if is_file {
            let text = read(Path::new(file_or_recipe))?;
            match Experiment::base_of(&text, file_or_recipe)? {
                Some((name, base)) => (Some(name), base),
                None => (None, experiment.clone()),
            }
        } else {
            (None, Experiment::recipe(file_or_recipe)?)
        };
        let mut warnings = experiment.warnings();
        warnings.extend(unreached(experiment));
        Ok(Self {
            base,
            differences: differences(&before, experiment)?,
            warnings,
        })
    }
}

fn differences(before: &Experiment, after: &Experiment) -> Result<Vec<String>, ConfigError> {
    const PHASES: &str = "curriculum.phases";
    let phases = &after.curriculum.phases;
    let same_phases =
        (before.curriculum.phases.iter().map(|p| &p.name)).eq(phases.iter().map(|p| &p.name));
    let mut differences = Vec::new();
    for mut edit in edits(before, after)? {
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
        let (from, to) = (phases(before), phases(after));
        differences.push(format!("`{PHASES}`, {to} instead of {from}"));
    }
    Ok(differences)
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
            "`metrics.csv` stays empty",
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
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    if e.learner.threads > threads {
        warnings.push(format!(
            "`learner.threads` is {}, but this machine has {threads}: more threads than processors are slower",
            e.learner.threads
        ));
    }
    warnings
}
