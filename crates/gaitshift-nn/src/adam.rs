//! Adam with bias correction, as `torch.optim.Adam`, element by element.

use crate::simd::{Scalar, vectorised};

/// Decay of the first moment.
pub const BETA_1: f64 = 0.9;
/// Decay of the second moment.
pub const BETA_2: f64 = 0.999;
/// Added to the root of the second moment.
pub const EPSILON: f64 = 1e-8;

/// What is the same for all elements of one step.
#[derive(Clone, Copy, Debug)]
pub struct AdamStep<T> {
    step_size: T,
    root_correction: T,
}

impl<T: Scalar> AdamStep<T> {
    /// For the `step`-th step, counted from 1.
    pub fn new(step: u64, learning_rate: f64) -> Self {
        let step = step as f64;
        Self {
            step_size: T::from_f64(learning_rate / (1.0 - BETA_1.powf(step))),
            root_correction: T::from_f64((1.0 - BETA_2.powf(step)).sqrt()),
        }
    }
}

vectorised! {
    /// One step for a range of parameters.
    pub fn descend<T>(_simd, step: AdamStep<T>,
        gradient: &[T],
        parameters: &mut [T],
        first_moment: &mut [T],
        second_moment: &mut [T],
    ) {
        let one_minus_beta_1 = T::from_f64(1.0 - BETA_1);
        let beta_2 = T::from_f64(BETA_2);
        let one_minus_beta_2 = T::from_f64(1.0 - BETA_2);
        let epsilon = T::from_f64(EPSILON);
        for (((&gradient, parameter), first), second) in gradient
            .iter()
            .zip(parameters.iter_mut())
            .zip(first_moment.iter_mut())
            .zip(second_moment.iter_mut())
        {
            *first += one_minus_beta_1 * (gradient - *first);
            *second = *second * beta_2 + one_minus_beta_2 * (gradient * gradient);
            let root = second.sqrt() / step.root_correction + epsilon;
            *parameter -= step.step_size * (*first / root);
        }
    }
}

vectorised! {
    /// follower ← (1 − rate) follower + rate leader.
    pub fn follow<T>(_simd, rate: T, leader: &[T], follower: &mut [T]) {
        let rest = T::ONE - rate;
        for (follower, &leader) in follower.iter_mut().zip(leader) {
            *follower = *follower * rest + rate * leader;
        }
    }
}

vectorised! {
    /// sum ← a + b.
    pub fn sum_of_two<T>(_simd, a: &[T], b: &[T], sum: &mut [T]) {
        for ((sum, &a), &b) in sum.iter_mut().zip(a).zip(b) {
            *sum = a + b;
        }
    }
}

vectorised! {
    /// sum ← sum + addend.
    pub fn add<T>(_simd, addend: &[T], sum: &mut [T]) {
        for (sum, &addend) in sum.iter_mut().zip(addend) {
            *sum += addend;
        }
    }
}

vectorised! {
    /// sum ← (sum + a) + b.
    pub fn add_two<T>(_simd, a: &[T], b: &[T], sum: &mut [T]) {
        for ((sum, &a), &b) in sum.iter_mut().zip(a).zip(b) {
            *sum = (*sum + a) + b;
        }
    }
}

vectorised! {
    /// Sum of squares in a fixed order.
    pub fn sum_of_squares<T>(_simd, values: &[T]) -> T {
        let mut lanes = [T::ZERO; 16];
        for values in values.chunks_exact(16) {
            for (lane, &value) in lanes.iter_mut().zip(values) {
                *lane += value * value;
            }
        }
        let mut sum = T::ZERO;
        for &value in values.chunks_exact(16).remainder() {
            sum += value * value;
        }
        for lane in lanes {
            sum += lane;
        }
        sum
    }
}
