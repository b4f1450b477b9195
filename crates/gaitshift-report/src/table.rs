//! Numbers of a figure as a table.

/// A table: names of columns with their units, and rows of cells.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Table {
    /// Name of its file, without ending.
    pub name: String,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Cells; an empty one is undefined.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows.
    pub fn new(name: &str, columns: &[&str]) -> Self {
        Self {
            name: name.to_owned(),
            columns: columns.iter().map(|&c| c.to_owned()).collect(),
            rows: Vec::new(),
        }
    }

    /// As CSV, after RFC 4180.
    pub fn to_csv(&self) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        // Writing into memory does not fail; rows have as many cells as there are columns.
        let _ = writer.write_record(&self.columns);
        for row in &self.rows {
            let _ = writer.write_record(row);
        }
        let bytes = writer.into_inner().unwrap_or_default();
        String::from_utf8(bytes).unwrap_or_default()
    }
}

/// A number in the shortest form that reads back to the same bits; nothing where it is undefined.
pub(crate) fn cell(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| format!("{value:?}"))
}
