//! Ground that is not flat: heights along x in straight pieces, vertical faces where they jump.
//!
//! A sphere is pressed on by the piece, or the corner between two pieces, that is nearest to its centre, along the
//! shortest way to it. That way is the gradient of the distance, so that the elastic energy of the contact depends on
//! the sphere's place alone and the energy account stays closed over corners too.

use std::ops::Range;

/// The profile of the ground along x.
#[derive(Debug, Clone, PartialEq)]
pub struct Terrain {
    /// From left to right, each beginning where the last one ends. The first and the last have no outer end.
    pieces: Vec<Piece>,
}

/// A straight piece of the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    /// A point on it, in m.
    x: f64,
    z: f64,
    /// Unit vector along it; its normal `(-uz, ux)` points out of the ground.
    ux: f64,
    uz: f64,
    /// Its ends as distances from the point along the vector, in m.
    from: f64,
    to: f64,
}

impl Piece {
    fn between((x, z): (f64, f64), (to_x, to_z): (f64, f64)) -> Self {
        let length = (to_x - x).hypot(to_z - z);
        Self {
            x,
            z,
            ux: (to_x - x) / length,
            uz: (to_z - z) / length,
            from: 0.0,
            to: length,
        }
    }

    /// From a point on, to the left or to the right, without an end.
    fn ray((x, z): (f64, f64), slope: f64, [from, to]: [f64; 2]) -> Self {
        let norm = slope.hypot(1.0);
        let (ux, uz) = (1.0 / norm, slope / norm);
        Self {
            x,
            z,
            ux,
            uz,
            from,
            to,
        }
    }

    fn point(&self, along: f64) -> (f64, f64) {
        (self.x + along * self.ux, self.z + along * self.uz)
    }

    fn height(&self, x: f64) -> f64 {
        self.z + (x - self.x) * self.uz / self.ux
    }

    fn right_end(&self) -> f64 {
        self.x + self.to * self.ux
    }
}

/// The place of the ground that is nearest to a point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Nearest {
    /// Distance from it, in m, negative within the ground.
    pub distance: f64,
    /// Unit vector out of the ground, along the shortest way.
    pub normal: (f64, f64),
}

impl Terrain {
    /// Straight lines through the points `(x, z)` in m, which go on with the given slopes (rise per way) before the
    /// first and after the last one. Two points with the same x make a vertical face.
    ///
    /// `None` unless there is a point, all numbers are finite, and x never decreases.
    pub fn through(points: &[(f64, f64)], slope_before: f64, slope_after: f64) -> Option<Self> {
        let finite = points.iter().all(|p| p.0.is_finite() && p.1.is_finite());
        let ordered = points.windows(2).all(|p| p[0].0 <= p[1].0);
        let (&first, &last) = (points.first()?, points.last()?);
        if !(finite && ordered && slope_before.is_finite() && slope_after.is_finite()) {
            return None;
        }
        let mut pieces = vec![Piece::ray(first, slope_before, [f64::NEG_INFINITY, 0.0])];
        let different = points.windows(2).filter(|p| p[0] != p[1]);
        pieces.extend(different.map(|p| Piece::between(p[0], p[1])));
        pieces.push(Piece::ray(last, slope_after, [0.0, f64::INFINITY]));
        Some(Self { pieces })
    }

    /// Whether it is the flat ground at height 0.
    pub fn is_flat(&self) -> bool {
        self.pieces.iter().all(|p| p.z == 0.0 && p.uz == 0.0)
    }

    /// Height of the ground at `x`, in m; on a vertical face that on its right.
    pub fn height(&self, x: f64) -> f64 {
        let index = self.pieces.partition_point(|p| p.right_end() <= x);
        self.pieces[index.min(self.pieces.len() - 1)].height(x)
    }

    /// Corners from left to right, in m, with a point on the first and on the last piece, a metre beyond the corner
    /// nearest to it: what a drawing of the ground needs.
    pub fn outline(&self) -> Vec<[f64; 2]> {
        let (first, last) = (self.pieces[0], self.pieces[self.pieces.len() - 1]);
        let before = first.point(-1.0 / first.ux);
        let corners = self.pieces[1..].iter().map(|p| (p.x, p.z));
        let points = [before].into_iter().chain(corners);
        let points = points.chain([last.point(1.0 / last.ux)]);
        points.map(|(x, z)| [x, z]).collect()
    }

    /// Indices of the pieces that have points between `from` and `to`.
    pub(crate) fn between(&self, from: f64, to: f64) -> Range<usize> {
        let last = self.pieces.len() - 1;
        let start = self.pieces.partition_point(|p| p.right_end() < from);
        let reaching = self.pieces[start.min(last)..].iter().skip(1);
        let end = start + 1 + reaching.take_while(|p| p.x <= to).count();
        start.min(last)..end.min(last + 1)
    }

    /// Lowest and highest point of some pieces between `from` and `to`, in m.
    pub(crate) fn range(&self, pieces: Range<usize>, from: f64, to: f64) -> (f64, f64) {
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for piece in &self.pieces[pieces] {
            let ends = if piece.ux > 0.0 {
                let along = |x: f64| ((x - piece.x) / piece.ux).clamp(piece.from, piece.to);
                [along(from), along(to)]
            } else {
                [piece.from, piece.to]
            };
            for z in ends.map(|along| piece.point(along).1) {
                range = (range.0.min(z), range.1.max(z));
            }
        }
        range
    }

    /// What of some pieces is nearest to the point `(x, z)`.
    pub(crate) fn nearest(&self, pieces: Range<usize>, x: f64, z: f64) -> Nearest {
        let mut least = f64::INFINITY;
        let mut face = None;
        let mut way = (0.0, 0.0);
        for piece in &self.pieces[pieces] {
            let (dx, dz) = (x - piece.x, z - piece.z);
            let foot = dx * piece.ux + dz * piece.uz;
            let along = foot.clamp(piece.from, piece.to);
            if along == foot {
                let distance = dz * piece.ux - dx * piece.uz;
                if distance * distance < least {
                    least = distance * distance;
                    face = Some(Nearest {
                        distance,
                        normal: (-piece.uz, piece.ux),
                    });
                }
            } else {
                let corner = piece.point(along);
                let to_corner = (x - corner.0, z - corner.1);
                let square = to_corner.0 * to_corner.0 + to_corner.1 * to_corner.1;
                if square < least {
                    least = square;
                    face = None;
                    way = to_corner;
                }
            }
        }
        face.unwrap_or_else(|| {
            let side = if z < self.height(x) { -1.0 } else { 1.0 };
            let distance = side * least.sqrt();
            Nearest {
                distance,
                normal: (way.0 / distance, way.1 / distance),
            }
        })
    }
}
