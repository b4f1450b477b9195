//! What the terms of an experiment's reward earn in motions that are known: how large they are beside each other.

use crate::config::Experiment;
use crate::simulation::Simulation;
use crate::{Controller, ControllerError, Deterministic};
use gaitshift_body::Body;
use gaitshift_task::{Environment, RewardTerms};

/// The terms of a reward in a motion of the shipped controller.
#[derive(Debug, Clone, PartialEq)]
pub struct Earned {
    /// The command, in s/m.
    pub omega_v: f64,
    /// How long it moved, in s: up to [`Earned::LONG_S`].
    pub duration_s: f64,
    /// Whether a fall or a rule of the task ended it.
    pub ended: bool,
    /// Name of each term and its mean in a control period, before the common factor; without those that are 0 at every command.
    pub terms: Vec<(String, f64)>,
}

impl Earned {
    /// How long it moves, in s.
    pub const LONG_S: f64 = 10.0;
}

/// Moves the experiment's body by the shipped controller, at the commands at which a gait is judged, and takes the mean of each
/// term of the reward that holds at the end of the last phase. A controller that is yet to be trained will earn something else; the order
/// of magnitude is what this tells.
///
/// # Errors
/// As [`Controller::shipped`].
pub fn earned(experiment: &Experiment) -> Result<Vec<Earned>, ControllerError> {
    let mut controller = Controller::shipped()?;
    // A body that cannot be is told elsewhere.
    let Ok(body) = Body::new(experiment.body.clone()) else {
        return Ok(Vec::new());
    };
    let last = experiment.curriculum.total_steps().saturating_sub(1);
    let settings = experiment.curriculum.at(last, &experiment.task.reward);
    let mut task = experiment.task.clone();
    task.reward = settings.reward;
    let judged = experiment.criteria.gaits.iter().map(|gait| gait.omega_v);
    let mut commands: Vec<f64> = judged.collect();
    if commands.is_empty() {
        commands.extend(settings.omega_v);
    }
    commands.sort_by(f64::total_cmp);
    commands.dedup();
    let start = Environment::start(&body, &task, None);
    let names: Vec<String> = (RewardTerms::NAMES.into_iter())
        .chain(task.reward.extra.names())
        .map(str::to_owned)
        .collect();
    let mut motions: Vec<Earned> = Vec::new();
    for omega_v in commands {
        let mut simulation = Simulation::new(&body, &task, start, omega_v);
        let mut sums = vec![0.0; names.len()];
        let (mut periods, mut ended) = (0_u32, false);
        while simulation.time_s() < Earned::LONG_S && !ended {
            let mut control = Deterministic(&mut controller.policy);
            ended = simulation.step(omega_v, None, &mut control).is_some();
            let terms = simulation.terms();
            for (sum, value) in sums
                .iter_mut()
                .zip(terms.values().iter().chain(&terms.extra))
            {
                *sum += value;
            }
            periods += 1;
        }
        let mean = |sum: f64| sum / f64::from(periods.max(1));
        motions.push(Earned {
            omega_v,
            duration_s: simulation.time_s(),
            ended,
            terms: names
                .iter()
                .cloned()
                .zip(sums.into_iter().map(mean))
                .collect(),
        });
    }
    let earns = |name: &String| {
        let mut all = motions.iter().flat_map(|motion| &motion.terms);
        all.any(|(other, value)| other == name && *value != 0.0)
    };
    let earning: Vec<String> = names.into_iter().filter(earns).collect();
    for motion in &mut motions {
        motion.terms.retain(|(name, _)| earning.contains(name));
    }
    Ok(motions)
}
