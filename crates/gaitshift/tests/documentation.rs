//! Contract: docs/deviations.md explains every key of an experiment (two keys were added without a line there), and the
//! commands and experiments that README.md and docs/ show are ones that the program takes.

use crate::common::Place;
use gaitshift_experiment::Experiment;
use std::path::Path;
use toml::{Table, Value};

const PAGE: &str = include_str!("../../../docs/deviations.md");

/// Paths of the keys that hold a value, e.g. `task.reward.omega_e`.
fn keys(table: &Table, path: &str) -> Vec<String> {
    let below = |(key, value): (&String, &Value)| {
        let path = format!("{path}{key}");
        match value {
            Value::Table(table) => keys(table, &format!("{path}.")),
            Value::Array(values) if values.iter().any(Value::is_table) => values
                .iter()
                .filter_map(Value::as_table)
                .flat_map(|table| keys(table, &format!("{path}.")))
                .collect(),
            _ => vec![path],
        }
    };
    table.iter().flat_map(below).collect()
}

#[test]
fn every_key_has_its_line() {
    let config = Experiment::recipe("fast").unwrap().to_toml().unwrap();
    let keys = keys(&config.parse().unwrap(), "");
    assert!(keys.len() > 100, "{keys:?}");
    for key in keys {
        let name = key.rsplit('.').next().unwrap();
        // The page explains `start.*` as one.
        let explained = PAGE.contains(&format!("{name}`"))
            || ["name", "seed", "kind"].contains(&name)
            || key.starts_with("task.start.");
        assert!(explained, "docs/deviations.md has no line about `{key}`");
    }
}

/// Experiments that a page shows.
fn experiments(page: &str) -> Vec<Experiment> {
    let blocks = page.split("```toml\n").skip(1);
    let texts = blocks.map(|block| block.split("```").next().unwrap());
    texts
        .map(|text| Experiment::parse(text, "example").unwrap_or_else(|e| panic!("{e}\n{text}")))
        .collect()
}

#[test]
fn every_experiment_that_is_shown_is_one() {
    for page in [
        include_str!("../../../README.md"),
        include_str!("../../../README.ja.md"),
    ] {
        let [mine] = &experiments(page)[..] else {
            panic!("one experiment is shown")
        };
        // What went wrong: its phases inherited a course of the recipe that cut them in the middle.
        let rate = |step| mine.learner_at(step).learning_rate;
        assert_eq!([0, 1_000_000, 1_999_999].map(rate), [3e-4; 3]);
        assert!((rate(3_500_000) - 2e-4).abs() < 1e-12);
        assert_eq!(mine.curriculum.rehearsal_start(), None);
        assert_eq!(mine.criteria.count(), 39);
    }
    let shown = experiments(include_str!("../../../docs/learning.md"));
    let counts: Vec<usize> = shown.iter().map(|e| e.criteria.count()).collect();
    assert_eq!(counts, [39, 39, 26]);
}

/// Lines of code blocks, fenced or indented, that call the program, without their comments.
fn commands(page: &str) -> Vec<&str> {
    let mut fenced = false;
    let in_code = |line: &&str| {
        fenced ^= line.starts_with("```");
        fenced || line.starts_with("    ")
    };
    let calls = page.lines().filter(in_code).map(str::trim);
    let calls = calls.filter(|line| line.starts_with("gaitshift "));
    calls
        .map(|line| line.split(" #").next().unwrap_or(line).trim_end())
        .collect()
}

/// Calls of the program within the text, but for those that stand for any command.
fn inline(page: &str) -> impl Iterator<Item = &str> {
    let quoted = page.split('`').skip(1).step_by(2);
    quoted.filter(|text| text.starts_with("gaitshift ") && !text.contains("COMMAND"))
}

/// With `--help` at the end, all options before it are parsed, and nothing runs.
fn is_taken(place: &Place, line: &str) {
    let arguments = line.trim_start_matches("gaitshift ");
    place.stdout(&format!("{arguments} --help"));
}

// Its tables were read by nothing.
#[test]
fn every_command_of_the_page_by_goal_is_one_that_the_program_takes() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/goals.md");
    let place = Place::new();
    let mut seen = 0;
    for line in inline(&std::fs::read_to_string(page).unwrap()) {
        is_taken(&place, line);
        seen += 1;
    }
    assert!(seen > 20, "{seen}");
}

#[test]
fn every_command_line_of_the_documentation_is_one_that_the_program_takes() {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let docs = std::fs::read_dir(repository.join("docs")).unwrap();
    let pages = docs.map(|entry| entry.unwrap().path());
    let pages = pages.filter(|path| path.extension().is_some_and(|e| e == "md"));
    let place = Place::new();
    let mut seen = 0;
    for page in pages.chain([repository.join("README.md")]) {
        for line in commands(&std::fs::read_to_string(&page).unwrap()) {
            is_taken(&place, line);
            seen += 1;
        }
    }
    assert!(seen > 15, "{seen}");
}
