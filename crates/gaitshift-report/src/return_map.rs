//! The return map of a gait: how a deviation from its stride grows or shrinks from one stride to the next.
//!
//! The section is where the right leg passes the left one forward, once a stride. A state on it has 20 coordinates, all but
//! the way travelled and the difference of the leg angles, which is 0. The controller begins its period at the section and acts every
//! millisecond, so that the map does not depend on where in a control period the section is met: with the usual period of 10 ms
//! a stride need not be a whole number of periods, and there would be no fixed point.
//!
//! The multipliers are the eigenvalues of the map's derivative at its fixed point (Floquet). Below 1 a gait is stable.
//!
//! Two things limit the differences. The networks count in single precision, so that a stride repeats to some 1e-6 only and
//! differences of that width measure rounding. And the map has kinks where contact begins or friction changes from sticking to
//! slipping: there a difference to one side is another than to the other, and no width makes them agree. Hence the differences
//! over decades of widths, central and to each side.

use crate::{ReportError, Subject};
use gaitshift_body::{Body, BodyState, EnergyAccount};
use gaitshift_experiment::{Control, Deterministic};
use gaitshift_task::{ACTION_SIZE, Environment, OBSERVATION_SIZE, scale_observation};
use serde::{Deserialize, Serialize};

/// Coordinates of a state on the section.
const SIZE: usize = 20;
/// How long the controller holds its commands, in s.
const HOLD_S: f64 = 0.001;
/// Longest stride, in s.
const LONGEST_S: f64 = 4.0;
/// Strides for the map to settle, and when it has.
const MOST_STRIDES: usize = 200;
const SETTLED: f64 = 2e-7;
/// A point that a stride changes by more than this is no fixed point.
const FIXED: f64 = 1e-5;
/// Widths of the differences, in m, rad, m/s and rad/s; and which of them the multiplier is from: the middle of those that agree.
const WIDTHS: [f64; 4] = [1e-6, 1e-5, 1e-4, 1e-3];
const WIDTH: usize = 2;
/// A real deviation, in every coordinate; strides over which it is followed; and where it ends in the point's own uncertainty.
const DEVIATION: f64 = 1e-3;
const FIRST_STRIDE: usize = 3;
const LAST_STRIDE: usize = 20;
const LEAST_DEVIATION: f64 = 5e-6;

/// A state on the section: height, pitch, the legs' common angle, their rates, forward speed, the rates of the leg angles, and of
/// each leg the displacements of thigh, tibia and foot with their rates.
pub type Section = [f64; SIZE];

/// The fixed point of a gait's return map, and its largest multiplier.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ReturnMap {
    /// The command.
    pub omega_v: f64,
    /// Time of a stride, in s.
    pub stride_s: f64,
    /// By how much a stride changes the point, as the greatest change of a coordinate: 0 at a fixed point.
    pub residual: f64,
    /// Largest amount of a multiplier, from central differences 1e-4 wide to each side; nothing without a fixed point.
    pub multiplier: Option<f64>,
    /// The same from differences of several widths and to either side: near it where the map is smooth.
    pub differences: [Differences; WIDTHS.len()],
    /// The same with commands held for the task's control period, which begins anew at the section.
    pub held: Option<f64>,
    /// By what factor a stride shrinks a real deviation, mean over some strides: the multiplier again, but for what is not linear.
    pub decay: Option<f64>,
}

/// Largest amounts of a multiplier from differences of one width.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Differences {
    /// How far the state is moved, in m, rad, m/s and rad/s.
    pub width: f64,
    /// From central differences.
    pub central: Option<f64>,
    /// From differences towards greater coordinates.
    pub forward: Option<f64>,
    /// From differences towards smaller coordinates.
    pub backward: Option<f64>,
}

impl ReturnMap {
    /// Follows a subject's default start to the fixed point of its stride, and differentiates the map there. Nothing if it
    /// falls or does not stride.
    ///
    /// # Errors
    /// None at present.
    pub fn find(subject: &mut Subject, omega_v: f64) -> Result<Option<Self>, ReportError> {
        let Subject {
            controller, body, ..
        } = subject;
        let start = Environment::default_start(body, &controller.task);
        let mut strider = Strider {
            body,
            policy: Deterministic(&mut controller.policy),
            omega_v,
            pitch_limit_rad: controller.task.termination.pitch_limit_rad,
            hold_s: HOLD_S,
        };
        let Some(cycle) = strider.settle(start) else {
            return Ok(None);
        };
        let differences = WIDTHS.map(|width| strider.differences(&cycle, width));
        let decay = cycle.fixed().then(|| strider.decay(&cycle.point)).flatten();
        strider.hold_s = controller.task.control_period_s;
        let held = strider
            .settle(start)
            .and_then(|cycle| strider.differences(&cycle, WIDTHS[WIDTH]).central);
        Ok(Some(Self {
            omega_v,
            stride_s: cycle.stride_s,
            residual: cycle.residual,
            multiplier: differences[WIDTH].central,
            differences,
            held,
            decay,
        }))
    }
}

/// Where a motion's strides lead.
struct Cycle {
    point: Section,
    stride_s: f64,
    residual: f64,
}

impl Cycle {
    fn fixed(&self) -> bool {
        self.residual < FIXED
    }
}

/// Moves a body from section to section.
struct Strider<'a> {
    body: &'a Body,
    policy: Deterministic<'a>,
    omega_v: f64,
    pitch_limit_rad: f64,
    hold_s: f64,
}

impl Strider<'_> {
    /// Follows a motion until a stride changes it no more, or long enough; nothing if it falls or does not stride.
    fn settle(&mut self, start: BodyState) -> Option<Cycle> {
        let (mut point, mut stride_s) = self.until_section(start)?;
        let mut residual = f64::INFINITY;
        for _ in 0..MOST_STRIDES {
            let (next, time_s) = self.stride(&point)?;
            residual = distance(&next, &point);
            (point, stride_s) = (next, time_s);
            if residual < SETTLED {
                break;
            }
        }
        Some(Cycle {
            point,
            stride_s,
            residual,
        })
    }

    /// The next point on the section and the time to it.
    fn stride(&mut self, point: &Section) -> Option<(Section, f64)> {
        self.until_section(state_of(point))
    }

    fn until_section(&mut self, mut s: BodyState) -> Option<(Section, f64)> {
        let dt = self.body.parameters().time_step_s;
        let steps = (self.hold_s / dt).round().max(1.0) as u32;
        let ahead = |s: &BodyState| s.legs[0].psi - s.legs[1].psi;
        let mut taken = 0_u32;
        while f64::from(taken) * dt < LONGEST_S {
            let observation = Environment::new(self.body, s, self.omega_v).observation();
            let mut scaled = [0.0; OBSERVATION_SIZE];
            scale_observation(&observation, &mut scaled);
            let mut action = [0.0; ACTION_SIZE];
            self.policy.act(&scaled, &mut action);
            let command = action.map(f64::from);
            for _ in 0..steps {
                let old = s;
                let mut account = EnergyAccount::default();
                let report = self.body.advance(&mut s, command, 1, &mut account);
                if report.diverged || s.theta.abs() > self.pitch_limit_rad {
                    return None;
                }
                let (before, after) = (ahead(&old), ahead(&s));
                if before < 0.0 && after >= 0.0 {
                    let share = before / (before - after);
                    let (a, b) = (point_of(&old), point_of(&s));
                    let point = std::array::from_fn(|k| a[k] + share * (b[k] - a[k]));
                    return Some((point, (f64::from(taken) + share) * dt));
                }
                taken += 1;
            }
        }
        None
    }

    /// Mean factor of a deviation from the fixed point from one stride to the next, once the quick parts are gone and until it is
    /// as small as the point is uncertain.
    fn decay(&mut self, point: &Section) -> Option<f64> {
        let mut moved = point.map(|value| value + DEVIATION);
        let mut distances = Vec::new();
        for _ in 0..LAST_STRIDE {
            moved = self.stride(&moved)?.0;
            distances.push(distance(&moved, point));
        }
        let mut seen = distances.iter().enumerate().skip(FIRST_STRIDE);
        let (first, from) = seen.next()?;
        let (last, to) = seen.take_while(|(_, d)| **d > LEAST_DEVIATION).last()?;
        Some((to / from).powf(1.0 / (last - first) as f64))
    }

    /// Largest multipliers at a fixed point; nothing at another.
    fn differences(&mut self, cycle: &Cycle, width: f64) -> Differences {
        let ends = cycle
            .fixed()
            .then(|| self.ends(&cycle.point, width))
            .flatten();
        let radius = |of: fn(&[Section; 3]) -> [&Section; 2], apart: f64| {
            let column = |ends: &[Section; 3]| {
                let [to, from] = of(ends);
                std::array::from_fn(|i| (to[i] - from[i]) / apart)
            };
            let columns: Vec<Section> = ends.as_ref()?.iter().map(column).collect();
            spectral_radius(&columns)
        };
        Differences {
            width,
            central: radius(|[down, _, up]| [up, down], 2.0 * width),
            forward: radius(|[_, here, up]| [up, here], width),
            backward: radius(|[down, here, _]| [here, down], width),
        }
    }

    /// Where strides end that begin `width` below a point, on it and `width` above it, in each coordinate.
    fn ends(&mut self, point: &Section, width: f64) -> Option<Vec<[Section; 3]>> {
        let here = self.stride(point)?.0;
        (0..SIZE)
            .map(|k| {
                let mut moved = |by: f64| {
                    let mut start = *point;
                    start[k] += by;
                    self.stride(&start).map(|(end, _)| end)
                };
                Some([moved(-width)?, here, moved(width)?])
            })
            .collect()
    }
}

fn distance(a: &Section, b: &Section) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

fn point_of(s: &BodyState) -> Section {
    let [r, l] = &s.legs;
    [
        s.z,
        s.theta,
        0.5 * (r.psi + l.psi),
        s.x_dot,
        s.z_dot,
        s.theta_dot,
        r.psi_dot,
        l.psi_dot,
        r.thigh,
        r.thigh_dot,
        r.tibia,
        r.tibia_dot,
        r.foot,
        r.foot_dot,
        l.thigh,
        l.thigh_dot,
        l.tibia,
        l.tibia_dot,
        l.foot,
        l.foot_dot,
    ]
}

fn state_of(point: &Section) -> BodyState {
    let leg = |psi_dot: f64, at: usize| gaitshift_body::LegState {
        psi: point[2],
        psi_dot,
        thigh: point[at],
        thigh_dot: point[at + 1],
        tibia: point[at + 2],
        tibia_dot: point[at + 3],
        foot: point[at + 4],
        foot_dot: point[at + 5],
    };
    BodyState {
        x: 0.0,
        z: point[0],
        theta: point[1],
        x_dot: point[3],
        z_dot: point[4],
        theta_dot: point[5],
        legs: [leg(point[6], 8), leg(point[7], 14)],
    }
}

/// Largest amount of an eigenvalue of a square matrix given by its columns: `lim ‖Mⁿ‖^(1/n)`, n a power of two (Gelfand). Real and
/// complex eigenvalues alike. Nothing if a number is not finite.
pub fn spectral_radius(columns: &[Section]) -> Option<f64> {
    /// 2³⁰ factors: what the norm adds vanishes, for matrices far from normal too.
    const SQUARINGS: i32 = 30;
    let mut power: Vec<Section> = columns.to_vec();
    // The logarithm of the size that was divided out, per factor of the product so far.
    let mut logarithm = 0.0;
    for squaring in 0..=SQUARINGS {
        let norm = power.iter().flatten().map(|v| v * v).sum::<f64>().sqrt();
        if norm == 0.0 {
            return Some(0.0);
        }
        if !norm.is_finite() {
            return None;
        }
        logarithm += norm.ln() / 2f64.powi(squaring);
        for value in power.iter_mut().flatten() {
            *value /= norm;
        }
        let square = |j: usize| -> Section {
            std::array::from_fn(|i| (0..power.len()).map(|k| power[k][i] * power[j][k]).sum())
        };
        power = (0..power.len()).map(square).collect();
    }
    Some(logarithm.exp())
}
