//! One experiment as one TOML file: body, task, curriculum, learner and training, every value named.

use crate::criteria::Criteria;
use crate::rehearsal::RehearsalParameters;
use gaitshift_analysis::GaitClass;
use gaitshift_body::{BodyParameters, ParameterError};
use gaitshift_sac::{SacConfig, Temperature};
use gaitshift_task::{
    Curriculum, Disturbance, Keyed, LearnerSettings, Phase, TaskError, TaskParameters,
};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// How mirror symmetry enters learning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Symmetry {
    /// Not at all.
    None,
    /// The reward term (7) with the policy's mean actions: a property of the policy in that state, which no single
    /// action changes.
    Reward,
    /// The reward term (7) with the action taken as `π(s_t)`, against the mirrored policy's mean: the critics see what
    /// an action costs that leaves the mirror image.
    Action,
    /// Half of every batch is replaced by its mirror image.
    Replay,
    /// Actor and critics commute with the mirror: left and right are equal by construction.
    Network,
}

/// Everything about training that is neither the task's nor the learner's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrainingParameters {
    /// Environments stepped together.
    pub environments: usize,
    /// Environment steps per update of the learner; 1 is the journal version's.
    pub steps_per_update: u64,
    /// Environment steps before the first update.
    pub learning_starts: u64,
    /// How mirror symmetry enters.
    pub symmetry: Symmetry,
    /// See [`LearnerSettings::entropy_command_divisor`].
    pub entropy_command_divisor: f64,
    /// See [`LearnerSettings::entropy_share_at_zero`].
    pub entropy_share_at_zero: f64,
    /// A controller to begin with instead of a random one, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub warm_start: Option<WarmStart>,
    /// How the walk is rehearsed in the phases that ask for it.
    pub rehearsal: RehearsalParameters,
    /// Environment steps between rows of `metrics.csv`.
    pub metrics_interval_steps: u64,
    /// Environment steps between evaluations.
    pub evaluation_interval_steps: u64,
    /// Each evaluation also tries the mean of the controllers of this many latest evaluations, and takes the
    /// better of the two; 1 tries none.
    pub average_evaluations: usize,
    /// Environment steps between checkpoints.
    pub checkpoint_interval_steps: u64,
    /// Stop at the first evaluation that meets every criterion.
    pub stop_when_accepted: bool,
    /// Transitions in the replay buffer.
    pub replay_capacity: usize,
}

impl Default for TrainingParameters {
    fn default() -> Self {
        Self {
            environments: 1,
            steps_per_update: 1,
            learning_starts: 10_000,
            symmetry: Symmetry::Reward,
            entropy_command_divisor: 0.0,
            entropy_share_at_zero: 1.0,
            warm_start: None,
            rehearsal: RehearsalParameters::default(),
            metrics_interval_steps: 20_000,
            evaluation_interval_steps: 250_000,
            average_evaluations: 1,
            checkpoint_interval_steps: 1_000_000,
            stop_when_accepted: false,
            replay_capacity: 1_000_000,
        }
    }
}

/// A controller that training begins with: does the learner keep what it does, or leave it?
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WarmStart {
    /// Its file, from the folder in which training begins; `shipped` is the one that comes with the program. Its hidden
    /// layers must be those of `learner.actor_hidden`.
    pub controller: String,
    /// Environment steps at the beginning in which only the critics learn, so that the actor is not led by critics that
    /// know nothing yet.
    #[serde(default)]
    pub critic_steps: u64,
}

/// A whole experiment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Experiment {
    /// The recipe or file that gives everything a file leaves out; `paper` if the file names none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base: Option<String>,
    /// Name of the experiment; a run's folder is named after it.
    pub name: String,
    /// Seed of everything random.
    pub seed: u64,
    /// The body.
    pub body: BodyParameters,
    /// The task.
    pub task: TaskParameters,
    /// The curriculum.
    pub curriculum: Curriculum,
    /// The learner.
    pub learner: SacConfig,
    /// The training loop.
    pub training: TrainingParameters,
    /// What is asked of its controllers.
    pub criteria: Criteria,
}

impl Default for Experiment {
    fn default() -> Self {
        Self {
            base: None,
            name: "unnamed".to_owned(),
            seed: 1,
            body: BodyParameters::default(),
            task: TaskParameters::default(),
            curriculum: Curriculum::default(),
            learner: SacConfig::default(),
            training: TrainingParameters::default(),
            criteria: Criteria::default(),
        }
    }
}

/// The recipes that come with the program, by name.
pub const RECIPES: [(&str, &str); 3] = [
    ("paper", include_str!("../recipes/paper.toml")),
    ("journal", include_str!("../recipes/journal.toml")),
    ("fast", include_str!("../recipes/fast.toml")),
];

/// A configuration that cannot be used: the file, what is wrong, what to do.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}; check the path and its permissions", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The text is not valid TOML, or a key is unknown or of the wrong type.
    #[error("{origin}: {message}")]
    Parse {
        /// The file or recipe.
        origin: String,
        /// What the parser says, with line or key.
        message: String,
    },
    /// A body parameter is out of range.
    #[error("{origin}: {source}")]
    Body {
        /// The file or recipe.
        origin: String,
        /// Which and why.
        source: ParameterError,
    },
    /// A task or curriculum parameter is out of range.
    #[error("{origin}: {source}")]
    Task {
        /// The file or recipe.
        origin: String,
        /// Which and why.
        source: TaskError,
    },
    /// A learner or training parameter is out of range.
    #[error("{origin}: {message}")]
    Value {
        /// The file or recipe.
        origin: String,
        /// Which and why.
        message: String,
    },
    /// No such recipe.
    #[error("{origin}: there is no recipe `{name}`; the recipes are {known}{remedy}")]
    UnknownRecipe {
        /// Where the name was given.
        origin: String,
        /// What was asked for.
        name: String,
        /// What there is.
        known: String,
        /// What else may be given.
        remedy: String,
    },
}

impl Experiment {
    /// A recipe by name.
    ///
    /// # Errors
    /// An unknown name.
    pub fn recipe(name: &str) -> Result<Self, ConfigError> {
        let remedy = format!("; a file is named by a path, such as ./{name} or {name}.toml");
        Self::named(name, "recipe", remedy)
    }

    fn named(name: &str, origin: &str, remedy: String) -> Result<Self, ConfigError> {
        let Some((_, text)) = RECIPES.iter().find(|(known, _)| *known == name) else {
            return Err(ConfigError::UnknownRecipe {
                origin: origin.to_owned(),
                name: name.to_owned(),
                known: RECIPES.map(|(n, _)| format!("`{n}`")).join(", "),
                remedy,
            });
        };
        Self::parse(text, &format!("recipe `{name}`"))
    }

    /// A recipe by its name, or the file that a path names. A text is a path if it has a `/`, `\\` or `.` in it, whatever
    /// the working directory holds; anything else is a recipe's name.
    ///
    /// # Errors
    /// As [`Experiment::parse`], an unknown name, or a file that cannot be read.
    pub fn load(file_or_recipe: &str) -> Result<Self, ConfigError> {
        if file_or_recipe.contains(['/', '\\', '.']) {
            Self::read(Path::new(file_or_recipe))
        } else {
            Self::recipe(file_or_recipe)
        }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// As [`Experiment::parse`], or the file cannot be read.
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        Self::parse(&read(path)?, &path.display().to_string())
    }

    /// Parses TOML. What the text does not give is taken from the recipe or file that its key `base` names,
    /// from `paper` without one. A file is named as by [`Experiment::load`], from the folder of the file that names it.
    ///
    /// # Errors
    /// Text that is no TOML, unknown keys, wrong types, values out of range; `origin` names the source.
    pub fn parse(text: &str, origin: &str) -> Result<Self, ConfigError> {
        Self::parse_within(text, origin, &mut Vec::new())
    }

    /// `within` are the files whose bases led here.
    fn parse_within(
        text: &str,
        origin: &str,
        within: &mut Vec<PathBuf>,
    ) -> Result<Self, ConfigError> {
        let parse_error = |message: String| parse_error(origin, &message);
        // Reading the text alone first reports unknown keys and wrong types with their line.
        let own: Self = toml::from_str(text).map_err(|e| parse_error(e.to_string()))?;
        let is_recipe = RECIPES.iter().any(|(_, recipe)| *recipe == text);
        let experiment = match (is_recipe, own.base.as_deref().unwrap_or("paper")) {
            (true, _) => own,
            (false, base) => {
                let mut whole = Self::base(base, "base", origin, within)?.table(origin)?;
                let over = toml::from_str(text).map_err(|e| parse_error(e.to_string()))?;
                overlay(&mut whole, over);
                whole
                    .try_into()
                    .map_err(|e: toml::de::Error| parse_error(e.to_string()))?
            }
        };
        experiment.validate(origin)?;
        Ok(Self {
            base: None,
            ..experiment
        })
    }

    /// What `key` of the file `origin` names: a recipe, or a file from that file's folder.
    pub(crate) fn base(
        name: &str,
        key: &str,
        origin: &str,
        within: &mut Vec<PathBuf>,
    ) -> Result<Self, ConfigError> {
        let key = format!("{origin}: key `{key}`");
        if !name.contains(['/', '\\', '.']) {
            let remedy = format!("; a file is named by a path, such as ./{name}.toml");
            return Self::named(name, &key, remedy);
        }
        let folder = Path::new(origin).parent().unwrap_or(Path::new(""));
        let path = folder.join(name);
        let same = |other: &PathBuf| match (other.canonicalize(), path.canonicalize()) {
            (Ok(other), Ok(path)) => other == path,
            _ => false,
        };
        within.push(PathBuf::from(origin));
        if within.iter().any(same) {
            return Err(parse_error(
                &key,
                &format!("{} is based on itself", path.display()),
            ));
        }
        let text = std::fs::read_to_string(&path)
            .map_err(|e| parse_error(&key, &format!("cannot read {}: {e}", path.display())))?;
        Self::parse_within(&text, &path.display().to_string(), within)
    }

    /// All values as a table.
    fn table(&self, origin: &str) -> Result<toml::Table, ConfigError> {
        toml::Table::try_from(self).map_err(|e| parse_error(origin, &e.to_string()))
    }

    /// The name of what a file is based on and that itself; nothing for a recipe, which is based on nothing.
    pub(crate) fn base_of(text: &str, origin: &str) -> Result<Option<(String, Self)>, ConfigError> {
        if RECIPES.iter().any(|(_, recipe)| *recipe == text) {
            return Ok(None);
        }
        let own: Self = toml::from_str(text).map_err(|e| parse_error(origin, &e.to_string()))?;
        let name = own.base.unwrap_or_else(|| "paper".to_owned());
        let base = Self::base(&name, "base", origin, &mut Vec::new())?;
        Ok(Some((name, base)))
    }

    /// The experiment with single values replaced, each `KEY=VALUE` with the path of a key, e.g.
    /// `body.friction=0.6`.
    ///
    /// # Errors
    /// No `=`, an unknown key, a wrong type, a value out of range.
    pub fn with_values(&self, assignments: &[String]) -> Result<Self, ConfigError> {
        assignments.iter().try_fold(self.clone(), |whole, text| {
            whole.with_table(assignment(text, &[])?, &format!("`{text}`"))
        })
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
        let mut table = self.table(origin)?;
        overlay(&mut table, values);
        let experiment: Self = table
            .try_into()
            .map_err(|e: toml::de::Error| parse_error(origin, &e.to_string()))?;
        experiment.validate(origin)?;
        Ok(experiment)
    }

    /// Checks every value.
    ///
    /// # Errors
    /// The first value out of range.
    pub fn validate(&self, origin: &str) -> Result<(), ConfigError> {
        let origin = || origin.to_owned();
        self.body.validate().map_err(|source| ConfigError::Body {
            origin: origin(),
            source,
        })?;
        self.task
            .validate(&self.body)
            .and_then(|()| self.curriculum.validate(&self.body, &self.task.reward))
            .map_err(|source| ConfigError::Task {
                origin: origin(),
                source,
            })?;
        self.learner.validate().map_err(|e| ConfigError::Value {
            origin: origin(),
            message: e.to_string(),
        })?;
        let t = &self.training;
        let value_error = |message: String| ConfigError::Value {
            origin: origin(),
            message,
        };
        t.rehearsal.validate().map_err(value_error)?;
        self.criteria.validate("criteria.").map_err(value_error)?;
        let walk = self.criteria.first(GaitClass::Walking);
        if self.curriculum.rehearsal_start().is_some() && walk.is_none() {
            return Err(value_error(
                "a phase rehearses the walk, but `criteria.gaits` asks for none; ask for one, or rehearse nothing"
                    .to_owned(),
            ));
        }
        for (name, value) in [
            ("entropy_command_divisor", t.entropy_command_divisor),
            ("entropy_share_at_zero", t.entropy_share_at_zero),
        ] {
            LearnerSettings::check(&format!("training.{name}"), name, value).map_err(|source| {
                ConfigError::Task {
                    origin: origin(),
                    source,
                }
            })?;
        }
        let learned = matches!(self.learner.temperature, Temperature::Auto { .. });
        let sets_alpha = |phase: &Phase| {
            let tables = [&phase.learner, &phase.learner_end];
            tables.iter().any(|table| table.get("alpha").is_some())
        };
        if let Some(i) = self.curriculum.phases.iter().position(sets_alpha)
            && learned
        {
            return Err(value_error(format!(
                "`curriculum.phases[{i}]` sets `alpha` of the learner, which needs `learner.temperature` of the kind \
                 \"fixed\""
            )));
        }
        let countable = |steps: u64| (1..=1_000_000_000_000_000).contains(&steps);
        let ranges = [
            (
                "environments",
                t.environments as f64,
                (1..=4096).contains(&t.environments),
                "between 1 and 4096",
            ),
            (
                "steps_per_update",
                t.steps_per_update as f64,
                countable(t.steps_per_update),
                "between 1 and 1e15",
            ),
            (
                "metrics_interval_steps",
                t.metrics_interval_steps as f64,
                countable(t.metrics_interval_steps),
                "between 1 and 1e15",
            ),
            (
                "evaluation_interval_steps",
                t.evaluation_interval_steps as f64,
                countable(t.evaluation_interval_steps),
                "between 1 and 1e15",
            ),
            (
                "average_evaluations",
                t.average_evaluations as f64,
                (1..=100).contains(&t.average_evaluations),
                "between 1 and 100",
            ),
            (
                "checkpoint_interval_steps",
                t.checkpoint_interval_steps as f64,
                countable(t.checkpoint_interval_steps),
                "between 1 and 1e15",
            ),
            (
                "replay_capacity",
                t.replay_capacity as f64,
                t.replay_capacity >= t.environments.max(1000),
                "1000 or greater and at least the number of environments",
            ),
        ];
        for (key, value, ok, accepted) in ranges {
            if !ok {
                return Err(value_error(format!(
                    "`training.{key}` is {value}, but it must be {accepted}"
                )));
            }
        }
        Ok(())
    }

    /// What can be trained but is probably not meant, a sentence each, as far as body and task alone show.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = self.body.warnings();
        let cause = match self.training.symmetry {
            Symmetry::Replay => Some(
                "`training.symmetry = \"replay\"` half of every batch is mirrored and keeps its reward and its end",
            ),
            Symmetry::Network => Some(
                "`training.symmetry = \"network\"` a state and its mirror image have one value",
            ),
            Symmetry::None | Symmetry::Reward | Symmetry::Action => None,
        };
        if let Some(cause) = cause {
            for (key, text) in self.task.asymmetric_expressions() {
                warnings.push(format!(
                    "`{key}` tells left from right: {text}. With {cause}, so that what is learned is the mean of the \
                     expression and of its mirror image; `training.symmetry = \"none\"` learns it as it stands"
                ));
            }
        }
        warnings
    }

    /// The learner's settings where no phase says otherwise. An entropy that is learned has no fixed α; it counts as 0.
    pub fn own_learner_settings(&self) -> LearnerSettings {
        let (l, t) = (&self.learner, &self.training);
        LearnerSettings {
            learning_rate: l.learning_rate,
            alpha: match l.temperature {
                Temperature::Fixed { alpha } => alpha,
                Temperature::Auto { .. } => 0.0,
            },
            horizon: 1.0 / (1.0 - l.gamma),
            rehearsal: 0.0,
            entropy_command_divisor: t.entropy_command_divisor,
            entropy_share_at_zero: t.entropy_share_at_zero,
        }
    }

    /// The learner's settings at environment step `step`.
    pub fn learner_at(&self, step: u64) -> LearnerSettings {
        let own = self.own_learner_settings();
        self.curriculum.learner_at(step, &own)
    }

    /// The resolved configuration as TOML, every value written out.
    ///
    /// # Errors
    /// Never for a valid experiment; a value TOML cannot hold otherwise.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }
}

/// Reads a TOML file that overrides body parameters, e.g. `friction = 0.6`, by themselves or as the table `[body]` of an
/// experiment, whose other tables say nothing here.
///
/// # Errors
/// An unreadable file, unknown keys, wrong types, values out of range.
pub fn load_body_overrides(
    path: &Path,
    base: &BodyParameters,
) -> Result<BodyParameters, ConfigError> {
    let text = read(path)?;
    let origin = path.display().to_string();
    let parse_error = |e: toml::de::Error| parse_error(&origin, &e.to_string());
    let mut table: toml::Table = toml::from_str(&text).map_err(parse_error)?;
    // A first reading reports unknown keys and wrong types with their line.
    if table.contains_key("body") {
        let _: Experiment = toml::from_str(&text).map_err(parse_error)?;
        if let Some(toml::Value::Table(body)) = table.remove("body") {
            table = body;
        }
    } else {
        let _: BodyParameters = toml::from_str(&text).map_err(parse_error)?;
    }
    let mut whole =
        toml::Table::try_from(base).map_err(|e| self::parse_error(&origin, &e.to_string()))?;
    overlay(&mut whole, table);
    let body: BodyParameters = whole.try_into().map_err(parse_error)?;
    body.validate()
        .map_err(|source| ConfigError::Body { origin, source })?;
    Ok(body)
}

/// Reads a TOML file that describes a disturbance; `origin` of an error is the file.
///
/// # Errors
/// An unreadable file, unknown keys, wrong types, values out of range.
pub fn load_disturbance(path: &Path) -> Result<Disturbance, ConfigError> {
    let origin = path.display().to_string();
    let disturbance: Disturbance =
        toml::from_str(&read(path)?).map_err(|e| parse_error(&origin, &e.to_string()))?;
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
        overlay(&mut table, assignment(text, &["body", "task"])?);
        both = table
            .try_into()
            .map_err(|e: toml::de::Error| parse_error(&origin, &e.to_string()))?;
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

/// `KEY=VALUE` as nested tables. Where there are `tables`, a key that begins with none of them is one of the first. A value
/// that is no TOML is a text, so that it needs no quotes within those of a shell.
fn assignment(text: &str, tables: &[&str]) -> Result<toml::Table, ConfigError> {
    let (key, value) = text
        .split_once('=')
        .filter(|(key, _)| !key.trim().is_empty())
        .ok_or_else(|| {
            parse_error(
                &format!("`{text}`"),
                "expected KEY=VALUE, for instance friction=0.6",
            )
        })?;
    let value = value.trim();
    let value = toml::from_str::<toml::Table>(&format!("value = {value}"))
        .ok()
        .and_then(|mut table| table.remove("value"))
        .unwrap_or_else(|| toml::Value::String(value.to_owned()));
    let mut path: Vec<&str> = key.trim().split('.').collect();
    if let Some(first) = tables.first()
        && !tables.contains(&path[0])
    {
        path.insert(0, first);
    }
    Ok(nested(&path, value))
}

/// A table that holds one value, under the path of a key.
pub(crate) fn nested(path: &[&str], value: toml::Value) -> toml::Table {
    let (Some(name), rest) = (path.first(), path.get(1..).unwrap_or_default()) else {
        return toml::Table::new();
    };
    let inner = if rest.is_empty() {
        value
    } else {
        toml::Value::Table(nested(rest, value))
    };
    toml::Table::from_iter([((*name).to_owned(), inner)])
}

/// What a parser says, with the key that was probably meant.
pub(crate) fn parse_error(origin: &str, message: &str) -> ConfigError {
    ConfigError::Parse {
        origin: origin.to_owned(),
        message: did_you_mean(message.trim_end()),
    }
}

/// Names of earlier versions and what has become of them. A name that could stand elsewhere has one that stood beside it.
const GONE: [(&str, &str, &str); 16] = [
    (
        "schedule",
        "symmetry",
        "each phase has its own `learner` table now: `learner = { learning_rate = 5e-4, alpha = 0.1, horizon = 200 }`, and \
         `learner_end` with the values that they reach linearly",
    ),
    ("after_steps", "states", REHEARSAL_OF_PHASES),
    ("weight", "states", REHEARSAL_OF_PHASES),
    ("entropy_command_divisor", "omega_e", ENTROPY_OF_TRAINING),
    ("entropy_share_at_zero", "omega_e", ENTROPY_OF_TRAINING),
    ("horizon_command_divisor", "", NO_GAIN),
    ("horizon_share_floor", "", NO_GAIN),
    ("alive_command_factor", "", NO_GAIN),
    ("energy_reference_period_s", "", NO_GAIN),
    ("noise_correlation", "", NO_GAIN),
    ("actor_every", "", NO_GAIN),
    ("mirror_loss_weight", "", NO_GAIN),
    ("loss", "replay", NO_GAIN),
    (
        "mirrored_fraction",
        "",
        "`training.symmetry = \"replay\"` mirrors half of every batch",
    ),
    ("rehearsal_weight", "", REHEARSAL_OF_PHASES),
    (
        "rehearsal_rows",
        "",
        "`training.rehearsal.rows` says how many pairs an update rehearses",
    ),
];
const NO_GAIN: &str = "it showed no benefit and no longer exists; remove it";
const REHEARSAL_OF_PHASES: &str =
    "the weight is now set in the phases that rehearse: `learner = { rehearsal = 10 }`";
const ENTROPY_OF_TRAINING: &str =
    "it is now a key of `[training]`, and of a phase's `learner` and `learner_end`";

/// A parser's message of an unknown name, with what has become of it or the nearest known name instead of the list of
/// all, if it is a name of earlier versions or one is near.
pub fn did_you_mean(message: &str) -> String {
    let near = || {
        let start = message.rfind("unknown ")?;
        let (unknown, listed) = message[start..].split_once(", expected ")?;
        let unknown = unknown.split('`').nth(1)?;
        let gone = GONE.iter().find(|(name, beside, _)| {
            *name == unknown && (beside.is_empty() || listed.contains(&format!("`{beside}`")))
        });
        let what = &message[..start + message[start..].find(", expected ")?];
        let rest = listed.rfind('`').map_or("", |last| &listed[last + 1..]);
        if let Some((_, _, remedy)) = gone {
            return Some(format!("{what}: {remedy}{rest}"));
        }
        // Names stand between backticks; what follows the list, the line of a TOML file, does not.
        let known = listed.split('`').skip(1).step_by(2);
        let distance = |name: &str| strsim::osa_distance(unknown, name);
        let contained = |name: &str| unknown.len() > 2 && name.contains(unknown);
        let name = known.min_by_key(|name| (distance(name), !contained(name)))?;
        let likely = distance(name) <= 1 + unknown.len() / 4 || contained(name);
        likely.then(|| format!("{what}; did you mean `{name}`?{rest}"))
    };
    near().unwrap_or_else(|| message.to_owned())
}

pub(crate) fn read(path: &Path) -> Result<String, ConfigError> {
    std::fs::read_to_string(path).map_err(|source| ConfigError::Read {
        path: path.to_owned(),
        source,
    })
}

/// Puts the values of `over` into `base`, table by table; arrays, and tables whose key `kind` says
/// what else they hold, are replaced whole.
pub(crate) fn overlay(base: &mut toml::Table, over: toml::Table) {
    for (key, value) in over {
        match (base.get_mut(&key), value) {
            (Some(toml::Value::Table(inner)), toml::Value::Table(over))
                if !over.contains_key("kind") =>
            {
                overlay(inner, over);
            }
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}
