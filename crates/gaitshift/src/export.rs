//! `gaitshift export`: body, controller and recording for other programs.

use crate::arguments::{ControllerArguments, ExportArguments, ExportFormat};
use crate::evaluate::criteria;
use crate::failure::Failure;
use crate::gaits::read_recording;
use crate::motion::{changed, load_controller, write_csv};
use crate::output;
use gaitshift_analysis::Recording;
use gaitshift_body::Body;
use gaitshift_experiment::{Controller, Deterministic, judge};
use gaitshift_task::Disturbance;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};

/// Runs the command.
pub fn run(arguments: &ExportArguments) -> Result<(), Failure> {
    match &arguments.format {
        ExportFormat::Mjcf {
            changes,
            disturbances,
            which,
            out,
        } => {
            let controller = controller_file(which);
            for input in [&controller, &changes.body, &disturbances.disturbance] {
                not_over(input.as_deref(), out.as_deref())?;
            }
            // The body of the controller that `export onnx` exports: a policy belongs to the body it was trained on.
            let c = load_controller(which.controller.as_deref())?;
            let (parameters, task) = changed(&c.body, &c.task, changes)?;
            let text = gaitshift_export::mjcf(&parameters, &task, &disturbances.read()?)
                .map_err(Failure::input)?;
            put(text.as_bytes(), out.as_deref())
        }
        ExportFormat::Onnx { which, out } => {
            not_over(controller_file(which).as_deref(), out.as_deref())?;
            let controller = load_controller(which.controller.as_deref())?;
            let bytes = gaitshift_export::onnx(&controller).map_err(Failure::run)?;
            put_binary(&bytes, out.as_deref())
        }
        ExportFormat::Hub {
            which,
            license,
            out,
        } => hub(which, license.as_deref(), out),
        ExportFormat::Csv { recording, out } => {
            not_over(Some(recording), out.as_deref())?;
            let recording = read(recording)?;
            // Written anew, so that unknown columns are gone and the order is the documented one.
            match out {
                Some(path) => {
                    output::create_folder_of(path)?;
                    write_csv(&recording, path)?;
                    output::written(std::slice::from_ref(path))
                }
                None => put(recording.to_csv().map_err(Failure::run)?.as_bytes(), None),
            }
        }
        ExportFormat::Html { recording, out } => {
            not_over(Some(recording), out.as_deref())?;
            let html = gaitshift_view::replay_html(&read(recording)?)
                .map_err(|e| Failure::input(format!("{}: {e}", recording.display())))?;
            put(html.as_bytes(), out.as_deref())
        }
        ExportFormat::Npz { recording, out } => {
            not_over(Some(recording), out.as_deref())?;
            let bytes = gaitshift_export::npz(&read(recording)?).map_err(Failure::run)?;
            put_binary(&bytes, out.as_deref())
        }
    }
}

/// Writes a folder for a model hub.
fn hub(which: &ControllerArguments, licence: Option<&str>, out: &Path) -> Result<(), Failure> {
    const FILE: &str = "controller.safetensors";
    let path = which.controller.as_deref();
    let holds = |names: [&str; 2]| names.iter().all(|name| out.join(name).exists());
    let whose = if holds(["config.toml", "checkpoint"]) {
        Some("a run's")
    } else if holds(["state.safetensors", "rounds.jsonl"]) {
        Some("a hardening's")
    } else {
        None
    };
    if let Some(whose) = whose {
        return Err(Failure::input(format!(
            "{} is {whose} folder, whose best controller would be replaced; give another --out",
            out.display()
        )));
    }
    for name in [FILE, "controller.onnx", "body.xml", "README.md"] {
        not_over(controller_file(which).as_deref(), Some(&out.join(name)))?;
    }
    // Better now than after the evaluation.
    output::create_folder(out)?;
    let mut controller = load_controller(path)?;
    let (criteria, _) = criteria(None, path)?;
    let body = Body::new(controller.body.clone()).map_err(Failure::input)?;
    let mut policy = Deterministic(&mut controller.policy);
    let judgement = judge(&body, &controller.task, &criteria, &mut policy).map_err(Failure::run)?;
    let card =
        gaitshift_export::card(&controller, &judgement, FILE, licence).map_err(Failure::input)?;
    let mjcf = gaitshift_export::mjcf(&controller.body, &controller.task, &Disturbance::default());
    let files = [
        ("README.md", card.into_bytes()),
        (FILE, controller.to_bytes().map_err(Failure::run)?),
        (
            "controller.onnx",
            gaitshift_export::onnx(&controller).map_err(Failure::run)?,
        ),
        ("body.xml", mjcf.map_err(Failure::input)?.into_bytes()),
    ];
    for (name, bytes) in files {
        let path = out.join(name);
        output::file(&path, &bytes)?;
        output::written(&[path])?;
    }
    Ok(())
}

/// The file that is read where a controller is given.
fn controller_file(which: &ControllerArguments) -> Option<PathBuf> {
    which.controller.as_deref().map(Controller::file_of)
}

/// Refuses to write over a file that is read, where both are there.
fn not_over(read: Option<&Path>, out: Option<&Path>) -> Result<(), Failure> {
    read.zip(out)
        .map_or(Ok(()), |(read, out)| output::not_over(read, out))
}

fn read(path: &Path) -> Result<Recording, Failure> {
    read_recording(path)
}

/// Bytes that no terminal should be shown.
fn put_binary(bytes: &[u8], out: Option<&Path>) -> Result<(), Failure> {
    if out.is_none() && io::stdout().is_terminal() {
        return Err(Failure::input(
            "this format is binary; give a file with --out FILE, or redirect standard output",
        ));
    }
    put(bytes, out)
}

/// To a file, or to standard output.
fn put(bytes: &[u8], out: Option<&Path>) -> Result<(), Failure> {
    match out {
        Some(path) => {
            output::create_folder_of(path)?;
            output::file(path, bytes)?;
            output::written(&[path.to_owned()])
        }
        None => {
            let mut output = io::stdout();
            output.write_all(bytes)?;
            // At the program's end nobody would hear of what cannot be written.
            Ok(output.flush()?)
        }
    }
}
