//! What a report is about: a controller and where it comes from.

use crate::ReportError;
use gaitshift_body::Body;
use gaitshift_experiment::{Controller, RunName, portable_path, quoted};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// A controller, the seed of its training, and the experiment of which it is a seed.
#[derive(Debug, Clone)]
pub struct Subject {
    /// Name in tables and figures.
    pub name: String,
    /// Name of the experiment: subjects of one experiment are its seeds.
    pub group: String,
    /// Seed of the training.
    pub seed: u64,
    /// The controller.
    pub controller: Controller,
    /// The body that it drives.
    pub body: Body,
    /// Folder of its run, where it has one.
    pub run: Option<PathBuf>,
    /// How it is named on a command line, quoted for a shell; nothing for the controller that comes with the program.
    pub argument: Option<String>,
    /// Least and greatest command of its run's training, where it has a run's folder.
    pub trained: Option<[f64; 2]>,
}

/// What is needed of a run's `config.toml` besides its name. Other keys are left alone, so that runs of other versions can be read.
#[derive(Deserialize, Default)]
#[serde(default)]
struct Schedule {
    curriculum: Phases,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Phases {
    phases: Vec<Commands>,
}

#[derive(Deserialize)]
struct Commands {
    omega_v: [f64; 2],
    omega_v_end: Option<[f64; 2]>,
}

impl Schedule {
    fn range(&self) -> Option<[f64; 2]> {
        let phases = &self.curriculum.phases;
        let ranges = phases.iter().map(|p| p.omega_v);
        ranges
            .chain(phases.iter().filter_map(|p| p.omega_v_end))
            .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
    }
}

impl Subject {
    /// The controller that comes with the program.
    ///
    /// # Errors
    /// Never, unless the program is damaged.
    pub fn shipped() -> Result<Self, ReportError> {
        let controller =
            Controller::shipped().map_err(|cause| ReportError::Subject(cause.to_string()))?;
        Self::new("shipped controller".to_owned(), controller)
    }

    /// A controller file, or a run's folder for the best controller in it, which is then named after experiment and seed.
    ///
    /// # Errors
    /// What is wrong with the file or the folder.
    pub fn read(path: &Path) -> Result<Self, ReportError> {
        let bad = |cause: String| ReportError::Subject(cause);
        let controller = Controller::read(path).map_err(|cause| bad(cause.to_string()))?;
        let mut name = portable_path(path).trim_end_matches('/').to_owned();
        if name.is_empty() || name == "." {
            name = format!(
                "{} {}",
                controller.provenance.experiment, controller.provenance.seed
            );
        }
        let mut subject = Self::new(name, controller)?;
        subject.argument = Some(quoted(&portable_path(path)));
        if Controller::run_of(path).is_some() {
            let run = RunName::read(path).map_err(|cause| bad(cause.to_string()))?;
            subject.is_of(run);
            subject.run = Some(path.to_owned());
            let config = path.join("config.toml");
            let schedule: Schedule = std::fs::read_to_string(&config)
                .map_err(|cause| cause.to_string())
                .and_then(|text| toml::from_str(&text).map_err(|cause| cause.to_string()))
                .map_err(|cause| bad(format!("{}: {cause}", config.display())))?;
            subject.trained = schedule.range();
        }
        Ok(subject)
    }

    /// Several of them. Runs that share a name but not their settings are told apart, since only seeds of one experiment
    /// are taken together.
    ///
    /// # Errors
    /// As [`Subject::read`].
    pub fn read_all(paths: &[PathBuf]) -> Result<Vec<Self>, ReportError> {
        let mut subjects = paths
            .iter()
            .map(|path| Self::read(path))
            .collect::<Result<Vec<_>, _>>()?;
        let runs: Vec<PathBuf> = subjects.iter().filter_map(|s| s.run.clone()).collect();
        let folders: Vec<&Path> = runs.iter().map(PathBuf::as_path).collect();
        let names =
            RunName::read_all(&folders).map_err(|cause| ReportError::Subject(cause.to_string()))?;
        let with_run = subjects.iter_mut().filter(|s| s.run.is_some());
        for (subject, of) in with_run.zip(names) {
            subject.is_of(of);
        }
        Ok(subjects)
    }

    /// Is named after its run.
    fn is_of(&mut self, run: RunName) {
        self.name = format!("{}, seed {}", run.name, run.seed);
        (self.group, self.seed) = (run.name, run.seed);
    }

    /// Its weight, in N.
    pub(crate) fn weight_n(&self) -> f64 {
        let p = self.body.parameters();
        p.total_mass_kg() * p.gravity_m_per_s2
    }

    fn new(name: String, controller: Controller) -> Result<Self, ReportError> {
        let body = Body::new(controller.body.clone())
            .map_err(|cause| ReportError::Subject(format!("{name}: {cause}")))?;
        Ok(Self {
            group: name.clone(),
            seed: controller.provenance.seed,
            name,
            controller,
            body,
            run: None,
            argument: None,
            trained: None,
        })
    }
}
