//! Numbers that a phase of the curriculum replaces or moves, by their keys.

use crate::TaskError;
use crate::error::require;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::marker::PhantomData;

/// A table of numbers, each of which has a key.
pub trait Keyed {
    /// What the table belongs to, e.g. "the reward".
    const OWNER: &'static str;
    /// The keys, in the order of the fields.
    const KEYS: &'static [&'static str];

    /// The values, in the order of [`Keyed::KEYS`].
    fn values(&self) -> Vec<f64>;

    /// The value of a key, to change it; none if there is no such key.
    fn get_mut(&mut self, key: &str) -> Option<&mut f64>;

    /// Whether a finite value is one for the key `name`, and what is.
    fn accepts(name: &str, value: f64) -> (bool, &'static str);

    /// Checks a value of the key `name`, which the user knows as `key`.
    ///
    /// # Errors
    /// A value out of range.
    fn check(key: &str, name: &str, value: f64) -> Result<(), TaskError> {
        let (ok, accepted) = Self::accepts(name, value);
        require(ok && value.is_finite(), key, value, accepted)
    }
}

/// Declares a struct of numbers and, from the same list, their access by key.
macro_rules! keyed_numbers {
    (
        $(#[$meta:meta])*
        struct $type:ident of $owner:literal {
            $($(#[$doc:meta])* $name:ident,)*
        }
        $(also { $($rest:tt)* })?
    ) => {
        $(#[$meta])*
        pub struct $type {
            $($(#[$doc])* pub $name: f64,)*
            $($($rest)*)?
        }

        impl $crate::Keyed for $type {
            const OWNER: &'static str = $owner;
            const KEYS: &'static [&'static str] = &[$(stringify!($name)),*];

            fn values(&self) -> Vec<f64> {
                vec![$(self.$name),*]
            }

            fn get_mut(&mut self, key: &str) -> Option<&mut f64> {
                match key {
                    $(stringify!($name) => Some(&mut self.$name),)*
                    _ => None,
                }
            }

            fn accepts(name: &str, value: f64) -> (bool, &'static str) {
                Self::range(name, value)
            }
        }
    };
}
pub(crate) use keyed_numbers;

/// A number moved a share of the way to another: 1 gives the other to the bit.
pub(crate) fn blend(from: f64, to: f64, share: f64) -> f64 {
    if share < 1.0 {
        from + share * (to - from)
    } else {
        to
    }
}

/// Some of a table's keys with the values that replace the table's own, e.g. `{ omega_e = 0.06 }`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(
    try_from = "BTreeMap<String, f64>",
    into = "BTreeMap<String, f64>",
    bound = "T: Keyed + Clone"
)]
pub struct Overrides<T>(BTreeMap<String, f64>, PhantomData<T>);

impl<T> Default for Overrides<T> {
    fn default() -> Self {
        Self(BTreeMap::new(), PhantomData)
    }
}

impl<T> From<Overrides<T>> for BTreeMap<String, f64> {
    fn from(overrides: Overrides<T>) -> Self {
        overrides.0
    }
}

impl<T: Keyed> TryFrom<BTreeMap<String, f64>> for Overrides<T> {
    type Error = String;

    fn try_from(values: BTreeMap<String, f64>) -> Result<Self, String> {
        match values.keys().find(|key| !T::KEYS.contains(&key.as_str())) {
            None => Ok(Self(values, PhantomData)),
            Some(key) => {
                let known: Vec<String> = T::KEYS.iter().map(|key| format!("`{key}`")).collect();
                Err(format!(
                    "unknown field `{key}` of {}, expected one of {}",
                    T::OWNER,
                    known.join(", ")
                ))
            }
        }
    }
}

impl<T, const N: usize> From<[(&'static str, f64); N]> for Overrides<T> {
    fn from(values: [(&'static str, f64); N]) -> Self {
        let values = values.map(|(key, value)| (key.to_owned(), value));
        Self(values.into(), PhantomData)
    }
}

impl<T> Overrides<T> {
    /// No key replaced.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The value of a key, if it is replaced.
    pub fn get(&self, key: &str) -> Option<f64> {
        self.0.get(key).copied()
    }

    /// The keys and their values.
    pub fn iter(&self) -> impl Iterator<Item = (&str, f64)> {
        self.0.iter().map(|(key, value)| (key.as_str(), *value))
    }
}

impl<T: Keyed> Overrides<T> {
    /// Moves each of the keys in `table` a share of the way to its value here: 1 replaces it.
    pub fn blend_into(&self, table: &mut T, share: f64) {
        for (key, value) in self.iter() {
            if let Some(current) = table.get_mut(key) {
                *current = blend(*current, value, share);
            }
        }
    }

    /// Checks every value; `path` is the user's name of this table.
    pub(crate) fn validate(&self, path: &str) -> Result<(), TaskError> {
        self.iter()
            .try_for_each(|(name, value)| T::check(&format!("{path}.{name}"), name, value))
    }
}
