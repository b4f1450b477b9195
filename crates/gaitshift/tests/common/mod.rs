//! Running the program as its user does, in a folder of its own.
#![allow(dead_code)]

use gaitshift_analysis::recording::{COLUMNS, Column, Recording, RecordingMetadata, column};
use gaitshift_body::BodyParameters;
use serde_json::Value;
use std::path::PathBuf;
use std::process::{Command, Output};
use tempfile::TempDir;

/// An experiment of seconds.
pub const TINY: &str = include_str!("../tiny.toml");

/// A folder to run the program in.
pub struct Place {
    folder: TempDir,
}

impl Place {
    pub fn new() -> Self {
        Self {
            folder: tempfile::tempdir().unwrap(),
        }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// The program with arguments separated by spaces.
    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("gaitshift"));
        command
            .args(arguments.split_whitespace())
            .current_dir(self.folder.path());
        command
    }

    /// Runs the program to its end; it must never panic.
    pub fn output(&self, arguments: &str) -> Output {
        let output = self.command(arguments).output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(!stderr.contains("panicked"), "{arguments}: {stderr}");
        output
    }

    /// What the program prints when it succeeds.
    pub fn stdout(&self, arguments: &str) -> String {
        let output = self.output(arguments);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{arguments}: {stderr}");
        String::from_utf8(output.stdout).unwrap()
    }

    /// The commands that the help of `command` lists; the program's own for an empty one.
    pub fn commands(&self, command: &str) -> Vec<String> {
        let help = self.stdout(&format!("{command} --help"));
        let listed = help
            .lines()
            .skip_while(|line| !["Commands:", "Formats:"].contains(line))
            .skip(1)
            .take_while(|line| !line.is_empty())
            // Names are indented by two spaces, the rest of a description by more.
            .filter_map(|line| {
                line.strip_prefix("  ")
                    .filter(|line| !line.starts_with(' '))
            })
            .filter_map(|line| line.split_whitespace().next())
            .filter(|name| *name != "help");
        listed.map(str::to_owned).collect()
    }

    /// The single JSON object that the program prints.
    pub fn json(&self, arguments: &str) -> Value {
        let text = self.stdout(arguments);
        serde_json::from_str(&text).unwrap_or_else(|e| panic!("{arguments}: {e}: {text}"))
    }

    /// Bad input: exit code 2, nothing on standard output, one error that holds all `words`.
    pub fn refused(&self, arguments: &str, words: &[&str]) {
        let output = self.output(arguments);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments}: {stderr}");
        assert!(output.stdout.is_empty(), "{arguments}");
        let errors = stderr.lines().filter(|line| line.starts_with("error:"));
        assert_eq!(errors.count(), 1, "{arguments}: {stderr}");
        for word in words {
            assert!(
                stderr.contains(word),
                "{arguments}: no `{word}` in: {stderr}"
            );
        }
    }

    /// A kinematic toy whose feet take turns on the ground, so that there are strides to draw.
    pub fn write_toy_recording(&self, name: &str) {
        let body = BodyParameters::default();
        let mut recording = Recording::new(RecordingMetadata {
            control_period_s: 0.005,
            total_mass_kg: body.total_mass_kg(),
            gravity_m_per_s2: body.gravity_m_per_s2,
            leg_length_m: body.leg_length_m,
            body: serde_json::to_value(&body).unwrap(),
            controller: "toy".to_owned(),
            seed: 0,
            fell: false,
            ended_by: "time limit".to_owned(),
            disturbance: None,
            ground: None,
        });
        for k in 0..=1200 {
            let time_s = 0.005 * f64::from(k);
            let mut row = vec![0.0; COLUMNS.len()];
            let mut set = |column: Column, value: f64| row[column.index()] = value;
            set(column::TIME_S, time_s);
            set(column::X_M, 0.6 * time_s);
            set(column::Z_M, 0.79);
            for side in 0..2 {
                // A stride lasts 1 s, of which each foot spends 0.6 s on the ground.
                let phase = (time_s + 0.5 * side as f64).fract();
                let swing = (2.0 * (phase - 0.6)).max(0.0);
                set(column::PHI_RAD[side], 0.3 - phase + 2.0 * swing);
                set(column::H_M[side], -0.1 * swing);
                set(
                    column::NORMAL_FORCE_N[side],
                    if phase < 0.6 { 330.0 } else { 0.0 },
                );
            }
            recording.push_row(&row).unwrap();
        }
        recording.write_csv(self.path(name)).unwrap();
    }
}
