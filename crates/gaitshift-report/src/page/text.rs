//! Words and numbers as HTML has them.

use gaitshift_analysis::statistics::wilson_interval;
use gaitshift_experiment::Estimate;
use std::fmt::Write;

/// A number to three figures.
pub(super) fn short(value: f64) -> String {
    // What is left of differences that would be 0 in exact arithmetic.
    let value = if value.abs() < 1e-12 { 0.0 } else { value };
    let size = value.abs();
    let decimals = if size >= 100.0 {
        0
    } else if size >= 10.0 {
        1
    } else if size >= 0.1 || size == 0.0 {
        2
    } else {
        3
    };
    let text = if size > 0.0 && size < 5e-4 {
        format!("{value:.1e}")
    } else {
        let decimals = if (0.1..1.0).contains(&size) {
            3
        } else {
            decimals
        };
        format!("{value:.decimals$}")
    };
    text.replace('-', "\u{2212}")
}

/// The same, with a dash for what is undefined.
pub(super) fn short_or_dash(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), short)
}

/// A number over seeds with its interval, where more than one has a value.
pub(super) fn estimate(estimate: Option<Estimate>, seeds: &[Option<f64>]) -> String {
    match estimate {
        None => "none".to_owned(),
        Some(e) if seeds.iter().flatten().count() < 2 => short(e.value),
        Some(e) => format!(
            "{} <small>[{}, {}]</small>",
            short(e.value),
            short(e.interval[0]),
            short(e.interval[1])
        ),
    }
}

/// Seeds by their numbers: `seed 1`, `seeds 1, 2`.
pub(super) fn numbered(seeds: &[u64]) -> String {
    let numbers: Vec<String> = seeds.iter().map(u64::to_string).collect();
    let s = if numbers.len() == 1 { "" } else { "s" };
    format!("seed{s} {}", numbers.join(", "))
}

/// The single seeds of a number, in small print; nothing for a single one.
pub(super) fn seeds(values: &[Option<f64>]) -> String {
    if values.len() < 2 {
        return String::new();
    }
    let words: Vec<String> = values.iter().copied().map(short_or_dash).collect();
    format!("<div class=\"seeds\">{}</div>", words.join(" "))
}

/// Successes of attempts with Wilson's interval.
pub(super) fn rate(successes: usize, trials: usize) -> String {
    let interval = match wilson_interval(successes, trials) {
        Some((low, high)) => format!(" <small>[{low:.2}, {high:.2}]</small>"),
        None => String::new(),
    };
    format!("{successes} of {trials}{interval}")
}

/// A text as HTML has it.
pub(super) struct Escaped<'a>(pub &'a str);

impl std::fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for character in self.0.chars() {
            match character {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '"' => f.write_str("&quot;")?,
                c => f.write_char(c)?,
            }
        }
        Ok(())
    }
}

/// A sentence: the same with the subscript of ω_v.
pub(super) struct Prose<'a>(pub &'a str);

impl std::fmt::Display for Prose<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (k, part) in self.0.split("ω_v").enumerate() {
            if k > 0 {
                f.write_str("ω<sub>v</sub>")?;
            }
            write!(f, "{}", Escaped(part))?;
        }
        Ok(())
    }
}
