//! Memory that begins at a cache line.

use std::ops::{Deref, DerefMut};

use crate::real::Real;

/// Scalars per aligned line of memory (one cache line of `f32`).
pub const LINE: usize = 16;

#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
struct Line<T>([T; LINE]);

/// A fixed-size vector whose first element lies at the start of a cache line, so that the vector loads of
/// the kernels never straddle two lines.
#[derive(Clone, Debug)]
pub struct Buffer<T> {
    lines: Vec<Line<T>>,
    len: usize,
}

impl<T: Real> Buffer<T> {
    /// `len` zeros.
    pub fn zeros(len: usize) -> Self {
        Self {
            lines: vec![Line([T::ZERO; LINE]); len.div_ceil(LINE)],
            len,
        }
    }
}

impl<T> Deref for Buffer<T> {
    type Target = [T];
    #[inline(always)]
    fn deref(&self) -> &[T] {
        // SAFETY: `Line<T>` is `LINE` scalars without padding (repr(C), 64 or 128 bytes), and
        // `len` is at most `lines.len() * LINE`.
        unsafe { std::slice::from_raw_parts(self.lines.as_ptr().cast(), self.len) }
    }
}

impl<T> DerefMut for Buffer<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        // SAFETY: as above, and `self` is borrowed mutably.
        unsafe { std::slice::from_raw_parts_mut(self.lines.as_mut_ptr().cast(), self.len) }
    }
}
