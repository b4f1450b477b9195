//! The ground as its parameters give it: a slope, steps and unevenness. *Not in the paper.*

use crate::TaskError;
use crate::error::require;
use gaitshift_body::Terrain;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

/// Places beyond this, in m, no motion reaches.
pub(crate) const FARTHEST_M: f64 = 1e4;
/// Most pieces of uneven ground.
const MOST_PIECES: f64 = 1e5;

/// Checks the distance between two heights of uneven ground, in m.
pub(crate) fn require_spacing(key: &str, spacing_m: f64) -> Result<(), TaskError> {
    let possible = (0.01..=FARTHEST_M).contains(&spacing_m);
    require(possible, key, spacing_m, "between 0.01 and 10000")
}

/// The ground: a slope, steps and unevenness, added to each other.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TerrainParameters {
    /// Inclination, in rad; positive rises forward.
    pub slope_rad: f64,
    /// Where the slope begins, in m; without it the whole ground is inclined.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slope_from_m: Option<f64>,
    /// Steps with vertical faces.
    pub steps: Vec<TerrainStep>,
    /// Heights drawn at random.
    pub uneven: UnevenGround,
}

/// A step of the ground with a vertical face.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TerrainStep {
    /// Its height, in m; negative leads down.
    pub height_m: f64,
    /// Where it is, in m.
    pub at_m: f64,
}

/// Heights drawn at random, with straight lines between them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct UnevenGround {
    /// Heights are drawn from plus or minus this, uniformly, in m.
    pub height_m: f64,
    /// Distance between two of them, in m.
    pub spacing_m: f64,
    /// Where the unevenness begins, in m.
    pub from_m: f64,
    /// How far it reaches, in m.
    pub length_m: f64,
    /// Seed that draws it.
    pub seed: u64,
}

impl Default for UnevenGround {
    fn default() -> Self {
        Self {
            height_m: 0.0,
            spacing_m: 0.25,
            from_m: 1.0,
            length_m: 100.0,
            seed: 0,
        }
    }
}

impl UnevenGround {
    /// Corners `(x, z)`; the first and the last one at height 0.
    fn corners(&self) -> Vec<(f64, f64)> {
        if self.height_m == 0.0 {
            return Vec::new();
        }
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(self.seed);
        let count = (self.length_m / self.spacing_m).ceil() as usize + 1;
        let height = |k: usize, rng: &mut Xoshiro256PlusPlus| {
            if k == 0 || k + 1 == count {
                0.0
            } else {
                self.height_m * (2.0 * rng.random::<f64>() - 1.0)
            }
        };
        let corner = |k: usize| {
            let x = self.from_m + self.spacing_m * k as f64;
            (x, height(k, &mut rng))
        };
        (0..count).map(corner).collect()
    }
}

impl TerrainParameters {
    /// The steepest inclination that there may be, in rad.
    pub const STEEPEST_RAD: f64 = 0.8;

    /// Whether it is the flat ground.
    pub fn is_flat(&self) -> bool {
        self.slope_rad == 0.0
            && self.steps.iter().all(|s| s.height_m == 0.0)
            && self.uneven.height_m == 0.0
    }

    /// The ground; `None` if it is flat, or not valid ([`Disturbance::validate`](crate::Disturbance::validate)).
    pub fn terrain(&self) -> Option<Terrain> {
        if self.is_flat() {
            return None;
        }
        let slope = self.slope_rad.tan();
        let start = self.slope_from_m;
        let inclined = |x: f64| match start {
            Some(start) => slope * (x - start).max(0.0),
            None => slope * x,
        };
        let rough = self.uneven.corners();
        let roughness = |x: f64| {
            let next = rough.partition_point(|c| c.0 <= x);
            match (next.checked_sub(1).map(|k| rough[k]), rough.get(next)) {
                (Some((x0, z0)), Some(&(x1, z1))) => z0 + (z1 - z0) * (x - x0) / (x1 - x0),
                _ => 0.0,
            }
        };
        let mut steps = self.steps.clone();
        steps.sort_by(|a, b| a.at_m.total_cmp(&b.at_m));
        let mut places: Vec<f64> = rough.iter().map(|c| c.0).collect();
        places.extend(start.iter().chain(steps.iter().map(|s| &s.at_m)));
        if places.is_empty() {
            places.push(0.0);
        }
        places.sort_by(f64::total_cmp);
        places.dedup();
        let mut points = Vec::new();
        let mut steps = steps.iter().peekable();
        let mut level = 0.0;
        for x in places {
            let base = inclined(x) + roughness(x);
            points.push((x, base + level));
            while let Some(step) = steps.next_if(|s| s.at_m <= x) {
                level += step.height_m;
            }
            points.push((x, base + level));
        }
        points.dedup();
        let before = if start.is_some() { 0.0 } else { slope };
        Terrain::through(&points, before, slope)
    }

    pub(crate) fn validate(&self, key: &str) -> Result<(), TaskError> {
        let key = |name: &str| format!("{key}.{name}");
        let near = |x: f64| x.abs() <= FARTHEST_M;
        require(
            self.slope_rad.abs() <= Self::STEEPEST_RAD,
            &key("slope_rad"),
            self.slope_rad,
            "between -0.8 and 0.8",
        )?;
        require(
            self.slope_from_m.is_none_or(near),
            &key("slope_from_m"),
            self.slope_from_m.unwrap_or_default(),
            "between -10000 and 10000",
        )?;
        for (k, step) in self.steps.iter().enumerate() {
            require(
                step.height_m.abs() <= 1.0,
                &key(&format!("steps[{k}].height_m")),
                step.height_m,
                "between -1 and 1",
            )?;
            require(
                near(step.at_m),
                &key(&format!("steps[{k}].at_m")),
                step.at_m,
                "between -10000 and 10000",
            )?;
        }
        let u = &self.uneven;
        require(
            (0.0..=1.0).contains(&u.height_m),
            &key("uneven.height_m"),
            u.height_m,
            "between 0 and 1",
        )?;
        require_spacing(&key("uneven.spacing_m"), u.spacing_m)?;
        require(
            near(u.from_m),
            &key("uneven.from_m"),
            u.from_m,
            "between -10000 and 10000",
        )?;
        require(
            u.length_m >= 0.0
                && u.length_m <= FARTHEST_M
                && u.length_m / u.spacing_m <= MOST_PIECES,
            &key("uneven.length_m"),
            u.length_m,
            "between 0 and 10000, and at most 100000 times spacing_m",
        )
    }
}
