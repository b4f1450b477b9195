//! Contract: `f_sym` (7) enters the stored reward either with the policy's mean actions or with the action that was taken,
//! against the mirrored policy's mean, weighted by `ω_s`; the rest of the reward is the same. With `"replay"` the controller
//! of a mirrored state gives the mirrored action.

use crate::common::{Until, file, unevaluated};
use gaitshift_experiment::{Controller, Symmetry, Training};
use gaitshift_sac::Agent;
use gaitshift_task::{
    ACTION_MIRROR, ACTION_SIZE, OBSERVATION_MIRROR, OBSERVATION_SIZE, RewardParameters,
};

#[test]
fn the_symmetry_term_of_means_and_of_actions_taken() {
    let root = tempfile::tempdir().unwrap();
    let run = |symmetry: Symmetry, name: &str| {
        let mut experiment = unevaluated();
        experiment.task.reward = RewardParameters::default();
        experiment.training.symmetry = symmetry;
        // Nothing is learned, so that every transition belongs to the policy of the checkpoint.
        experiment.training.learning_starts = 3000;
        let folder = root.path().join(name);
        Training::new(experiment, &folder, "test")
            .unwrap()
            .run(&mut Until::step(1000))
            .unwrap();
        let bytes = file(&folder, "checkpoint/replay.safetensors");
        let replay = safetensors::SafeTensors::deserialize(&bytes).unwrap();
        let floats = |name: &str| -> Vec<f32> {
            let data = replay.tensor(name).unwrap().data();
            data.chunks_exact(4)
                .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
                .collect()
        };
        let rows = [floats("observations"), floats("actions"), floats("rewards")];
        let agent = Agent::load(&folder.join("checkpoint/agent.safetensors")).unwrap();
        (rows, agent)
    };
    let ([observations, actions, plain], mut agent) = run(Symmetry::None, "none");
    let ([same, _, of_means], _) = run(Symmetry::Reward, "means");
    let ([_, same_actions, of_actions], _) = run(Symmetry::Action, "actions");
    assert!(observations == same && actions == same_actions);

    let omega_s = RewardParameters::default().omega_s as f32;
    let square =
        |a: &[f32], b: &[f32]| -> f32 { a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum() };
    let mut largest: f32 = 0.0;
    for (i, o) in observations
        .chunks_exact(OBSERVATION_SIZE)
        .enumerate()
        .take(900)
    {
        let mirrored: [f32; OBSERVATION_SIZE] = std::array::from_fn(|k| o[OBSERVATION_MIRROR[k]]);
        let mut mean = [0.0; ACTION_SIZE];
        let mut mirrored_mean = [0.0; ACTION_SIZE];
        agent.act_deterministic(o, &mut mean).unwrap();
        agent
            .act_deterministic(&mirrored, &mut mirrored_mean)
            .unwrap();
        let back = ACTION_MIRROR.map(|k| mirrored_mean[k]);
        let taken = &actions[i * ACTION_SIZE..(i + 1) * ACTION_SIZE];
        for (reward, own) in [(&of_means, &mean[..]), (&of_actions, taken)] {
            let term = -omega_s * square(own, &back);
            let difference = reward[i] - plain[i];
            assert!(
                (difference - term).abs() < 1e-5 * plain[i].abs().max(1.0),
                "transition {i}: {difference} instead of {term}"
            );
            largest = largest.max(term.abs());
        }
    }
    assert!(largest > 0.1, "{largest}");
}

#[test]
fn mirrored_batches_give_a_controller_that_commutes() {
    let root = tempfile::tempdir().unwrap();
    // The greatest difference between the action of a mirrored state and the mirrored action.
    let largest = |symmetry: Symmetry, name: &str| {
        let mut experiment = unevaluated();
        experiment.training.symmetry = symmetry;
        let folder = root.path().join(name);
        Training::new(experiment, &folder, "test")
            .unwrap()
            .run(&mut Until::default())
            .unwrap();
        let mut controller = Controller::read(&folder.join("controller-last.safetensors")).unwrap();
        let (mut asymmetry, mut turn): (f32, f32) = (0.0, 0.0);
        for seed in 0..50 {
            let o: [f32; OBSERVATION_SIZE] =
                std::array::from_fn(|k| ((seed * OBSERVATION_SIZE + k) as f32 * 1.7).sin());
            let image: [f32; OBSERVATION_SIZE] = std::array::from_fn(|k| o[OBSERVATION_MIRROR[k]]);
            let (mut action, mut of_image) = ([0.0; ACTION_SIZE], [0.0; ACTION_SIZE]);
            controller.policy.mean_action(&o, &mut action).unwrap();
            controller
                .policy
                .mean_action(&image, &mut of_image)
                .unwrap();
            for (index, source) in ACTION_MIRROR.into_iter().enumerate() {
                asymmetry = asymmetry.max((of_image[index] - action[source]).abs());
            }
            turn = turn.max((action[0] - action[1]).abs());
        }
        assert!(turn > 0.01, "{turn}");
        asymmetry
    };
    assert!(largest(Symmetry::Replay, "replay") < 1e-5);
    assert!(largest(Symmetry::None, "none") > 0.01);
}
