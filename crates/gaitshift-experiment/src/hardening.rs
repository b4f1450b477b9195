//! A controller learns to withstand pushes that it falls from, by imitating ways to withstand them that a search finds. In every
//! round, motions are pushed at random; where the controller falls, the cross-entropy method looks for offsets to its commands with which
//! it does not; then it is fitted to what was done with them and, so that it keeps what it can do, to what it did before.
//!
//! A round follows from the state before it and its number alone, so that the result depends neither on the threads nor on
//! whether it was stopped and continued.

mod before;
mod case;
mod search;
mod state;

use crate::acceptance::judge;
use crate::controller::{Controller, Deterministic};
use crate::criteria::Criteria;
use crate::durable;
use crate::parallel::in_parallel;
use crate::provenance::Provenance;
use crate::run_folder::RunFolder;
use crate::training::task_mirror;
use crate::training_error::{TrainingError, io_error};
use case::{Case, NO_OFFSETS, Pairs};
use gaitshift_body::Body;
use gaitshift_sac::{Imitation, Mirror, Policy, Rehearsal};
use gaitshift_task::{ACTION_SIZE, OBSERVATION_SIZE, OMEGA_V_MAX};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Motions of the controller so far, for so many of the one that it was, whose states are remembered in a round.
const MOTIONS_NOW: f64 = 0.15;
/// What is imitated of a push, in s from its begin.
const IMITATED_S: f64 = 2.0;
/// Rounds whose ways are imitated.
const ROUNDS_IMITATED: usize = 20;
/// Rate of Adam's steps at the begin of a round and at its end, and pairs of each kind in a step.
const LEARNING_RATE: [f64; 2] = [1e-3, 1e-4];
const ROWS: usize = 128;
/// Weights of what it did before, of found ways, and of what it withstood.
const WEIGHTS: [f64; 3] = [1.0, 4.0, 1.0];

/// What is to be withstood, and how thoroughly that is learned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HardeningPlan {
    /// Commands at which it is pushed, each as likely.
    pub omega_v: Vec<f64>,
    /// Ranges of the push's impulse in N s, each as likely; positive is forward. It lasts 0.1 s.
    pub impulse_n_s: Vec<[f64; 2]>,
    /// Pushes in a round.
    pub pushes: usize,
    /// Seed of everything random.
    pub seed: u64,
    /// Motions of the controller as it was, of 10 s each, whose states it is to answer as before.
    pub motions: usize,
    /// Steps of Adam in a round.
    pub steps: usize,
    /// Pushes by which the controllers of all rounds are compared, none of them one of a round's.
    pub compared: usize,
}

impl Default for HardeningPlan {
    fn default() -> Self {
        Self {
            omega_v: vec![0.0],
            impulse_n_s: vec![[20.0, 36.0], [-36.0, -20.0]],
            pushes: 80,
            seed: 1,
            motions: 400,
            steps: 4000,
            compared: 128,
        }
    }
}

impl HardeningPlan {
    /// Checks every value; the error is a sentence.
    ///
    /// # Errors
    /// The first value that is out of its range.
    pub fn validate(&self) -> Result<(), String> {
        let command = |w: &f64| w.abs() <= OMEGA_V_MAX;
        if self.omega_v.is_empty() || !self.omega_v.iter().all(command) {
            return Err(format!(
                "the commands are {:?}, but must be at least one, each between -100 and 100",
                self.omega_v
            ));
        }
        let range = |[from, to]: &[f64; 2]| from <= to && from.abs().max(to.abs()) <= 1000.0;
        if self.impulse_n_s.is_empty() || !self.impulse_n_s.iter().all(range) {
            return Err(format!(
                "the impulses are {:?} N s, but must be at least one range from a smaller to a greater one, none above 1000",
                self.impulse_n_s
            ));
        }
        for (what, number, most) in [
            ("pushes in a round", self.pushes, 10_000),
            ("motions", self.motions, 10_000),
            ("steps of a round", self.steps, 1_000_000),
            ("pushes to compare by", self.compared, 10_000),
        ] {
            if !(1..=most).contains(&number) {
                return Err(format!(
                    "the number of {what} is {number}, but it must be between 1 and {most}"
                ));
            }
        }
        Ok(())
    }
}

/// What a round came to.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct HardeningRound {
    /// Its number, from 1; 0 is the controller as it was.
    pub round: usize,
    /// Pushed motions of the round: those that fell undisturbed are none.
    pub pushed: usize,
    /// How many of them the controller withstood alone, before the round's fitting.
    pub alone: usize,
    /// For how many of the others a way was found.
    pub found: usize,
    /// Motions tried for that.
    pub tried: usize,
    /// mean |μ(s) − a|² over found ways at the end of the fitting.
    pub found_loss: f64,
    /// The same over what the controller did before.
    pub before_loss: f64,
    /// How many of the pushes by which all rounds are compared the fitted controller withstands.
    pub withstood: usize,
    /// How many these are.
    pub compared: usize,
    /// Criteria that it meets, on flat ground and undisturbed.
    pub met: usize,
    /// Their number.
    pub criteria: usize,
    /// Whether it is the best so far: it meets at least as many criteria as the controller did at first, and withstands more than
    /// any best one before.
    pub best: bool,
    /// Wall-clock so far, in s.
    pub elapsed_s: f64,
}

/// A controller that is being hardened, and the folder that holds what came of it: `controller.safetensors` is the best so far,
/// `controller-last.safetensors` that of the last round, `rounds.jsonl` has a [`HardeningRound`] a line, and `state.safetensors` is what
/// the next round begins with.
#[derive(Debug)]
pub struct Hardening {
    plan: HardeningPlan,
    /// As it was.
    original: Controller,
    body: Body,
    criteria: Criteria,
    folder: PathBuf,
    /// Keeps other processes away.
    _lock: Option<File>,
    command: String,
    threads: usize,
    mirror: Mirror,
    /// Where the controller is the mean of a policy and its mirror image, that policy is fitted.
    is_mean: bool,
    policy: Policy,
    before: Pairs,
    /// Ways that were found, and what the controller did where it fell not, round by round.
    found: Vec<Pairs>,
    alone: Vec<Pairs>,
    rounds: Vec<HardeningRound>,
}

impl Hardening {
    /// Begins in `folder`, or goes on with what it holds.
    ///
    /// # Errors
    /// A plan that cannot be followed; a folder that holds something else, or that cannot be written.
    pub fn new(
        original: Controller,
        plan: HardeningPlan,
        folder: &Path,
        threads: usize,
        command: &str,
    ) -> Result<Self, TrainingError> {
        plan.validate()
            .map_err(|cause| TrainingError::other(folder, cause))?;
        let body = Body::new(original.body.clone())
            .map_err(|e| TrainingError::other(folder, e.to_string()))?;
        std::fs::create_dir_all(folder).map_err(io_error(folder))?;
        let lock = RunFolder::at(folder).lock()?;
        let mirror = task_mirror();
        let half = original.policy.without_mirror_image(&mirror);
        let mut hardening = Self {
            is_mean: half.is_some(),
            policy: half.unwrap_or_else(|| original.policy.clone()),
            plan,
            original,
            body,
            criteria: Criteria::default(),
            folder: folder.to_owned(),
            _lock: lock,
            command: command.to_owned(),
            threads,
            mirror,
            before: Pairs::default(),
            found: Vec::new(),
            alone: Vec::new(),
            rounds: Vec::new(),
        };
        if hardening.restore()? {
            // A kill may have come between the state and what is made of it, of which the rounds are the last.
            let written = std::fs::read_to_string(hardening.rounds_path());
            if written.ok() != Some(hardening.lines()?) {
                hardening.publish()?;
            }
        } else {
            hardening.require_empty()?;
            hardening.finish(HardeningRound::default(), Instant::now())?;
        }
        Ok(hardening)
    }

    /// The rounds so far; the first is the controller as it was.
    pub fn rounds(&self) -> &[HardeningRound] {
        &self.rounds
    }

    /// The best controller so far.
    pub fn best_path(&self) -> PathBuf {
        self.folder.join("controller.safetensors")
    }

    /// A round.
    ///
    /// # Errors
    /// A folder that cannot be written, or a fit that diverges.
    pub fn round(&mut self) -> Result<&HardeningRound, TrainingError> {
        let clock = Instant::now();
        let number = self.rounds.len();
        if self.before.rows() == 0 {
            self.before = self.motions(self.plan.motions, true, &self.original.policy, 0);
        }
        let policy = self.judged();
        let pushes = in_parallel(self.threads, self.plan.pushes, |index| {
            let mut rng = self.stream(number, index);
            let mut policy = policy.clone();
            let case = self.case(&mut policy, &mut rng)?;
            let alone = case.withstood(&mut policy, &NO_OFFSETS);
            let (offsets, tried) = if alone {
                (Some(NO_OFFSETS), 0)
            } else {
                search::search(&case, &mut policy, &mut rng)
            };
            let mut pairs = Pairs::default();
            if let Some(offsets) = &offsets {
                let recorded = Some((&mut pairs, IMITATED_S));
                case.up_s(&mut policy, offsets, IMITATED_S, recorded);
            }
            Some((alone, pairs, tried))
        });
        let mut round = HardeningRound {
            round: number,
            ..HardeningRound::default()
        };
        let (mut found, mut own) = (Pairs::default(), Pairs::default());
        for (alone, pairs, tried) in pushes.into_iter().flatten() {
            round.pushed += 1;
            round.tried += tried;
            if alone {
                round.alone += 1;
                own.append(&pairs);
            } else if pairs.rows() > 0 {
                round.found += 1;
                found.append(&pairs);
            }
        }
        for (rounds, pairs) in [(&mut self.found, found), (&mut self.alone, own)] {
            rounds.push(pairs);
            if rounds.len() > ROUNDS_IMITATED {
                rounds.remove(0);
            }
        }
        let motions = (MOTIONS_NOW * self.plan.motions as f64).ceil() as usize;
        let now = self.motions(motions, false, &policy, number);
        [round.before_loss, round.found_loss, _] = self.fit(&now, number)?;
        self.finish(round, clock)?;
        Ok(&self.rounds[number])
    }

    /// Fits the policy to what is remembered: what it did before, found ways, and what it withstood. Gives their last losses.
    fn fit(&mut self, now: &Pairs, number: usize) -> Result<[f64; 3], TrainingError> {
        let joined = |rounds: &[Pairs]| {
            let mut all = Pairs::default();
            rounds.iter().for_each(|pairs| all.append(pairs));
            all
        };
        let mut before = self.before.clone();
        before.append(now);
        let all = [before, joined(&self.found), joined(&self.alone)];
        let (mut kinds, mut remembered) = (Vec::new(), Vec::new());
        for (kind, pairs) in all.into_iter().enumerate() {
            // A round in which nothing falls, or everything does, leaves a kind empty.
            if pairs.rows() > 0 {
                kinds.push(kind);
                remembered.push(Rehearsal::new(
                    OBSERVATION_SIZE,
                    ACTION_SIZE,
                    pairs.observations,
                    pairs.actions,
                )?);
            }
        }
        let weights = kinds.iter().map(|&kind| WEIGHTS[kind]);
        let sets: Vec<(&Rehearsal, f64)> = remembered.iter().zip(weights).collect();
        let mirror = self.is_mean.then(|| self.mirror.clone());
        let mut imitation = Imitation::new(&self.policy, mirror, ROWS)?;
        let mut rng = self.stream(number, usize::MAX);
        let mut losses = [0.0; 3];
        let steps = self.plan.steps;
        let averaged = steps.div_ceil(10);
        for step in 0..steps {
            let share = step as f64 / steps as f64;
            let rate = LEARNING_RATE[0] + (LEARNING_RATE[1] - LEARNING_RATE[0]) * share;
            let step_losses = imitation.step(&sets, rate, &mut rng)?;
            if step + averaged >= steps {
                for (&kind, loss) in kinds.iter().zip(&step_losses) {
                    losses[kind] += loss / averaged as f64;
                }
            }
        }
        self.policy = imitation.policy();
        Ok(losses)
    }

    /// Compares the controller with those before it, and writes everything.
    fn finish(&mut self, mut round: HardeningRound, clock: Instant) -> Result<(), TrainingError> {
        let mut controller = self.controller();
        let withstood = in_parallel(self.threads, self.plan.compared, |index| {
            // Those of no round: as many as there can be are before.
            let mut rng = self.stream(usize::MAX, index);
            let mut policy = controller.policy.clone();
            let case = self.case(&mut policy, &mut rng);
            case.is_some_and(|case| case.withstood(&mut policy, &NO_OFFSETS))
        });
        round.compared = withstood.len();
        round.withstood = withstood.into_iter().filter(|up| *up).count();
        let mut control = Deterministic(&mut controller.policy);
        let judgement = judge(
            &self.body,
            &self.original.task,
            &self.criteria,
            &mut control,
        )
        .map_err(|e| TrainingError::other(&self.folder, e.to_string()))?;
        round.met = judgement.met();
        round.criteria = judgement.checks.len();
        let most = self
            .rounds
            .iter()
            .filter(|r| r.best)
            .map(|r| r.withstood)
            .max();
        let met_at_first = self.rounds.first().map_or(0, |first| first.met);
        round.best = round.met >= met_at_first && most.is_none_or(|most| round.withstood > most);
        let earlier_s = self.rounds.last().map_or(0.0, |last| last.elapsed_s);
        round.elapsed_s = earlier_s + clock.elapsed().as_secs_f64();
        self.rounds.push(round);
        // The state first: what is made from it can be made again.
        self.save()?;
        self.publish()
    }

    /// Writes what others read of the state: the last round's controller, which may be the best, and the rounds.
    fn publish(&self) -> Result<(), TrainingError> {
        let controller = self.controller();
        controller.write(&self.folder.join("controller-last.safetensors"))?;
        if self.rounds.last().is_some_and(|last| last.best) {
            controller.write(&self.best_path())?;
        }
        let path = self.rounds_path();
        durable::write(&path, self.lines()?.as_bytes()).map_err(io_error(&path))
    }

    fn rounds_path(&self) -> PathBuf {
        self.folder.join("rounds.jsonl")
    }

    /// The rounds, a line each.
    fn lines(&self) -> Result<String, TrainingError> {
        let mut lines = String::new();
        for round in &self.rounds {
            let line = serde_json::to_string(round)
                .map_err(|e| TrainingError::other(&self.folder, e.to_string()))?;
            lines += &line;
            lines.push('\n');
        }
        Ok(lines)
    }

    /// A push of the plan, drawn by `rng`; nothing if the body falls before it.
    fn case(&self, policy: &mut Policy, rng: &mut Xoshiro256PlusPlus) -> Option<Case> {
        let (plan, task) = (&self.plan, &self.original.task);
        Case::draw(
            policy,
            &self.body,
            task,
            &plan.omega_v,
            &plan.impulse_n_s,
            rng,
        )
    }

    /// The policy that acts.
    fn judged(&self) -> Policy {
        if self.is_mean {
            self.policy.mean_with_mirror_image(&self.mirror)
        } else {
            self.policy.clone()
        }
    }

    fn controller(&self) -> Controller {
        let original = &self.original.provenance;
        Controller {
            policy: self.judged(),
            body: self.original.body.clone(),
            task: self.original.task.clone(),
            provenance: Provenance {
                command: self.command.clone(),
                seed: self.plan.seed,
                version: env!("CARGO_PKG_VERSION").to_owned(),
                ..original.clone()
            },
        }
    }

    fn motions(&self, count: usize, disturbed: bool, policy: &Policy, number: usize) -> Pairs {
        let motions = in_parallel(self.threads, count, |index| {
            let seed = self.plan.seed ^ (number as u64) << 32 ^ (index as u64) << 8 ^ 0x6265;
            before::motion(&self.original, policy, &self.body, disturbed, index, seed)
        });
        let mut all = Pairs::default();
        motions.iter().for_each(|pairs| all.append(pairs));
        all
    }

    /// The random numbers of one task of a round.
    fn stream(&self, number: usize, index: usize) -> Xoshiro256PlusPlus {
        let mixed = (number as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
            ^ (index as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
        Xoshiro256PlusPlus::seed_from_u64(self.plan.seed ^ mixed)
    }
}
