//! Files that are not what they should be give one error that names the file, what is wrong and what to do; none
//! makes the program panic. (That a whole file resumes bit for bit is shown in `agent.rs`.)

use std::path::{Path, PathBuf};

use gaitshift_sac::{Agent, ReplayBuffer, SacConfig, SacError, Temperature, Transitions};
use tempfile::TempDir;

struct Files {
    folder: TempDir,
    agent: PathBuf,
    replay: PathBuf,
}

fn files() -> Files {
    let folder = tempfile::tempdir().unwrap();
    let (agent, replay) = (
        folder.path().join("agent.safetensors"),
        folder.path().join("replay.safetensors"),
    );
    let config = SacConfig {
        actor_hidden: vec![8],
        critic_hidden: vec![8],
        ..SacConfig::default()
    };
    Agent::new(config, 2, 1, None, 1)
        .unwrap()
        .save(&agent)
        .unwrap();
    let mut buffer = ReplayBuffer::new(6, 2, 2, 1).unwrap();
    for _ in 0..2 {
        buffer
            .push(Transitions {
                observations: &[0.0; 4],
                actions: &[0.0; 2],
                log_probs: &[0.0; 2],
                rewards: &[0.0; 2],
                next_observations: &[0.0; 4],
                terminated: &[false; 2],
                truncated: &[false; 2],
                valid: &[true; 2],
            })
            .unwrap();
    }
    buffer.save(&replay).unwrap();
    Files {
        folder,
        agent,
        replay,
    }
}

/// Loading fails with a message that names the file and holds `cause`.
fn refuse_agent(path: &Path, cause: &str) {
    let error = Agent::load(path).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains(path.to_str().unwrap()) && text.contains(cause),
        "{text}"
    );
}

#[test]
fn a_missing_file() {
    let files = files();
    let path = files.folder.path().join("nothing");
    refuse_agent(&path, "No such file");
    assert!(matches!(
        ReplayBuffer::load(&path),
        Err(SacError::File { action: "read", .. })
    ));
}

#[test]
fn every_truncation() {
    let files = files();
    let bytes = std::fs::read(&files.agent).unwrap();
    let path = files.folder.path().join("cut");
    for length in (0..bytes.len())
        .step_by(bytes.len() / 60)
        .chain([bytes.len() - 1])
    {
        std::fs::write(&path, &bytes[..length]).unwrap();
        refuse_agent(&path, "restore it from a copy");
    }
    let bytes = std::fs::read(&files.replay).unwrap();
    for length in [0, 7, 8, 100, bytes.len() - 1] {
        std::fs::write(&path, &bytes[..length]).unwrap();
        assert!(matches!(
            ReplayBuffer::load(&path),
            Err(SacError::Format { .. })
        ));
    }
}

#[test]
fn foreign_files() {
    let files = files();
    let path = files.folder.path().join("foreign");
    std::fs::write(&path, "this is no checkpoint at all, it is prose").unwrap();
    refuse_agent(&path, "not a valid agent checkpoint");
    // Each is the other's foreign file.
    refuse_agent(&files.replay, "no entry `gaitshift-sac-agent`");
    assert!(matches!(
        ReplayBuffer::load(&files.agent),
        Err(SacError::Format { .. })
    ));
    // Without metadata.
    let empty = safetensors::serialize(
        Vec::<(String, safetensors::tensor::TensorView<'_>)>::new(),
        None,
    )
    .unwrap();
    std::fs::write(&path, empty).unwrap();
    refuse_agent(&path, "no entry `gaitshift-sac-agent`");
}

/// Replaces text of the header by text of the same length.
fn alter(from: &Path, to: &Path, old: &str, new: &str) {
    assert_eq!(old.len(), new.len());
    let mut bytes = std::fs::read(from).unwrap();
    let place = bytes
        .windows(old.len())
        .position(|window| window == old.as_bytes())
        .expect(old);
    bytes[place..place + old.len()].copy_from_slice(new.as_bytes());
    std::fs::write(to, bytes).unwrap();
}

#[test]
fn altered_headers() {
    let files = files();
    let path = files.folder.path().join("altered");
    for (old, new, cause) in [
        (r#"\"format\":5"#, r#"\"format\":7"#, "has format 7"),
        (
            "\"critic_2.output.bias\"",
            "\"critic_2.outPUT.bias\"",
            "`critic_2.output.bias` is missing",
        ),
        (r#"\"gamma\":0.99"#, r#"\"gamma\":9.99"#, "`gamma` is 9.99"),
        (
            r#"\"gamma\":0.99"#,
            r#"\"gamMa\":0.99"#,
            "unknown field `gamMa`",
        ),
        (
            r#"\"actor_hidden\":[8]"#,
            r#"\"actor_hidden\":[9]"#,
            "but F32 [9, 2] is needed",
        ),
    ] {
        alter(&files.agent, &path, old, new);
        refuse_agent(&path, cause);
    }
    for (old, new) in [
        (r#"\"filled\":2"#, r#"\"filled\":3"#),
        (r#"\"head\":2"#, r#"\"head\":7"#),
        (r#"\"streams\":2"#, r#"\"streams\":0"#),
        (r#"\"rows\":3"#, r#"\"rows\":1"#),
    ] {
        alter(&files.replay, &path, old, new);
        let error = ReplayBuffer::load(&path).unwrap_err();
        assert!(matches!(error, SacError::Format { .. }), "{old}: {error}");
    }
}

#[test]
fn a_count_of_updates_from_which_nobody_can_count_on() {
    // What went wrong: found among damaged files. An agent that claims 2^64 - 1 updates was accepted, and its next update
    // overflowed; so was one whose temperature claims as many steps.
    let files = files();
    let learned = files.folder.path().join("learned");
    learned_temperature().save(&learned).unwrap();
    let path = files.folder.path().join("counted");
    for (file, key) in [
        (&files.agent, "updates"),
        (&files.agent, "actor_steps"),
        (&learned, "steps"),
    ] {
        let count = format!(r#"\"{key}\":{}"#, u64::MAX);
        rewrite(file, &path, &format!(r#"\"{key}\":0"#), &count);
        refuse_agent(&path, "more updates than any run can make");
    }
}

#[test]
fn a_temperature_that_cannot_be() {
    // What went wrong: a negative temperature was accepted, and the agent went on to learn with it.
    let files = files();
    let learned = files.folder.path().join("learned");
    learned_temperature().save(&learned).unwrap();
    let path = files.folder.path().join("heated");
    let state = r#"\"temperature\":{\"alpha\":"#;
    for (file, old, new, least) in [
        (&files.agent, "0.2", "-0.2", "at least 0"),
        (&learned, "0.3", "-0.3", "above 0"),
        (&learned, "0.3", "0.0", "above 0"),
    ] {
        rewrite(
            file,
            &path,
            &format!("{state}{old}"),
            &format!("{state}{new}"),
        );
        refuse_agent(&path, &format!("must be {least}"));
    }
    // A fixed one may be 0.
    rewrite(
        &files.agent,
        &path,
        &format!("{state}0.2"),
        &format!("{state}0.0"),
    );
    assert_eq!(Agent::load(&path).unwrap().alpha(), 0.0);
}

fn learned_temperature() -> Agent {
    let config = SacConfig {
        actor_hidden: vec![8],
        critic_hidden: vec![8],
        temperature: Temperature::Auto {
            initial: 0.3,
            target_entropy: None,
            learning_rate: 1e-3,
        },
        ..SacConfig::default()
    };
    Agent::new(config, 2, 1, None, 1).unwrap()
}

/// Replaces text of the header by text of any length.
fn rewrite(from: &Path, to: &Path, old: &str, new: &str) {
    let bytes = std::fs::read(from).unwrap();
    let end = header_end(&bytes);
    let header = std::str::from_utf8(&bytes[8..8 + end]).unwrap();
    assert_eq!(header.matches(old).count(), 1, "{old} in {header}");
    let header = header.replacen(old, new, 1);
    let length = (header.len() as u64).to_le_bytes();
    let file = [&length[..], header.as_bytes(), &bytes[8 + end..]].concat();
    std::fs::write(to, file).unwrap();
}

/// Length of the header that a file names.
fn header_end(bytes: &[u8]) -> usize {
    u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize
}

#[test]
fn a_folder_that_does_not_exist() {
    let files = files();
    let path = files.folder.path().join("no/such/folder/agent");
    let agent = Agent::load(&files.agent).unwrap();
    let error = agent.save(&path).unwrap_err();
    assert!(
        matches!(
            error,
            SacError::File {
                action: "write",
                ..
            }
        ),
        "{error}"
    );
}
