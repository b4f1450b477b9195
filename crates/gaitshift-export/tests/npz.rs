//! Contract: a recording's NPZ is a ZIP archive with an array for each column and the metadata, every
//! entry with its checksum, every number to the bit, the same bytes for the same recording. That NumPy reads
//! it is tested with NumPy: `crates/gaitshift-python/tests/test_motion.py`.

use gaitshift_analysis::recording::{COLUMNS, Recording, RecordingMetadata};
use gaitshift_export::npz;

fn recording(rows: usize) -> Recording {
    let mut recording = Recording::new(RecordingMetadata {
        control_period_s: 0.01,
        total_mass_kg: 40.0,
        gravity_m_per_s2: 9.81,
        leg_length_m: 0.8,
        body: serde_json::json!({ "friction": 1.0 }),
        controller: "ω".to_owned(),
        seed: 3,
        fell: false,
        ended_by: "time limit".to_owned(),
        disturbance: None,
        ground: None,
    });
    for row in 0..rows {
        let values: Vec<f64> = (0..COLUMNS.len())
            .map(|k| 0.01 * row as f64 + k as f64 / 7.0)
            .collect();
        recording.push_row(&values).unwrap();
    }
    recording
}

fn number(bytes: &[u8], at: usize, width: usize) -> usize {
    bytes[at..at + width]
        .iter()
        .rev()
        .fold(0, |value, &byte| value << 8 | usize::from(byte))
}

/// Names and contents by the central directory, each checked against its local header.
fn entries(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
    let end = bytes.len() - 22;
    assert_eq!(&bytes[end..end + 4], b"PK\x05\x06");
    let count = number(bytes, end + 10, 2);
    let mut at = number(bytes, end + 16, 4);
    assert_eq!(at + number(bytes, end + 12, 4), end);
    let mut all = Vec::new();
    for _ in 0..count {
        assert_eq!(&bytes[at..at + 4], b"PK\x01\x02");
        let (crc, size) = (number(bytes, at + 16, 4), number(bytes, at + 24, 4));
        let length = number(bytes, at + 28, 2);
        let local = number(bytes, at + 42, 4);
        let name = String::from_utf8(bytes[at + 46..at + 46 + length].to_vec()).unwrap();
        assert_eq!(&bytes[local..local + 4], b"PK\x03\x04");
        assert_eq!(bytes[local + 4..local + 30], bytes[at + 6..at + 32]);
        let start = local + 30 + length;
        let data = bytes[start..start + size].to_vec();
        assert_eq!(crc32fast::hash(&data) as usize, crc, "{name}");
        all.push((name, data));
        at += 46 + length;
    }
    all
}

#[test]
fn every_column_is_an_array_of_the_same_bits() {
    for rows in [0, 1, 250] {
        let recording = recording(rows);
        let bytes = npz(&recording).unwrap();
        assert_eq!(bytes, npz(&recording).unwrap());
        let entries = entries(&bytes);
        assert_eq!(entries.len(), COLUMNS.len() + 1);
        for (k, (name, data)) in entries.iter().enumerate().take(COLUMNS.len()) {
            assert_eq!(*name, format!("{}.npy", COLUMNS[k]));
            let header = 10 + number(data, 8, 2);
            assert!(header.is_multiple_of(64));
            let text = std::str::from_utf8(&data[10..header]).unwrap();
            assert!(
                text.contains("'<f8'") && text.contains(&format!("({rows},)")),
                "{text}"
            );
            let values: Vec<f64> = data[header..]
                .chunks_exact(8)
                .map(|b| f64::from_le_bytes(b.try_into().unwrap()))
                .collect();
            let column = gaitshift_analysis::recording::Column::named(COLUMNS[k]).unwrap();
            assert_eq!(values, recording.column(column));
        }
        assert_eq!(entries.last().unwrap().0, "metadata.npy");
    }
}
