//! Replays the whole updates that PyTorch made (`tools/golden/sac_update.py`) and compares everything they left behind.

use std::path::PathBuf;

use gaitshift_nn::{Mlp, Scalar};
use gaitshift_sac::{Batch, Learner, NamedTensor, Noise, SacConfig, streams};
use safetensors::SafeTensors;
use serde::Deserialize;

#[derive(Deserialize)]
struct Header {
    observations: usize,
    actions: usize,
    updates: u64,
    config: SacConfig,
}

struct Golden<'a>(SafeTensors<'a>);

impl Golden<'_> {
    fn values<T: Scalar>(&self, name: &str) -> Vec<T> {
        let tensor = self
            .0
            .tensor(name)
            .unwrap_or_else(|_| panic!("no golden {name}"));
        let bytes = tensor.data().chunks_exact(8);
        bytes
            .map(|bytes| T::from_f64(f64::from_le_bytes(bytes.try_into().unwrap())))
            .collect()
    }

    fn scalar(&self, name: &str) -> f64 {
        self.values(name)[0]
    }

    /// The golden tensors with the names and shapes of `like`.
    fn tensors<T: Scalar>(&self, prefix: &str, like: &[NamedTensor<T>]) -> Vec<NamedTensor<T>> {
        like.iter()
            .map(|tensor| {
                let name = format!("{prefix}.{}", tensor.name);
                assert_eq!(
                    self.0.tensor(&name).unwrap().shape(),
                    tensor.shape,
                    "{name}"
                );
                NamedTensor {
                    values: self.values(&name),
                    ..tensor.clone()
                }
            })
            .collect()
    }
}

/// The largest difference relative to the largest element of the golden tensor.
fn difference<T: Scalar>(what: &str, found: &[T], golden: &[T], tolerance: f64) -> f64 {
    let scale = golden
        .iter()
        .fold(1e-3f64, |scale, value| scale.max(value.to_f64().abs()));
    let mut worst: f64 = 0.0;
    for (element, (found, golden)) in found.iter().zip(golden).enumerate() {
        let error = (found.to_f64() - golden.to_f64()).abs() / scale;
        assert!(
            error < tolerance,
            "{what}[{element}]: {found:?}, PyTorch {golden:?}"
        );
        worst = worst.max(error);
    }
    worst
}

/// Replays one recorded case; every difference must stay below `tolerance`.
pub fn replay<T: Scalar>(case: &str, tolerance: f64) {
    let path =
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("tests/golden/{case}.safetensors"));
    let bytes = std::fs::read(&path).unwrap();
    let (_, metadata) = SafeTensors::read_metadata(&bytes).unwrap();
    let header: Header =
        serde_json::from_str(&metadata.metadata().as_ref().unwrap()["golden"]).unwrap();
    let golden = Golden(SafeTensors::deserialize(&bytes).unwrap());

    let [mut init] = streams(0);
    let mut learner = Learner::<T>::new(
        header.config,
        header.observations,
        header.actions,
        None,
        &mut init,
    )
    .unwrap();
    let start = |prefix: &str, network: &mut Mlp<T>| {
        let tensors = golden.tensors(&format!("start.{prefix}"), &network.tensors());
        assert_eq!(network.load_tensors(&tensors), tensors.len());
    };
    start("actor", &mut learner.actor.network);
    for number in 0..2 {
        start(
            &format!("critic_{}", number + 1),
            &mut learner.critics[number].network,
        );
        start(
            &format!("target_{}", number + 1),
            &mut learner.targets[number],
        );
        learner.critics[number].refresh();
    }
    learner.actor.refresh();

    let mut worst: f64 = 0.0;
    for update in 1..=header.updates {
        let at = format!("update_{update}");
        let column = |name: &str| golden.values::<T>(&format!("{at}.{name}"));
        let batch = Batch {
            observations: column("observations"),
            actions: column("actions"),
            rewards: column("rewards"),
            discounts: column("discounts"),
            next_observations: column("next_observations"),
        };
        let (next, current) = (column("noise_next"), column("noise_current"));
        let stats = learner
            .update(
                &batch,
                Noise {
                    next: &next,
                    current: &current,
                },
            )
            .unwrap();

        let mut compare = |what: String, found: &[T], golden: &[T]| {
            worst = worst.max(difference(
                &format!("{case} {what}"),
                found,
                golden,
                tolerance,
            ));
        };
        let losses = stats.critic_loss.map(T::from_f64);
        compare(format!("{at} critic loss"), &losses, &column("critic_loss"));
        for (name, value) in [("actor_loss", stats.actor_loss), ("entropy", stats.entropy)] {
            compare(format!("{at} {name}"), &[T::from_f64(value)], &column(name));
        }
        compare(
            format!("{at} log alpha"),
            &[T::from_f64(learner.temperature().log_alpha)],
            &[T::from_f64(golden.scalar(&format!("{at}.log_alpha")))],
        );

        let networks = [
            ("critic_1", &learner.critics[0].network),
            ("critic_2", &learner.critics[1].network),
            ("target_1", &learner.targets[0]),
            ("target_2", &learner.targets[1]),
            ("actor", &learner.actor.network),
        ];
        let mut tensors = Vec::new();
        for (prefix, network) in networks {
            tensors.push((format!("{at}.after.{prefix}"), network.tensors()));
        }
        let critics = &learner.critics;
        tensors.push((format!("{at}.gradient.critic_1"), critics[0].gradient()));
        tensors.push((format!("{at}.gradient.critic_2"), critics[1].gradient()));
        tensors.push((format!("{at}.gradient.actor"), learner.actor.gradient()));
        for (prefix, found) in tensors {
            for (found, golden) in found.iter().zip(golden.tensors(&prefix, &found)) {
                compare(
                    format!("{prefix}.{}", found.name),
                    &found.values,
                    &golden.values,
                );
            }
        }
    }
    println!(
        "{case} in {}: largest relative difference {worst:.1e}",
        std::any::type_name::<T>()
    );
}
