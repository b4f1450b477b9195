//! Contract: the ground's height is that of the lines through its points; ground that is flat at height 0 moves a body to the
//! same bits as no terrain at all, and flat ground at another height as much higher; on a slope a sphere is pressed on along
//! the slope's normal; over slopes, corners and vertical faces power, stored energy and losses balance and the energy account
//! closes; mirrored states move as mirror images to the last bit; a body is put where its lower sole just touches.

use gaitshift_body::{Body, BodyParameters, BodyState, EnergyAccount, LEFT, RIGHT, Terrain};
use proptest::prelude::*;

fn flat() -> Body {
    Body::new(BodyParameters::default()).unwrap()
}

fn on(points: &[(f64, f64)], before: f64, after: f64) -> Body {
    flat().on(Terrain::through(points, before, after).unwrap())
}

/// A slope up, a step up and one down, and a ridge.
fn rough() -> Body {
    on(
        &[
            (0.1, 0.0),
            (0.1, 0.04),
            (0.5, 0.04),
            (0.5, 0.0),
            (0.7, 0.03),
            (0.9, -0.02),
        ],
        -0.1,
        0.15,
    )
}

#[test]
fn heights_are_those_of_the_lines() {
    let terrain = Terrain::through(&[(1.0, 0.0), (1.0, 0.1), (2.0, 0.3)], -0.5, 0.25).unwrap();
    for (x, height) in [
        (-1.0, 1.0),
        (0.999_999, 5e-7),
        (1.0, 0.1),
        (1.5, 0.2),
        (2.0, 0.3),
        (6.0, 1.3),
    ] {
        assert!((terrain.height(x) - height).abs() < 1e-12, "{x}");
    }
    let outline = terrain.outline();
    let expected = [[0.0, 0.5], [1.0, 0.0], [1.0, 0.1], [2.0, 0.3], [3.0, 0.55]];
    assert_eq!(outline.len(), expected.len());
    for (point, expected) in outline.iter().zip(expected) {
        assert!((point[0] - expected[0]).abs() < 1e-12 && (point[1] - expected[1]).abs() < 1e-12);
    }
}

#[test]
fn what_is_no_profile_is_refused() {
    assert!(Terrain::through(&[], 0.0, 0.0).is_none());
    assert!(Terrain::through(&[(1.0, 0.0), (0.9, 0.0)], 0.0, 0.0).is_none());
    assert!(Terrain::through(&[(0.0, f64::NAN)], 0.0, 0.0).is_none());
    assert!(Terrain::through(&[(0.0, 0.0)], f64::INFINITY, 0.0).is_none());
}

/// Falls, bounces and rolls for a while.
fn tumble(body: &Body, start: BodyState, steps: u32) -> (BodyState, EnergyAccount) {
    let (mut state, mut account) = (start, EnergyAccount::default());
    for k in 0..steps / 50 {
        let swing = (0.3 * f64::from(k)).sin();
        let command = [0.4 + 0.4 * swing, 0.4 - 0.4 * swing];
        let report = body.advance(&mut state, command, 50, &mut account);
        assert!(!report.diverged);
    }
    (state, account)
}

fn start(body: &Body, x: f64) -> BodyState {
    let mut state = BodyState {
        x,
        ..BodyState::default()
    };
    (state.legs[RIGHT].psi, state.legs[LEFT].psi) = (0.3, -0.2);
    state.z = body.lowest_hip_height(&state) + 0.02;
    state.x_dot = 0.8;
    state
}

#[test]
fn flat_ground_is_no_terrain_to_the_same_bits() {
    let (plain, same) = (flat(), on(&[(-1.0, 0.0), (3.0, 0.0)], 0.0, 0.0));
    assert!(same.terrain().is_none());
    let state = start(&plain, 0.0);
    assert_eq!(tumble(&plain, state, 3000), tumble(&same, state, 3000));
}

#[test]
fn higher_flat_ground_is_flat_ground_higher() {
    let (low, high) = (flat(), on(&[(0.0, 0.25)], 0.0, 0.0));
    let state = start(&low, 0.0);
    let mut raised = state;
    raised.z += 0.25;
    assert!((high.lowest_hip_height(&raised) + 0.02 - raised.z).abs() < 1e-12);
    let (a, account_a) = tumble(&low, state, 2000);
    let (b, account_b) = tumble(&high, raised, 2000);
    let (qa, qb) = (a.positions(), b.positions());
    for i in 0..11 {
        let shift = if i == 1 { 0.25 } else { 0.0 };
        assert!((qb[i] - qa[i] - shift).abs() < 1e-9, "coordinate {i}");
    }
    assert!((account_a.dissipated() - account_b.dissipated()).abs() < 1e-7);
    assert!(account_a.contact() > 0.1);
}

#[test]
fn a_slope_presses_along_its_normal() {
    // One sphere at rest, 4 mm in the slope: only the spring, along the normal, through the sphere's centre.
    let p = BodyParameters {
        foot_sphere_count: 1,
        ..BodyParameters::default()
    };
    let slope: f64 = 0.2;
    let terrain = Terrain::through(&[(0.0, 0.0)], slope.tan(), slope.tan()).unwrap();
    let body = Body::new(p.clone()).unwrap().on(terrain);
    let mut state = BodyState::standing(&body);
    let depth = 0.004;
    state.x += depth * slope.sin();
    state.z -= depth * slope.cos();
    let contact = body.foot_contact(&state, RIGHT);
    let force = p.contact_stiffness * depth;
    assert!((contact.tangential_n + force * slope.sin()).abs() < 1e-6 * force);
    assert!((contact.normal_n - force * slope.cos()).abs() < 1e-6 * force);
    let lever = p.leg_length_m - p.foot_sphere_radius_m;
    assert!((contact.moment_nm + force * slope.sin() * lever).abs() < 1e-6 * force);
    // Sliding down the slope is braked up the slope, by Coulomb's share of the force.
    (state.x_dot, state.z_dot) = (-3.0 * slope.cos(), -3.0 * slope.sin());
    let sliding = body.foot_contact(&state, RIGHT);
    let share = 3.0 / f64::hypot(3.0, p.friction_smoothing_m_per_s);
    let along = sliding.tangential_n * slope.cos() + sliding.normal_n * slope.sin();
    assert!((along - p.friction * force * share).abs() < 1e-6 * force);
}

#[test]
fn the_energy_account_closes_over_slopes_corners_and_faces() {
    let relative = |time_step_s: f64| {
        let p = BodyParameters {
            time_step_s,
            ..BodyParameters::default()
        };
        let terrain = rough().terrain().unwrap().clone();
        let body = Body::new(p).unwrap().on(terrain);
        let mut worst = 0.0_f64;
        for k in 0..12 {
            let mut state = start(&body, 0.09 * f64::from(k) - 0.2);
            let stored_j = body.energy(&state).stored();
            let mut account = EnergyAccount::default();
            let steps = (0.4 / time_step_s).round() as u32;
            assert!(
                !body
                    .advance(&mut state, [0.5, 0.3], steps, &mut account)
                    .diverged
            );
            assert!(account.contact() > 1.0);
            let residual_j =
                body.energy(&state).stored() - stored_j - account.work() + account.dissipated();
            let exchanged_j = account.positive_work() + account.dissipated();
            worst = worst.max((residual_j / exchanged_j).abs());
        }
        println!("step {time_step_s}: residual {worst:.5} of the energy exchanged");
        worst
    };
    let (coarse, fine) = (relative(2e-4), relative(2e-5));
    assert!(coarse < 1e-2 && fine < 1e-3, "{coarse} {fine}");
}

proptest! {
    #[test]
    fn mirrored_states_move_as_mirror_images_to_the_last_bit(x in -0.5..1.2f64, front in -0.4..0.4f64, rear in -0.4..0.4f64) {
        let body = rough();
        let mut state = start(&body, x);
        (state.legs[RIGHT].psi, state.legs[LEFT].psi) = (front, rear);
        state.z = body.lowest_hip_height(&state);
        let mut mirrored = state.mirrored();
        let mut account = EnergyAccount::default();
        body.advance(&mut state, [0.7, 0.2], 500, &mut account);
        let work = account.actuator_work;
        let mut account = EnergyAccount::default();
        body.advance(&mut mirrored, [0.2, 0.7], 500, &mut account);
        prop_assert_eq!(mirrored, state.mirrored());
        prop_assert_eq!(account.actuator_work, [work[1], work[0]]);
    }

    #[test]
    fn the_lower_sole_just_touches(x in -0.5..1.2f64, front in -0.6..0.6f64, rear in -0.6..0.6f64) {
        let body = rough();
        let mut state = BodyState { x, ..BodyState::default() };
        (state.legs[RIGHT].psi, state.legs[LEFT].psi) = (front, rear);
        state.z = body.lowest_hip_height(&state);
        let touches = |state: &BodyState| {
            [RIGHT, LEFT].iter().any(|&leg| body.foot_contact(state, leg).elastic_j > 0.0)
        };
        prop_assert!(!touches(&state));
        state.z -= 1e-6;
        prop_assert!(touches(&state));
    }

    #[test]
    fn power_stored_energy_and_losses_balance(
        x in -0.5..1.2f64, psi in -0.6..0.6f64, depth in 0.0..0.01f64, psi_dot in -3.0..3.0f64,
        x_dot in -2.0..2.0f64, z_dot in -0.3..0.3f64,
    ) {
        let body = rough();
        let mut state = BodyState { x, ..BodyState::default() };
        state.legs = [state.legs[0]; 2];
        (state.legs[RIGHT].psi, state.legs[LEFT].psi) = (psi, psi);
        state.z = body.lowest_hip_height(&state) - depth;
        (state.x_dot, state.z_dot) = (x_dot, z_dot);
        state.legs[RIGHT].psi_dot = psi_dot;
        let contact = body.foot_contact(&state, RIGHT);
        prop_assert!(contact.normal_loss_w >= 0.0 && contact.friction_loss_w >= 0.0);
        let stored_at = |dt: f64| {
            let mut moved = state;
            moved.x += dt * x_dot;
            moved.z += dt * z_dot;
            moved.legs[RIGHT].psi += dt * psi_dot;
            body.foot_contact(&moved, RIGHT).elastic_j
        };
        let dt = 1e-7;
        let stored_w = (stored_at(dt) - stored_at(-dt)) / (2.0 * dt);
        // Where the nearest place jumps from one face to another within the difference, the rate has no single value.
        let (before, after) = ((stored_at(0.0) - stored_at(-dt)) / dt, (stored_at(dt) - stored_at(0.0)) / dt);
        prop_assume!((before - after).abs() < 1.0);
        let given_w = -(contact.tangential_n * x_dot + contact.normal_n * z_dot + contact.moment_nm * psi_dot);
        let taken_w = stored_w + contact.normal_loss_w + contact.friction_loss_w;
        let scale = 1.0 + given_w.abs() + contact.friction_loss_w;
        prop_assert!((given_w - taken_w).abs() < 2e-3 * scale, "{} given, {} taken", given_w, taken_w);
    }
}
