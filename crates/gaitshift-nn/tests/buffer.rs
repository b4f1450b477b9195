//! Contract: a buffer has exactly the elements it was asked for, at first 0, each its own; it begins at a cache line; a
//! clone shares nothing. Small enough for Miri, which checks every access (docs/verification.md).

use gaitshift_nn::{Buffer, LINE, Real};

fn holds_what_is_written<T: Real + std::fmt::Debug>(number: impl Fn(usize) -> T) {
    // Empty, within a line, whole lines, and lines that are not full.
    for len in [0, 1, LINE - 1, LINE, LINE + 1, 3 * LINE, 5 * LINE + 7] {
        let mut buffer = Buffer::<T>::zeros(len);
        assert_eq!(buffer.len(), len);
        assert!(buffer.iter().all(|&value| value == T::ZERO));
        assert_eq!(buffer.as_ptr().cast::<u8>().align_offset(64), 0);
        for (index, value) in buffer.iter_mut().enumerate() {
            *value = number(index);
        }
        let mut clone = buffer.clone();
        clone.fill(T::ZERO);
        assert!((0..len).all(|index| buffer[index] == number(index)));
        assert!(clone.iter().all(|&value| value == T::ZERO));
        let (low, high) = buffer.split_at_mut(len / 2);
        low.iter_mut()
            .zip(high)
            .for_each(|(a, b)| std::mem::swap(a, b));
        if len > 1 {
            assert_eq!(buffer[0], number(len / 2));
        }
    }
}

#[test]
fn of_single_precision() {
    holds_what_is_written(|index| index as f32 + 1.0);
}

#[test]
fn of_double_precision() {
    holds_what_is_written(|index| index as f64 + 1.0);
}
