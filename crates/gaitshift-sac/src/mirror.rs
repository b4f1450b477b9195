//! Mirror images of observations and actions as signed permutations.

use gaitshift_nn::Scalar;
use serde::{Deserialize, Serialize};

use crate::error::SacError;

/// Left-right mirror of a task: mirrored\[i\] = sign\[i\] · original\[source\[i\]\].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mirror {
    /// (source index, sign) for each observation.
    pub observation: Vec<(usize, f32)>,
    /// (source index, sign) for each action.
    pub action: Vec<(usize, f32)>,
}

impl Mirror {
    /// Outputs of the actor, the means of the actions and ln σ: the latter change places but no sign.
    pub(crate) fn actor_outputs(&self) -> Vec<(usize, f32)> {
        let count = self.action.len();
        let spreads = self.action.iter();
        let spreads = spreads.map(|&(source, _)| (count + source, 1.0));
        self.action.iter().copied().chain(spreads).collect()
    }

    /// # Errors
    /// When a list is not as long as the vector it mirrors, a source lies outside it, a sign is not ±1, or
    /// mirroring twice does not give the original back.
    pub fn validate(&self, observation_size: usize, action_size: usize) -> Result<(), SacError> {
        check("observation", &self.observation, observation_size)?;
        check("action", &self.action, action_size)
    }
}

fn check(what: &'static str, map: &[(usize, f32)], size: usize) -> Result<(), SacError> {
    let reject = |cause: String| Err(SacError::Mirror { what, cause });
    if map.len() != size {
        return reject(format!("it has {} entries for {size} numbers", map.len()));
    }
    for (index, &(source, sign)) in map.iter().enumerate() {
        if source >= size {
            return reject(format!("entry {index} takes number {source} of {size}"));
        }
        if sign.abs() != 1.0 {
            return reject(format!("entry {index} has sign {sign}, not 1 or -1"));
        }
        let (back, back_sign) = map[source];
        if back != index || back_sign * sign != 1.0 {
            return reject(format!("entry {index} mirrored twice is not itself"));
        }
    }
    Ok(())
}

/// Writes the mirror image of `from` to `to`.
pub fn reflect<T: Scalar>(map: &[(usize, f32)], from: &[T], to: &mut [T]) {
    for (to, &(source, sign)) in to.iter_mut().zip(map) {
        *to = if sign < 0.0 {
            -from[source]
        } else {
            from[source]
        };
    }
}
