//! Single values and parts of an experiment that come from elsewhere: an option, a file of the body's parameters, of a
//! disturbance or of criteria.

use super::names::{elsewhere, parse_error, question};
use super::tables::{assignment, overlay, read};
use super::{ConfigError, Experiment, shape};
use crate::criteria::Criteria;
use gaitshift_body::BodyParameters;
use gaitshift_task::{Disturbance, TaskParameters};
use serde::{Deserialize, Serialize};
use std::path::Path;

impl Experiment {
    /// The experiment with single values replaced, each `KEY=VALUE` with the path of a key, e.g.
    /// `body.friction=0.6`.
    ///
    /// # Errors
    /// No `=`, an unknown key, a wrong type, a value out of range, `base`, which has been read already.
    pub fn with_values(&self, assignments: &[String]) -> Result<Self, ConfigError> {
        if assignments.is_empty() {
            return Ok(self.clone());
        }
        let mut whole = self.clone();
        for text in assignments {
            let (values, origin) = (assignment(text, &[])?, format!("`{text}`"));
            if values.contains_key("base") {
                return Err(ConfigError::Value {
                    origin,
                    message:
                        "`base` belongs into a file; give that recipe or file as the experiment"
                            .to_owned(),
                });
            }
            whole = whole.overlaid(values, &origin)?;
        }
        // Only now: values that depend on each other may come one after the other.
        whole.validate(&all_of(assignments))?;
        Ok(whole)
    }

    /// The experiment with the values of a table in the place of its own; `origin` names the table in errors.
    ///
    /// # Errors
    /// An unknown key, a wrong type, a value out of range.
    pub(crate) fn with_table(
        &self,
        values: toml::Table,
        origin: &str,
    ) -> Result<Self, ConfigError> {
        let experiment = self.overlaid(values, origin)?;
        experiment.validate(origin)?;
        Ok(experiment)
    }

    /// As [`Experiment::with_table`], before anything is checked.
    fn overlaid(&self, values: toml::Table, origin: &str) -> Result<Self, ConfigError> {
        shape::of_experiment(&values, origin)?;
        let mut table = self.table(origin)?;
        overlay(&mut table, values).map_err(|e| parse_error(origin, &e))?;
        table
            .try_into()
            .map_err(|e: toml::de::Error| parse_error(origin, &e.to_string()))
    }
}

/// What errors of several assignments name.
fn all_of(assignments: &[String]) -> String {
    let quoted: Vec<String> = assignments.iter().map(|text| format!("`{text}`")).collect();
    quoted.join(", ")
}

impl Criteria {
    /// Reads the criteria of a TOML file: its table `[criteria]`, if it is an experiment, or the keys of that table by
    /// themselves. What the file leaves out is as in the experiment's base, or as by default.
    ///
    /// # Errors
    /// An unreadable file, unknown keys, wrong types, values out of range.
    pub fn load(path: &Path) -> Result<Self, ConfigError> {
        let text = read(path)?;
        let origin = path.display().to_string();
        let error = |e: toml::de::Error| parse_error(&origin, &e.to_string());
        let own: toml::Table = toml::from_str(&text).map_err(error)?;
        let mut whole = toml::Table::try_from(Self::default())
            .map_err(|e| parse_error(&origin, &e.to_string()))?;
        if !own.keys().any(|key| whole.contains_key(key)) {
            return Ok(Experiment::parse(&text, &origin)?.criteria);
        }
        shape::of_criteria(&own, &origin)?;
        // A first reading reports unknown keys and wrong types with their line.
        let _: Self = toml::from_str(&text).map_err(error)?;
        overlay(&mut whole, own).map_err(|e| parse_error(&origin, &e))?;
        let criteria: Self = whole.try_into().map_err(error)?;
        match criteria.validate("") {
            Ok(()) => Ok(criteria),
            Err(message) => Err(ConfigError::Value { origin, message }),
        }
    }

    /// Those of a run, from its `config.toml`; of a run of before there were any, the default ones.
    ///
    /// # Errors
    /// An unreadable file, or criteria that cannot be used. What else stands there may be of another version.
    pub fn of_run(folder: &Path) -> Result<Self, ConfigError> {
        #[derive(Deserialize)]
        struct Part {
            #[serde(default)]
            criteria: Criteria,
        }
        let path = folder.join("config.toml");
        let origin = path.display().to_string();
        let Part { criteria } =
            toml::from_str(&read(&path)?).map_err(|e| parse_error(&origin, &e.to_string()))?;
        match criteria.validate("criteria.") {
            Ok(()) => Ok(criteria),
            Err(message) => Err(ConfigError::Value { origin, message }),
        }
    }
}

/// Reads a TOML file that overrides body parameters, e.g. `friction = 0.6`, by themselves or as the table `[body]` of an
/// experiment and of the files it is based on, whose other tables say nothing here.
///
/// # Errors
/// An unreadable file, unknown keys, wrong types, values out of range, an experiment that says nothing of a body.
pub fn load_body_overrides(
    path: &Path,
    base: &BodyParameters,
) -> Result<BodyParameters, ConfigError> {
    let text = read(path)?;
    let origin = path.display().to_string();
    let parse_error = |e: toml::de::Error| parse_error(&origin, &e.to_string());
    let mut table: toml::Table = toml::from_str(&text).map_err(parse_error)?;
    if table.keys().any(|key| is_table_of_experiments(key)) {
        table = Experiment::own_bodies(&text, &origin, &mut Vec::new())?;
        if table.is_empty() {
            return Err(self::parse_error(
                &origin,
                "it says nothing of a body; give a table [body], or keys of the body alone, such as friction = 0.6",
            ));
        }
    } else {
        // A first reading reports unknown keys and wrong types with their line.
        let _: BodyParameters = toml::from_str(&text).map_err(parse_error)?;
    }
    let mut whole =
        toml::Table::try_from(base).map_err(|e| self::parse_error(&origin, &e.to_string()))?;
    overlay(&mut whole, table).map_err(|e| self::parse_error(&origin, &e))?;
    let body: BodyParameters = whole.try_into().map_err(parse_error)?;
    body.validate()
        .map_err(|source| ConfigError::Body { origin, source })?;
    Ok(body)
}

/// Whether a key stands at the top of an experiment.
fn is_table_of_experiments(key: &str) -> bool {
    let keys = Experiment::default().keys();
    key == "base" || keys.iter().any(|of| of.split('.').next() == Some(key))
}

/// Reads a TOML file that describes a disturbance; `origin` of an error is the file.
///
/// # Errors
/// An unreadable file, unknown keys, wrong types, values out of range.
pub fn load_disturbance(path: &Path) -> Result<Disturbance, ConfigError> {
    let origin = path.display().to_string();
    let text = read(path)?;
    let error = |e: toml::de::Error| parse_error(&origin, &e.to_string());
    shape::of_disturbance(&toml::from_str(&text).map_err(error)?, &origin)?;
    let disturbance: Disturbance = toml::from_str(&text).map_err(error)?;
    let source = disturbance.validate();
    source.map_err(|source| ConfigError::Task { origin, source })?;
    Ok(disturbance)
}

/// Body and task with single values replaced, each `KEY=VALUE` with a key of `[body]`, or with `body.KEY` or `task.KEY`.
///
/// # Errors
/// No `=`, an unknown key, a wrong type, a value out of range.
pub fn set_body_and_task(
    body: &BodyParameters,
    task: &TaskParameters,
    assignments: &[String],
) -> Result<(BodyParameters, TaskParameters), ConfigError> {
    #[derive(Clone, Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Both {
        body: BodyParameters,
        task: TaskParameters,
    }
    let mut both = Both {
        body: body.clone(),
        task: task.clone(),
    };
    for text in assignments {
        let origin = format!("`{text}`");
        let mut table =
            toml::Table::try_from(&both).map_err(|e| parse_error(&origin, &e.to_string()))?;
        let key = text.split(['=', '.']).next().unwrap_or_default().trim();
        if !["body", "task"].contains(&key) && is_table_of_experiments(key) {
            return Err(parse_error(
                &origin,
                &format!("`{key}` is of training; here keys of the body and `task.KEY` can be set"),
            ));
        }
        let own = assignment(text, &["body", "task"])?;
        shape::of_experiment(&own, &origin)?;
        overlay(&mut table, own).map_err(|e| parse_error(&origin, &e))?;
        both = table.try_into().map_err(|e: toml::de::Error| {
            // Without a table it was looked for among those of the body.
            let key = text.split('=').next().unwrap_or_default().trim();
            let of_task = |key: &String| key.starts_with("task.");
            match elsewhere(key).into_iter().find(of_task) {
                Some(meant) => parse_error(
                    &origin,
                    &format!("unknown key `{key}`; {}", question(&[meant])),
                ),
                None => parse_error(&origin, &e.to_string()),
            }
        })?;
    }
    if !assignments.is_empty() {
        let origin = all_of(assignments);
        let source = both.body.validate();
        source.map_err(|source| ConfigError::Body {
            origin: origin.clone(),
            source,
        })?;
        let source = both.task.validate(&both.body);
        source.map_err(|source| ConfigError::Task { origin, source })?;
    }
    Ok((both.body, both.task))
}
