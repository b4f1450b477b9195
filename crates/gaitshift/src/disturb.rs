//! What disturbs a motion: the options of the command line, their values, and the file.

use crate::failure::Failure;
use clap::Args;
use gaitshift_experiment::{did_you_mean, load_disturbance};
use gaitshift_task::{Disturbance, Push, SensorNoise, TerrainParameters, TerrainStep};
use std::path::{Path, PathBuf};

/// Where a step of the ground is if nothing else is said, in m.
const STEP_AT_M: f64 = 3.0;

/// Noise of one observation.
#[derive(Debug, Clone, PartialEq)]
pub struct Noise {
    /// Its field in [`SensorNoise`].
    name: String,
    deviation: f64,
}

/// What is left of the force of the right and the left actuator, where something is said about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Weak([Option<f64>; 2]);

/// An inclination of the ground.
#[derive(Debug, Clone, PartialEq)]
pub struct Slope {
    rad: f64,
    from_m: Option<f64>,
}

/// Ground that is not flat; as it stands, it is.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Disturbances")]
pub struct GroundArguments {
    /// Inclination of the ground with its unit, rising forward: 3deg, -0.05rad or 5%; starting at X m as
    /// 3deg@2
    #[arg(long, value_name = "ANGLE[@X]", allow_hyphen_values = true, value_parser = slope)]
    pub slope: Option<Slope>,

    /// A step up of the ground in m, e.g. 0.03, or with its unit, as 3cm; at X = 3 m if not given; may be
    /// given several times
    #[arg(long, value_name = "HEIGHT[@X]", allow_hyphen_values = true, value_parser = step)]
    pub step_up: Vec<TerrainStep>,

    /// A step down of the ground, in the same form
    #[arg(long, value_name = "HEIGHT[@X]", allow_hyphen_values = true, value_parser = step)]
    pub step_down: Vec<TerrainStep>,

    /// Uneven ground from 1 m on: every 0.25 m a height drawn between plus and minus HEIGHT, in m or with its unit, as 1cm,
    /// joined by straight lines
    #[arg(long, value_name = "HEIGHT", allow_hyphen_values = true, value_parser = height)]
    pub uneven: Option<f64>,
}

impl GroundArguments {
    /// Puts the options over a ground, or adds them to it.
    fn put_over(&self, terrain: &mut TerrainParameters) {
        if let Some(slope) = &self.slope {
            (terrain.slope_rad, terrain.slope_from_m) = (slope.rad, slope.from_m);
        }
        let down = self.step_down.iter().map(|step| TerrainStep {
            height_m: -step.height_m,
            ..*step
        });
        terrain
            .steps
            .extend(self.step_up.iter().copied().chain(down));
        if let Some(height_m) = self.uneven {
            terrain.uneven.height_m = height_m;
        }
    }
}

/// Actuators that are weak or late; as it stands, neither.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Disturbances")]
pub struct ActuatorArguments {
    /// Delay from the controller's command to the actuator's force in s, 0 to 1; or with its unit, as 20ms
    #[arg(long, value_name = "S", allow_hyphen_values = true, value_parser = latency)]
    pub latency: Option<f64>,

    /// Share of their force that the actuators keep, 0 to 1; for one leg right=0.5 or left=0.5; may be given several times
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = weak)]
    pub weak: Vec<Weak>,
}

impl ActuatorArguments {
    /// Puts the options over a disturbance.
    fn put_over(&self, d: &mut Disturbance) {
        if let Some(latency_s) = self.latency {
            d.latency_s = latency_s;
        }
        for Weak(factors) in &self.weak {
            for (old, new) in d.actuator_factor.iter_mut().zip(factors) {
                *old = new.unwrap_or(*old);
            }
        }
    }
}

/// What of a disturbance a model for another simulator can have.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Disturbances")]
pub struct ModelArguments {
    /// The actuators.
    #[command(flatten)]
    pub actuators: ActuatorArguments,

    /// The ground.
    #[command(flatten)]
    pub ground: GroundArguments,

    /// Ground and actuators from a file as for `evaluate --disturbance`; one with noise or pushes is refused; options override
    /// it or are added to it
    #[arg(long, value_name = "FILE.toml")]
    pub disturbance: Option<PathBuf>,
}

impl ModelArguments {
    /// The file's disturbance with the options put over it. Noise and pushes are refused: MuJoCo applies none that a model gives.
    pub fn read(&self) -> Result<Disturbance, Failure> {
        let mut d = match &self.disturbance {
            Some(path) => load_disturbance(path).map_err(Failure::input)?,
            None => Disturbance::default(),
        };
        if d.noise != SensorNoise::default() || !d.pushes.is_empty() {
            return Err(Failure::input(format!(
                "{}: MuJoCo applies no `noise` or `pushes` that a model gives; remove them from the file, and apply them in the script that \
                 runs the model",
                self.disturbance
                    .as_deref()
                    .unwrap_or(Path::new(""))
                    .display()
            )));
        }
        self.actuators.put_over(&mut d);
        self.ground.put_over(&mut d.terrain);
        d.validate().map_err(Failure::input)?;
        Ok(d)
    }
}

/// What disturbs a motion; as it stands, nothing.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Disturbances")]
pub struct DisturbanceArguments {
    /// Noise on one observation of the controller, e.g. --noise theta_velocity=0.1; may be given several
    /// times, or as a list
    ///
    /// NAME is x_velocity (forward speed of the hip, m/s), theta (pitch of the trunk, rad), theta_velocity (its rate, rad/s),
    /// phi (angle of a hip joint, rad), phi_velocity (rad/s), h (displacement of the thigh along the leg, m), h_velocity
    /// (m/s) or d_velocity (rate of the leg's compression, m/s); SD is the standard deviation in that unit. It is drawn anew
    /// in every control period, for each leg separately.
    #[arg(long, value_name = "NAME=SD", value_delimiter = ',', value_parser = noise)]
    pub noise: Vec<Noise>,

    /// The actuators.
    #[command(flatten)]
    pub actuators: ActuatorArguments,

    /// Pushes on the hip.
    // Texts of their own: brackets in a comment would be links.
    #[arg(long, value_name = "PUSH", allow_hyphen_values = true, value_parser = push,
          help = "Push the hip: FORWARD[:UP]@START[+PHASE][,DURATION], e.g. --push 100@5; may be given several times",
          long_help = "\
Push the hip: FORWARD[:UP]@START[+PHASE][,DURATION], e.g. --push 100@5; may be given several times

Forces in N, negative ones backward and down; times in s, DURATION 0.1 if not given. With +PHASE, from 0 to below 1, the \
push begins at this phase of the stride that begins with the right foot's first touchdown from START on: \
--push -150:40@5+0.25,0.2 pushes back and up for 0.2 s, a quarter of a stride after it.")]
    pub push: Vec<Push>,

    /// The ground.
    #[command(flatten)]
    pub ground: GroundArguments,

    /// File with all of this.
    #[arg(
        long,
        value_name = "FILE.toml",
        help = "Disturbances from a TOML file, which has more settings; options override it or are added to it",
        long_help = "\
Disturbances from a TOML file, which has more settings; options override it or are added to it

A file with every kind of setting (noise also: x_velocity_m_per_s, theta_rad, h_m, h_velocity_m_per_s, \
phi_velocity_rad_per_s, d_velocity_m_per_s):
  latency_s = 0.02
  actuator_factor = [0.8, 1.0]                # right, left
  noise = { theta_velocity_rad_per_s = 0.1, phi_rad = 0.02 }
  [[pushes]]
  forward_n = 100
  up_n = 0
  start_s = 5
  duration_s = 0.1
  phase = 0.25                                # without it exactly at start_s
  [terrain]
  slope_rad = 0.05
  slope_from_m = 2                            # without it everywhere
  steps = [{ height_m = 0.03, at_m = 3 }]
  uneven = { height_m = 0.01, spacing_m = 0.25, from_m = 1, length_m = 100, seed = 0 }"
    )]
    pub disturbance: Option<PathBuf>,
}

impl DisturbanceArguments {
    /// The file's disturbance with the options put over it; nothing if it changes nothing.
    pub fn read(&self) -> Result<Option<Disturbance>, Failure> {
        let mut d = match &self.disturbance {
            Some(path) => load_disturbance(path).map_err(Failure::input)?,
            None => Disturbance::default(),
        };
        for noise in &self.noise {
            if let Some(deviation) = d.noise.named_mut(&noise.name) {
                *deviation = noise.deviation;
            }
        }
        self.actuators.put_over(&mut d);
        d.pushes.extend(&self.push);
        self.ground.put_over(&mut d.terrain);
        d.validate().map_err(Failure::input)?;
        Ok((!d.is_none()).then_some(d))
    }
}

/// A number, with or without one of the units, in the unit with the factor 1.
fn quantity(text: &str, units: &[(&str, f64)]) -> Result<f64, String> {
    let text = text.trim();
    let with_unit = units.iter().find_map(|(unit, factor)| {
        let number = text.strip_suffix(unit)?.trim_end();
        Some(number.parse::<f64>().ok()? * factor)
    });
    let number = with_unit.or_else(|| text.parse().ok());
    number
        .filter(|value: &f64| value.is_finite())
        .ok_or_else(|| {
            let units: Vec<&str> = units.iter().map(|(unit, _)| *unit).collect();
            match units[..] {
                [] => format!("`{text}` is not a number"),
                _ => format!(
                    "`{text}` is not a number, or not one in {}",
                    units.join(" or ")
                ),
            }
        })
}

/// What stands before and after the first of such a sign.
fn around(text: &str, sign: char) -> (&str, Option<&str>) {
    match text.split_once(sign) {
        Some((before, after)) => (before, Some(after)),
        None => (text, None),
    }
}

/// `theta_velocity=0.1`, with or without the unit in the name.
pub fn noise(text: &str) -> Result<Noise, String> {
    let (name, deviation) = text
        .split_once('=')
        .ok_or_else(|| "expected NAME=SD, for instance theta_velocity=0.1".to_owned())?;
    let deviation = quantity(deviation, &[])?;
    if deviation < 0.0 {
        return Err("a standard deviation is 0 or greater".to_owned());
    }
    let name = name.trim();
    let short = |full: &str| -> String {
        let units = ["_m_per_s", "_rad_per_s", "_rad", "_m"];
        let unit = units.iter().find_map(|unit| full.strip_suffix(unit));
        unit.unwrap_or(full).to_owned()
    };
    let known = SensorNoise::NAMES.into_iter();
    match known
        .clone()
        .find(|&full| full == name || short(full) == name)
    {
        Some(full) => Ok(Noise {
            name: full.to_owned(),
            deviation,
        }),
        None => {
            let names: Vec<String> = known.map(|full| format!("`{}`", short(full))).collect();
            Err(did_you_mean(&format!(
                "unknown observation `{name}`, expected one of {}",
                names.join(", ")
            )))
        }
    }
}

/// `0.8` of both actuators, or `right=0.5`.
pub fn weak(text: &str) -> Result<Weak, String> {
    let (side, factor) = match text.split_once('=') {
        Some((side, factor)) => (side.trim(), factor),
        None => ("both", text),
    };
    let factor = quantity(factor, &[("%", 0.01)])?;
    if !(0.0..=1.0).contains(&factor) {
        return Err("it must be from 0 (no force) to 1".to_owned());
    }
    match side {
        "both" => Ok(Weak([Some(factor); 2])),
        "right" => Ok(Weak([Some(factor), None])),
        "left" => Ok(Weak([None, Some(factor)])),
        _ => Err(format!("`{side}` is neither `right` nor `left`")),
    }
}

/// `FORWARD[:UP]@START[+PHASE][,DURATION]`.
pub fn push(text: &str) -> Result<Push, String> {
    let newtons = |text: &str| {
        let impulse = text.strip_suffix("N s").or(text.strip_suffix("Ns"));
        if let Some(n_s) = impulse.and_then(|number| number.trim().parse::<f64>().ok()) {
            let force_n = n_s / Push::default().duration_s;
            return Err(format!(
                "`{text}` is an impulse; give the force, here {force_n:.0} for 0.1 s"
            ));
        }
        quantity(text, &[("N", 1.0)])
    };
    let seconds = |text| quantity(text, &[("ms", 1e-3), ("s", 1.0)]);
    let (force, time) = text
        .split_once('@')
        .ok_or_else(|| "expected FORCE@START, for instance 100@5 or -80:20@5,0.2".to_owned())?;
    let (forward, up) = around(force, ':');
    let (start, duration) = around(time, ',');
    let (start, phase) = around(start, '+');
    let push = Push {
        forward_n: newtons(forward)?,
        up_n: up.map(newtons).transpose()?.unwrap_or(0.0),
        start_s: seconds(start)?,
        duration_s: match duration {
            Some(duration) => seconds(duration)?,
            None => Push::default().duration_s,
        },
        phase: phase
            .map(|phase| quantity(phase, &[("%", 0.01)]))
            .transpose()?,
    };
    if push.start_s < 0.0 || push.duration_s <= 0.0 {
        return Err("START must be 0 s or later, and DURATION longer than 0 s".to_owned());
    }
    if push.phase.is_some_and(|phase| !(0.0..1.0).contains(&phase)) {
        return Err("PHASE must be from 0 to below 1, as in 100@5+0.25".to_owned());
    }
    Ok(push)
}

fn metres(text: &str) -> Result<f64, String> {
    quantity(text, &[("mm", 1e-3), ("cm", 0.01), ("m", 1.0)])
}

/// `3deg`, `0.05rad` or `5%`, with `@X` where it begins.
pub fn slope(text: &str) -> Result<Slope, String> {
    let (angle, from) = around(text, '@');
    let number = |unit| angle.trim().strip_suffix(unit);
    let rad = if let Some(percent) = number("%") {
        (quantity(percent, &[])? / 100.0).atan()
    } else if number("deg").or(number("rad")).is_some() {
        quantity(angle, &[("deg", 1f64.to_radians()), ("rad", 1.0)])?
    } else if let Some(degrees) = number("°") {
        quantity(degrees, &[])?.to_radians()
    } else {
        return Err(format!(
            "`{angle}` needs a unit: for instance 3deg, 0.05rad or 5%"
        ));
    };
    if rad.abs() > TerrainParameters::STEEPEST_RAD {
        let steepest = TerrainParameters::STEEPEST_RAD;
        return Err(format!(
            "it must be between -{steepest} and {steepest} rad, which is {:.1}°; in degrees as 3deg",
            steepest.to_degrees()
        ));
    }
    Ok(Slope {
        rad,
        from_m: from.map(metres).transpose()?,
    })
}

/// `0.03`, with `@X` where it is.
pub fn step(text: &str) -> Result<TerrainStep, String> {
    let (height, at) = around(text, '@');
    let height_m = metres(height)?;
    if !(0.0..=1.0).contains(&height_m) {
        return Err(
            "its height must be from 0 to 1 m; --step-up and --step-down give the direction"
                .to_owned(),
        );
    }
    Ok(TerrainStep {
        height_m,
        at_m: at.map(metres).transpose()?.unwrap_or(STEP_AT_M),
    })
}

/// A height, with or without its unit.
pub fn height(text: &str) -> Result<f64, String> {
    let height_m = metres(text)?;
    if !(0.0..=1.0).contains(&height_m) {
        return Err("it must be from 0 to 1 m".to_owned());
    }
    Ok(height_m)
}

/// A delay in s, with or without its unit.
pub fn latency(text: &str) -> Result<f64, String> {
    let latency_s = quantity(text, &[("ms", 1e-3), ("s", 1.0)])?;
    if !(0.0..=1.0).contains(&latency_s) {
        return Err("it must be from 0 to 1 s; in milliseconds as 10ms".to_owned());
    }
    Ok(latency_s)
}

/// A disturbance in a few words.
pub fn describe(d: &Disturbance) -> String {
    let mut words = Vec::new();
    let mut noise = d.noise;
    for name in SensorNoise::NAMES {
        if let Some(deviation) = noise.named_mut(name).filter(|deviation| **deviation > 0.0) {
            words.push(format!("noise {name} {deviation}"));
        }
    }
    if d.latency_s > 0.0 {
        words.push(format!("latency {} s", d.latency_s));
    }
    let [right, left] = d.actuator_factor;
    if right == left && right != 1.0 {
        words.push(format!("actuators at {right} of their force"));
    } else if right != left {
        words.push(format!(
            "right actuator at {right} of its force, left {left}"
        ));
    }
    for p in &d.pushes {
        let up = if p.up_n == 0.0 {
            String::new()
        } else {
            format!(" and {} N up", p.up_n)
        };
        let when = match p.phase {
            Some(phase) => format!("at phase {phase} of the stride after {} s", p.start_s),
            None => format!("at {} s", p.start_s),
        };
        words.push(format!(
            "push of {} N forward{up} for {} s {when}",
            p.forward_n, p.duration_s
        ));
    }
    let t = &d.terrain;
    if t.slope_rad != 0.0 {
        let from = t
            .slope_from_m
            .map_or_else(String::new, |x| format!(" from {x} m on"));
        let degrees = (t.slope_rad.to_degrees() * 100.0).round() / 100.0;
        words.push(format!("slope {degrees}°{from}"));
    }
    for step in t.steps.iter().filter(|s| s.height_m != 0.0) {
        words.push(format!(
            "step {} of {} m at {} m",
            if step.height_m > 0.0 { "up" } else { "down" },
            step.height_m.abs(),
            step.at_m
        ));
    }
    if t.uneven.height_m > 0.0 {
        words.push(format!(
            "uneven ground of ± {} m, seed {}",
            t.uneven.height_m, t.uneven.seed
        ));
    }
    words.join(", ")
}
