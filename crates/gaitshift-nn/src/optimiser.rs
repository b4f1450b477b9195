//! A network with its optimiser: gradients summed from parts, steps of Adam, networks that follow behind.

use crate::adam::{self, AdamStep};
use crate::backward::Transposed;
use crate::buffer::Buffer;
use crate::layout::NamedTensor;
use crate::mlp::Mlp;
use crate::simd::Scalar;
use crate::workers::Workers;

/// Parameters that a task takes at a time: all its operands fit the first-level cache.
const RANGE: usize = 1024;

/// A network with what Adam remembers of it.
#[derive(Clone, Debug)]
pub struct Trained<T> {
    /// The network.
    pub network: Mlp<T>,
    /// Weights in the order of the backward pass.
    pub transposed: Transposed<T>,
    /// Gradient of the last update, in the layout of the parameters, as all below.
    pub gradient: Buffer<T>,
    /// First moment of Adam.
    pub first_moment: Buffer<T>,
    /// Second moment of Adam.
    pub second_moment: Buffer<T>,
    /// Adam steps made.
    pub steps: u64,
}

impl<T: Scalar> Trained<T> {
    /// Before the first step.
    pub fn new(network: Mlp<T>) -> Self {
        Self {
            transposed: network.transposed(),
            gradient: network.zeros_like(),
            first_moment: network.zeros_like(),
            second_moment: network.zeros_like(),
            steps: 0,
            network,
        }
    }

    /// Gradient of the last update, as named tensors.
    pub fn gradient(&self) -> Vec<NamedTensor<T>> {
        self.network.tensors_of(&self.gradient)
    }

    /// Recomputes the copies that the backward pass reads, after the parameters changed.
    pub fn refresh(&mut self) {
        self.network.refresh(&mut self.transposed);
    }
}

/// A step of Adam.
#[derive(Debug)]
pub struct Step<'a, T, const NETWORKS: usize> {
    /// Learning rate.
    pub learning_rate: f64,
    /// For each network one that follows behind: follower ← (1 − rate) follower + rate network.
    pub followers: [Option<(T, &'a mut Mlp<T>)>; NETWORKS],
}

/// Sums the gradients of networks and steps along them.
#[derive(Debug, Default)]
pub struct Optimiser {
    /// Sum of squares of each range of the gradients.
    squares: Vec<f64>,
}

impl Optimiser {
    /// Sums the gradient of each of the networks, which are of one size, from its parts, in their order. Gives the norms of
    /// the gradients.
    pub fn sum<T: Scalar, P: AsRef<[T]> + Sync, const NETWORKS: usize>(
        &mut self,
        workers: &mut Workers,
        mut networks: [&mut Trained<T>; NETWORKS],
        parts: [&[P]; NETWORKS],
    ) -> [f64; NETWORKS] {
        let gradients = networks
            .each_mut()
            .map(|network| [&mut network.gradient[..]]);
        self.for_each_range(workers, gradients, |network, from, [gradient], square| {
            *square = add_up(parts[network], from, gradient);
        })
    }

    /// Does as [`Optimiser::sum`], moves the parameters along the gradients, and the followers behind them; each range of
    /// parameters while the cache holds it.
    pub fn step<T: Scalar, P: AsRef<[T]> + Sync, const NETWORKS: usize>(
        &mut self,
        workers: &mut Workers,
        mut networks: [&mut Trained<T>; NETWORKS],
        parts: [&[P]; NETWORKS],
        step: Step<'_, T, NETWORKS>,
    ) -> [f64; NETWORKS] {
        let steps = networks.each_mut().map(|network| {
            network.steps += 1;
            AdamStep::new(network.steps, step.learning_rate)
        });
        let rates = step
            .followers
            .each_ref()
            .map(|follower| follower.as_ref().map_or(T::ZERO, |(rate, _)| *rate));
        let mut followers = step.followers.into_iter();
        let slices = networks.map(|network| {
            [
                &mut network.gradient[..],
                &mut network.network.parameters[..],
                &mut network.first_moment[..],
                &mut network.second_moment[..],
                match followers.next().flatten() {
                    Some((_, follower)) => &mut follower.parameters[..],
                    None => &mut [],
                },
            ]
        });
        self.for_each_range(
            workers,
            slices,
            |network,
             from,
             [gradient, parameters, first_moment, second_moment, follower],
             square| {
                *square = add_up(parts[network], from, gradient);
                adam::descend(
                    steps[network],
                    gradient,
                    parameters,
                    first_moment,
                    second_moment,
                );
                adam::follow(rates[network], parameters, follower);
            },
        )
    }

    /// Runs a task for each range of the networks' slices; gives the roots of the sums of what it left for each network.
    fn for_each_range<T: Scalar, const NETWORKS: usize, const SLICES: usize>(
        &mut self,
        workers: &mut Workers,
        networks: [[&mut [T]; SLICES]; NETWORKS],
        task: impl Fn(usize, usize, [&mut [T]; SLICES], &mut f64) + Sync,
    ) -> [f64; NETWORKS] {
        let ranges = networks[0][0].len().div_ceil(RANGE);
        let most = self.squares.len().max(NETWORKS * ranges);
        self.squares.resize(most, 0.0);
        workers.for_each_piece(RANGE, networks, &mut self.squares, task);
        std::array::from_fn(|network| {
            let squares = &self.squares[network * ranges..(network + 1) * ranges];
            squares.iter().sum::<f64>().sqrt()
        })
    }
}

/// gradient ← Σ of the parts from `from` on, in their order, two of them in one pass. Gives the sum of its squares.
fn add_up<T: Scalar>(parts: &[impl AsRef<[T]>], from: usize, gradient: &mut [T]) -> f64 {
    let range = from..from + gradient.len();
    let rest = match parts {
        [a, b, rest @ ..] => {
            let (a, b) = (&a.as_ref()[range.clone()], &b.as_ref()[range.clone()]);
            adam::sum_of_two(a, b, gradient);
            rest
        }
        parts => {
            gradient.copy_from_slice(&parts[0].as_ref()[range.clone()]);
            &parts[1..]
        }
    };
    for pair in rest.chunks(2) {
        let part = |index: usize| &pair[index].as_ref()[range.clone()];
        match pair.len() {
            2 => adam::add_two(part(0), part(1), gradient),
            _ => adam::add(part(0), gradient),
        }
    }
    adam::sum_of_squares(gradient).to_f64()
}
