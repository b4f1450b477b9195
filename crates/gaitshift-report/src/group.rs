//! The seeds of one experiment together.

use crate::claims::is_claimed;
use crate::headline::{HeadlineNumber, headline_numbers};
use crate::study::Study;
use serde::Serialize;

/// The seeds of one experiment together.
#[derive(Serialize)]
pub(crate) struct Group {
    pub name: String,
    pub seeds: Vec<u64>,
    /// Whether claims are about it; otherwise it stands beside them.
    pub claimed: bool,
    pub numbers: Vec<HeadlineNumber>,
}

impl Group {
    /// The experiments of some studies, in the order in which they first come.
    pub fn all(studies: &[&Study]) -> Vec<Self> {
        let mut names: Vec<&str> = Vec::new();
        for study in studies {
            if !names.contains(&study.group.as_str()) {
                names.push(&study.group);
            }
        }
        let group = |name: &str| {
            let own: Vec<&Study> = studies
                .iter()
                .copied()
                .filter(|s| s.group == name)
                .collect();
            Self {
                name: name.to_owned(),
                seeds: own.iter().map(|s| s.seed).collect(),
                claimed: is_claimed(name),
                numbers: headline_numbers(&own),
            }
        };
        names.into_iter().map(group).collect()
    }
}
