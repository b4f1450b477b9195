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
        let group = |own: Vec<&Study>| Self {
            name: own[0].group.clone(),
            seeds: own.iter().map(|s| s.seed).collect(),
            claimed: is_claimed(&own[0].group),
            numbers: headline_numbers(&own),
        };
        by_group(studies).into_iter().map(group).collect()
    }
}

/// Studies by experiment, each with one at least, in the order in which they first come.
pub(crate) fn by_group<'a>(studies: &[&'a Study]) -> Vec<Vec<&'a Study>> {
    let mut groups: Vec<Vec<&Study>> = Vec::new();
    for &study in studies {
        match groups.iter_mut().find(|own| own[0].group == study.group) {
            Some(own) => own.push(study),
            None => groups.push(vec![study]),
        }
    }
    groups
}
