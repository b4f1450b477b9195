//! Contract: every store of energy is the textbook's formula; a body that moves as one has ½ M v² and M v; energy and
//! momentum do not depend on where the body is; sums are the sums of their parts.

use gaitshift_body::{Body, BodyParameters, BodyState, EnergyAccount, LEFT, RIGHT};

fn body() -> Body {
    Body::new(BodyParameters::default()).unwrap()
}

fn assert_near(value: f64, expected: f64) {
    let scale = expected.abs().max(1.0);
    assert!(
        (value - expected).abs() <= 1e-12 * scale,
        "{value} instead of {expected}"
    );
}

#[test]
fn springs_hold_half_k_x_squared() {
    let body = body();
    let p = body.parameters();
    let mut s = BodyState {
        z: 5.0,
        theta: 0.1,
        ..BodyState::default()
    };
    let leg = &mut s.legs[RIGHT];
    (leg.psi, leg.thigh, leg.tibia, leg.foot) = (0.4, 0.13, 0.1, 0.05);
    let e = body.energy(&s);
    let half = |k: f64, x: f64| 0.5 * k * x * x;
    // φ = ψ - θ of both legs; d = h - foot, w = h - tibia.
    let k = p.hip_stiffness_nm_per_rad;
    assert_near(e.hip_springs, half(k, 0.3) + half(k, -0.1));
    assert_near(e.k1, half(p.k1_n_per_m, 0.08));
    assert_near(e.k2, half(p.k2_n_per_m, 0.05));
    assert_near(e.k3, half(p.k3_n_per_m, 0.03));
    assert_near(e.stops, half(p.stop_stiffness_n_per_m, 0.13 - p.stroke_m));
    assert_eq!((e.kinetic, e.contact), (0.0, 0.0));
    assert_near(e.leg_springs(), e.k1 + e.k2 + e.k3);
    assert_near(e.elastic(), e.hip_springs + e.leg_springs());
    assert_near(e.total(), e.gravitational + e.elastic());
    assert_near(e.stored(), e.total() + e.stops);
}

#[test]
fn a_body_that_moves_as_one_has_half_m_v_squared() {
    let body = body();
    let mut s = BodyState::with_leg_angles(&body, [0.3, -0.2]);
    s.z += 1.0;
    let still = body.energy(&s);
    (s.x_dot, s.z_dot) = (1.5, -0.5);
    let e = body.energy(&s);
    let mass = body.parameters().total_mass_kg();
    assert_near(e.kinetic, 0.5 * mass * (1.5 * 1.5 + 0.5 * 0.5));
    assert_eq!(e.gravitational, still.gravitational);
    let momentum = body.momentum(&s);
    assert_near(momentum.x, mass * 1.5);
    assert_near(momentum.z, mass * -0.5);
    assert_near(momentum.angular, 0.0);
}

#[test]
fn height_costs_m_g_h_and_place_nothing() {
    let body = body();
    let p = body.parameters();
    let low = BodyState::standing(&body);
    let high = BodyState {
        x: 30.0,
        z: low.z + 0.7,
        ..low
    };
    let rise = body.energy(&high).gravitational - body.energy(&low).gravitational;
    assert_near(rise, p.total_mass_kg() * p.gravity_m_per_s2 * 0.7);
    // By the masses: the hip at the axis, each leg's parts hanging below it.
    let below = 2.0
        * (p.thigh_mass_kg * p.thigh_distance_m
            + p.tibia_mass_kg * p.tibia_distance_m
            + p.foot_mass_kg * p.foot_distance_m);
    let moment = p.total_mass_kg() * low.z - below;
    assert_near(body.energy(&low).gravitational, p.gravity_m_per_s2 * moment);
}

#[test]
fn a_swinging_leg_has_the_energy_of_its_parts() {
    let body = body();
    let p = body.parameters();
    let mut s = BodyState {
        z: 3.0,
        ..BodyState::default()
    };
    s.legs[LEFT].psi_dot = 2.0;
    let inertia = p.thigh_inertia_kg_m2
        + p.tibia_inertia_kg_m2
        + p.foot_inertia_kg_m2
        + p.thigh_mass_kg * p.thigh_distance_m.powi(2)
        + p.tibia_mass_kg * p.tibia_distance_m.powi(2)
        + p.foot_mass_kg * p.foot_distance_m.powi(2);
    assert_near(body.energy(&s).kinetic, 0.5 * inertia * 4.0);
    // A foot thrust down the leg: ½ m ṙ².
    s.legs[LEFT].psi_dot = 0.0;
    s.legs[LEFT].foot_dot = 0.6;
    assert_near(body.energy(&s).kinetic, 0.5 * p.foot_mass_kg * 0.36);
}

#[test]
fn the_account_adds_up() {
    let account = EnergyAccount {
        actuator_work: [1.0, -0.25],
        actuator_positive_work: [2.0, 0.5],
        hip_dampers: 0.1,
        c1: 0.2,
        c2: 0.3,
        stops: 0.4,
        contact_normal: 0.5,
        friction: 0.6,
        ..EnergyAccount::default()
    };
    assert_near(account.work(), 0.75);
    assert_near(account.positive_work(), 2.5);
    assert_near(account.dampers(), 0.6);
    assert_near(account.contact(), 1.1);
    assert_near(account.dissipated(), 2.1);
}

#[test]
fn the_centre_of_mass_is_where_gravity_and_momentum_say() {
    // Height from the gravitational energy, velocity from the momentum, both computed elsewhere; forward position by its
    // definition, body by body; and the velocity is the rate of the position.
    let body = Body::new(BodyParameters {
        hip_com_height_m: 0.07,
        ..BodyParameters::default()
    })
    .unwrap();
    let p = body.parameters();
    let mut s = BodyState::with_leg_angles(&body, [0.4, -0.3]);
    (s.x, s.z, s.theta) = (2.5, 1.4, 0.2);
    (s.x_dot, s.z_dot, s.theta_dot) = (1.1, -0.4, 0.9);
    let leg = &mut s.legs[LEFT];
    (leg.thigh, leg.tibia, leg.foot) = (0.05, 0.03, -0.02);
    (leg.psi_dot, leg.thigh_dot, leg.foot_dot) = (2.0, 0.3, -0.5);
    let mass = p.total_mass_kg();
    let centre = body.centre_of_mass(&s);
    assert_near(
        centre.z,
        body.energy(&s).gravitational / (mass * p.gravity_m_per_s2),
    );
    assert_near(centre.x_dot, body.momentum(&s).x / mass);
    assert_near(centre.z_dot, body.momentum(&s).z / mass);
    let mut moment = p.hip_mass_kg * (s.x - 0.07 * s.theta.sin());
    for leg in &s.legs {
        for (m, along) in [
            (p.thigh_mass_kg, p.thigh_distance_m + leg.thigh),
            (p.tibia_mass_kg, p.tibia_distance_m + leg.tibia),
            (p.foot_mass_kg, p.foot_distance_m + leg.foot),
        ] {
            moment += m * (s.x + along * leg.psi.sin());
        }
    }
    assert_near(centre.x, moment / mass);
    let mut later = s;
    let dt = 1e-7;
    later.x += s.x_dot * dt;
    later.z += s.z_dot * dt;
    later.theta += s.theta_dot * dt;
    for leg in &mut later.legs {
        leg.psi += leg.psi_dot * dt;
        leg.thigh += leg.thigh_dot * dt;
        leg.tibia += leg.tibia_dot * dt;
        leg.foot += leg.foot_dot * dt;
    }
    let moved = body.centre_of_mass(&later);
    assert!(((moved.x - centre.x) / dt - centre.x_dot).abs() < 1e-6);
    assert!(((moved.z - centre.z) / dt - centre.z_dot).abs() < 1e-6);
}
