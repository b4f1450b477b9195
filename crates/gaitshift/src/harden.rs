//! `gaitshift harden`: a controller learns to withstand pushes and steps that it falls from.

use crate::arguments::{HardenArguments, distinct_commands};
use crate::failure::Failure;
use crate::motion::load_controller;
use crate::output;
use crate::progress::duration;
use crate::train::catch_interrupts;
use gaitshift_experiment::{Hardening, HardeningOutcomes, HardeningPlan, HardeningRound, quoted};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Duration;

#[derive(Serialize)]
struct Outcome<'a> {
    /// Folder.
    folder: String,
    /// The best controller.
    controller: String,
    /// What was asked for.
    plan: &'a HardeningPlan,
    /// The controller as it was, then every round.
    rounds: &'a [HardeningRound],
}

/// Runs the command.
pub fn run(arguments: &HardenArguments) -> Result<(), Failure> {
    let a = arguments;
    let mut plan = HardeningPlan {
        pushes: a.pushes,
        hidden_units: a.hidden_units,
        seed: a.seed,
        ..HardeningPlan::with_steps_up(a.steps_up)
    };
    if !a.omega_v.is_empty() {
        plan.omega_v = distinct_commands(&a.omega_v).map_err(Failure::input)?;
    }
    if !a.impulse.is_empty() {
        plan.impulse_n_s.clone_from(&a.impulse);
    }
    if !a.step_height.is_empty() {
        plan.step_up_m.clone_from(&a.step_height);
    }
    if !a.step_omega_v.is_empty() {
        plan.step_omega_v = distinct_commands(&a.step_omega_v).map_err(Failure::input)?;
    }
    plan.validate().map_err(Failure::input)?;
    let controller = load_controller(a.which.controller.as_deref())?;
    let threads = a.threads.count();
    let folder = a.out.clone().unwrap_or_else(|| PathBuf::from("out/harden"));
    let interrupted = catch_interrupts("stopping after this round")?;
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(4));
    if let Ok(style) = ProgressStyle::with_template("{spinner:.cyan} {msg}, {elapsed}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(250));
    bar.set_message("meeting the controller as it is");
    let hardening = Hardening::new(controller, plan.clone(), &folder, threads, &a.command);
    let mut hardening = hardening.map_err(Failure::input)?;
    let say = |round: &HardeningRound| match a.print.json {
        true => Ok(()),
        false => bar.suspend(|| output::line(&row(round))),
    };
    if !a.print.json {
        bar.suspend(|| header(&plan))?;
        hardening.rounds().iter().try_for_each(say)?;
    }
    while hardening.rounds().len() <= a.rounds && !interrupted.load(Ordering::SeqCst) {
        bar.set_message(format!(
            "round {} of {}",
            hardening.rounds().len(),
            a.rounds
        ));
        say(hardening.round().map_err(Failure::run)?)?;
    }
    bar.finish_and_clear();
    let controller = hardening.best_path();
    if a.print.json {
        output::json(&Outcome {
            folder: folder.to_string_lossy().into_owned(),
            controller: controller.to_string_lossy().into_owned(),
            plan: &plan,
            rounds: hardening.rounds(),
        })?;
    } else {
        describe(hardening.rounds(), &controller.to_string_lossy())?;
    }
    match interrupted.load(Ordering::SeqCst) && hardening.rounds().len() <= a.rounds {
        true => {
            output::note("stopped; the same command goes on");
            Err(Failure::Interrupted)
        }
        false => Ok(()),
    }
}

fn header(plan: &HardeningPlan) -> Result<(), Failure> {
    let (of, others) = match plan.steps_up {
        0 => (format!("{} pushes", plan.pushes), "pushes"),
        steps => (
            format!("{} pushes and {steps} steps", plan.pushes),
            "pushes and steps",
        ),
    };
    let what = format!(
        "Of {of} in a round: how many the controller withstands alone, and for how many others a way is found. Then, fitted to \
         these ways: how many of other {others} it withstands, in how many weakly disturbed motions it stays up, and the criteria \
         that it meets.",
    );
    output::text(&what, 0)?;
    if plan.steps_up > 0 {
        output::line("       pushes                   steps up")?;
        output::line("round  alone  found  withstood  alone  found  withstood     weak  criteria")
    } else {
        output::line("round  alone  found  withstood     weak  criteria")
    }
}

fn row(r: &HardeningRound) -> String {
    let columns = |outcomes: &HardeningOutcomes| {
        let [alone, found] = if r.round == 0 {
            [String::new(), String::new()]
        } else {
            [outcomes.alone.to_string(), outcomes.found.to_string()]
        };
        let withstood = format!("{}/{}", outcomes.withstood, outcomes.compared);
        format!("  {alone:>5}  {found:>5}  {withstood:>9}")
    };
    let steps_up = match r.steps_up.compared {
        0 => String::new(),
        _ => columns(&r.steps_up),
    };
    format!(
        "{:>5}{}{steps_up}  {:>7}  {:>8}{}",
        r.round,
        columns(&r.pushes),
        format!("{}/{}", r.weak_up, r.weak_compared),
        format!("{}/{}", r.met, r.criteria),
        if r.best && r.round > 0 { "  best" } else { "" }
    )
}

fn describe(rounds: &[HardeningRound], controller: &str) -> Result<(), Failure> {
    let best = rounds.iter().rev().find(|round| round.best);
    if let (Some(best), Some(first), Some(last)) = (best, rounds.first(), rounds.last()) {
        let kinds = [
            ("pushes", &best.pushes, &first.pushes),
            ("steps", &best.steps_up, &first.steps_up),
        ];
        let withstands: Vec<String> = kinds
            .into_iter()
            .filter(|(_, best, _)| best.compared > 0)
            .map(|(what, best, first)| {
                let (withstood, compared) = (best.withstood, best.compared);
                format!(
                    "{withstood} of {compared} {what} ({} before)",
                    first.withstood
                )
            })
            .collect();
        let outcome = format!(
            "{} {} in {}; the best, of round {}, withstands {}, stays up in {} of {} weakly disturbed motions ({} before), and meets \
             {} of {} criteria ({} before)",
            last.round,
            if last.round == 1 { "round" } else { "rounds" },
            duration(last.elapsed_s),
            best.round,
            withstands.join(" and "),
            best.weak_up,
            best.weak_compared,
            first.weak_up,
            best.met,
            best.criteria,
            first.met,
        );
        output::text(&outcome, 0)?;
    }
    output::line(&format!("controller: {controller}"))?;
    output::line(&format!(
        "what it withstands: gaitshift stress --controller {}",
        quoted(controller)
    ))
}
