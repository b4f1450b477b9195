//! The ground of a recording, for pictures: flat at height 0, or the profile in its metadata.

use gaitshift_analysis::Recording;

/// Heights are averaged over this far to both sides, in m, where a picture follows the ground.
const HALF_WIDTH_M: f64 = 0.75;
/// Points of that average.
const POINTS: i32 = 30;

/// The profile of the ground.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Ground<'a>(Option<&'a [[f64; 2]]>);

impl<'a> Ground<'a> {
    /// That of two or more points in order; flat without any.
    pub fn through(points: Option<&'a [[f64; 2]]>) -> Self {
        Self(points.filter(|points| points.len() > 1))
    }

    pub fn of(recording: &'a Recording) -> Self {
        Self::through(recording.metadata.ground_to_draw())
    }

    /// Whether nothing is said of it: it is flat at height 0.
    pub fn is_flat(&self) -> bool {
        self.0.is_none()
    }

    /// Its height at `x`, in m.
    pub fn height(&self, x: f64) -> f64 {
        let Some(points) = self.0 else {
            return 0.0;
        };
        let next = points.partition_point(|p| p[0] <= x);
        let last = next.clamp(1, points.len() - 1);
        let ([x0, z0], [x1, z1]) = (points[last - 1], points[last]);
        let way = x1 - x0;
        if way.abs() > 0.0 {
            z0 + (z1 - z0) * (x - x0) / way
        } else {
            z1
        }
    }

    /// The corners from `from` to `to`, in m, with the points at both ends.
    pub fn between(&self, from: f64, to: f64) -> Vec<(f64, f64)> {
        let within = self.0.unwrap_or_default().iter();
        let within = within.filter(|corner| from < corner[0] && corner[0] < to);
        std::iter::once((from, self.height(from)))
            .chain(within.map(|&[x, z]| (x, z)))
            .chain([(to, self.height(to))])
            .collect()
    }

    /// Its mean height around `x`, in m: what the eye follows without jumping over steps.
    pub fn level(&self, x: f64) -> f64 {
        if self.0.is_none() {
            return 0.0;
        }
        let share = |k: i32| f64::from(k) / f64::from(POINTS);
        let heights = (-POINTS..=POINTS).map(|k| self.height(x + HALF_WIDTH_M * share(k)));
        heights.sum::<f64>() / f64::from(2 * POINTS + 1)
    }
}
