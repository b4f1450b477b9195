//! Reads experiments: recipes, files, and what they are based on.

use super::names::{nearest, parse_error, question};
use super::tables::{check_changes, leaves, overlay, read, without_changes};
use super::{ConfigError, Experiment, shape};
use std::path::{Path, PathBuf};

/// The recipes that come with the program, by name.
pub const RECIPES: [(&str, &str); 4] = [
    ("paper", include_str!("../../recipes/paper.toml")),
    ("journal", include_str!("../../recipes/journal.toml")),
    ("fast", include_str!("../../recipes/fast.toml")),
    ("robust", include_str!("../../recipes/robust.toml")),
];

impl Experiment {
    /// A recipe by name.
    ///
    /// # Errors
    /// An unknown name.
    pub fn recipe(name: &str) -> Result<Self, ConfigError> {
        let remedy = format!("file is named by a path, such as ./{name} or {name}.toml");
        Self::named(name, "recipe", remedy)
    }

    fn named(name: &str, origin: &str, remedy: String) -> Result<Self, ConfigError> {
        let Some((_, text)) = RECIPES.iter().find(|(known, _)| *known == name) else {
            let names = RECIPES.map(|(known, _)| known);
            let known = match nearest(name, names) {
                Some(near) => format!("{} A", question(&[near])),
                None => {
                    let all = names.map(|name| format!("`{name}`")).join(", ");
                    format!("the recipes are {all}; a")
                }
            };
            return Err(ConfigError::UnknownRecipe {
                origin: origin.to_owned(),
                name: name.to_owned(),
                known,
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
        if is_path(file_or_recipe) {
            Self::read(Path::new(file_or_recipe))
        } else {
            Self::recipe(file_or_recipe)
        }
    }

    /// Reads a file. One that gives no name is named as the file is, without its ending.
    ///
    /// # Errors
    /// As [`Experiment::parse`], or the file cannot be read.
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        let text = read(path)?;
        let mut experiment = Self::parse(&text, &path.display().to_string())?;
        let named =
            toml::from_str::<toml::Table>(&text).is_ok_and(|table| table.contains_key("name"));
        if let Some(stem) = path.file_stem().filter(|_| !named) {
            experiment.name = stem.to_string_lossy().into_owned();
        }
        Ok(experiment)
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
        let (own, over) = Self::own(text, origin)?;
        let experiment = match base_name(&own, text) {
            None => own,
            Some(base) => {
                let mut whole = Self::base(base, "base", origin, within)?.table(origin)?;
                overlay(&mut whole, over).map_err(parse_error)?;
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

    /// The text alone, read and as a table. Reading it reports unknown keys and wrong types with their line, also in phases
    /// given as changes of those of the base and in own terms given so, whatever the base has.
    pub(super) fn own(text: &str, origin: &str) -> Result<(Self, toml::Table), ConfigError> {
        let error = |e: toml::de::Error| parse_error(origin, &e.to_string());
        let table: toml::Table = toml::from_str(text).map_err(error)?;
        shape::of_experiment(&table, origin)?;
        let mut alone = table.clone();
        let own = if without_changes(&mut alone) {
            check_changes(text).map_err(error)?;
            alone.try_into()
        } else {
            toml::from_str(text)
        };
        Ok((own.map_err(error)?, table))
    }

    /// What `key` of the file `origin` names: a recipe, or a file from that file's folder.
    pub(crate) fn base(
        name: &str,
        key: &str,
        origin: &str,
        within: &mut Vec<PathBuf>,
    ) -> Result<Self, ConfigError> {
        let key = format!("{origin}: key `{key}`");
        if !is_path(name) {
            let remedy = format!("file is named by a path, such as ./{name}.toml");
            return Self::named(name, &key, remedy);
        }
        let (text, path) = file_of(name, &key, origin, within)?;
        Self::parse_within(&text, &path, within)
    }

    /// The tables `[body]` of a text and of the files it is based on, one over the other; not of a recipe, whose body is the default.
    pub(super) fn own_bodies(
        text: &str,
        origin: &str,
        within: &mut Vec<PathBuf>,
    ) -> Result<toml::Table, ConfigError> {
        let (own, mut table) = Self::own(text, origin)?;
        let mut bodies = match own.base.as_deref().filter(|name| is_path(name)) {
            None => toml::Table::new(),
            Some(name) => {
                let key = format!("{origin}: key `base`");
                let (text, path) = file_of(name, &key, origin, within)?;
                Self::own_bodies(&text, &path, within)?
            }
        };
        if let Some(toml::Value::Table(body)) = table.remove("body") {
            overlay(&mut bodies, body).map_err(|e| parse_error(origin, &e))?;
        }
        Ok(bodies)
    }

    /// All values as a table.
    pub(super) fn table(&self, origin: &str) -> Result<toml::Table, ConfigError> {
        toml::Table::try_from(self).map_err(|e| parse_error(origin, &e.to_string()))
    }

    /// The path of every key with a value, but for those of phases.
    pub fn keys(&self) -> Vec<String> {
        let Ok(table) = toml::Value::try_from(self) else {
            return Vec::new();
        };
        // A list of tables is one key.
        let key = |(path, _): (String, _)| path.split('[').next().unwrap_or_default().to_owned();
        let mut keys: Vec<String> = leaves(&table).into_iter().map(key).collect();
        keys.dedup();
        keys
    }

    /// The name of what a file is based on and that itself; nothing for a recipe that is based on nothing.
    pub(crate) fn base_of(text: &str, origin: &str) -> Result<Option<(String, Self)>, ConfigError> {
        let (own, _) = Self::own(text, origin)?;
        let Some(name) = base_name(&own, text) else {
            return Ok(None);
        };
        let base = Self::base(name, "base", origin, &mut Vec::new())?;
        Ok(Some((name.to_owned(), base)))
    }
}

/// Whether a name is a file's and no recipe's.
fn is_path(name: &str) -> bool {
    name.contains(['/', '\\', '.'])
}

/// The text and the path of the file that `key` of the file `origin` names.
fn file_of(
    name: &str,
    key: &str,
    origin: &str,
    within: &mut Vec<PathBuf>,
) -> Result<(String, String), ConfigError> {
    let folder = Path::new(origin).parent().unwrap_or(Path::new(""));
    let path = folder.join(name);
    let same = |other: &PathBuf| match (other.canonicalize(), path.canonicalize()) {
        (Ok(other), Ok(path)) => other == path,
        _ => false,
    };
    within.push(PathBuf::from(origin));
    if within.iter().any(same) {
        return Err(parse_error(
            key,
            &format!("{} is based on itself", path.display()),
        ));
    }
    let text = std::fs::read_to_string(&path)
        .map_err(|e| parse_error(key, &format!(
                "cannot read {}: {e}; give the name of a recipe, or a path as it is from the folder of this file",
                path.display()
            )))?;
    Ok((text, path.display().to_string()))
}

/// What a text is based on: what it says, else `paper`, on which the recipes stand without saying so.
fn base_name<'a>(own: &'a Experiment, text: &str) -> Option<&'a str> {
    let is_recipe = RECIPES.iter().any(|(_, recipe)| *recipe == text);
    match own.base.as_deref() {
        None if is_recipe => None,
        None => Some("paper"),
        base => base,
    }
}
