//! Expressions of one's own over named quantities of a motion: compiled and checked where they are read, evaluated once
//! in every control period without allocating.

use crate::StepEnergies;
use gaitshift_body::{
    AdvanceReport, Body, BodyState, CentreOfMass, EnergyAccount, LEFT, MechanicalEnergy, RIGHT,
};
use nanoexpr::{Context, ErrorKind, Instruction, Math, Number, Program, evaluate_with};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Mutex, PoisonError};

/// Most instructions of an expression.
const MOST_INSTRUCTIONS: usize = 256;
/// Draws on which an expression is compared with its mirror image.
const MIRRORED_DRAWS: usize = 256;
/// Constants that an expression may use besides the quantities.
const CONSTANTS: [&str; 3] = ["pi", "tau", "e"];
/// Functions that an expression may use.
const FUNCTIONS: [&str; 31] = [
    "abs", "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "ceil", "clamp",
    "cos", "cosh", "exp", "floor", "hypot", "ln", "log", "log10", "log2", "max", "min", "pow",
    "round", "sign", "sin", "sinh", "sqrt", "tan", "tanh", "trunc",
];

/// The end of a control period, and what happened in it.
pub(crate) struct Moment<'a> {
    pub state: &'a BodyState,
    pub account: &'a EnergyAccount,
    pub report: &'a AdvanceReport,
    pub energies: StepEnergies,
    pub omega_v: f64,
    pub time_s: f64,
    pub ground_m: f64,
    pub sole_m: [f64; 2],
    pub command: [f64; 2],
    pub previous: [f64; 2],
    pub energy: MechanicalEnergy,
    pub centre: CentreOfMass,
}

impl<'a> Moment<'a> {
    /// The moment in which an episode begins, its actuators without force.
    pub fn at_start(body: &Body, state: &'a BodyState, report: &'a AdvanceReport) -> Self {
        const NONE: &EnergyAccount = &EnergyAccount {
            actuator_work: [0.0; 2],
            actuator_positive_work: [0.0; 2],
            hip_dampers: 0.0,
            c1: 0.0,
            c2: 0.0,
            stops: 0.0,
            contact_normal: 0.0,
            friction: 0.0,
            external_work: 0.0,
        };
        Self {
            state,
            account: NONE,
            report,
            energies: StepEnergies::default(),
            omega_v: 0.0,
            time_s: 0.0,
            ground_m: body.ground_height(state.x),
            sole_m: [RIGHT, LEFT].map(|leg| body.sole_height(state, leg)),
            command: [0.0; 2],
            previous: [0.0; 2],
            energy: body.energy(state),
            centre: body.centre_of_mass(state),
        }
    }
}

/// Declares the quantities once: their names and values.
macro_rules! quantities {
    (|$m:ident| $($name:literal $value:expr;)*) => {
        /// Names of the quantities that an expression may use.
        ///
        /// One that a recording has a column of is the same there: states and energies at the end of the control period,
        /// forces as means over it, works and losses since the episode began. `…_previous_command` are of the period
        /// before, `ground_height_m` is that of the ground below the hip axis, `…_sole_height_m` are those of
        /// the soles' lowest points over the ground, and `period_…` are of this period: the
        /// change of the energy that the reward penalises, the actuators' positive work, the loss to friction.
        pub const QUANTITIES: &[&str] = &[$($name),*];

        /// The values of all quantities.
        #[derive(Debug, Clone, Copy)]
        pub(crate) struct Quantities([f64; QUANTITIES.len()]);

        impl Quantities {
            pub fn of($m: &Moment<'_>) -> Self {
                Self([$($value),*])
            }
        }
    };
}

quantities! { |m|
    "time_s" m.time_s;
    "omega_v" m.omega_v;
    "x_m" m.state.x;
    "z_m" m.state.z;
    "theta_rad" m.state.theta;
    "x_velocity_m_per_s" m.state.x_dot;
    "z_velocity_m_per_s" m.state.z_dot;
    "theta_velocity_rad_per_s" m.state.theta_dot;
    "right_phi_rad" m.state.phi(RIGHT);
    "right_h_m" m.state.legs[RIGHT].thigh;
    "right_d_m" m.state.legs[RIGHT].d();
    "right_w_m" m.state.legs[RIGHT].w();
    "right_phi_velocity_rad_per_s" m.state.phi_dot(RIGHT);
    "right_h_velocity_m_per_s" m.state.legs[RIGHT].thigh_dot;
    "right_d_velocity_m_per_s" m.state.legs[RIGHT].d_dot();
    "right_w_velocity_m_per_s" m.state.legs[RIGHT].w_dot();
    "left_phi_rad" m.state.phi(LEFT);
    "left_h_m" m.state.legs[LEFT].thigh;
    "left_d_m" m.state.legs[LEFT].d();
    "left_w_m" m.state.legs[LEFT].w();
    "left_phi_velocity_rad_per_s" m.state.phi_dot(LEFT);
    "left_h_velocity_m_per_s" m.state.legs[LEFT].thigh_dot;
    "left_d_velocity_m_per_s" m.state.legs[LEFT].d_dot();
    "left_w_velocity_m_per_s" m.state.legs[LEFT].w_dot();
    "right_command" m.command[RIGHT];
    "left_command" m.command[LEFT];
    "right_previous_command" m.previous[RIGHT];
    "left_previous_command" m.previous[LEFT];
    "right_actuator_force_n" m.report.actuator_n[RIGHT];
    "right_normal_force_n" m.report.normal_n[RIGHT];
    "right_tangential_force_n" m.report.tangential_n[RIGHT];
    "left_actuator_force_n" m.report.actuator_n[LEFT];
    "left_normal_force_n" m.report.normal_n[LEFT];
    "left_tangential_force_n" m.report.tangential_n[LEFT];
    "kinetic_energy_j" m.energy.kinetic;
    "gravitational_energy_j" m.energy.gravitational;
    "hip_spring_energy_j" m.energy.hip_springs;
    "leg_spring_energy_j" m.energy.leg_springs();
    "elastic_energy_j" m.energy.elastic();
    "contact_energy_j" m.energy.contact;
    "stop_energy_j" m.energy.stops;
    "actuator_work_j" m.account.work();
    "actuator_positive_work_j" m.account.positive_work();
    "damper_dissipation_j" m.account.dampers();
    "contact_dissipation_j" m.account.contact();
    "stop_dissipation_j" m.account.stops;
    "com_x_m" m.centre.x;
    "com_z_m" m.centre.z;
    "com_x_velocity_m_per_s" m.centre.x_dot;
    "com_z_velocity_m_per_s" m.centre.z_dot;
    "ground_height_m" m.ground_m;
    "right_sole_height_m" m.sole_m[RIGHT];
    "left_sole_height_m" m.sole_m[LEFT];
    "period_energy_change_j" m.energies.change_j;
    "period_positive_work_j" m.energies.positive_work_j;
    "period_friction_loss_j" m.energies.friction_loss_j;
}

impl Quantities {
    /// Drawn at random, of either sign and any size that a quantity here may have, for tests of an expression.
    fn drawn(rng: &mut Xoshiro256PlusPlus) -> Self {
        Self(std::array::from_fn(|_| {
            let size = 10_f64.powf(7.0 * rng.random::<f64>() - 2.0);
            if rng.random() { size } else { -size }
        }))
    }

    /// Right and left exchanged.
    fn mirrored(&self) -> Self {
        Self(std::array::from_fn(|k| {
            let name = QUANTITIES[k];
            let other = match (name.strip_prefix("right_"), name.strip_prefix("left_")) {
                (Some(rest), _) => format!("left_{rest}"),
                (_, Some(rest)) => format!("right_{rest}"),
                _ => return self.0[k],
            };
            let place = QUANTITIES.iter().position(|name| *name == other);
            place.map_or(self.0[k], |k| self.0[k])
        }))
    }
}

impl Context<f64> for Quantities {
    fn variable(&self, name: &str) -> Option<f64> {
        match QUANTITIES.iter().position(|known| *known == name) {
            Some(k) => Some(self.0[k]),
            None => Math.variable(name),
        }
    }

    fn call(&self, name: &str, arguments: &[f64]) -> Option<Result<f64, ErrorKind>> {
        Math.call(name, arguments)
    }
}

/// A formula over [`QUANTITIES`], checked when it is made.
///
/// Numbers, `+ - * / %`, powers as `^` or `**`, comparisons and `&& || !`, which give 1 and 0, `condition ? a : b`, the usual
/// functions such as `abs`, `min`, `max`, `exp`, and the constants `pi`, `tau` and `e`.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Expression {
    text: String,
    compiled: Compiled,
}

/// A program that lives as long as the process: every text is compiled once, and configurations have few.
#[derive(Clone, Copy)]
struct Compiled(&'static Program<'static, 'static, f64>);

impl PartialEq for Compiled {
    /// The text says it all.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl fmt::Debug for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self.text, f)
    }
}

impl From<Expression> for String {
    fn from(expression: Expression) -> Self {
        expression.text
    }
}

impl TryFrom<String> for Expression {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let compiled = compile(&text)?;
        Ok(Self { text, compiled })
    }
}

/// The programs so far, by their texts.
static PROGRAMS: Mutex<BTreeMap<String, Compiled>> = Mutex::new(BTreeMap::new());

fn compile(text: &str) -> Result<Compiled, String> {
    let mut programs = PROGRAMS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = programs.get(text) {
        return Ok(*known);
    }
    check(text)?;
    let kept: &'static str = Box::leak(text.to_owned().into_boxed_str());
    let code = vec![Instruction::default(); text.len().min(MOST_INSTRUCTIONS)];
    let program: Program<'_, '_, f64> =
        nanoexpr::compile(kept, Box::leak(code.into())).map_err(|e| at(text, e))?;
    let compiled = Compiled(Box::leak(Box::new(program)));
    programs.insert(text.to_owned(), compiled);
    Ok(compiled)
}

/// Checks syntax, names and numbers of arguments, in branches that no value would enter too.
fn check(text: &str) -> Result<(), String> {
    let mut code = [Instruction::default(); MOST_INSTRUCTIONS];
    let compiled: Result<Program<'_, '_, f64>, _> = nanoexpr::compile(text, &mut code);
    compiled.map_err(|e| at(text, e))?;
    if is_chained(text) {
        return Err(format!(
            "the expression \"{text}\" compares the outcome of a comparison, which is 1 or 0; write `a < b && b < c` for `a < b < c`"
        ));
    }
    // Sums, whose every part is looked at, in the place of choices.
    let whole = text.replace("&&", "+ ").replace("||", "+ ");
    let whole = whole.replace(['?', ':'], "+");
    let names = Names::default();
    let evaluated: Result<Anything, _> = evaluate_with(&whole, &names);
    let wrong = names.0.take();
    match wrong {
        Some(cause) => Err(cause),
        None => evaluated.map(|_| ()).map_err(|e| at(text, e)),
    }
}

/// Whether `<`, `<=`, `>` or `>=` follow one another with nothing between that takes the outcome of the first: it would be
/// compared itself, which nobody means.
fn is_chained(text: &str) -> bool {
    // Within each pair of parentheses: whether there was one since.
    let (mut compared, mut before) = (vec![false], ' ');
    for c in text.chars() {
        match c {
            // Of `<=` and `>=`.
            '=' if matches!(before, '<' | '>') => {}
            '(' => compared.push(false),
            ')' if compared.len() > 1 => {
                compared.pop();
            }
            '<' | '>' => {
                if let Some(last) = compared.last_mut()
                    && std::mem::replace(last, true)
                {
                    return true;
                }
            }
            '=' | '&' | '|' | ',' | '?' | ':' => {
                if let Some(last) = compared.last_mut() {
                    *last = false;
                }
            }
            _ => {}
        }
        before = c;
    }
    false
}

/// What the compiler says, with the place.
fn at(text: &str, error: nanoexpr::Error) -> String {
    let place = match text.get(error.span.start..error.span.end) {
        Some(part) if !part.is_empty() => {
            let before = text[..error.span.start].chars().count();
            format!(": `{part}`, character {}", before + 1)
        }
        _ => ", at its end".to_owned(),
    };
    let part = text.get(error.span.start..error.span.end);
    let remedy = match part.map(str::trim) {
        Some("and") => "; write `&&`",
        Some("or") => "; write `||`",
        Some("not") => "; write `!`",
        Some("if" | "else") => "; write `condition ? this : that`",
        _ => "",
    };
    let shown = match text.char_indices().nth(200) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    };
    format!(
        "the expression \"{shown}\" has an error: {}{place}{remedy}",
        error.kind
    )
}

/// Notes the first name that is none.
#[derive(Default)]
struct Names(RefCell<Option<String>>);

impl Names {
    fn wrong(&self, cause: String) {
        self.0.borrow_mut().get_or_insert(cause);
    }
}

fn listed(names: &[&str]) -> String {
    let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    names.join(", ")
}

impl Context<Anything> for Names {
    fn variable(&self, name: &str) -> Option<Anything> {
        if !QUANTITIES.contains(&name) && !CONSTANTS.contains(&name) {
            self.wrong(format!(
                "unknown quantity `{name}`, expected one of {}, {}",
                listed(QUANTITIES),
                listed(&CONSTANTS)
            ));
        }
        Some(Anything)
    }

    fn call(&self, name: &str, arguments: &[Anything]) -> Option<Result<Anything, ErrorKind>> {
        let values = vec![0.5; arguments.len()];
        if !FUNCTIONS.contains(&name) {
            self.wrong(format!(
                "unknown function `{name}`, expected one of {}",
                listed(&FUNCTIONS)
            ));
        } else if name == "log" && values.len() == 1 {
            self.wrong(
                "`log` takes a number and a base, as in `log(x, 10)`; the natural logarithm is `ln(x)`"
                    .to_owned(),
            );
        } else if Math.call(name, &values) == Some(Err(ErrorKind::ArgumentCount)) {
            self.wrong(format!(
                "the function `{name}` has {} argument{} in the expression, which is not what it takes",
                values.len(),
                if values.len() == 1 { "" } else { "s" }
            ));
        }
        Some(Ok(Anything))
    }
}

/// A number whose value does not matter.
#[derive(Clone, Copy, Default)]
struct Anything;

impl Number for Anything {
    fn parse(literal: &str) -> Option<Self> {
        f64::parse(literal).map(|_| Self)
    }
    fn add(self, _: Self) -> Result<Self, ErrorKind> {
        Ok(self)
    }
    fn subtract(self, _: Self) -> Result<Self, ErrorKind> {
        Ok(self)
    }
    fn multiply(self, _: Self) -> Result<Self, ErrorKind> {
        Ok(self)
    }
    fn divide(self, _: Self) -> Result<Self, ErrorKind> {
        Ok(self)
    }
    fn remainder(self, _: Self) -> Result<Self, ErrorKind> {
        Ok(self)
    }
    fn power(self, _: Self) -> Result<Self, ErrorKind> {
        Ok(self)
    }
    fn negate(self) -> Result<Self, ErrorKind> {
        Ok(self)
    }
    fn compare(self, _: Self) -> Result<Ordering, ErrorKind> {
        Ok(Ordering::Equal)
    }
    fn factorial(self) -> Result<Self, ErrorKind> {
        Ok(self)
    }
}

impl Expression {
    /// As it was written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Its value; the reason if it has none, or none that is finite.
    pub(crate) fn evaluate(&self, quantities: &Quantities) -> Result<f64, &'static str> {
        match self.compiled.0.evaluate(quantities) {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) => Err("not finite"),
            Err(e) => Err(e.kind.description()),
        }
    }

    /// Whether it has the same value in a state and in its mirror image, as far as draws show.
    pub fn is_symmetric(&self) -> bool {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(0);
        (0..MIRRORED_DRAWS).all(|_| {
            let drawn = Quantities::drawn(&mut rng);
            match (self.evaluate(&drawn), self.evaluate(&drawn.mirrored())) {
                (Ok(a), Ok(b)) => (a - b).abs() <= 1e-9 * (1.0 + a.abs()),
                (a, b) => a.is_err() == b.is_err(),
            }
        })
    }
}
