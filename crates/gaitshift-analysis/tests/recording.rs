//! Contract: a recording written and read back is the same to the bit; a file that is damaged, cut off or
//! something else is refused with an error that names the file, the place, the cause and the remedy; a
//! recording never holds a number that is not finite, nor time running backwards.

use crate::common;
use std::fs;

use crate::common::{Gait, metadata};
use gaitshift_analysis::recording::{
    COLUMNS, Column, DETAILS, Recording, RecordingError, RowError, Window, column, detail,
};
use proptest::prelude::*;
use tempfile::TempDir;

fn bits(recording: &Recording) -> Vec<Vec<u64>> {
    let series = |name: &&str| {
        let column = Column::named(name).expect("known");
        recording
            .column(column)
            .iter()
            .map(|value| value.to_bits())
            .collect()
    };
    COLUMNS.iter().map(series).collect()
}

fn round_trip(recording: &Recording) -> Recording {
    let folder = TempDir::new().expect("temporary folder");
    let path = folder.path().join("motion.csv");
    recording.write_csv(&path).expect("written");
    Recording::read_csv(&path).expect("read")
}

/// Writes a good file, changes its text and reads it.
fn read_changed(change: impl Fn(&str) -> String) -> Result<Recording, RecordingError> {
    let folder = TempDir::new().expect("temporary folder");
    let path = folder.path().join("motion.csv");
    Gait::WALK.record(0.05).write_csv(&path).expect("written");
    let text = fs::read_to_string(&path).expect("text");
    fs::write(&path, change(&text)).expect("rewritten");
    Recording::read_csv(&path)
}

/// The error of a changed file; it must name the file and all of `parts`.
fn refusal(change: impl Fn(&str) -> String, parts: &[&str]) -> RecordingError {
    let error = read_changed(change).expect_err("refused");
    let message = error.to_string();
    for part in parts.iter().chain(&["motion.csv"]) {
        assert!(message.contains(part), "{message:?} lacks {part:?}");
    }
    error
}

/// Replaces field `field` of line `line` (both from 0) in a file.
fn with_field(text: &str, line: usize, field: usize, value: &str) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let mut fields: Vec<&str> = lines[line].split(',').collect();
    fields[field] = value;
    lines[line] = fields.join(",");
    lines.join("\n") + "\n"
}

#[test]
fn columns_are_those_of_the_format() {
    assert_eq!(COLUMNS.len(), 52);
    assert_eq!(COLUMNS[..3], ["time_s", "omega_v", "x_m"]);
    assert_eq!(column::RIGHT_PHI_RAD.name(), "right_phi_rad");
    assert_eq!(column::LEFT_NORMAL_FORCE_N.name(), "left_normal_force_n");
    assert_eq!(column::REWARD_WORK.index(), 51);
    for (index, name) in COLUMNS.iter().enumerate() {
        assert_eq!(Column::named(name).map(Column::index), Some(index));
    }
    assert_eq!(Column::named("time"), None);
}

#[test]
fn a_file_starts_with_its_kind_version_and_metadata() {
    let folder = TempDir::new().expect("temporary folder");
    let path = folder.path().join("motion.csv");
    Gait::WALK.record(0.01).write_csv(&path).expect("written");
    let text = fs::read_to_string(&path).expect("text");
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[0].starts_with("# gaitshift-recording 1 {\"control_period_s\":0.005,"));
    assert!(lines[0].contains("\"seed\":18446744073709551615"));
    assert_eq!(lines[1], COLUMNS.join(","));
    assert_eq!(lines.len(), 2 + 3);
}

#[test]
fn metadata_survives_to_the_bit() {
    let mut metadata = metadata();
    // A number that serde_json's default parser reads back with another last bit.
    metadata.total_mass_kg = 31.245_270_191_439_438;
    metadata.body =
        serde_json::json!({"k": 0.1 + 0.2, "text": "a, \"b\"\n# c", "list": [1, -2.5e-300]});
    metadata.controller = "controllers/näher, am Ziel.safetensors".to_owned();
    let recording = Recording::new(metadata);
    let read = round_trip(&recording);
    assert_eq!(read, recording);
    assert!(read.is_empty());
}

#[test]
fn columns_in_another_order_and_unknown_columns_are_read() {
    let read = read_changed(|text| {
        let mut lines = text.lines();
        let first = lines.next().expect("first line").to_owned();
        lines.fold(first + "\n", |text, line| {
            let reversed: Vec<&str> = line.split(',').rev().collect();
            let extra = if line.starts_with("time_s") {
                "comment"
            } else {
                "any, \"\"thing"
            };
            text + &format!("\"{extra}\",") + &reversed.join(",") + "\n"
        })
    });
    assert_eq!(bits(&read.expect("read")), bits(&Gait::WALK.record(0.05)));
}

#[test]
fn metadata_written_by_another_program_may_hold_integers_and_lack_the_row_count() {
    let read = read_changed(|text| {
        text.replace(
            "\"leg_length_m\":0.8,\"body\"",
            "\"leg_length_m\":1,\"body\"",
        )
        .replace(",\"rows\":11", "")
    });
    assert_eq!(read.expect("read").metadata.leg_length_m, 1.0);
}

// Of a file that a spreadsheet had saved it was said that its first line is another.
#[test]
fn a_byte_order_mark_is_no_part_of_the_first_line() {
    let read = read_changed(|text| format!("\u{feff}{text}"));
    assert_eq!(bits(&read.expect("read")), bits(&Gait::WALK.record(0.05)));
}

#[test]
fn foreign_files_are_refused() {
    assert!(matches!(
        refusal(|_| String::new(), &["empty"]),
        RecordingError::Foreign { .. }
    ));
    let foreign = refusal(
        |_| "time,x\n0,1\n".to_owned(),
        &["not a recording", "gaitshift transition"],
    );
    assert!(matches!(foreign, RecordingError::Foreign { .. }));
    let version = refusal(
        |text| text.replacen("recording 1", "recording 2", 1),
        &["line 1", "\"2\"", "format 1"],
    );
    assert!(matches!(version, RecordingError::Version { .. }));

    let folder = TempDir::new().expect("temporary folder");
    let path = folder.path().join("motion.csv");
    fs::write(&path, [0x93, 0x4e, 0xff, 0x00]).expect("written");
    let error = Recording::read_csv(&path).expect_err("refused");
    assert!(error.to_string().contains("not a text file"), "{error}");
}

// The system's word for it was all that was said.
#[test]
fn a_folder_is_answered_by_a_recording_in_it() {
    let folder = TempDir::new().expect("temporary folder");
    let refused = || {
        Recording::read_csv(folder.path())
            .expect_err("refused")
            .to_string()
    };
    assert!(refused().ends_with("is a folder, not a recording; give a CSV file in it"));
    fs::write(folder.path().join("a.csv"), "time_s,omega_v\n0,1\n").expect("written");
    let motion = folder.path().join("omega_v_3.csv");
    fs::write(&motion, "# gaitshift-recording 1 {}\n").expect("written");
    assert!(refused().ends_with(&format!(", such as {}", motion.display())));
    let usual = folder.path().join("recording.csv");
    fs::write(&usual, "").expect("written");
    assert!(refused().ends_with(&format!(", such as {}", usual.display())));
}

#[test]
fn unreadable_and_unwritable_paths_are_named() {
    let folder = TempDir::new().expect("temporary folder");
    let missing = folder.path().join("nowhere").join("motion.csv");
    for (error, action) in [
        (
            Recording::read_csv(&missing).expect_err("unreadable"),
            "read",
        ),
        (
            Recording::new(metadata())
                .write_csv(&missing)
                .expect_err("unwritable"),
            "write",
        ),
    ] {
        let message = error.to_string();
        assert!(
            message.contains(action) && message.contains("nowhere"),
            "{message}"
        );
    }
}

#[test]
fn damaged_metadata_is_refused() {
    refusal(
        |text| text.replacen("\"seed\"", "\"sead\"", 1),
        &["line 1", "seed"],
    );
    refusal(
        |text| text.replacen("{\"control", "{control", 1),
        &["line 1", "metadata"],
    );
    refusal(
        |text| text.replacen("\"total_mass_kg\":40.0", "\"total_mass_kg\":-40.0", 1),
        &["line 1", "total_mass_kg", "-40", "positive"],
    );
    let mut recording = Recording::new(metadata());
    recording.metadata.gravity_m_per_s2 = f64::NAN;
    let folder = TempDir::new().expect("temporary folder");
    let error = recording
        .write_csv(folder.path().join("motion.csv"))
        .expect_err("refused");
    assert!(error.to_string().contains("gravity_m_per_s2"), "{error}");
}

#[test]
fn a_file_cut_anywhere_is_refused() {
    let folder = TempDir::new().expect("temporary folder");
    let path = folder.path().join("motion.csv");
    Gait::WALK.record(0.01).write_csv(&path).expect("written");
    let whole = fs::read(&path).expect("bytes");
    for length in 0..whole.len() {
        fs::write(&path, &whole[..length]).expect("rewritten");
        assert!(
            Recording::read_csv(&path).is_err(),
            "cut to {length} of {} bytes",
            whole.len()
        );
    }
}

#[test]
fn cut_files_say_so() {
    let cut = |text: &str, bytes: usize| text[..text.len() - bytes].to_owned();
    let ends = refusal(
        |text| cut(text, 1),
        &["cut off", "line break", "record the motion again"],
    );
    assert!(matches!(ends, RecordingError::Truncated { .. }));
    let fields = refusal(|text| cut(text, 30), &["line 13", "52"]);
    assert!(matches!(
        fields,
        RecordingError::FieldCount {
            line: 13,
            expected: 52,
            ..
        }
    ));
    let rows = refusal(
        |text| {
            text.lines()
                .take(8)
                .map(|line| line.to_owned() + "\n")
                .collect()
        },
        &["6 rows", "11"],
    );
    assert!(matches!(rows, RecordingError::Truncated { .. }));
    let header = refusal(
        |text| {
            text.lines()
                .take(1)
                .map(|line| line.to_owned() + "\n")
                .collect()
        },
        &["no header"],
    );
    assert!(matches!(header, RecordingError::Truncated { .. }));
}

#[test]
fn missing_and_doubled_columns_are_named() {
    let missing = refusal(
        |text| with_field(&with_field(text, 1, 2, "xx_m"), 1, 40, "yy"),
        &["line 2", "x_m", COLUMNS[40]],
    );
    assert!(
        matches!(missing, RecordingError::MissingColumns { columns, .. } if columns == ["x_m", COLUMNS[40]])
    );
    // Beside an unknown column's name, so that no column is missing.
    let doubled = refusal(
        |text| {
            text.replace('\n', ",0.0\n")
                .replace("reward_work,0.0", "reward_work,z_m")
                .replacen("},0.0", "}", 1)
        },
        &["line 2", "`z_m`", "twice"],
    );
    assert!(matches!(
        doubled,
        RecordingError::DuplicateColumn { column, .. } if column == "z_m"
    ));
}

#[test]
fn text_in_place_of_a_number_is_located() {
    let text = refusal(
        |text| with_field(text, 4, 3, "fast"),
        &["line 5", "`z_m`", "\"fast\"", "not a number"],
    );
    assert!(matches!(
        text,
        RecordingError::NotANumber {
            line: 5,
            column,
            ..
        } if column == "z_m"
    ));
    refusal(
        |text| with_field(text, 4, 3, ""),
        &["line 5", "`z_m`", "\"\""],
    );
    let infinite = refusal(
        |text| with_field(text, 4, 3, "NaN"),
        &["line 5", "`z_m`", "NaN", "finite"],
    );
    assert!(matches!(infinite, RecordingError::Row { line: 5, .. }));
    let backwards = refusal(
        |text| with_field(text, 4, 0, "0.001"),
        &["line 5", "time_s", "0.001", "0.005"],
    );
    assert!(matches!(
        backwards,
        RecordingError::Row {
            source: RowError::TimeNotIncreasing { .. },
            ..
        }
    ));
}

#[test]
fn a_refused_row_leaves_the_recording_unchanged() {
    let mut recording = Gait::WALK.record(0.01);
    let before = recording.clone();
    let mut row = vec![1.0; COLUMNS.len()];
    row[7] = f64::INFINITY;
    let infinite = RowError::NotFinite {
        column: COLUMNS[7].to_owned(),
        value: f64::INFINITY,
    };
    assert_eq!(recording.push_row(&row), Err(infinite));
    assert_eq!(
        recording.push_row(&row[1..]),
        Err(RowError::Width {
            found: 51,
            expected: 52
        })
    );
    row[7] = 0.0;
    row[0] = 0.01;
    let late = RowError::TimeNotIncreasing {
        time_s: 0.01,
        previous_s: 0.01,
    };
    assert_eq!(recording.push_row(&row), Err(late));
    assert_eq!(recording, before);
    row[0] = 0.015;
    assert_eq!(recording.push_row(&row), Ok(()));
    assert_eq!(recording.len(), 4);
}

#[test]
fn windows_hold_the_rows_between_two_times() {
    let recording = Gait::WALK.record(1.0);
    let window = recording.window(0.2, 0.3).expect("two rows");
    assert_eq!((window.start_row(), window.end_row()), (40, 60));
    assert!((window.duration_s(&recording) - 0.1).abs() < 1e-12);
    assert!(window.contains(40) && window.contains(60) && !window.contains(61));
    assert_eq!(recording.window(-1.0, 9.0), Window::new(0, 200));
    assert_eq!(recording.window(0.2, 0.2), None);
    assert_eq!(recording.window(0.3, 0.2), None);
    assert_eq!(recording.window(2.0, 3.0), None);
    assert_eq!(recording.window(f64::NAN, f64::NAN), None);
    assert_eq!(Recording::new(metadata()).window(0.0, 1.0), None);
    assert_eq!(recording.whole(), Window::new(0, 200));
    assert_eq!(
        window.intersection(Window::new(50, 90).expect("rows")),
        Window::new(50, 60)
    );
    assert_eq!(
        window.intersection(Window::new(60, 90).expect("rows")),
        None
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_finite_numbers_survive_to_the_bit(
        rows in prop::collection::vec(
            prop::collection::vec(
                prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO,
                COLUMNS.len(),
            ),
            0..6,
        ),
    ) {
        let mut recording = Recording::new(metadata());
        for (index, mut row) in rows.into_iter().enumerate() {
            row[0] = index as f64 / 3.0;
            recording.push_row(&row).expect("finite");
        }
        let read = round_trip(&recording);
        prop_assert_eq!(bits(&read), bits(&recording));
        prop_assert_eq!(read.metadata, recording.metadata);
    }
}

/// A recording with details that tell their rows and places.
fn detailed() -> Recording {
    let mut recording = Recording::new(metadata());
    for k in 0..4 {
        let mut row = vec![f64::from(k); COLUMNS.len() + DETAILS.len()];
        for (place, value) in row[COLUMNS.len()..].iter_mut().enumerate() {
            *value = f64::from(k) + 0.001 * place as f64 + 0.1;
        }
        recording.push_row(&row).expect("valid");
    }
    recording
}

#[test]
fn details_are_read_back_to_the_bit_whole_or_in_part_or_not_at_all() {
    let recording = detailed();
    assert_eq!(round_trip(&recording), recording);
    assert_eq!(
        recording.named_columns().count(),
        COLUMNS.len() + DETAILS.len()
    );
    let plain = Gait::WALK.record(0.05);
    assert_eq!(plain.detail(detail::COM_X_M), None);
    assert_eq!(plain.named_columns().count(), COLUMNS.len());
    assert_eq!(round_trip(&plain), plain);

    // Another simulator may know the centre of mass and nothing else.
    let text = recording.to_csv().expect("text");
    let keep = COLUMNS.len() + 4;
    let cut = text.lines().enumerate().map(|(line, text)| match line {
        0 => text.to_owned(),
        _ => text.split(',').take(keep).collect::<Vec<_>>().join(","),
    });
    let folder = TempDir::new().expect("temporary folder");
    let path = folder.path().join("part.csv");
    fs::write(&path, cut.collect::<Vec<_>>().join("\n") + "\n").expect("written");
    let part = Recording::read_csv(&path).expect("read");
    assert_eq!(
        part.detail(detail::COM_Z_M),
        recording.detail(detail::COM_Z_M)
    );
    assert_eq!(part.detail(detail::FLIGHT_SHARE), None);
    assert_eq!(round_trip(&part), part);
}

#[test]
fn damaged_details_are_refused() {
    let text = detailed().to_csv().expect("text");
    let folder = TempDir::new().expect("temporary folder");
    let path = folder.path().join("motion.csv");
    let refused = |text: String, parts: &[&str]| {
        fs::write(&path, text).expect("written");
        let message = Recording::read_csv(&path).expect_err("refused").to_string();
        for part in parts {
            assert!(message.contains(part), "{message:?} lacks {part:?}");
        }
    };
    let first = COLUMNS.len();
    refused(
        with_field(&text, 3, first + 1, "high"),
        &["com_z_m", "line 4", "high"],
    );
    refused(with_field(&text, 3, first, "inf"), &["com_x_m", "inf"]);
    refused(with_field(&text, 1, first + 1, "com_x_m"), &["com_x_m"]);
}

#[test]
fn rows_have_details_all_or_none() {
    let row = vec![9.0; COLUMNS.len()];
    let mut with = detailed();
    let width = |found, expected| Err(RowError::Width { found, expected });
    let whole = COLUMNS.len() + DETAILS.len();
    assert_eq!(with.push_row(&row), width(COLUMNS.len(), whole));
    let mut without = Gait::WALK.record(0.01);
    assert_eq!(
        without.push_row(&vec![9.0; whole]),
        width(whole, COLUMNS.len())
    );
    let mut empty = Recording::new(metadata());
    assert_eq!(
        empty.push_row(&row[1..]),
        width(COLUMNS.len() - 1, COLUMNS.len())
    );
    let mut told = Gait::WALK.record(0.01);
    assert!(told.set_detail(detail::COM_X_M, vec![1.0]).is_err());
    assert!(told.set_detail(detail::COM_X_M, vec![f64::NAN; 3]).is_err());
    assert_eq!(told.detail(detail::COM_X_M), None);
    told.set_detail(detail::COM_X_M, vec![1.0, 2.0, 3.0])
        .expect("valid");
    assert_eq!(told.detail(detail::COM_X_M), Some(&[1.0, 2.0, 3.0][..]));
    assert_eq!(round_trip(&told), told);
    // The detail became shorter than the rows.
    let before = told.clone();
    assert!(matches!(
        told.push_row(&row),
        Err(RowError::DetailLength { .. })
    ));
    assert_eq!(told, before);
}

#[test]
fn a_part_is_a_recording_of_those_rows() {
    let mut recording = common::Gait::WALK.record(2.0);
    let heights: Vec<f64> = (0..recording.len()).map(|row| row as f64).collect();
    recording
        .set_detail(detail::SOLE_HEIGHT_M[0], heights)
        .unwrap();
    let own = vec![0.25; recording.len()];
    recording.set_extra("reward_own", own).unwrap();
    let part = recording.part(recording.window(0.5, 1.5).unwrap());
    let (_, series) = part
        .every_column()
        .find(|(name, _)| *name == "reward_own")
        .unwrap();
    assert!(series == [0.25; 201]);
    assert_eq!(part.len(), 201);
    assert_eq!(part.column(column::TIME_S)[0], 0.5);
    assert_eq!(
        part.column(column::X_M),
        &recording.column(column::X_M)[100..=300]
    );
    assert_eq!(part.detail(detail::SOLE_HEIGHT_M[0]).unwrap()[200], 300.0);
    assert_eq!(part.detail(detail::SOLE_HEIGHT_M[1]), None);
    assert_eq!(part.metadata, recording.metadata);
}
