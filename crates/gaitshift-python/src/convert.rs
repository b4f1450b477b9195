//! Between Python's dictionaries and arrays and the libraries' types.

use gaitshift_body::BodyParameters;
use gaitshift_experiment::{Controller, Experiment, did_you_mean};
use gaitshift_task::TaskParameters;
use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyUserWarning, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat, PyList, PyTuple};
use serde::{Serialize, de::DeserializeOwned};
use serde_json::Value;
use std::ffi::CString;
use std::fmt::Display;
use std::ops::RangeInclusive;
use std::path::Path;

/// Something that the caller gave cannot be used.
pub fn value_error(cause: impl Display) -> PyErr {
    PyValueError::new_err(cause.to_string())
}

/// Warns of what can be simulated but is probably not meant; so many callers up is the line that is named.
pub fn warn(py: Python<'_>, warnings: &[String], callers: i32) -> PyResult<()> {
    let category = py.get_type::<PyUserWarning>();
    warnings.iter().try_for_each(|warning| {
        let text = CString::new(warning.as_str()).map_err(value_error)?;
        PyErr::warn(py, &category, &text, callers)
    })
}

/// A value as Python's dictionaries, lists, numbers and texts.
pub fn to_python<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value).map_err(value_error)?;
    py.import("json")?.call_method1("loads", (text,))
}

/// Python's dictionaries, lists, numbers (NumPy's too) and texts as a value; `name` is what errors call it.
pub fn from_python(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Value> {
    let py = value.py();
    if let Some(place) = not_finite(value, "", DEEPEST) {
        return Err(value_error(match place.trim_start_matches('.') {
            "" => format!("`{name}`: a number is not finite"),
            place => format!("`{name}`, `{place}`: a number is not finite"),
        }));
    }
    let options = PyDict::new(py);
    options.set_item("allow_nan", false)?;
    // NumPy's arrays and numbers keep their kind: an integer stays one.
    let default = c"lambda value: value.tolist() if hasattr(value, 'tolist') else float(value)";
    options.set_item("default", py.eval(default, None, None)?)?;
    let text: String = py
        .import("json")?
        .call_method("dumps", (value,), Some(&options))
        .map_err(|e| value_error(format!("`{name}`: {}", e.value(py))))?
        .extract()?;
    serde_json::from_str(&text).map_err(|e| value_error(format!("`{name}`: {e}")))
}

/// Tables in tables that are looked into; one that holds itself has no end.
const DEEPEST: usize = 16;

/// Where in dictionaries and lists the first number that is not finite stands, after `place`.
fn not_finite(value: &Bound<'_, PyAny>, place: &str, deeper: usize) -> Option<String> {
    if let Ok(number) = value.cast::<PyFloat>() {
        return (!number.value().is_finite()).then(|| place.to_owned());
    }
    let deeper = deeper.checked_sub(1)?;
    if let Ok(table) = value.cast::<PyDict>() {
        let mut items = table.iter();
        return items
            .find_map(|(key, value)| not_finite(&value, &format!("{place}.{key}"), deeper));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let mut items = value.try_iter().ok()?.flatten().enumerate();
        return items.find_map(|(k, value)| not_finite(&value, &format!("{place}[{k}]"), deeper));
    }
    None
}

/// Parameters from a table; what it leaves out is as by default, and an unknown key is an error that names the one that was
/// probably meant.
pub fn parameters<T: DeserializeOwned>(table: Value, name: &str) -> PyResult<T> {
    serde_path_to_error::deserialize(table).map_err(|e| {
        let place = match e.path().to_string() {
            path if path == "." => format!("`{name}`"),
            path => format!("`{name}`, `{path}`"),
        };
        value_error(did_you_mean(&format!("{place}: {}", e.inner())))
    })
}

/// `base` with the keys that a dictionary replaces; an unknown key is an error that names the one that was probably meant.
pub fn with_overrides<T: Serialize + DeserializeOwned>(
    base: &T,
    overrides: Option<&Bound<'_, PyAny>>,
    name: &str,
) -> PyResult<T> {
    let mut whole = serde_json::to_value(base).map_err(value_error)?;
    if let Some(overrides) = overrides {
        overlay(&mut whole, from_python(overrides, name)?);
    }
    parameters(whole, name)
}

fn overlay(base: &mut Value, over: Value) {
    match (base, over) {
        (Value::Object(base), Value::Object(over)) => {
            for (key, value) in over {
                overlay(base.entry(key).or_insert(Value::Null), value);
            }
        }
        (base, over) => *base = over,
    }
}

/// Body and task of a recipe, an experiment file or a controller, with what dictionaries replace.
pub fn body_and_task(
    experiment: Option<&str>,
    controller: Option<&Controller>,
    body: Option<&Bound<'_, PyAny>>,
    task: Option<&Bound<'_, PyAny>>,
) -> PyResult<(gaitshift_body::Body, TaskParameters)> {
    let (base_body, base_task) = match (experiment, controller) {
        (Some(_), Some(_)) => {
            return Err(value_error(
                "both `experiment` and `controller` say what body and task are; give one of them",
            ));
        }
        (_, Some(controller)) => (controller.body.clone(), controller.task.clone()),
        (name, None) => {
            let experiment = Experiment::load(name.unwrap_or("paper")).map_err(value_error)?;
            (experiment.body, experiment.task)
        }
    };
    let changes = body;
    let body: BodyParameters = with_overrides(&base_body, changes, "body")?;
    if let Some(changes) = changes.filter(|_| body != base_body) {
        warn(changes.py(), &body.warnings(), 2)?;
    }
    let task: TaskParameters = with_overrides(&base_task, task, "task")?;
    let body = gaitshift_body::Body::new(body).map_err(value_error)?;
    task.validate(body.parameters()).map_err(value_error)?;
    Ok((body, task))
}

/// Reads a controller file.
pub fn read_controller(path: &Path) -> PyResult<Controller> {
    if Controller::is_name(path) {
        return Controller::read(path).map_err(value_error);
    }
    let path = &Controller::file_of(path);
    // The operating system's kind of error, so that a missing file is a FileNotFoundError.
    let bytes = std::fs::read(path).map_err(|e| match Controller::read(path) {
        Err(told) => std::io::Error::new(e.kind(), told.to_string()).into(),
        Ok(_) => os_error(&e, path),
    })?;
    Controller::from_bytes(&bytes, path).map_err(value_error)
}

/// The operating system's error, with the file that caused it.
pub fn os_error(error: &std::io::Error, path: &Path) -> PyErr {
    std::io::Error::new(error.kind(), format!("{}: {error}", path.display())).into()
}

/// A whole number that has to be in a range.
pub fn in_range<N>(name: &str, value: i64, range: RangeInclusive<N>) -> PyResult<N>
where
    N: TryFrom<i64> + PartialOrd + Display,
{
    N::try_from(value)
        .ok()
        .filter(|value| range.contains(value))
        .ok_or_else(|| {
            value_error(format!(
                "`{name}` is {value}, but it must be from {} to {}",
                range.start(),
                range.end()
            ))
        })
}

/// `N` finite numbers from an array.
pub fn numbers<const N: usize>(
    array: &PyReadonlyArrayDyn<'_, f64>,
    name: &str,
) -> PyResult<[f64; N]> {
    if array.shape() != [N] {
        return Err(value_error(format!(
            "`{name}` has the shape {:?}, but it must be ({N},)",
            array.shape()
        )));
    }
    let mut out = [0.0; N];
    for (out, value) in out.iter_mut().zip(array.as_array().iter()) {
        *out = *value;
    }
    match out.iter().position(|v| !v.is_finite()) {
        Some(k) => Err(value_error(format!(
            "`{name}[{k}]` is {}, but it must be finite",
            out[k]
        ))),
        None => Ok(out),
    }
}
