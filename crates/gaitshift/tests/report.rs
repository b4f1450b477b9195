//! Contract: `report` and `reproduce` refuse what they cannot use with one error, before they measure anything. The commands
//! on the page give the page's numbers. What else they write is tested in gaitshift-report.

use crate::common::Place;
use gaitshift_report::{Plan, Subject, Work, write_report};
use serde_json::Value;

#[test]
fn what_cannot_be_reported_on_is_one_error() {
    let place = Place::new();
    place.refused("report no-such-run", &["no-such-run"]);
    place.refused("report --quick", &["RUN|FILE|NAME"]);
    place.refused("reproduce --quick --dry-run", &["--dry-run"]);
    // Said at once, not after a minute of measuring.
    place.write("file", "");
    let output = place.output("report --quick shipped --out file");
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("file") && error.contains("--out"), "{error}");
    assert!(!error.contains("steady motions"), "{error}");
}

// The page's numbers took the place of the run's own report.
#[test]
fn a_report_is_not_written_into_a_run() {
    let place = Place::new();
    std::fs::create_dir(place.path("run")).unwrap();
    place.write("run/config.toml", "");
    place.refused(
        "report shipped --quick --out run",
        &["run", "report.json", "--out"],
    );
    // Hours of training came first.
    place.refused(
        "reproduce --learner fast --out run",
        &["run", "report.json"],
    );
}

#[test]
fn a_run_without_a_best_controller_is_said_to_have_none() {
    let place = Place::new();
    std::fs::create_dir(place.path("run")).unwrap();
    let shipped = include_bytes!("../../gaitshift-experiment/controllers/biped.safetensors");
    place.write("run/controller-last.safetensors", shipped);
    place.write("file", "");
    let output = place.output("report --quick run --out file");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(error.contains("run: not evaluated yet"), "{error}");
}

/// A table with its cells by the names of its columns.
fn table(place: &Place, name: &str) -> Vec<Value> {
    let table: Value = serde_json::from_slice(&place.read(name)).unwrap();
    let columns = table["columns"].as_array().unwrap();
    let named = |row: &Value| {
        let cells = row.as_array().unwrap().iter();
        let cells = columns
            .iter()
            .map(|c| c.as_str().unwrap().to_owned())
            .zip(cells.cloned());
        Value::Object(cells.collect())
    };
    table["rows"]
        .as_array()
        .unwrap()
        .iter()
        .map(named)
        .collect()
}

/// The value that a key of the rows, or the words around it, ask for.
fn asked(rows: &[Value], value: &str) -> Option<f64> {
    let number = |row: &Value, key: &str| row[key].as_f64();
    let words: Vec<&str> = value.split(' ').collect();
    let gaits = |row: &&Value| row["gait"] == "walking" || row["gait"] == "running";
    let journal = |row: &&Value| (0.0..=2.93).contains(&row["omega_v"].as_f64().unwrap());
    match words[..] {
        ["gait"] => {
            let gait = if rows[0]["omega_v"] == 0.0 {
                "walking"
            } else {
                "running"
            };
            Some(f64::from(u8::from(rows[0]["gait"] == gait)))
        }
        [key] => number(&rows[0], key),
        [key, "divided", "by", divisor] => {
            let key = key.trim_end_matches(',');
            Some(number(&rows[0], key)? / divisor.parse::<f64>().ok()?)
        }
        ["mean", "of", right, "and", left] => {
            Some(0.5 * (number(&rows[0], right)? + number(&rows[0], left)?))
        }
        ["greatest", "energy_recovery", ..] => {
            let walks = rows.iter().filter(|row| row["gait"] == "walking");
            walks
                .filter_map(|row| number(row, "energy_recovery"))
                .reduce(f64::max)
        }
        [
            end @ ("least" | "greatest"),
            key,
            "of",
            "rows",
            ref rest @ ..,
        ] => {
            let rows = rows.iter().filter(gaits);
            let values: Vec<f64> = rows
                .filter(|row| rest[0] != "from" || journal(row))
                .filter_map(|row| number(row, key))
                .collect();
            let choose = if end == "least" { f64::min } else { f64::max };
            values.into_iter().reduce(choose)
        }
        ["omega_v", ..] => {
            let up = rows
                .iter()
                .filter(|row| row["omega_v"].as_f64() >= Some(0.0));
            let stands = up.take_while(|row| row["fell"] == false);
            stands.last().and_then(|row| number(row, "omega_v"))
        }
        _ => panic!("what is {value}?"),
    }
}

#[test]
fn the_commands_on_the_page_give_its_numbers() {
    let place = Place::new();
    let plan = Plan {
        range: [0.0, 3.5, 0.5],
        steady_s: 12.0,
        stairs: [0.3, 0.3, 15.0],
        starts: 1,
        starts_step: 0.3,
        trials: 1,
        phases: 1,
        step_heights_m: [0.002, 0.002, 0.002],
        noise_levels: vec![],
        followed: vec![],
        ..Plan::quick()
    };
    let work = Work {
        threads: 1,
        say: &|_| {},
        stop: &|| false,
    };
    let mut subjects = [Subject::shipped().unwrap()];
    write_report(&mut subjects, &[], &plan, &place.path("page"), &work).unwrap();
    let mut rows = table(&place, "page/claims.json");
    rows.extend(table(&place, "page/numbers.json"));
    let (mut tried, mut answers) = (0, std::collections::BTreeMap::new());
    for row in &rows {
        let text = |key: &str| row[key].as_str().unwrap();
        let Some(arguments) = text("command").strip_prefix("gaitshift evaluate ") else {
            assert_eq!(text("command"), "gaitshift report shipped");
            continue;
        };
        // Of an experiment that was not measured there is nothing to compare.
        if text("experiment") != "shipped controller" || text("ours").is_empty() {
            continue;
        }
        let answer = answers
            .entry(arguments.to_owned())
            .or_insert_with(|| place.json(&format!("evaluate {arguments}")));
        let found = asked(answer["rows"].as_array().unwrap(), text("value_of_command"));
        let ours: f64 = text("ours").parse().unwrap();
        assert_eq!(found, Some(ours), "{row}");
        tried += 1;
    }
    assert!(tried > 30, "{tried}");
}
