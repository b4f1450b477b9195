//! Contract: the page holds everything and fetches nothing; the same subjects give the same bytes; every figure stands beside it
//! as SVG, PNG, CSV and JSON; seeds of one experiment stand together with intervals.

use gaitshift_experiment::Controller;
use gaitshift_report::{Plan, ReportError, Subject, write_report};
use std::collections::BTreeMap;
use std::path::Path;

/// The least plan that has something of everything.
fn tiny() -> Plan {
    Plan {
        range: [0.0, 3.5, 0.5],
        steady_s: 12.0,
        stairs: [0.6, 0.3, 6.0],
        starts: 2,
        starts_step: 0.3,
        trials: 2,
        phases: 2,
        step_heights_m: [0.002, 0.004, 0.002],
        noise_levels: vec![0.5],
        followed: vec![0.0, 3.0],
        ..Plan::quick()
    }
}

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().display().to_string();
                all.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    all
}

fn written(subjects: &mut [Subject]) -> BTreeMap<String, Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    let paths = write_report(subjects, &tiny(), folder.path(), &mut |_| {}).unwrap();
    assert_eq!(paths[0], folder.path().join("report.html"));
    let all = files(folder.path());
    assert_eq!(paths.len(), all.len());
    all
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

#[test]
fn the_page_of_the_shipped_controller_is_whole_and_always_the_same() {
    let all = written(&mut [Subject::shipped().unwrap()]);
    let page = text(&all["report.html"]);
    // Links lead to files beside it; nothing is fetched from anywhere.
    for fetching in ["src=", "@import", "url(", "<script", "<link"] {
        assert!(!page.contains(fetching), "{fetching}");
    }
    for (at, _) in page.match_indices("href=\"") {
        let target = page[at + 6..].split('"').next().unwrap();
        let known = target.starts_with('#') && page.contains(&format!("id=\"{}\"", &target[1..]));
        assert!(known || all.contains_key(target), "{target}");
    }
    assert!(!page.contains("NaN") && !page.contains("inf<"));
    assert!(page.matches("<svg ").count() >= 13);
    // Every figure has its four files.
    let figures: Vec<&String> = all.keys().filter(|name| name.ends_with(".svg")).collect();
    for svg in &figures {
        let stem = svg.trim_end_matches(".svg");
        for ending in ["png", "csv", "json"] {
            assert!(
                all.contains_key(&format!("{stem}.{ending}")),
                "{stem}.{ending}"
            );
        }
    }
    for name in [
        "bifurcation",
        "energy-flow",
        "ground-reaction",
        "fig3-walk-to-run",
        "sweep",
    ] {
        assert!(figures.iter().any(|f| f.contains(name)), "{name}");
    }
    let numbers: serde_json::Value = serde_json::from_slice(&all["report.json"]).unwrap();
    assert_eq!(numbers["format"], "gaitshift-report 1");
    let walk = &numbers["studies"][0]["steady"][0];
    assert_eq!(
        (&walk["omega_v"], &walk["gait"]),
        (&0.0.into(), &"walking".into())
    );
    let claims = text(&all["claims.csv"]);
    assert!(claims.contains("it walks at ω_v = 0,double support,1.0,,,every attempt,holds"));

    assert!(
        written(&mut [Subject::shipped().unwrap()]) == all,
        "the same bytes"
    );
}

#[test]
fn seeds_of_one_experiment_stand_together() {
    // Two seeds of one experiment: the shipped controller and itself.
    let mut subjects: Vec<Subject> = (1..=2)
        .map(|seed| Subject {
            name: format!("run {seed} <b>"),
            group: "an \"experiment\" & more".to_owned(),
            seed,
            ..Subject::shipped().unwrap()
        })
        .collect();
    let all = written(&mut subjects);
    let page = text(&all["report.html"]);
    assert!(page.contains("an &quot;experiment&quot; &amp; more (seeds 1, 2)"));
    assert!(page.contains("run 1 &lt;b&gt;") && !page.contains("run 1 <b>"));
    // Intervals, which a single seed has not: both values are the same here.
    let claims = text(&all["claims.csv"]);
    let froude = claims
        .lines()
        .find(|line| line.contains("Froude number at ω_v = 0"))
        .unwrap();
    let cells: Vec<&str> = froude.split(',').collect();
    let value = cells
        .iter()
        .position(|cell| cell.starts_with("0.18"))
        .unwrap();
    assert_eq!(cells[value + 1], cells[value]);
    // Each has figures of its own.
    for folder in ["figures/1-run-1--b-", "figures/2-run-2--b-"] {
        assert!(
            all.contains_key(&format!("{folder}/bifurcation.svg")),
            "{folder}"
        );
    }
    assert!(all.contains_key("figures/sweep.svg"));
}

#[test]
fn a_run_brings_its_episodes() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    std::fs::create_dir(&run).unwrap();
    Controller::shipped()
        .unwrap()
        .write(&run.join("controller.safetensors"))
        .unwrap();
    assert_eq!(Subject::read(&run).unwrap().run, None);
    // Folders of several experiments are all called `seed-1`: a run is named after what it is.
    std::fs::write(run.join("config.toml"), "name = \"paper\"\nseed = 7\n").unwrap();
    let subject = Subject::read(&run).unwrap();
    assert_eq!(
        (subject.name.as_str(), subject.group.as_str(), subject.seed),
        ("paper, seed 7", "paper", 7)
    );
    assert_eq!(subject.run, Some(run.clone()));
    let log = "step,omega_v,total_reward,periods,ended,distance_m\n";
    let episodes: String = (1..=10)
        .map(|k| {
            let ended = if k == 10 { "pitch" } else { "time limit" };
            format!("{},0.5,{k}.5,1000,{ended},3.5\n", 1000 * k)
        })
        .collect();
    std::fs::write(run.join("episodes.csv"), log.to_owned() + &episodes).unwrap();
    let all = written(&mut [subject.clone()]);
    assert!(all.contains_key("figures/fig4-returns.svg"));
    // Of the episodes from step 8000 on one in three ended in a fall: more than twice the tenth that "almost none" allows.
    let claims = text(&all["claims.csv"]);
    let line = claims
        .lines()
        .find(|line| line.contains("with phase I"))
        .unwrap();
    assert!(line.contains("0.3333") && line.contains("fails"), "{line}");

    // A log that was cut off names the file and the line.
    std::fs::write(run.join("episodes.csv"), log.to_owned() + "1000,0.5,1.5,10").unwrap();
    let out = folder.path().join("out");
    let error = write_report(&mut [subject], &tiny(), &out, &mut |_| {}).unwrap_err();
    assert!(matches!(error, ReportError::Log { .. }));
    let message = error.to_string();
    assert!(
        message.contains("episodes.csv") && message.contains("line: 2"),
        "{message}"
    );
}

#[test]
fn what_cannot_be_reported_on_is_an_error() {
    let out = tempfile::tempdir().unwrap();
    let none = write_report(&mut [], &tiny(), out.path(), &mut |_| {});
    assert!(matches!(none, Err(ReportError::NoSubject)));
    let missing = Subject::read(Path::new("no/such/run"))
        .unwrap_err()
        .to_string();
    assert!(missing.contains("no/such/run"), "{missing}");
    let file = out.path().join("file");
    std::fs::write(&file, "").unwrap();
    let blocked = write_report(
        &mut [Subject::shipped().unwrap()],
        &tiny(),
        &file,
        &mut |_| {},
    );
    let message = blocked.unwrap_err().to_string();
    assert!(
        message.contains("file") && message.contains("--out"),
        "{message}"
    );
}
