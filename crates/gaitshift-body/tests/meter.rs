//! Contract: a meter changes nothing; its sums and extremes are those of every integration step, taken one by one; over both
//! legs they are the account's; mirrored motions have mirrored meters.

use gaitshift_body::{Body, BodyParameters, BodyState, EnergyAccount, LEFT, Meter, RIGHT, Terrain};

const STEPS: u32 = 50;

/// A body that drops onto the ground, hops, and hits its end stops.
fn start(body: &Body) -> BodyState {
    let mut s = BodyState::with_leg_angles(body, [0.25, -0.2]);
    s.z += 0.05;
    s.x_dot = 1.2;
    s
}

fn command(period: usize) -> [f64; 2] {
    let wave = |phase: f64| (0.13 * period as f64 + phase).sin();
    [wave(0.0), 0.9 * wave(1.7)]
}

fn near(value: f64, expected: f64, what: &str) {
    let scale = expected.abs().max(1e-3);
    assert!(
        (value - expected).abs() <= 1e-9 * scale,
        "{what}: {value} instead of {expected}"
    );
}

/// Sums of one leg by definition, from accelerations and states that anyone can ask the body for.
#[derive(Default)]
struct BruteForce {
    peak: f64,
    touching: u32,
    work: f64,
    positive: f64,
    squared: f64,
    impulse: f64,
    at_stop: f64,
    spring_release: f64,
    hip_release: f64,
    stop_release: f64,
    losses: [f64; 6],
}

#[test]
fn sums_are_those_of_every_step_taken_one_by_one() {
    let body = Body::new(BodyParameters::default()).unwrap();
    let p = body.parameters().clone();
    let dt = p.time_step_s;
    let (mut metered, mut meter) = (start(&body), Meter::default());
    let (mut plain, mut single) = (metered, metered);
    let (mut account, mut plain_account) = (EnergyAccount::default(), EnergyAccount::default());
    let mut brute: [BruteForce; 2] = Default::default();
    let half = |k: f64, x: f64| 0.5 * k * x * x;
    let mut hit_a_stop = false;
    for period in 0..150 {
        let command = command(period);
        meter.begin_period();
        let report =
            body.advance_metered(&mut metered, command, None, STEPS, &mut account, &mut meter);
        assert!(!report.diverged);
        body.advance(&mut plain, command, STEPS, &mut plain_account);
        assert_eq!(
            (metered, account),
            (plain, plain_account),
            "a meter changes nothing"
        );

        for leg in &mut brute {
            (leg.peak, leg.touching) = (0.0, 0);
        }
        let mut flight = 0;
        for _ in 0..STEPS {
            let force = command.map(|c| c * p.actuator_force_n);
            let a = body.accelerations(&single, force);
            let old = single;
            body.advance(&mut single, command, 1, &mut EnergyAccount::default());
            flight += u32::from(a.forces.iter().all(|f| f.contact.normal_n == 0.0));
            for i in [RIGHT, LEFT] {
                let b = &mut brute[i];
                let (o, n) = (&old.legs[i], &single.legs[i]);
                let contact = a.forces[i].contact;
                b.peak = b.peak.max(contact.normal_n);
                b.touching += u32::from(contact.normal_n > 0.0);
                // The semi-implicit step moves each coordinate by its new velocity; works take the mean of both.
                let way = 0.5 * (o.thigh_dot + n.thigh_dot) * dt;
                b.work += force[i] * way;
                b.positive += (force[i] * way).max(0.0);
                b.squared += force[i].powi(2) * dt;
                b.impulse += force[i].abs() * dt;
                if o.thigh.abs() > p.stroke_m && (force[i] > 0.0) == (o.thigh > 0.0) {
                    b.at_stop += force[i].abs() * dt;
                    hit_a_stop = true;
                }
                let springs = |s: &BodyState| {
                    let (d, w) = (s.legs[i].d(), s.legs[i].w());
                    half(p.k1_n_per_m, d) + half(p.k2_n_per_m, d - w) + half(p.k3_n_per_m, w)
                };
                let hip = |s: &BodyState| half(p.hip_stiffness_nm_per_rad, s.phi(i));
                let stop = |s: &BodyState| {
                    half(
                        p.stop_stiffness_n_per_m,
                        (s.legs[i].thigh.abs() - p.stroke_m).max(0.0),
                    )
                };
                b.spring_release += (springs(&old) - springs(&single)).max(0.0);
                b.hip_release += (hip(&old) - hip(&single)).max(0.0);
                b.stop_release += (stop(&old) - stop(&single)).max(0.0);
                let both = |k: f64, old: f64, new: f64| k * old * 0.5 * (old + new) * dt;
                let rates = |l: &gaitshift_body::LegState| l.d_dot() - l.w_dot();
                let of_step = [
                    both(p.hip_damping_nms_per_rad, old.phi_dot(i), single.phi_dot(i)),
                    both(p.c1_ns_per_m, o.d_dot(), n.d_dot()),
                    both(p.c2_ns_per_m, rates(o), rates(n)),
                    -(a.forces[i].stop_n - a.forces[i].stop_elastic_n) * way,
                    contact.normal_loss_w * dt,
                    contact.friction_loss_w * dt,
                ];
                for (sum, loss) in b.losses.iter_mut().zip(of_step) {
                    *sum += loss;
                }
            }
        }
        near(
            meter.flight_share,
            f64::from(flight) / f64::from(STEPS),
            "flight",
        );
        for (leg, b) in meter.legs.iter().zip(&brute) {
            near(leg.peak_normal_n, b.peak, "peak");
            near(
                leg.contact_share,
                f64::from(b.touching) / f64::from(STEPS),
                "contact",
            );
            assert!(
                leg.peak_normal_n >= report.normal_n[0].min(report.normal_n[1]),
                "a peak is no less than a mean"
            );
        }
    }
    assert!(hit_a_stop, "the motion tests nothing at the end stops");
    for (leg, b) in meter.legs.iter().zip(&brute) {
        for (value, expected, what) in [
            (leg.actuator_work, b.work, "work"),
            (leg.actuator_positive_work, b.positive, "positive work"),
            (leg.squared_force_n2_s, b.squared, "squared force"),
            (leg.impulse_n_s, b.impulse, "impulse"),
            (leg.impulse_at_stop_n_s, b.at_stop, "impulse at the stop"),
            (leg.leg_spring_release, b.spring_release, "leg springs"),
            (leg.hip_spring_release, b.hip_release, "hip spring"),
            (leg.stop_release, b.stop_release, "stop"),
            (leg.hip_damper, b.losses[0], "hip damper"),
            (leg.c1, b.losses[1], "c1"),
            (leg.c2, b.losses[2], "c2"),
            (leg.stops, b.losses[3], "stop loss"),
            (leg.contact_normal, b.losses[4], "normal contact"),
            (leg.friction, b.losses[5], "friction"),
        ] {
            near(value, expected, what);
        }
    }
    let both = |of: fn(&gaitshift_body::LegMeter) -> f64| meter.legs.iter().map(of).sum::<f64>();
    for (sum, total, what) in [
        (both(|l| l.actuator_work), account.work(), "work"),
        (
            both(|l| l.actuator_positive_work),
            account.positive_work(),
            "positive work",
        ),
        (both(|l| l.hip_damper), account.hip_dampers, "hip dampers"),
        (both(|l| l.c1), account.c1, "c1"),
        (both(|l| l.c2), account.c2, "c2"),
        (both(|l| l.stops), account.stops, "stops"),
        (
            both(|l| l.contact_normal),
            account.contact_normal,
            "contact",
        ),
        (both(|l| l.friction), account.friction, "friction"),
    ] {
        near(sum, total, what);
    }
}

#[test]
fn a_contact_gives_back_what_it_stored_less_what_it_loses() {
    // Dropped without friction or dampers in the way: over a bounce the contact's store begins and ends empty, so it releases
    // all that it stored; what it took from the motion beyond that is its loss.
    let body = Body::new(BodyParameters {
        foot_sphere_count: 1,
        ..BodyParameters::default()
    })
    .unwrap();
    let mut s = BodyState::standing(&body);
    s.z += 0.1;
    let (mut account, mut meter) = (EnergyAccount::default(), Meter::default());
    let (mut most, mut last) = ([0.0_f64; 2], [0.0; 2]);
    let mut rises = [0.0; 2];
    for _ in 0..3000 {
        body.advance_metered(&mut s, [0.0; 2], None, 1, &mut account, &mut meter);
        for i in [RIGHT, LEFT] {
            let stored = body.foot_contact(&s, i).elastic_j;
            rises[i] += (stored - last[i]).max(0.0);
            most[i] = most[i].max(stored);
            last[i] = stored;
        }
    }
    // One more step lets the meter, which looks at the state before each step, see the last.
    body.advance_metered(&mut s, [0.0; 2], None, 1, &mut account, &mut meter);
    for i in [RIGHT, LEFT] {
        assert!(most[i] > 0.5, "it never fell on the foot");
        let released = rises[i] - last[i];
        assert!((meter.legs[i].contact_release - released).abs() < 1e-9 * released);
    }
}

#[test]
fn a_foot_that_the_ground_only_pushes_sideways_touches_it() {
    // A foot in the air runs into the face of a step and slides up along it: the ground pushes it back, and down.
    let step = Terrain::through(&[(0.0, 0.0), (0.0, 1.0)], 0.0, 0.0).unwrap();
    let body = Body::new(BodyParameters::default()).unwrap().on(step);
    let flat = Body::new(BodyParameters::default()).unwrap();
    let mut s = BodyState::standing(&flat);
    s.z += 0.05;
    (s.x_dot, s.z_dot) = (1.0, 1.5);
    s.x = -0.3;
    let (mut meter, mut sideways, mut steps) = (Meter::default(), 0, 0);
    meter.begin_period();
    for _ in 0..1500 {
        let contacts = [RIGHT, LEFT].map(|leg| body.foot_contact(&s, leg));
        let flight = contacts
            .iter()
            .all(|c| c.normal_n == 0.0 && c.tangential_n == 0.0);
        sideways += u32::from(!flight && contacts.iter().all(|c| c.normal_n <= 0.0));
        steps += u32::from(flight);
        let mut account = EnergyAccount::default();
        body.advance_metered(&mut s, [0.0; 2], None, 1, &mut account, &mut meter);
    }
    assert!(sideways > 0, "it touches nothing but the ground below");
    near(meter.flight_share, f64::from(steps) / 1500.0, "flight");
}

#[test]
fn mirrored_motions_have_mirrored_meters() {
    let body = Body::new(BodyParameters::default()).unwrap();
    let (mut a, mut b) = (start(&body), start(&body).mirrored());
    let (mut right, mut left) = (Meter::default(), Meter::default());
    for period in 0..50 {
        let [r, l] = command(period);
        body.advance_metered(
            &mut a,
            [r, l],
            None,
            STEPS,
            &mut EnergyAccount::default(),
            &mut right,
        );
        body.advance_metered(
            &mut b,
            [l, r],
            None,
            STEPS,
            &mut EnergyAccount::default(),
            &mut left,
        );
    }
    left.legs.swap(RIGHT, LEFT);
    assert_eq!(right, left);
}
