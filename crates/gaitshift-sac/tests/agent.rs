//! An agent is the same run bit for bit
//!
//! - with 1, 2 and 4 threads, with every option on,
//! - when the seed is the same, and another when it is not,
//! - whether or not it was saved, dropped, loaded and resumed on the way, replay buffer included.
//!
//! Its acting noise is standard normal. Divergence is reported, an update allocates nothing, settings out of range are refused by name.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use gaitshift_sac::{
    Agent, Mirror, NamedTensor, Rehearsal, ReplayBuffer, SacConfig, SacError, Temperature,
    Transitions, UpdateStats,
};

/// Counts the allocations of each thread.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: passes everything on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: passed on from the caller.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: passed on from the caller.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const OBSERVATIONS: usize = 3;
const ACTIONS: usize = 2;
const ENVIRONMENTS: usize = 4;

fn mirror() -> Mirror {
    Mirror {
        observation: vec![(1, 1.0), (0, 1.0), (2, -1.0)],
        action: vec![(1, 1.0), (0, 1.0)],
    }
}

fn config(threads: usize) -> SacConfig {
    SacConfig {
        actor_hidden: vec![20, 33],
        critic_hidden: vec![40, 17],
        critic_layer_norm: true,
        learning_rate: 1e-3,
        batch_size: 200,
        n_step: 3,
        temperature: Temperature::Auto {
            initial: 0.2,
            target_entropy: None,
            learning_rate: 1e-3,
        },
        threads,
        ..SacConfig::default()
    }
}

/// A task of no interest whose every number depends on the actions, so that no difference stays hidden.
struct Task {
    states: Vec<f32>,
    steps: u64,
}

impl Task {
    fn new() -> Self {
        Self {
            states: (0..ENVIRONMENTS * OBSERVATIONS)
                .map(|index| (index as f32).sin())
                .collect(),
            steps: 0,
        }
    }

    fn step(&mut self, agent: &mut Agent, replay: &mut ReplayBuffer) {
        let (mut actions, mut log_probs) = ([0.0; ENVIRONMENTS * ACTIONS], [0.0; ENVIRONMENTS]);
        agent
            .act(&self.states, &mut actions, &mut log_probs)
            .unwrap();
        let mut next = [0.0; ENVIRONMENTS * OBSERVATIONS];
        let mut rewards = [0.0; ENVIRONMENTS];
        for environment in 0..ENVIRONMENTS {
            for index in 0..OBSERVATIONS {
                let place = environment * OBSERVATIONS + index;
                let action = actions[environment * ACTIONS + index % ACTIONS];
                next[place] =
                    0.8 * self.states[place] + 0.3 * action + 0.05 * (self.steps as f32).cos();
                rewards[environment] -= next[place] * next[place];
            }
        }
        self.steps += 1;
        let at = |every: u64| -> [bool; ENVIRONMENTS] {
            std::array::from_fn(|environment| {
                (self.steps + environment as u64).is_multiple_of(every)
            })
        };
        replay
            .push(Transitions {
                observations: &self.states,
                actions: &actions,
                log_probs: &log_probs,
                rewards: &rewards,
                next_observations: &next,
                terminated: &at(11),
                truncated: &at(17),
                valid: &at(23).map(|gap| !gap),
            })
            .unwrap();
        self.states.copy_from_slice(&next);
    }
}

/// Everything that a run leaves behind, as bits.
fn run(
    agent: &mut Agent,
    replay: &mut ReplayBuffer,
    task: &mut Task,
    steps: usize,
) -> Vec<UpdateStats> {
    (0..steps)
        .map(|_| {
            task.step(agent, replay);
            agent.update(replay).unwrap()
        })
        .collect()
}

fn bits(tensors: &[NamedTensor<f32>]) -> Vec<u32> {
    tensors
        .iter()
        .flat_map(|tensor| tensor.values.iter().map(|value| value.to_bits()))
        .collect()
}

fn parameters(agent: &Agent) -> Vec<u32> {
    let learner = agent.learner();
    let mut all = bits(&agent.policy().tensors());
    for (critic, target) in learner.critics.iter().zip(&learner.targets) {
        all.extend(bits(&critic.network.tensors()));
        all.extend(bits(&target.tensors()));
    }
    all
}

fn rehearsal() -> Rehearsal {
    let numbers = |count: usize| (0..count).map(|k| (0.7 * k as f32).sin()).collect();
    Rehearsal::new(
        OBSERVATIONS,
        ACTIONS,
        numbers(90 * OBSERVATIONS),
        numbers(90 * ACTIONS),
    )
    .unwrap()
}

fn start(threads: usize, seed: u64) -> (Agent, ReplayBuffer, Task) {
    let mut agent =
        Agent::new(config(threads), OBSERVATIONS, ACTIONS, Some(mirror()), seed).unwrap();
    agent.rehearse(rehearsal(), 70).unwrap();
    agent.set_rehearsal_weight(0.7).unwrap();
    let replay = ReplayBuffer::new(600, ENVIRONMENTS, OBSERVATIONS, ACTIONS).unwrap();
    (agent, replay, Task::new())
}

#[test]
fn threads_do_not_change_a_bit() {
    let results = [1, 2, 4].map(|threads| {
        let (mut agent, mut replay, mut task) = start(threads, 1);
        let stats = run(&mut agent, &mut replay, &mut task, 200);
        (stats, parameters(&agent), task.states)
    });
    assert!(results[0] == results[1] && results[0] == results[2]);
}

#[test]
fn the_seed_decides() {
    let results = [1, 1, 2].map(|seed| {
        let (mut agent, mut replay, mut task) = start(1, seed);
        run(&mut agent, &mut replay, &mut task, 30);
        parameters(&agent)
    });
    assert!(results[0] == results[1] && results[0] != results[2]);
}

#[test]
fn a_resumed_run_goes_on_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let (agent_path, replay_path) = (
        folder.path().join("agent.safetensors"),
        folder.path().join("replay.safetensors"),
    );
    // Stopped before and after the ring of 150 rows wraps, at odd and even updates.
    for pause in [31, 170] {
        let (mut agent, mut replay, mut task) = start(1, 3);
        let mut stats = run(&mut agent, &mut replay, &mut task, pause);
        agent.save(&agent_path).unwrap();
        replay.save(&replay_path).unwrap();
        stats.extend(run(&mut agent, &mut replay, &mut task, 40));

        let (mut resumed, mut loaded, mut again) = start(1, 3);
        let mut resumed_stats = run(&mut resumed, &mut loaded, &mut again, pause);
        let mut resumed = Agent::load(&agent_path).unwrap();
        let mut loaded = ReplayBuffer::load(&replay_path).unwrap();
        assert_eq!(resumed.updates(), pause as u64);
        assert_eq!(resumed.mirror(), Some(&mirror()));
        assert_eq!(resumed.config(), &config(1));
        assert_eq!(resumed.rehearsal(), Some(&rehearsal()));
        assert_eq!(resumed.rehearsal_weight(), 0.7);
        resumed_stats.extend(run(&mut resumed, &mut loaded, &mut again, 40));
        assert_eq!(stats, resumed_stats);
        assert!(parameters(&agent) == parameters(&resumed));
        assert_eq!(task.states, again.states);
    }
}

#[test]
fn saving_twice_gives_the_same_file() {
    let folder = tempfile::tempdir().unwrap();
    let (mut agent, mut replay, mut task) = start(1, 4);
    run(&mut agent, &mut replay, &mut task, 5);
    let bytes = ["a", "b"].map(|name| {
        let path = folder.path().join(name);
        agent.save(&path).unwrap();
        std::fs::read(path).unwrap()
    });
    assert!(bytes[0] == bytes[1]);
}

#[test]
fn rates_and_weights_can_be_changed_on_the_way() {
    let (mut agent, mut replay, mut task) = start(1, 5);
    run(&mut agent, &mut replay, &mut task, 3);
    agent.set_learning_rate(1e-9).unwrap();
    agent.set_gamma(0.5).unwrap();
    let before = parameters(&agent);
    let first = agent.policy().tensors()[0].values[0];
    run(&mut agent, &mut replay, &mut task, 1);
    assert!(before != parameters(&agent));
    assert!((agent.policy().tensors()[0].values[0] - first).abs() < 1e-7);
    assert!(agent.set_learning_rate(-1.0).is_err());
    assert!(agent.set_gamma(1.5).is_err());
    // The temperature is learned here and cannot be set.
    assert!(agent.set_alpha(0.1).is_err());
    let fixed = SacConfig {
        temperature: Temperature::Fixed { alpha: 0.2 },
        ..config(1)
    };
    let mut agent = Agent::new(fixed, OBSERVATIONS, ACTIONS, Some(mirror()), 1).unwrap();
    agent.set_alpha(0.05).unwrap();
    assert_eq!(agent.alpha(), 0.05);
    assert_eq!(agent.update(&replay).unwrap().alpha, 0.05);
    assert!(agent.set_alpha(f64::NAN).is_err());
}

#[test]
fn acting_noise_is_white_and_standard_normal() {
    let mut agent = Agent::new(SacConfig::default(), OBSERVATIONS, ACTIONS, None, 5).unwrap();
    let observations = [0.0; ENVIRONMENTS * OBSERVATIONS];
    let (mut actions, mut log_probs) = ([0.0; ENVIRONMENTS * ACTIONS], [0.0; ENVIRONMENTS]);
    // The policy's own means, then the logarithms of its deviations, at the one observation.
    let network = &agent.learner().actor.network;
    let mut activations = network.activations(1);
    network.forward(
        1,
        &observations[..OBSERVATIONS],
        OBSERVATIONS,
        &mut activations,
    );
    let (means, log_deviations) = activations.out[..2 * ACTIONS].split_at(ACTIONS);
    let mut noise = Vec::new();
    for _ in 0..5000 {
        agent
            .act(&observations, &mut actions, &mut log_probs)
            .unwrap();
        for row in actions.chunks(ACTIONS) {
            for (action, (mean, log_deviation)) in row.iter().zip(means.iter().zip(log_deviations))
            {
                let drawn = f64::from(*action).atanh() - f64::from(*mean);
                noise.push(drawn / f64::from(*log_deviation).exp());
            }
        }
    }
    // Within four standard errors of what independent normal numbers have.
    let near = |what: &str, values: &mut dyn Iterator<Item = f64>, expected: f64, variance: f64| {
        let (mut sum, mut count) = (0.0, 0.0);
        for value in values {
            (sum, count) = (sum + value, count + 1.0);
        }
        let (found, error) = (sum / count, f64::sqrt(variance / count));
        assert!(
            (found - expected).abs() < 4.0 * error,
            "{what}: {found}, but {expected} with an error of {error} is expected"
        );
    };
    near("mean", &mut noise.iter().copied(), 0.0, 1.0);
    near("variance", &mut noise.iter().map(|e| e * e), 1.0, 2.0);
    for (limit, share) in [(1.0, 0.317_311), (2.0, 0.045_500), (3.0, 0.002_700)] {
        let mut beyond = noise.iter().map(|e| f64::from(u8::from(e.abs() > limit)));
        near("tails", &mut beyond, share, share * (1.0 - share));
    }
    // Between the actions of a row, between environments, and from one step to the next.
    for lag in [1, ACTIONS, ENVIRONMENTS * ACTIONS] {
        let pairs = noise.iter().zip(&noise[lag..]);
        near("correlation", &mut pairs.map(|(a, b)| a * b), 0.0, 1.0);
    }
}

#[test]
fn divergence_is_an_error_that_says_so() {
    let config = SacConfig {
        learning_rate: 1e30,
        critic_layer_norm: false,
        ..config(1)
    };
    let mut agent = Agent::new(config, OBSERVATIONS, ACTIONS, Some(mirror()), 1).unwrap();
    let (mut healthy, mut replay, mut task) = start(1, 6);
    run(&mut healthy, &mut replay, &mut task, 20);
    let error = (0..50).find_map(|_| agent.update(&replay).err()).unwrap();
    assert!(matches!(error, SacError::Diverged { .. }), "{error}");
    assert!(error.to_string().contains("a lower learning rate"));
    let folder = tempfile::tempdir().unwrap();
    assert!(
        agent.save(&folder.path().join("diverged")).is_err(),
        "a broken agent must not replace a good one"
    );
}

#[test]
fn nothing_is_allocated_after_the_start() {
    let (mut agent, mut replay, mut task) = start(1, 7);
    run(&mut agent, &mut replay, &mut task, 20);
    let (mut actions, mut log_probs) = ([0.0; ENVIRONMENTS * ACTIONS], [0.0; ENVIRONMENTS]);
    let before = ALLOCATIONS.with(Cell::get);
    for _ in 0..20 {
        task.step(&mut agent, &mut replay);
        // A phase that moves the learner's settings sets them at every step.
        agent.set_learning_rate(1e-3).unwrap();
        agent.set_gamma(0.98).unwrap();
        agent.update(&replay).unwrap();
        agent
            .act(&task.states, &mut actions, &mut log_probs)
            .unwrap();
        agent.act_deterministic(&task.states, &mut actions).unwrap();
    }
    assert_eq!(ALLOCATIONS.with(Cell::get) - before, 0);
    let counted = ALLOCATIONS.with(Cell::get);
    drop(Box::new(1u8));
    assert!(ALLOCATIONS.with(Cell::get) > counted, "the count works");
}

#[test]
fn wrong_use_is_an_error() {
    let (mut agent, replay, _) = start(1, 8);
    assert!(matches!(agent.update(&replay), Err(SacError::EmptyReplay)));
    let other = ReplayBuffer::new(10, 1, OBSERVATIONS + 1, ACTIONS).unwrap();
    assert!(matches!(agent.update(&other), Err(SacError::Length { .. })));
    assert!(agent.act(&[0.0; 3], &mut [0.0; 2], &mut [0.0; 2]).is_err());
    assert!(agent.act_deterministic(&[0.0; 3], &mut [0.0; 3]).is_err());
    assert!(agent.act_deterministic(&[0.0; 4], &mut [0.0; 2]).is_err());
}
