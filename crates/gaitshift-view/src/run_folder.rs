//! The folder of a training run, read while it is written: learning curve, evaluations, their controllers.

use crate::biped::Subject;
use gaitshift_analysis::GaitClass;
use gaitshift_body::Body;
use gaitshift_experiment::{Controller, Evaluation, is_finished};
use serde::Serialize;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// Points of the learning curve; episodes are averaged beyond that.
const MOST_POINTS: usize = 400;
/// Most of a file that is read at a time, in bytes; what is more comes with the next look.
const MOST_READ: u64 = 32 << 20;
/// Evaluations that are kept.
const MOST_EVALUATIONS: usize = 5000;

/// A run's folder and what has been read of it.
#[derive(Debug, Clone)]
pub(crate) struct RunView {
    folder: PathBuf,
    read: Arc<Mutex<Known>>,
}

#[derive(Debug, Default)]
struct Known {
    episodes: Tail,
    curve: Curve,
    evaluations_file: Tail,
    evaluations: Vec<ShownEvaluation>,
}

/// A text file that grows at its end.
#[derive(Debug, Default)]
struct Tail {
    offset: u64,
}

/// Means of as many episodes each as keep the number of points bounded: commands, steps and returns.
#[derive(Debug, Default)]
struct Curve {
    columns: Option<[usize; 3]>,
    per_point: usize,
    points: Vec<Point>,
    sum: Point,
}

#[derive(Debug, Default, Clone, Copy)]
struct Point {
    count: usize,
    step: f64,
    omega_v: f64,
    total_reward: f64,
}

/// What the page shows of an evaluation.
#[derive(Debug, Clone, Serialize)]
struct ShownEvaluation {
    step: u64,
    met: usize,
    criteria: usize,
    walking: Option<bool>,
    running: Option<bool>,
    /// Names of the criteria that are not met.
    unmet: Vec<String>,
    /// Whether its controller is there.
    controller: bool,
}

#[derive(Serialize)]
struct Answer<'a> {
    folder: String,
    /// Step, mean command and mean return of some episodes each.
    curve: Vec<(f64, f64, f64)>,
    evaluations: &'a [ShownEvaluation],
    finished: bool,
}

impl Tail {
    /// The whole lines that came since the last look, and whether the file was cut back before, so that all that is
    /// known of it has to go.
    fn lines(&mut self, path: &Path) -> (Vec<String>, bool) {
        let Ok(mut file) = File::open(path) else {
            return (Vec::new(), false);
        };
        let length = file.metadata().map_or(0, |m| m.len());
        let cut = length < self.offset;
        if cut {
            self.offset = 0;
        }
        let mut bytes = Vec::new();
        if file.seek(SeekFrom::Start(self.offset)).is_err()
            || file.take(MOST_READ).read_to_end(&mut bytes).is_err()
        {
            return (Vec::new(), cut);
        }
        // A line being written is left for the next look.
        let end = bytes.iter().rposition(|b| *b == b'\n').map_or(0, |k| k + 1);
        self.offset += end as u64;
        let text = String::from_utf8_lossy(&bytes[..end]);
        (text.lines().map(str::to_owned).collect(), cut)
    }
}

impl Curve {
    fn add(&mut self, line: &str) {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        let Some([step, omega_v, total]) = self.columns else {
            let at = |name| fields.iter().position(|f| *f == name);
            if let (Some(s), Some(o), Some(t)) = (at("step"), at("omega_v"), at("total_reward")) {
                self.columns = Some([s, o, t]);
            }
            return;
        };
        let number = |k: usize| fields.get(k).and_then(|f| f.parse::<f64>().ok());
        let (Some(step), Some(omega_v), Some(total)) =
            (number(step), number(omega_v), number(total))
        else {
            return;
        };
        self.sum.count += 1;
        self.sum.step += step;
        self.sum.omega_v += omega_v;
        self.sum.total_reward += total;
        if self.sum.count >= self.per_point.max(1) {
            self.points.push(std::mem::take(&mut self.sum));
        }
        if self.points.len() >= 2 * MOST_POINTS {
            self.points = self
                .points
                .chunks(2)
                .map(|pair| {
                    pair.iter().fold(Point::default(), |a, b| Point {
                        count: a.count + b.count,
                        step: a.step + b.step,
                        omega_v: a.omega_v + b.omega_v,
                        total_reward: a.total_reward + b.total_reward,
                    })
                })
                .collect();
            self.per_point = 2 * self.per_point.max(1);
        }
    }
}

impl RunView {
    pub fn new(folder: PathBuf) -> Self {
        Self {
            folder,
            read: Arc::default(),
        }
    }

    /// Where the controller of an evaluation is kept.
    fn controller(&self, step: u64) -> PathBuf {
        self.folder
            .join("controllers")
            .join(format!("step-{step:010}.safetensors"))
    }

    /// The subject of an evaluation.
    ///
    /// # Errors
    /// A step without a controller, or a controller that cannot be used.
    pub fn subject(&self, step: u64) -> Result<Subject, String> {
        let controller = Controller::read(&self.controller(step)).map_err(|e| e.to_string())?;
        Ok(Subject {
            body: Body::new(controller.body.clone()).map_err(|e| e.to_string())?,
            trained: trained_range(&self.folder),
            name: format!("step {step}"),
            controller,
            seed: None,
        })
    }

    /// The curves as JSON; what is not there yet is empty.
    pub fn json(&self) -> String {
        let mut known = match self.read.lock() {
            Ok(known) => known,
            Err(poisoned) => poisoned.into_inner(),
        };
        let known = &mut *known;
        let (lines, cut) = known.episodes.lines(&self.folder.join("episodes.csv"));
        if cut {
            known.curve = Curve::default();
        }
        lines.iter().for_each(|line| known.curve.add(line));
        let (lines, cut) = known
            .evaluations_file
            .lines(&self.folder.join("evaluations.jsonl"));
        if cut {
            known.evaluations.clear();
        }
        for line in &lines {
            if let Ok(evaluation) = Evaluation::parse(line) {
                known.evaluations.push(ShownEvaluation::of(evaluation));
            }
        }
        let too_many = known.evaluations.len().saturating_sub(MOST_EVALUATIONS);
        known.evaluations.drain(..too_many);
        for evaluation in &mut known.evaluations {
            evaluation.controller =
                evaluation.controller || self.controller(evaluation.step).exists();
        }
        let mean = |p: &Point| {
            let n = p.count as f64;
            (p.step / n, p.omega_v / n, p.total_reward / n)
        };
        let answer = Answer {
            folder: self.folder.display().to_string(),
            curve: known.curve.points.iter().map(mean).collect(),
            evaluations: &known.evaluations,
            finished: is_finished(&self.folder).unwrap_or(false),
        };
        serde_json::to_string(&answer).unwrap_or_else(|_| "{}".to_owned())
    }
}

impl ShownEvaluation {
    fn of(evaluation: Evaluation) -> Self {
        let is = |gait: GaitClass| {
            let motion = evaluation.motion(gait)?;
            Some(motion.gait == gait)
        };
        let checks = &evaluation.checks;
        Self {
            step: evaluation.step,
            met: checks.iter().filter(|check| check.met).count(),
            criteria: checks.len(),
            walking: is(GaitClass::Walking),
            running: is(GaitClass::Running),
            unmet: checks
                .iter()
                .filter(|check| !check.met)
                .map(|check| check.name.clone())
                .collect(),
            controller: false,
        }
    }
}

/// The widest range of the command in a run's curriculum, or that of the recipes.
fn trained_range(folder: &Path) -> [f64; 2] {
    let config = folder.join("config.toml");
    gaitshift_experiment::Experiment::load(&config.display().to_string())
        .ok()
        .and_then(|experiment| crate::trained_range(&experiment.curriculum))
        .unwrap_or(crate::RECIPES_RANGE)
}
