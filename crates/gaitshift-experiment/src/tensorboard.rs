//! TensorBoard event files: scalars by name and step.
//!
//! An event file is a sequence of records `length, crc(length), data, crc(data)` with masked CRC-32C,
//! each `data` a protocol-buffer `Event`. Only scalars are needed, so the few bytes are written here.

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
            let mut event = Vec::new();
            put_double(&mut event, 1, 0.0);
            put_bytes(&mut event, 3, b"brain.Event:2");
            writer.record(&event)?;
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
        self.record(&event)?;
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

    fn record(&mut self, data: &[u8]) -> io::Result<()> {
        let length = (data.len() as u64).to_le_bytes();
        self.file.write_all(&length)?;
        self.file.write_all(&masked_crc(&length).to_le_bytes())?;
        self.file.write_all(data)?;
        self.file.write_all(&masked_crc(data).to_le_bytes())
    }
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
