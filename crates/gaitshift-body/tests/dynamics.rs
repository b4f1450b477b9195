//! Contract: in undamped flight energy and both momenta are conserved, their drift falling with the
//! step at the integrator's order; a push moves the whole body and is accounted for; mirrored states
//! move as mirror images to the last bit; a dropped body settles at the height that statics give;
//! no random body goes wrong without saying so.

use gaitshift_body::{Body, BodyParameters, BodyState, EnergyAccount, LEFT, RIGHT};
use proptest::prelude::*;

fn undamped(time_step_s: f64, hip_com_height_m: f64) -> Body {
    Body::new(BodyParameters {
        hip_damping_nms_per_rad: 0.0,
        c1_ns_per_m: 0.0,
        c2_ns_per_m: 0.0,
        stroke_m: 1.0,
        hip_com_height_m,
        time_step_s,
        ..BodyParameters::default()
    })
    .unwrap()
}

fn tumbling() -> BodyState {
    let mut s = BodyState {
        z: 50.0,
        theta: 0.2,
        x_dot: 1.3,
        z_dot: 0.4,
        theta_dot: -0.7,
        ..BodyState::default()
    };
    for (i, leg) in s.legs.iter_mut().enumerate() {
        let side = if i == RIGHT { 1.0 } else { -1.0 };
        leg.psi = 0.35 * side;
        leg.psi_dot = 2.1 * side + 0.5;
        leg.thigh = 0.02 * side;
        leg.foot = -0.01;
        leg.foot_dot = 0.3;
        leg.tibia_dot = -0.2 * side;
    }
    s
}

/// Largest drift of energy, and of the three momenta with gravity taken out, over 1 s.
fn drift(body: &Body) -> (f64, f64, f64) {
    let dt = body.parameters().time_step_s;
    let weight = body.parameters().total_mass_kg() * body.parameters().gravity_m_per_s2;
    let mut s = tumbling();
    let (e0, m0) = (body.energy(&s).stored(), body.momentum(&s));
    let (mut energy, mut linear, mut angular) = (0.0f64, 0.0f64, 0.0f64);
    let mut account = EnergyAccount::default();
    let steps = (1.0 / dt).round() as u32;
    for k in 1..=steps {
        assert!(!body.advance(&mut s, [0.0; 2], 1, &mut account).diverged);
        let m = body.momentum(&s);
        energy = energy.max((body.energy(&s).stored() - e0).abs());
        linear = linear.max((m.x - m0.x).abs());
        linear = linear.max((m.z - m0.z + weight * f64::from(k) * dt).abs());
        angular = angular.max((m.angular - m0.angular).abs());
    }
    (energy, linear, angular)
}

#[test]
fn flight_conserves_energy_and_momentum_at_first_order() {
    for offset in [0.0, 0.15] {
        let (e1, l1, a1) = drift(&undamped(2e-4, offset));
        let (e2, l2, a2) = drift(&undamped(2e-5, offset));
        println!(
            "offset {offset}: energy {e1:.2e} -> {e2:.2e} J, linear {l1:.2e} -> {l2:.2e} kg m/s, angular {a1:.2e} -> {a2:.2e} kg m²/s"
        );
        // Some 60 J of kinetic and elastic energy are in play.
        assert!(e1 < 0.5, "energy drift {e1} J");
        assert!(l1 < 0.02 && a1 < 0.02, "momentum drift {l1} {a1}");
        for (coarse, fine) in [(e1, e2), (l1, l2), (a1, a2)] {
            let ratio = coarse / fine;
            assert!(
                (8.0..12.5).contains(&ratio) || coarse < 1e-9,
                "ratio {ratio}"
            );
        }
    }
}

#[test]
fn flight_with_a_stationary_leg_falls_freely() {
    let body = undamped(1e-4, 0.0);
    let mut s = BodyState {
        z: 10.0,
        ..BodyState::default()
    };
    let a = body.accelerations(&s, [0.0; 2]);
    assert_eq!((a.x, a.theta), (0.0, 0.0));
    assert!((a.z + 9.81).abs() < 1e-12);
    body.advance(&mut s, [0.0; 2], 10_000, &mut EnergyAccount::default());
    assert!((s.z - (10.0 - 0.5 * 9.81)).abs() < 1e-3);
}

#[test]
fn a_push_on_the_hip_is_accounted_for_and_moves_the_whole_body() {
    // In flight momentum grows by the impulse (up to the step); on the ground the energy account closes with the push's work.
    let body = undamped(1e-4, 0.05);
    let mut s = tumbling();
    let before = body.momentum(&s);
    let mut account = EnergyAccount::default();
    let energy_j = body.energy(&s).stored();
    body.advance_pushed(&mut s, [0.0; 2], [80.0, -30.0], 1000, &mut account);
    let after = body.momentum(&s);
    let weight_n = body.parameters().total_mass_kg() * body.parameters().gravity_m_per_s2;
    assert!((after.x - before.x - 8.0).abs() < 0.01);
    assert!((after.z - before.z - 0.1 * (-30.0 - weight_n)).abs() < 0.05);
    assert!(account.external_work.abs() > 1.0);
    let residual_j = body.energy(&s).stored() - energy_j - account.external_work;
    assert!(residual_j.abs() < 0.02, "{residual_j} J");

    let body = Body::new(BodyParameters {
        time_step_s: 1e-5,
        ..BodyParameters::default()
    })
    .unwrap();
    let mut s = BodyState::with_leg_angles(&body, [0.2, -0.2]);
    let energy_j = body.energy(&s).stored();
    let mut account = EnergyAccount::default();
    body.advance_pushed(&mut s, [0.2, 0.1], [150.0, 0.0], 20_000, &mut account);
    let residual_j = body.energy(&s).stored() - energy_j - account.work() - account.external_work
        + account.dissipated();
    let exchanged_j = account.external_work + account.dissipated();
    assert!(account.external_work > 5.0);
    assert!(
        residual_j.abs() < 2e-3 * exchanged_j,
        "{residual_j} J of {exchanged_j} J"
    );
}

#[test]
fn a_dropped_body_settles_where_statics_say() {
    // Both soles flat under straight legs and the actuators holding the weight they carry.
    let body = Body::new(BodyParameters {
        // One sphere right under the leg makes the static height a closed form.
        foot_sphere_count: 1,
        hip_stiffness_nm_per_rad: 4000.0,
        hip_damping_nms_per_rad: 200.0,
        hip_inertia_kg_m2: 5.0,
        time_step_s: 1e-4,
        ..BodyParameters::default()
    })
    .unwrap();
    let p = body.parameters().clone();
    let mut s = BodyState::standing(&body);
    s.z += 0.01;
    let hold = 0.5 * p.hip_mass_kg * p.gravity_m_per_s2 / p.actuator_force_n;
    let mut account = EnergyAccount::default();
    let report = body.advance(&mut s, [hold; 2], 40_000, &mut account);
    assert!(!report.diverged);
    let contact_n = p.total_mass_kg() * p.gravity_m_per_s2 / 2.0;
    let sink = contact_n / p.contact_stiffness;
    let a = body.accelerations(&s, [hold * p.actuator_force_n; 2]);
    let carried = a.forces[0].contact.normal_n + a.forces[1].contact.normal_n;
    assert!((carried - 2.0 * contact_n).abs() < 0.5, "{carried} N");
    // Compression of the wobbling mechanism under thigh + hip share above and tibia at its middle:
    // thigh: k1 d + k3 w = (m_hip/2 + m_thigh) g; tibia: k2 (d - w) - k3 w = -m_tibia g... solved.
    let top = (0.5 * p.hip_mass_kg + p.thigh_mass_kg) * p.gravity_m_per_s2;
    let tibia = p.tibia_mass_kg * p.gravity_m_per_s2;
    // k1 d + k3 w = top; k2 (d - w) = k3 w + tibia
    let w = (p.k2_n_per_m * top / p.k1_n_per_m - tibia)
        / (p.k2_n_per_m + p.k3_n_per_m + p.k2_n_per_m * p.k3_n_per_m / p.k1_n_per_m);
    let d = (top - p.k3_n_per_m * w) / p.k1_n_per_m;
    assert!((s.legs[RIGHT].d() - d).abs() < 1e-5 && (s.legs[RIGHT].w() - w).abs() < 1e-5);
    let h = s.legs[RIGHT].thigh;
    let height = p.leg_length_m + h - d - sink;
    assert!((s.z - height).abs() < 1e-4, "{} against {height}", s.z);
}

fn random_state() -> impl Strategy<Value = BodyState> {
    (
        0.6..1.2f64,
        -1.0..1.0f64,
        prop::array::uniform6(-3.0..3.0f64),
        prop::array::uniform8(-1.0..1.0f64),
    )
        .prop_map(|(z, theta, v, q)| {
            let mut s = BodyState {
                z,
                theta,
                x_dot: v[0],
                z_dot: v[1],
                theta_dot: v[2],
                ..BodyState::default()
            };
            for i in [RIGHT, LEFT] {
                let leg = &mut s.legs[i];
                leg.psi = 0.8 * q[4 * i];
                leg.psi_dot = v[3 + i];
                leg.thigh = 0.12 * q[4 * i + 1];
                leg.foot = 0.1 * q[4 * i + 2];
                leg.tibia = 0.1 * q[4 * i + 3];
                leg.thigh_dot = v[5] * q[4 * i];
                leg.foot_dot = -v[5] * q[4 * i + 3];
            }
            s
        })
}

proptest! {
    #[test]
    fn mirrored_states_move_as_mirror_images_to_the_last_bit(
        s in random_state(), command in prop::array::uniform2(-1.0..1.0f64), offset in -0.2..0.2f64
    ) {
        let body = Body::new(BodyParameters { hip_com_height_m: offset, ..Default::default() }).unwrap();
        let (mut a, mut b) = (s, s.mirrored());
        let (mut ea, mut eb) = (EnergyAccount::default(), EnergyAccount::default());
        body.advance(&mut a, command, 200, &mut ea);
        body.advance(&mut b, [command[1], command[0]], 200, &mut eb);
        prop_assert_eq!(a.mirrored(), b);
        prop_assert_eq!(ea.dissipated(), eb.dissipated());
        prop_assert_eq!(body.energy(&a), body.energy(&b));
    }

    #[test]
    fn random_bodies_never_go_wrong_silently(
        s in random_state(),
        scale in prop::array::uniform8(0.05..20.0f64),
        commands in prop::collection::vec(prop::array::uniform2(-2.0..2.0f64), 40),
    ) {
        let d = BodyParameters::default();
        let body = Body::new(BodyParameters {
            hip_mass_kg: d.hip_mass_kg * scale[0],
            foot_mass_kg: d.foot_mass_kg * scale[1],
            hip_inertia_kg_m2: d.hip_inertia_kg_m2 * scale[2],
            k1_n_per_m: d.k1_n_per_m * scale[3],
            c1_ns_per_m: d.c1_ns_per_m * scale[4],
            contact_stiffness: d.contact_stiffness * scale[5],
            contact_dissipation_s_per_m: d.contact_dissipation_s_per_m * scale[6],
            actuator_force_n: d.actuator_force_n * scale[7],
            ..d
        }).unwrap();
        let mut s = s;
        let mut account = EnergyAccount::default();
        for command in commands {
            let report = body.advance(&mut s, command, 25, &mut account);
            if report.diverged {
                return Ok(());
            }
            prop_assert!(s.positions().iter().chain(&s.velocities()).all(|v| v.is_finite()));
            prop_assert!(body.energy(&s).stored().is_finite());
        }
    }
}
