//! Slices that several threads write at once, each its own part.

use std::marker::PhantomData;

/// A mutable slice handed out to tasks in pieces.
pub struct Disjoint<'a, E> {
    start: *mut E,
    len: usize,
    borrow: PhantomData<&'a mut [E]>,
}

// SAFETY: hands out `&mut E` to other threads, sound for `E: Send`, and `&E` of those that are `Sync`.
unsafe impl<E: Send> Sync for Disjoint<'_, E> {}

impl<'a, E> Disjoint<'a, E> {
    pub fn new(slice: &'a mut [E]) -> Self {
        Self {
            start: slice.as_mut_ptr(),
            len: slice.len(),
            borrow: PhantomData,
        }
    }

    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The elements `from..to`.
    ///
    /// # Safety
    /// No two pieces alive at the same time may overlap.
    #[allow(clippy::mut_from_ref)]
    pub unsafe fn range(&self, from: usize, to: usize) -> &'a mut [E] {
        assert!(from <= to && to <= self.len);
        // SAFETY: in bounds; that no two overlap is the caller's.
        unsafe { std::slice::from_raw_parts_mut(self.start.add(from), to - from) }
    }

    /// The element `index`, to read.
    ///
    /// # Safety
    /// No piece alive at the same time may hold it.
    pub unsafe fn shared(&self, index: usize) -> &'a E
    where
        E: Sync,
    {
        assert!(index < self.len);
        // SAFETY: in bounds; that nobody writes is the caller's.
        unsafe { &*self.start.add(index) }
    }
}
