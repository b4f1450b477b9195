//! `gaitshift sweep` end to end on a tiny file: what it leaves behind, that it goes on where it was stopped, and
//! bad input.

use crate::common::Place;

const TINY: &str = r#"
name = "tiny sweep"
experiment = "fast"
seeds = [1]
[set.learner]
actor_hidden = [8]
critic_hidden = [8]
batch_size = 32
threads = 1
[set.training]
environments = 4
steps_per_update = 8
learning_starts = 200
evaluation_interval_steps = 800
replay_capacity = 6000
[[set.curriculum.phases]]
name = "only"
steps = 800
omega_v = [-0.2, 0.2]
[[variants]]
name = "rubber"
[[variants]]
name = "ice"
set.body = { friction = 0.3 }
"#;

#[test]
fn a_sweep_leaves_runs_and_a_table_and_is_not_run_twice() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    let table = place.json("sweep tiny.toml --json");
    let variants = table["variants"].as_array().unwrap();
    assert_eq!(variants.len(), 2);
    assert_eq!(variants[1]["variant"], "ice");
    assert_eq!(variants[1]["finished"], 1);
    for file in [
        "table.md",
        "table.json",
        "table.svg",
        "table.png",
        "rubber/seed-1/controller.safetensors",
        "ice/seed-1/report.json",
    ] {
        assert!(place.path("runs/tiny-sweep").join(file).is_file(), "{file}");
    }
    let again = place.output("sweep tiny.toml");
    let said = String::from_utf8_lossy(&again.stderr);
    assert!(said.contains("0 runs finished now, 2 before"), "{said}");
    let markdown = String::from_utf8_lossy(&again.stdout);
    assert!(markdown.contains("| ice | 1 | 1 |"), "{markdown}");
}

// Everything was finished, and it ended as bad input, whose remedy was to run it.
#[test]
fn without_an_evaluation_there_is_no_table_and_no_error() {
    let place = Place::new();
    place.write(
        "tiny.toml",
        TINY.replace(
            "evaluation_interval_steps = 800",
            "evaluation_interval_steps = 1000",
        ),
    );
    let output = place.output("sweep tiny.toml");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(
        said.contains("2 runs finished now") && said.contains("no table"),
        "{said}"
    );
    place.refused("sweep tiny.toml --table", &["no run has been evaluated"]);
    // It printed nothing.
    let table = place.json("sweep tiny.toml --json");
    assert_eq!(table["trials"].as_array().map(Vec::len), Some(0), "{table}");
}

// What came before it was trained first, for hours.
#[test]
fn a_folder_of_other_settings_is_refused_before_anything_is_trained() {
    let place = Place::new();
    place.write(
        "tiny.toml",
        TINY.replace("[[variants]]\nname = \"rubber\"\n", ""),
    );
    place.stdout("sweep tiny.toml");
    place.write(
        "tiny.toml",
        TINY.replace("friction = 0.3", "friction = 0.4"),
    );
    for options in ["", " --dry-run", " --table"] {
        let output = place.output(&format!("sweep tiny.toml{options}"));
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(
            said.contains("ice/seed-1") && said.contains("--out"),
            "{said}"
        );
        assert!(!place.path("runs/tiny-sweep/rubber").exists());
    }
}

// It had a pace of 0 and took 0 s.
#[test]
fn a_run_too_short_to_be_measured_has_no_pace() {
    let place = Place::new();
    place.write("short.toml", TINY.replace("steps = 800", "steps = 8"));
    let json = place.json("sweep short.toml --dry-run --json");
    assert!(json["variants"][0]["steps_per_s"].is_null(), "{json}");
    let said = place.stdout("sweep short.toml --dry-run");
    assert!(said.contains("before their pace"), "{said}");
}

#[test]
fn parts_of_a_grid_run_by_themselves_and_make_one_table() {
    let place = Place::new();
    let (head, _) = TINY.split_once("[[variants]]").unwrap();
    place.write(
        "grid.toml",
        format!("{head}[vary]\nbody.friction = [0.3, 1.0]\n"),
    );
    let first = place.json("sweep grid.toml --part 1/2 --json");
    assert_eq!(first["trials"].as_array().unwrap().len(), 1);
    let both = place.json("sweep grid.toml --part 2/2 --json");
    assert_eq!(both["trials"].as_array().unwrap().len(), 2);
    assert_eq!(both["variants"][1]["values"]["body.friction"], "1.0");
    let svg = String::from_utf8(place.read("runs/tiny-sweep/table.svg")).unwrap();
    assert!(svg.contains("friction=0.3") && svg.contains("criteria met"));
    place.refused("sweep grid.toml --part 3/2", &["K/N"]);
    place.refused("sweep grid.toml --part 0/2", &["K/N"]);
}

#[test]
fn a_dry_run_says_how_long_it_takes_and_writes_nothing() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    let said = place.stdout("sweep tiny.toml --dry-run --jobs 2");
    assert!(
        said.contains("ice: 1 seed of 800 steps") && said.contains("2 at a time"),
        "{said}"
    );
    let json = place.json("sweep tiny.toml --dry-run --jobs 2 --json");
    let ice = &json["variants"][1];
    assert_eq!((&ice["name"], &ice["seeds"]), (&"ice".into(), &1.into()));
    assert_eq!((&ice["steps"], &json["jobs"]), (&800.into(), &2.into()));
    let [all, wall] = ["training_s", "duration_s"].map(|key| json[key].as_f64().unwrap());
    let longest = |json: &serde_json::Value| {
        let s = |k: usize| json["variants"][k]["duration_s"].as_f64().unwrap();
        s(0).max(s(1))
    };
    // The longer run may take more than half of it all.
    assert!(all > 0.0 && wall == longest(&json).max(all / 2.0), "{json}");
    // More at a time than there are runs make none of them shorter.
    let many = place.json("sweep tiny.toml --dry-run --jobs 8 --json");
    assert_eq!(many["duration_s"].as_f64(), Some(longest(&many)), "{many}");
    assert!(!place.path("runs").exists());
    // Of several variants it was not said which one cannot be learned.
    let wild = TINY.replace(
        "set.body = { friction = 0.3 }",
        "set.learner = { learning_rate = 1e30 }",
    );
    assert_ne!(wild, TINY);
    place.write("wild.toml", wild);
    let output = place.output("sweep wild.toml --dry-run");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("variant `ice`: update"), "{stderr}");
}

#[test]
fn bad_files_are_named() {
    let place = Place::new();
    place.write("bad.toml", TINY.replace("friction", "frictoin"));
    place.refused("sweep bad.toml", &["variant `ice`", "frictoin"]);
    place.refused("sweep none.toml", &["none.toml"]);
    place.refused("sweep bad.toml --jobs 0", &["--jobs"]);
    place.write("tiny.toml", TINY);
    place.refused(
        "sweep tiny.toml --table",
        &["no run has been evaluated yet"],
    );
}
