//! What moves: a controller, the body it drives and the start; and the motions asked for.

use crate::arguments::{ChangeArguments, SubjectArguments};
use crate::failure::Failure;
use crate::{disturb, output, render};
use gaitshift_analysis::recording::{Recording, RecordingError};
use gaitshift_body::{Body, BodyParameters, BodyState};
use gaitshift_experiment::{
    CommandProfile, Controller, Deterministic, Rollout, load_body_overrides, portable_path,
    set_body_and_task,
};
use gaitshift_task::{Disturbance, Environment, OMEGA_V_MAX, TaskParameters};
use std::path::Path;

/// A controller on a body, ready to move.
#[derive(Debug)]
pub struct Subject {
    controller: Controller,
    body: Body,
    /// The controller as messages and recordings name it.
    pub name: String,
    /// What the user changed of its body and task, each after a comma.
    changes: String,
    start: BodyState,
    seed: Option<u64>,
    disturbance: Option<Disturbance>,
}

/// A controller's file, or the best one of a run's folder; without a path the shipped one.
pub fn load_controller(path: Option<&Path>) -> Result<Controller, Failure> {
    let controller = match path {
        Some(path) => Controller::read(path),
        None => Controller::shipped(),
    };
    if let (Some(path), Ok(_)) = (path, &controller) {
        note_if_unevaluated(path);
    }
    controller.map_err(Failure::input)
}

/// Says that what stands for a run is its last controller, where it has no best one yet.
pub fn note_if_unevaluated(path: &Path) {
    if Controller::is_unevaluated(path) {
        output::note(&format!(
            "{}: not evaluated yet, so there is no best controller; this is that of the last checkpoint",
            path.display()
        ));
    }
}

impl Subject {
    /// Loads what the user asked for, at the default start.
    pub fn load(arguments: &SubjectArguments) -> Result<Self, Failure> {
        Self::of(arguments.which.controller.as_deref(), &arguments.changes)
    }

    /// A controller's file, or a run's folder, or the shipped controller, changed as the user asks, at the default start.
    pub fn of(path: Option<&Path>, changes: &ChangeArguments) -> Result<Self, Failure> {
        let name = match path {
            Some(path) => path.display().to_string(),
            None => "the shipped controller".to_owned(),
        };
        Self::new(load_controller(path)?, name, changes)
    }

    /// A controller on its own body and task, changed as the user asks.
    pub fn new(
        mut controller: Controller,
        name: String,
        changes: &ChangeArguments,
    ) -> Result<Self, Failure> {
        let (body, task) = changed(&controller.body, &controller.task, changes)?;
        controller.task = task;
        let body = Body::new(body).map_err(Failure::input)?;
        let start = Environment::default_start(&body, &controller.task);
        let file = changes
            .body
            .iter()
            .map(|path| format!(", body of {}", path.display()));
        let values = changes.set.iter().map(|value| format!(", {value}"));
        Ok(Self {
            controller,
            body,
            name,
            changes: file.chain(values).collect(),
            start,
            seed: None,
            disturbance: None,
        })
    }

    /// Disturbs every motion from now on, and puts the start on the ground of the disturbance.
    pub fn disturb(&mut self, disturbance: Option<Disturbance>) {
        if let Some(disturbance) = &disturbance {
            self.body = disturbance.place(self.body.clone());
        }
        self.disturbance = disturbance;
        self.start_at(self.seed);
    }

    /// What disturbs the motions, if anything.
    pub fn disturbance(&self) -> Option<&Disturbance> {
        self.disturbance.as_ref()
    }

    /// What is changed of the body and what disturbs the motions, in words after a comma.
    pub fn circumstances(&self) -> String {
        let words = self.disturbance.as_ref().map(disturb::describe);
        let disturbed = words.map_or_else(String::new, |words| format!(", {words}"));
        format!("{}{disturbed}", self.changes)
    }

    /// Begins motions at the start that a seed draws, or at the default start.
    pub fn start_at(&mut self, seed: Option<u64>) {
        let task = &self.controller.task;
        self.seed = seed;
        self.start = Environment::start(&self.body, task, seed);
    }

    /// The controller.
    pub fn controller(&self) -> &Controller {
        &self.controller
    }

    /// The body that moves.
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// Body, task and policy without noise, for whatever moves them by itself.
    pub fn parts(&mut self) -> (&Body, &TaskParameters, Deterministic<'_>) {
        let policy = Deterministic(&mut self.controller.policy);
        (&self.body, &self.controller.task, policy)
    }

    /// For a live stage, with the range of the command that the controller was trained for.
    pub fn for_view(self, trained: [f64; 2]) -> gaitshift_view::Subject {
        gaitshift_view::Subject {
            controller: self.controller,
            body: self.body,
            name: self.name,
            trained,
            seed: self.seed,
        }
    }

    /// Where motions start, in words.
    pub fn start_name(&self) -> String {
        start_words(self.seed.as_slice())
    }

    /// Moves under `profile` for `duration_s` or until it falls.
    pub fn record(
        &mut self,
        profile: &CommandProfile,
        duration_s: f64,
    ) -> Result<Recording, Failure> {
        let Self {
            controller,
            body,
            name,
            changes: _,
            start,
            seed,
            disturbance,
        } = self;
        Rollout {
            body,
            task: &controller.task,
            start: *start,
            profile,
            duration_s,
            seed: seed.unwrap_or(0),
            disturbance: disturbance.as_ref(),
            controller: &portable_path(Path::new(name)),
        }
        .record(&mut Deterministic(&mut controller.policy))
        .map_err(Failure::run)
    }
}

/// Body and task with the user's changes; says what about a changed body is probably not meant.
pub fn changed(
    body: &BodyParameters,
    task: &TaskParameters,
    changes: &ChangeArguments,
) -> Result<(BodyParameters, TaskParameters), Failure> {
    let new = match &changes.body {
        Some(path) => {
            let new = load_body_overrides(path, body).map_err(Failure::input)?;
            // The controller's period has to fit the integration step that the file may change; with --set it is checked below.
            if changes.set.is_empty() {
                task.validate(&new).map_err(|e| {
                    Failure::input(format!("{}: with this body {e}", path.display()))
                })?;
            }
            new
        }
        None => body.clone(),
    };
    let (new, task) = set_body_and_task(&new, task, &changes.set).map_err(Failure::input)?;
    if new != *body {
        for warning in new.warnings() {
            output::note(&format!("warning: {warning}"));
        }
    }
    Ok((new, task))
}

/// Reads the command over time from a file.
pub fn read_profile(path: &Path) -> Result<CommandProfile, Failure> {
    let profile = CommandProfile::read_csv(path).map_err(Failure::input)?;
    let (low, high) = profile.range();
    if low < -OMEGA_V_MAX || high > OMEGA_V_MAX {
        return Err(Failure::input(format!(
            "{}: `omega_v` reaches from {low} to {high}, but it must stay between -{OMEGA_V_MAX} and \
             {OMEGA_V_MAX}",
            path.display()
        )));
    }
    if profile.end_s() > 3600.0 {
        return Err(Failure::input(format!(
            "{}: `time_s` reaches to {} s, but a motion lasts at most 3600 s",
            path.display(),
            profile.end_s()
        )));
    }
    Ok(profile)
}

/// Writes a recording as it is.
pub fn write_csv(recording: &Recording, path: &Path) -> Result<(), Failure> {
    recording.write_csv(path).map_err(|error| match error {
        RecordingError::Io { path, source, .. } => Failure::write(&path, &source),
        other => Failure::run(other),
    })
}

/// Writes a recording into a folder and gives its path. Pictures of an older recording that it takes the place of, which
/// `gaitshift render` put beside that, are removed: they would show another motion than the file.
pub fn write_recording(
    recording: &Recording,
    folder: &Path,
    name: &str,
) -> Result<std::path::PathBuf, Failure> {
    let path = folder.join(name);
    let old = std::fs::read(&path).ok();
    write_csv(recording, &path)?;
    if old.is_some_and(|old| std::fs::read(&path).is_ok_and(|new| new != old)) {
        for picture in render::pictures_beside(&path) {
            if std::fs::remove_file(&picture).is_ok() {
                let picture = picture.display();
                output::note(&format!(
                    "removed {picture}, a picture of the recording that was replaced"
                ));
            }
        }
    }
    Ok(path)
}

/// Where motions start that begin at what these seeds draw; at the default start if there are none.
pub fn start_words(seeds: &[u64]) -> String {
    match seeds {
        [] => "default start".to_owned(),
        [seed] => format!("random start {seed}"),
        several => format!("{} random starts", several.len()),
    }
}
