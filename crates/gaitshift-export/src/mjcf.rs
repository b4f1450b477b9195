//! The body as MJCF, the model format of MuJoCo.
//!
//! Bodies, joints, springs, dampers and actuators are the same: MuJoCo's `qpos` and `qvel` are
//! [`BodyState::positions`](gaitshift_body::BodyState::positions) and `velocities`, in their order and
//! with their signs. Off the ground both models have the same equations of motion.
//!
//! # Contact
//! MuJoCo computes contact forces from a constraint (its documentation, "Computation", "Constraint
//! model"): in the direct format of `solref`, with a constant impedance `d` and the constraint-space
//! inverse inertia `A` that MuJoCo takes from the body's `invweight0`, the normal force obeys
//!
//! `f R = -(b v + k d r) - a`,  `R = (1 - d) A / d`,  `f ≥ 0`
//!
//! with penetration `-r`, its rate and its acceleration `a`. That is a spring of `k d / R`, a damper of
//! `b / R` and an added mass of `1 / R`. With the smallest `d` that MuJoCo accepts the added mass vanishes
//! against the foot's, and spring and damper can be chosen freely: here the spring is the body's own
//! (`contact_exponent = 1`), while the damper, which Hunt and Crossley make proportional to the depth,
//! can be right at one load only, the nominal one. Friction is a damper of `impratio` times the normal
//! one, limited by Coulomb's cone.

use gaitshift_body::{Body, BodyParameters, ParameterError, Terrain};
use gaitshift_task::{Disturbance, Environment, TaskParameters};
use std::fmt::Write as _;

/// The smallest impedance that MuJoCo accepts (`mjMINIMP`).
const IMPEDANCE: f64 = 1e-4;
/// Least inertia that is written, in kg m²: MuJoCo refuses moving bodies without any.
const LEAST_INERTIA: f64 = 1e-12;

/// The contact of one sphere with the ground, linearised at the nominal load, as the MJCF has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NominalContact {
    /// The nominal load: half of the body's weight on one sphere, in N.
    pub load_n: f64,
    /// Depth under that load, in m.
    pub depth_m: f64,
    /// Spring that carries the nominal load at that depth, in N/m; the very stiffness if the exponent is 1.
    pub stiffness_n_per_m: f64,
    /// Damper with the dissipation of that depth, in N s/m.
    pub damping_ns_per_m: f64,
    /// Slope of friction over the sliding speed under the nominal load, in N s/m.
    pub friction_ns_per_m: f64,
}

impl NominalContact {
    /// The nominal contact of a body.
    pub fn new(p: &BodyParameters) -> Self {
        let gravity = if p.gravity_m_per_s2 > 0.0 {
            p.gravity_m_per_s2
        } else {
            9.81
        };
        let load_n = 0.5 * p.total_mass_kg() * gravity;
        let depth_m = (load_n / p.contact_stiffness).powf(1.0 / p.contact_exponent);
        let friction_ns_per_m = p.friction * load_n / p.friction_smoothing_m_per_s;
        // The friction's slope is a multiple of this damper: a body without dissipation gets a trace.
        let least = 1e-3 * friction_ns_per_m;
        Self {
            load_n,
            depth_m,
            stiffness_n_per_m: if depth_m.is_finite() {
                load_n / depth_m
            } else {
                0.0
            },
            damping_ns_per_m: (load_n * p.contact_dissipation_s_per_m).max(least),
            friction_ns_per_m,
        }
    }
}

/// Mean over the three axes of the foot's inverse inertia at its centre of mass, body upright, in 1/kg:
/// MuJoCo's `body_invweight0`, by which it scales the contact.
fn foot_inverse_weight(p: &BodyParameters) -> f64 {
    let parts = [
        (p.thigh_mass_kg, p.thigh_distance_m, p.thigh_inertia_kg_m2),
        (p.tibia_mass_kg, p.tibia_distance_m, p.tibia_inertia_kg_m2),
        (p.foot_mass_kg, p.foot_distance_m, p.foot_inertia_kg_m2),
    ];
    let mass: f64 = parts.iter().map(|b| b.0).sum();
    let first: f64 = parts.iter().map(|b| b.0 * b.1).sum();
    let second: f64 = parts.iter().map(|b| b.0 * b.1 * b.1 + b.2).sum();
    let offset = p.hip_mass_kg * p.hip_com_height_m;
    let hip = p.hip_mass_kg - offset * offset / (p.hip_inertia_kg_m2 + offset * p.hip_com_height_m)
        + 2.0 * (mass - first * first / second);
    // Across the leg a unit force moves the hip and turns the leg (docs/physics.md); along it, it moves
    // the foot alone; out of the plane nothing moves.
    let hip_x = (1.0 - first * p.foot_distance_m / second) / hip;
    let turn = (p.foot_distance_m - first * hip_x) / second;
    let across = hip_x + p.foot_distance_m * turn;
    (across + 1.0 / p.foot_mass_kg) / 3.0
}

/// The attributes of a delay of some steps, which MuJoCo keeps in a buffer of as many commands.
fn delay(steps: u32, step_s: f64) -> String {
    if steps == 0 {
        return String::new();
    }
    format!(
        r#" delay="{:?}" nsample="{steps}" interp="zoh""#,
        f64::from(steps) * step_s
    )
}

/// The body as the text of an MJCF file, SI units and radians. The task gives the keyframe `start`, its default
/// start, and the number `control_period_s`, for which a policy's action is held. Of the disturbance it has the ground and what the
/// actuators are; noise and pushes are none of a model's: MuJoCo does not apply the `noise` of a sensor.
///
/// # Errors
/// Parameters that are not valid ([`BodyParameters::validate`]).
///
/// Ground that is not flat is a plane where it is one slope, and otherwise boxes side by side, each under one piece: in a
/// hollow corner a sphere feels both of them, while ours feels the nearer one.
pub fn mjcf(
    parameters: &BodyParameters,
    task: &TaskParameters,
    disturbance: &Disturbance,
) -> Result<String, ParameterError> {
    let p = parameters;
    let body = disturbance.place(Body::new(p.clone())?);
    let start = Environment::default_start(&body, task);
    let contact = NominalContact::new(p);
    // f R = -(b v + k d r) - a with R = (1 - d) A / d; MuJoCo divides what solref gives by d and d².
    let scale = (1.0 - IMPEDANCE) * foot_inverse_weight(p);
    let solref_stiffness = contact.stiffness_n_per_m * scale;
    let solref_damping = contact.damping_ns_per_m * scale;
    let impratio = if contact.friction_ns_per_m > 0.0 {
        contact.friction_ns_per_m / contact.damping_ns_per_m
    } else {
        1.0
    };
    let mut legs = String::new();
    let mut tendons = String::new();
    let mut motors = String::new();
    let sides = [("right", "0.84 0.37 0 1"), ("left", "0 0.45 0.70 1")];
    for ((side, rgba), factor) in sides.into_iter().zip(disturbance.actuator_factor) {
        legs.push_str(&leg(p, side, rgba));
        let _ = write!(
            tendons,
            r#"
    <fixed name="{side}_k2" springlength="0" stiffness="{k2:?}" damping="{c2:?}">
      <joint joint="{side}_d" coef="1"/>
      <joint joint="{side}_w" coef="-1"/>
    </fixed>
    <fixed name="{side}_stop" springlength="{lower:?} {upper:?}" stiffness="{stop:?}">
      <joint joint="{side}_h" coef="1"/>
    </fixed>"#,
            k2 = p.k2_n_per_m,
            c2 = p.c2_ns_per_m,
            lower = -p.stroke_m,
            upper = p.stroke_m,
            stop = p.stop_stiffness_n_per_m,
        );
        let _ = write!(
            motors,
            "\n    <motor name=\"{side}\" joint=\"{side}_h\" gear=\"{:?}\" ctrlrange=\"-1 1\"{}/>",
            factor * p.actuator_force_n,
            delay(disturbance.latency_steps(p.time_step_s), p.time_step_s)
        );
    }
    let sensors: String = SENSORS
        .iter()
        .map(|(kind, joint)| format!("\n    <{kind} name=\"{joint}_{kind}\" joint=\"{joint}\"/>"))
        .collect();
    Ok(format!(
        r#"<!-- A planar biped with passive hips, written by `gaitshift export mjcf`. SI units and radians.

     qpos: x, z, theta, then right phi, h, d, w, then left phi, h, d, w; qvel likewise. x and z are the hip axis
     over the ground; angles are positive when they swing a leg forward (about -y); h is the thigh's displacement
     down the leg, d the compression between thigh and foot, w that between thigh and tibia.
     ctrl: right, left actuator in units of their greatest force, held for a control period.
     sensordata: the observation of the controller but for its last element, the command omega_v.
     Keyframe "start": the controller's default start, one leg in front and moving. From the pose at rest, which is
     symmetric, a symmetric controller does not step. Numeric "control_period_s": how long an action is held.

     The same as in gaitshift: masses, inertias, springs, dampers, actuators, gravity, and the integrator
     (semi-implicit Euler with the same step). Off the ground, and with |h| within the stroke, both follow the
     same equations. For a longer step use integrator="implicitfast".

     Different:
     - Normal contact force of a sphere at the depth r: gaitshift k r^n (1 + c r'), after Hunt and Crossley, with
       k = {k:?}, n = {n:?}, c = {c:?}; here a spring of {k_here:?} N/m and a damper of
       {b_here:?} N s/m, the same at the nominal load of {load:?} N (half the weight on one sphere).
       At other loads the damping differs, and the force jumps at touchdown, where Hunt's and Crossley's begins at 0.
     - Friction: gaitshift mu f v / sqrt(v^2 + v_s^2) with v_s = {vs:?} m/s; here a damper of {ft:?} N s/m
       (the slope of that curve at the nominal load) limited to mu f.
     - End stops beyond the stroke: the same spring, without Hunt's and Crossley's dissipation of {stop:?} s/m.
-->
<mujoco model="gaitshift">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="{dt:?}" gravity="0 0 {gravity:?}" integrator="Euler" cone="elliptic" impratio="{impratio:?}">
    <flag eulerdamp="disable"/>
  </option>

  <default>
    <default class="sole">
      <!-- A constant impedance: with it, solref is a spring and a damper (see above). -->
      <geom type="sphere" size="{sphere:?}" contype="1" conaffinity="0" priority="1" condim="3" friction="{mu:?} 0 0"
            solref="{solref_k:?} {solref_b:?}" solimp="{d:?} {d:?} 0.001 0.5 1"/>
    </default>
    <default class="visual">
      <geom contype="0" conaffinity="0" group="1"/>
    </default>
  </default>

  <asset>
    <texture name="grid" type="2d" builtin="checker" rgb1="0.93 0.93 0.93" rgb2="0.84 0.84 0.84" width="256" height="256"/>
    <material name="grid" texture="grid" texrepeat="2 2" texuniform="true"/>
  </asset>

  <worldbody>
    <light pos="0 -2 4" dir="0 0.4 -1" directional="true"/>
    <camera name="side" mode="trackcom" pos="0 -3 0.6" xyaxes="1 0 0 0 0.1 1"/>
{ground}
    <body name="hip" pos="0 0 {l:?}">
      <joint name="x" type="slide" axis="1 0 0"/>
      <joint name="z" type="slide" axis="0 0 1" ref="{l:?}"/>
      <joint name="theta" type="hinge" axis="0 -1 0"/>
      <inertial mass="{hip_mass:?}" pos="0 0 {hip_com:?}" diaginertia="{hip_inertia:?} {hip_inertia:?} {hip_inertia:?}"/>
      <geom class="visual" type="box" size="0.15 0.08 0.1" pos="0 0 {hip_com:?}" rgba="0.5 0.5 0.5 1"/>{legs}
    </body>
  </worldbody>

  <!-- k2 and c2 act between tibia and foot, on d - w. The end stops are springs with a dead band, the stroke. -->
  <tendon>{tendons}
  </tendon>

  <actuator>{motors}
  </actuator>

  <sensor>{sensors}
  </sensor>

  <custom>
    <numeric name="control_period_s" data="{period:?}"/>
  </custom>

  <keyframe>
    <key name="start" qpos="{qpos}" qvel="{qvel}"/>
  </keyframe>
</mujoco>
"#,
        ground = ground(body.terrain()),
        period = task.control_period_s,
        qpos = numbers(&start.positions()),
        qvel = numbers(&start.velocities()),
        k = p.contact_stiffness,
        n = p.contact_exponent,
        c = p.contact_dissipation_s_per_m,
        k_here = contact.stiffness_n_per_m,
        b_here = contact.damping_ns_per_m,
        load = contact.load_n,
        vs = p.friction_smoothing_m_per_s,
        ft = contact.friction_ns_per_m,
        stop = p.stop_dissipation_s_per_m,
        dt = p.time_step_s,
        gravity = -p.gravity_m_per_s2,
        sphere = p.foot_sphere_radius_m,
        mu = p.friction,
        solref_k = -solref_stiffness,
        solref_b = -solref_damping,
        d = IMPEDANCE,
        l = p.leg_length_m,
        hip_mass = p.hip_mass_kg,
        hip_com = p.hip_com_height_m,
        hip_inertia = p.hip_inertia_kg_m2,
    ))
}

/// How far the first and the last piece of the ground reach, and how deep its boxes are, in m.
const GROUND_REACH_M: f64 = 100.0;
const GROUND_DEPTH_M: f64 = 1.0;

/// The ground as geoms.
fn ground(terrain: Option<&Terrain>) -> String {
    const LAST: &str = r#"material="grid" contype="0" conaffinity="1"/>"#;
    let Some(terrain) = terrain else {
        return format!(r#"    <geom name="ground" type="plane" size="0 0 1" {LAST}"#);
    };
    let mut points = terrain.outline();
    let angle = |a: [f64; 2], b: [f64; 2]| (b[1] - a[1]).atan2(b[0] - a[0]);
    let (first, last) = (points[0], points[points.len() - 1]);
    let slope = angle(first, last);
    if points
        .windows(2)
        .all(|p| (angle(p[0], p[1]) - slope).abs() < 1e-12)
    {
        let [x, z] = first;
        return format!(
            r#"    <geom name="ground" type="plane" size="0 0 1" pos="{x:?} 0 {z:?}" euler="0 {:?} 0" {LAST}"#,
            -slope
        );
    }
    // The outer points lie a metre beyond the corners; the same lines go on.
    let beyond = |corner: [f64; 2], outer: [f64; 2]| {
        let way = [outer[0] - corner[0], outer[1] - corner[1]];
        [
            corner[0] + GROUND_REACH_M * way[0],
            corner[1] + GROUND_REACH_M * way[1],
        ]
    };
    let end = points.len() - 1;
    points[0] = beyond(points[1], points[0]);
    points[end] = beyond(points[end - 1], points[end]);
    // A vertical face is the side of the box that ends there.
    let pieces = points.windows(2).filter(|p| p[1][0] > p[0][0]);
    let boxes = pieces.enumerate().map(|(k, p)| {
        let (a, b, angle) = (p[0], p[1], angle(p[0], p[1]));
        let half = 0.5 * (b[0] - a[0]).hypot(b[1] - a[1]);
        let (sin, cos) = angle.sin_cos();
        let x = 0.5 * (a[0] + b[0]) + 0.5 * GROUND_DEPTH_M * sin;
        let z = 0.5 * (a[1] + b[1]) - 0.5 * GROUND_DEPTH_M * cos;
        format!(
            r#"    <geom name="ground_{k}" type="box" size="{half:?} 5 {:?}" pos="{x:?} 0 {z:?}" euler="0 {:?} 0" {LAST}"#,
            0.5 * GROUND_DEPTH_M,
            -angle
        )
    });
    boxes.collect::<Vec<_>>().join("\n")
}

fn numbers(values: &[f64]) -> String {
    let texts: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
    texts.join(" ")
}

/// The observation in its order, but for the command.
const SENSORS: [(&str, &str); 13] = [
    ("jointvel", "x"),
    ("jointpos", "theta"),
    ("jointvel", "theta"),
    ("jointpos", "right_h"),
    ("jointvel", "right_h"),
    ("jointpos", "left_h"),
    ("jointvel", "left_h"),
    ("jointpos", "right_phi"),
    ("jointvel", "right_phi"),
    ("jointpos", "left_phi"),
    ("jointvel", "left_phi"),
    ("jointvel", "right_d"),
    ("jointvel", "left_d"),
];

/// One leg: the thigh on hinge and slide, foot and tibia on slides of their own.
fn leg(p: &BodyParameters, side: &str, rgba: &str) -> String {
    let mut spheres = String::new();
    for index in 0..p.foot_sphere_count {
        let (x, z) = gaitshift_body::sphere_center(p, 0.0, 0.0, index);
        let _ = write!(
            spheres,
            "\n          <geom class=\"sole\" name=\"{side}_sole_{index}\" pos=\"{x:?} 0 {z:?}\" rgba=\"{rgba}\"/>"
        );
    }
    let inertia = |i: f64| {
        let i = i.max(LEAST_INERTIA);
        format!("{i:?} {i:?} {i:?}")
    };
    // The parts are drawn over their halves of the leg.
    let l = p.leg_length_m;
    format!(
        r#"
      <body name="{side}_thigh">
        <joint name="{side}_phi" type="hinge" axis="0 -1 0" stiffness="{k_hip:?}" damping="{c_hip:?}"/>
        <joint name="{side}_h" type="slide" axis="0 0 -1"/>
        <inertial mass="{thigh:?}" pos="0 0 {thigh_at:?}" diaginertia="{thigh_inertia}"/>
        <geom class="visual" type="capsule" size="{thick:?}" fromto="0 0 0 0 0 {knee:?}" rgba="{rgba}"/>
        <body name="{side}_foot">
          <joint name="{side}_d" type="slide" axis="0 0 1" stiffness="{k1:?}" damping="{c1:?}"/>
          <inertial mass="{foot:?}" pos="0 0 {foot_at:?}" diaginertia="{foot_inertia}"/>{spheres}
        </body>
        <body name="{side}_tibia">
          <joint name="{side}_w" type="slide" axis="0 0 1" stiffness="{k3:?}"/>
          <inertial mass="{tibia:?}" pos="0 0 {tibia_at:?}" diaginertia="{tibia_inertia}"/>
          <geom class="visual" type="capsule" size="{thin:?}" fromto="0 0 {knee:?} 0 0 {ankle:?}" rgba="{rgba}"/>
        </body>
      </body>"#,
        k_hip = p.hip_stiffness_nm_per_rad,
        c_hip = p.hip_damping_nms_per_rad,
        thigh = p.thigh_mass_kg,
        thigh_at = -p.thigh_distance_m,
        thigh_inertia = inertia(p.thigh_inertia_kg_m2),
        thick = 0.05 * l,
        thin = 0.035 * l,
        knee = -0.5 * l,
        ankle = -0.9 * l,
        k1 = p.k1_n_per_m,
        c1 = p.c1_ns_per_m,
        foot = p.foot_mass_kg,
        foot_at = -p.foot_distance_m,
        foot_inertia = inertia(p.foot_inertia_kg_m2),
        k3 = p.k3_n_per_m,
        tibia = p.tibia_mass_kg,
        tibia_at = -p.tibia_distance_m,
        tibia_inertia = inertia(p.tibia_inertia_kg_m2),
    )
}
