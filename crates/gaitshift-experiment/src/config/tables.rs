//! TOML files and tables: reading, one value by its key, one table over another.

use super::ConfigError;
use super::names::parse_error;
use std::path::Path;

pub(crate) fn read(path: &Path) -> Result<String, ConfigError> {
    std::fs::read_to_string(path).map_err(|source| ConfigError::Read {
        path: path.to_owned(),
        source,
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
