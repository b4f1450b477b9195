//! Can walking be optimal at all? What the paper's reward pays per control period for a recorded walk and run,
//! beside standing, at several control periods.
//!
//! At ω_v = 0 standing still earns C2 a period, with nothing to pay. A walk earns C2 + ω_l f_leg - ω_E |ΔE|, and
//! |ΔE| of a period grows with its length while f_leg does not. So there is a longest period at which this walk
//! is worth more than standing. The motions are those of a controller, by default the shipped one, acting at each
//! period; what is printed is the mean of each term from 5 s to the end.
//!
//! `cargo run --release -p gaitshift-experiment --example walk_or_stand [CONTROLLER.safetensors]`, one line of JSON
//! per motion and period.

use gaitshift_analysis::recording::{Column, column};
use gaitshift_analysis::{AnalysisOptions, summarise};
use gaitshift_body::Body;
use gaitshift_experiment::{CommandProfile, Controller, Deterministic, Rollout};
use gaitshift_task::{Environment, LegTerm, RewardParameters, TaskParameters};
use std::path::Path;

const PERIODS_S: [f64; 6] = [0.002, 0.003, 0.004, 0.005, 0.008, 0.01];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut controller = match std::env::args().nth(1) {
        Some(file) => Controller::read(Path::new(&file))?,
        None => Controller::shipped()?,
    };
    let body = Body::new(controller.body.clone())?;
    for omega_v in [0.0, 3.0] {
        for control_period_s in PERIODS_S {
            for leg_term in [LegTerm::Rates, LegTerm::Angles] {
                let task = TaskParameters {
                    control_period_s,
                    reward: RewardParameters {
                        leg_term,
                        ..RewardParameters::default()
                    },
                    ..controller.task.clone()
                };
                let recording = Rollout {
                    body: &body,
                    task: &task,
                    start: Environment::default_start(&body, &task),
                    profile: &CommandProfile::constant(omega_v),
                    duration_s: 20.0,
                    seed: 0,
                    disturbance: None,
                    controller: "",
                }
                .record(&mut Deterministic(&mut controller.policy))?;
                let from = (5.0 / control_period_s) as usize;
                let mean = |c: Column| {
                    let values = recording.column(c).get(from..).unwrap_or_default();
                    values.iter().sum::<f64>() / values.len().max(1) as f64
                };
                let terms = [
                    column::REWARD_ENERGY,
                    column::REWARD_VELOCITY,
                    column::REWARD_FORWARD,
                    column::REWARD_ALIVE,
                    column::REWARD_LEG,
                ]
                .map(mean);
                let total: f64 = terms.iter().sum();
                let summary = summarise(&recording, &AnalysisOptions::default());
                let line = serde_json::json!({
                    "omega_v": omega_v,
                    "control_period_s": control_period_s,
                    "leg_term": leg_term,
                    "gait": summary.gait,
                    "froude": summary.froude,
                    "energy": terms[0],
                    "velocity": terms[1],
                    "leg": terms[4],
                    "reward": total,
                    "more_than_standing": total - task.reward.c2,
                    "energy_change_w": -terms[0] / task.reward.omega_e / control_period_s,
                });
                println!("{line}");
            }
        }
    }
    Ok(())
}
