//! What a report is about: a controller and where it comes from.

use crate::ReportError;
use gaitshift_body::Body;
use gaitshift_experiment::{Controller, RunName, portable_path};
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
}

impl Subject {
    /// The controller that comes with the program.
    ///
    /// # Errors
    /// Never, unless the program is damaged.
    pub fn shipped() -> Result<Self, ReportError> {
        let controller =
            Controller::shipped().map_err(|cause| ReportError::Subject(cause.to_string()))?;
        Self::new("shipped controller".to_owned(), controller, None)
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
        let mut subject = Self::new(name, controller, None)?;
        if !Controller::is_name(path) && path.join("config.toml").is_file() {
            let run = RunName::read(path).map_err(|cause| bad(cause.to_string()))?;
            subject.name = format!("{}, seed {}", run.name, run.seed);
            (subject.group, subject.seed) = (run.name, run.seed);
            subject.run = Some(path.to_owned());
        }
        Ok(subject)
    }

    /// Its weight, in N.
    pub(crate) fn weight_n(&self) -> f64 {
        let p = self.body.parameters();
        p.total_mass_kg() * p.gravity_m_per_s2
    }

    fn new(
        name: String,
        controller: Controller,
        run: Option<PathBuf>,
    ) -> Result<Self, ReportError> {
        let body = Body::new(controller.body.clone())
            .map_err(|cause| ReportError::Subject(format!("{name}: {cause}")))?;
        Ok(Self {
            group: name.clone(),
            seed: controller.provenance.seed,
            name,
            controller,
            body,
            run,
        })
    }
}
