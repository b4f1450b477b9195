//! Writing and reading the file of a recording.

use std::fmt::Write as _;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::error::FORMAT_VERSION;
use super::{COLUMNS, DETAILS, Recording, RecordingError, RecordingMetadata, RowError, is_extra};
use crate::files::write_whole;

const MAGIC: &str = "# gaitshift-recording ";

/// The JSON of the first line: the metadata and the number of rows to expect.
#[derive(Serialize, Deserialize)]
struct FirstLine<M> {
    #[serde(flatten)]
    metadata: M,
    #[serde(default)]
    rows: Option<usize>,
}

impl Recording {
    /// Writes the recording as a CSV file, replacing what was there.
    ///
    /// # Errors
    /// If the metadata holds numbers that no reader would accept, or the file cannot be written.
    pub fn write_csv(&self, path: impl AsRef<Path>) -> Result<(), RecordingError> {
        let path = path.as_ref();
        let text = self.to_csv().map_err(|reason| RecordingError::Metadata {
            path: path.to_owned(),
            reason,
        })?;
        write_whole(path, text.as_bytes()).map_err(|source| RecordingError::Io {
            path: path.to_owned(),
            action: "write",
            source,
        })
    }

    /// The text of the CSV file.
    ///
    /// # Errors
    /// As a text, metadata with numbers that no reader would accept.
    pub fn to_csv(&self) -> Result<String, String> {
        check_metadata(&self.metadata)?;
        let first_line = serde_json::to_string(&FirstLine {
            metadata: &self.metadata,
            rows: Some(self.len()),
        })
        .map_err(|error| error.to_string())?;
        let (names, columns): (Vec<&str>, Vec<&[f64]>) = self.every_column().unzip();
        let mut text = format!(
            "{MAGIC}{FORMAT_VERSION} {first_line}\n{}\n",
            names.join(",")
        );
        for row in 0..self.len() {
            for (position, series) in columns.iter().enumerate() {
                if position > 0 {
                    text.push(',');
                }
                // Debug is the shortest form that reads back to the same bits, with an exponent where
                // Display would write hundreds of zeros.
                let _ = write!(text, "{:?}", series[row]);
            }
            text.push('\n');
        }
        Ok(text)
    }

    /// Reads a CSV file written by [`Recording::write_csv`] or by another program in that form.
    ///
    /// # Errors
    /// Names the file and, where it applies, the line and column, the cause and the remedy.
    pub fn read_csv(path: impl AsRef<Path>) -> Result<Self, RecordingError> {
        let path = path.as_ref();
        if path.is_dir() {
            let such_as = recording_in(path);
            return Err(RecordingError::Folder {
                path: path.to_owned(),
                such_as: such_as.map_or_else(String::new, |p| format!(", such as {}", p.display())),
            });
        }
        let bytes = std::fs::read(path).map_err(|source| RecordingError::Io {
            path: path.to_owned(),
            action: "read",
            source,
        })?;
        let foreign = |reason: &str| RecordingError::Foreign {
            path: path.to_owned(),
            reason: reason.to_owned(),
        };
        let truncated = |reason| RecordingError::Truncated {
            path: path.to_owned(),
            reason,
        };
        if bytes.is_empty() {
            return Err(foreign("the file is empty"));
        }
        let text = String::from_utf8(bytes).map_err(|_| foreign("it is not a text file"))?;
        // Spreadsheets put a byte order mark in front.
        let first_line = text
            .strip_prefix('\u{feff}')
            .unwrap_or(&text)
            .strip_prefix(MAGIC)
            .ok_or_else(|| foreign("its first line is not `# gaitshift-recording 1 {...}`"))?;
        let (first_line, table) = first_line
            .split_once('\n')
            .ok_or_else(|| truncated("it ends within its first line".to_owned()))?;
        let (version, json) = first_line.split_once(' ').unwrap_or((first_line, ""));
        if version.trim_end() != FORMAT_VERSION {
            return Err(RecordingError::Version {
                path: path.to_owned(),
                found: version.trim_end().to_owned(),
            });
        }
        let bad_metadata = |reason| RecordingError::Metadata {
            path: path.to_owned(),
            reason,
        };
        let FirstLine { metadata, rows }: FirstLine<RecordingMetadata> =
            serde_json::from_str(json).map_err(|error| bad_metadata(error.to_string()))?;
        check_metadata(&metadata).map_err(bad_metadata)?;
        if table.is_empty() {
            return Err(truncated("it has no header".to_owned()));
        }

        let mut recording = Recording::new(metadata);
        recording.read_table(path, table)?;
        if let Some(rows) = rows
            && rows != recording.len()
        {
            return Err(truncated(format!(
                "it has {} rows where its first line announces {rows}",
                recording.len()
            )));
        }
        // Without this a number cut in its last digits would pass for a shorter one.
        if !table.ends_with('\n') {
            return Err(truncated(
                "its last line does not end in a line break".to_owned(),
            ));
        }
        Ok(recording)
    }

    /// Appends the rows of `table`: a header line and lines of numbers.
    fn read_table(&mut self, path: &Path, table: &str) -> Result<(), RecordingError> {
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .from_reader(table.as_bytes());
        let header = reader.headers().map_err(|error| csv_error(path, &error))?;
        let fields = fields_of_columns(path, header)?;
        let details = fields_of_details(path, header)?;
        let extra = fields_of_extra(path, header)?;
        let mut own = vec![Vec::new(); extra.len()];
        // Kept apart until the end: each of them may be there or not.
        let mut detailed = vec![Vec::new(); DETAILS.len()];
        let mut row = vec![0.0; COLUMNS.len()];
        for record in reader.records() {
            let record = record.map_err(|error| csv_error(path, &error))?;
            let line = file_line(record.position());
            let number = |field: usize, column: &str| {
                // The csv reader has made sure that the record is as long as the header.
                let text = record.get(field).unwrap_or_default();
                text.parse::<f64>().map_err(|_| RecordingError::NotANumber {
                    path: path.to_owned(),
                    line,
                    column: column.to_owned(),
                    text: text.to_owned(),
                })
            };
            let bad_row = |source| RecordingError::Row {
                path: path.to_owned(),
                line,
                source,
            };
            for ((value, &field), &column) in row.iter_mut().zip(&fields).zip(COLUMNS) {
                *value = number(field, column)?;
            }
            self.push_row(&row).map_err(bad_row)?;
            for &(detail, field) in &details {
                let column = DETAILS[detail];
                let value = number(field, column)?;
                detailed[detail].push(finite(column, value).map_err(bad_row)?);
            }
            for ((column, field), series) in extra.iter().zip(&mut own) {
                let value = number(*field, column)?;
                series.push(finite(column, value).map_err(bad_row)?);
            }
        }
        self.details = detailed;
        let names = extra.into_iter().map(|(column, _)| column);
        self.extra = names.zip(own).collect();
        Ok(())
    }
}

fn finite(column: &str, value: f64) -> Result<f64, RowError> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(RowError::NotFinite {
        column: column.to_owned(),
        value,
    })
}

/// Says what is wrong with the numbers of the metadata, if anything.
fn check_metadata(metadata: &RecordingMetadata) -> Result<(), String> {
    let positive = [
        ("control_period_s", metadata.control_period_s),
        ("total_mass_kg", metadata.total_mass_kg),
        ("leg_length_m", metadata.leg_length_m),
    ];
    let gravity = metadata.gravity_m_per_s2;
    if !(gravity.is_finite() && gravity >= 0.0) {
        return Err(format!(
            "`gravity_m_per_s2` is {gravity} and must be 0 or greater and finite"
        ));
    }
    match positive
        .iter()
        .find(|(_, value)| !(value.is_finite() && *value > 0.0))
    {
        Some((name, value)) => Err(format!(
            "`{name}` is {value} and must be positive and finite"
        )),
        None => Ok(()),
    }
}

/// For each column of [`COLUMNS`] the position of its field in a line of the file.
fn fields_of_columns(
    path: &Path,
    header: &csv::StringRecord,
) -> Result<Vec<usize>, RecordingError> {
    let mut fields = Vec::with_capacity(COLUMNS.len());
    let mut missing = Vec::new();
    for &column in COLUMNS {
        let mut matching = (0..header.len()).filter(|&field| &header[field] == column);
        match (matching.next(), matching.next()) {
            (Some(field), None) => fields.push(field),
            (None, _) => missing.push(column),
            (Some(_), Some(_)) => {
                return Err(RecordingError::DuplicateColumn {
                    path: path.to_owned(),
                    column: column.to_owned(),
                });
            }
        }
    }
    if missing.is_empty() {
        Ok(fields)
    } else {
        Err(RecordingError::MissingColumns {
            path: path.to_owned(),
            columns: missing,
        })
    }
}

/// Those of [`DETAILS`] that the file has, each with the position of its field in a line.
fn fields_of_details(
    path: &Path,
    header: &csv::StringRecord,
) -> Result<Vec<(usize, usize)>, RecordingError> {
    let mut fields = Vec::new();
    for (detail, &column) in DETAILS.iter().enumerate() {
        let mut matching = (0..header.len()).filter(|&field| &header[field] == column);
        match (matching.next(), matching.next()) {
            (Some(field), None) => fields.push((detail, field)),
            (None, _) => {}
            (Some(_), Some(_)) => {
                return Err(RecordingError::DuplicateColumn {
                    path: path.to_owned(),
                    column: column.to_owned(),
                });
            }
        }
    }
    Ok(fields)
}

/// Columns of reward terms of one's own, each with the position of its field in a line.
fn fields_of_extra(
    path: &Path,
    header: &csv::StringRecord,
) -> Result<Vec<(String, usize)>, RecordingError> {
    let mut fields: Vec<(String, usize)> = Vec::new();
    for (field, column) in header.iter().enumerate().filter(|(_, c)| is_extra(c)) {
        if fields.iter().any(|(known, _)| known == column) {
            return Err(RecordingError::DuplicateColumn {
                path: path.to_owned(),
                column: column.to_owned(),
            });
        }
        fields.push((column.to_owned(), field));
    }
    Ok(fields)
}

/// Line in the file of a position in the table, which starts on the file's second line.
fn file_line(position: Option<&csv::Position>) -> u64 {
    position.map_or(2, |position| position.line() + 1)
}

fn csv_error(path: &Path, error: &csv::Error) -> RecordingError {
    match error.kind() {
        csv::ErrorKind::UnequalLengths {
            pos,
            expected_len,
            len,
        } => RecordingError::FieldCount {
            path: path.to_owned(),
            line: file_line(pos.as_ref()),
            found: *len,
            expected: *expected_len,
        },
        _ => RecordingError::Foreign {
            path: path.to_owned(),
            reason: error.to_string(),
        },
    }
}

/// A recording in a folder: `recording.csv`, or the first by its name.
fn recording_in(folder: &Path) -> Option<PathBuf> {
    let usual = folder.join("recording.csv");
    if usual.is_file() {
        return Some(usual);
    }
    let is_one = |path: &PathBuf| {
        let mut first = [0; MAGIC.len()];
        let read = File::open(path).and_then(|mut file| file.read_exact(&mut first));
        read.is_ok() && first == *MAGIC.as_bytes()
    };
    let entries = std::fs::read_dir(folder).ok()?;
    let mut files: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|ending| ending == "csv"))
        .collect();
    files.sort();
    files.into_iter().find(is_one)
}
