//! `gaitshift train` end to end on a tiny recipe: what a run leaves behind, that stopping and resuming
//! changes nothing, that Ctrl-C loses nothing, and bad input.

mod common;
use common::Place;

const TINY: &str = r#"
name = "tiny run"
base = "fast"
seed = 5
[[curriculum.phases]]
name = "only"
steps = 6000
omega_v = [-0.2, 0.2]
[learner]
actor_hidden = [8]
critic_hidden = [8]
batch_size = 32
threads = 1
[training]
environments = 4
steps_per_update = 8
learning_starts = 1000
evaluation_interval_steps = 3000
checkpoint_interval_steps = 6000
replay_capacity = 6000
"#;

fn place_with_recipe() -> Place {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    place
}

#[test]
fn a_run_leaves_everything_behind_and_its_controller_can_be_evaluated() {
    let place = place_with_recipe();
    let report = place.json("train tiny.toml --json");
    assert_eq!(report["finished"], true);
    assert_eq!(report["step"], 6000);
    assert_eq!(report["folder"], "runs/tiny-run-5");
    // The parts of a run make up its time.
    let parts = report["parts"].as_object().unwrap();
    let seconds = |name: &str| parts[name].as_f64().unwrap();
    let sum: f64 = parts.keys().map(|name| seconds(name)).sum();
    let elapsed_s = report["elapsed_s"].as_f64().unwrap();
    assert!(sum <= elapsed_s && sum > 0.8 * elapsed_s, "{report}");
    assert!(
        seconds("learning_s") > 0.0 && seconds("simulating_s") > 0.0,
        "{report}"
    );
    for name in [
        "config.toml",
        "metrics.csv",
        "episodes.csv",
        "evaluations.jsonl",
        "events.out.tfevents.gaitshift",
        "report.json",
        "controller.safetensors",
        "controller-last.safetensors",
        "checkpoint",
        "returns.svg",
        "returns.png",
    ] {
        let path = place.path("runs/tiny-run-5").join(name);
        assert!(path.exists(), "{}", path.display());
    }
    let controller = report["controller"].as_str().unwrap();
    let evaluate = format!("evaluate --controller {controller} --omega-v 0 --duration-s 1 --json");
    assert_eq!(place.json(&evaluate)["rows"].as_array().unwrap().len(), 1);
    // The resolved configuration is a recipe by itself.
    place.stdout("train runs/tiny-run-5/config.toml --out again --steps 1");
    // A run is never overwritten.
    place.refused("train tiny.toml", &["runs/tiny-run-5", "--resume", "--out"]);
}

#[test]
fn stopping_and_resuming_ends_with_the_same_controller() {
    let place = place_with_recipe();
    place.stdout("train tiny.toml --out whole");
    let output = place.output("train tiny.toml --out parts --steps 2000");
    assert_eq!(output.status.code(), Some(0));
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(
        stderr.contains("gaitshift train --resume parts"),
        "{stderr}"
    );
    let report = place.json("train --resume parts --threads 2 --json");
    assert_eq!(report["finished"], true);
    let rows = |folder: &str| {
        let file = format!("{folder}/controller-last.safetensors");
        place.json(&format!(
            "evaluate --controller {file} --omega-v 0,3 --json"
        ))
    };
    assert_eq!(rows("whole"), rows("parts"));
    assert_eq!(
        place.read("whole/episodes.csv"),
        place.read("parts/episodes.csv")
    );
}

#[test]
fn the_seed_and_the_threads_are_the_users() {
    let place = place_with_recipe();
    for (seed, threads, folder) in [(1, 1, "a"), (1, 2, "b"), (2, 1, "c")] {
        place.stdout(&format!(
            "train tiny.toml --seed {seed} --threads {threads} --out {folder} --steps 3000"
        ));
    }
    let episodes = |folder: &str| place.read(&format!("{folder}/episodes.csv"));
    assert_eq!(episodes("a"), episodes("b"));
    assert_ne!(episodes("a"), episodes("c"));
}

#[test]
fn progress_goes_to_standard_error_in_plain_lines() {
    let output = place_with_recipe().output("train tiny.toml --out run");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(stderr.contains("of 6,000 steps"), "{stderr}");
    // One line for each evaluation: step, criteria met, what it does at each command.
    let evaluation = stderr
        .lines()
        .find(|line| line.trim_start().starts_with("3,000 "));
    let evaluation = evaluation.unwrap_or_else(|| panic!("{stderr}"));
    assert!(
        evaluation.contains("/39") && evaluation.contains("fell"),
        "{stderr}"
    );
    assert!(!stderr.contains('\u{1b}'), "{stderr}");
    let stdout = String::from_utf8_lossy(&output.stdout);
    assert!(stdout.contains("6,000 steps and"), "{stdout}");
}

#[cfg(unix)]
#[test]
fn an_interrupt_writes_a_checkpoint_to_go_on_from() {
    use std::io::{BufRead, BufReader, Read};
    use std::process::{Command, Stdio};
    let place = place_with_recipe();
    place.write(
        "long.toml",
        TINY.replace("steps = 6000", "steps = 100_000_000"),
    );
    let mut child = place
        .command("train long.toml --out run")
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap());
    // Its first line comes after the handler is in place.
    let mut first = String::new();
    lines.read_line(&mut first).unwrap();
    assert!(first.contains("run in run"), "{first}");
    let interrupted = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(interrupted.unwrap().success());
    let mut rest = String::new();
    lines.read_to_string(&mut rest).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{rest}");
    assert!(rest.contains("gaitshift train --resume run"), "{rest}");
    place.stdout("train --resume run --steps 1");
}

#[test]
fn a_bad_configuration_is_refused_before_anything_is_written() {
    let place = Place::new();
    let cases = [
        ("unknown.toml", "[body]\nfoot_mas_kg = 1.0\n", "foot_mas_kg"),
        ("table.toml", "[bodies]\nfoot_mass_kg = 1.0\n", "bodies"),
        ("typed.toml", "[learner]\ngamma = \"high\"\n", "gamma"),
        ("mass.toml", "[body]\nfoot_mass_kg = -1.0\n", "foot_mass_kg"),
        ("step.toml", "[body]\ntime_step_s = 0.0\n", "time_step_s"),
        (
            "period.toml",
            "[task]\ncontrol_period_s = 0\n",
            "control_period_s",
        ),
        ("gamma.toml", "[learner]\ngamma = 1.5\n", "gamma"),
        (
            "count.toml",
            "[training]\nenvironments = 0\n",
            "environments",
        ),
        ("base.toml", "base = \"slow\"\n", "slow"),
        ("broken.toml", "[body\n", "line 1"),
        (
            "phase.toml",
            "[curriculum]\nphases = []\n",
            "curriculum.phases",
        ),
    ];
    for (name, content, key) in cases {
        place.write(name, content);
        place.refused(&format!("train {name}"), &[name, key]);
    }
    place.refused("train slow", &["slow", "fast", "paper", "journal"]);
    place.refused("train absent.toml", &["absent.toml"]);
    assert!(!place.path("runs").exists());
}

#[test]
fn what_cannot_be_resumed_is_refused() {
    let place = place_with_recipe();
    place.refused("train --resume absent", &["absent", "config.toml"]);
    place.stdout("train tiny.toml --out run --steps 2000");
    place.write("run/checkpoint/agent.safetensors", "damaged");
    place.refused("train --resume run", &["agent.safetensors"]);
    std::fs::remove_dir_all(place.path("run/checkpoint")).unwrap();
    place.refused("train --resume run", &["checkpoint"]);
}
