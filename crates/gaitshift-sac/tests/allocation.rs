//! What a file or a few settings name is checked before memory is taken for it.
//!
//! The allocator of this program refuses more than a gigabyte at once, as a machine without it would: the process then
//! ends with "memory allocation of … bytes failed".

use std::alloc::{GlobalAlloc, Layout, System};
use std::path::Path;

use gaitshift_sac::{Agent, MlpShape, NamedTensor, Policy, PolicyError, SacConfig, SacError};

const MOST: usize = 1 << 30;

struct Limited;

// SAFETY: passes everything on to the system's allocator, or says that there is no memory.
unsafe impl GlobalAlloc for Limited {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if layout.size() > MOST {
            return std::ptr::null_mut();
        }
        // SAFETY: passed on from the caller.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: passed on from the caller.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Limited = Limited;

/// A controller file of a few bytes that named two layers of 65,536 units took 17 GB before its tensors were looked at.
#[test]
fn a_policy_of_huge_layers_without_their_tensors() {
    let shape = MlpShape {
        inputs: 2,
        hidden: vec![65_536, 65_536],
        outputs: 2,
        layer_norm: false,
    };
    let error = Policy::from_tensors(shape.clone(), &[]).unwrap_err();
    assert!(
        matches!(&error, PolicyError::Missing { name } if name == "layers.0.weight"),
        "{error}"
    );
    // All of the right shape by name, but one without its numbers.
    let tensors = [
        ("layers.0.weight", vec![65_536, 2]),
        ("layers.0.bias", vec![65_536]),
        ("layers.1.weight", vec![65_536, 65_536]),
        ("layers.1.bias", vec![65_536]),
        ("output.weight", vec![2, 65_536]),
        ("output.bias", vec![2]),
    ]
    .map(|(name, shape)| NamedTensor {
        name: name.to_owned(),
        values: vec![0.0; shape.iter().product::<usize>() % (1 << 32)],
        shape,
    });
    let error = Policy::from_tensors(shape, &tensors).unwrap_err();
    assert!(
        matches!(&error, PolicyError::TensorShape { name, .. } if name == "layers.1.weight"),
        "{error}"
    );
}

/// A checkpoint whose header names two layers of 65,536 units, and which holds the tensors of one layer of 8, took
/// more than 17 GB before they were compared.
#[test]
fn a_checkpoint_of_huge_layers_without_their_tensors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("agent.safetensors");
    for key in ["actor_hidden", "critic_hidden"] {
        let config = SacConfig {
            actor_hidden: vec![8],
            critic_hidden: vec![8],
            ..SacConfig::default()
        };
        let agent = Agent::new(config, 2, 1, None, 1).unwrap();
        for (units, cause) in [("65536", key), ("16000", "layers.0.weight")] {
            agent.save(&path).unwrap();
            name_huge_layers(&path, key, units);
            let error = Agent::load(&path).unwrap_err();
            assert!(matches!(error, SacError::Format { .. }), "{error}");
            let text = error.to_string();
            assert!(text.contains(cause) && text.contains(units), "{text}");
        }
    }
}

/// Replaces the sizes of the layers in the header of a safetensors file.
fn name_huge_layers(path: &Path, key: &str, units: &str) {
    let bytes = std::fs::read(path).unwrap();
    let length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
    let header = std::str::from_utf8(&bytes[8..8 + length]).unwrap();
    let from = format!(r#"\"{key}\":[8]"#);
    assert!(header.contains(&from), "{header}");
    let header = header.replace(&from, &format!(r#"\"{key}\":[{units},{units}]"#));
    // The tensors begin at a multiple of eight.
    let padded = header.len().next_multiple_of(8);
    let mut altered = (padded as u64).to_le_bytes().to_vec();
    altered.extend(format!("{header:padded$}").bytes());
    altered.extend(&bytes[8 + length..]);
    std::fs::write(path, altered).unwrap();
}
