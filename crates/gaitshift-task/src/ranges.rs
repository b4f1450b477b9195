//! Ranges from which an episode draws its pushes and its ground. *Not in the paper.*

use crate::error::require;
use crate::terrain::{FARTHEST_M, require_spacing};
use crate::{TaskError, TerrainParameters, TerrainStep, UnevenGround};
use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

/// A number from a range, uniformly.
pub(crate) fn uniform([low, high]: [f64; 2], rng: &mut impl Rng) -> f64 {
    low + (high - low) * rng.random::<f64>()
}

/// Checks a range: ordered, and between two bounds.
pub(crate) fn require_within(
    key: &str,
    range: [f64; 2],
    bounds: [f64; 2],
    accepted: &'static str,
) -> Result<(), TaskError> {
    let [low, high] = range;
    let ok = bounds[0] <= low && low <= high && high <= bounds[1];
    require(ok, key, range, accepted)
}

/// Pushes that come at random, as those of a [`Disturbance`](crate::Disturbance) come at given times.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PushRanges {
    /// Mean time from the end of one to the beginning of the next, in s, to within a control period: each control period without one begins one with the same chance.
    pub interval_s: f64,
    /// Range of the forward force, in N.
    pub forward_n: [f64; 2],
    /// Range of the upward force, in N.
    pub up_n: [f64; 2],
    /// Range of their duration, in s, rounded to whole integration steps.
    pub duration_s: [f64; 2],
}

impl Default for PushRanges {
    fn default() -> Self {
        Self {
            interval_s: 3.0,
            forward_n: [0.0; 2],
            up_n: [0.0; 2],
            duration_s: [0.1; 2],
        }
    }
}

/// Ground that each episode draws, as [`TerrainParameters`] give it. It is flat where episodes begin.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TerrainRanges {
    /// Range of the inclination, in rad; positive rises forward.
    pub slope_rad: [f64; 2],
    /// Range of where it begins, in m.
    pub slope_from_m: [f64; 2],
    /// Steps, one after the other.
    pub steps: StepRanges,
    /// Heights drawn at random.
    pub uneven: UnevenRanges,
}

impl Default for TerrainRanges {
    fn default() -> Self {
        Self {
            slope_rad: [0.0; 2],
            slope_from_m: [1.0; 2],
            steps: StepRanges::default(),
            uneven: UnevenRanges::default(),
        }
    }
}

/// Steps with vertical faces, each drawn by itself.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StepRanges {
    /// Range of their heights, in m; negative leads down.
    pub height_m: [f64; 2],
    /// Range of the distance from one to the next, in m.
    pub spacing_m: [f64; 2],
    /// Where they begin, in m: the first comes one distance later.
    pub from_m: f64,
    /// How far they reach, in m.
    pub length_m: f64,
}

impl Default for StepRanges {
    fn default() -> Self {
        Self {
            height_m: [0.0; 2],
            spacing_m: [1.0, 3.0],
            from_m: 0.5,
            length_m: 40.0,
        }
    }
}

/// As [`UnevenGround`], its height and its seed drawn.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct UnevenRanges {
    /// Range of the height, in m.
    pub height_m: [f64; 2],
    /// Distance between two heights, in m.
    pub spacing_m: f64,
    /// Where the unevenness begins, in m.
    pub from_m: f64,
    /// How far it reaches, in m.
    pub length_m: f64,
}

impl Default for UnevenRanges {
    fn default() -> Self {
        Self {
            height_m: [0.0; 2],
            spacing_m: 0.25,
            from_m: 1.0,
            length_m: 40.0,
        }
    }
}

/// Where the ground may cease to be flat, in m: the feet of every start stand before it.
const FLAT_TO_M: f64 = 0.5;

impl TerrainRanges {
    pub(crate) fn draw(&self, rng: &mut impl Rng) -> TerrainParameters {
        let mut terrain = TerrainParameters::default();
        if self.slope_rad != [0.0; 2] {
            terrain.slope_rad = uniform(self.slope_rad, rng);
            terrain.slope_from_m = Some(uniform(self.slope_from_m, rng));
        }
        let s = &self.steps;
        if s.height_m != [0.0; 2] {
            let mut at_m = s.from_m + uniform(s.spacing_m, rng);
            while at_m < s.from_m + s.length_m {
                let height_m = uniform(s.height_m, rng);
                terrain.steps.push(TerrainStep { height_m, at_m });
                at_m += uniform(s.spacing_m, rng);
            }
        }
        let u = &self.uneven;
        if u.height_m != [0.0; 2] {
            terrain.uneven = UnevenGround {
                height_m: uniform(u.height_m, rng),
                spacing_m: u.spacing_m,
                from_m: u.from_m,
                length_m: u.length_m,
                // A seed that TOML and JSON hold exactly.
                seed: rng.random::<u64>() >> 11,
            };
        }
        terrain
    }

    pub(crate) fn validate(&self, key: &str) -> Result<(), TaskError> {
        let key = |name: &str| format!("{key}.{name}");
        let (s, u) = (&self.steps, &self.uneven);
        for (name, range, low, high, accepted) in [
            (
                "slope_rad",
                self.slope_rad,
                -0.8,
                0.8,
                "[low, high] between -0.8 and 0.8",
            ),
            (
                "slope_from_m",
                self.slope_from_m,
                FLAT_TO_M,
                FARTHEST_M,
                "[low, high] between 0.5 and 10000: episodes begin on flat ground",
            ),
            (
                "steps.height_m",
                s.height_m,
                -1.0,
                1.0,
                "[low, high] between -1 and 1",
            ),
            (
                "steps.spacing_m",
                s.spacing_m,
                0.05,
                FARTHEST_M,
                "[low, high] between 0.05 and 10000",
            ),
            (
                "uneven.height_m",
                u.height_m,
                0.0,
                1.0,
                "[low, high] between 0 and 1",
            ),
        ] {
            require_within(&key(name), range, [low, high], accepted)?;
        }
        for (name, from_m) in [("steps.from_m", s.from_m), ("uneven.from_m", u.from_m)] {
            require(
                (FLAT_TO_M..=FARTHEST_M).contains(&from_m),
                &key(name),
                from_m,
                "between 0.5 and 10000: episodes begin on flat ground",
            )?;
        }
        require(
            (0.0..=1000.0).contains(&s.length_m),
            &key("steps.length_m"),
            s.length_m,
            "between 0 and 1000",
        )?;
        // Every step that is drawn lies before this.
        require(
            s.from_m + s.length_m <= FARTHEST_M,
            &key("steps.from_m"),
            s.from_m,
            "small enough that `from_m` plus `length_m` is at most 10000",
        )?;
        require_spacing(&key("uneven.spacing_m"), u.spacing_m)?;
        require(
            (0.0..=1000.0).contains(&u.length_m),
            &key("uneven.length_m"),
            u.length_m,
            "between 0 and 1000",
        )
    }
}

impl PushRanges {
    pub(crate) fn validate(&self, key: &str) -> Result<(), TaskError> {
        let key = |name: &str| format!("{key}.{name}");
        require(
            (0.01..=1e6).contains(&self.interval_s),
            &key("interval_s"),
            self.interval_s,
            "between 0.01 and 1e6",
        )?;
        for (name, range) in [("forward_n", self.forward_n), ("up_n", self.up_n)] {
            let accepted = "[low, high] between -1e6 and 1e6";
            require_within(&key(name), range, [-1e6, 1e6], accepted)?;
        }
        let accepted = "[low, high] between 0 and 100";
        require_within(&key("duration_s"), self.duration_s, [0.0, 100.0], accepted)
    }
}
