//! TOML files and tables: reading, one value by its key, one table over another.

use super::ConfigError;
use super::names::parse_error;
use gaitshift_task::{ExtraRule, ExtraTerm, Phase};
use serde::Deserialize;
use std::io::ErrorKind;
use std::path::Path;
use toml::de::{DeTable, DeValue, ValueDeserializer};
use toml::{Spanned, Value};

pub(crate) fn read(path: &Path) -> Result<String, ConfigError> {
    let bytes = std::fs::read(path).map_err(|source| ConfigError::Read {
        path: path.to_owned(),
        remedy: match source.kind() {
            ErrorKind::IsADirectory => "give a file",
            _ => "check the path and its permissions",
        },
        source,
    })?;
    String::from_utf8(bytes).map_err(|e| {
        let text = &e.as_bytes()[..e.utf8_error().valid_up_to()];
        let line = 1 + text.iter().filter(|&&byte| byte == b'\n').count();
        parse_error(
            &path.display().to_string(),
            &format!("line {line} is not UTF-8 text; save the file as UTF-8"),
        )
    })
}

/// `KEY=VALUE` as nested tables. Where there are `tables`, a key that begins with none of them is one of the first. A value
/// that is no TOML is a text, so that it needs no quotes within those of a shell.
pub(super) fn assignment(text: &str, tables: &[&str]) -> Result<toml::Table, ConfigError> {
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
        // More than one line is no value.
        .filter(|table| table.len() == 1)
        .and_then(|mut table| table.remove("value"))
        .unwrap_or_else(|| Value::String(value.to_owned()));
    let mut path = parts(key.trim());
    if let Some(first) = tables.first()
        && !tables.contains(&path[0])
    {
        path.insert(0, first);
    }
    nested(&path, value).map_err(|message| parse_error("--set", &message))
}

/// The parts of a dotted key. As in TOML, quotes may enclose a part; without them a part ends at the next dot.
fn parts(key: &str) -> Vec<&str> {
    let (mut parts, mut rest) = (Vec::new(), key);
    loop {
        let quoted = rest.strip_prefix(['"', '\'']).and_then(|inside| {
            let (part, after) = inside.split_once(rest.chars().next()?)?;
            let next = after.strip_prefix('.');
            (next.is_some() || after.is_empty()).then_some((part, next))
        });
        let (part, next) = quoted.unwrap_or_else(|| match rest.split_once('.') {
            Some((part, next)) => (part, Some(next)),
            None => (rest, None),
        });
        parts.push(part);
        let Some(next) = next else {
            return parts;
        };
        rest = next;
    }
}

/// Most parts of a key's path; no key has half as many.
const DEEPEST: usize = 32;

/// A table that holds one value, under the path of a key.
///
/// # Errors
/// A path so long that tables this deep would exhaust the stack.
pub(crate) fn nested(path: &[&str], value: Value) -> Result<toml::Table, String> {
    if path.len() > DEEPEST {
        return Err(format!(
            "a key of {} parts, `{}...`, but none has more than {DEEPEST}",
            path.len(),
            path[..3].join(".")
        ));
    }
    let (first, rest) = path.split_first().ok_or("a key without a name")?;
    let inside =
        |inner, name: &&str| Value::Table([((*name).to_owned(), inner)].into_iter().collect());
    let inner = rest.iter().rev().fold(value, inside);
    Ok([((*first).to_owned(), inner)].into_iter().collect())
}

/// Puts the values of `over` into `base`, table by table; arrays, and tables whose key `kind` says
/// what else they hold, are replaced whole. What differs in an array of tables that have a `name` can also be given as a
/// table of theirs by name: `[curriculum.phases.II]`.
///
/// # Errors
/// A name that the array does not have.
pub(crate) fn overlay(base: &mut toml::Table, over: toml::Table) -> Result<(), String> {
    for (key, value) in over {
        match (base.get_mut(&key), value) {
            (Some(Value::Table(inner)), Value::Table(over)) if !over.contains_key("kind") => {
                overlay(inner, over)?;
            }
            (Some(Value::Array(list)), Value::Table(over)) if list.iter().all(has_name) => {
                by_name(list, over, &key)?;
            }
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
    Ok(())
}

fn name_of(entry: &Value) -> Option<&str> {
    entry.get("name").and_then(Value::as_str)
}

fn has_name(entry: &Value) -> bool {
    name_of(entry).is_some()
}

/// Puts the tables of `over` into those of the list that have their names.
fn by_name(list: &mut [Value], over: toml::Table, key: &str) -> Result<(), String> {
    for (name, value) in over {
        let entry = list.iter().position(|e| name_of(e) == Some(&name));
        match (entry.and_then(|i| list[i].as_table_mut()), value) {
            (Some(entry), Value::Table(value)) => overlay(entry, value)?,
            (Some(_), value) => {
                return Err(format!(
                    "`{key}.\"{name}\"` is {value}, but it must be a table of what differs"
                ));
            }
            (None, _) => {
                let names: Vec<String> = list
                    .iter()
                    .filter_map(|e| Some(format!("`{}`", name_of(e)?)))
                    .collect();
                let known = if names.is_empty() {
                    "there are none".to_owned()
                } else {
                    format!("expected one of {}", names.join(", "))
                };
                return Err(format!("unknown name `{name}` in `{key}`, {known}"));
            }
        }
    }
    Ok(())
}

/// Lists that can be given as a table of what differs from the base's, by name.
const NAMED: [(&[&str], &str); 3] = [
    (&["curriculum"], "phases"),
    (&["task", "reward"], "extra"),
    (&["task", "termination"], "extra"),
];

/// Every value in a table by the path of its key, as `a.b`; lists of tables by their places, as `a[0].b`.
pub(crate) fn leaves(table: &Value) -> Vec<(String, &Value)> {
    fn list<'a>(key: String, value: &'a Value, out: &mut Vec<(String, &'a Value)>) {
        match value {
            Value::Table(table) => {
                let dot = if key.is_empty() { "" } else { "." };
                for (name, value) in table {
                    list(format!("{key}{dot}{name}"), value, out);
                }
            }
            Value::Array(items) if items.iter().any(Value::is_table) => {
                for (place, value) in items.iter().enumerate() {
                    list(format!("{key}[{place}]"), value, out);
                }
            }
            value => out.push((key, value)),
        }
    }
    let mut out = Vec::new();
    list(String::new(), table, &mut out);
    out
}

/// Reads each table of such a list by itself, what it leaves out filled in, so that unknown keys and wrong types in it are
/// told with their line.
pub(super) fn check_changes(text: &str) -> Result<(), toml::de::Error> {
    let whole = DeTable::parse(text)?.into_inner();
    for (path, list) in NAMED {
        let mut names = path.iter().chain([&list]);
        let first = names.next().and_then(|name| whole.get(*name));
        let table = names.try_fold(first, |value, name| {
            Some(value?.get_ref().as_table()?.get(*name))
        });
        let Some(changes) = table.flatten().and_then(|value| value.get_ref().as_table()) else {
            continue;
        };
        for value in changes.values() {
            // What is no table is told where it is put over the base.
            let Some(change) = value.get_ref().as_table() else {
                continue;
            };
            let filled = |missing: &'static str| {
                let mut change = change.clone();
                for (key, value) in DeTable::parse(missing)?.into_inner() {
                    change.entry(key).or_insert(value);
                }
                let value = Spanned::new(value.span(), DeValue::Table(change));
                Ok::<_, toml::de::Error>(ValueDeserializer::from(value))
            };
            let read = match path {
                ["curriculum"] => filled("name = ''\nsteps = 1\nomega_v = [0, 0]")
                    .and_then(|phase| Phase::deserialize(phase).map(|_| ())),
                [_, "reward"] => filled("name = ''\nweight = 0\nexpression = '0'")
                    .and_then(|term| ExtraTerm::deserialize(term).map(|_| ())),
                _ => filled("name = ''\nexpression = '0'")
                    .and_then(|rule| ExtraRule::deserialize(rule).map(|_| ())),
            };
            read.map_err(|mut error| {
                error.set_input(Some(text));
                error
            })?;
        }
    }
    Ok(())
}

/// Takes away such tables, and a temperature whose kind is the base's; says whether there were any.
pub(super) fn without_changes(table: &mut toml::Table) -> bool {
    let mut found = false;
    for (path, list) in NAMED {
        let mut names = path.iter();
        let inner = names.try_fold(&mut *table, |t, name| t.get_mut(*name)?.as_table_mut());
        if let Some(inner) = inner
            && inner.get(list).is_some_and(Value::is_table)
        {
            inner.remove(list);
            found = true;
        }
    }
    let learner = table.get_mut("learner").and_then(Value::as_table_mut);
    if let Some(learner) = learner
        && let Some(temperature) = learner.get("temperature").and_then(Value::as_table)
        && !temperature.contains_key("kind")
    {
        learner.remove("temperature");
        found = true;
    }
    found
}
