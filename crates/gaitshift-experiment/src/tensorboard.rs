//! TensorBoard event files: scalars by name and step, and the settings of a run for its table of hyperparameters.
//!
//! An event file is a sequence of records `length, crc(length), data, crc(data)` with masked CRC-32C,
//! each `data` a protocol-buffer `Event`. Only these are needed, so the few bytes are written here.

use serde::{Deserialize, Serialize};
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Appends scalar events to a file that TensorBoard reads.
#[derive(Debug)]
pub struct EventWriter {
    file: BufWriter<File>,
}

impl EventWriter {
    /// Opens a file for appending; a new file gets the version record.
    ///
    /// # Errors
    /// Whatever the file system says.
    pub fn append(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().create(true).append(true).open(path)?;
        let new = file.metadata()?.len() == 0;
        let mut writer = Self {
            file: BufWriter::new(file),
        };
        if new {
            writer.file.write_all(&version())?;
        }
        Ok(writer)
    }

    /// Writes scalars of one step. `wall_time_s` is in seconds since 1970.
    ///
    /// # Errors
    /// Whatever the file system says.
    pub fn scalars(
        &mut self,
        step: u64,
        wall_time_s: f64,
        values: &[(String, f64)],
    ) -> io::Result<()> {
        let mut summary = Vec::new();
        for (tag, value) in values {
            let mut entry = Vec::new();
            put_bytes(&mut entry, 1, tag.as_bytes());
            // Field 2 of Summary.Value: simple_value, a float.
            entry.push(2 << 3 | 5);
            entry.extend_from_slice(&(*value as f32).to_le_bytes());
            put_bytes(&mut summary, 1, &entry);
        }
        let mut event = Vec::new();
        put_double(&mut event, 1, wall_time_s);
        event.push(2 << 3);
        put_varint(&mut event, step);
        put_bytes(&mut event, 5, &summary);
        self.file.write_all(&record(&event))?;
        self.file.flush()
    }

    /// Puts everything on the disk and gives the file's length in bytes.
    ///
    /// # Errors
    /// Whatever the file system says.
    pub fn sync(&mut self) -> io::Result<u64> {
        self.file.flush()?;
        self.file.get_ref().sync_data()?;
        Ok(self.file.get_ref().metadata()?.len())
    }
}

/// A setting's value as TensorBoard's hyperparameters have it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Setting {
    /// A number.
    Number(f64),
    /// A word.
    Word(String),
}

impl Setting {
    /// A number where `text` is one.
    pub fn parse(text: &str) -> Self {
        text.parse().map_or_else(
            |_| Self::Word(text.trim_matches('"').to_owned()),
            Self::Number,
        )
    }
}

/// The bytes of an event file with the settings of a run, which TensorBoard shows beside the scalars of the same folder.
/// No group is named, so that every run has a row of its own.
pub fn settings_file(settings: &[(String, Setting)]) -> Vec<u8> {
    const PLUGIN: &[u8] = b"hparams";
    const TAG: &[u8] = b"_hparams_/session_start_info";
    let mut session = Vec::new();
    for (name, setting) in settings {
        // google.protobuf.Value: a number is its field 2, a string its field 3.
        let mut value = Vec::new();
        match setting {
            Setting::Number(number) => put_double(&mut value, 2, *number),
            Setting::Word(word) => put_bytes(&mut value, 3, word.as_bytes()),
        }
        let entry = message(&[(1, name.as_bytes()), (2, &value)]);
        put_bytes(&mut session, 1, &entry);
    }
    let content = message(&[(3, &session)]);
    let metadata = message(&[(1, &message(&[(1, PLUGIN), (2, &content)]))]);
    let summary = message(&[(1, &message(&[(1, TAG), (9, &metadata)]))]);
    let mut event = Vec::new();
    put_double(&mut event, 1, 0.0);
    put_bytes(&mut event, 5, &summary);
    [version(), record(&event)].concat()
}

/// The record that every event file begins with.
fn version() -> Vec<u8> {
    let mut event = Vec::new();
    put_double(&mut event, 1, 0.0);
    put_bytes(&mut event, 3, b"brain.Event:2");
    record(&event)
}

/// An event as it stands in the file.
fn record(data: &[u8]) -> Vec<u8> {
    let length = (data.len() as u64).to_le_bytes();
    let (before, after) = (masked_crc(&length), masked_crc(data));
    [
        &length[..],
        &before.to_le_bytes(),
        data,
        &after.to_le_bytes(),
    ]
    .concat()
}

/// A message of fields that are bytes or messages.
fn message(fields: &[(u8, &[u8])]) -> Vec<u8> {
    let mut out = Vec::new();
    for (field, bytes) in fields {
        put_bytes(&mut out, *field, bytes);
    }
    out
}

fn masked_crc(data: &[u8]) -> u32 {
    crc32c::crc32c(data)
        .rotate_right(15)
        .wrapping_add(0xa282_ead8)
}

fn put_varint(out: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

fn put_bytes(out: &mut Vec<u8>, field: u8, bytes: &[u8]) {
    out.push(field << 3 | 2);
    put_varint(out, bytes.len() as u64);
    out.extend_from_slice(bytes);
}

fn put_double(out: &mut Vec<u8>, field: u8, value: f64) {
    out.push(field << 3 | 1);
    out.extend_from_slice(&value.to_le_bytes());
}
