//! Seeds of several runs or motions, as they are written: `7`, `1..12`, `1-12`.

use serde::Deserialize;
use serde::de::{Deserializer, Error};

/// The greatest seed of a run, which is the greatest number that a TOML file holds: its configuration is written and read again.
pub(crate) const GREATEST: u64 = i64::MAX.unsigned_abs();

/// Most seeds of one range.
const MOST_IN_RANGE: u64 = 1000;

/// `7`, `1..12` or `1-12`, both ends included.
///
/// # Errors
/// What it has to be.
pub fn parse_seeds(text: &str) -> Result<Vec<u64>, String> {
    let whole = |text: &str| {
        let number = text.trim().parse::<u64>();
        number.map_err(|_| {
            format!("`{text}` is not a whole number from 0 on, nor a range such as 1..12")
        })
    };
    let range = text.split_once("..").or_else(|| text.split_once('-'));
    let Some((first, last)) = range.filter(|(first, _)| !first.trim().is_empty()) else {
        return Ok(vec![whole(text)?]);
    };
    let (first, last) = (whole(first)?, whole(last.trim_start_matches('='))?);
    if first > last || last - first >= MOST_IN_RANGE {
        return Err(format!(
            "`{text}` must be from a lower to a higher seed, at most {MOST_IN_RANGE} of them"
        ));
    }
    Ok((first..=last).collect())
}

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "a list of whole numbers from 0 on, such as [1, 2, 3], or a range such as \"1-5\""
)]
enum Written {
    List(Vec<u64>),
    Range(String),
}

/// A file's `seeds`: a list, or a range as text.
pub(crate) fn listed<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<u64>, D::Error> {
    match Written::deserialize(deserializer)? {
        Written::List(seeds) => Ok(seeds),
        Written::Range(text) => parse_seeds(&text).map_err(Error::custom),
    }
}
