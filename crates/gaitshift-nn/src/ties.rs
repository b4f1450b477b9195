//! Networks that commute with a mirror: which parameters have to be equal, and gradients that keep them so.
//!
//! A network f commutes with mirrors of its inputs and outputs, f(M x) = M' f(x), where each hidden unit has a partner
//! that sees the mirror image of what it sees. Unit k of a layer of n is the partner of unit n - 1 - k; then a weight and the weight
//! between the partners of its two ends are equal, up to the mirrors' signs. Gradients averaged over such pairs keep
//! parameters equal that were so at first, with any optimiser that treats each parameter alike.

use crate::layout::Place;
use crate::mlp::Mlp;
use crate::simd::Scalar;

/// Two parameters of which the mirror makes one of the other: equal, or of opposite sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tie {
    first: u32,
    second: u32,
    opposite: bool,
}

/// Where each number of a mirror image comes from, and its sign.
type Map = [(usize, f32)];

impl<T: Scalar> Mlp<T> {
    /// The ties by which the network commutes with mirrors of its inputs and outputs: element i of an image is element
    /// `map[i].0` of the original times the sign `map[i].1`. Both have to be mirrors: applied twice, they give the
    /// original back.
    pub fn ties(&self, inputs: &Map, outputs: &Map) -> Vec<Tie> {
        let hidden = |units: usize| (0..units).rev().map(|unit| (unit, 1.0)).collect::<Vec<_>>();
        let one = [(0, 1.0)];
        let mut places = self.places().into_iter();
        let mut ties = Vec::new();
        let mut add = |rows: &Map, columns: &Map, vectors: usize| {
            if let Some(weight) = places.next() {
                tie(&weight, rows, columns, &mut ties);
            }
            for vector in places.by_ref().take(vectors) {
                tie(&vector, &one, rows, &mut ties);
            }
        };
        let vectors = if self.shape.layer_norm { 3 } else { 1 };
        let mut below = inputs.to_vec();
        for &units in &self.shape.hidden {
            let units = hidden(units);
            add(&units, &below, vectors);
            below = units;
        }
        add(outputs, &below, 1);
        ties
    }
}

/// The ties of one tensor, its rows and columns mirrored.
fn tie(place: &Place, rows: &Map, columns: &Map, ties: &mut Vec<Tie>) {
    for (row, &(to_row, row_sign)) in rows.iter().enumerate() {
        for (column, &(to_column, column_sign)) in columns.iter().enumerate() {
            let (first, second) = (place.index(row, column), place.index(to_row, to_column));
            let opposite = row_sign * column_sign < 0.0;
            // One that is its own image is free, or zero where its sign changes.
            if first < second || (first == second && opposite) {
                let (first, second) = (first as u32, second as u32);
                ties.push(Tie {
                    first,
                    second,
                    opposite,
                });
            }
        }
    }
}

/// Makes numbers in the layout of the parameters obey the ties: both of a pair become their mean.
pub(crate) fn average<T: Scalar>(ties: &[Tie], numbers: &mut [T]) {
    let half = T::from_f64(0.5);
    for tie in ties {
        let (first, second) = (tie.first as usize, tie.second as usize);
        let sign = if tie.opposite { -T::ONE } else { T::ONE };
        let mean = half * (numbers[first] + sign * numbers[second]);
        numbers[first] = mean;
        numbers[second] = sign * mean;
    }
}

/// Makes the second of each pair the image of the first: keeps the spread of numbers drawn at random, which a mean would
/// narrow.
pub(crate) fn copy<T: Scalar>(ties: &[Tie], numbers: &mut [T]) {
    for tie in ties {
        let (first, second) = (tie.first as usize, tie.second as usize);
        numbers[second] = match (tie.opposite, first == second) {
            (true, true) => T::ZERO,
            (true, false) => -numbers[first],
            (false, _) => numbers[first],
        };
    }
}
