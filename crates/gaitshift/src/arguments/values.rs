//! What a value on the command line may be.

use gaitshift_experiment::{STEP_UP_MAX_M, parse_seeds};
use gaitshift_task::OMEGA_V_MAX;
use std::cmp::Ordering;
use std::fmt::Display;
use std::path::PathBuf;
use std::str::FromStr;

/// Longest motion or part of one, in s: an hour, whose recording takes some 300 MB of memory.
const LONGEST_S: f64 = 3600.0;
/// Shortest motion, in s.
const SHORTEST_S: f64 = 0.1;

pub fn number(text: &str) -> Result<f64, String> {
    in_range(text, f64::MIN, f64::MAX, "")
}

/// One seed, where several would say nothing.
pub fn seed(text: &str) -> Result<u64, String> {
    whole(text, u64::MAX).map_err(|cause| {
        format!(
            "{cause}; one seed is taken here, `evaluate --seed` and `train --seeds` take several"
        )
    })
}

pub fn port(text: &str) -> Result<u16, String> {
    whole(text, u16::MAX)
}

fn whole<T: FromStr + Display>(text: &str, greatest: T) -> Result<T, String> {
    let value = text.trim().parse();
    value.map_err(|_| format!("`{text}` is no whole number from 0 to {greatest}"))
}

pub fn omega_v(text: &str) -> Result<f64, String> {
    in_range(text, -OMEGA_V_MAX, OMEGA_V_MAX, "")
}

/// Most commands of one range.
const MOST_IN_RANGE: f64 = 1000.0;

/// Commands that an element of a list stands for.
#[derive(Debug, Clone, PartialEq)]
pub struct Commands(pub Vec<f64>);

/// Seeds that an element of a list stands for.
#[derive(Debug, Clone, PartialEq)]
pub struct Seeds(pub Vec<u64>);

/// `1.5`, or `FIRST:LAST:STEP`, both ends included.
pub fn commands(text: &str) -> Result<Commands, String> {
    let parts: Vec<&str> = text.split(':').collect();
    let [first, last, step] = parts[..] else {
        return match parts.len() {
            1 if text.trim().parse::<f64>().is_ok() => Ok(Commands(vec![omega_v(text)?])),
            1 => Err(format!(
                "`{text}` is not a number; a range is FIRST:LAST:STEP, such as 0:3.5:0.5"
            )),
            _ => Err(format!(
                "`{text}` is neither a number nor FIRST:LAST:STEP, such as 0:3.5:0.5"
            )),
        };
    };
    let (first, last, step) = (omega_v(first)?, omega_v(last)?, number(step)?);
    let steps = (last - first) / step;
    if !(0.0..MOST_IN_RANGE).contains(&steps) {
        return Err(format!(
            "STEP must lead from FIRST to LAST in at most {MOST_IN_RANGE} commands"
        ));
    }
    // A step such as 0.1 does not meet its end exactly, and a product of it has a long tail of digits.
    let tidy = |value: f64| (value * 1e9).round() / 1e9;
    let count = (steps + 1e-6).floor() as usize;
    Ok(Commands(
        (0..=count).map(|k| tidy(first + k as f64 * step)).collect(),
    ))
}

/// The seeds of a list, each once.
///
/// # Errors
/// A seed that is there twice: its motions or its run would count twice.
pub fn distinct(lists: &[Seeds]) -> Result<Vec<u64>, String> {
    let seeds: Vec<u64> = lists.iter().flat_map(|list| list.0.clone()).collect();
    match twice(&seeds) {
        Some(seed) => Err(format!("seed {seed} is given twice; give it once")),
        None => Ok(seeds),
    }
}

/// The least value of a list that is there twice.
fn twice<T: Copy + PartialOrd>(list: &[T]) -> Option<T> {
    let mut sorted = list.to_vec();
    sorted.sort_unstable_by(|a, b| a.partial_cmp(b).unwrap_or(Ordering::Equal));
    let pair = sorted.windows(2).find(|pair| pair[0] == pair[1])?;
    Some(pair[0])
}

/// The commands of a list, each once.
///
/// # Errors
/// A command that is there twice: its motion would be measured, and its files written, twice.
pub fn distinct_commands(lists: &[Commands]) -> Result<Vec<f64>, String> {
    let commands: Vec<f64> = lists.iter().flat_map(|list| list.0.clone()).collect();
    match twice(&commands) {
        Some(command) => Err(format!(
            "the command {command} is given twice; give it once"
        )),
        None => Ok(commands),
    }
}

/// Whether paths are of different files.
///
/// # Errors
/// One that is there twice, by whatever name: what is measured of it would count twice.
pub fn distinct_paths(paths: &[PathBuf]) -> Result<(), String> {
    // What is no file, such as a controller's name, is what it is called.
    let place = |path: &PathBuf| path.canonicalize().unwrap_or_else(|_| path.clone());
    let mut places: Vec<PathBuf> = Vec::new();
    for path in paths {
        let at = place(path);
        if places.contains(&at) {
            return Err(format!("{} is given twice; give it once", path.display()));
        }
        places.push(at);
    }
    Ok(())
}

/// `7`, `1..12` or `1-12`, both ends included.
pub fn seeds(text: &str) -> Result<Seeds, String> {
    parse_seeds(text).map(Seeds)
}

/// Lowest step up that a controller is hardened against, in m.
const LOWEST_STEP_M: f64 = 0.001;
/// Greatest impulse of a push, in N s: it would stop any walk at once.
const GREATEST_IMPULSE_N_S: f64 = 1000.0;

/// `FROM:TO` in N s, or one value.
pub fn impulse(text: &str) -> Result<[f64; 2], String> {
    span(text, -GREATEST_IMPULSE_N_S, GREATEST_IMPULSE_N_S, " N s")
}

/// The heights of steps up in m: FROM:TO, or one value.
pub fn step_height(text: &str) -> Result<[f64; 2], String> {
    span(text, LOWEST_STEP_M, STEP_UP_MAX_M, " m")
}

fn span(text: &str, low: f64, high: f64, unit: &str) -> Result<[f64; 2], String> {
    let (from, to) = text.split_once(':').unwrap_or((text, text));
    let value = |text| in_range(text, low, high, unit);
    let range = [value(from)?, value(to)?];
    if range[0] > range[1] {
        return Err(format!("FROM is greater than TO; write {to}:{from}"));
    }
    Ok(range)
}

/// The K-th of N parts.
#[derive(Debug, Clone, Copy)]
pub struct Part {
    /// From 1 on.
    pub number: usize,
    /// Number of parts.
    pub of: usize,
}

pub fn part(text: &str) -> Result<Part, String> {
    let parts = text.split_once('/');
    let numbers = parts.and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
    match numbers {
        Some((number, of)) if (1..=of).contains(&number) => Ok(Part { number, of }),
        _ => Err("expected K/N with K from 1 to N, such as 2/4".to_owned()),
    }
}

pub fn duration_s(text: &str) -> Result<f64, String> {
    in_range(text, SHORTEST_S, LONGEST_S, " s")
}

/// A host name alone, as a browser sends it.
pub fn host_name(text: &str) -> Result<String, String> {
    let part = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    match !text.is_empty() && text.chars().all(part) {
        true => Ok(text.to_owned()),
        false => {
            Err("expected a host name without scheme and port, such as lab.example.org".to_owned())
        }
    }
}

/// A time of a recording, whose clock may have begun anywhere.
pub fn recorded_s(text: &str) -> Result<f64, String> {
    in_range(text, f64::MIN, f64::MAX, " s")
}

pub fn time_s(text: &str) -> Result<f64, String> {
    in_range(text, 0.0, LONGEST_S, " s")
}

fn in_range(text: &str, low: f64, high: f64, unit: &str) -> Result<f64, String> {
    let value: f64 = text
        .trim()
        .parse()
        .map_err(|_| format!("`{text}` is not a number"))?;
    if (low..=high).contains(&value) {
        Ok(value)
    } else if low == f64::MIN {
        Err(format!("`{text}` is not a finite number"))
    } else {
        Err(format!("it must be from {low} to {high}{unit}"))
    }
}
