//! A controller learns to withstand pushes and steps that it falls from, by imitating ways to withstand them that a search finds. In
//! every round, motions are disturbed at random; where the controller falls, or does not get over a step, the cross-entropy method
//! looks for offsets to its commands with which it does; then it is fitted to what was done with them and, so that it keeps what it
//! can do, to what it did before, also where it goes now.
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
use before::Motion;
use case::{Case, Kind, NO_OFFSETS, Offsets, Pairs, Trial};
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
const MOTIONS_NOW: f64 = 0.5;
/// What is imitated of a push or a step, in s from its begin or its first touch.
const IMITATED_S: f64 = 2.0;
/// How often a way is followed with noise beside once without: one that was found, and what the controller withstands alone.
const NOISY_FOUND: usize = 4;
const NOISY_ALONE: usize = 1;
/// Rounds whose ways are imitated.
const ROUNDS_IMITATED: usize = 20;
/// Rate of Adam's steps at the begin of a round and at its end, and pairs of each kind in a step.
const LEARNING_RATE: [f64; 2] = [1e-3, 1e-4];
const ROWS: usize = 128;
/// Weights of found ways and of what it withstood. Ways over steps fit together less well than those of pushes: with as much
/// weight they cost criteria and what is withstood of pushes.
const PUSH_FOUND_WEIGHT: f64 = 4.0;
const STEP_FOUND_WEIGHT: f64 = 1.0;
const ALONE_WEIGHT: f64 = 1.0;

/// Streams of random numbers of no round: there are not so many rounds.
const COMPARISON: usize = usize::MAX;
const WIDENING: usize = usize::MAX - 1;

/// The highest step that may be asked for, in m.
pub const STEP_UP_MAX_M: f64 = 0.2;

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
    /// Commands at which steps up are met, each as likely.
    pub step_omega_v: Vec<f64>,
    /// Ranges of a step's height in m, each as likely. Where its face is, is random.
    pub step_up_m: Vec<[f64; 2]>,
    /// Steps up in a round; may be 0.
    pub steps_up: usize,
    /// Seed of everything random.
    pub seed: u64,
    /// Motions of the controller as it was, of 10 s each, whose states it is to answer as before.
    pub motions: usize,
    /// Units that every hidden layer of the policy is to have at least. It begins as the same function in a network so wide. Where the
    /// controller is the mean of a policy and its mirror image, it has twice as many.
    pub hidden_units: usize,
    /// Steps of Adam in a round.
    pub adam_steps: usize,
    /// Weight of what the controller did before.
    pub before_weight: f64,
    /// Pushes, as many steps if a round has any, and as many weakly disturbed motions, by which the controllers of all rounds are
    /// compared, none of them one of a round's.
    pub compared: usize,
}

impl Default for HardeningPlan {
    fn default() -> Self {
        Self {
            omega_v: vec![0.0],
            impulse_n_s: vec![[20.0, 36.0], [-36.0, -20.0]],
            pushes: 80,
            step_omega_v: vec![0.0],
            step_up_m: vec![[0.005, 0.035]],
            steps_up: 0,
            seed: 1,
            motions: 400,
            hidden_units: 0,
            adam_steps: 4000,
            before_weight: 1.0,
            compared: 128,
        }
    }
}

impl HardeningPlan {
    /// Pushes, and `steps_up` steps in a round. With steps among the disturbances it takes more of the fitting to keep what the
    /// controller did before.
    #[must_use]
    pub fn with_steps_up(steps_up: usize) -> Self {
        let pushes_alone = Self::default();
        if steps_up == 0 {
            return pushes_alone;
        }
        Self {
            steps_up,
            adam_steps: 12_000,
            before_weight: 4.0,
            ..pushes_alone
        }
    }

    /// Checks every value; the error is a sentence.
    ///
    /// # Errors
    /// The first value that is out of its range.
    pub fn validate(&self) -> Result<(), String> {
        let command = |w: &f64| w.abs() <= OMEGA_V_MAX;
        for (what, omega_v) in [("", &self.omega_v), (" for steps", &self.step_omega_v)] {
            if omega_v.is_empty() || !omega_v.iter().all(command) {
                return Err(format!(
                    "the commands{what} are {omega_v:?}, but must be at least one, each between -100 and 100"
                ));
            }
        }
        let range = |[from, to]: &[f64; 2]| from <= to && from.abs().max(to.abs()) <= 1000.0;
        if self.impulse_n_s.is_empty() || !self.impulse_n_s.iter().all(range) {
            return Err(format!(
                "the impulses are {:?} N s, but must be at least one range from a smaller to a greater one, none above 1000",
                self.impulse_n_s
            ));
        }
        let height = |[from, to]: &[f64; 2]| 0.0 < *from && from <= to && *to <= STEP_UP_MAX_M;
        if self.step_up_m.is_empty() || !self.step_up_m.iter().all(height) {
            return Err(format!(
                "the heights of steps are {:?} m, but must be at least one range from a smaller to a greater one, all above 0 and \
                 none above {STEP_UP_MAX_M}",
                self.step_up_m
            ));
        }
        for (what, number, least, most) in [
            ("pushes in a round", self.pushes, 1, 10_000),
            ("steps up in a round", self.steps_up, 0, 10_000),
            ("motions", self.motions, 1, 10_000),
            ("hidden units", self.hidden_units, 0, 4096),
            ("steps of Adam in a round", self.adam_steps, 1, 1_000_000),
            ("pushes to compare by", self.compared, 1, 10_000),
        ] {
            if !(least..=most).contains(&number) {
                return Err(format!(
                    "the number of {what} is {number}, but it must be between {least} and {most}"
                ));
            }
        }
        if !(0.0..=1000.0).contains(&self.before_weight) {
            return Err(format!(
                "the weight of what the controller did before is {}, but it must be between 0 and 1000",
                self.before_weight
            ));
        }
        Ok(())
    }
}

/// What a round came to.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct HardeningRound {
    /// Its number, from 1; 0 is the controller as it was.
    pub round: usize,
    /// Of the pushes.
    pub pushes: HardeningOutcomes,
    /// Of the steps up.
    pub steps_up: HardeningOutcomes,
    /// Of the motions of 10 s by which all rounds are compared, with sensor noise, delays, slopes, steps and weak pushes: in how
    /// many the fitted controller stays up.
    pub weak_up: usize,
    /// Their number.
    pub weak_compared: usize,
    /// Motions tried by the searches.
    pub tried: usize,
    /// mean |μ(s) − a|² over what the controller did before it was hardened, at the end of the fitting.
    pub before_loss: f64,
    /// Criteria that it meets, on flat ground and undisturbed.
    pub met: usize,
    /// Their number.
    pub criteria: usize,
    /// Whether it is the best so far: it meets at least as many criteria as the controller did at first, and withstands more of
    /// what all rounds are compared by, of all kinds together, than any best one before.
    pub best: bool,
    /// Wall-clock so far, in s.
    pub elapsed_s: f64,
}

impl HardeningRound {
    /// How many of the disturbances by which all rounds are compared the fitted controller withstands.
    pub fn withstood(&self) -> usize {
        self.pushes.withstood + self.steps_up.withstood + self.weak_up
    }

    fn outcomes(&mut self, kind: Kind) -> &mut HardeningOutcomes {
        match kind {
            Kind::Push => &mut self.pushes,
            Kind::StepUp => &mut self.steps_up,
        }
    }
}

/// What is imitated of a way: what is done, and what would be done beside it, where noise has led for `noisy` times, as long as that
/// is withstood. Errors of the controller's own will lead there.
fn imitated(
    case: &Case,
    policy: &mut Policy,
    offsets: &Offsets,
    noisy: usize,
    rng: &mut Xoshiro256PlusPlus,
) -> Pairs {
    let mut pairs = case.record(policy, offsets, offsets, IMITATED_S);
    for _ in 0..noisy {
        let followed = search::with_noise(offsets, rng);
        if case.share(policy, &followed, Trial::Sample) >= 1.0 {
            pairs.append(&case.record(policy, offsets, &followed, IMITATED_S));
        }
    }
    pairs
}

/// The first `pushes` are pushes, all others steps.
fn kind(index: usize, pushes: usize) -> Kind {
    if index < pushes {
        Kind::Push
    } else {
        Kind::StepUp
    }
}

/// What disturbances of a kind came to in a round.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct HardeningOutcomes {
    /// Motions of the round that were disturbed: those that fell before are none.
    pub met: usize,
    /// How many of them the controller withstood alone, before the round's fitting.
    pub alone: usize,
    /// For how many of the others a way was found.
    pub found: usize,
    /// mean |μ(s) − a|² over remembered ways at the end of the fitting; 0 without any.
    pub found_loss: f64,
    /// How many of those by which all rounds are compared the fitted controller withstands.
    pub withstood: usize,
    /// How many these are.
    pub compared: usize,
}

/// What is remembered of disturbances of a kind, round by round.
#[derive(Debug, Default)]
struct Remembered {
    /// Ways that were found.
    found: Vec<Pairs>,
    /// What the controller did where it needed none.
    alone: Vec<Pairs>,
}

impl Remembered {
    fn begin_round(&mut self) {
        for rounds in [&mut self.found, &mut self.alone] {
            rounds.push(Pairs::default());
            if rounds.len() > ROUNDS_IMITATED {
                rounds.remove(0);
            }
        }
    }
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
    /// As it was after the best round.
    best: Policy,
    before: Pairs,
    pushes: Remembered,
    steps_up: Remembered,
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
            best: original.policy.clone(),
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
            pushes: Remembered::default(),
            steps_up: Remembered::default(),
            rounds: Vec::new(),
        };
        let mut rng = hardening.stream(WIDENING, 0);
        let units = hardening.plan.hidden_units;
        hardening.policy = hardening.policy.widened(units, &mut rng);
        if hardening.restore()? {
            // A kill may have come between the state and what is made of it, of which the rounds are the last.
            let written = std::fs::read_to_string(hardening.rounds_path());
            if written.ok() != Some(hardening.lines()?) || !hardening.holds_best() {
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
            self.before = self.motions(self.plan.motions, &self.original.policy, 0);
        }
        let policy = self.judged(&self.policy);
        let cases = self.plan.pushes + self.plan.steps_up;
        let tried = in_parallel(self.threads, cases, |index| {
            let mut rng = self.stream(number, index);
            let mut policy = policy.clone();
            let kind = kind(index, self.plan.pushes);
            let case = self.case(kind, &mut policy, &mut rng)?;
            let alone = case.withstood(&mut policy, &NO_OFFSETS);
            let (offsets, tried) = if alone {
                (Some(NO_OFFSETS), 0)
            } else {
                search::search(&case, &mut policy, &mut rng)
            };
            let pairs = offsets.map(|offsets| {
                let noisy = if alone { NOISY_ALONE } else { NOISY_FOUND };
                imitated(&case, &mut policy, &offsets, noisy, &mut rng)
            });
            Some((kind, alone, pairs, tried))
        });
        let mut round = HardeningRound {
            round: number,
            ..HardeningRound::default()
        };
        for remembered in [&mut self.pushes, &mut self.steps_up] {
            remembered.begin_round();
        }
        for (kind, alone, pairs, tried) in tried.into_iter().flatten() {
            round.tried += tried;
            let outcomes = round.outcomes(kind);
            outcomes.met += 1;
            let Some(pairs) = pairs else { continue };
            let remembered = match kind {
                Kind::Push => &mut self.pushes,
                Kind::StepUp => &mut self.steps_up,
            };
            let (number, rounds) = if alone {
                (&mut outcomes.alone, &mut remembered.alone)
            } else {
                (&mut outcomes.found, &mut remembered.found)
            };
            *number += 1;
            if let Some(now) = rounds.last_mut() {
                now.append(&pairs);
            }
        }
        let motions = (MOTIONS_NOW * self.plan.motions as f64).ceil() as usize;
        let now = self.motions(motions, &policy, number);
        [
            round.before_loss,
            round.pushes.found_loss,
            round.steps_up.found_loss,
        ] = self.fit(&now, number)?;
        self.finish(round, clock)?;
        Ok(&self.rounds[number])
    }

    /// Fits the policy to what is remembered: what it did before, found ways, and what it withstood. Gives the last losses of what it
    /// did before, of ways found for pushes, and of those found for steps.
    fn fit(&mut self, now: &Pairs, number: usize) -> Result<[f64; 3], TrainingError> {
        let joined = |rounds: &[Pairs]| {
            let mut all = Pairs::default();
            rounds.iter().for_each(|pairs| all.append(pairs));
            all
        };
        let mut before = self.before.clone();
        before.append(now);
        let all = [
            (before, self.plan.before_weight),
            (joined(&self.pushes.found), PUSH_FOUND_WEIGHT),
            (joined(&self.steps_up.found), STEP_FOUND_WEIGHT),
            (joined(&self.pushes.alone), ALONE_WEIGHT),
            (joined(&self.steps_up.alone), ALONE_WEIGHT),
        ];
        let (mut kinds, mut remembered) = (Vec::new(), Vec::new());
        for (kind, (pairs, weight)) in all.into_iter().enumerate() {
            // A round in which nothing falls, or everything does, leaves a kind empty.
            if pairs.rows() > 0 {
                kinds.push(kind);
                let (observations, actions) = (pairs.observations, pairs.actions);
                let set = Rehearsal::new(OBSERVATION_SIZE, ACTION_SIZE, observations, actions)?;
                remembered.push((set, weight));
            }
        }
        let sets: Vec<(&Rehearsal, f64)> = remembered.iter().map(|(set, w)| (set, *w)).collect();
        let mirror = self.is_mean.then(|| self.mirror.clone());
        let mut imitation = Imitation::new(&self.policy, mirror, ROWS)?;
        let mut rng = self.stream(number, usize::MAX);
        let mut losses = [0.0; 3];
        let steps = self.plan.adam_steps;
        let averaged = steps.div_ceil(10);
        for step in 0..steps {
            let share = step as f64 / steps as f64;
            let rate = LEARNING_RATE[0] * (LEARNING_RATE[1] / LEARNING_RATE[0]).powf(share);
            let step_losses = imitation.step(&sets, rate, &mut rng)?;
            if step + averaged >= steps {
                for (&kind, loss) in kinds.iter().zip(&step_losses) {
                    if let Some(sum) = losses.get_mut(kind) {
                        *sum += loss / averaged as f64;
                    }
                }
            }
        }
        self.policy = imitation.policy();
        Ok(losses)
    }

    /// Compares the controller with those before it, and writes everything.
    fn finish(&mut self, mut round: HardeningRound, clock: Instant) -> Result<(), TrainingError> {
        let mut controller = self.controller(&self.policy);
        let compared = self.plan.compared;
        let of_both = if self.plan.steps_up > 0 {
            2 * compared
        } else {
            compared
        };
        let withstood = in_parallel(self.threads, of_both, |index| {
            let mut rng = self.stream(COMPARISON, index);
            let mut policy = controller.policy.clone();
            let case = self.case(kind(index, compared), &mut policy, &mut rng);
            case.is_some_and(|case| case.withstood(&mut policy, &NO_OFFSETS))
        });
        for (index, up) in withstood.into_iter().enumerate() {
            let outcomes = round.outcomes(kind(index, compared));
            outcomes.compared += 1;
            outcomes.withstood += usize::from(up);
        }
        round.weak_compared = compared;
        round.weak_up = self.weakly_disturbed_up(&controller.policy);
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
            .map(HardeningRound::withstood)
            .max();
        let met_at_first = self.rounds.first().map_or(0, |first| first.met);
        round.best = round.met >= met_at_first && most.is_none_or(|most| round.withstood() > most);
        let earlier_s = self.rounds.last().map_or(0.0, |last| last.elapsed_s);
        round.elapsed_s = earlier_s + clock.elapsed().as_secs_f64();
        if round.best {
            self.best = self.policy.clone();
        }
        self.rounds.push(round);
        // The state first: what is made from it can be made again.
        self.save()?;
        self.publish()
    }

    /// Writes what others read of the state: the last round's controller, the best one, and the rounds.
    fn publish(&self) -> Result<(), TrainingError> {
        let last = self.controller(&self.policy);
        last.write(&self.folder.join("controller-last.safetensors"))?;
        if !self.holds_best() {
            self.controller(&self.best).write(&self.best_path())?;
        }
        let path = self.rounds_path();
        durable::write(&path, self.lines()?.as_bytes()).map_err(io_error(&path))
    }

    /// Whether the best controller is where others look for it.
    fn holds_best(&self) -> bool {
        Controller::read(&self.best_path())
            .is_ok_and(|held| held.policy.tensors() == self.judged(&self.best).tensors())
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

    /// A disturbance of the plan, drawn by `rng`; nothing if the body falls before it.
    fn case(&self, kind: Kind, policy: &mut Policy, rng: &mut Xoshiro256PlusPlus) -> Option<Case> {
        let task = &self.original.task;
        Case::draw(kind, &self.plan, policy, &self.body, task, rng)
    }

    /// The policy that acts where this one is fitted.
    fn judged(&self, policy: &Policy) -> Policy {
        if self.is_mean {
            policy.mean_with_mirror_image(&self.mirror)
        } else {
            policy.clone()
        }
    }

    fn controller(&self, policy: &Policy) -> Controller {
        let original = &self.original.provenance;
        Controller {
            policy: self.judged(policy),
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

    fn motions(&self, count: usize, policy: &Policy, number: usize) -> Pairs {
        let motions = in_parallel(self.threads, count, |index| {
            self.motion(policy, number, index).pairs
        });
        let mut all = Pairs::default();
        motions.iter().for_each(|pairs| all.append(pairs));
        all
    }

    /// In how many of the disturbed motions by which all rounds are compared the body stays up.
    fn weakly_disturbed_up(&self, policy: &Policy) -> usize {
        let disturbed: Vec<usize> = (0..)
            .filter(|&index| before::is_disturbed(index))
            .take(self.plan.compared)
            .collect();
        let fell = in_parallel(self.threads, disturbed.len(), |index| {
            self.motion(policy, COMPARISON, disturbed[index]).fell
        });
        fell.into_iter().filter(|fell| !fell).count()
    }

    fn motion(&self, policy: &Policy, number: usize, index: usize) -> Motion {
        let seed = self.plan.seed ^ (number as u64) << 32 ^ (index as u64) << 8 ^ 0x6265;
        before::motion(&self.original, policy, &self.body, index, seed)
    }

    /// The random numbers of one task of a round.
    fn stream(&self, number: usize, index: usize) -> Xoshiro256PlusPlus {
        let mixed = (number as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
            ^ (index as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
        Xoshiro256PlusPlus::seed_from_u64(self.plan.seed ^ mixed)
    }
}
