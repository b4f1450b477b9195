//! Contract: whatever a file holds, its reader gives a value or an error: no reader panics, hangs, or sets aside more than
//! 1 GB. What a reader accepts can be used.
//!
//! Files are damaged at random: valid ones, changed at up to four places, the header's length of a safetensors file put
//! right again or not. `BOLERO_RANDOM_ITERATIONS` says how many inputs each test tries instead of its own, small number;
//! docs/verification.md has the result of a long run. Valid files that a person writes are in `corpus/`, those that the
//! program writes are made anew, so that they follow the formats. An input that failed is a named test of its reader
//! that begins with what went wrong: here, in run_folder.rs and in the tests of the other crates.

mod common;
use bolero::TypeGenerator;
use cap::Cap;
use common::{EVALUATION, Until, tiny};
use gaitshift_analysis::Recording;
use gaitshift_body::Body;
use gaitshift_experiment::{
    CommandProfile, Control, Controller, Criteria, Deterministic, Evaluation, Experiment, Rollout,
    Sweep, Training, load_body_overrides, load_disturbance,
};
use gaitshift_sac::{Agent, ReplayBuffer};
use gaitshift_task::{AutoReset, Environment, Opening, VectorEnvironment, VectorState};
use std::alloc::System;
use std::fs;
use std::panic::AssertUnwindSafe;
use std::path::Path;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Memory that all tests of this file have together; more ends the process.
#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, 1 << 30);

/// What happens to a valid file.
#[derive(Debug, Clone, TypeGenerator)]
enum Damage {
    Set {
        at: u32,
        byte: u8,
    },
    Insert {
        at: u32,
        byte: u8,
    },
    Remove {
        at: u32,
        length: u8,
    },
    Repeat {
        at: u32,
        length: u8,
        times: u8,
    },
    CutAfter {
        at: u32,
    },
    /// Another number in place of one, or of a word.
    Number {
        index: u32,
        other: u8,
    },
    /// One number or word in place of another.
    Swap {
        index: u32,
        other: u32,
    },
}

#[derive(Debug, Clone, TypeGenerator)]
struct Input {
    seed: u8,
    first: Damage,
    more: [Option<Damage>; 3],
    repair: bool,
}

const OTHERS: [&str; 24] = [
    "0",
    "-1",
    "1",
    "2",
    "1e308",
    "-1e308",
    "1e-320",
    "18446744073709551615",
    "18446744073709551616",
    "9223372036854775807",
    "4294967295",
    "4294967296",
    "65536",
    "65537",
    "1000000000",
    "nan",
    "inf",
    "null",
    "\"x\"",
    "[]",
    "{}",
    "0.5",
    "",
    "true",
];

/// Where numbers and words stand.
fn words(bytes: &[u8]) -> Vec<std::ops::Range<usize>> {
    let in_word = |b: u8| b.is_ascii_alphanumeric() || b"._-+".contains(&b);
    let mut words = Vec::new();
    let mut start = None;
    for (i, &byte) in bytes.iter().enumerate() {
        match (in_word(byte), start) {
            (true, None) => start = Some(i),
            (false, Some(from)) => {
                words.push(from..i);
                start = None;
            }
            _ => {}
        }
    }
    words.extend(start.map(|from| from..bytes.len()));
    words
}

fn damage(bytes: &mut Vec<u8>, damage: &Damage) {
    if bytes.is_empty() {
        return;
    }
    let place = |at: u32| at as usize % bytes.len();
    match *damage {
        Damage::Set { at, byte } => {
            let at = place(at);
            bytes[at] = byte;
        }
        Damage::Insert { at, byte } => bytes.insert(place(at), byte),
        Damage::Remove { at, length } => {
            let from = place(at);
            let to = (from + usize::from(length)).min(bytes.len());
            bytes.drain(from..to);
        }
        Damage::Repeat { at, length, times } => {
            let from = place(at);
            let to = (from + usize::from(length)).min(bytes.len());
            let part = bytes[from..to].repeat(usize::from(times));
            bytes.splice(to..to, part);
        }
        Damage::CutAfter { at } => bytes.truncate(place(at)),
        Damage::Number { index, other } => {
            let words = words(bytes);
            if let Some(word) = words.get(index as usize % words.len().max(1)) {
                let other = OTHERS[usize::from(other) % OTHERS.len()];
                bytes.splice(word.clone(), other.bytes());
            }
        }
        Damage::Swap { index, other } => {
            let words = words(bytes);
            if !words.is_empty() {
                let other = words[other as usize % words.len()].clone();
                let other = bytes[other].to_vec();
                bytes.splice(words[index as usize % words.len()].clone(), other);
            }
        }
    }
}

impl Input {
    fn apply(&self, seeds: &[Vec<u8>]) -> Vec<u8> {
        let seed = &seeds[usize::from(self.seed) % seeds.len()];
        let damages = || [&self.first].into_iter().chain(self.more.iter().flatten());
        // Of a safetensors file the header is damaged, and told its new length, or the file as a whole.
        let header = seed
            .get(..8)
            .and_then(|b| b.try_into().ok())
            .map(u64::from_le_bytes);
        match header.and_then(|length| seed.split_at_checked(8 + usize::try_from(length).ok()?)) {
            Some((start, data)) if self.repair => {
                let mut header = start[8..].to_vec();
                damages().for_each(|d| damage(&mut header, d));
                [&(header.len() as u64).to_le_bytes()[..], &header, data].concat()
            }
            _ => {
                let mut bytes = seed.clone();
                damages().for_each(|d| damage(&mut bytes, d));
                bytes
            }
        }
    }
}

/// Tries damaged seeds on a reader, which says whether it accepted what it was given.
fn try_damaged(inputs: usize, seeds: Vec<Vec<u8>>, reader: impl Fn(&[u8]) -> bool) {
    // As they are, they must be read: a test that only ever sees errors at the first byte shows nothing.
    for seed in &seeds {
        assert!(reader(seed), "{}", String::from_utf8_lossy(seed));
    }
    let reader = AssertUnwindSafe(reader);
    bolero::check!()
        .with_type::<Input>()
        .with_iterations(inputs)
        .with_test_time(Duration::MAX)
        .for_each(|input: &Input| {
            let bytes = input.apply(&seeds);
            let start = Instant::now();
            reader(&bytes);
            let took = start.elapsed();
            assert!(took < Duration::from_secs(20), "{took:?}");
        });
}

/// The files of a folder of `corpus/`.
fn corpus(folder: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/corpus")
        .join(folder);
    let entries = fs::read_dir(&folder).unwrap();
    let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    assert!(!paths.is_empty(), "{}", folder.display());
    paths.iter().map(|path| fs::read(path).unwrap()).collect()
}

/// A finished run of a second with small networks, for its files.
fn run() -> &'static Path {
    static RUN: OnceLock<tempfile::TempDir> = OnceLock::new();
    let folder = RUN.get_or_init(|| {
        let root = tempfile::tempdir().unwrap();
        let mut experiment = tiny();
        experiment.learner.actor_hidden = vec![4];
        experiment.learner.critic_hidden = vec![4];
        experiment.learner.batch_size = 32;
        experiment.training.environments = 2;
        experiment.training.replay_capacity = 1000;
        experiment.training.learning_starts = 100;
        experiment.training.evaluation_interval_steps = 1_000_000;
        experiment.curriculum.phases[0].steps = 500;
        experiment.curriculum.phases[1].steps = 500;
        experiment.curriculum.phases[2].steps = 1_000_000;
        let folder = root.path().join("run");
        Training::new(experiment, &folder, "test")
            .unwrap()
            .run(&mut Until::step(2000))
            .unwrap();
        root
    });
    // Dropped never, so that the system's temporary folder keeps it: the run is small.
    Box::leak(folder.path().join("run").into_boxed_path())
}

fn file(name: &str) -> Vec<u8> {
    fs::read(run().join(name)).unwrap()
}

#[test]
fn controllers() {
    let seeds = vec![file("controller-last.safetensors")];
    try_damaged(2000, seeds, |bytes| {
        let Ok(mut controller) = Controller::from_bytes(bytes, Path::new("c")) else {
            return false;
        };
        let mut action = [0.0; 2];
        Deterministic(&mut controller.policy).act(&[0.1; 14], &mut action);
        let body = Body::new(controller.body).unwrap();
        // Of bodies beyond all measure the recording refuses a row, with an error.
        let _ = Rollout {
            body: &body,
            task: &controller.task,
            start: Environment::default_start(&body, &controller.task),
            profile: &CommandProfile::constant(0.0),
            duration_s: 2.0 * controller.task.control_period_s,
            seed: 0,
            disturbance: None,
            controller: "c",
        }
        .record(&mut Deterministic(&mut controller.policy));
        true
    });
}

/// Also what `gaitshift.SAC.load` of the Python package reads.
#[test]
fn agents() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("agent.safetensors");
    let replay = ReplayBuffer::load(&run().join("checkpoint/replay.safetensors")).unwrap();
    try_damaged(1000, vec![file("checkpoint/agent.safetensors")], |bytes| {
        fs::write(&path, bytes).unwrap();
        let Ok(mut agent) = Agent::load(&path) else {
            return false;
        };
        let (mut actions, mut log_probs) = ([0.0; 4], [0.0; 2]);
        let _ = agent.act(&[0.1; 28], &mut actions, &mut log_probs);
        let _ = agent.update(&replay);
        true
    });
}

#[test]
fn replay_buffers() {
    let agent = run().join("checkpoint/agent.safetensors");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("replay.safetensors");
    try_damaged(1000, vec![file("checkpoint/replay.safetensors")], |bytes| {
        fs::write(&path, bytes).unwrap();
        let Ok(replay) = ReplayBuffer::load(&path) else {
            return false;
        };
        assert!(replay.len() <= replay.capacity());
        // An agent that learns from it ends in an error at worst.
        let _ = Agent::load(&agent).unwrap().update(&replay);
        true
    });
}

#[test]
fn recordings() {
    let mut controller = Controller::shipped().unwrap();
    let body = Body::new(controller.body.clone()).unwrap();
    let recording = Rollout {
        body: &body,
        task: &controller.task,
        start: Environment::default_start(&body, &controller.task),
        profile: &CommandProfile::ramp(0.0, 3.0, 0.01, 0.02),
        duration_s: 0.05,
        seed: 0,
        disturbance: None,
        controller: "c",
    }
    .record(&mut Deterministic(&mut controller.policy))
    .unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("motion.csv");
    let seeds = vec![recording.to_csv().unwrap().into_bytes()];
    try_damaged(2000, seeds, |bytes| {
        fs::write(&path, bytes).unwrap();
        let Ok(recording) = Recording::read_csv(&path) else {
            return false;
        };
        let options = gaitshift_analysis::AnalysisOptions::default();
        gaitshift_analysis::summarise(&recording, &options);
        true
    });
}

#[test]
fn command_profiles() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("profile.csv");
    try_damaged(2000, corpus("profile"), |bytes| {
        fs::write(&path, bytes).unwrap();
        let Ok(profile) = CommandProfile::read_csv(&path) else {
            return false;
        };
        let (low, high) = profile.range();
        assert!(low <= high && profile.end_s().is_finite());
        profile.at(0.3);
        profile.change_s();
        true
    });
}

#[test]
fn experiments() {
    let mut seeds: Vec<Vec<u8>> = vec![tiny().to_toml().unwrap().into_bytes()];
    seeds.push(common::TINY.as_bytes().to_vec());
    for name in ["fast", "paper"] {
        seeds.push(
            Experiment::recipe(name)
                .unwrap()
                .to_toml()
                .unwrap()
                .into_bytes(),
        );
    }
    seeds.extend(corpus("experiment"));
    try_damaged(1000, seeds, |bytes| {
        let text = String::from_utf8_lossy(bytes);
        let Ok(experiment) = Experiment::parse(&text, "e.toml") else {
            return false;
        };
        let again = Experiment::parse(&experiment.to_toml().unwrap(), "e.toml").unwrap();
        assert_eq!(again, experiment);
        assert_eq!(again.digest().unwrap(), experiment.digest().unwrap());
        let total = experiment.curriculum.total_steps();
        for step in [0, total / 2, total] {
            experiment.curriculum.at(step, &experiment.task.reward);
            experiment.learner_at(step);
        }
        true
    });
}

#[test]
fn sweeps() {
    try_damaged(300, corpus("sweep"), |bytes| {
        let Ok(text) = std::str::from_utf8(bytes) else {
            return false;
        };
        let Ok(sweep) = Sweep::parse(text, "sweep.toml") else {
            return false;
        };
        assert!(!sweep.trials.is_empty());
        for trial in &sweep.trials {
            trial.experiment.validate("trial").unwrap();
        }
        true
    });
}

#[test]
fn evaluations() {
    let line = EVALUATION.replace('\n', "");
    let lines = format!("{line}\n{line}\n").into_bytes();
    let run = tempfile::tempdir().unwrap();
    try_damaged(300, vec![lines.clone()], |bytes| {
        fs::write(run.path().join("evaluations.jsonl"), bytes).unwrap();
        if bytes == lines {
            assert_eq!(Evaluation::read_all(run.path()).unwrap().len(), 2);
        }
        let Ok(evaluations) = Evaluation::read_all(run.path()) else {
            return false;
        };
        assert_eq!(
            Evaluation::best(&evaluations).is_some(),
            !evaluations.is_empty()
        );
        true
    });
}

#[test]
fn body_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("body.toml");
    let base = Experiment::recipe("paper").unwrap().body;
    let whole = toml::to_string(&base).unwrap();
    let mut seeds = corpus("body");
    seeds.push(whole.into_bytes());
    try_damaged(2000, seeds, |bytes| {
        fs::write(&path, bytes).unwrap();
        let Ok(parameters) = load_body_overrides(&path, &base) else {
            return false;
        };
        Body::new(parameters).unwrap();
        true
    });
}

#[test]
fn disturbances() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("disturbance.toml");
    let controller = Controller::shipped().unwrap();
    let body = Body::new(controller.body.clone()).unwrap();
    try_damaged(1000, corpus("disturbance"), |bytes| {
        fs::write(&path, bytes).unwrap();
        let Ok(disturbance) = load_disturbance(&path) else {
            return false;
        };
        let body = disturbance.place(body.clone());
        // What a motion cannot survive ends it; a recording may refuse its numbers.
        let _ = Rollout {
            body: &body,
            task: &controller.task,
            start: Environment::default_start(&body, &controller.task),
            profile: &CommandProfile::constant(3.0),
            duration_s: 0.05,
            seed: 1,
            disturbance: Some(&disturbance),
            controller: "c",
        }
        .record(&mut Deterministic(&mut controller.policy.clone()));
        true
    });
}

#[test]
fn criteria() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("criteria.toml");
    try_damaged(1000, corpus("criteria"), |bytes| {
        fs::write(&path, bytes).unwrap();
        let Ok(criteria) = Criteria::load(&path) else {
            return false;
        };
        let experiment = Experiment {
            criteria,
            ..Experiment::recipe("paper").unwrap()
        };
        // No phase of `paper` rehearses, which would need a walk to be asked for.
        experiment.validate("criteria").unwrap();
        !experiment.criteria.to_string().is_empty()
    });
}

/// What the Python package's environments keep when they are pickled.
#[test]
fn states_of_vector_environments() {
    let experiment = tiny();
    let body = Body::new(experiment.body.clone()).unwrap();
    let vector = VectorEnvironment::new(body, experiment.task.clone(), [-0.5, 3.5], 2);
    let randomization = experiment.curriculum.phases[1].randomization.clone();
    let drawn = vector.clone().randomized(randomization.unwrap()).unwrap();
    for vector in [vector, drawn] {
        let mut begun = vector.clone();
        for index in 0..begun.len() {
            begun.reset(index, Opening::default());
            begun.step(index, [0.3, -0.3]);
        }
        let seed = serde_json::to_vec(&begun.state()).unwrap();
        try_damaged(1000, vec![seed], |bytes| {
            let Ok(state) = serde_json::from_slice::<VectorState>(bytes) else {
                return false;
            };
            let mut vector = vector.clone();
            if !vector.restore(state) {
                return false;
            }
            for _ in 0..2 {
                vector.step_all(&[[0.5, -0.5]; 2], AutoReset::NextStep, 1);
            }
            true
        });
    }
}

/// A run resumed from a folder of which one file is damaged, and what it does next.
fn resumed(name: &str, inputs: usize) {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("run");
    let files: Vec<(String, Vec<u8>)> = [
        "config.toml",
        "metrics.csv",
        "episodes.csv",
        "checkpoint/config.toml",
        "checkpoint/agent.safetensors",
        "checkpoint/replay.safetensors",
        "checkpoint/state.json",
    ]
    .map(|name| (name.to_owned(), file(name)))
    .to_vec();
    try_damaged(inputs, vec![file(name)], |bytes| {
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(folder.join("checkpoint")).unwrap();
        for (other, content) in &files {
            fs::write(folder.join(other), content).unwrap();
        }
        fs::write(folder.join(name), bytes).unwrap();
        let Ok(mut training) = Training::resume(&folder) else {
            return false;
        };
        // `progress` is told after the first period.
        let _ = training.run(&mut Until::step(1));
        true
    });
}

#[test]
fn states() {
    resumed("checkpoint/state.json", 200);
}

/// They are cut back to the lengths that the checkpoint names.
#[test]
fn logs_of_episodes() {
    resumed("episodes.csv", 100);
}

#[test]
fn configurations_of_runs() {
    resumed("config.toml", 200);
}

#[test]
fn configurations_of_checkpoints() {
    resumed("checkpoint/config.toml", 100);
}
