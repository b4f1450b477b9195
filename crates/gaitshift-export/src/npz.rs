//! A recording as NPZ, the archive of arrays that `numpy.load` reads: a ZIP file, not compressed, with
//! one `.npy` entry for each column and one, `metadata`, for the JSON of the recording's first line.
//!
//! ZIP: PKWARE's APPNOTE.TXT, sections 4.3.7, 4.3.12 and 4.3.16. NPY: `numpy.lib.format`, version 1.0.

use gaitshift_analysis::Recording;

/// The bytes of the NPZ file of a recording: for each column an array of 64-bit floats with as many
/// elements as there are rows, and `metadata`, a string.
///
/// # Errors
/// As a text, metadata that cannot be written as JSON.
pub fn npz(recording: &Recording) -> Result<Vec<u8>, String> {
    let mut archive = Archive::default();
    for (name, series) in recording.every_column() {
        let bytes = series.iter().flat_map(|v| v.to_le_bytes()).collect();
        archive.add(name, &npy("<f8", &format!("({},)", series.len()), bytes))?;
    }
    let metadata = serde_json::to_string(&recording.metadata).map_err(|e| e.to_string())?;
    // NumPy's strings are of 32-bit characters, of fixed number.
    let characters: Vec<u8> = metadata
        .chars()
        .flat_map(|c| u32::from(c).to_le_bytes())
        .collect();
    let kind = format!("<U{}", characters.len() / 4);
    archive.add("metadata", &npy(&kind, "()", characters))?;
    archive.finish()
}

/// An array in NumPy's own format.
fn npy(kind: &str, shape: &str, data: Vec<u8>) -> Vec<u8> {
    let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    // Magic, version, length and header together fill whole blocks of 64 bytes.
    while !(10 + header.len() + 1).is_multiple_of(64) {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

/// A ZIP archive being written, its entries stored as they are.
#[derive(Default)]
struct Archive {
    bytes: Vec<u8>,
    directory: Vec<u8>,
    entries: u16,
}

impl Archive {
    fn add(&mut self, name: &str, data: &[u8]) -> Result<(), String> {
        let name = format!("{name}.npy");
        let offset = small(self.bytes.len())?;
        let size = small(data.len())?;
        // Version 2.0, no flags, stored, 1 January 1980: the same recording gives the same bytes.
        let mut common = vec![20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0];
        common.extend(crc32fast::hash(data).to_le_bytes());
        common.extend(size.to_le_bytes());
        common.extend(size.to_le_bytes());
        common.extend((name.len() as u16).to_le_bytes());
        common.extend([0, 0]);

        self.bytes.extend(b"PK\x03\x04");
        self.bytes.extend(&common);
        self.bytes.extend(name.as_bytes());
        self.bytes.extend(data);

        self.directory.extend(b"PK\x01\x02\x14\x00");
        self.directory.extend(&common);
        // No comment, disk 0, no attributes.
        self.directory.extend([0; 10]);
        self.directory.extend(offset.to_le_bytes());
        self.directory.extend(name.as_bytes());
        self.entries += 1;
        Ok(())
    }

    fn finish(mut self) -> Result<Vec<u8>, String> {
        let offset = small(self.bytes.len())?;
        let size = small(self.directory.len())?;
        self.bytes.append(&mut self.directory);
        self.bytes.extend(b"PK\x05\x06\0\0\0\0");
        self.bytes.extend(self.entries.to_le_bytes());
        self.bytes.extend(self.entries.to_le_bytes());
        self.bytes.extend(size.to_le_bytes());
        self.bytes.extend(offset.to_le_bytes());
        self.bytes.extend([0, 0]);
        Ok(self.bytes)
    }
}

/// A ZIP archive without extensions counts its bytes in 32 bits.
fn small(length: usize) -> Result<u32, String> {
    u32::try_from(length).map_err(|_| {
        "the recording is larger than 4 GB; cut it before writing it as NPZ".to_owned()
    })
}
