//! Contract: what a controller file says of its origin is true and holds on every machine; a file is checked against
//! its own length before memory is set aside for what it promises.

mod common;
use common::{Until, unevaluated};
use gaitshift_experiment::{Controller, Experiment, RECIPES, Training, portable_command};
use std::ffi::OsString;
use std::path::Path;

#[test]
fn what_comes_with_the_program_is_what_training_or_hardening_wrote() {
    // What went wrong: the shipped controller was a mean of three that a hand had chosen, and its file did not say so.
    let commands = [
        ("shipped", "fast", 1, "gaitshift train fast --threads 1"),
        (
            "robust",
            "robust",
            1,
            "python experiments/hardening/map_command.py --controller controllers/robust/shaped-when-fast.safetensors \
             --out robust.safetensors --points 0.3:0,0.31:0.9,2.5:1.3,2.51:2.2,3.5:2.3",
        ),
    ];
    assert!(Controller::names().eq(commands.map(|(name, ..)| name)));
    for (name, recipe, seed, command) in commands {
        let provenance = Controller::read(Path::new(name)).unwrap().provenance;
        assert_eq!(
            (provenance.experiment.as_str(), provenance.seed),
            (recipe, seed)
        );
        assert_eq!(provenance.command, command);
        assert!(provenance.edits.is_empty());
        // What went wrong: the recipe was changed and kept its name, so the file named one that had not made it.
        if let Some(digest) = provenance.experiment_digest {
            let now = Experiment::recipe(recipe).unwrap().digest().unwrap();
            assert_eq!(
                digest, now,
                "{name} is not what the recipe {recipe} makes now"
            );
        }
    }
}

#[test]
fn experiments_of_one_name_are_told_apart() {
    let fast = Experiment::recipe("fast").unwrap();
    let digest = |e: &Experiment| e.digest().unwrap();
    let of = |values: &[&str]| {
        let values: Vec<String> = values.iter().map(|&v| v.to_owned()).collect();
        digest(&fast.with_values(&values).unwrap())
    };
    // What makes no other experiment: its name, the seed, threads, and how its file is written.
    let same = of(&["name=x", "seed=7", "learner.threads=2"]);
    assert_eq!(same, digest(&fast));
    let read_again = Experiment::parse(&fast.to_toml().unwrap(), "config.toml").unwrap();
    assert_eq!(digest(&read_again), digest(&fast));
    // One value anywhere does.
    let others = [
        "body.friction=0.9",
        "body.friction=0",
        "learner.gamma=0.98",
        "learner.critic_hidden=[64]",
        "learner.critic_layer_norm=false",
        "curriculum.phases.II.steps=5000000",
        "training.symmetry=none",
        "criteria.omega_v=[0, 3]",
    ];
    let mut digests: Vec<String> = others.iter().map(|&value| of(&[value])).collect();
    digests.extend(RECIPES.map(|(name, _)| digest(&Experiment::recipe(name).unwrap())));
    digests.sort();
    digests.dedup();
    assert_eq!(digests.len(), others.len() + RECIPES.len());
    assert!(digests.iter().all(|d| d.len() == 8));
}

#[test]
fn training_writes_the_digest_and_files_without_one_are_read() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("run");
    let experiment = unevaluated();
    let digest = experiment.digest().unwrap();
    Training::new(experiment, &folder, "gaitshift train tiny.toml")
        .unwrap()
        .run(&mut Until::step(600))
        .unwrap();
    let mut controller = Controller::read(&folder).unwrap();
    assert_eq!(controller.provenance.experiment_digest, Some(digest));
    // Version 1 of the format, before there was one: the key is absent.
    controller.provenance.experiment_digest = None;
    let bytes = controller.to_bytes().unwrap();
    assert!(!String::from_utf8_lossy(&bytes).contains("experiment_digest"));
    let read = Controller::from_bytes(&bytes, Path::new("c")).unwrap();
    assert_eq!(read.provenance, controller.provenance);
}

#[test]
fn what_comes_with_the_program_is_read_by_name() {
    let names: Vec<&str> = Controller::names().collect();
    assert_eq!(names, ["shipped", "robust"]);
    let of = |name: &str| Controller::read(Path::new(name)).unwrap();
    assert_eq!(
        of("shipped").provenance,
        Controller::shipped().unwrap().provenance
    );
    assert_eq!(of("robust").provenance.experiment, "robust");
    assert!(Controller::read(Path::new("./robust")).is_err());
}

#[test]
fn controllers_of_earlier_versions_are_read_unless_their_reward_or_network_is_another() {
    // This one has keys that are no more, none of which changes its reward.
    let bytes = include_bytes!("old-controller.safetensors").to_vec();
    let path = Path::new("old.safetensors");
    let altered = |from: &str, to: &str| {
        let place = bytes.windows(from.len()).position(|w| w == from.as_bytes());
        let place = place.unwrap_or_else(|| panic!("no {from}"));
        let mut bytes = bytes.clone();
        bytes[place..place + to.len()].copy_from_slice(to.as_bytes());
        Controller::from_bytes(&bytes, path)
    };
    altered(r#"scale\":1.0"#, r#"scale\":3.0"#).unwrap();
    for (key, from, to) in [
        (
            "omega_e_floor",
            r#"omega_e_floor\":0.0"#,
            r#"omega_e_floor\":2.0"#,
        ),
        (
            "speed_limit_m_per_s",
            r#"speed_limit_m_per_s\":0.00"#,
            r#"speed_limit_m_per_s\":2.65"#,
        ),
        (
            "layer normalisation",
            r#"layer_norm\":false"#,
            r#"layer_norm\":true "#,
        ),
    ] {
        let error = altered(from, to).unwrap_err().to_string();
        let words = ["old.safetensors", key, "version"];
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    }
}

#[test]
fn a_command_line_loses_the_places_of_the_machine_it_was_given_on() {
    // What went wrong: a controller kept the command line with absolute paths of the machine that trained it.
    let line = |words: &[&str]| portable_command(words.iter().map(OsString::from));
    assert_eq!(
        line(&[
            "train",
            "/home/ann/my bipeds/fast walk.toml",
            "--out=/data/runs/a",
            "--seed",
            "3"
        ]),
        "gaitshift train 'fast walk.toml' --out=a --seed 3"
    );
    assert_eq!(
        line(&["train", "fast", "--out", "runs/a"]),
        "gaitshift train fast --out runs/a"
    );
    assert_eq!(line(&["train", "/"]), "gaitshift train /");
    let key = "training.warm_start.controller";
    assert_eq!(
        line(&["train", "--set", &format!("{key}=/home/ann/x.safetensors")]),
        format!("gaitshift train --set {key}=x.safetensors")
    );
    assert_eq!(
        line(&["train", &format!("--set={key}=/home/ann/x.safetensors")]),
        format!("gaitshift train --set={key}=x.safetensors")
    );
    assert_eq!(
        line(&["train", "it's", ""]),
        r"gaitshift train 'it'\''s' ''"
    );

    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("run");
    let command = line(&["train", "tiny.toml", "--out", folder.to_str().unwrap()]);
    Training::new(unevaluated(), &folder, &command)
        .unwrap()
        .run(&mut Until::step(600))
        .unwrap();
    for name in [
        "controller-last.safetensors",
        "checkpoint/state.json",
        "config.toml",
    ] {
        let bytes = std::fs::read(folder.join(name)).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        assert!(!text.contains(root.path().to_str().unwrap()), "{name}");
    }
}

// Of observations in another order only the scale might have told.
#[test]
fn a_policy_of_other_observations_is_refused() {
    let path = Path::new("other.safetensors");
    let with = |names: &str| {
        let from = r#"\"x_velocity_m_per_s\",\"theta_rad\","#;
        let bytes = with_metadata(from, names);
        Controller::from_bytes(&bytes, path)
            .unwrap_err()
            .to_string()
    };
    let swapped = with(r#"\"theta_rad\",\"x_velocity_m_per_s\","#);
    let words = [
        "other.safetensors",
        "`theta_rad`",
        "`x_velocity_m_per_s`",
        "version",
    ];
    assert!(words.iter().all(|word| swapped.contains(word)), "{swapped}");
    let fewer = with(r#"\"theta_rad\","#);
    assert!(fewer.contains("13 observations instead of 14"), "{fewer}");
}

/// The bytes of the shipped controller with another list of layers in its metadata.
fn with_layers(hidden: &str) -> Vec<u8> {
    let from = r#"\"hidden\":[200,200]"#;
    with_metadata(from, &format!(r#"\"hidden\":{hidden}"#))
}

/// The bytes of the shipped controller with something else in its metadata.
fn with_metadata(from: &str, to: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("controllers");
    let bytes = std::fs::read(folder.join("biped.safetensors")).unwrap();
    let length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
    let header = String::from_utf8(bytes[8..8 + length].to_vec()).unwrap();
    assert!(header.contains(from));
    let header = header.replacen(from, to, 1);
    let header = format!(
        "{header}{}",
        " ".repeat(header.len().next_multiple_of(8) - header.len())
    );
    [
        &(header.len() as u64).to_le_bytes()[..],
        header.as_bytes(),
        &bytes[8 + length..],
    ]
    .concat()
}

#[test]
fn a_small_file_cannot_ask_for_gigabytes() {
    // What went wrong: two layers of 65,536 units named in a file of a few bytes made 17 GB be set aside before anybody
    // saw that the file holds no such layers.
    assert!(Controller::from_bytes(&with_layers("[200,200]"), Path::new("c")).is_ok());
    let allowed = memory_kb();
    for hidden in [
        "[65536,65536]",
        "[65536,65536,65536,65536]",
        "[18446744073709551615,2]",
    ] {
        let error = Controller::from_bytes(&with_layers(hidden), Path::new("small.safetensors"))
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("small.safetensors") && error.contains("layers"),
            "{error}"
        );
    }
    let used = memory_kb() - allowed;
    assert!(used < 100_000, "{used} kB");
}

/// The most memory this process has used so far, in kB; 0 where the system does not say.
fn memory_kb() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmPeak:"));
    peak.and_then(|p| p.trim().strip_suffix(" kB")?.parse().ok())
        .unwrap_or(0)
}
