//! Recordings as arrays.

use crate::convert::{from_python, os_error, to_python, value_error};
use gaitshift_analysis::recording::{
    COLUMNS, Column, Detail, RecordingError, RecordingMetadata, is_extra,
};
use gaitshift_analysis::{
    AnalysisOptions, TransitionOptions, changes_of_gait, command_changes, summarise,
    summarise_transition,
};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::{PyKeyError, PyOSError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// See `_native.pyi`.
#[pyclass(module = "gaitshift", frozen)]
pub struct Recording(pub gaitshift_analysis::Recording);

fn recording_error(error: RecordingError) -> PyErr {
    match &error {
        RecordingError::Io { path, source, .. } => os_error(source, path),
        _ => value_error(error),
    }
}

/// A column as Python gives it.
fn floats(name: &str, values: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let values: PyReadonlyArray1<'_, f64> = values.extract().map_err(|_| {
        value_error(format!(
            "column `{name}` must be a one-dimensional array of float64"
        ))
    })?;
    Ok(values.as_array().to_vec())
}

#[pymethods]
impl Recording {
    #[new]
    fn new(metadata: &Bound<'_, PyAny>, columns: &Bound<'_, PyDict>) -> PyResult<Self> {
        let metadata: RecordingMetadata =
            serde_json::from_value(from_python(metadata, "metadata")?)
                .map_err(|e| value_error(format!("`metadata`: {e}")))?;
        let mut series: Vec<Vec<f64>> = Vec::with_capacity(COLUMNS.len());
        for name in COLUMNS {
            let values = columns
                .get_item(name)?
                .ok_or_else(|| value_error(format!("`columns` has no column `{name}`")))?;
            series.push(floats(name, &values)?);
        }
        let mut details = Vec::new();
        let mut extra = Vec::new();
        for (key, values) in columns.iter() {
            let key: String = key.extract()?;
            if let Some(detail) = Detail::named(&key) {
                details.push((detail, floats(&key, &values)?));
            } else if is_extra(&key) {
                let values = floats(&key, &values)?;
                extra.push((key, values));
            } else if Column::named(&key).is_none() {
                return Err(value_error(format!(
                    "`columns` has the unknown column `{key}`; see gaitshift.COLUMNS"
                )));
            }
        }
        let rows = series[0].len();
        if let Some(k) = series.iter().position(|values| values.len() != rows) {
            return Err(value_error(format!(
                "column `{}` has {} rows, but `{}` has {rows}",
                COLUMNS[k],
                series[k].len(),
                COLUMNS[0]
            )));
        }
        let mut recording = gaitshift_analysis::Recording::new(metadata);
        let mut values = vec![0.0; COLUMNS.len()];
        for row in 0..rows {
            for (value, column) in values.iter_mut().zip(&series) {
                *value = column[row];
            }
            recording
                .push_row(&values)
                .map_err(|e| value_error(format!("row {row}: {e}")))?;
        }
        for (detail, values) in details {
            recording.set_detail(detail, values).map_err(value_error)?;
        }
        for (column, values) in extra {
            recording.set_extra(&column, values).map_err(value_error)?;
        }
        Ok(Self(recording))
    }

    #[staticmethod]
    fn read_csv(path: PathBuf) -> PyResult<Self> {
        gaitshift_analysis::Recording::read_csv(path)
            .map(Self)
            .map_err(recording_error)
    }

    fn write_csv(&self, path: PathBuf) -> PyResult<()> {
        self.0.write_csv(path).map_err(recording_error)
    }

    fn write_npz(&self, path: PathBuf) -> PyResult<()> {
        let bytes = gaitshift_export::npz(&self.0).map_err(PyOSError::new_err)?;
        gaitshift_analysis::write_whole(&path, &bytes).map_err(|e| os_error(&e, &path))
    }

    #[getter]
    fn metadata<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.0.metadata)
    }

    #[getter]
    fn columns(&self) -> Vec<&str> {
        self.0.every_column().map(|(name, _)| name).collect()
    }

    fn __len__(&self) -> usize {
        self.0.len()
    }

    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let mut columns = self.0.every_column();
        let (_, series) = columns.find(|(known, _)| *known == name).ok_or_else(|| {
            PyKeyError::new_err(format!(
                "this recording has no column `{name}`; list(recording) gives the names of those that it has"
            ))
        })?;
        Ok(PyArray1::from_slice(py, series))
    }

    #[pyo3(signature = (settling_time_s = 5.0))]
    fn summary<'py>(&self, py: Python<'py>, settling_time_s: f64) -> PyResult<Bound<'py, PyAny>> {
        if !(settling_time_s.is_finite() && settling_time_s >= 0.0) {
            return Err(value_error(format!(
                "`settling_time_s` is {settling_time_s}, but it must be 0 or greater"
            )));
        }
        let options = AnalysisOptions {
            settling_time_s,
            ..AnalysisOptions::default()
        };
        to_python(py, &summarise(&self.0, &options))
    }

    fn transition_summary<'py>(
        &self,
        py: Python<'py>,
        ramp_start_s: f64,
        ramp_end_s: f64,
    ) -> PyResult<Bound<'py, PyAny>> {
        if !(ramp_start_s.is_finite() && ramp_end_s.is_finite() && ramp_start_s <= ramp_end_s) {
            return Err(value_error(format!(
                "the ramp from {ramp_start_s} s to {ramp_end_s} s must be finite and end after it begins"
            )));
        }
        let options = TransitionOptions::default();
        let summary = summarise_transition(&self.0, ramp_start_s, ramp_end_s, &options);
        to_python(py, &summary)
    }

    fn changes_of_gait<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let ramps = command_changes(&self.0);
        let options = TransitionOptions::default();
        to_python(py, &changes_of_gait(&self.0, &ramps, &options))
    }
}
