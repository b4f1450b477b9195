//! Contract: a touchdown is the begin of a contact that lasts, after a foot was off the ground; a scuff is taken back once it is
//! over, and a short loss of contact changes nothing. That the rule is the one of recordings is tested where both are known.

use gaitshift_body::BodyParameters;
use gaitshift_task::Touchdowns;

/// Control periods of 10 ms.
const PERIOD: u64 = 50;
/// Forces on a foot that bears the body, that trails, and that is in the air, in N.
const BEARS: f64 = 200.0;
const TRAILS: f64 = 10.0;
const AIR: f64 = 0.0;

/// The stride, in control periods, as it is known after so many periods with a force each.
fn after(forces: &[(u64, f64)]) -> Option<(u64, u64)> {
    let body = BodyParameters::default();
    assert_eq!(
        (PERIOD as f64 * body.time_step_s, body.total_mass_kg()),
        (0.01, 40.0)
    );
    let mut touchdowns = Touchdowns::new(&body);
    let periods = forces
        .iter()
        .flat_map(|&(count, n)| (0..count).map(move |_| n));
    for (period, normal_n) in periods.enumerate() {
        touchdowns.see(normal_n, period as u64 * PERIOD);
    }
    let stride = touchdowns.stride();
    stride.map(|(last, lasted)| (last / PERIOD, lasted / PERIOD))
}

#[test]
fn a_stride_is_from_touchdown_to_touchdown() {
    let walk = [
        (30, BEARS),
        (20, AIR),
        (30, BEARS),
        (20, AIR),
        (30, BEARS),
        (20, AIR),
        (1, BEARS),
    ];
    // The contact that the motion begins with has no touchdown, and one touchdown is no stride.
    assert_eq!(after(&walk[..4]), None);
    assert_eq!(after(&walk[..5]), Some((100, 50)));
    assert_eq!(after(&walk[..6]), Some((100, 50)));
    assert_eq!(after(&walk), Some((150, 50)));
    // Trailing feet are down, and feet that come down touch the ground only with more force.
    let trailing = [
        (30, BEARS),
        (20, AIR),
        (30, TRAILS),
        (30, BEARS),
        (20, AIR),
        (30, BEARS),
        (3, TRAILS),
        (9, BEARS),
    ];
    assert_eq!(after(&trailing), Some((130, 50)));
}

#[test]
fn a_scuff_is_no_touchdown_and_a_short_gap_is_none() {
    let walk = [(30, BEARS), (20, AIR), (30, BEARS), (20, AIR), (30, BEARS)];
    let and = |more: &[(u64, f64)]| after(&[&walk, more].concat());
    // While a scuff lasts it may be a touchdown, and for 0.02 s after.
    assert_eq!(and(&[(10, AIR), (7, BEARS)]), Some((140, 40)));
    assert_eq!(and(&[(10, AIR), (7, BEARS), (2, AIR)]), Some((140, 40)));
    assert_eq!(and(&[(10, AIR), (7, BEARS), (3, AIR)]), None);
    assert_eq!(
        and(&[(10, AIR), (7, BEARS), (10, AIR), (1, BEARS)]),
        Some((157, 57))
    );
    // A contact of 0.08 s is one.
    assert_eq!(and(&[(10, AIR), (8, BEARS), (3, AIR)]), Some((140, 40)));
    // Two scuffs are none either, and what is interrupted for less than 0.02 s is one contact.
    assert_eq!(
        and(&[
            (10, AIR),
            (4, BEARS),
            (5, AIR),
            (4, BEARS),
            (5, AIR),
            (1, BEARS)
        ]),
        Some((158, 58))
    );
    assert_eq!(
        and(&[(10, AIR), (4, BEARS), (1, AIR), (4, BEARS), (5, AIR)]),
        Some((140, 40))
    );
    assert_eq!(and(&[(1, AIR), (9, BEARS)]), Some((100, 50)));
}
