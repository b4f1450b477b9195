//! Which elements of a matrix are not zero, a bit for each.

use crate::product::padded;
use crate::simd::{LANES, Scalar, Simd8, Vector8, vectorised};

/// Elements that a word marks.
pub(crate) const WORD: usize = u64::BITS as usize;

/// Marks of a matrix's elements that are not zero.
#[derive(Clone, Debug)]
pub struct Pattern {
    rows: usize,
    columns: usize,
    /// Row by row; the lowest bit of a row's first word is its first element. Bits behind a row's last element are 0.
    words: Vec<u64>,
}

impl Pattern {
    /// With memory for matrices of up to `rows` × `columns`, and for their transposes.
    pub fn new(rows: usize, columns: usize) -> Self {
        let words = (rows * columns.div_ceil(WORD)).max(columns * rows.div_ceil(WORD));
        Self {
            rows: 0,
            columns: 0,
            words: vec![0; words],
        }
    }

    /// Words of a row.
    fn width(&self) -> usize {
        self.columns.div_ceil(WORD)
    }

    /// The share of elements that are not zero.
    pub(crate) fn share(&self) -> f64 {
        let words = &self.words[..self.rows * self.width()];
        let count: usize = words.iter().map(|word| word.count_ones() as usize).sum();
        count as f64 / (self.rows * self.columns).max(1) as f64
    }

    /// Its rows and columns.
    pub(crate) fn sizes(&self) -> (usize, usize) {
        (self.rows, self.columns)
    }

    /// The words of all rows that mark the same columns, those from `word` * [`WORD`] on.
    #[inline(always)]
    pub(crate) fn column(&self, word: usize) -> impl Iterator<Item = u64> {
        let words = &self.words[word..self.rows * self.width()];
        words.iter().step_by(self.width()).copied()
    }

    /// Marks what is not zero in `rows` rows of `x`, `stride` apart and padded to a whole number of vectors.
    pub fn read<T: Scalar>(&mut self, rows: usize, columns: usize, x: &[T], stride: usize) {
        // Nothing, should one of the slices below be too short: a kernel may then rely on the marks that are there.
        (self.rows, self.columns) = (0, 0);
        let width = columns.div_ceil(WORD);
        mark(columns, x, stride, &mut self.words[..rows * width]);
        (self.rows, self.columns) = (rows, columns);
    }

    /// Becomes the transpose of `other`.
    pub fn transpose(&mut self, other: &Self) {
        let (rows, columns) = (other.columns, other.rows);
        (self.rows, self.columns) = (0, 0);
        let (width, other_width) = (columns.div_ceil(WORD), other.width());
        for (word, others) in (0..other.rows).step_by(WORD).enumerate() {
            let others = others..other.rows.min(others + WORD);
            for other_word in 0..other_width {
                let mut square = [0; WORD];
                for (bits, row) in square.iter_mut().zip(others.clone()) {
                    *bits = other.words[row * other_width + other_word];
                }
                transpose(&mut square);
                let part = other_word * WORD..rows.min((other_word + 1) * WORD);
                for (row, bits) in part.zip(square) {
                    self.words[row * width + word] = bits;
                }
            }
        }
        (self.rows, self.columns) = (rows, columns);
    }
}

/// Marks of `GROUPS` groups of lanes.
#[inline(always)]
fn marks<T: Scalar, const GROUPS: usize>(simd: impl Simd8<T>, x: &[T]) -> u64 {
    let x = &x[..GROUPS * LANES];
    let mut word = 0;
    for group in 0..GROUPS {
        word |= u64::from(simd.load(&x[group * LANES..]).not_zero()) << (group * LANES);
    }
    word
}

vectorised! {
    fn mark<T>(simd, columns: usize, x: &[T], stride: usize, words: &mut [u64]) {
        let width = columns.div_ceil(WORD);
        let padded = padded(columns);
        // Padding is no element.
        let last = u64::MAX >> (width * WORD - columns);
        for (row, words) in words.chunks_exact_mut(width).enumerate() {
            let (whole, rest) = x[row * stride..][..padded].as_chunks::<WORD>();
            for (word, x) in words.iter_mut().zip(whole) {
                *word = marks::<T, { WORD / LANES }>(simd, x);
            }
            if let Some(word) = words.get_mut(whole.len()) {
                *word = rest
                    .chunks_exact(LANES)
                    .rev()
                    .fold(0, |word, x| word << LANES | marks::<T, 1>(simd, x));
            }
            words[width - 1] &= last;
        }
    }
}

/// Bit `c` of word `r` to bit `r` of word `c`: squares of bits change places across the diagonal, of 32 × 32 first.
fn transpose(square: &mut [u64; WORD]) {
    let mut half = WORD / 2;
    let mut low = u64::MAX >> half;
    while half > 0 {
        for pair in square.chunks_exact_mut(2 * half) {
            let (upper, lower) = pair.split_at_mut(half);
            for (upper, lower) in upper.iter_mut().zip(lower) {
                let change = ((*upper >> half) ^ *lower) & low;
                *upper ^= change << half;
                *lower ^= change;
            }
        }
        half /= 2;
        low ^= low << half;
    }
}
