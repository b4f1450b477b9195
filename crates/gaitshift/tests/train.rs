//! `gaitshift train` end to end on a tiny recipe: what a run leaves behind, that stopping and resuming
//! changes nothing, that Ctrl-C loses nothing, and bad input.

use crate::common::{Place, TINY};

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

/// The run was trained to its end, and then the report could not be printed.
#[cfg(target_os = "linux")]
#[test]
fn a_folder_whose_name_is_no_text_is_reported() {
    use std::os::unix::ffi::OsStrExt;
    let place = place_with_recipe();
    let mut command = place.command("train tiny.toml --steps 1000 --json --out");
    let output = command
        .arg(std::ffi::OsStr::from_bytes(b"run-\xff"))
        .output()
        .unwrap();
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{report}");
    assert_eq!(report["folder"], "run-\u{fffd}");
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
    // It went on for a little and wrote another checkpoint.
    let episodes = place.read("parts/episodes.csv");
    let output = place.output("train --resume parts --steps 1000");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(
        stderr.contains("nothing to do: the run is at step 2,"),
        "{stderr}"
    );
    assert!(!stderr.contains("stopped"), "{stderr}");
    assert_eq!(place.read("parts/episodes.csv"), episodes);
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
        evaluation.contains("/39") && evaluation.contains(" f0."),
        "{stderr}"
    );
    // The columns are explained, and no line is wider than a terminal.
    for word in ["score", "w walks", "f fell", "Froude"] {
        assert!(stderr.contains(word), "no {word} in {stderr}");
    }
    for line in stderr.lines() {
        assert!(line.chars().count() <= 80, "{line}");
    }
    assert!(!stderr.contains('\u{1b}'), "{stderr}");
    // Many commands go on in another line.
    let many = "[0, 0.25, 0.5, 0.75, 1, 1.25, 1.5, 1.75, 2, 2.25, 2.5, 2.75, 3, 3.25, 3.5]";
    let set = format!("criteria.omega_v={many}").replace(' ', "");
    let output = place_with_recipe().output(&format!("train tiny.toml --out run --set {set}"));
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(
        stderr.contains("1.75\n") && stderr.contains("\n                             2     2.25"),
        "{stderr}"
    );
    for line in stderr.lines() {
        assert!(line.chars().count() <= 80, "{line}");
    }
    let stdout = String::from_utf8_lossy(&output.stdout);
    assert!(stdout.contains("6,000 steps and"), "{stdout}");
}

/// Begins the command, sends it a signal once it trains, and gives its exit code and what it then said.
#[cfg(unix)]
fn signalled(command: &mut std::process::Command, signal: &str) -> (Option<i32>, String) {
    use std::io::{BufRead, BufReader, Read};
    use std::process::{Command, Stdio};
    let mut child = command
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap());
    // Its first line comes after the handler is in place.
    let mut first = String::new();
    lines.read_line(&mut first).unwrap();
    assert!(first.contains("training in"), "{first}");
    let sent = Command::new("kill")
        .args([&format!("-{signal}"), &child.id().to_string()])
        .status();
    assert!(sent.unwrap().success());
    let mut rest = String::new();
    lines.read_to_string(&mut rest).unwrap();
    (child.wait().unwrap().code(), rest)
}

#[cfg(unix)]
#[test]
fn an_interrupt_writes_a_checkpoint_to_go_on_from() {
    let place = place_with_recipe();
    place.write(
        "long.toml",
        TINY.replace("steps = 6000", "steps = 100_000_000"),
    );
    // Ctrl-C, and what batch systems send before a job's time is over.
    for signal in ["INT", "TERM", "USR1"] {
        let run = format!("run-{signal}");
        let mut command = place.command(&format!("train long.toml --out {run}"));
        let (code, rest) = signalled(&mut command, signal);
        assert_eq!(code, Some(130), "{rest}");
        assert!(
            rest.contains(&format!("gaitshift train --resume {run}")),
            "{rest}"
        );
        place.stdout(&format!("train --resume {run} --steps 1"));
    }
}

// Under nohup it stopped when its terminal was closed.
#[cfg(target_os = "linux")]
#[test]
fn a_hangup_that_is_ignored_stays_ignored() {
    let place = place_with_recipe();
    place.write("some.toml", TINY.replace("steps = 6000", "steps = 30_000"));
    let program = assert_cmd::cargo::cargo_bin!("gaitshift").display();
    let script = format!("trap '' HUP; exec '{program}' train some.toml --out run");
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", &script]).current_dir(place.path("."));
    let (code, rest) = signalled(&mut shell, "HUP");
    assert_eq!(code, Some(0), "{rest}");
}

// The scratch folder of the measurement was left behind.
#[cfg(unix)]
#[test]
fn an_interrupted_measurement_leaves_nothing() {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};
    let place = place_with_recipe();
    place.write(
        "sweep.toml",
        "name = \"s\"\nexperiment = \"fast\"\nseeds = [1]\n[[variants]]\nname = \"a\"\n",
    );
    let scratch = place.path("scratch");
    std::fs::create_dir(&scratch).unwrap();
    let entries = || std::fs::read_dir(&scratch).unwrap().count();
    for command in ["train fast --check", "sweep sweep.toml --dry-run"] {
        let mut child = place
            .command(command)
            .env("TMPDIR", &scratch)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let begun = Instant::now();
        while entries() == 0 {
            assert!(begun.elapsed() < Duration::from_secs(60), "{command}");
            std::thread::sleep(Duration::from_millis(5));
        }
        let interrupted = Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .status();
        assert!(interrupted.unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(130), "{command}");
        assert_eq!(entries(), 0, "{command}");
    }
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

// A controller that lay there was taken for the run's best, and a walk for the one to rehearse.
#[test]
fn a_folder_with_controllers_of_others_is_refused() {
    let place = place_with_recipe();
    for name in [
        "controller.safetensors",
        "controller-walk.safetensors",
        "report.json",
        // These were replaced, and what else lay in the folders was lost.
        "controller-last.safetensors",
        "lock",
        "checkpoint/weights.pt",
        "checkpoint.new/weights.pt",
        "checkpoint.old/weights.pt",
    ] {
        let file = format!("there/{name}");
        std::fs::create_dir_all(place.path(&file).parent().unwrap()).unwrap();
        place.write(&file, "precious");
        let first = name.split('/').next().unwrap();
        place.refused("train tiny.toml --out there", &["there", first, "--out"]);
        assert_eq!(place.read(&file), b"precious");
        std::fs::remove_dir_all(place.path("there")).unwrap();
    }
    // A run whose configuration was moved away.
    place.stdout("train tiny.toml --out run --steps 2000");
    std::fs::create_dir_all(place.path("moved")).unwrap();
    std::fs::rename(place.path("run/checkpoint"), place.path("moved/checkpoint")).unwrap();
    place.refused("train tiny.toml --out moved", &["checkpoint", "--out"]);
}

// "already holds checkpoint" was said of a file.
#[test]
fn a_file_is_no_folder_for_a_run() {
    let place = place_with_recipe();
    place.write("file", "precious");
    place.refused(
        "train tiny.toml --out file",
        &["file: a file is where a folder is to be", "--out"],
    );
    place.refused("train tiny.toml --out file/run", &["file/run"]);
    assert_eq!(place.read("file"), b"precious");
}

// The option won, or no run had the seed that was set.
#[test]
fn a_seed_is_given_once() {
    let place = place_with_recipe();
    for options in ["--seed 4", "--seeds 1-2"] {
        place.refused(
            &format!("train tiny.toml --check --set seed=5 {options}"),
            &["--set seed", "give one of them"],
        );
    }
}

// It was a note, and the exit code 0.
#[test]
fn a_start_that_cannot_be_is_an_error_of_the_check_too() {
    let place = place_with_recipe();
    let start = |controller: &str| {
        format!("train tiny.toml --set training.warm_start.controller={controller}")
    };
    for check in ["", " --check"] {
        place.refused(
            &format!("{}{check}", start("none.safetensors")),
            &["none.safetensors"],
        );
        place.refused(
            &format!("{}{check}", start("shipped")),
            &["learner.actor_hidden"],
        );
    }
}

// The base has been read by then: it was ignored, and written into `config.toml`.
#[test]
fn a_base_is_not_set() {
    let place = place_with_recipe();
    place.refused(
        "train tiny.toml --set base=fast",
        &["base", "as the experiment"],
    );
}

// It said only that learning diverges.
#[test]
fn a_check_reports_where_the_pace_cannot_be_measured() {
    let place = place_with_recipe();
    let text = place.stdout("train --check tiny.toml --set learner.learning_rate=1e10");
    assert!(
        text.contains("probably") && text.contains("unknown time"),
        "{text}"
    );
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

#[test]
fn several_seeds_are_trained_one_after_the_other() {
    let place = place_with_recipe();
    let text = place.stdout("train tiny.toml --seeds 1-2,4 --steps 3000");
    for seed in [1, 2, 4] {
        let folder = format!("runs/tiny-run-{seed}");
        assert!(
            place
                .path(&folder)
                .join("controller-last.safetensors")
                .exists()
        );
        assert!(text.contains(&folder), "{text}");
    }
    assert!(text.contains("mean"), "{text}");
    place.stdout("train tiny.toml --seed 2 --out alone --steps 3000");
    assert_eq!(
        place.read("alone/episodes.csv"),
        place.read("runs/tiny-run-2/episodes.csv")
    );
    // Before anything is trained, every folder has to be free.
    place.refused(
        "train tiny.toml --seeds 3-4",
        &["runs/tiny-run-4", "--seeds"],
    );
    assert!(!place.path("runs/tiny-run-3").exists());
    // The third run was refused after two had been trained.
    place.refused("train tiny.toml --seeds 5-6,5", &["seed 5", "twice"]);
    // Its configuration could not be read again.
    place.refused(
        "train tiny.toml --seed 9223372036854775808",
        &["seed", "at most 9223372036854775807"],
    );
    let reports = place.json("train tiny.toml --seeds 7-8 --steps 3000 --out o --json");
    assert_eq!(reports["runs"].as_array().unwrap().len(), 2);
    place.refused("train tiny.toml --seeds 5-1", &["--seeds"]);
    place.refused("train tiny.toml --seeds 1-2 --seed 3", &["--seed"]);
    // The table had them, the JSON had not.
    let spread = &reports["spread"];
    let elapsed = reports["runs"].as_array().unwrap().iter();
    let total: f64 = elapsed.map(|run| run["elapsed_s"].as_f64().unwrap()).sum();
    let mean = spread["elapsed_s"]["mean"].as_f64().unwrap();
    assert!((mean - 0.5 * total).abs() < 1e-9, "{spread}");
    assert!(spread["best_met"].get("sd").is_some(), "{spread}");
    assert!(spread["best_step"].get("mean").is_some(), "{spread}");
}

// Of a phase's randomization it listed three dozen factors of 1.
#[test]
fn a_check_says_of_a_randomization_what_it_changes() {
    let place = Place::new();
    place.write(
        "hills.toml",
        "base = \"fast\"\n[[task.reward.extra]]\nname = \"upright\"\nweight = 0.2\nexpression = \"-theta_rad^2\"\n\
         [[curriculum.phases]]\nname = \"hills\"\nsteps = 300_000\nomega_v = [-0.2, 3.5]\n\
         reward_extra_end = { upright = 1 }\nrandomization = { latency_s = [0, 0.01], body = { friction = [0.5, 1.2] }, \
         pushes = { forward_n = [-80, 80] }, terrain = { slope_rad = [-0.05, 0.05], steps = { height_m = [0, 0.02] } } }\n",
    );
    let value = place.json("train --check hills.toml --json");
    let changes = &value["phases"][0]["changes"];
    assert_eq!(
        changes.to_string(),
        "[\"randomization: body.friction [0.5,1.2], latency_s [0.0,0.01], pushes.forward_n [-80.0,80.0], \
         terrain.slope_rad [-0.05,0.05], terrain.steps.height_m [0.0,0.02]\",\"reward_extra_end: upright 1.0\"]"
    );
    // It was one line of some 400 characters.
    for line in place.stdout("train --check robust").lines() {
        assert!(line.chars().count() <= 80, "{line}");
    }
    let differences = value["differences"].to_string();
    assert!(
        differences.contains("task.reward.extra[0].expression"),
        "{differences}"
    );
}

#[test]
fn a_check_says_what_would_be_trained_and_trains_nothing() {
    let place = place_with_recipe();
    let text = place.stdout("train --check tiny.toml");
    for word in [
        "6,000 steps",
        "steps/s",
        "only",
        "fast",
        "`learner.batch_size` from 256 to 32",
        "Warnings",
    ] {
        assert!(text.contains(word), "no {word} in {text}");
    }
    let reward = text
        .lines()
        .skip_while(|l| !l.starts_with("Reward of the last"));
    let reward: Vec<&str> = reward.take(14).collect();
    for name in ["energy", "velocity", "alive", "sum"] {
        let row = |l: &&str| l.trim_start().starts_with(name);
        assert!(reward.iter().any(row), "no {name} in {reward:#?}");
    }
    let value = place.json("train --check tiny.toml --set body.friction=0.5 --json");
    assert_eq!(value["steps"], 6000);
    let motion = &value["reward"][0];
    let terms = motion["terms"].as_object().unwrap().values();
    let sum: f64 = terms.map(|term| term.as_f64().unwrap()).sum();
    assert!(
        (motion["sum"].as_f64().unwrap() - sum).abs() < 1e-9,
        "{motion}"
    );
    assert!(value["steps_per_s"].as_f64().unwrap() > 0.0, "{value}");
    let phase = &value["phases"][0];
    assert_eq!(
        (&phase["to_step"], &phase["from_s"]),
        (&6000.into(), &0.0.into())
    );
    let expected_s = 6000.0 / value["steps_per_s"].as_f64().unwrap();
    assert!(
        (phase["to_s"].as_f64().unwrap() - expected_s).abs() < 1e-6,
        "{phase}"
    );
    let warnings = value["warnings"].to_string();
    assert!(warnings.contains("metrics_interval_steps"), "{value}");
    assert!(text.contains("Judged by 39 criteria: 8 commands"), "{text}");
    let asked = value["criteria"].as_str().unwrap();
    assert!(asked.starts_with("39 criteria"), "{value}");
    let differences = value["differences"].to_string();
    assert!(differences.contains("body.friction"), "{differences}");
    let text = place.stdout("train --check tiny.toml --seeds 1-3");
    assert!(
        text.contains("3 seeds from 1 to 3") && text.contains("for all 3"),
        "{text}"
    );
    let value = place.json("train --check tiny.toml --seeds 4,6 --json");
    assert_eq!(value["seeds"].to_string(), "[4,6]");
    assert!(!place.path("runs").exists());
    place.refused("train --check absent.toml", &["absent.toml"]);
}

// It went to runs/fast-1.
#[test]
fn a_file_without_a_name_is_named_as_the_file_is() {
    let place = place_with_recipe();
    let tiny = String::from_utf8(place.read("tiny.toml")).unwrap();
    let nameless: Vec<&str> = tiny
        .lines()
        .filter(|l| !l.starts_with("name = \"tiny"))
        .collect();
    place.write("mine.toml", nameless.join("\n"));
    place.stdout("train mine.toml --steps 1");
    assert!(place.path("runs/mine-5/config.toml").is_file());
}

#[test]
fn single_values_are_set_without_a_file() {
    let place = place_with_recipe();
    place.stdout(
        "train tiny.toml --set body.friction=0.5 --set training.environments=8 --out run --steps 1",
    );
    let config = String::from_utf8(place.read("run/config.toml")).unwrap();
    assert!(
        config.contains("friction = 0.5") && config.contains("environments = 8"),
        "{config}"
    );
    place.refused(
        "train tiny.toml --set body.frction=0.5",
        &["did you mean `friction`?"],
    );
}

// `metrics.csv` of a run shorter than its interval was empty, without a header.
#[test]
fn the_log_of_a_short_run_has_its_header() {
    let place = place_with_recipe();
    place.stdout("train tiny.toml --out run --steps 2000");
    let header = String::from_utf8(place.read("run/metrics.csv")).unwrap();
    assert!(header.starts_with("train/step,train/updates,"), "{header}");
    assert!(header.trim_end().ends_with("reward/symmetry"), "{header}");
    assert_eq!(header.lines().count(), 1);
    place.stdout("train --resume run");
    assert_eq!(place.read("run/metrics.csv"), header.as_bytes());
}

// The networks of a checkpoint were readable by their owner only, while all else was not.
#[cfg(unix)]
#[test]
fn every_file_of_a_run_has_the_same_permissions() {
    use std::os::unix::fs::PermissionsExt;
    let place = place_with_recipe();
    place.stdout("train tiny.toml --out run --steps 2000");
    let mode = |name: &str| {
        std::fs::metadata(place.path(name))
            .unwrap()
            .permissions()
            .mode()
    };
    let usual = mode("run/config.toml");
    for name in ["agent.safetensors", "replay.safetensors", "state.json"] {
        assert_eq!(mode(&format!("run/checkpoint/{name}")), usual, "{name}");
    }
    let files = std::fs::read_dir(place.path("run/checkpoint")).unwrap();
    assert!(
        files
            .flatten()
            .all(|file| !file.file_name().to_string_lossy().ends_with(".new"))
    );
}

// A command that was told to be typed did not work where a folder has a space in its name.
#[test]
fn hints_quote_paths() {
    let place = place_with_recipe();
    let mut command = place.command("train tiny.toml --steps 2000 --out");
    let output = command.arg("my run").output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(
        stderr.contains("gaitshift train --resume 'my run'"),
        "{stderr}"
    );
    let stdout = String::from_utf8_lossy(&output.stdout);
    assert!(
        stdout.contains("--controller 'my run/controller-last.safetensors'"),
        "{stdout}"
    );
}
