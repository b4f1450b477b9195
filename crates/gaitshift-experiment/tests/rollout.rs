//! Contract: a rollout records every control period of the environment it moves, command by command, to the bit; it ends
//! with its duration or with the fall and says which; the task's time limit does not end it; a motion that diverges
//! ends with its last finite state. Its details are those of the same motion taken one integration step at a time. What disturbs it comes when it should, and the header says so;
//! in an environment, which cannot look ahead, a push at a phase of the stride comes as near to it as strides are alike.

use crate::common::moved;
use gaitshift_analysis::recording::{Column, Recording, Side, column, detail};
use gaitshift_analysis::support::{ContactRule, FootEventKind, Support};
use gaitshift_body::{Body, BodyParameters, BodyState, EnergyAccount};
use gaitshift_experiment::{CommandProfile, Control, Controller, Deterministic, Rollout};
use gaitshift_task::{
    ACTION_SIZE, Disturbance, Environment, OBSERVATION_SIZE, Opening, Push, TaskParameters,
    TerrainParameters, Touchdowns, VectorEnvironment, scale_observation,
};

type Observation = [f32; OBSERVATION_SIZE];
type Action = [f32; ACTION_SIZE];

/// Pushes both legs alike, by what it sees of the pitch.
fn push(observation: &Observation, action: &mut Action) {
    *action = [0.4 - 0.1 * observation[1], 0.3];
}

fn body() -> Body {
    Body::new(BodyParameters::default()).unwrap()
}

fn rollout<'a>(
    body: &'a Body,
    task: &'a TaskParameters,
    profile: &'a CommandProfile,
    duration_s: f64,
) -> Rollout<'a> {
    Rollout {
        body,
        task,
        start: Environment::start(body, task, Some(3)),
        profile,
        duration_s,
        seed: 3,
        disturbance: None,
        controller: "push",
    }
}

/// The shipped controller on what a disturbance makes of the default body.
fn disturbed(disturbance: &Disturbance, omega_v: f64, duration_s: f64) -> Recording {
    let mut controller = Controller::shipped().unwrap();
    moved(&mut controller, disturbance, Some(5), omega_v, duration_s)
}

#[test]
fn a_disturbance_that_is_none_changes_nothing() {
    let none = disturbed(&Disturbance::default(), 1.0, 2.0);
    assert!(none.metadata.disturbance.is_none() && none.metadata.ground.is_none());
    let none_but_a_start = Disturbance {
        pushes: vec![Push::default()],
        ..Disturbance::default()
    };
    let pushed_by_nothing = disturbed(&none_but_a_start, 1.0, 2.0);
    assert_eq!(
        none.column(column::X_M),
        pushed_by_nothing.column(column::X_M)
    );
}

/// When the right foot comes down, from a time on, in s.
fn right_landings(recording: &Recording, from_s: f64) -> Vec<f64> {
    let support = Support::find(recording, &ContactRule::default());
    let landings = support.events().iter().filter(|e| {
        e.side == Side::Right && e.kind == FootEventKind::Touchdown && e.time_s >= from_s
    });
    landings.map(|e| e.time_s).collect()
}

#[test]
fn a_push_at_a_phase_of_the_stride_comes_then_and_the_header_says_when() {
    let quiet = disturbed(&Disturbance::default(), 3.0, 6.0);
    let landings = right_landings(&quiet, 4.0);
    let expected_s = landings[0] + 0.25 * (landings[1] - landings[0]);
    let pushed = disturbed(
        &Disturbance {
            pushes: vec![Push {
                forward_n: 60.0,
                start_s: 4.0,
                phase: Some(0.25),
                ..Push::default()
            }],
            ..Disturbance::default()
        },
        3.0,
        6.0,
    );
    let noted = pushed.metadata.disturbance.as_ref().unwrap();
    let push = &noted["pushes"][0];
    assert_eq!(push["start_s"], expected_s);
    assert!(push.get("phase").is_none(), "{push}");
    // Both motions are one until then, and two from then on.
    let (x, other) = (quiet.column(column::X_M), pushed.column(column::X_M));
    let first = x.iter().zip(other).position(|(a, b)| a != b).unwrap();
    let time_s = quiet.column(column::TIME_S)[first];
    assert!(
        (expected_s..expected_s + 0.011).contains(&time_s),
        "{time_s}"
    );
}

/// Where the hip is after each control period in a disturbed environment that the shipped controller moves, and is saved and
/// restored in each of them.
fn moved_in_an_environment(disturbance: &Disturbance, omega_v: f64, periods: usize) -> Vec<f64> {
    let mut controller = Controller::shipped().unwrap();
    let body = Body::new(controller.body.clone()).unwrap();
    let mut environment = VectorEnvironment::new(body, controller.task.clone(), [omega_v; 2], 1)
        .disturbed(disturbance.clone())
        .unwrap();
    environment.seed(0, 5);
    let mut observation = environment.reset(0, Opening::default()).observation;
    let mut policy = Deterministic(&mut controller.policy);
    let (mut scaled, mut action) = ([0.0; OBSERVATION_SIZE], [0.0; ACTION_SIZE]);
    let period = |_| {
        scale_observation(&observation, &mut scaled);
        policy.act(&scaled, &mut action);
        observation = environment.step(0, action.map(f64::from)).observation;
        let saved = serde_json::to_string(&environment.state()).unwrap();
        assert!(environment.restore(serde_json::from_str(&saved).unwrap()));
        environment.environment(0).state.x
    };
    (0..periods).map(period).collect()
}

#[test]
fn an_environment_pushes_at_a_phase_of_the_stride_that_it_expects() {
    for (omega_v, phase) in [
        (0.0, 0.0),
        (0.0, 0.6),
        (1.0, 0.25),
        (2.0, 0.9),
        (3.0, 0.0),
        (3.0, 0.5),
    ] {
        let quiet = disturbed(&Disturbance::default(), omega_v, 13.0);
        let landings = right_landings(&quiet, 9.0);
        let stride_s = landings[1] - landings[0];
        let disturbance = Disturbance {
            pushes: vec![Push {
                forward_n: 60.0,
                start_s: 9.0,
                phase: Some(phase),
                ..Push::default()
            }],
            ..Disturbance::default()
        };
        let x_m = &quiet.column(column::X_M)[1..];
        let moved = moved_in_an_environment(&disturbance, omega_v, x_m.len());
        // Both motions are one until then, and two from then on.
        let first = x_m.iter().zip(&moved).position(|(a, b)| a != b).unwrap();
        let time_s = quiet.column(column::TIME_S)[first];
        // At 0 strides differ by some percent. A touchdown is seen at the end of its control period.
        let off_s = time_s - landings[0] - phase * stride_s;
        let most_s = 0.03 * phase * stride_s + 0.0101;
        assert!(off_s.abs() < most_s, "{omega_v}, {phase}: {off_s} s");
        let further_m = moved[first + 10] - x_m[first + 10];
        assert!(further_m > 0.002, "{omega_v}, {phase}: {further_m} m");
    }
}

#[test]
fn touchdowns_found_on_the_way_are_those_of_the_analysis() {
    for half in 0..8 {
        let recording = disturbed(&Disturbance::default(), 0.5 * f64::from(half), 8.0);
        let body = BodyParameters::default();
        let period = (recording.metadata.control_period_s / body.time_step_s).round() as u64;
        let mut touchdowns = Touchdowns::new(&body);
        let mut found = Vec::new();
        let forces = recording.column(column::NORMAL_FORCE_N[Side::Right.index()]);
        for (k, normal_n) in forces[1..].iter().enumerate() {
            touchdowns.see(*normal_n, k as u64 * period);
            if let Some((last, lasted)) = touchdowns.stride() {
                found.push((last - lasted) / period);
            }
        }
        found.dedup();
        let landings = right_landings(&recording, 0.0);
        let periods = landings
            .iter()
            .map(|s| (s / recording.metadata.control_period_s).round() as u64);
        let periods: Vec<u64> = periods.collect();
        assert!(found.len() >= 3, "{found:?}");
        assert_eq!(
            found,
            periods[..found.len()],
            "ω_v {}",
            0.5 * f64::from(half)
        );
        assert!(periods.len() <= found.len() + 1, "{periods:?}");
    }
}

// The first that was given was timed first, and the stride of the other then had another length than when given in the order of
// time.
#[test]
fn the_order_in_which_pushes_of_one_stride_are_given_changes_nothing() {
    let push = |phase: f64| Push {
        forward_n: 100.0,
        start_s: 3.0,
        phase: Some(phase),
        ..Push::default()
    };
    let motion = |phases: [f64; 2]| {
        let pushes = phases.map(push).to_vec();
        let disturbance = Disturbance {
            pushes,
            ..Disturbance::default()
        };
        disturbed(&disturbance, 3.0, 5.0)
    };
    let (one, other) = (motion([0.1, 0.9]), motion([0.9, 0.1]));
    assert_eq!(one.metadata.disturbance, other.metadata.disturbance);
    assert_eq!(one.column(column::X_M), other.column(column::X_M));
    let noted = one.metadata.disturbance.as_ref().unwrap();
    assert_eq!(noted["pushes"].as_array().unwrap().len(), 2);
}

#[test]
fn the_header_holds_the_ground_and_a_fall_counts_from_it() {
    // A walk up a slope ends higher than any hip on the flat, and down one lower than the limit there, without a fall.
    for slope_rad in [0.03, -0.03] {
        let terrain = TerrainParameters {
            slope_rad,
            slope_from_m: Some(1.0),
            ..TerrainParameters::default()
        };
        let disturbance = Disturbance {
            terrain,
            ..Disturbance::default()
        };
        let recording = disturbed(&disturbance, 3.0, 6.0);
        assert!(!recording.metadata.fell);
        let ground = recording.metadata.ground.as_ref().unwrap();
        assert_eq!(ground[1], [1.0, 0.0]);
        let last = |column: Column| *recording.column(column).last().unwrap();
        let rise = (last(column::X_M) - 1.0) * slope_rad.tan();
        assert!((last(column::Z_M) - rise - 0.76).abs() < 0.1, "{rise}");
        assert!(rise.abs() > 0.3);
    }
}

#[test]
fn it_is_the_environment_to_the_bit() {
    let (body, task) = (body(), TaskParameters::default());
    let profile = CommandProfile::ramp(0.5, 2.0, 0.05, 0.1);
    let recording = rollout(&body, &task, &profile, 0.2)
        .record(&mut push)
        .unwrap();
    assert_eq!(recording.len(), 1 + 20);
    let values = |name: Column| recording.column(name);
    let mut alone = Environment::new(&body, Environment::start(&body, &task, Some(3)), 0.5);
    for row in 1..recording.len() {
        // The command of a period is the one at its beginning.
        alone.omega_v = profile.at((row - 1) as f64 * task.control_period_s);
        let mut scaled = [0.0; OBSERVATION_SIZE];
        gaitshift_task::scale_observation(&alone.observation(), &mut scaled);
        let mut action = [0.0; ACTION_SIZE];
        push(&scaled, &mut action);
        let outcome = alone.step(&body, &task, &task.reward, action.map(f64::from));
        assert_eq!(values(column::OMEGA_V)[row], alone.omega_v);
        assert_eq!(values(column::X_M)[row], alone.state.x);
        assert_eq!(values(column::Z_M)[row], alone.state.z);
        assert_eq!(values(column::REWARD)[row], outcome.terms.sum());
        assert_eq!(
            values(column::ACTUATOR_POSITIVE_WORK_J)[row],
            alone.account.positive_work()
        );
    }
    let m = &recording.metadata;
    assert_eq!((m.seed, m.controller.as_str()), (3, "push"));
    assert_eq!(m.total_mass_kg, 40.0);
}

#[test]
fn a_fall_ends_it_and_the_time_limit_does_not() {
    let (body, mut task) = (body(), TaskParameters::default());
    task.termination.time_limit_s = 0.05;
    let profile = CommandProfile::constant(0.0);
    let limp = &mut |_: &Observation, action: &mut Action| *action = [-1.0, -1.0];
    let recording = rollout(&body, &task, &profile, 10.0).record(limp).unwrap();
    let m = &recording.metadata;
    assert!(m.fell && m.ended_by == "hip height", "{}", m.ended_by);
    assert!(recording.duration_s() > 0.05 && recording.duration_s() < 5.0);

    let short = rollout(&body, &task, &profile, 0.1)
        .record(&mut push)
        .unwrap();
    assert!(!short.metadata.fell && short.metadata.ended_by == "time limit");
    assert!((short.duration_s() - 0.1).abs() < 1e-9);
}

#[test]
fn a_motion_that_diverges_ends_with_its_last_finite_state() {
    let body = Body::new(BodyParameters {
        diverged_speed: 1e-6,
        ..BodyParameters::default()
    })
    .unwrap();
    let task = TaskParameters::default();
    let profile = CommandProfile::constant(0.0);
    let recording = rollout(&body, &task, &profile, 1.0)
        .record(&mut push)
        .unwrap();
    assert_eq!(recording.len(), 1);
    let m = &recording.metadata;
    assert!(m.fell && m.ended_by == "diverged", "{}", m.ended_by);
}

#[test]
fn details_are_those_of_the_motion_taken_step_by_step() {
    // From the state of each row on, the body goes through the next period in 50 steps by itself; recorded angles are relative,
    // so states agree to rounding only.
    let recording = disturbed(&Disturbance::default(), 3.0, 3.0);
    let body = Body::new(Controller::shipped().unwrap().body).unwrap();
    let at = |column: Column, row: usize| recording.column(column)[row];
    let both = |pair: [Column; 2], row: usize| pair.map(|column| at(column, row));
    let state = |row: usize| {
        let [phi, h, d, w] = [column::PHI_RAD, column::H_M, column::D_M, column::W_M];
        let leg = |i: usize| [phi, h, d, w].map(|pair| both(pair, row)[i]);
        let rate = |i: usize| {
            [
                column::PHI_VELOCITY_RAD_PER_S,
                column::H_VELOCITY_M_PER_S,
                column::D_VELOCITY_M_PER_S,
                column::W_VELOCITY_M_PER_S,
            ]
            .map(|pair| both(pair, row)[i])
        };
        let join = |first: [f64; 3], right: [f64; 4], left: [f64; 4]| -> [f64; 11] {
            let all: Vec<f64> = first.into_iter().chain(right).chain(left).collect();
            all.try_into().unwrap()
        };
        let place = [column::X_M, column::Z_M, column::THETA_RAD].map(|c| at(c, row));
        let velocity = [
            column::X_VELOCITY_M_PER_S,
            column::Z_VELOCITY_M_PER_S,
            column::THETA_VELOCITY_RAD_PER_S,
        ]
        .map(|c| at(c, row));
        BodyState::from_coordinates(
            &join(place, leg(0), leg(1)),
            &join(velocity, rate(0), rate(1)),
        )
    };
    let force = body.parameters().actuator_force_n;
    let mut greatest_hidden = 0.0_f64;
    for row in 100..recording.len() - 1 {
        let mut s = state(row);
        let command = both(column::COMMAND, row + 1);
        let (mut peak, mut touching, mut flight) = ([0.0_f64; 2], [0.0; 2], 0.0);
        let mut friction = [0.0; 2];
        for _ in 0..50 {
            let forces = body.accelerations(&s, command.map(|c| c * force)).forces;
            for i in 0..2 {
                peak[i] = peak[i].max(forces[i].contact.normal_n);
                touching[i] += f64::from(u8::from(forces[i].contact.normal_n > 0.0)) / 50.0;
                friction[i] += forces[i].contact.friction_loss_w * body.parameters().time_step_s;
            }
            flight += f64::from(u8::from(forces.iter().all(|f| f.contact.normal_n <= 0.0))) / 50.0;
            body.advance(&mut s, command, 1, &mut EnergyAccount::default());
        }
        let told = |d: gaitshift_analysis::recording::Detail, row: usize| {
            recording.detail(d).expect("details")[row]
        };
        for i in 0..2 {
            let recorded = told(detail::PEAK_NORMAL_FORCE_N[i], row + 1);
            assert!(
                (recorded - peak[i]).abs() < 1e-4 * peak[i].max(1.0),
                "{recorded} {}",
                peak[i]
            );
            let mean = both(column::NORMAL_FORCE_N, row + 1)[i];
            greatest_hidden = greatest_hidden.max(recorded - mean);
            let [before, after] =
                [row, row + 1].map(|row| told(detail::FRICTION_DISSIPATION_J[i], row));
            assert!((after - before - friction[i]).abs() < 1e-6 * friction[i].max(1.0));
            // A force of a few millionths of a newton may begin a step earlier or later.
            assert!((told(detail::CONTACT_SHARE[i], row + 1) - touching[i]).abs() < 0.021);
        }
        assert!((told(detail::FLIGHT_SHARE, row + 1) - flight).abs() < 0.021);
        let centre = body.centre_of_mass(&state(row));
        assert!((told(detail::COM_X_M, row) - centre.x).abs() < 1e-12);
        assert!((told(detail::COM_Z_VELOCITY_M_PER_S, row) - centre.z_dot).abs() < 1e-12);
    }
    // The impact that means over the period hide: more than a body weight.
    assert!(greatest_hidden > 400.0, "{greatest_hidden} N");
}
