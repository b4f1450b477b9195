//! Steady motions, the stairs of the command and random starts.

use super::plan::{Plan, commands};
use crate::{ReportError, Subject};
use gaitshift_analysis::recording::{Recording, Window, column};
use gaitshift_analysis::{AnalysisOptions, GaitClass, GaitSummary, summarise};
use gaitshift_experiment::{CommandProfile, Deterministic, Rollout, Simulation};
use gaitshift_task::Environment;
use serde::{Deserialize, Serialize};

/// A steady motion under one command, or one stair of the command.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Steady {
    /// The command.
    pub omega_v: f64,
    /// Mean change of the total energy (2) within a control period, as an amount, in J.
    pub energy_change_j: Option<f64>,
    /// What the motion is.
    #[serde(flatten)]
    pub summary: GaitSummary,
}

/// A motion from a random start.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StartedMotion {
    /// The command.
    pub omega_v: f64,
    /// Seed that draws the start.
    pub seed: u64,
    /// What it is in the end.
    pub gait: GaitClass,
    /// Its mean speed, in m/s.
    pub speed_m_per_s: Option<f64>,
    /// Share of the right leg's stride on the ground.
    pub duty_factor: Option<f64>,
}

pub(super) fn record(
    subject: &mut Subject,
    profile: &CommandProfile,
    duration_s: f64,
    seed: Option<u64>,
) -> Result<Recording, ReportError> {
    let Subject {
        controller,
        body,
        name,
        ..
    } = subject;
    let recording = Rollout {
        body,
        task: &controller.task,
        start: Environment::start(body, &controller.task, seed),
        profile,
        duration_s,
        seed: seed.unwrap_or(0),
        disturbance: None,
        controller: name,
    }
    .record(&mut Deterministic(&mut controller.policy))?;
    Ok(recording)
}

pub(super) fn steady_motion(
    subject: &mut Subject,
    omega_v: f64,
    duration_s: f64,
) -> Result<Steady, ReportError> {
    let recording = record(
        subject,
        &CommandProfile::constant(omega_v),
        duration_s,
        None,
    )?;
    Ok(described(omega_v, &recording, &AnalysisOptions::default()))
}

fn described(omega_v: f64, recording: &Recording, options: &AnalysisOptions) -> Steady {
    let summary = summarise(recording, options);
    let window = summary
        .window_start_s
        .zip(summary.window_end_s)
        .and_then(|(from, to)| recording.window(from, to));
    Steady {
        omega_v,
        energy_change_j: window.and_then(|window| energy_change_j(recording, window)),
        summary,
    }
}

/// Mean |ΔE| of (2) over the periods of a window, in J.
fn energy_change_j(recording: &Recording, window: Window) -> Option<f64> {
    let total = |row: usize| -> f64 {
        [
            column::KINETIC_ENERGY_J,
            column::GRAVITATIONAL_ENERGY_J,
            column::ELASTIC_ENERGY_J,
        ]
        .iter()
        .map(|&column| recording.column(column)[row])
        .sum()
    };
    let changes: Vec<f64> = (window.start_row()..window.end_row())
        .map(|row| (total(row + 1) - total(row)).abs())
        .collect();
    gaitshift_analysis::statistics::mean(&changes)
}

/// One motion whose command climbs stairs and comes down again.
pub(super) fn stairs(
    subject: &mut Subject,
    plan: &Plan,
) -> Result<(Vec<Steady>, Vec<Steady>), ReportError> {
    let [top, step, hold_s] = plan.stairs;
    let mut up = commands([0.0, top, step]);
    let first = up.first().copied().unwrap_or_default();
    let Subject {
        controller, body, ..
    } = subject;
    let task = controller.task.clone();
    let start = Environment::default_start(body, &task);
    let mut simulation = Simulation::new(body, &task, start, first);
    simulation.record_details();
    let options = AnalysisOptions {
        settling_time_s: 0.4 * hold_s,
        ..AnalysisOptions::default()
    };
    let mut stair = |omega_v: f64| -> Result<Option<Steady>, ReportError> {
        let mut recording = Recording::new(simulation.metadata("", 0));
        let mut row = Vec::new();
        for _ in 0..(hold_s / simulation.control_period_s()).round() as u64 {
            if simulation
                .step(omega_v, None, &mut Deterministic(&mut controller.policy))
                .is_some()
            {
                return Ok(None);
            }
            simulation.detailed_row(&mut row);
            recording.push_row(&row)?;
        }
        Ok(Some(described(omega_v, &recording, &options)))
    };
    let mut climb = |commands: &[f64]| -> Result<Vec<Steady>, ReportError> {
        let mut rows = Vec::new();
        for &omega_v in commands {
            match stair(omega_v)? {
                Some(row) => rows.push(row),
                None => break,
            }
        }
        Ok(rows)
    };
    let risen = climb(&up)?;
    if risen.len() < up.len() {
        return Ok((risen, Vec::new()));
    }
    up.reverse();
    let fallen = climb(&up)?;
    Ok((risen, fallen))
}

pub(super) fn random_starts(
    subject: &mut Subject,
    plan: &Plan,
) -> Result<Vec<StartedMotion>, ReportError> {
    let mut motions = Vec::new();
    for omega_v in commands([0.0, plan.stairs[0], plan.starts_step]) {
        for seed in 1..=plan.starts {
            let profile = CommandProfile::constant(omega_v);
            let recording = record(subject, &profile, 20.0, Some(seed))?;
            let options = AnalysisOptions {
                settling_time_s: 10.0,
                ..AnalysisOptions::default()
            };
            let summary = summarise(&recording, &options);
            motions.push(StartedMotion {
                omega_v,
                seed,
                gait: summary.gait,
                speed_m_per_s: summary.speed_m_per_s,
                duty_factor: summary.duty_factor_right,
            });
        }
    }
    Ok(motions)
}
