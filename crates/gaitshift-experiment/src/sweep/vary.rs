//! Keys that vary: every combination of their values, or settings drawn at random.

use super::{Random, VariantEntry};
use crate::config::{nested, overlay};
use rand::{Rng, RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::Deserialize;
use toml::{Table, Value};

/// Most variants of a sweep.
const MOST_VARIANTS: usize = 1_000;
/// Draws for each setting that is wanted before a space counts as exhausted.
const MOST_DRAWS: usize = 100;

/// A key and what it may be.
struct Key {
    /// Path of the key, as in TOML.
    path: Vec<String>,
    choice: Choice,
}

enum Choice {
    /// One of these.
    List(Vec<Value>),
    /// A number of a range; drawn only.
    Range(Range),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Range {
    from: Value,
    to: Value,
    #[serde(default)]
    scale: Scale,
}

#[derive(Deserialize, Default, Clone, Copy, PartialEq)]
#[serde(rename_all = "lowercase")]
enum Scale {
    #[default]
    Linear,
    Log,
}

/// The variants that `vary` asks for.
pub(super) fn variants(vary: &Table, random: Option<Random>) -> Result<Vec<VariantEntry>, String> {
    let mut keys = Vec::new();
    collect(vary, &mut Vec::new(), &mut keys)?;
    if keys.is_empty() {
        return Err("`vary` names no key; e.g. learner.learning_rate = [3e-4, 1e-3]".to_owned());
    }
    let settings = match random {
        None => grid(&keys)?,
        Some(random) => drawn(&keys, random)?,
    };
    let names = short_names(&keys);
    let variants = settings.iter().map(|setting| {
        let mut set = Table::new();
        let (mut words, mut values) = (Vec::new(), Vec::new());
        for ((key, name), value) in keys.iter().zip(&names).zip(setting) {
            let path: Vec<&str> = key.path.iter().map(String::as_str).collect();
            overlay(&mut set, nested(&path, value.clone())?)?;
            let text = match value {
                Value::String(text) => text.clone(),
                // As people write it, 0.0003 rather than 3e-4.
                value => value.to_string(),
            };
            words.push(format!("{name}={text}"));
            values.push((key.path.join("."), value.to_string()));
        }
        Ok(VariantEntry {
            name: words.join(" "),
            reason: String::new(),
            experiment: None,
            set,
            values,
        })
    });
    variants.collect()
}

/// All keys below a table, in alphabetical order; a quoted key may be a whole path.
fn collect(table: &Table, within: &mut Vec<String>, keys: &mut Vec<Key>) -> Result<(), String> {
    for (name, value) in table {
        let depth = within.len();
        within.extend(name.split('.').map(str::to_owned));
        let path = within.join(".");
        match value {
            Value::Array(list) if list.is_empty() => {
                return Err(format!("`vary`: `{path}` has no values"));
            }
            Value::Array(list) => {
                if let Some(value) = super::repeated(list) {
                    return Err(format!("`vary`: `{path}` has the value {value} twice"));
                }
                keys.push(Key {
                    path: within.clone(),
                    choice: Choice::List(list.clone()),
                });
            }
            Value::Table(inner) if inner.contains_key("from") || inner.contains_key("to") => {
                let range = value.clone().try_into::<Range>();
                let range = range.map_err(|e| format!("`vary`: `{path}`: {}", e.message()))?;
                keys.push(Key {
                    choice: Choice::Range(range.checked(&path)?),
                    path: within.clone(),
                });
            }
            Value::Table(inner) => collect(inner, within, keys)?,
            value => {
                return Err(format!(
                    "`vary`: `{path}` is {value}, but it must be a list of values, or for `random` a range \
                     {{ from = ..., to = ... }}; what is the same in all variants belongs to `[set]`"
                ));
            }
        }
        within.truncate(depth);
    }
    let paths: Vec<String> = keys.iter().map(|key| key.path.join(".")).collect();
    match super::repeated(&paths) {
        Some(path) => Err(format!("`vary` names `{path}` twice")),
        None => Ok(()),
    }
}

impl Range {
    fn checked(self, path: &str) -> Result<Self, String> {
        let number = |value: &Value| match value {
            Value::Integer(whole) => Some(*whole as f64),
            Value::Float(number) => Some(*number),
            _ => None,
        };
        let bounds = number(&self.from).zip(number(&self.to));
        match bounds {
            Some((from, to)) if from < to && from.is_finite() && to.is_finite() => {
                if self.scale == Scale::Log && from <= 0.0 {
                    return Err(format!(
                        "`vary`: `{path}` begins at {from}, but the scale \"log\" needs numbers above 0"
                    ));
                }
                Ok(self)
            }
            _ => Err(format!(
                "`vary`: `{path}` goes from {} to {}, but these must be numbers, the lower one first",
                self.from, self.to
            )),
        }
    }

    /// A whole number if both bounds are, else a number of four digits, so that it can be read and typed.
    fn draw(&self, rng: &mut impl Rng) -> Value {
        let share: f64 = rng.random();
        let between = |from: f64, to: f64| match self.scale {
            Scale::Linear => from + share * (to - from),
            Scale::Log => (from.ln() + share * (to / from).ln()).exp(),
        };
        match (&self.from, &self.to) {
            (Value::Integer(from), Value::Integer(to)) => {
                // Each whole number has the space up to the next.
                let number = between(*from as f64, *to as f64 + 1.0);
                Value::Integer((number.floor() as i64).clamp(*from, *to))
            }
            (from, to) => {
                let bound = |value: &Value| match value {
                    Value::Integer(whole) => *whole as f64,
                    value => value.as_float().unwrap_or_default(),
                };
                let (from, to) = (bound(from), bound(to));
                let number = between(from, to);
                let rounded = format!("{number:.3e}").parse().unwrap_or(number);
                Value::Float(f64::clamp(rounded, from, to))
            }
        }
    }
}

/// Every combination; the last key varies first.
fn grid(keys: &[Key]) -> Result<Vec<Vec<Value>>, String> {
    let mut settings = vec![Vec::new()];
    for key in keys {
        let Choice::List(list) = &key.choice else {
            return Err(format!(
                "`vary`: `{}` is a range, which has no end of values; list some, or add \
                 random = {{ settings = 20, seed = 1 }} above the first table",
                key.path.join(".")
            ));
        };
        if settings.len().saturating_mul(list.len()) > MOST_VARIANTS {
            return Err(format!(
                "`vary` has more than {MOST_VARIANTS} combinations; vary fewer values, or draw some of them: \
                 random = {{ settings = 20, seed = 1 }}"
            ));
        }
        settings = settings
            .iter()
            .flat_map(|setting: &Vec<Value>| {
                list.iter().map(|value| {
                    let mut longer = setting.clone();
                    longer.push(value.clone());
                    longer
                })
            })
            .collect();
    }
    Ok(settings)
}

/// Settings drawn independently of each other, no two alike: more of them begin with the same ones.
fn drawn(keys: &[Key], random: Random) -> Result<Vec<Vec<Value>>, String> {
    if !(1..=MOST_VARIANTS).contains(&random.settings) {
        return Err(format!(
            "`random.settings` is {}, but it must be from 1 to {MOST_VARIANTS}",
            random.settings
        ));
    }
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(random.seed);
    let mut settings: Vec<Vec<Value>> = Vec::new();
    for _ in 0..random.settings {
        let fresh = (0..MOST_DRAWS).find_map(|_| {
            let draw = |key: &Key| match &key.choice {
                Choice::List(list) => list[rng.random_range(0..list.len())].clone(),
                Choice::Range(range) => range.draw(&mut rng),
            };
            let setting: Vec<Value> = keys.iter().map(draw).collect();
            (!settings.contains(&setting)).then_some(setting)
        });
        settings.push(fresh.ok_or_else(|| {
            format!(
                "`random.settings` is {}, but `vary` has hardly more than {} different ones; ask for {}",
                random.settings,
                settings.len(),
                settings.len()
            )
        })?);
    }
    Ok(settings)
}

/// Names of the keys for a table: their last word, or the whole path where two have the same.
fn short_names(keys: &[Key]) -> Vec<String> {
    let last = |key: &Key| key.path.last().cloned().unwrap_or_default();
    keys.iter()
        .map(|key| {
            let same = keys.iter().filter(|other| last(other) == last(key)).count();
            if same > 1 {
                key.path.join(".")
            } else {
                last(key)
            }
        })
        .collect()
}
