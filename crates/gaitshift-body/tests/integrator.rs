//! Contract: in a contact-rich motion the energy account closes, closer with a finer step, and no loss is
//! negative; the step agrees with a finer one; a push of nothing is none; what diverges says so.

use gaitshift_body::{Body, BodyParameters, BodyState, EnergyAccount, RIGHT};

/// A contact-rich motion: dropped with some speed and hopped by a fixed rhythm of commands.
fn hop(body: &Body, seconds: f64) -> (BodyState, EnergyAccount, f64, f64) {
    let mut s = BodyState::with_leg_angles(body, [0.25, -0.2]);
    s.z += 0.05;
    s.x_dot = 0.7;
    let start = body.energy(&s).stored();
    let mut account = EnergyAccount::default();
    let period = 5e-3;
    let steps = (period / body.parameters().time_step_s).round() as u32;
    for k in 0..(seconds / period).round() as u32 {
        let t = f64::from(k) * period;
        let command = [0.5 + 0.3 * (12.0 * t).sin(), 0.5 - 0.3 * (12.0 * t).sin()];
        assert!(!body.advance(&mut s, command, steps, &mut account).diverged);
    }
    let exchanged = account.positive_work() + account.dissipated();
    let residual = body.energy(&s).stored() - start - account.work() + account.dissipated();
    (s, account, residual, exchanged)
}

#[test]
fn the_energy_account_closes() {
    let at = |dt| {
        Body::new(BodyParameters {
            time_step_s: dt,
            ..BodyParameters::default()
        })
        .unwrap()
    };
    let relative = |dt| {
        let (_, account, residual, exchanged) = hop(&at(dt), 1.0);
        assert!(
            account.contact() > 1.0 && account.dampers() > 1.0 && account.positive_work() > 10.0
        );
        println!("step {dt}: residual {residual:.4} J of {exchanged:.1} J exchanged");
        (residual / exchanged).abs()
    };
    let (coarse, fine) = (relative(2e-4), relative(2e-5));
    assert!(coarse < 1e-2, "{coarse}");
    assert!(fine < 1e-3, "{fine}");
}

#[test]
fn no_push_and_a_push_of_nothing_move_alike_and_are_not_written_down() {
    let body = Body::new(BodyParameters::default()).unwrap();
    let start = BodyState::with_leg_angles(&body, [0.3, -0.2]);
    let (mut plain, mut pushed) = (start, start);
    let (mut account, mut pushed_account) = <(EnergyAccount, EnergyAccount)>::default();
    body.advance(&mut plain, [0.4, -0.3], 500, &mut account);
    body.advance_pushed(&mut pushed, [0.4, -0.3], [0.0; 2], 500, &mut pushed_account);
    assert_eq!(plain, pushed);
    assert_eq!(account, pushed_account);
}

#[test]
fn every_dissipation_is_positive() {
    let (_, a, _, _) = hop(&Body::new(BodyParameters::default()).unwrap(), 1.5);
    for (name, loss) in [
        ("hip", a.hip_dampers),
        ("c1", a.c1),
        ("c2", a.c2),
        ("stops", a.stops),
        ("normal", a.contact_normal),
        ("friction", a.friction),
    ] {
        assert!(loss >= 0.0, "{name} {loss}");
    }
}

#[test]
fn the_step_agrees_with_a_tenfold_finer_one() {
    let run = |dt: f64| {
        let body = Body::new(BodyParameters {
            time_step_s: dt,
            ..BodyParameters::default()
        })
        .unwrap();
        hop(&body, 0.4).0
    };
    let (a, b, c) = (run(2e-4), run(2e-5), run(2e-6));
    let error = |p: &BodyState, q: &BodyState| {
        p.positions()
            .iter()
            .zip(q.positions())
            .map(|(p, q)| (p - q).abs())
            .fold(0.0, f64::max)
    };
    println!(
        "largest difference of a coordinate after 0.4 s: {:.2e}, a tenth of the step: {:.2e}",
        error(&a, &b),
        error(&b, &c)
    );
    assert!(error(&a, &b) < 5e-3);
    assert!(error(&b, &c) < 0.3 * error(&a, &b));
}

#[test]
fn a_diverging_body_says_so() {
    // A hundredfold damper on the light foot is beyond what the step resolves.
    let body = Body::new(BodyParameters {
        c1_ns_per_m: 1e5,
        ..BodyParameters::default()
    })
    .unwrap();
    let mut s = BodyState::with_leg_angles(&body, [0.2, -0.2]);
    s.legs[RIGHT].foot_dot = 0.1;
    let report = body.advance(&mut s, [0.3; 2], 2000, &mut EnergyAccount::default());
    assert!(report.diverged);
}
